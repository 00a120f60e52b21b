//! Fixtures shared by the system tests: the real program, its JSON, virtual screens, and a disk
//! that fails.

pub mod compositor;
pub mod disk;
pub mod documents;
pub mod lrs;
pub mod postgres;
mod program;
pub mod reader;
pub mod screen;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

pub use program::Program;

/// Time after which a test gives up waiting. It is generous because it is no performance limit.
pub const PATIENCE: Duration = Duration::from_secs(600);

/// Root folder of the workspace.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Command for the `calot` program, which cargo built next to this test.
#[must_use]
pub fn calot() -> Command {
    let mut command = Command::new(built().join("calot"));
    command.current_dir(root()).stdin(Stdio::null());
    // Runs share a cache, so that they prepare each scene once.
    command.env("XDG_CACHE_HOME", built().join("cache"));
    // The program uses neither the settings of the person who runs the tests nor those of another
    // test.
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let own = format!("settings-{}-{count}", std::process::id());
    command.env("XDG_CONFIG_HOME", std::env::temp_dir().join(own));
    command
}

/// Folder into which cargo built the programs.
fn built() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows its own path");
    let folder = test.ancestors().nth(2);
    folder.expect("target/PROFILE/deps/test").to_owned()
}

/// Waits until no other large test of this test program runs. While the guard is held, other large
/// tests wait; small ones may still run.
pub fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Compiles a recipe, with this number of spheres if given, and returns the file. Each test program
/// prepares a recipe once.
///
/// # Panics
///
/// If the recipe cannot be prepared.
#[must_use]
pub fn compiled(recipe: &str, spheres: Option<u32>) -> String {
    static MADE: Mutex<BTreeMap<String, String>> = Mutex::new(BTreeMap::new());
    let name = spheres.map_or_else(|| recipe.to_owned(), |count| format!("{recipe}-{count}"));
    // One test prepares at a time; the others wait for the result.
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(path) = made.get(&name) {
        return path.clone();
    }
    let folder = built().join("cache");
    std::fs::create_dir_all(&folder).expect("a folder in target");
    let begun = folder.join(format!("{name}-{}.calot", std::process::id()));
    let path = folder.join(format!("{name}.calot"));
    let mut command = calot();
    command.args(["prepare", recipe, "--out"]).arg(&begun);
    if let Some(count) = spheres {
        command.args(["--spheres", &count.to_string()]);
    }
    let output = finish(&mut command);
    assert!(output.status.success(), "{}", said(&output));
    // Another program may be reading an older file of this name: after the rename it still reads
    // the old one.
    std::fs::rename(&begun, &path).expect("it was written");
    let path = path.to_str().expect("a path in UTF-8").to_owned();
    made.insert(name, path.clone());
    path
}

/// Returns a station name that no other test uses.
#[must_use]
pub fn station_name(test: &str) -> String {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    format!("test-{}-{count}-{test}", std::process::id())
}

/// Runs a command to its end.
///
/// # Panics
///
/// If the command does not end within [`PATIENCE`]; then it is killed, and its output is shown.
/// Also if it was asked for JSON and its output does not follow the schemas.
#[track_caller]
pub fn finish(command: &mut Command) -> Output {
    Program::start(command).finish()
}

/// Page faults that a test tolerates: 16 if the kernel may move locked pages to form larger free
/// blocks, else 0.
#[must_use]
pub fn moved_pages_max() -> u64 {
    let allowed = std::fs::read_to_string("/proc/sys/vm/compact_unevictable_allowed");
    if allowed.is_ok_and(|it| it.trim() != "0") {
        16
    } else {
        0
    }
}

/// Standard error as text.
#[must_use]
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Reads the `summary.json` of a run.
///
/// # Panics
///
/// If the file is missing, is not JSON or does not follow its schema.
#[must_use]
#[track_caller]
pub fn summary(folder: &Path) -> serde_json::Value {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).expect("summary.json is there");
    let summary = serde_json::from_str(&text).expect("summary.json is JSON");
    documents::check(&summary);
    summary
}

/// Waits until `holds` returns true.
///
/// # Panics
///
/// If it does not do so within [`PATIENCE`].
#[track_caller]
pub fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Processes whose command line contains all of `words`.
#[must_use]
pub fn processes(words: &[&str]) -> Vec<u32> {
    let entries = std::fs::read_dir("/proc").expect("/proc is there");
    entries
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter(|pid: &u32| {
            let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            let line: Vec<&str> = line
                .split(|&b| b == 0)
                .filter_map(|w| core::str::from_utf8(w).ok())
                .collect();
            words.iter().all(|word| line.contains(word))
        })
        .collect()
}

/// Sends a signal to a process.
pub fn signal(pid: u32, signal: rustix::process::Signal) {
    if let Some(pid) = rustix::process::Pid::from_raw(pid.cast_signed()) {
        let _ = rustix::process::kill_process(pid, signal);
    }
}

/// Folder of the real anatomy, which is not part of the repository: `CALOT_ANATOMY` if it is set,
/// else `shared/anatomy` beside the checkout. `None` if that folder has no `hra-female`.
#[must_use]
pub fn anatomy() -> Option<PathBuf> {
    let named = std::env::var_os("CALOT_ANATOMY").map(PathBuf::from);
    let beside = root().join("../shared/anatomy");
    named
        .or(Some(beside))
        .filter(|folder| folder.join("hra-female").is_dir())
}

/// True for root, and for a user whose limits permit realtime scheduling.
#[must_use]
pub fn may_be_realtime() -> bool {
    use rustix::process::{Resource, getrlimit, getuid};
    getuid().is_root() || getrlimit(Resource::Rtprio).current != Some(0)
}
