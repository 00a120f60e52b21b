//! Errors of a station's services.

use std::path::PathBuf;

/// An error of a station's services.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The station's name is not 1 to 40 characters of a-z, A-Z, 0-9, `-` and `_`.
    #[error(
        "station name '{0}' cannot be used: allowed are 1 to 40 characters of a-z, A-Z, 0-9, \
         '-' and '_'"
    )]
    StationName(String),
    /// Another process controls this station.
    #[error(
        "station '{0}' already has a controller; stop it (its `calot run` or `calot rt`), or \
         choose another name with --station"
    )]
    SecondController(String),
    /// Another display controls the emulated hand.
    #[error("station '{0}': another display has the instrument in hand; let go of it there (M)")]
    SecondHand(String),
    /// Another host publishes the state of this station's task.
    #[error("station '{0}': another `calot run` assesses its task; end it first")]
    SecondTask(String),
    /// Another host answers the instructors of this station.
    #[error("station '{0}': another `calot run` answers its instructors; end it first")]
    SecondDesk(String),
    /// A process of another version has opened the service with another layout of its messages.
    #[error("station '{station}', service '{service}': a process of another version runs; end it")]
    OtherVersion {
        /// Station.
        station: String,
        /// Service.
        service: &'static str,
    },
    /// The folder of the user's stations cannot be trusted.
    #[error("{path}: {problem}; remove it, or name another temporary folder with TMPDIR")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The folder's problem.
        problem: String,
    },
    /// Shared memory is too small, or nearly full.
    #[error(
        "station '{station}' needs {} of shared memory, but /dev/shm has {} free; free some, or make \
         it larger: `mount -o remount,size=256m /dev/shm`, docker: `--shm-size=256m`",
        words(.need), words(.free)
    )]
    NoRoom {
        /// Station.
        station: String,
        /// Bytes that the end needs.
        need: u64,
        /// Free bytes in /dev/shm.
        free: u64,
    },
    /// This process's limit on the size of a file is too low for the shared memory.
    #[error(
        "station '{station}' needs shared memory in files of {}, but this process may write files \
         of {} only; raise the limit (`ulimit -f`, RLIMIT_FSIZE, `prlimit --fsize`)",
        words(.need), words(.limit)
    )]
    FileSize {
        /// Station.
        station: String,
        /// Bytes of the largest file.
        need: u64,
        /// Limit of the process, bytes.
        limit: u64,
    },
    /// The folder of the shared memory cannot be used.
    #[error("station '{station}': shared memory, /dev/shm: {problem}")]
    SharedMemory {
        /// Station.
        station: String,
        /// The folder's problem, and the remedy.
        problem: String,
    },
    /// The station is in use, but this process does not find the station's files.
    #[error(
        "station '{station}' runs (process {processes}), but its files are gone from {place}: {why}"
    )]
    Gone {
        /// Station.
        station: String,
        /// Processes that have it open.
        processes: String,
        /// The folder in which this process searches.
        place: String,
        /// Likely causes.
        why: &'static str,
    },
    /// A file of the station belongs to another user.
    #[error(
        "station '{station}': {file} belongs to {owner}; have it removed by {owner}, or choose \
         another name with --station"
    )]
    Foreign {
        /// Station.
        station: String,
        /// The file.
        file: PathBuf,
        /// Its owner.
        owner: String,
    },
    /// A service of the station already has as many readers as it admits.
    #[error("station '{station}' has {max} {what} already; close one")]
    ManyHosts {
        /// Station.
        station: String,
        /// Largest number of such readers at once.
        max: usize,
        /// Kind of readers: recorders, or all readers.
        what: &'static str,
    },
    /// Another process runs the station.
    #[error(
        "station '{station}' runs already, held by {by}; show it with `calot run --attach`, or choose \
         another name with --station"
    )]
    RunsAlready {
        /// Station.
        station: String,
        /// The program that runs the station, in words.
        by: String,
    },
    /// iceoryx2 refused a step.
    #[error(
        "station '{station}', {doing}: {detail}; its files are {files}; end all programs of the \
         station, and start it again"
    )]
    Transport {
        /// Station.
        station: String,
        /// The step that failed.
        doing: &'static str,
        /// iceoryx2's own words.
        detail: String,
        /// File-name patterns of the station's files.
        files: String,
    },
    /// No controller answered a command, or no [`super::ActDesk`] answered an act.
    #[error("station '{station}': nobody answered within {waited_ms} ms")]
    NoAnswer {
        /// Station.
        station: String,
        /// Time waited, ms.
        waited_ms: u128,
    },
}

/// An amount of memory in words.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the messages' fields come as references"
)]
fn words(&bytes: &u64) -> String {
    match bytes {
        ..100_000 => format!("{} kB", bytes / 1000),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}
