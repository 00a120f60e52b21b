//! A scripted surgeon that operates at a running station through shared memory.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use assess::Task;
use rt_process::time_driver::monotonic_ns;
use session::Sight;
use shared_mem::message::{CommandMsg, HandMsg};
use shared_mem::scene::SceneFile;
use shared_mem::service::{HandSender, Host, Station};
use surgeon::{Seen, Surgeon, Theatre, operate};

use crate::problem::Problem;
use crate::say;

/// Interval at which the surgeon looks and moves.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// Longest wait for the answer to a command.
const PATIENCE: Duration = Duration::from_secs(8);

/// A surgeon at work.
pub(crate) struct AtWork {
    thread: JoinHandle<Result<(), String>>,
    stop: Arc<AtomicBool>,
}

impl AtWork {
    /// Starts the surgeon's thread, which waits for the controller's first state. The surgeon may
    /// take an angled endoscope if `sight` is given; in a window the endoscope is the window's.
    pub(crate) fn begin(
        surgeon: Surgeon,
        task: Task,
        station: &Station,
        scene: SceneFile,
        sight: Option<Sight>,
    ) -> Result<Self, Problem> {
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, station) = (stop.clone(), station.clone());
        let thread = Builder::new()
            .name("calot-surgeon".to_owned())
            .spawn(move || {
                operate(
                    surgeon,
                    task,
                    scene,
                    &mut Processes::new(&station, stopped, sight)?,
                )
            })
            .map_err(|error| format!("cannot start the surgeon's thread: {error}"))?;
        Ok(Self { thread, stop })
    }

    /// Ends the work. Returns the reason if the surgeon gave up.
    pub(crate) fn end(self) -> Option<String> {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.join() {
            Ok(outcome) => outcome.err(),
            Err(_) => Some("it panicked; please report this".to_owned()),
        }
    }
}

/// The station, as the surgeon sees and moves it through shared memory.
struct Processes {
    host: Host,
    hand: HandSender,
    looked: Instant,
    began_ns: u64,
    stop: Arc<AtomicBool>,
    sight: Option<Sight>,
}

impl Processes {
    fn new(station: &Station, stop: Arc<AtomicBool>, sight: Option<Sight>) -> Result<Self, String> {
        let text = |error: shared_mem::service::ServiceError| error.to_string();
        Ok(Self {
            host: Host::open(station).map_err(text)?,
            hand: HandSender::open(station).map_err(text)?,
            looked: Instant::now(),
            began_ns: monotonic_ns(),
            stop,
            sight,
        })
    }
}

impl Theatre for Processes {
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool {
        self.hand.send(HandMsg {
            at_ns: monotonic_ns(),
            began_ns: self.began_ns,
            ..*asked
        });
        std::thread::sleep(LOOK_EVERY);
        let before = seen.tools.tick;
        self.host.newest_state(&mut seen.state);
        self.host.newest_tools(&mut seen.tools);
        // Count simulated time, because a controller that misses ticks lags behind the clock: hands
        // that followed the clock would run ahead of the simulation.
        let waited_s = self.looked.elapsed().as_secs_f64();
        self.looked = Instant::now();
        seen.at_s += match before {
            0 => waited_s,
            before => seen.tools.tick.saturating_sub(before) as f64 * 1e-3,
        };
        let events = &mut seen.events;
        self.host.drain_events(|event| events.push(*event));
        !self.stop.load(Ordering::Relaxed)
    }

    fn command(&mut self, command: CommandMsg) -> Result<(), String> {
        let sent = self.host.command(command, PATIENCE);
        sent.map(|_| ()).map_err(|error| error.to_string())
    }

    fn look_off(&mut self, sight_rad: [f32; 2]) -> bool {
        if let Some(sight) = &self.sight {
            sight.tell(sight_rad);
        }
        self.sight.is_some()
    }

    fn tell(&mut self, what: &str) {
        say::note(format_args!("calot: the surgeon: {what}"));
    }
}
