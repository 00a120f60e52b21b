//! Pictures of the critical view of safety, kept beside the session.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use image::RgbaImage;

use crate::DisplayError;
use crate::picture::write_png;
use crate::ui::TaskView;

/// Files of the views from the front and from behind.
pub const VIEWS: [&str; 2] = ["critical_view_front.png", "critical_view_behind.png"];

/// Watches a task for critical views that the trainee has held.
#[derive(Debug, Clone)]
pub(crate) struct Watch {
    task: Arc<Mutex<TaskView>>,
    out_dir: PathBuf,
    before: [bool; 2],
}

impl Watch {
    pub(crate) fn new(task: &Arc<Mutex<TaskView>>, out_dir: &Path) -> Self {
        Self {
            task: task.clone(),
            out_dir: out_dir.to_owned(),
            before: [false; 2],
        }
    }

    /// Path of the picture that is due now, if a view was held since the last call. After a restart
    /// of the task a new view replaces the old one.
    pub(crate) fn due(&mut self) -> Option<PathBuf> {
        let held = self
            .task
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .views_held;
        let mut due = None;
        for ((before, held), name) in self.before.iter_mut().zip(held).zip(VIEWS) {
            if held && !*before && due.is_none() {
                due = Some(self.out_dir.join(name));
                *before = true;
            }
            *before &= held;
        }
        due
    }
}

/// Writes a picture that only the user may read, because a trainee's performance is private.
pub(crate) fn write(picture: &RgbaImage, path: &Path) -> Result<(), DisplayError> {
    let failed = |detail: String| DisplayError::Write {
        path: path.to_owned(),
        detail,
    };
    let file = session::create_private(path).map_err(|it| failed(it.to_string()))?;
    write_png(picture, file).map_err(|it| failed(it.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_view_is_due_once_and_again_after_a_restart() {
        let task = Arc::new(Mutex::new(TaskView::default()));
        let mut watch = Watch::new(&task, Path::new("out"));
        let mut names = |held: [bool; 2]| {
            task.lock().unwrap().views_held = held;
            core::iter::from_fn(|| watch.due())
                .map(|it| it.file_name().unwrap().to_string_lossy().into_owned())
                .collect::<Vec<_>>()
        };
        assert!(names([false; 2]).is_empty());
        assert_eq!(names([true, false]), VIEWS[..1]);
        assert_eq!(names([true; 2]), VIEWS[1..]);
        assert!(names([true; 2]).is_empty());
        assert!(names([false; 2]).is_empty());
        assert_eq!(names([true; 2]), VIEWS);
    }
}
