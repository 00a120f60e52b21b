//! One turn of the station: starts the station, watches it for the time of the turn, and ends it.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use display_host::latency::FrameRecord;
use jitter::misses::Round;
use jitter::tally::Tally;
use jitter::why::Watch;
use jitter::{Report, kernel};
use rt_process::realtime::pin_to;
use rt_process::time_driver::monotonic_ns;
use shared_mem::message::{STAGES, StateFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::{Host, Station};

use super::bench::Bench;
use super::drawing::draw;
use super::line::Line;
use super::save::save;
use super::standing::{note_memory, note_standing, progress};
use super::work::Work;
use crate::children::Process;
use crate::problem::Problem;
use crate::run::player::Player;
use crate::run::processes::{self, Running};

/// Interval at which shared memory is read. It is the resolution of "publish to display".
const LOOK: Duration = Duration::from_millis(1);
/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(2);
/// Interval at which results are written.
const SAVE: Duration = Duration::from_secs(5);
/// The turn fails after this time without timing records.
const PATIENCE: Duration = Duration::from_secs(60);

/// A finished turn of the station.
pub(crate) struct Turn {
    /// Message about the process that died, if one did.
    pub(crate) died: Option<String>,
    /// Durations of the ticks, in order, ns.
    pub(crate) ticks_ns: Vec<u32>,
}

/// Flags shared by the threads of a turn.
#[derive(Debug, Default)]
struct Flags {
    /// The time of the turn is over.
    done: AtomicBool,
    /// The controller has ended; no more data will come.
    over: AtomicBool,
    /// Process of the controller; 0 until it has started.
    process: Arc<AtomicU32>,
    /// Time of each stage in the worst tick of the controller's trial, ns.
    admitted_ns: OnceLock<[u64; STAGES]>,
}

impl Bench<'_> {
    /// Runs one turn of `seconds`.
    pub(crate) fn measure(
        &self,
        seconds: f64,
        round: u32,
        tally: &mut Tally,
        report: &mut Report,
    ) -> Result<Turn, Problem> {
        let flags = Flags::default();
        let mut stolen_ms = None;
        let before_s = report.about.seconds;
        let mut kernel_counts = Vec::new();
        let mut ran = self.scene.to_owned();
        let died = std::thread::scope(|scope| {
            let mut drawing = None;
            let (attached, watcher_attached) = mpsc::channel();
            let (frames_in, frames) = mpsc::channel();
            let watcher = {
                let (flags, tally, report) = (&flags, &mut *tally, &mut *report);
                scope.spawn(move || {
                    self.watch(seconds, tally, report, flags, &attached, &frames)
                        .map_err(|problem| problem.to_string())
                })
            };
            // Wait until the watcher is attached, so that it sees the first tick. If it fails, its
            // error is returned at the end.
            let _ = watcher_attached.recv();
            let started = processes::start(
                self.station,
                match self.hand {
                    Some(_) => Player::Surgeon,
                    None => Player::Script,
                },
                self.scene,
                self.folder,
                self.stop,
            );
            let died = match started {
                Ok(Running {
                    mut children,
                    scene: level,
                    admitted_ns,
                    ..
                }) => {
                    ran.clone_from(&level);
                    if let Some(ns) = admitted_ns {
                        let _ = flags.admitted_ns.set(ns);
                    }
                    let work = Work::begin(self.hand, &self.station.station, &level);
                    if self.draws {
                        let flags = &flags;
                        let draw = move || draw(self, &level, &flags.done, &frames_in);
                        drawing = Some(scope.spawn(draw));
                    }
                    let process = children.last().map(Process::id);
                    flags.process.store(process.unwrap_or(0), Ordering::Relaxed);
                    let start = kernel::Counters::read(self.core, process);
                    let stolen_before_ms = kernel::stolen_ms(self.core);
                    let died = match &work {
                        Ok(_) => self.wait(&flags, &mut children, || watcher.is_finished()),
                        Err(problem) => Some(problem.to_string()),
                    };
                    kernel_counts = kernel::Counters::read(self.core, process).since(&start);
                    let stolen_now_ms = kernel::stolen_ms(self.core);
                    stolen_ms = stolen_now_ms
                        .zip(stolen_before_ms)
                        .map(|(now, then)| now - then);
                    flags.done.store(true, Ordering::Relaxed);
                    if let Ok(work) = work {
                        work.end();
                    }
                    // End all children, the controller first.
                    let problems = children.into_iter().rev().filter_map(Process::end);
                    let problems: Vec<String> = problems.collect();
                    Ok(died.or(problems.into_iter().next()))
                }
                Err(problem) => Err(problem),
            };
            flags.done.store(true, Ordering::Relaxed);
            // The watcher must also get the last frames of the display.
            if let Some(drawing) = drawing {
                let _ = drawing.join();
            }
            flags.over.store(true, Ordering::Relaxed);
            match watcher.join() {
                Ok(Ok(())) => died,
                Ok(Err(problem)) => died.and(Err(problem.into())),
                Err(_) => Err("the thread that measures panicked".into()),
            }
        })?;
        SceneFile::open(&ran)?
            .name()
            .clone_into(&mut report.about.scene);
        for (name, count) in kernel_counts {
            report.count(&name, count);
        }
        let over = tally.end_session(report.about.seconds);
        tally.fill(report);
        let q = over.wake.quantiles();
        report.rounds.push(Round {
            round,
            program: "station".to_owned(),
            p50: q.p50,
            p99: q.p99,
            max: q.max,
            missed: Some(over.missed),
            stolen_ms,
        });
        if report.about.seconds <= before_s && died.is_none() && !self.stop.load(Ordering::Relaxed)
        {
            return Err("the station published no timing; try `calot rt` by hand".into());
        }
        Ok(Turn {
            died,
            ticks_ns: over.ticks_ns,
        })
    }

    /// Waits for the end of the turn. Returns a message if a child dies before.
    fn wait(
        &self,
        flags: &Flags,
        children: &mut [Process],
        watcher_ended: impl Fn() -> bool,
    ) -> Option<String> {
        loop {
            std::thread::sleep(Duration::from_millis(20));
            for child in &mut *children {
                if let Ok(Some(status)) = child.ended() {
                    return Some(format!("the {} process died ({status})", child.name()));
                }
            }
            let stopped = self.stop.load(Ordering::Relaxed);
            if stopped || flags.done.load(Ordering::Relaxed) || watcher_ended() {
                return None;
            }
        }
    }

    /// Reads timing, states and events of the station until the controller has ended. `attached`
    /// reports that all services are open.
    fn watch(
        &self,
        seconds: f64,
        tally: &mut Tally,
        report: &mut Report,
        flags: &Flags,
        attached: &Sender<()>,
        frames: &Receiver<FrameRecord>,
    ) -> Result<(), Problem> {
        if !self.others.is_empty() {
            // Leave the tick's core. If that is refused, the figures show it.
            let _ = pin_to(&self.others);
        }
        let station = Station::new(&self.station.station)?;
        let host = Host::open(&station)?;
        let mut line = Line::of(&self.station.controller.devices, &station)?;
        let mut why = self.why.then(|| {
            let is_virtual = report.about.machine.virtual_machine;
            Watch::begin(self.core, is_virtual, flags.process.clone())
        });
        let _ = attached.send(());
        let before_s = report.about.seconds;
        let mut state: Box<StateFrame> = bytemuck::allocation::zeroed_box();
        let (mut reported, mut saved) = (Instant::now(), Instant::now());
        let mut first: Option<Instant> = None;
        let opened = Instant::now();
        let mut heard = opened;
        loop {
            // Load the flag before the records are read, so that the last records are read, too.
            let over = flags.over.load(Ordering::Relaxed);
            if host.newest_state(&mut state) {
                let age_ns = monotonic_ns().saturating_sub(state.at_ns);
                // Before the first tick of this turn, the state may be that of an earlier run.
                if first.is_some() {
                    tally.publish_to_display.record(age_ns);
                }
            }
            host.drain_timing(|batch| {
                heard = Instant::now();
                // A controller that refuses its scene runs no tick. The next controller takes a
                // coarser scene.
                if batch.count > 0 {
                    first.get_or_insert(heard);
                }
                tally.take(batch, report);
                if let Some(why) = &mut why {
                    why.take(batch);
                }
            });
            tally.budgets.admitted_ns = flags.admitted_ns.get().copied();
            if let Some(why) = &mut why {
                why.settle(&mut tally.black_box);
            }
            if let Some(line) = &mut line {
                line.look();
            }
            host.drain_events(|_| ());
            for frame in frames.try_iter().filter(|frame| frame.live) {
                report
                    .times("publish_to_frame_ns")
                    .record(frame.publish_to_frame_ns());
                let took_ns = frame.shown_ns.saturating_sub(frame.submitted_ns);
                report.times("frame_ns").record(took_ns);
            }
            let elapsed_s = first.map_or(0.0, |first| (heard - first).as_secs_f64());
            report.about.seconds = before_s + elapsed_s;
            note_standing(tally, report);
            if elapsed_s >= seconds {
                flags.done.store(true, Ordering::Relaxed);
            }
            if heard.elapsed() > PATIENCE {
                return Err("the station published no timing for a minute".into());
            }
            if reported.elapsed() >= PROGRESS && !flags.done.load(Ordering::Relaxed) {
                tally.fill(report);
                progress(report, self.total_s);
                reported = Instant::now();
            }
            if saved.elapsed() >= SAVE && first.is_some() {
                tally.fill(report);
                save(report, self.out)?;
                note_memory(report);
                saved = Instant::now();
            }
            if over {
                if let Some(remark) = line.as_ref().map(Line::remark)
                    && !report.about.notes.contains(&remark)
                {
                    report.about.notes.push(remark);
                }
                if let Some(why) = why {
                    why.end(&mut tally.black_box, report);
                }
                return Ok(());
            }
            std::thread::sleep(LOOK);
        }
    }
}
