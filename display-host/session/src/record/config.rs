//! Target and content of a recording, and the endoscope's view that the display passes to it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};

use shared_mem::message::{ActMsg, EventMsg};
use shared_mem::scene::SceneFile;

use crate::course::Entry;
use crate::info::Assignment;

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

    pub(super) fn now(&self) -> [f32; 2] {
        let bits = self.0.load(Relaxed);
        [bits >> 32, bits].map(|bits| f32::from_bits(bits as u32))
    }
}

/// Acts of instructors, until the recorder writes them.
#[derive(Debug, Clone, Default)]
pub struct Acts(Arc<Mutex<Vec<(u64, ActMsg)>>>);

impl Acts {
    /// Notes an act that took place at `at_ns` (`CLOCK_MONOTONIC`). Skips a malformed one.
    pub fn note(&self, at_ns: u64, act: ActMsg) {
        if act.is_sane() {
            let acts = self.0.lock();
            acts.unwrap_or_else(PoisonError::into_inner)
                .push((at_ns, act));
        }
    }

    pub(super) fn taken(&self) -> Vec<(u64, ActMsg)> {
        core::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// News of the session, sent when they are written.
#[derive(Debug, Clone, Copy)]
pub enum Heard {
    /// An event.
    Event(EventMsg),
    /// The recording has reached this tick.
    Tick(u64),
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
    /// Acts of instructors.
    pub acts: Acts,
    /// Channel into which each entry of the course is sent when it is written.
    pub course: Option<Sender<Entry>>,
    /// Channel of news for a caller that waits for an event or a tick.
    pub hears: Option<Sender<Heard>>,
}
