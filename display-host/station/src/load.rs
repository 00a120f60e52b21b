//! Work that competes with the tick. Each load is a process of its own (`calot load`), so that it
//! can be killed without effect on the process that measures. It has ordinary priority and no
//! locked memory.

use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use shared_mem::service::{Host, Station};

use crate::problem::Problem;
use crate::stop;

/// Kind of work that competes with the tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Load {
    /// Computes on each core
    Cpu,
    /// Copies memory to flush the caches
    Memory,
    /// Writes, syncs and reads files
    Io,
    /// A display joins every second; it then leaves or is killed
    Join,
    /// Join, and one display that draws all the time
    Display,
    /// All of the above
    All,
    /// Watchers on `calot link` join, stall, leave and are killed; not part of all
    Watch,
}

impl Load {
    /// The loads asked for, each once.
    pub(crate) fn each(asked: &[Self]) -> Vec<Self> {
        let mut each = match asked.contains(&Self::All) {
            true => vec![Self::Cpu, Self::Memory, Self::Io, Self::Display],
            false => asked.to_vec(),
        };
        each.sort();
        each.dedup();
        each
    }

    /// Name as typed.
    pub(crate) fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// Options of `calot load`, which runs one load until it is asked to end.
#[derive(Debug, Clone, Args)]
pub(crate) struct LoadArgs {
    /// Load to run
    #[arg(value_name = "LOAD")]
    pub(crate) load: Load,
    /// Folder for files, or name of the station to join
    #[arg(value_name = "DIR|STATION")]
    pub(crate) place: String,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}

/// Size of one copy, larger than usual caches.
const COPY_BYTES: usize = 64 << 20;
/// Bytes that are written before each sync.
const FILE_BYTES: usize = 4 << 20;
/// Time after which a display is killed or asked to leave.
const DISPLAY_LIFE: Duration = Duration::from_secs(1);

/// Time after which a watcher is stalled, asked to leave or killed. It is long enough to connect.
const WATCHER_LIFE: Duration = Duration::from_secs(2);

/// Time that a load may take to end.
const PATIENCE: Duration = Duration::from_secs(1);

/// Runs `calot load`.
pub(crate) fn run(args: &LoadArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    match args.load {
        Load::Cpu => on_each_core(&stop, compute),
        Load::Memory => on_each_core(&stop, copy),
        Load::Io => files(Path::new(&args.place), &stop)?,
        Load::Join => join(&args.place, &stop)?,
        Load::Display => return Err("this load also joins; name `join`".into()),
        Load::Watch => watch(&args.place, &stop)?,
        Load::All => return Err("a process runs one load; name one".into()),
    }
    Ok(ExitCode::SUCCESS)
}

fn on_each_core(stop: &Arc<AtomicBool>, body: fn(&AtomicBool)) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| body(stop));
        }
    });
}

fn compute(stop: &AtomicBool) {
    let mut x = 0.5f64;
    while !stop.load(Ordering::Relaxed) {
        for _ in 0..100_000 {
            x = 3.9 * x * (1.0 - x);
        }
        core::hint::black_box(x);
    }
}

fn copy(stop: &AtomicBool) {
    let (mut from, mut to) = (vec![1u8; COPY_BYTES], vec![0u8; COPY_BYTES]);
    while !stop.load(Ordering::Relaxed) {
        to.copy_from_slice(core::hint::black_box(&from));
        core::mem::swap(&mut from, &mut to);
    }
}

fn files(folder: &Path, stop: &AtomicBool) -> Result<(), Problem> {
    let path = folder.join(format!("load-{}", std::process::id()));
    let failed = |error| format!("{}: {error}", path.display());
    let mut file = std::fs::File::options()
        .create(true)
        .truncate(true)
        .read(true)
        .write(true)
        .open(&path)
        .map_err(failed)?;
    // An unlinked file disappears with this process, however it ends.
    std::fs::remove_file(&path).map_err(failed)?;
    let mut block = vec![0x5au8; FILE_BYTES];
    while !stop.load(Ordering::Relaxed) {
        file.seek(SeekFrom::Start(0)).map_err(failed)?;
        file.write_all(&block).map_err(failed)?;
        file.sync_all().map_err(failed)?;
        file.seek(SeekFrom::Start(0)).map_err(failed)?;
        file.read_exact(&mut block).map_err(failed)?;
    }
    Ok(())
}

/// Reads state, times and events as a display does, until it is asked to end.
fn join(station: &str, stop: &AtomicBool) -> Result<(), Problem> {
    let host = Host::open(&Station::new(station)?)?;
    let mut state = display_frame();
    while !stop.load(Ordering::Relaxed) {
        host.newest_state(&mut state);
        host.drain_timing(|_| ());
        host.drain_events(|_| ());
        std::thread::sleep(Duration::from_millis(4));
    }
    Ok(())
}

/// Serves the station on this computer. Watchers join one after another: some are asked to leave,
/// some stall until they are killed, and some are killed at work.
fn watch(station: &str, stop: &AtomicBool) -> Result<(), Problem> {
    let free = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?;
    let (address, own) = (free.to_string(), std::process::id());
    let link = |words: &[&str]| -> Result<Child, Problem> {
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("link").args(words).arg("--insecure");
        command.args(["--with-parent", &own.to_string()]);
        command.stdin(Stdio::null()).stdout(Stdio::null());
        Ok(command.stderr(Stdio::null()).spawn()?)
    };
    let mut server = link(&["serve", "--station", station, "--listen", &address])?;
    let name = format!("watch-{own}");
    let rest = |time: Duration| {
        let start = Instant::now();
        while start.elapsed() < time && !stop.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(10));
        }
    };
    let mut joined = 0u64;
    while !stop.load(Ordering::Relaxed) && server.try_wait()?.is_none() {
        let mut watcher = link(&["watch", "--connect", &address, "--as", &name])?;
        joined += 1;
        rest(WATCHER_LIFE);
        let signal = match joined % 3 {
            0 => rustix::process::Signal::STOP,
            1 => rustix::process::Signal::TERM,
            _ => rustix::process::Signal::KILL,
        };
        if let Some(pid) = rustix::process::Pid::from_raw(watcher.id().cast_signed()) {
            let _ = rustix::process::kill_process(pid, signal);
        }
        rest(WATCHER_LIFE / 4);
        let _ = watcher.kill();
        let _ = watcher.wait();
    }
    let _ = server.kill();
    let _ = server.wait();
    Ok(())
}

fn display_frame() -> Box<shared_mem::message::StateFrame> {
    bytemuck::allocation::zeroed_box()
}

/// Running loads. They end on drop.
#[derive(Debug)]
pub(crate) struct Loads {
    children: Vec<Child>,
    /// Thread that starts and ends displays, with its stop flag.
    churn: Option<(Arc<AtomicBool>, JoinHandle<Churned>)>,
}

/// Displays that joined one after another.
#[derive(Debug, Default)]
pub(crate) struct Churned {
    /// Number of displays that joined.
    pub(crate) joined: u64,
    /// Reason why no further display joined, if they ended too early.
    pub(crate) problem: Option<String>,
}

impl Loads {
    /// Starts the loads. They may write files to `folder`.
    pub(crate) fn start(loads: &[Load], folder: &Path, station: &str) -> Result<Self, Problem> {
        let mut started = Self {
            children: Vec::new(),
            churn: None,
        };
        for &load in loads {
            if matches!(load, Load::Join | Load::Display) {
                if started.churn.is_some() {
                    continue;
                }
                let stop = Arc::new(AtomicBool::new(false));
                let (flag, station) = (stop.clone(), station.to_owned());
                let thread = std::thread::spawn(move || {
                    join_and_kill(&flag, || spawn(Load::Join, &station))
                });
                started.churn = Some((stop, thread));
            } else {
                let place = match load {
                    Load::Watch => station.to_owned(),
                    _ => folder.to_string_lossy().into_owned(),
                };
                started.children.push(spawn(load, &place)?);
            }
        }
        Ok(started)
    }

    /// Describes the first load that ended by itself, if any. The measured load is then not the
    /// requested one.
    pub(crate) fn died(&mut self) -> Option<String> {
        let ended = self.children.iter_mut().find_map(|c| c.try_wait().ok()?);
        ended.map(|status| format!("a load ended by itself ({status})"))
    }

    /// Ends the loads. Returns how displays joined.
    pub(crate) fn end(mut self) -> Churned {
        let Some((stop, thread)) = self.churn.take() else {
            return Churned::default();
        };
        stop.store(true, Ordering::Relaxed);
        thread.join().unwrap_or_else(|_| Churned {
            joined: 0,
            problem: Some("the thread that lets displays join panicked".to_owned()),
        })
    }
}

impl Drop for Loads {
    fn drop(&mut self) {
        if let Some((stop, _)) = &self.churn {
            stop.store(true, Ordering::Relaxed);
        }
        // Ask before killing, because a load may have children that it must end.
        for child in &self.children {
            if let Some(pid) = rustix::process::Pid::from_raw(child.id().cast_signed()) {
                let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
            }
        }
        let start = Instant::now();
        for child in &mut self.children {
            while matches!(child.try_wait(), Ok(None)) && start.elapsed() < PATIENCE {
                std::thread::sleep(Duration::from_millis(10));
            }
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn spawn(load: Load, place: &str) -> Result<Child, Problem> {
    // With `--with-parent`, the kernel signals a child when the thread that started it ends. All
    // threads that call this outlive their children.
    let parent = std::process::id().to_string();
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["load", &load.name(), place, "--with-parent", &parent]);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    if matches!(load, Load::Join | Load::Watch) {
        // The controller ends between two rounds. These loads then print errors, which are none.
        command.stderr(Stdio::null());
    }
    Ok(command.spawn()?)
}

/// Runs displays, which `join` starts, one after another. Asks every third to leave, and kills the
/// others at work. Ends at the first display that cannot be started.
fn join_and_kill(stop: &AtomicBool, join: impl Fn() -> Result<Child, Problem>) -> Churned {
    let mut churned = Churned::default();
    while !stop.load(Ordering::Relaxed) {
        let mut display = match join() {
            Ok(display) => display,
            Err(problem) => {
                churned.problem = Some(format!(
                    "the load of joining displays ended by itself after {} displays: another one \
                     cannot be started: {problem}",
                    churned.joined
                ));
                break;
            }
        };
        churned.joined += 1;
        let start = Instant::now();
        while start.elapsed() < DISPLAY_LIFE && !stop.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(10));
        }
        let leaves = churned.joined % 3 == 0;
        if leaves && let Some(pid) = rustix::process::Pid::from_raw(display.id().cast_signed()) {
            let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
            std::thread::sleep(Duration::from_millis(50));
        }
        let _ = display.kill();
        let _ = display.wait();
    }
    churned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_display_that_cannot_be_started_is_reported() {
        let left = std::cell::Cell::new(1);
        let churned = join_and_kill(&AtomicBool::new(false), || {
            let program = match left.replace(0) {
                0 => "/nowhere/calot",
                _ => "/bin/true",
            };
            Ok(Command::new(program).spawn()?)
        });
        assert_eq!(churned.joined, 1);
        let said = churned.problem.unwrap_or_default();
        assert!(said.contains("ended by itself after 1 displays"), "{said}");
        assert!(said.contains("No such file"), "{said}");
    }

    #[test]
    fn all_loads_are_each_of_them_once() {
        assert_eq!(Load::each(&[]), []);
        assert_eq!(
            Load::each(&[Load::Io, Load::Cpu, Load::Io]),
            [Load::Cpu, Load::Io]
        );
        assert_eq!(Load::each(&[Load::All, Load::Cpu]).len(), 4);
    }
}
