//! Folder of a running station: its compiled scene, links to its devices, its lock.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hardware::{Holder, holders, socket_holders};
use shared_mem::service::{Claim, ServiceError, Station, owner};

use crate::problem::Problem;

/// Number of looks at a station's lock. Another process may hold the lock for a moment.
const LOCK_LOOKS: u32 = 5;
/// Pause between two looks.
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// Folder of a running station.
pub(crate) struct Folder {
    path: PathBuf,
    attached: bool,
    /// Lock that is held while the station runs. The kernel releases it however this process ends.
    _lock: Option<std::fs::File>,
    /// Claim of the station's name. It holds even if a clean-up removes the lock's file.
    _claim: Option<Claim>,
}

impl Folder {
    /// Opens the folder. A station claims its name and takes the lock; an attached display does
    /// not.
    pub(crate) fn open(station: &str, attached: bool) -> Result<Self, Problem> {
        let path = shared_mem::service::user_folder()?.join(station);
        let failed = |error| format!("{}: {error}", path.display());
        std::fs::create_dir_all(&path).map_err(failed)?;
        if attached {
            return Ok(Self {
                path,
                attached,
                _lock: None,
                _claim: None,
            });
        }
        let held_by = |socket: Option<u64>| in_words(&socket.map_or_else(Vec::new, socket_holders));
        let claim = Station::new(station)?.claim(held_by)?;
        let lock = std::fs::OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(path.join("lock"))
            .map_err(failed)?;
        let mut locked = lock.try_lock();
        for _ in 0..LOCK_LOOKS {
            // Another process may hold the lock for a moment, to check that the station runs.
            if !matches!(locked, Err(std::fs::TryLockError::WouldBlock)) {
                break;
            }
            std::thread::sleep(LOCK_PAUSE);
            locked = lock.try_lock();
        }
        match locked {
            Ok(()) => {
                // A killed station may have left this file behind. It names that station's scene.
                let _ = std::fs::remove_file(path.join(SCENE_NAME_FILE));
                Ok(Self {
                    path,
                    attached,
                    _lock: Some(lock),
                    _claim: Some(claim),
                })
            }
            Err(std::fs::TryLockError::WouldBlock) => {
                drop(lock);
                Err(ServiceError::RunsAlready {
                    station: station.to_owned(),
                    by: in_words(&holders(&path.join("lock"))),
                }
                .into())
            }
            Err(std::fs::TryLockError::Error(error)) => Err(failed(error).into()),
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Tells joining displays which compiled scene runs.
    pub(crate) fn announce_scene(&self, scene: &Path) -> Result<(), Problem> {
        use std::os::unix::ffi::OsStrExt as _;
        if self.attached {
            return Ok(());
        }
        let path = std::path::absolute(scene)?;
        // A rename puts the file in place, so that no reader sees half of it.
        let unfinished = self.path.join(format!("{SCENE_NAME_FILE}.new"));
        let written = std::fs::write(&unfinished, path.as_os_str().as_bytes());
        let written =
            written.and_then(|()| std::fs::rename(&unfinished, self.path.join(SCENE_NAME_FILE)));
        written.map_err(|error| format!("{}: {error}", unfinished.display()).into())
    }

    /// File for the compiled scene. An attached display has its own file, so that it does not
    /// change the station's file.
    pub(crate) fn scene(&self) -> PathBuf {
        match self.attached {
            true => self
                .path
                .join(format!("attached-{}.calot", std::process::id())),
            false => self.path.join("scene.calot"),
        }
    }
}

/// Names the programs that hold a station's name or lock, and their users.
fn in_words(holders: &[Holder]) -> String {
    let one = |it: &Holder| format!("{it} of {}", owner(it.user));
    match holders {
        [] => "a program that /proc does not show: another account's, or one in another container"
            .to_owned(),
        seen => seen.iter().map(one).collect::<Vec<_>>().join(", "),
    }
}

/// File in a station's folder that names the running compiled scene.
const SCENE_NAME_FILE: &str = "running";

/// Compiled scene that a station runs, if its `calot run` has named it.
pub(crate) fn running_scene(station: &str) -> Result<Option<PathBuf>, Problem> {
    use std::os::unix::ffi::OsStringExt as _;
    let folder = shared_mem::service::user_folder()?.join(station);
    let file = folder.join(SCENE_NAME_FILE);
    match std::fs::read(&file) {
        // A killed station leaves its file behind, but not its lock.
        Ok(_) if !is_held(&folder.join("lock")) => Ok(None),
        Ok(path) => Ok(Some(std::ffi::OsString::from_vec(path).into())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            match is_lock_unseen(station, &folder.join("lock"))? {
                true => Err(unseen_lock(station, &folder).into()),
                false => Ok(None),
            }
        }
        Err(error) => Err(format!("{}: {error}", file.display()).into()),
    }
}

/// True if the station runs, but this process cannot see its lock.
fn is_lock_unseen(station: &str, lock: &Path) -> Result<bool, Problem> {
    let station = Station::new(station)?;
    // A station that starts takes its name first, and its lock a moment later.
    for _ in 0..LOCK_LOOKS {
        if is_held(lock) || !station.is_claimed() {
            return Ok(false);
        }
        std::thread::sleep(LOCK_PAUSE);
    }
    Ok(true)
}

fn unseen_lock(station: &str, folder: &Path) -> String {
    format!(
        "station '{station}' runs, but its files are not in {}. Either it was started with another \
         TMPDIR: give this program the same one. Or a clean-up (systemd-tmpfiles) removed them: \
         restart the station",
        folder.display()
    )
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
            let _ = std::fs::remove_file(self.path.join(SCENE_NAME_FILE));
        }
        let _ = std::fs::remove_file(self.scene());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_holder_of_a_station_s_name_is_named_with_process_and_user() {
        use std::os::linux::net::SocketAddrExt as _;
        use std::os::unix::net::{SocketAddr, UnixListener};
        let name = format!("held-{}", std::process::id());
        let user = rustix::process::geteuid().as_raw();
        let address = SocketAddr::from_abstract_name(format!("calot-{user}-{name}")).unwrap();
        let _stranger = UnixListener::bind_addr(&address).unwrap();
        let error = Folder::open(&name, false).err().expect("the name is taken");
        let process = std::process::id();
        let words = format!("(process {process}) of {}; show it", owner(user));
        assert!(error.to_string().contains(&words), "{error}");
    }

    #[test]
    fn the_holder_of_the_lock_is_named_or_reported_as_unseen() {
        let folder = tempfile::tempdir().unwrap();
        let lock = std::fs::File::create(folder.path().join("lock")).unwrap();
        let seen = in_words(&holders(&folder.path().join("lock")));
        assert!(
            seen.contains(&format!("(process {})", std::process::id())),
            "{seen}"
        );
        drop(lock);
        let unseen = in_words(&holders(&folder.path().join("lock")));
        assert!(unseen.contains("another account's"), "{unseen}");
    }
}
