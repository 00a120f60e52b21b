//! The station's side: reads the station's shared memory like any display and answers watchers.

use std::net::{Shutdown, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::{Host, Station, TaskReceiver};
use shared_mem::task::TaskMsg;

use crate::address::Address;
use crate::desk::{Desk, scene_answer, scene_asked};
use crate::error::LinkError;
use crate::line::{Door, Line, Porter};
use crate::{monotonic_ns, wire};

/// Largest number of connections at once, including those not yet authenticated.
const CONNECTIONS_MAX: usize = 32;
/// A watcher that asks nothing for this long is disconnected.
const SILENT_WATCHER: Duration = Duration::from_secs(15);
/// Interval at which shared memory is read while nobody asks, so that no event is lost.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Delay before a missing scene is searched again: the search is slow and all watchers wait for it.
const LOOK_AGAIN: Duration = Duration::from_secs(1);
/// A controller that publishes no state for this long may have died; `serve` then checks.
const SILENT: Duration = Duration::from_millis(500);

/// Counts of a served station.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Questions answered.
    pub answers: u64,
    /// Bytes of the answers.
    pub bytes: u64,
    /// Malformed questions.
    pub malformed: u64,
    /// States of the station that were seen; 0: it never ran.
    pub states: u64,
}

/// A watcher's question and the channel for its answer.
struct Question {
    kind: u8,
    asked: Vec<u8>,
    answer: SyncSender<Option<Vec<u8>>>,
}

/// Answers watchers of `station` at `address` until `stop` is set or `seconds` have passed.
/// Searches for the running scene in `places`, which are compiled scenes or folders of them. Calls
/// `ready` as soon as watchers can connect.
///
/// # Errors
/// When it cannot listen, or cannot join the station's shared memory.
pub fn serve(
    station: &Station,
    address: &Address,
    places: &[PathBuf],
    seconds: Option<f64>,
    stop: &AtomicBool,
    ready: impl FnOnce(),
) -> Result<Served, LinkError> {
    let host = Host::open(station)?;
    let tasks = TaskReceiver::open(station)?;
    let door = Door::open(address)?;
    ready();
    let mut stand = Stand {
        host,
        desk: Desk::new(monotonic_ns()),
        state: bytemuck::zeroed_box(),
        tools: ToolFrame::zeroed(),
        tasks,
        task: bytemuck::zeroed_box(),
        heard: Instant::now(),
        scene: None,
        vain: None,
        served: Served::default(),
    };
    let start = Instant::now();
    let over = AtomicBool::new(false);
    let mut visitors = Visitors::default();
    // The thread of each watcher passes on one question at a time, which bounds the queue.
    let (asks, questions) = mpsc::sync_channel(CONNECTIONS_MAX);
    std::thread::scope(|scope| {
        while !stop.load(Relaxed) && seconds.is_none_or(|s| start.elapsed().as_secs_f64() < s) {
            for _ in 0..CONNECTIONS_MAX {
                let Some(stream) = door.knock() else { break };
                let Some(visit) = visitors.enter(&stream) else {
                    continue;
                };
                let (porter, asks) = (door.porter(), asks.clone());
                let over = &over;
                let attend = move || attend(&porter, stream, &visit, &asks, over);
                let builder = std::thread::Builder::new().name("calot-watcher".to_owned());
                // If no thread starts, the connection is closed.
                let _ = builder.spawn_scoped(scope, attend);
            }
            stand.answer_all(&questions, places);
        }
        over.store(true, Relaxed);
        // Watchers that wait get no answer. Watchers that read slowly do not get the rest.
        drop(questions);
        visitors.cut_off();
    });
    Ok(stand.served)
}

/// All connections.
#[derive(Default)]
struct Visitors(Vec<Weak<Visit>>);

/// A connection, which lives as long as its thread.
struct Visit {
    line: TcpStream,
    /// Set once the peer is authenticated and has asked a question.
    is_known: AtomicBool,
}

impl Visitors {
    /// Registers a connection. If all places are taken, the connection replaces the oldest one
    /// whose peer has asked nothing, so that such peers keep nobody out. `None` if the peers of all
    /// places have asked.
    fn enter(&mut self, stream: &TcpStream) -> Option<Arc<Visit>> {
        let line = stream.try_clone().ok()?;
        self.0.retain(|it| it.strong_count() > 0);
        if self.0.len() >= CONNECTIONS_MAX {
            let is_stranger = |it: &Weak<Visit>| {
                it.upgrade()
                    .is_none_or(|visit| !visit.is_known.load(Relaxed))
            };
            let stranger = self.0.iter().position(is_stranger)?;
            if let Some(visit) = self.0.remove(stranger).upgrade() {
                visit.cut_off();
            }
        }
        let visit = Arc::new(Visit {
            line,
            is_known: AtomicBool::new(false),
        });
        self.0.push(Arc::downgrade(&visit));
        Some(visit)
    }

    fn cut_off(&self) {
        let here = self.0.iter().filter_map(Weak::upgrade);
        here.for_each(|visit| visit.cut_off());
    }
}

impl Visit {
    fn cut_off(&self) {
        let _ = self.line.shutdown(Shutdown::Both);
    }
}

/// Serves one watcher on a thread of its own, so that a slow watcher delays only itself.
fn attend(
    porter: &Porter,
    stream: TcpStream,
    visit: &Visit,
    asks: &SyncSender<Question>,
    over: &AtomicBool,
) {
    let is_over = || over.load(Relaxed);
    let Ok(mut line) = porter.let_in(stream, wire::ASK_MAX, &is_over) else {
        return;
    };
    let mut heard = Instant::now();
    while !is_over() && heard.elapsed() < SILENT_WATCHER {
        match line.receive() {
            Ok(Some((kind, asked))) => {
                heard = Instant::now();
                visit.is_known.store(true, Relaxed);
                if reply(&mut line, kind, asked, asks).is_none() {
                    return;
                }
            }
            Ok(None) => {}
            Err(_) => return,
        }
    }
}

fn reply(line: &mut Line, kind: u8, asked: Vec<u8>, asks: &SyncSender<Question>) -> Option<()> {
    let (answer, answered) = mpsc::sync_channel(1);
    let question = Question {
        kind,
        asked,
        answer,
    };
    asks.send(question).ok()?;
    let bytes = answered.recv().ok()??;
    line.send(kind, &bytes).ok()
}

struct Stand {
    host: Host,
    desk: Desk,
    state: Box<StateFrame>,
    tools: ToolFrame,
    tasks: TaskReceiver,
    task: Box<TaskMsg>,
    heard: Instant,
    /// The last requested scene, if it was found.
    scene: Option<SceneFile>,
    /// Identity of the last scene that was not found, and the time of the search.
    vain: Option<([u8; 16], Instant)>,
    served: Served,
}

impl Stand {
    /// Reads shared memory, and answers questions for `LOOK_EVERY`.
    fn answer_all(&mut self, questions: &Receiver<Question>, places: &[PathBuf]) {
        let next = Instant::now() + LOOK_EVERY;
        self.refresh();
        loop {
            let left = next.saturating_duration_since(Instant::now());
            // With a time-out of zero, `recv_timeout` still takes a waiting question. With many
            // watchers one always waits, and the loop would never end.
            if left.is_zero() {
                return;
            }
            match questions.recv_timeout(left) {
                Ok(question) => {
                    self.refresh();
                    let answer = self.answer(question.kind, &question.asked, places);
                    // The watcher may have gone meanwhile.
                    let _ = question.answer.send(answer);
                }
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    /// Takes new data from the station.
    fn refresh(&mut self) {
        let Self { host, desk, .. } = self;
        if host.newest_state(&mut self.state) {
            self.heard = Instant::now();
            self.served.states += 1;
            desk.set_state(&self.state);
        }
        if host.newest_tools(&mut self.tools) {
            desk.set_tools(&self.tools);
        }
        if self.tasks.newest(&mut self.task) {
            desk.set_task(&self.task);
        }
        host.drain_events(|event| desk.add_event(*event));
        host.drain_timing(|batch| {
            if batch.records().is_some() {
                desk.add_batch(batch);
            }
        });
        if self.heard.elapsed() > SILENT {
            host.forget_dead();
            self.heard = Instant::now();
        }
    }

    /// Answers a question; `None` if it is malformed.
    fn answer(&mut self, kind: u8, asked: &[u8], places: &[PathBuf]) -> Option<Vec<u8>> {
        let answer = match kind {
            wire::LOOK => self.desk.answer(asked, monotonic_ns()),
            wire::SCENE => scene_asked(asked).map(|ask| {
                let scene = self.scene(ask.scene_id, places);
                scene_answer(scene.map(SceneFile::bytes), &ask)
            }),
            _ => Err(LinkError::Malformed {
                what: "a question of an unknown kind",
            }),
        };
        match answer {
            Ok(answer) => {
                self.served.answers += 1;
                self.served.bytes += answer.len() as u64;
                Some(answer)
            }
            Err(_) => {
                self.served.malformed += 1;
                None
            }
        }
    }

    /// The running scene, if its identity is `id` and a file in `places` holds it.
    fn scene(&mut self, id: [u8; 16], places: &[PathBuf]) -> Option<&SceneFile> {
        if self.desk.scene_id() != Some(id) {
            return None;
        }
        let is_vain = |&(vain, at): &([u8; 16], Instant)| vain == id && at.elapsed() < LOOK_AGAIN;
        if self.scene.as_ref().is_none_or(|it| it.short_id() != id) {
            if self.vain.as_ref().is_some_and(is_vain) {
                return None;
            }
            self.scene = places.iter().flat_map(|it| files(it)).find_map(|file| {
                let levels = SceneFile::levels(&file).into_iter();
                let mut scenes = levels.filter_map(|level| SceneFile::open(&level).ok());
                scenes.find(|scene| scene.short_id() == id)
            });
            self.vain = self.scene.is_none().then(|| (id, Instant::now()));
        }
        self.scene.as_ref()
    }
}

/// The compiled scenes in a folder, or the file itself.
fn files(place: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(place) else {
        return vec![place.to_owned()];
    };
    let paths = entries.flatten().map(|entry| entry.path());
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|it| it == "calot");
    paths.filter(is_scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;
    use std::net::TcpListener;

    #[test]
    fn strangers_keep_nobody_out_and_who_has_asked_stays() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let knock = || {
            let theirs = TcpStream::connect(address).expect("it listens");
            let (ours, _) = listener.accept().expect("it came");
            (theirs, ours)
        };
        let mut visitors = Visitors::default();
        let mut enter = |ours: &TcpStream| visitors.enter(ours);
        let mut inside: Vec<_> = (0..CONNECTIONS_MAX)
            .map(|_| {
                let (theirs, ours) = knock();
                let visit = enter(&ours).expect("there are places");
                (theirs, ours, visit)
            })
            .collect();
        let [first, second, ..] = &mut inside[..] else {
            unreachable!("there are more");
        };
        first.2.is_known.store(true, Relaxed);

        let (_theirs, ours) = knock();
        let newcomer = enter(&ours).expect("a stranger gives way");
        assert_eq!(second.0.read(&mut [0]).expect("it is cut off"), 0);
        first.0.set_nonblocking(true).expect("set");
        assert!(first.0.read(&mut [0]).is_err(), "who has asked stays");

        for visit in inside.iter().map(|it| &it.2).chain([&newcomer]) {
            visit.is_known.store(true, Relaxed);
        }
        let (_theirs, ours) = knock();
        assert!(enter(&ours).is_none(), "all places are taken");
    }
}
