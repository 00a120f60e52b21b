//! The instructor's side: asks a station for its newest data and publishes them to the displays of
//! this computer.

use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use shared_mem::message::ReplyMsg;
use shared_mem::scene::SceneFile;
use shared_mem::service::{Controller, Station, TaskSender};
use shared_mem::task::TaskMsg;

use crate::address::Address;
use crate::error::LinkError;
use crate::inbox::{Fresh, Inbox};
use crate::line::{self, Line};
use crate::monotonic_ns;
use crate::pace::Pace;
use crate::parts::Parts;
use crate::reason::reason;
use crate::wire::{self, Answer, MAGIC, SceneAsk};

/// The line is reopened when not even part of an answer arrives for this long.
const GONE: Duration = Duration::from_secs(8);
/// Delay between two attempts to open the line.
const AGAIN: Duration = Duration::from_secs(1);
/// Delay before a missing scene is asked for again.
const SCENE_AGAIN: Duration = Duration::from_secs(2);
/// Longest interval between two questions. It replaces the interval of a rate that is lower or
/// invalid.
const SLOWEST: Duration = Duration::from_secs(1);
/// Interval at which commands are read while there is no line.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Settings of a watcher.
#[derive(Debug, Clone)]
pub struct WatchConfig {
    /// Name under which displays of this computer see the station.
    pub station: Station,
    /// Address of the station's `serve`.
    pub address: Address,
    /// Largest number of pictures per second.
    pub rate_hz: f64,
    /// Path at which the compiled scene is written.
    pub scene: PathBuf,
    /// Running time, s; `None`: until stopped.
    pub seconds: Option<f64>,
}

/// Something that happened while watching.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen<'a> {
    /// The station answers.
    Connected,
    /// The station does not answer, for this reason. The watcher tries again.
    Lost(&'a str),
    /// The scene has arrived at this path.
    Scene(&'a Path),
    /// The station's `serve` cannot find the scene that its controller runs.
    NoScene,
}

/// Counts of a watched station.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Watched {
    /// States published to displays.
    pub states: u64,
    /// Events published to displays.
    pub events: u64,
    /// Events that the station had dropped before the watcher asked for them.
    pub events_lost: u64,
    /// Rejected answers: garbled, or of another version.
    pub malformed: u64,
    /// Connections made.
    pub connections: u64,
}

/// Watches until `stop` is set or the time is over. Waits for a station that does not answer.
///
/// # Errors
/// When this computer's shared memory cannot be used, the name is taken, or the scene cannot be
/// written. Failures of the other side are no errors; `observe` receives them.
pub fn watch(
    config: &WatchConfig,
    stop: &AtomicBool,
    mut observe: impl FnMut(Seen<'_>),
) -> Result<Watched, LinkError> {
    let mut show = Show {
        controller: Controller::open(&config.station)?,
        tasks: TaskSender::open(&config.station)?,
        inbox: Inbox::default(),
        scene_id: None,
        coming: None,
        watched: Watched::default(),
        tick: 0,
    };
    let start = Instant::now();
    let is_over = || {
        let seconds = config.seconds;
        stop.load(Relaxed) || seconds.is_some_and(|s| start.elapsed().as_secs_f64() >= s)
    };
    let mut said = String::new();
    while !is_over() {
        let before = show.watched.connections;
        let why = match line::connect(&config.address, wire::ANSWER_MAX, &is_over) {
            Ok(line) => show.follow(config, line, &is_over, &mut observe)?,
            Err(error) => reason(&error),
        };
        if show.watched.connections > before {
            // Report the next loss even if its reason is the same.
            said.clear();
        }
        if !is_over() && why != said {
            observe(Seen::Lost(&why));
            said = why;
        }
        let tried = Instant::now();
        while !is_over() && tried.elapsed() < AGAIN {
            show.refuse_commands();
            std::thread::sleep(LOOK_EVERY);
        }
    }
    show.watched.events_lost = show.inbox.events_lost;
    Ok(show.watched)
}

struct Show {
    controller: Controller,
    tasks: TaskSender,
    inbox: Inbox,
    /// Identity of the scene that is ready for displays.
    scene_id: Option<[u8; 16]>,
    /// The incoming scene. If the line breaks, the next connection asks for the missing rest.
    coming: Option<Coming>,
    watched: Watched,
    /// Newest tick that was published.
    tick: u64,
}

/// A scene that arrives in parts.
struct Coming {
    id: [u8; 16],
    bytes: Vec<u8>,
    parts: Parts,
    /// Time of the last question for a part.
    asked: Instant,
}

impl Show {
    /// Follows the station while it answers; returns the reason for the end.
    fn follow(
        &mut self,
        config: &WatchConfig,
        mut line: Line,
        is_over: &dyn Fn() -> bool,
        observe: &mut dyn FnMut(Seen<'_>),
    ) -> Result<String, LinkError> {
        let period = Duration::try_from_secs_f64(1.0 / config.rate_hz);
        let period = period.map_or(SLOWEST, |it| it.min(SLOWEST));
        let mut pace = Pace::new(period);
        let mut part_asked = false;
        let mut no_scene: Option<Instant> = None;
        let mut connected = false;
        let mut due = Instant::now();
        while !is_over() {
            if due <= Instant::now() && pace.may_ask() {
                // Questions that fell due meanwhile are left out.
                due = (due + period).max(Instant::now());
                pace.asked(monotonic_ns());
                if let Err(error) = line.send(wire::LOOK, bytemuck::bytes_of(&self.inbox.ask())) {
                    return Ok(reason(&error));
                }
            }
            self.refuse_commands();
            let (kind, message) = match line.receive() {
                Ok(Some(came)) => came,
                Ok(None) if line.heard().elapsed() < GONE => continue,
                Ok(None) => return Ok("the station does not answer".to_owned()),
                Err(error) => return Ok(reason(&error)),
            };
            let next = match kind {
                wire::SCENE if core::mem::take(&mut part_asked) => {
                    match self.take_part(config, &message, observe)? {
                        Ok(next) => next,
                        Err(error) => return Ok(error.to_string()),
                    }
                }
                wire::LOOK => {
                    let (Some(asked_ns), answer) =
                        (pace.answered(monotonic_ns()), Answer::read(&message))
                    else {
                        return Ok("the station sent an answer without a question".to_owned());
                    };
                    let answer = match answer {
                        Ok(answer) => answer,
                        Err(error) => {
                            self.watched.malformed += 1;
                            return Ok(error.to_string());
                        }
                    };
                    if !core::mem::replace(&mut connected, true) {
                        self.watched.connections += 1;
                        observe(Seen::Connected);
                    }
                    let fresh = self.inbox.take(answer, asked_ns, monotonic_ns());
                    let scene_id = fresh.state.as_ref().map(|it| it.scene_id);
                    self.show(fresh);
                    let is_due = no_scene.is_none_or(|at| at.elapsed() > SCENE_AGAIN);
                    match scene_id {
                        Some(id) if self.scene_id != Some(id) && !part_asked && is_due => {
                            no_scene = Some(Instant::now());
                            Some(self.ask_for(id))
                        }
                        _ => None,
                    }
                }
                _ => return Ok("the station sent an answer of the wrong kind".to_owned()),
            };
            if let Some(ask) = next {
                part_asked = true;
                if let Err(error) = line.send(wire::SCENE, bytemuck::bytes_of(&ask)) {
                    return Ok(error.to_string());
                }
            }
        }
        Ok(String::new())
    }

    /// The request for the rest of this scene.
    fn ask_for(&mut self, id: [u8; 16]) -> SceneAsk {
        let known = self.coming.take().filter(|it| it.id == id);
        self.coming
            .insert(known.unwrap_or_else(|| Coming::new(id)))
            .ask()
    }

    /// Takes a part of the scene. Returns the next request, if any. The inner error is a fault of
    /// the part; the outer error is a failure to write the scene.
    fn take_part(
        &mut self,
        config: &WatchConfig,
        message: &[u8],
        observe: &mut dyn FnMut(Seen<'_>),
    ) -> Result<Result<Option<SceneAsk>, LinkError>, LinkError> {
        let Some(mut scene) = self.coming.take() else {
            return Ok(Ok(None));
        };
        match scene.take(message) {
            Ok(Part::Next) => return Ok(Ok(Some(self.coming.insert(scene).ask()))),
            Ok(Part::None) => observe(Seen::NoScene),
            Ok(Part::Whole(whole)) => {
                write(&config.scene, whole.bytes())?;
                self.scene_id = Some(whole.short_id());
                observe(Seen::Scene(&config.scene));
            }
            Err(error) => return Ok(Err(error)),
        }
        Ok(Ok(None))
    }

    /// Publishes new data to displays. Ignores a failed send: nothing here could mend it.
    fn show(&mut self, fresh: Fresh) {
        if let Some(state) = fresh.state {
            self.watched.states += 1;
            // A lower tick means that the run started again: the old progress of the task is void.
            if state.tick < self.tick
                && let Some(nothing) = TaskMsg::new(monotonic_ns(), "")
            {
                self.tasks.send(&nothing);
            }
            self.tick = state.tick;
            let _ = self.controller.state.send_copy(*state);
        }
        if let Some(tools) = fresh.tools {
            let _ = self.controller.tools.send_copy(*tools);
        }
        if let Some(task) = fresh.task {
            self.tasks.send(&task);
        }
        for event in fresh.events {
            self.watched.events += 1;
            let _ = self.controller.events.send_copy(event);
        }
        self.controller.greet();
        for batch in fresh.batches {
            let _ = self.controller.timing.send_copy(batch);
        }
    }

    /// Refuses commands: a watcher cannot command the station.
    fn refuse_commands(&self) {
        while let Some(request) = self.controller.next_request() {
            request.reply(ReplyMsg {
                outcome: ReplyMsg::UNKNOWN,
                reserved: 0,
                tick: self.tick,
            });
        }
    }
}

/// Result of taking a part.
enum Part {
    /// More is to come.
    Next,
    /// The scene is complete and has the requested identity.
    Whole(Box<SceneFile>),
    /// The station cannot find the scene.
    None,
}

impl Coming {
    fn new(id: [u8; 16]) -> Self {
        Self {
            id,
            bytes: Vec::new(),
            parts: Parts::new(),
            asked: Instant::now(),
        }
    }

    /// The request for the next part.
    fn ask(&mut self) -> SceneAsk {
        self.asked = Instant::now();
        SceneAsk {
            magic: MAGIC,
            scene_id: self.id,
            offset: self.bytes.len() as u64,
            part_bytes: u32::try_from(self.parts.bytes()).unwrap_or(u32::MAX),
            reserved: 0,
        }
    }

    /// Appends a part. The part must start where the last one ended and lie within the scene, so
    /// the buffer never exceeds the largest scene.
    fn take(&mut self, message: &[u8]) -> Result<Part, LinkError> {
        let (total, offset, part) = wire::scene_part(message)?;
        if total == 0 {
            return Ok(Part::None);
        }
        if offset != self.bytes.len() as u64 || part.is_empty() {
            return Err(LinkError::Malformed {
                what: "a part of a scene that does not follow the last one",
            });
        }
        self.parts.took(self.asked.elapsed());
        self.bytes.extend_from_slice(part);
        if (self.bytes.len() as u64) < total {
            return Ok(Part::Next);
        }
        let scene = SceneFile::from_bytes(&self.bytes)?;
        match scene.short_id() == self.id {
            true => Ok(Part::Whole(Box::new(scene))),
            false => Err(LinkError::Malformed {
                what: "another scene than the one that was asked for",
            }),
        }
    }
}

/// Replaces the scene file atomically, because a display may have the old one mapped.
fn write(path: &Path, bytes: &[u8]) -> Result<(), LinkError> {
    let failed = |source| LinkError::Io {
        path: path.to_owned(),
        source,
    };
    let new = path.with_extension("new");
    let _ = std::fs::remove_file(&new);
    let mut options = std::fs::OpenOptions::new();
    let mut file = options
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(&new)
        .map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    std::fs::rename(&new, path).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::SceneHead;

    #[test]
    fn a_name_that_has_a_controller_already_is_refused_in_the_station_s_words() {
        let name = format!("taken-{}", std::process::id());
        let config = WatchConfig {
            station: Station::new(&name).unwrap(),
            address: Address::new("127.0.0.1:1", None, true).unwrap(),
            rate_hz: 10.0,
            scene: PathBuf::from("never.calot"),
            seconds: Some(0.1),
        };
        let _controller = Controller::open(&config.station).unwrap();
        let refused = watch(&config, &AtomicBool::new(false), |_| {}).unwrap_err();
        assert!(matches!(refused, LinkError::Service(_)), "{refused:?}");
        let whole = format!(
            "station '{name}' already has a controller; stop it (its `calot run` or `calot rt`), or \
             choose another name with --station"
        );
        assert_eq!(refused.to_string(), whole);
    }

    fn part(total: u64, offset: u64, bytes: &[u8]) -> Vec<u8> {
        let head = SceneHead {
            magic: MAGIC,
            total,
            offset,
        };
        [bytemuck::bytes_of(&head), bytes].concat()
    }

    #[test]
    fn a_scene_that_comes_wrong_is_refused_in_words() {
        let said = |messages: &[Vec<u8>]| {
            let mut coming = Coming::new([7; 16]);
            let mut taken = messages.iter().map(|it| coming.take(it));
            taken.find_map(Result::err).expect("a refusal").to_string()
        };
        let noise = said(&[part(200, 0, &[1; 100]), part(200, 100, &[1; 100])]);
        assert!(
            noise.starts_with("the received scene is unusable: "),
            "{noise}"
        );
        let gap = said(&[part(200, 0, &[1; 50]), part(200, 100, &[1; 100])]);
        assert!(
            gap.contains("it is of another version, or not Calot"),
            "{gap}"
        );
    }
}
