//! Work that competes with the tick. Each load is a process of its own (`calot load`), ordinary
//! priority, memory not locked, so that it can be killed and takes nothing from the measurement.

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

/// Work that competes with the tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Load {
    /// A thread that computes on each core
    Cpu,
    /// Threads that copy memory and throw everything out of the caches
    Memory,
    /// Files written, synced, read
    Io,
    /// A display that joins, and leaves or is killed, every second
    Join,
    /// The same, and one that draws all the time
    Display,
    /// All of these
    All,
    /// The station is seen from elsewhere (`calot link`): watchers join, stand still, leave and are
    /// killed; not in `all`
    Watch,
}

impl Load {
    /// Those meant, each once.
    pub(crate) fn each(asked: &[Self]) -> Vec<Self> {
        let mut each = match asked.contains(&Self::All) {
            true => vec![Self::Cpu, Self::Memory, Self::Io, Self::Display],
            false => asked.to_vec(),
        };
        each.sort();
        each.dedup();
        each
    }

    /// As it is typed.
    pub(crate) fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// `calot load`: one load, until told to end.
#[derive(Debug, Clone, Args)]
pub(crate) struct LoadArgs {
    /// Which
    #[arg(value_name = "LOAD")]
    pub(crate) load: Load,
    /// Where files are written, or the station that is joined
    #[arg(value_name = "DIR|STATION")]
    pub(crate) place: String,
    /// End when this process, which started this one, ends
    #[arg(long, value_name = "PID")]
    pub(crate) with_parent: Option<i32>,
}

/// More than any cache holds.
const COPY_BYTES: usize = 64 << 20;
/// Written and synced at a time.
const FILE_BYTES: usize = 4 << 20;
/// How long a display that is killed lives.
const DISPLAY_LIFE: Duration = Duration::from_secs(1);

/// How long a watcher works before it leaves or stalls: it has to connect first.
const WATCHER_LIFE: Duration = Duration::from_secs(2);

/// How long a load may take to end.
const PATIENCE: Duration = Duration::from_secs(1);

/// Body of `calot load`.
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
        Load::Display => return Err("it joins, too: name join".into()),
        Load::Watch => watch(&args.place, &stop)?,
        Load::All => return Err("one load a process: name one".into()),
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
    // Gone when this process is, however it ends.
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

/// A display that reads whatever there is, until it is killed.
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

/// Serves the station on this computer, to watchers that join and, one after the other, are asked
/// to leave, stand still until they are killed, and are killed at work.
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

/// Loads that run; they end when this is dropped.
#[derive(Debug)]
pub(crate) struct Loads {
    children: Vec<Child>,
    /// Joins and kills displays.
    churn: Option<(Arc<AtomicBool>, JoinHandle<u64>)>,
}

impl Loads {
    /// Starts them. `folder`: where files may be written.
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
                let thread = std::thread::spawn(move || join_and_kill(&station, &flag));
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

    /// The first that ended by itself, if one did: the load is not what was asked for.
    pub(crate) fn died(&mut self) -> Option<String> {
        let ended = self.children.iter_mut().find_map(|c| c.try_wait().ok()?);
        ended.map(|status| format!("a load ended by itself ({status})"))
    }

    /// Ends them; how many displays joined and were killed.
    pub(crate) fn end(mut self) -> u64 {
        let churn = self.churn.take().map(|(stop, thread)| {
            stop.store(true, Ordering::Relaxed);
            thread.join().unwrap_or(0)
        });
        churn.unwrap_or(0)
    }
}

impl Drop for Loads {
    fn drop(&mut self) {
        if let Some((stop, _)) = &self.churn {
            stop.store(true, Ordering::Relaxed);
        }
        // Asked first: one may have children of its own.
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
    // It gets a signal when the thread that starts it ends: each here outlives what it starts.
    let parent = std::process::id().to_string();
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["load", &load.name(), place, "--with-parent", &parent]);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    if matches!(load, Load::Join | Load::Watch) {
        // A controller that goes between two rounds is nothing to complain of.
        command.stderr(Stdio::null());
    }
    Ok(command.spawn()?)
}

/// Displays, one after the other, each killed in mid-life. Every third is asked to leave instead.
fn join_and_kill(station: &str, stop: &AtomicBool) -> u64 {
    let mut joined = 0;
    while !stop.load(Ordering::Relaxed) {
        let Ok(mut display) = spawn(Load::Join, station) else {
            break;
        };
        joined += 1;
        let start = Instant::now();
        while start.elapsed() < DISPLAY_LIFE && !stop.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(10));
        }
        let leaves = joined % 3 == 0;
        if leaves && let Some(pid) = rustix::process::Pid::from_raw(display.id().cast_signed()) {
            let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
            std::thread::sleep(Duration::from_millis(50));
        }
        let _ = display.kill();
        let _ = display.wait();
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

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
