//! The writing thread: it writes the queue's items into the file, and reports the state of the
//! disk.

use std::io::Write as _;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use bytemuck::Zeroable as _;
use shared_mem::inputs::InputRecord;
use shared_mem::message::{CommandMsg, ToolFrame};

use super::config::{Config, Heard, Sight};
use super::first_move::FirstMove;
use super::queue::{Item, Items};
use crate::file::{Error, SessionFile};
use crate::health::{Health, Recorded, Standing};
use crate::identity::Identity;
use crate::info::{ENDOSCOPE_DRILL, Info, hex};
use crate::storage::Storage;

/// Period of writing. A killed recorder loses no more than the data of this time.
const FLUSH_EVERY: Duration = Duration::from_secs(1);

pub(super) fn write(
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
    // A task begins with the first move, except the endoscope drill. A session without a task
    // begins at once.
    let waits = judged.filter(|it| it.task != ENDOSCOPE_DRILL);
    let mut first_move = waits.map(|_| FirstMove::default());
    let mut newest = Box::new(ToolFrame::zeroed());
    let mut flushed = Instant::now();
    let mut refused = None;
    loop {
        match items.next() {
            Ok(Item::Inputs(batch)) => {
                file.inputs(&batch)?;
                if batch.records().is_some_and(begins_anew) {
                    first_move = waits.map(|_| FirstMove::default());
                }
                if let Some(newest) = batch.records().and_then(<[_]>::last) {
                    tell_news(config, Heard::Tick(newest.tick));
                }
            }
            Ok(Item::Tools(tools, shown)) => {
                let now = sight.now();
                if seen != now.map(f32::to_bits) {
                    seen = now.map(f32::to_bits);
                    file.sight(now, &tools)?;
                }
                if first_move.as_mut().is_none_or(|it| it.has_come(&tools)) {
                    file.moved(&tools)?;
                }
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
            Ok(Item::Event(event)) => {
                file.event(&event)?;
                tell_news(config, Heard::Event(event));
            }
            Ok(Item::Timing(batch)) => file.timing(&batch)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                write_acts(config, file, &newest)?;
                file.heard_of(items.heard.load(Relaxed));
                return Ok(());
            }
        }
        write_acts(config, file, &newest)?;
        if flushed.elapsed() >= FLUSH_EVERY {
            file.flush()?;
            tell(file.outbox.refused.as_deref(), &mut refused);
            *lock(health) = health_of(file);
            // The period begins after the write, so that the queue is emptied after a slow write.
            flushed = Instant::now();
        }
    }
}

/// True if a command among these inputs begins the operation anew.
fn begins_anew(records: &[InputRecord]) -> bool {
    let mut commands = records.iter().map(|it| u32::from(it.command & 15));
    commands.any(|it| matches!(it, CommandMsg::RESET | CommandMsg::START))
}

fn tell_news(config: &Config, news: Heard) {
    // The receiver may be gone.
    let _ = config.hears.as_ref().map(|it| it.send(news));
}

fn write_acts(config: &Config, file: &mut SessionFile, newest: &ToolFrame) -> Result<(), Error> {
    for (at_ns, act) in config.acts.taken() {
        file.act(&act, at_ns, newest)?;
    }
    Ok(())
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
        reported: Some(Instant::now()),
    }
}

pub(super) fn lock(health: &Mutex<Health>) -> std::sync::MutexGuard<'_, Health> {
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
            "calot: the disk does not take the recording ({why}), so the recording waits in memory, 16 \
             MB at most: make room on the disk"
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
