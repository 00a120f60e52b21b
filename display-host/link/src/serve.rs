//! The station's side: a host like any display, which answers watchers.

use std::net::{Shutdown, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
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

/// Connections at once, those that have not proved themselves among them.
const CONNECTIONS_MAX: usize = 32;
/// A watcher that asks nothing for so long is given up.
const SILENT_WATCHER: Duration = Duration::from_secs(15);
/// How often shared memory is looked at while nobody asks: events must not be lost.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// How long before a scene that was not found is looked for again: it takes a while, and all wait.
const LOOK_AGAIN: Duration = Duration::from_secs(1);
/// A controller that was silent for so long may have died.
const SILENT: Duration = Duration::from_millis(500);

/// What was served.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Questions answered.
    pub answers: u64,
    /// Bytes of the answers.
    pub bytes: u64,
    /// Questions that were none.
    pub malformed: u64,
}

/// A watcher's question, and where the answer goes.
struct Question {
    kind: u8,
    asked: Vec<u8>,
    answer: SyncSender<Option<Vec<u8>>>,
}

/// Answers watchers of `station` at `address` until `stop` is set or `seconds` are over. The scene that runs is
/// looked for in `places`: compiled scenes, or folders of them. `ready` is called once it listens.
///
/// # Errors
/// When it cannot listen, or the station's shared memory cannot be joined.
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
    let connections = AtomicUsize::new(0);
    // To cut off who takes an answer slowly, when it is over.
    let mut lines: Vec<Weak<TcpStream>> = Vec::new();
    // Each watcher waits for its answer before it can ask again: so many questions at most.
    let (asks, questions) = mpsc::sync_channel(CONNECTIONS_MAX);
    std::thread::scope(|scope| {
        while !stop.load(Relaxed) && seconds.is_none_or(|s| start.elapsed().as_secs_f64() < s) {
            for _ in 0..CONNECTIONS_MAX {
                let Some(stream) = door.knock() else { break };
                if connections.fetch_add(1, Relaxed) >= CONNECTIONS_MAX {
                    connections.fetch_sub(1, Relaxed);
                    continue;
                }
                let Ok(line) = stream.try_clone().map(Arc::new) else {
                    connections.fetch_sub(1, Relaxed);
                    continue;
                };
                lines.retain(|it| it.strong_count() > 0);
                lines.push(Arc::downgrade(&line));
                let (porter, asks) = (door.porter(), asks.clone());
                let (over, connections) = (&over, &connections);
                let attend = move || {
                    attend(&porter, stream, &asks, over);
                    drop(line);
                    connections.fetch_sub(1, Relaxed);
                };
                let builder = std::thread::Builder::new().name("calot-watcher".to_owned());
                if builder.spawn_scoped(scope, attend).is_err() {
                    connections.fetch_sub(1, Relaxed);
                }
            }
            stand.answer_all(&questions, places);
        }
        over.store(true, Relaxed);
        // Who waits for an answer gets none, and who takes one slowly no more of it.
        drop(questions);
        for line in lines.iter().filter_map(Weak::upgrade) {
            let _ = line.shutdown(Shutdown::Both);
        }
    });
    Ok(stand.served)
}

/// One watcher, on a thread of its own: whatever it does, it holds up itself alone.
fn attend(porter: &Porter, stream: TcpStream, asks: &SyncSender<Question>, over: &AtomicBool) {
    let is_over = || over.load(Relaxed);
    let Ok(mut line) = porter.let_in(stream, wire::ASK_MAX, &is_over) else {
        return;
    };
    let mut heard = Instant::now();
    while !is_over() && heard.elapsed() < SILENT_WATCHER {
        match line.receive() {
            Ok(Some((kind, asked))) => {
                heard = Instant::now();
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
    /// The scene that was last asked for, if it was found.
    scene: Option<SceneFile>,
    /// The scene that was last looked for in vain, and when.
    vain: Option<([u8; 16], Instant)>,
    served: Served,
}

impl Stand {
    /// What is asked until shared memory is to be looked at again.
    fn answer_all(&mut self, questions: &Receiver<Question>, places: &[PathBuf]) {
        let next = Instant::now() + LOOK_EVERY;
        self.refresh();
        loop {
            let left = next.saturating_duration_since(Instant::now());
            // With none left it would still take a question that waits, and with many watchers one always does.
            if left.is_zero() {
                return;
            }
            match questions.recv_timeout(left) {
                Ok(question) => {
                    self.refresh();
                    let answer = self.answer(question.kind, &question.asked, places);
                    // One that has gone meanwhile does not mind.
                    let _ = question.answer.send(answer);
                }
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    /// What has come from the station.
    fn refresh(&mut self) {
        let Self { host, desk, .. } = self;
        if host.newest_state(&mut self.state) {
            self.heard = Instant::now();
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

    /// None: it is no question.
    fn answer(&mut self, kind: u8, asked: &[u8], places: &[PathBuf]) -> Option<Vec<u8>> {
        let answer = match kind {
            wire::LOOK => self.desk.answer(asked, monotonic_ns()),
            wire::SCENE => scene_asked(asked).map(|ask| {
                let scene = self.scene(ask.scene_id, places);
                scene_answer(scene.map(SceneFile::bytes), ask.offset)
            }),
            _ => Err(LinkError::Malformed {
                what: "a question that is none",
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

    /// The scene that runs, if it is the one that is asked for.
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

/// The compiled scenes in a folder, or the one that is named.
fn files(place: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(place) else {
        return vec![place.to_owned()];
    };
    let paths = entries.flatten().map(|entry| entry.path());
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|it| it == "calot");
    paths.filter(is_scene).collect()
}
