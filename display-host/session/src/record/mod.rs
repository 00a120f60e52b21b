//! The recorder: a listening thread, a bounded queue, a writing thread. Neither thread can delay
//! the simulation, because its publisher overwrites messages that are not fetched in time.

mod config;
mod first_move;
mod listen;
mod queue;
mod write;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

pub use self::config::{Acts, Config, Heard, Sight};
use self::listen::LOOK_EVERY;
pub use self::listen::Listening;
use self::write::{lock, write};
use crate::file::Error;
use crate::health::{Health, Recorded, Standing};
use crate::storage::{Storage, check_recording, create_recording};

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

impl Listening {
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
            reported: Some(Instant::now()),
            ..Health::default()
        }));
        let shared = health.clone();
        let writer = Builder::new()
            .name("calot-record".to_owned())
            .spawn(move || {
                prepare(tick_cpu);
                let recorded = write(&items, storage, config, &overflowed, &shared);
                lock(&shared).standing = Standing::Ended;
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
            let silent = health.reported.map_or(Duration::ZERO, |it| it.elapsed());
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

#[cfg(test)]
mod tests;
