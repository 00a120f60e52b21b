//! Free space in shared memory. If no page of /dev/shm is left, the first write to a new page ends
//! the process (SIGBUS). So all pages are allocated before they are used.

use std::fs::File;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, Mode, OFlags};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

use super::folder;

/// Folder of POSIX shared memory in Linux.
pub(super) const SHARED: &str = "/dev/shm";

/// Reason why memory could not be reserved.
#[derive(Debug)]
pub(super) enum MemoryError {
    /// Bytes that are needed, and bytes that are free.
    Room { need: u64, free: u64 },
    /// Bytes of the largest file, and this process's limit on the size of a file.
    FileSize { need: u64, limit: u64 },
    /// The folder's problem, with the remedy.
    Folder(String),
}

/// Memory that is reserved until this value is dropped.
#[derive(Debug)]
pub(super) struct Reservation {
    _files: Vec<File>,
}

/// Free bytes in shared memory.
fn free() -> u64 {
    rustix::fs::statvfs(SHARED).map_or(0, |it| it.f_bavail.saturating_mul(it.f_frsize))
}

/// Reserves memory for files of these sizes, bytes.
pub(super) fn reserve(prefix: &str, sizes: &[u64]) -> Result<Reservation, MemoryError> {
    let largest = sizes.iter().copied().max().unwrap_or(0);
    if let Some(limit) = getrlimit(Resource::Fsize).current
        && limit < largest
    {
        return Err(MemoryError::FileSize {
            need: largest,
            limit,
        });
    }
    let need: u64 = sizes.iter().sum();
    let mut files = Vec::new();
    // Free bytes before anything is reserved. If the file system cannot reserve pages, only this
    // number decides.
    let free_before = free();
    for (n, &size) in sizes.iter().enumerate() {
        let path = format!("{SHARED}/{prefix}room.{}.{n}", std::process::id());
        let _ = std::fs::remove_file(&path); // left by a killed process with the same id
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL | OFlags::CLOEXEC;
        let file = rustix::fs::open(&path, flags, Mode::RUSR | Mode::WUSR)
            .map_err(|error| match error {
                Errno::NOSPC => MemoryError::Room {
                    need,
                    free: free_before,
                },
                _ => MemoryError::Folder(problem(error)),
            })
            .map(File::from)?;
        // The file needs no name: it keeps its pages while it is open.
        let _ = std::fs::remove_file(&path);
        match rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, size) {
            Err(Errno::NOSPC | Errno::NOMEM | Errno::DQUOT) => {
                return Err(MemoryError::Room {
                    need,
                    free: free_before,
                });
            }
            Err(Errno::OPNOTSUPP) if free_before < need => {
                return Err(MemoryError::Room {
                    need,
                    free: free_before,
                });
            }
            Ok(()) | Err(Errno::OPNOTSUPP) => files.push(file),
            Err(error) => return Err(MemoryError::Folder(problem(error))),
        }
    }
    Ok(Reservation { _files: files })
}

fn problem(error: Errno) -> String {
    let remedy = match error {
        Errno::NOENT | Errno::NOTDIR => {
            "there is no such folder; mount it: `mount -t tmpfs -o mode=1777 shm /dev/shm`"
        }
        Errno::ROFS => "it is mounted read-only; `mount -o remount,rw /dev/shm`",
        Errno::ACCESS | Errno::PERM => {
            "this user may not write there; set the usual mode: `chmod 1777 /dev/shm`"
        }
        _ => return error.to_string(),
    };
    remedy.to_owned()
}

/// Files of any owner in a folder whose names begin with `prefix`.
pub(super) fn files(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let named = entries.filter(|it| it.file_name().to_string_lossy().starts_with(prefix));
    named.map(|it| it.path()).collect()
}

/// Allocates every page of this user's files whose names begin with `prefix`.
pub(super) fn fill(prefix: &str) -> Result<(), MemoryError> {
    for path in files(Path::new(SHARED), prefix) {
        let flags = OFlags::WRONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        // A file may disappear after it was listed. A link that another user put there is not
        // followed.
        let Ok(file) = rustix::fs::open(&path, flags, Mode::empty()).map(File::from) else {
            continue;
        };
        let Ok(meta) = file.metadata() else { continue };
        if !meta.is_file() || meta.uid() != folder::user() || meta.len() == 0 {
            continue;
        }
        let taken = rustix::fs::fallocate(&file, FallocateFlags::KEEP_SIZE, 0, meta.len());
        // Any other error means that the file system allocates a page only when it is used.
        if let Err(Errno::NOSPC | Errno::NOMEM | Errno::DQUOT) = taken {
            let need = meta.len();
            return Err(MemoryError::Room { need, free: free() });
        }
    }
    Ok(())
}

/// Removes all files and folders whose names begin with `prefix` from shared memory and from
/// iceoryx2's folders below `root`.
pub(super) fn remove_files(root: &Path, prefix: &str) {
    for path in files(Path::new(SHARED), prefix) {
        let _ = std::fs::remove_file(path);
    }
    for folder in ["nodes", "services"].map(|name| root.join(name)) {
        for path in files(&folder, prefix) {
            let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
        }
    }
}
