//! Folder of a running station: its compiled scene, links to its devices, its lock.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::problem::Problem;

/// Attempts to take the lock of a station.
const LOCK_LOOKS: u32 = 5;
/// Pause between two attempts.
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// Folder of a running station.
pub(crate) struct Folder {
    path: PathBuf,
    attached: bool,
    /// Held while the station runs. The kernel releases it however this process ends.
    _lock: Option<std::fs::File>,
}

impl Folder {
    pub(crate) fn open(station: &str, attached: bool) -> Result<Self, Problem> {
        let path = shared_mem::service::user_folder()?.join(station);
        let failed = |error| format!("{}: {error}", path.display());
        std::fs::create_dir_all(&path).map_err(failed)?;
        if attached {
            return Ok(Self {
                path,
                attached,
                _lock: None,
            });
        }
        let lock = std::fs::OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(path.join("lock"))
            .map_err(failed)?;
        let mut locked = lock.try_lock();
        for _ in 0..LOCK_LOOKS {
            // A process that checks whether the station runs holds the lock for a moment.
            if !matches!(locked, Err(std::fs::TryLockError::WouldBlock)) {
                break;
            }
            std::thread::sleep(LOCK_PAUSE);
            locked = lock.try_lock();
        }
        match locked {
            Ok(()) => {
                // A killed station left this file behind. It names the wrong scene for the next
                // run.
                let _ = std::fs::remove_file(path.join(RUNNING));
                Ok(Self {
                    path,
                    attached,
                    _lock: Some(lock),
                })
            }
            Err(std::fs::TryLockError::WouldBlock) => Err(format!(
                "station '{station}' runs already; show it with `calot run --attach`, or choose \
                 another name with --station"
            )
            .into()),
            Err(std::fs::TryLockError::Error(error)) => Err(failed(error).into()),
        }
    }

    /// Path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Tells joining displays which compiled scene runs.
    pub(crate) fn tell(&self, scene: &Path) -> Result<(), Problem> {
        use std::os::unix::ffi::OsStrExt as _;
        if self.attached {
            return Ok(());
        }
        let path = std::path::absolute(scene)?;
        // A rename puts it in place, so that no reader sees half of it.
        let half = self.path.join(format!("{RUNNING}.new"));
        let written = std::fs::write(&half, path.as_os_str().as_bytes());
        let written = written.and_then(|()| std::fs::rename(&half, self.path.join(RUNNING)));
        written.map_err(|error| format!("{}: {error}", half.display()).into())
    }

    /// File for the compiled scene. A joining display uses its own file and leaves that of the
    /// running station alone.
    pub(crate) fn scene(&self) -> PathBuf {
        match self.attached {
            true => self
                .path
                .join(format!("attached-{}.calot", std::process::id())),
            false => self.path.join("scene.calot"),
        }
    }
}

/// File in a station's folder that names the running compiled scene.
const RUNNING: &str = "running";

/// Compiled scene that a station runs, if its `calot run` has named it.
pub(crate) fn running(station: &str) -> Result<Option<PathBuf>, Problem> {
    use std::os::unix::ffi::OsStringExt as _;
    let folder = shared_mem::service::user_folder()?.join(station);
    let file = folder.join(RUNNING);
    match std::fs::read(&file) {
        // A killed station leaves its file behind, but not its lock.
        Ok(_) if !is_held(&folder.join("lock")) => Ok(None),
        Ok(path) => Ok(Some(std::ffi::OsString::from_vec(path).into())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(format!("{}: {error}", file.display()).into()),
    }
}

/// True if a station holds the lock.
fn is_held(lock: &Path) -> bool {
    std::fs::File::open(lock).is_ok_and(|file| {
        let tried = file.try_lock_shared();
        matches!(tried, Err(std::fs::TryLockError::WouldBlock))
    })
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.attached {
            let _ = std::fs::remove_file(self.path.join(RUNNING));
        }
        let _ = std::fs::remove_file(self.scene());
    }
}
