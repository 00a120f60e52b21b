//! The main thread's work: it starts a station from its configuration, supervises it and ends it.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed, Ordering::Release};
use core::time::Duration;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread::{JoinHandle, sleep};

use hardware::station::StationFile;
use heapless::spsc::{Consumer, Producer, Queue};
use rt_core::fault::Fault;
use rt_core::sim::Stage;
use shared_mem::message::TimingBatch;
use shared_mem::scene::SceneFile;
use shared_mem::service::{Controller, ServiceError, Station};

use crate::admission::Admission;
use crate::config::{AdmissionPolicy, Realtime, RtConfig};
use crate::devices::Device;
use crate::error::RtError;
use crate::fit;
use crate::handover::Handover;
use crate::notice::Notices;
use crate::publisher::{self, COMMAND_QUEUE, EVENT_QUEUE, RECORD_QUEUE};
use crate::realtime::{self, NoDeepIdle, Standing};
use crate::reconnect::Opener;
use crate::runaway::RunawayGuard;
use crate::scene::LoadedScene;
use crate::scope_line::ScopeLine;
use crate::settings::Settings;
use crate::shared::Shared;
use crate::summary::{DeviceReport, Ended, Ready, RtSummary};
use crate::thread::{TICK_STACK_BYTES, ended_without_report, join, spawn};
use crate::tick;
use crate::tick_thread::{self, Start};
use crate::time_driver::monotonic_ns;
use crate::watch::Watch;

/// Longest wait for the tick to end when asked.
const PATIENCE_TO_END_NS: u64 = 2_000_000_000;
/// Interval of the main thread's checks.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Runs the realtime process until `stop` is set, a host's command ends it,
/// [`RtConfig::periods_max`] periods have passed, or a thread fails. Calls `on_ready` once, after
/// the first tick.
///
/// Blocks the calling thread, which should receive the signals (`signal_hook::flag` on `stop`).
/// When it returns, the force is zero, with one exception: after `RtError::Wedged` only the
/// device's own watchdog, if it has one, zeroes the force. Refusals of Linux and problems are
/// written to standard error.
///
/// The simulation's storage is leaked, because embassy's tasks use it and must be `'static`.
///
/// # Errors
/// [`RtError`] says why the process did not start or ended early.
pub fn run(
    config: &RtConfig,
    stop: &AtomicBool,
    on_ready: impl FnOnce(&Ready),
) -> Result<RtSummary, RtError> {
    config.check()?;
    let cores = realtime::allowed_cores();
    let file = config.station_file.as_deref().map(StationFile::read);
    let file = file
        .transpose()
        .map_err(|source| RtError::Device {
            device: "station file",
            source,
        })?
        .unwrap_or_default();
    let mut run = Run {
        config,
        scene: LoadedScene::load(&config.scene, &file)?.keep(),
        file,
        admission: None,
        core: config.core.or(cores.last().copied()).unwrap_or(0),
        cores,
        shared: Arc::default(),
    };
    let (tick_ends, publisher_ends) = queues();

    // The station is taken first, because a second controller must not touch the first one's
    // devices.
    let publisher = run.start_publisher(publisher_ends)?;
    let outcome = run
        .admit()
        .and_then(|()| run.start_tick(tick_ends))
        .and_then(|tick| run.supervise(tick, &publisher, stop, on_ready));
    if let Err(wedged @ RtError::Wedged { .. }) = outcome {
        // The tick may still write into the publisher's memory, so leave both running.
        return Err(wedged);
    }
    run.shared.tick_ended.store(true, Release);
    let published = join("publishing", publisher);
    let supervised = outcome?;
    published?;
    Ok(run.summary(supervised))
}

/// Constants of a run.
struct Run<'a> {
    config: &'a RtConfig,
    scene: &'static LoadedScene,
    /// Devices as the station file names them.
    file: StationFile,
    /// Measured cost of the scene, if it was measured.
    admission: Option<Admission>,
    /// Cores that this process may use.
    cores: Vec<usize>,
    /// Core of the tick.
    core: usize,
    shared: Arc<Shared>,
}

/// The tick's thread, ready to tick.
struct TickThread {
    thread: JoinHandle<()>,
    /// The thread that reopens lost devices. It ends after the tick.
    opener: JoinHandle<()>,
    devices: Vec<DeviceReport>,
    standing: Standing,
    /// The request lasts until this value is dropped.
    _no_deep_idle: Option<NoDeepIdle>,
}

/// Result of the supervision.
struct Supervised {
    ended: Ended,
    standing: Standing,
    stalls_seen: u64,
}

impl Run<'_> {
    /// Starts the publishing thread and waits until it has the station.
    fn start_publisher(&self, ends: publisher::Ends) -> Result<JoinHandle<()>, RtError> {
        let station = Station::new(&self.config.station)?;
        let shared = Arc::clone(&self.shared);
        let asks = self.config.realtime == Realtime::Ask;
        let priority = self.config.publisher_priority;
        let period_ns = self.config.period_ns;
        let (cores, core) = (self.cores.clone(), self.core);
        let (sender, receiver) = mpsc::sync_channel::<Result<(), ServiceError>>(1);
        let body = move || {
            realtime::leave_signals_to_main();
            let controller = match Controller::open(&station) {
                Ok(controller) => controller,
                Err(error) => {
                    let _ = sender.send(Err(error));
                    return;
                }
            };
            if asks {
                // Refusals are ignored here, because the tick's thread will report the same ones.
                let _ = realtime::work_beside_tick(&cores, core, priority);
            }
            let _ = sender.send(Ok(()));
            publisher::publish(&controller, ends, &shared, period_ns);
        };
        let thread = spawn("publishing", 2 << 20, body)?;
        match receiver.recv() {
            Ok(Ok(())) => Ok(thread),
            Ok(Err(error)) => Err(error.into()),
            Err(_) => Err(ended_without_report("publishing", thread)),
        }
    }

    /// Takes the finest level whose worst tick fits this machine. If none fits, refuses (strict) or
    /// takes the coarsest and reports it.
    fn admit(&mut self) -> Result<(), RtError> {
        if self.config.admission == AdmissionPolicy::Skip {
            return Ok(());
        }
        let finest = SceneFile::levels(&self.config.scene).into_iter().skip(1);
        let files = self.config.coarser.iter();
        let mut coarser = finest.chain(files.flat_map(|file| SceneFile::levels(file)));
        loop {
            let scene = self.scene.scene()?;
            let found = fit::measure(&self.scene.name, scene, self.config, self.core)?;
            crate::say!("calot rt: {}", found.in_words());
            let fits = found.fits;
            self.admission = Some(found.clone());
            if fits {
                return Ok(());
            }
            match coarser.next() {
                Some(level) => self.scene = LoadedScene::load(&level, &self.file)?.keep(),
                None if self.config.admission == AdmissionPolicy::Strict => {
                    return Err(RtError::DoesNotFit(Box::new(found)));
                }
                None => {
                    crate::say!(
                        "calot rt: no level of the scene fits, so the coarsest one runs; some \
                         ticks will end late; take a coarser scene (`calot prepare --spheres`)"
                    );
                    return Ok(());
                }
            }
        }
    }

    /// Opens the devices, locks memory, starts the tick's thread and waits until it is ready.
    fn start_tick(&self, ends: tick::Ends) -> Result<TickThread, RtError> {
        let opener = Opener {
            config: self.config.clone(),
            file: self.file.clone(),
            cores: self.cores.clone(),
            tick_core: self.core,
            shared: Arc::clone(&self.shared),
        };
        let (devices, opener) = opener.start()?;
        let reports = devices.reports(self.config, &self.file);
        let mut standing = Standing::default();
        let mut no_deep_idle = None;
        match self.config.realtime {
            Realtime::Ask => {
                standing.note(TimingBatch::LOCKED, realtime::lock_memory());
                match NoDeepIdle::ask() {
                    Ok(request) => no_deep_idle = Some(request),
                    Err(why) => standing.refused.push(why),
                }
            }
            Realtime::Never => standing
                .refused
                .push("realtime was not requested".to_owned()),
        }
        let start = Start {
            scene: self.scene.scene()?,
            scene_id: self.scene.short_id,
            devices,
            ends,
            shared: Arc::clone(&self.shared),
            core: self.core,
            standing,
            scope_line: self
                .config
                .scope_line
                .as_ref()
                .map(ScopeLine::open)
                .transpose()?,
            settings: Settings {
                trocar: self.scene.trocar,
                ..Settings::new(self.config, self.admission.as_ref())
            },
        };
        let (sender, receiver) = mpsc::sync_channel(1);
        let thread = spawn("tick", TICK_STACK_BYTES, move || {
            tick_thread::run(start, &sender);
        })?;
        match receiver.recv() {
            Ok(standing) => Ok(TickThread {
                thread,
                opener,
                devices: reports,
                standing,
                _no_deep_idle: no_deep_idle,
            }),
            Err(_) => Err(ended_without_report("tick", thread)),
        }
    }

    /// Watches until the tick has ended.
    fn supervise(
        &self,
        mut tick: TickThread,
        publisher: &JoinHandle<()>,
        stop: &AtomicBool,
        on_ready: impl FnOnce(&Ready),
    ) -> Result<Supervised, RtError> {
        for why in &tick.standing.refused {
            crate::say!("calot rt: {why}");
        }
        if !tick.standing.is_realtime() {
            crate::say!("calot rt: NOT REALTIME; every report says so");
        }
        let refused = self.config.must_be_realtime && !tick.standing.is_realtime();
        if refused {
            self.shared.ask_to_end(Ended::Asked);
        }
        let mut on_ready = Some(on_ready).filter(|_| !refused);
        let runaway = RunawayGuard::arm();
        if let Err(error) = &runaway {
            crate::say!("calot rt: a runaway tick would not be stopped: RLIMIT_RTTIME: {error}");
        }
        let mut watch = Watch::new();
        let mut notices =
            Notices::new(Device::path(0, self.config, &self.file).map(Path::to_owned));
        let mut asked_at_ns = None;
        while !tick.thread.is_finished() {
            sleep(LOOK_EVERY);
            if self.shared.ticks.load(Relaxed) > 0
                && let Some(on_ready) = on_ready.take()
            {
                on_ready(&self.ready(&tick));
            }
            if stop.load(Relaxed) || publisher.is_finished() {
                self.shared.ask_to_end(Ended::Asked);
            }
            watch.look(&self.shared);
            notices.look(&self.shared);
            watch.look_at_standing(&self.shared, &mut tick.standing);
            if runaway.as_ref().is_ok_and(RunawayGuard::tripped) {
                realtime::demote(self.shared.tick_thread.load(Relaxed));
                self.shared.ask_to_end(Ended::Runaway);
            }
            if self.shared.asked_to_end().is_some() {
                let asked_at_ns = *asked_at_ns.get_or_insert_with(monotonic_ns);
                let waited_ns = monotonic_ns() - asked_at_ns;
                if waited_ns > PATIENCE_TO_END_NS {
                    realtime::demote(self.shared.tick_thread.load(Relaxed));
                    let waited_ms = waited_ns / 1_000_000;
                    return Err(RtError::Wedged { waited_ms });
                }
            }
        }
        join("tick", tick.thread)?;
        join("devices", tick.opener)?;
        if refused {
            return Err(RtError::NotRealtime {
                refused: tick.standing.refused,
            });
        }
        Ok(Supervised {
            ended: self.shared.asked_to_end().unwrap_or(Ended::Asked),
            standing: tick.standing,
            stalls_seen: watch.stalls_seen(),
        })
    }

    fn ready(&self, tick: &TickThread) -> Ready {
        let standing = &tick.standing;
        Ready {
            station: self.config.station.clone(),
            scene: self.scene.name.clone(),
            scene_id: self.scene.id.clone(),
            spheres: self.scene.sphere_count(),
            core: self.core,
            realtime: standing.is_realtime(),
            refused: standing.refused.clone(),
            admission: self.admission.clone(),
            devices: tick.devices.clone(),
        }
    }

    fn summary(&self, supervised: Supervised) -> RtSummary {
        let shared = &*self.shared;
        let allocations = shared.allocations.load(Relaxed);
        let stages = Stage::ALL.into_iter().zip(&shared.stages_over);
        let over = stages
            .map(|(stage, count)| (format!("{stage:?}").to_lowercase(), count.load(Relaxed)))
            .filter(|(_, count)| *count > 0)
            .collect();
        let faults = Fault::ALL.into_iter().zip(&shared.faults);
        RtSummary {
            station: self.config.station.clone(),
            scene: self.scene.name.clone(),
            scene_id: self.scene.id.clone(),
            ended: supervised.ended,
            ticks: shared.ticks.load(Relaxed),
            missed_periods: shared.missed_periods.load(Relaxed),
            late_ticks: shared.late_ticks.load(Relaxed),
            allocations_after_start: (allocations != u64::MAX).then_some(allocations),
            page_faults_after_start: shared.page_faults.load(Relaxed),
            involuntary_switches: shared.involuntary_switches.load(Relaxed),
            blocks: shared.blocks.load(Relaxed),
            realtime: supervised.standing.is_realtime(),
            refused: supervised.standing.refused,
            admission: self.admission.clone(),
            core: self.core,
            faults: faults
                .map(|(fault, count)| (fault.name().to_owned(), count.load(Relaxed)))
                .filter(|(_, count)| *count > 0)
                .collect(),
            force_max_n: f32::from_bits(shared.force_max_n.load(Relaxed)),
            frames_skipped: shared.frames_skipped.load(Relaxed),
            self_collisions_dropped: shared.self_collisions_dropped.load(Relaxed),
            far_organs_dropped: shared.far_organs_dropped.load(Relaxed),
            frames_dropped: shared.frames_dropped.load(Relaxed),
            stages_over: over,
            events_lost: shared.events_lost.load(Relaxed),
            records_lost: shared.records_lost.load(Relaxed),
            inputs_lost: shared.inputs_lost.load(Relaxed),
            stalls_seen: supervised.stalls_seen,
        }
    }
}

/// Makes the queues between the tick and the publishing thread. They live as long as the process.
pub(crate) fn queues() -> (tick::Ends, publisher::Ends) {
    fn queue<T, const N: usize>() -> (Producer<'static, T>, Consumer<'static, T>) {
        Box::leak(Box::new(Queue::<T, N>::new())).split()
    }
    let (state, state_sender) = Handover::new().split();
    let (tools, tools_sender) = Handover::new().split();
    let (events, events_out) = queue::<_, EVENT_QUEUE>();
    let (records, records_out) = queue::<_, RECORD_QUEUE>();
    let (inputs, inputs_out) = queue::<_, RECORD_QUEUE>();
    let (commands_in, commands) = queue::<_, COMMAND_QUEUE>();
    let (accepted, accepted_out) = queue::<_, COMMAND_QUEUE>();
    (
        tick::Ends {
            state,
            tools,
            events,
            records,
            inputs,
            commands,
            accepted,
        },
        publisher::Ends {
            state: state_sender,
            tools: tools_sender,
            events: events_out,
            records: records_out,
            inputs: inputs_out,
            commands: commands_in,
            accepted: accepted_out,
        },
    )
}
