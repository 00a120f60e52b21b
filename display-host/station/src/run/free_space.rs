//! Checks for free space on the disk before a recording begins.

use std::path::Path;

use rustix::process::{Resource, getrlimit};

use crate::problem::Problem;
use crate::say;

/// Largest number of bytes of an hour of recording. Tests of `session` show that inputs stay below
/// 330 MB, and the course (poses and events) below 80 MB. The rest is for times of ticks (100 MB)
/// and for the messages that viewers read (70 MB).
const HOUR_BYTES: f64 = 600e6;
/// Free space for the other results: pages, pictures, summary.
const RESULTS_BYTES: u64 = 4 << 20;
/// Length of recording that must fit, s. Otherwise the recording is refused.
const LEAST_S: f64 = 60.0;
/// Assumed length of an operation without `--seconds`, s.
const OPEN_S: f64 = 3600.0;

/// Compares the free bytes at `path` with the size of a session of `seconds` that holds a scene of
/// this size. Warns if the session will not fit.
///
/// # Errors
/// The first minute of the session, or a shorter session, does not fit.
pub(super) fn check(path: &Path, scene_bytes: u64, seconds: Option<f64>) -> Result<(), Problem> {
    // If the file system does not report its free bytes, assume that there are enough.
    let free = free_bytes(path).unwrap_or(u64::MAX);
    let limit = getrlimit(Resource::Fsize).current.unwrap_or(u64::MAX);
    let (free, are_free, make_room) = match limit < free {
        true => (
            limit,
            "are allowed by the limit of file sizes (`ulimit -f`)",
            "raise the limit",
        ),
        false => (free, "are free there", "make room"),
    };
    let planned_s = seconds.unwrap_or(OPEN_S);
    let need = |seconds: f64| scene_bytes + RESULTS_BYTES + (HOUR_BYTES * seconds / 3600.0) as u64;
    let mb = |bytes: u64| bytes as f64 * 1e-6;
    let place = path.display();
    if free < need(planned_s.min(LEAST_S)) {
        return Err(format!(
            "{place}: {:.1} MB {are_free}, and {:.0} s of recording need {:.1} MB; {make_room}, or record \
             elsewhere with --out or --record",
            mb(free),
            planned_s.min(LEAST_S),
            mb(need(planned_s.min(LEAST_S)))
        )
        .into());
    }
    if free < need(planned_s) {
        let fits_s = (free - need(0.0)) as f64 / HOUR_BYTES * 3600.0;
        say::note(format_args!(
            "warning: {place}: {:.1} MB {are_free}, enough for about {:.0} minutes of recording; {make_room}, or \
             record elsewhere with --out or --record",
            mb(free),
            (fits_s / 60.0).floor()
        ));
    }
    Ok(())
}

/// Bytes that this user may still write where the file is or will be.
fn free_bytes(path: &Path) -> Option<u64> {
    let folder = path.parent().filter(|it| !it.as_os_str().is_empty());
    let room = rustix::fs::statvfs(folder.unwrap_or(Path::new("."))).ok()?;
    Some(room.f_bavail.saturating_mul(room.f_frsize))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_that_does_not_fit_is_refused_with_need_and_room() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("session.mcap");
        check(&path, 0, Some(1.0)).unwrap();
        let refused = check(&path, 1 << 60, Some(1.0)).unwrap_err().to_string();
        for words in [
            "session.mcap",
            "are free",
            "1 s of recording need",
            "--record",
        ] {
            assert!(refused.contains(words), "{refused}");
        }
    }
}
