//! Finds the programs that have a file or a socket open, so that a person knows which one to stop.

use core::fmt;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

/// Largest number of programs that a search returns: enough for a message.
const HOLDERS_MAX: usize = 3;

/// A program that has a file or a socket open, displayed as "calot (process 4711)".
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Name from `/proc/PID/comm`: at most 15 bytes, chosen by the program, without control
    /// characters.
    pub command: String,
    /// Id of its process.
    pub process: u32,
    /// Id of the user who owns the process.
    pub user: u32,
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (process {})", self.command, self.process)
    }
}

/// Programs that have the file `path` open, up to three. Empty if there is no such file, or if no
/// such program is visible: only root sees the programs of other users.
#[must_use]
pub fn holders(path: &Path) -> Vec<Holder> {
    path.canonicalize()
        .map_or_else(|_| Vec::new(), |path| find_holders(&path))
}

/// Like [`holders`], for the socket with this inode.
#[must_use]
pub fn socket_holders(inode: u64) -> Vec<Holder> {
    find_holders(Path::new(&format!("socket:[{inode}]")))
}

/// Programs with a file descriptor that points to `target`, as `/proc/PID/fd/N` shows it.
fn find_holders(target: &Path) -> Vec<Holder> {
    let programs = fs::read_dir("/proc").into_iter().flatten().flatten();
    programs
        .map(|program| program.path())
        .filter(|program| has_open(program, target))
        .filter_map(|program| holder(&program))
        .take(HOLDERS_MAX)
        .collect()
}

fn holder(program: &Path) -> Option<Holder> {
    let name = fs::read_to_string(program.join("comm")).ok()?;
    Some(Holder {
        // Control characters would garble a terminal.
        command: name.chars().filter(|it| !it.is_control()).collect(),
        process: program.file_name()?.to_str()?.parse().ok()?,
        user: fs::metadata(program).ok()?.uid(),
    })
}

fn has_open(program: &Path, link: &Path) -> bool {
    fs::read_dir(program.join("fd")).is_ok_and(|files| {
        files
            .flatten()
            .any(|file| fs::read_link(file.path()).is_ok_and(|it| it == link))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixListener;

    #[test]
    fn the_holder_of_a_socket_is_this_program_until_it_is_closed() {
        let folder = tempfile::tempdir().unwrap();
        let socket = UnixListener::bind(folder.path().join("s")).unwrap();
        let own = fs::metadata("/proc/self").unwrap().uid();
        let inode = {
            use std::os::fd::AsRawFd as _;
            let link = fs::read_link(format!("/proc/self/fd/{}", socket.as_raw_fd())).unwrap();
            let link = link.to_str().unwrap().to_owned();
            let number = link.trim_start_matches("socket:[").trim_end_matches(']');
            number.parse().unwrap()
        };
        let [found] = &socket_holders(inode)[..] else {
            panic!("one program has it");
        };
        assert_eq!((found.process, found.user), (std::process::id(), own));
        let words = format!("{} (process {})", found.command, std::process::id());
        assert_eq!(found.to_string(), words);
        drop(socket);
        assert_eq!(socket_holders(inode), []);
    }
}
