//! The scripted surgeon of `--hand`, who works while a turn is measured.

use std::path::Path;

use assess::Task;
use shared_mem::scene::SceneFile;
use shared_mem::service::Station;
use surgeon::Surgeon;

use crate::problem::Problem;
use crate::say;
use crate::surgeon::AtWork;
use crate::task;

/// A surgeon at work, if one was asked for.
pub(super) struct Work(Option<AtWork>);

impl Work {
    /// Brings the organs to the state in which the task begins, and starts the surgeon. Does
    /// nothing without `hand`.
    pub(super) fn begin(
        hand: Option<(Surgeon, Task)>,
        station: &str,
        scene: &Path,
    ) -> Result<Self, Problem> {
        let Some((surgeon, task)) = hand else {
            return Ok(Self(None));
        };
        let station = Station::new(station)?;
        if let Some(state) = task::begins(task) {
            task::start(state, &station)?;
        }
        let scene = SceneFile::open(scene)?;
        AtWork::begin(surgeon, task, &station, scene, None).map(|work| Self(Some(work)))
    }

    pub(super) fn end(self) {
        if let Some(reason) = self.0.and_then(AtWork::end) {
            say::note(format_args!("jitter: the surgeon gave up: {reason}"));
        }
    }
}
