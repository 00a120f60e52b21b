//! Members of a station. Each shows its presence by an abstract Unix socket. Such a socket needs no
//! file that a clean-up could remove, and the kernel closes it when its process ends. A process in
//! another network namespace does not see the socket. So each member also keeps a locked file in
//! /dev/shm.

use std::fs::File;
use std::io::{Error, ErrorKind};
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixListener};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::fs::{AtFlags, CWD, FlockOperation, Mode, OFlags};
use rustix::io::Errno;

use super::memory;

/// Longest wait for the turn: the lock that an end holds while it joins or leaves. That takes
/// milliseconds, unless its process is stopped.
const TURN_TIMEOUT: Duration = Duration::from_secs(5);
/// Largest number of numbered names that a process tries. Each end of the process takes one name.
const ENDS_MAX: u32 = 1000;

/// A name that this process holds by an abstract socket, until it ends or drops this value.
#[derive(Debug)]
pub(super) struct HeldName {
    name: String,
    _socket: UnixListener,
}

impl HeldName {
    /// Takes a name; `None` if it is already held.
    pub(super) fn take(name: String) -> Result<Option<Self>, Error> {
        let address = SocketAddr::from_abstract_name(&name)?;
        match UnixListener::bind_addr(&address) {
            Ok(socket) => Ok(Some(Self {
                name,
                _socket: socket,
            })),
            Err(error) if error.kind() == ErrorKind::AddrInUse => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn take_numbered(stem: &str) -> Option<Self> {
        let process = std::process::id();
        (0..ENDS_MAX).find_map(|n| Self::take(format!("{stem}.{process}.{n}")).ok().flatten())
    }
}

/// All held names that begin with `stem`; `None` if the kernel's table cannot be read.
pub(super) fn held(stem: &str) -> Option<Vec<String>> {
    let table = table()?;
    let names = rows(&table).map(|(_, name)| name);
    let of_stem = names.filter(|name| name.starts_with(stem));
    Some(of_stem.map(str::to_owned).collect())
}

/// Inode of the socket that holds this name, if the kernel's table has it.
pub(super) fn inode(name: &str) -> Option<u64> {
    let table = table()?;
    let (row, _) = rows(&table).find(|(_, it)| *it == name)?;
    row.split_whitespace().last()?.parse().ok()
}

/// The kernel's table of Unix sockets.
fn table() -> Option<String> {
    let table = std::fs::read("/proc/net/unix").ok()?;
    Some(String::from_utf8_lossy(&table).into_owned())
}

/// Rows of the table that have an abstract name. Each row is split into the columns before the name
/// and the name. The last of these columns is the inode.
fn rows(table: &str) -> impl Iterator<Item = (&str, &str)> {
    table.lines().filter_map(|line| line.split_once(" @"))
}

/// Waits for the turn to join or leave. Only one end of a station holds it at a time. `None` if the
/// wait is longer than [`TURN_TIMEOUT`] or abstract sockets do not work.
pub(super) fn turn(base: &str) -> Option<HeldName> {
    let start = Instant::now();
    while start.elapsed() < TURN_TIMEOUT {
        match HeldName::take(format!("{base}.turn")) {
            Ok(Some(turn)) => return Some(turn),
            Ok(None) => std::thread::sleep(Duration::from_millis(2)),
            Err(_) => return None,
        }
    }
    None
}

/// A file in /dev/shm that shows an end's presence: it stays locked until its process ends or drops
/// this value.
#[derive(Debug)]
struct PresenceFile {
    path: PathBuf,
    _locked: File,
}

impl PresenceFile {
    /// Makes the file. It is locked before it gets its name, so that no other process mistakes it
    /// for a file of a dead process.
    fn set(stem: &str) -> Option<Self> {
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        let file = rustix::fs::open(memory::SHARED, flags, Mode::RUSR | Mode::WUSR).ok()?;
        rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).ok()?;
        let file = File::from(file);
        let from = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&file));
        let process = std::process::id();
        for n in 0..ENDS_MAX {
            let path = Path::new(memory::SHARED).join(format!("{stem}.{process}.{n}"));
            match rustix::fs::linkat(CWD, &*from, CWD, &path, AtFlags::SYMLINK_FOLLOW) {
                Ok(()) => {
                    let _locked = file;
                    return Some(Self { path, _locked });
                }
                Err(Errno::EXIST) => {}
                Err(_) => return None,
            }
        }
        None
    }

    /// True if a living process holds this file. True also if opening or locking it fails for
    /// another reason, because a doubtful file must not be removed. False if the file can be
    /// locked, is gone, or is a link.
    fn is_held(path: &Path) -> bool {
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = match rustix::fs::open(path, flags, Mode::empty()) {
            Ok(file) => file,
            Err(error) => return !matches!(error, Errno::NOENT | Errno::LOOP),
        };
        rustix::fs::flock(&file, FlockOperation::NonBlockingLockShared).is_err()
    }
}

impl Drop for PresenceFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Presence of one end in a station.
#[derive(Debug)]
pub(super) struct Presence {
    base: String,
    name: Option<HeldName>,
    file: Option<PresenceFile>,
}

impl Presence {
    /// Shows that this end is present, before it opens a service.
    pub(super) fn enter(base: &str) -> Self {
        Self {
            base: base.to_owned(),
            name: HeldName::take_numbered(&format!("{base}.here")),
            file: PresenceFile::set(&format!("{base}.here")),
        }
    }

    /// True if certainly no other end is present. False also if this end has no name of its own or
    /// the kernel's table cannot be read.
    pub(super) fn is_alone(&self) -> bool {
        let own = self.name.as_ref().map(|it| &it.name);
        own.is_some()
            && held(&format!("{}.here.", self.base))
                .is_some_and(|all| all.iter().all(|name| Some(name) == own))
            && self
                .other_files()
                .iter()
                .all(|path| !PresenceFile::is_held(path))
    }

    fn other_files(&self) -> Vec<PathBuf> {
        let own = self.file.as_ref().map(|it| &it.path);
        let mut all = memory::files(Path::new(memory::SHARED), &format!("{}.here.", self.base));
        all.retain(|path| Some(path) != own);
        all
    }

    /// Removes the presence files of dead members. Only a member that is alone may call this
    /// method.
    pub(super) fn remove_dead(&self) {
        for path in self.other_files() {
            let _ = std::fs::remove_file(path);
        }
    }

    /// Shows that this end has the services open.
    pub(super) fn show_open(&self) -> Option<HeldName> {
        HeldName::take_numbered(&format!("{}.open", self.base))
    }

    /// Processes that have the services open.
    pub(super) fn open_processes(&self) -> Vec<u32> {
        let stem = format!("{}.open.", self.base);
        let names = held(&stem).unwrap_or_default();
        let process = |name: &String| {
            let rest = name.strip_prefix(&stem)?;
            rest.split('.').next()?.parse::<u32>().ok()
        };
        let mut processes: Vec<u32> = names.iter().filter_map(process).collect();
        processes.sort_unstable();
        processes.dedup();
        processes
    }

    /// Leaves the station. Runs `last` if this end gets the turn and no other end is present.
    pub(super) fn leave(&mut self, last: impl FnOnce()) {
        let turn = turn(&self.base);
        if turn.is_some() && self.is_alone() {
            self.remove_dead();
            last();
        }
        self.name = None;
        self.file = None;
    }
}
