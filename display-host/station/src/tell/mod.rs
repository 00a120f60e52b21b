//! `calot tell`: writes reports about a station as frames to standard output. The program
//! `calot-centre` starts it and sends the frames over the network. `calot tell` opens no port.
//!
//! Each line of standard input is a JSON object: `{"tile_hz": 2, "view_hz": 30}` asks for pictures,
//! `{"id": 1, "remark": "…"}` asks the station for an act. The program ends when its input ends.

mod frame;
mod picture;
mod state;

use std::io::BufRead as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use bytemuck::Zeroable as _;
use clap::Args;
use display_host::ui::Bulletin;
use serde_json::json;
use shared_mem::message::{ActMsg, ActReply, REMARK_BYTES, StateFrame, ToolFrame};
use shared_mem::service::{ACT_PATIENCE, ActSender, Host, Station, TaskReceiver};
use shared_mem::task::TaskMsg;

use self::frame::Frames;
use self::picture::{Moment, Rates};
use self::state::Teller;
use crate::args::parse_station;
use crate::folder::running_scene;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// Interval between two looks at the station.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Longest time between two reports of the state. A change for which an instructor waits is
/// reported at once.
const TELL_EVERY: Duration = Duration::from_millis(500);
/// Interval between two searches for resources that dead processes left behind.
const TIDY_EVERY: Duration = Duration::from_secs(5);
/// Events that wait for the next picture, at most.
const EVENTS_MAX: usize = 4096;

#[derive(Debug, Clone, Args)]
pub(crate) struct TellArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    station: String,
    /// Name that the trainee chose
    #[arg(long, value_name = "NAME")]
    trainee: Option<String>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID", hide = true)]
    with_parent: Option<i32>,
}

/// A line of standard input.
#[derive(Debug, serde::Deserialize)]
#[serde(untagged)]
enum Asked {
    Act { id: u64, remark: String },
    Pictures(Rates),
}

type Out = Frames<std::io::Stdout>;

pub(crate) fn run(args: &TellArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    display_host::priority::step_aside(None);
    let station = Station::new(&args.station)?;
    let out = Arc::new(Frames::new(std::io::stdout()));
    let moment = Arc::<Mutex<Moment>>::default();
    let (ask, acts) = mpsc::channel();
    listen(moment.clone(), ask, stop.clone());
    act(station.clone(), acts, out.clone());
    let Some(scene) = scene(args, &stop)? else {
        return Ok(ExitCode::SUCCESS);
    };
    paint(scene, moment.clone(), out.clone(), stop.clone());
    tell(args, &station, &moment, &out, &stop)?;
    Ok(ExitCode::SUCCESS)
}

/// Waits until the station names its scene. `None`: stopped before.
fn scene(args: &TellArgs, stop: &AtomicBool) -> Result<Option<PathBuf>, Problem> {
    while !stop.load(Relaxed) {
        if let Some(scene) = running_scene(&args.station)? {
            return Ok(Some(scene));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(None)
}

/// Takes requests from standard input, in a thread of its own.
fn listen(moment: Arc<Mutex<Moment>>, ask: Sender<(u64, String)>, stop: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            match serde_json::from_str(&line) {
                Ok(Asked::Pictures(rates)) => {
                    moment.lock().unwrap_or_else(PoisonError::into_inner).rates = rates;
                }
                Ok(Asked::Act { id, remark }) => {
                    let _ = ask.send((id, remark));
                }
                Err(problem) => say::note(format_args!("calot tell: a request: {problem}")),
            }
        }
        stop.store(true, Relaxed);
    });
}

/// Asks the station for acts, in a thread of its own, because an answer may take a second.
fn act(station: Station, acts: Receiver<(u64, String)>, out: Arc<Out>) {
    std::thread::spawn(move || {
        for (id, remark) in acts {
            let outcome = match ActMsg::remark(&remark) {
                None => format!("a remark has 1 to {REMARK_BYTES} bytes"),
                Some(act) => match ActSender::open(&station) {
                    Ok(sender) => outcome(sender.ask(act, ACT_PATIENCE)),
                    Err(problem) => problem.to_string(),
                },
            };
            let answer = json!({"id": id, "outcome": outcome}).to_string();
            if out.write(frame::ANSWER, answer.as_bytes()).is_err() {
                return;
            }
        }
    });
}

/// Name of an outcome: `done`, or why not.
fn outcome(told: Result<u32, shared_mem::service::ServiceError>) -> String {
    match told {
        Ok(ActReply::DONE) => "done".to_owned(),
        Ok(ActReply::UNRECORDED) => "nothing is recorded there, so no remark would last".to_owned(),
        Ok(ActReply::FULL) => "the session holds no more remarks".to_owned(),
        Ok(_) => "the station does not take it".to_owned(),
        Err(problem) => problem.to_string(),
    }
}

/// Draws in a thread of its own, because a picture may take longer than an alarm may wait.
fn paint(scene: PathBuf, moment: Arc<Mutex<Moment>>, out: Arc<Out>, stop: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        let mut send = |is_large: bool, picture: &[u8]| {
            let kind = if is_large { frame::VIEW } else { frame::TILE };
            if out.write(kind, picture).is_err() {
                stop.store(true, Relaxed);
            }
        };
        let drawn = picture::draw(&scene, &moment, &|| stop.load(Relaxed), &mut send);
        if let Err(problem) = drawn {
            say::note(format_args!(
                "calot tell: the centre gets no pictures: {problem}"
            ));
        }
    });
}

fn tell(
    args: &TellArgs,
    station: &Station,
    moment: &Mutex<Moment>,
    out: &Out,
    stop: &AtomicBool,
) -> Result<(), Problem> {
    let host = Host::open(station)?;
    let tasks = TaskReceiver::open(station)?;
    let began = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let operation = u64::try_from(began.as_millis()).unwrap_or(0);
    let mut teller = Teller::new(operation, args.trainee.clone());
    let mut state = Box::new(StateFrame::zeroed());
    let mut tools = ToolFrame::zeroed();
    let mut task: Box<TaskMsg> = bytemuck::allocation::zeroed_box();
    let (mut told, mut tidied) = (None, Instant::now());
    while !stop.load(Relaxed) {
        let is_new = host.newest_state(&mut state);
        if is_new {
            teller.hear();
        }
        if host.newest_tools(&mut tools) {
            teller.tools(&tools);
        }
        host.drain_timing(|batch| teller.timing(batch));
        if tasks.newest(&mut task)
            && let Some(bulletin) = task.text().and_then(Bulletin::parse)
        {
            teller.task(&bulletin);
        }
        {
            let mut moment = moment.lock().unwrap_or_else(PoisonError::into_inner);
            host.drain_events(|event| moment.events.push(*event));
            let spare = moment.events.len().saturating_sub(EVENTS_MAX);
            moment.events.drain(..spare);
            if is_new {
                moment.newest = Some((state.clone(), tools));
            }
        }
        let news = teller.news();
        let is_due =
            |(last, at): &(state::News, Instant)| *last != news || at.elapsed() >= TELL_EVERY;
        if told.as_ref().is_none_or(is_due) {
            out.write(frame::STATE, &teller.json())?;
            told = Some((news, Instant::now()));
        }
        if tidied.elapsed() > TIDY_EVERY {
            host.forget_dead();
            tidied = Instant::now();
        }
        std::thread::sleep(LOOK_EVERY);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_told_apart() {
        let parse = |line: &str| serde_json::from_str::<Asked>(line);
        let pictures = parse(r#"{"tile_hz": 2}"#).unwrap();
        assert!(matches!(pictures, Asked::Pictures(rates) if rates.tile_hz > 1.9));
        let act = parse(r#"{"id": 3, "remark": "Well done"}"#).unwrap();
        assert!(matches!(act, Asked::Act { id: 3, .. }));
        assert!(parse("nonsense").is_err());
    }

    #[test]
    fn outcomes_are_words() {
        assert_eq!(outcome(Ok(ActReply::DONE)), "done");
        assert!(outcome(Ok(ActReply::UNRECORDED)).contains("nothing is recorded"));
        assert!(outcome(Ok(ActReply::FULL)).contains("no more"));
        assert!(outcome(Ok(ActReply::SILENT)).contains("does not take it"));
    }
}
