//! The recorder: a listening thread, a bounded queue, a writing thread. Neither thread can delay
//! the simulation, because its publisher overwrites messages that are not fetched in time.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use bytemuck::Zeroable as _;
use shared_mem::inputs::InputBatch;
use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::{ServiceError, Station, Tap};

use crate::course::Entry;
use crate::file::{Error, SessionFile};
use crate::health::{Health, Recorded, Standing};
use crate::identity::Identity;
use crate::info::{Assignment, Info, hex};
use crate::storage::{Storage, check_recording, create_recording};

/// Capacity of the queue to the writing thread, messages: about 40 s of a session.
const QUEUE: usize = 6144;
/// Part of the capacity that only events may use, so that a queue full of ticks still takes events.
const FOR_EVENTS: usize = 1024;
/// Period at which the services are read. The services keep the messages of 8 s.
const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Period at which poses are written for viewers. `/course` and `/tool` get every frame that is
/// read.
const TOOLS_EVERY: Duration = Duration::from_millis(50);
/// Period of the identity images that tell what the endoscope shows.
const SEEN_EVERY: Duration = Duration::from_millis(200);
/// Period of writing. A killed recorder loses no more than the data of this time.
const FLUSH_EVERY: Duration = Duration::from_secs(1);
/// Silence of the disk after which the end of a recording waits no longer.
const HANGING_MAX: Duration = Duration::from_secs(30);

/// Checks that a recording can be written to `path`, and changes nothing there.
///
/// # Errors
/// See [`Error::Create`].
pub fn check_target(path: &Path) -> Result<(), Error> {
    check_recording(path).map_err(|source| Error::Create {
        path: path.to_owned(),
        source,
    })
}

enum Item {
    Inputs(Box<InputBatch>),
    /// The tools. The flag is true if their poses are also written for viewers.
    Tools(Box<ToolFrame>, bool),
    /// The organs, for an identity image.
    State(Box<StateFrame>),
    Event(EventMsg),
    Timing(Box<TimingBatch>),
}

/// The endoscope's view relative to its shaft, set by the display.
#[derive(Debug, Clone, Default)]
pub struct Sight(Arc<AtomicU64>);

impl Sight {
    /// Sets the angle between view and shaft, and the view's turn about the shaft, rad.
    pub fn tell(&self, [off_rad, turned_rad]: [f32; 2]) {
        let (off, turned) = (
            u64::from(off_rad.to_bits()),
            u64::from(turned_rad.to_bits()),
        );
        self.0.store(off << 32 | turned, Relaxed);
    }

    fn now(&self) -> [f32; 2] {
        let bits = self.0.load(Relaxed);
        [bits >> 32, bits].map(|bits| f32::from_bits(bits as u32))
    }
}

/// Target and content of a recording.
pub struct Config {
    /// Path of the file; an existing one is replaced.
    pub path: PathBuf,
    /// Program: version, commit, build.
    pub build: String,
    /// The compiled scene.
    pub scene: SceneFile,
    /// Purpose of the session, if it belongs to a task.
    pub assignment: Option<Assignment>,
    /// The endoscope's view relative to its shaft.
    pub sight: Sight,
    /// Channel into which each entry of the course is sent when it is written.
    pub course: Option<Sender<Entry>>,
}

/// The writing thread's end of the queue.
#[derive(Debug)]
struct Items {
    items: Receiver<Item>,
    waiting: Arc<AtomicUsize>,
    heard: Arc<AtomicU64>,
}

impl Items {
    fn next(&self) -> Result<Item, RecvTimeoutError> {
        let item = self.items.recv_timeout(Duration::from_millis(100));
        if item.is_ok() {
            self.waiting.fetch_sub(1, Relaxed);
        }
        item
    }
}

/// The listening thread's end of the queue.
struct Queue {
    items: SyncSender<Item>,
    waiting: Arc<AtomicUsize>,
    overflowed: Arc<AtomicU64>,
    /// One more than the number of the newest event. It reveals events that were lost at the end.
    heard: Arc<AtomicU64>,
}

impl Queue {
    /// Queues an item for the writer. A full queue drops the item. Items other than events are
    /// dropped earlier, so that room remains for events.
    fn send(&self, item: Item) {
        let is_event = match &item {
            Item::Event(event) => {
                self.heard.store(event.sequence.saturating_add(1), Relaxed);
                true
            }
            _ => false,
        };
        let waiting = self.waiting.fetch_add(1, Relaxed);
        let has_room = is_event || waiting < QUEUE - FOR_EVENTS;
        let sent = match has_room {
            true => self
                .items
                .try_send(item)
                .map_err(|it| matches!(it, TrySendError::Full(_))),
            false => Err(true),
        };
        if let Err(is_full) = sent {
            self.waiting.fetch_sub(1, Relaxed);
            self.overflowed.fetch_add(u64::from(is_full), Relaxed);
        }
    }
}

fn queue(overflowed: Arc<AtomicU64>) -> (Queue, Items) {
    let (sender, items) = mpsc::sync_channel(QUEUE);
    let (waiting, heard) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicU64::new(0)));
    let queue = Queue {
        items: sender,
        waiting: waiting.clone(),
        overflowed,
        heard: heard.clone(),
    };
    (
        queue,
        Items {
            items,
            waiting,
            heard,
        },
    )
}

/// A thread that listens to a station, so that nothing is missed before the file is opened.
#[derive(Debug)]
pub struct Listening {
    thread: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    overflowed: Arc<AtomicU64>,
    items: Items,
    prepare: fn(Option<usize>),
    tick_cpu: Option<usize>,
}

impl Listening {
    /// Starts listening. Call it before the controller starts: a session without its first tick
    /// cannot be replayed. Each of the recorder's threads calls `prepare` with `tick_cpu`, to stay
    /// off the tick's core.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn begin(
        station: &Station,
        prepare: fn(Option<usize>),
        tick_cpu: Option<usize>,
    ) -> Result<Self, Error> {
        let (tell, told) = mpsc::sync_channel::<Result<(), ServiceError>>(1);
        let stop = Arc::new(AtomicBool::new(false));
        let overflowed = Arc::new(AtomicU64::new(0));
        let (sender, items) = queue(overflowed.clone());
        let (station, stopped) = (station.clone(), stop.clone());
        let thread = Builder::new()
            .name("calot-listen".to_owned())
            .spawn(move || {
                prepare(tick_cpu);
                match Tap::open(&station) {
                    Ok(tap) => {
                        let _ = tell.send(Ok(()));
                        listen(&tap, &sender, &stopped);
                    }
                    Err(error) => {
                        let _ = tell.send(Err(error));
                    }
                }
            })
            .map_err(Error::Thread)?;
        if let Ok(told) = told.recv() {
            told?;
        }
        Ok(Self {
            thread,
            stop,
            overflowed,
            items,
            prepare,
            tick_cpu,
        })
    }

    /// Writes everything received, from the start, to a file.
    ///
    /// # Errors
    /// The file cannot be created, or the thread cannot be started.
    pub fn record(self, config: Config) -> Result<Recording, Error> {
        let created = create_recording(&config.path);
        let storage = created.map_err(|source| Error::Create {
            path: config.path.clone(),
            source,
        })?;
        self.record_to(Box::new(storage), config)
    }

    /// Writes everything received to any storage.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn record_to(self, storage: Box<dyn Storage>, config: Config) -> Result<Recording, Error> {
        let Self {
            thread: listener,
            stop,
            overflowed,
            items,
            prepare,
            tick_cpu,
        } = self;
        let file = config.path.clone();
        let health = Arc::new(Mutex::new(Health {
            told: Some(Instant::now()),
            ..Health::default()
        }));
        let told = health.clone();
        let writer = Builder::new()
            .name("calot-record".to_owned())
            .spawn(move || {
                prepare(tick_cpu);
                let recorded = write(&items, storage, config, &overflowed, &told);
                lock(&told).standing = Standing::Ended;
                recorded
            })
            .map_err(Error::Thread)?;
        Ok(Recording {
            listener,
            stop,
            writer,
            health,
            file,
        })
    }
}

/// A session being recorded.
#[derive(Debug)]
pub struct Recording {
    listener: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    writer: JoinHandle<Recorded>,
    health: Arc<Mutex<Health>>,
    file: PathBuf,
}

impl Recording {
    /// State of the recording, updated once a second.
    #[must_use]
    pub fn health(&self) -> Arc<Mutex<Health>> {
        self.health.clone()
    }

    /// Fetches the remaining messages and ends the recording. Call it after the controller has
    /// ended. Waits for a hanging disk for a limited time. Returns `None` if a thread panicked.
    #[must_use]
    pub fn end(self) -> Option<Recorded> {
        self.end_within(HANGING_MAX)
    }

    fn end_within(self, hanging_max: Duration) -> Option<Recorded> {
        self.stop.store(true, Relaxed);
        let listened = self.listener.join();
        while !self.writer.is_finished() {
            let health = *lock(&self.health);
            let silent = health.told.map_or(Duration::ZERO, |told| told.elapsed());
            if silent > hanging_max {
                return Some(Recorded {
                    bytes: health.bytes,
                    missing: health.missing,
                    missing_events: health.missing_events,
                    problem: Some(format!(
                        "the disk has not answered for {} s",
                        silent.as_secs()
                    )),
                    ..Recorded::none_yet(self.file)
                });
            }
            std::thread::sleep(LOOK_EVERY);
        }
        let recorded = self.writer.join();
        listened.ok().and(recorded.ok())
    }
}

fn listen(tap: &Tap, queue: &Queue, stop: &AtomicBool) {
    let mut shown_at: Option<Instant> = None;
    let mut seen_at: Option<Instant> = None;
    let mut newest_ns = 0;
    let mut tools = ToolFrame::zeroed();
    let send = |item: Item| queue.send(item);
    loop {
        // Read the flag first, so that everything sent before the end is still fetched.
        let last = stop.load(Relaxed);
        tap.drain_inputs(|batch| send(Item::Inputs(Box::new(*batch))));
        tap.drain_events(|event| send(Item::Event(*event)));
        tap.drain_timing(|batch| send(Item::Timing(Box::new(*batch))));
        if tap.newest_tools(&mut tools) && tools.capsules().is_some() && tools.at_ns != newest_ns {
            let shown = shown_at.is_none_or(|at| at.elapsed() >= TOOLS_EVERY);
            if shown {
                shown_at = Some(Instant::now());
            }
            newest_ns = tools.at_ns;
            send(Item::Tools(Box::new(tools), shown));
        }
        if seen_at.is_none_or(|at| at.elapsed() >= SEEN_EVERY) {
            let mut state: Box<StateFrame> = bytemuck::zeroed_box();
            if tap.newest_state(&mut state) {
                seen_at = Some(Instant::now());
                send(Item::State(state));
            }
        }
        if last {
            return;
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

fn write(
    items: &Items,
    storage: Box<dyn Storage>,
    mut config: Config,
    overflowed: &AtomicU64,
    health: &Mutex<Health>,
) -> Recorded {
    let mut recorded = Recorded::none_yet(config.path.clone());
    let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let info = Info {
        scene: config.scene.name().to_owned(),
        scene_id: hex(config.scene.short_id()),
        build: config.build.clone(),
        wall_from_host_ns: wall.map_or(0, |wall| wall.as_nanos() as i64) - now_ns() as i64,
    };
    let mut file = match SessionFile::begin(storage, &info, &config.scene) {
        Ok(file) => file,
        Err(error) => {
            recorded.problem = Some(error.to_string());
            return recorded;
        }
    };
    if let Some(course) = config.course.take() {
        file.tell(course);
    }
    let assigned = match &config.assignment {
        Some(assignment) => file.assignment(assignment),
        None => Ok(()),
    };
    let outcome = assigned
        .and_then(|()| take_all(items, &config, &mut file, health))
        .and_then(|()| file.finish());
    recorded.bytes = file.outbox.written;
    recorded.ticks = file.ticks.on_disk;
    recorded.missing = file.ticks.missing;
    recorded.missing_events = file.events.missing;
    recorded.overflowed = overflowed.load(Relaxed);
    recorded.write_failures = file.outbox.failures;
    recorded.slowest_write_ms = file.outbox.slowest.as_millis() as u64;
    recorded.problem = file.outbox.given_up.clone();
    if let Err(error) = outcome {
        recorded.problem = Some(error.to_string());
    }
    recorded
}

fn take_all(
    items: &Items,
    config: &Config,
    file: &mut SessionFile,
    health: &Mutex<Health>,
) -> Result<(), Error> {
    let sight = &config.sight;
    let mut seen = Sight::default().now().map(f32::to_bits);
    // Identity images serve the assessment, so a session without a task has none.
    let judged = config.assignment.as_ref();
    let mut identity = judged.map(|_| Identity::of(&config.scene));
    let mut newest = Box::new(ToolFrame::zeroed());
    let mut flushed = Instant::now();
    let mut refused = None;
    loop {
        match items.next() {
            Ok(Item::Inputs(batch)) => file.inputs(&batch)?,
            Ok(Item::Tools(tools, shown)) => {
                let now = sight.now();
                if seen != now.map(f32::to_bits) {
                    seen = now.map(f32::to_bits);
                    file.sight(now, &tools)?;
                }
                file.moved(&tools)?;
                if shown {
                    file.tools(&tools)?;
                }
                newest = tools;
            }
            Ok(Item::State(state)) => {
                let image = identity.as_mut();
                if let Some(what) = image.and_then(|it| it.look(sight.now(), &state, &newest)) {
                    file.seen(what, &newest)?;
                }
            }
            Ok(Item::Event(event)) => file.event(&event)?,
            Ok(Item::Timing(batch)) => file.timing(&batch)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                file.heard_of(items.heard.load(Relaxed));
                return Ok(());
            }
        }
        if flushed.elapsed() >= FLUSH_EVERY {
            file.flush()?;
            tell(file.outbox.refused.as_deref(), &mut refused);
            *lock(health) = health_of(file);
            // The period begins after the write, so that the queue is emptied after a slow write.
            flushed = Instant::now();
        }
    }
}

fn health_of(file: &SessionFile) -> Health {
    let outbox = &file.outbox;
    Health {
        standing: match (&outbox.given_up, &outbox.refused) {
            (Some(_), _) => Standing::Ended,
            (None, Some(_)) => Standing::Refused,
            (None, None) => Standing::Recording,
        },
        bytes: outbox.written,
        waiting: outbox.waits() as u64,
        missing: file.ticks.missing,
        missing_events: file.events.missing,
        told: Some(Instant::now()),
    }
}

fn lock(health: &Mutex<Health>) -> std::sync::MutexGuard<'_, Health> {
    health.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reports on standard error when the disk begins to refuse the recording, and when it accepts it
/// again.
fn tell(refused: Option<&str>, before: &mut Option<String>) {
    if before.as_deref() == refused {
        return;
    }
    *before = refused.map(str::to_owned);
    // Unlike `eprintln!` this does not panic when standard error is closed.
    let _ = match refused {
        Some(why) => writeln!(
            std::io::stderr(),
            "calot: the disk does not take the recording ({why}); minutes of it wait in memory: make \
             room"
        ),
        None => writeln!(
            std::io::stderr(),
            "calot: the disk accepts the recording again"
        ),
    };
}

/// Present time on the controller's clock (`CLOCK_MONOTONIC`), ns.
fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_recorder_too_many_is_refused_in_the_station_s_words() {
        let station = Station::new(&format!("taps-{}", std::process::id())).expect("a plain name");
        let recorders = [(); 2].map(|()| Tap::open(&station).expect("room for two"));
        let refused = Listening::begin(&station, |_| {}, None).expect_err("both places are taken");
        assert!(matches!(refused, Error::Service(_)), "{refused:?}");
        let (name, count) = (station.name(), recorders.len());
        let whole = format!("station '{name}' has {count} recorders already; close one");
        assert_eq!(refused.to_string(), whole);
    }

    #[test]
    fn a_queue_full_of_ticks_still_takes_events() {
        let overflowed = Arc::new(AtomicU64::new(0));
        let (queue, items) = queue(overflowed.clone());
        for _ in 0..QUEUE + 100 {
            queue.send(Item::Inputs(Box::new(InputBatch::zeroed())));
        }
        assert_eq!(overflowed.load(Relaxed), FOR_EVENTS as u64 + 100);
        for _ in 0..FOR_EVENTS {
            queue.send(Item::Event(EventMsg::zeroed()));
        }
        assert_eq!(overflowed.load(Relaxed), FOR_EVENTS as u64 + 100);
        queue.send(Item::Event(EventMsg::zeroed()));
        assert_eq!(overflowed.load(Relaxed), FOR_EVENTS as u64 + 101);
        let (mut inputs, mut events) = (0, 0);
        drop(queue);
        while let Ok(item) = items.next() {
            match item {
                Item::Event(_) => events += 1,
                _ => inputs += 1,
            }
        }
        assert_eq!((inputs, events), (QUEUE - FOR_EVENTS, FOR_EVENTS));
    }

    /// A listener whose messages are already queued; the station is gone.
    fn heard(items: Items, overflowed: Arc<AtomicU64>) -> Listening {
        Listening {
            thread: std::thread::spawn(|| {}),
            stop: Arc::default(),
            overflowed,
            items,
            prepare: |_| {},
            tick_cpu: None,
        }
    }

    fn config(path: PathBuf) -> Config {
        Config {
            path,
            build: "a test".to_owned(),
            scene: crate::tests::scene(),
            assignment: None,
            sight: Sight::default(),
            course: None,
        }
    }

    #[test]
    fn events_that_a_full_queue_loses_are_counted_and_told() {
        let overflowed = Arc::new(AtomicU64::new(0));
        let (queue, items) = queue(overflowed.clone());
        for sequence in 0..QUEUE as u64 + 3 {
            queue.send(Item::Event(EventMsg {
                sequence,
                ..EventMsg::zeroed()
            }));
        }
        drop(queue);
        let folder = tempfile::tempdir().unwrap();
        let config = config(folder.path().join("session.mcap"));
        let recording = heard(items, overflowed).record(config).unwrap();
        let recorded = recording.end().unwrap();
        // No tick is missing, so only the count of events shows the loss.
        assert_eq!(
            (
                recorded.missing,
                recorded.missing_events,
                recorded.overflowed
            ),
            (0, 3, 3)
        );
        let warning = recorded.warning().unwrap();
        assert!(warning.contains("misses 3 events"), "{warning}");
    }

    #[test]
    fn two_recorders_do_not_write_over_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("session.mcap");
        let begin = || {
            let overflowed = Arc::new(AtomicU64::new(0));
            let (queue, items) = queue(overflowed.clone());
            let recording = heard(items, overflowed).record(config(path.clone()));
            (queue, recording)
        };
        let (queue, first) = begin();
        let error = begin().1.unwrap_err().to_string();
        assert!(error.contains("another recorder"), "{error}");
        assert!(crate::is_being_recorded(&path));
        drop(queue);
        let recorded = first.unwrap().end().unwrap();
        assert_eq!(recorded.problem, None);
        assert_eq!(std::fs::metadata(&path).unwrap().len(), recorded.bytes);
        // After the end the file may be replaced.
        assert!(!crate::is_being_recorded(&path));
        let (queue, again) = begin();
        drop(queue);
        assert_eq!(again.unwrap().end().unwrap().problem, None);
    }

    #[test]
    fn a_pipe_is_refused_instead_of_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        let fifo = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, &path, fifo, mode, 0).unwrap();
        let (_queue, items) = queue(Arc::default());
        let refused = heard(items, Arc::default()).record(config(path));
        let error = refused.unwrap_err().to_string();
        assert!(error.contains("needs a file"), "{error}");
    }

    #[test]
    fn the_end_does_not_wait_for_a_disk_that_hangs() {
        let (hold, held) = mpsc::channel::<()>();
        let recording = Recording {
            listener: std::thread::spawn(|| {}),
            stop: Arc::default(),
            writer: std::thread::spawn(move || {
                let _ = held.recv();
                Recorded::none_yet(PathBuf::new())
            }),
            health: Arc::new(Mutex::new(Health {
                bytes: 7,
                told: Some(Instant::now()),
                ..Health::default()
            })),
            file: "session.mcap".into(),
        };
        let recorded = recording.end_within(Duration::from_millis(50)).unwrap();
        let problem = recorded.problem.clone().unwrap();
        assert!(problem.contains("has not answered"), "{problem}");
        assert_eq!(
            (recorded.bytes, recorded.file.to_str()),
            (7, Some("session.mcap"))
        );
        drop(hold);
    }
}
