//! Collects the display's observations into histograms and one value a second.

use std::collections::BTreeMap;

use figures::{Distribution, Machine};
use shared_mem::limits::FAULTS;
use shared_mem::message::{DeviceHealth, STAGE_NAMES, STAGES, TimingBatch, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::Fault;

use super::standstill::Standstills;
use super::unrest::{Unrest, UnrestFinding};
use super::{DeviceSummary, HeldBack, LineSummary, Range, Summary};
use crate::feed::hex;
use crate::headless::{Observed, RunOutcome};

/// Points per second of the force's course.
const FORCE_POINTS_PER_S: u64 = 20;
/// Largest number of points of a time series. Further ones replace the oldest.
const POINTS_MAX: usize = 40_000;

/// A quantity over time: for each time step since the first sample, the largest value in it.
#[derive(Debug, Clone, Default)]
pub struct TimeSeries {
    start_ns: Option<u64>,
    points: std::collections::VecDeque<(u64, f64)>,
}

impl TimeSeries {
    fn push(&mut self, at_ns: u64, steps_per_s: u64, value: f64) {
        let start = *self.start_ns.get_or_insert(at_ns);
        let step = at_ns.saturating_sub(start) / (1_000_000_000 / steps_per_s);
        match self.points.back_mut() {
            Some((last, greatest)) if *last >= step => *greatest = greatest.max(value),
            _ => {
                if self.points.len() == POINTS_MAX {
                    self.points.pop_front();
                }
                self.points.push_back((step, value));
            }
        }
    }

    /// The points, each as seconds since the first sample and value.
    pub(super) fn points(&self, steps_per_s: u64) -> Vec<(f64, f64)> {
        self.points
            .iter()
            .map(|&(step, v)| (step as f64 / steps_per_s as f64, v))
            .collect()
    }
}

/// The collected data of a run's report.
#[derive(Debug, Default)]
pub struct Recorder {
    pub(super) wake_latency: Distribution,
    pub(super) tick: Distribution,
    pub(super) motion_to_force: Distribution,
    pub(super) stages: [Distribution; STAGES],
    force: TimeSeries,
    worst_tick: TimeSeries,
    worst_wake: TimeSeries,
    force_min_max: Option<(f32, f32)>,
    events: BTreeMap<&'static str, u64>,
    unrest: Unrest,
    standstills: Standstills,
    records: u64,
    /// Health of haptic device, tracker and pedal in the newest tool state.
    lines: [Option<DeviceHealth>; 3],
    last_batch: Option<Counters>,
}

/// Counters of the controller, from its newest batch.
#[derive(Debug, Clone, Copy)]
struct Counters {
    ticks: u64,
    missed_periods: u64,
    late_ticks: u64,
    allocations: u64,
    page_faults: u64,
    involuntary_switches: u64,
    realtime: u32,
    faults: [u64; FAULTS],
    contact_ticks: u64,
    held_ticks: [u64; FAULTS],
    held_times: [u64; FAULTS],
}

impl Recorder {
    /// An empty recorder.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes an observation of the display.
    pub fn observe(&mut self, observed: &Observed<'_>) {
        match observed {
            Observed::Timing(batch) => self.take_timing(batch),
            Observed::Tools(tools) => self.take_tools(tools),
            Observed::Event(event) => {
                *self.events.entry(event.name()).or_default() += 1;
                self.unrest.take(event);
            }
            Observed::Begun
            | Observed::State(_)
            | Observed::Scope(_)
            | Observed::Settings(_)
            | Observed::Progress(_)
            | Observed::Warning(_)
            | Observed::Over => {}
        }
    }

    /// Organs that fell or shook.
    #[must_use]
    pub fn unrest(&self, scene: &SceneFile) -> Vec<UnrestFinding> {
        self.unrest.findings(scene)
    }

    /// Standstills of the controller, as one of the run's warnings.
    #[must_use]
    pub fn standstills(&self) -> Option<String> {
        self.standstills.warning()
    }

    fn take_timing(&mut self, batch: &TimingBatch) {
        let Some(records) = batch.records() else {
            return;
        };
        for record in records {
            self.records += 1;
            self.standstills.take(record);
            self.wake_latency.record(u64::from(record.wake_latency_ns));
            self.tick.record(u64::from(record.tick_ns));
            if record.motion_to_force_ns > 0 {
                self.motion_to_force
                    .record(u64::from(record.motion_to_force_ns));
            }
            for (stage, &ns) in self.stages.iter_mut().zip(&record.stage_ns) {
                stage.record(u64::from(ns));
            }
            let us = |ns: u32| f64::from(ns) / 1e3;
            self.worst_tick
                .push(record.scheduled_ns, 1, us(record.tick_ns));
            self.worst_wake
                .push(record.scheduled_ns, 1, us(record.wake_latency_ns));
        }
        self.last_batch = Some(Counters {
            ticks: batch.ticks,
            missed_periods: batch.missed_periods,
            late_ticks: batch.late_ticks,
            allocations: batch.allocations,
            page_faults: batch.page_faults,
            involuntary_switches: batch.involuntary_switches,
            realtime: batch.realtime,
            faults: batch.faults,
            contact_ticks: batch.contact_ticks,
            held_ticks: batch.held_ticks,
            held_times: batch.held_times,
        });
    }

    fn take_tools(&mut self, tools: &ToolFrame) {
        self.lines = tools.health.map(Some);
        let force_n = tools.force_n.iter().map(|x| x * x).sum::<f32>().sqrt();
        let (min, max) = self.force_min_max.unwrap_or((force_n, force_n));
        self.force_min_max = Some((min.min(force_n), max.max(force_n)));
        self.force
            .push(tools.at_ns, FORCE_POINTS_PER_S, f64::from(force_n));
    }

    /// Devices of the newest tool state, without names and capabilities.
    fn devices(&self) -> Vec<DeviceSummary> {
        let kinds = ["haptic", "tracker", "pedal"].into_iter();
        let lines = kinds.zip(self.lines);
        let present = lines.filter_map(|(kind, line)| {
            let line = line.filter(|it| it.status != DeviceHealth::ABSENT)?;
            Some(DeviceSummary {
                kind: kind.to_owned(),
                line: LineSummary {
                    frames: line.frames,
                    bad_frames: line.bad_frames,
                    lost_frames: line.lost_frames,
                    dropped_writes: line.dropped_writes,
                    unread_bytes: line.unread_bytes,
                },
                ..DeviceSummary::default()
            })
        });
        present.collect()
    }

    /// Force on the hand: (s, N), the largest of each step.
    pub(super) fn force_course(&self) -> Vec<(f64, f64)> {
        self.force.points(FORCE_POINTS_PER_S)
    }

    /// Worst tick of each second: (s, µs).
    pub(super) fn tick_course(&self) -> Vec<(f64, f64)> {
        self.worst_tick.points(1)
    }

    /// Worst wake latency of each second: (s, µs).
    pub(super) fn wake_course(&self) -> Vec<(f64, f64)> {
        self.worst_wake.points(1)
    }

    /// Summary of a run.
    #[must_use]
    pub fn summary(&self, scene: &SceneFile, outcome: &RunOutcome, machine: Machine) -> Summary {
        let counters = self.last_batch;
        let realtime_bits = counters.map_or(0, |c| c.realtime);
        let lacks: Vec<String> = [
            (TimingBatch::FIFO, "SCHED_FIFO"),
            (TimingBatch::LOCKED, "locked memory"),
            (TimingBatch::PINNED, "a core of its own"),
        ]
        .into_iter()
        .filter(|(bit, _)| realtime_bits & bit == 0)
        .map(|(_, name)| name.to_owned())
        .collect();
        let (min, max) = self.force_min_max.unwrap_or_default();
        let mut publish_to_frame = Distribution::new();
        let mut motion_to_picture = Distribution::new();
        for frame in outcome.frames.iter().filter(|frame| frame.live) {
            publish_to_frame.record(frame.publish_to_frame_ns());
            if frame.sample_ns > 0 {
                motion_to_picture.record(frame.motion_to_picture_ns());
            }
        }
        let stages = STAGE_NAMES.iter().zip(&self.stages);
        let faults = counters.map_or([0; FAULTS], |c| c.faults);
        Summary {
            program: concat!("calot ", env!("CARGO_PKG_VERSION")).to_owned(),
            scene: scene.name().to_owned(),
            case: None,
            scene_id: hex(scene.short_id()),
            ticks: counters.map_or(0, |c| c.ticks),
            missed_periods: counters.map_or(0, |c| c.missed_periods),
            late_ticks: counters.map_or(0, |c| c.late_ticks),
            wake_latency_ns: self.wake_latency.quantiles(),
            tick_ns: self.tick.quantiles(),
            motion_to_force_ns: self.motion_to_force.quantiles(),
            stage_ns: stages.map(|(name, d)| (*name, d.quantiles())).collect(),
            publish_to_frame_ns: publish_to_frame.quantiles(),
            motion_to_picture_ns: motion_to_picture.quantiles(),
            motion_to_presentation_ns: outcome.presentation.motion.quantiles(),
            presentation: outcome.presentation.summary(),
            force_n: Range { min, max },
            frames: outcome.frames.len(),
            pictures_per_second: outcome.pictures_per_second,
            fluids: outcome.fluids.map(Into::into),
            allocations_after_start: counters
                .map(|c| c.allocations)
                .filter(|&count| count != u64::MAX),
            page_faults_after_start: counters.map_or(0, |c| c.page_faults),
            involuntary_switches: counters.map_or(0, |c| c.involuntary_switches),
            realtime: counters.is_some() && lacks.is_empty(),
            not_realtime: lacks,
            timing_records: self.records,
            timing_batches_lost: outcome.counters.batches_lost,
            events: self.events.clone(),
            events_lost: outcome.counters.events_lost,
            faults: faults
                .iter()
                .enumerate()
                .filter(|&(_, &count)| count > 0)
                .map(|(number, &count)| (Fault::NAMES[number].to_owned(), count))
                .collect(),
            contact_ticks: counters.map_or(0, |c| c.contact_ticks),
            force_held_back: counters.map(|c| held_back(&c)).unwrap_or_default(),
            devices: self.devices(),
            ended: outcome.ended,
            recording: None,
            task: None,
            adapter: outcome.adapter.clone(),
            warnings: (outcome.warnings.iter().cloned())
                .chain(self.unrest(scene).into_iter().map(|it| it.warning))
                .chain(self.standstills())
                .collect(),
            unrest: self.unrest(scene),
            machine,
        }
    }
}

/// Force that was held back, by reason. A reason that held back no force is left out.
fn held_back(counters: &Counters) -> Vec<HeldBack> {
    let counts = counters.held_ticks.iter().zip(&counters.held_times);
    let by_name = Fault::NAMES.iter().zip(counts);
    let held = by_name.filter(|(_, (ticks, _))| **ticks > 0);
    held.map(|(fault, (&ticks, &times))| HeldBack {
        fault: (*fault).to_owned(),
        ticks,
        times,
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use shared_mem::message::TickRecord;

    use super::*;

    fn batch(first_tick: u64, wake_ns: &[u32]) -> TimingBatch {
        let mut batch = TimingBatch::zeroed();
        batch.count = wake_ns.len() as u32;
        batch.ticks = first_tick + wake_ns.len() as u64;
        for (i, (record, &ns)) in batch.records.iter_mut().zip(wake_ns).enumerate() {
            let scheduled_ns = (first_tick + i as u64) * 1_000_000;
            *record = TickRecord {
                scheduled_ns,
                wake_latency_ns: ns,
                ..TickRecord::zeroed()
            };
        }
        batch
    }

    #[test]
    fn records_and_counters_reach_the_histograms() {
        let mut recorder = Recorder::new();
        recorder.observe(&Observed::Timing(&batch(0, &[1000, 2000, 3000])));
        recorder.observe(&Observed::Timing(&batch(3, &[9000])));
        assert_eq!(recorder.wake_latency.quantiles().count, 4);
        assert!(recorder.wake_latency.quantiles().max >= 9000);
        assert_eq!(recorder.last_batch.map(|c| c.ticks), Some(4));
        assert_eq!(
            recorder.motion_to_force.quantiles().count,
            0,
            "0 means no fresh sample"
        );
    }

    #[test]
    fn the_course_keeps_the_worst_of_each_second() {
        let mut recorder = Recorder::new();
        for second in 0..3u64 {
            let first = second * 1000;
            recorder.observe(&Observed::Timing(&batch(
                first,
                &[5000, 70_000 + second as u32, 10],
            )));
        }
        let course = recorder.wake_course();
        assert_eq!(course.len(), 3);
        assert!((course[2].1 - 70.002).abs() < 1e-9, "{course:?}");
    }

    #[test]
    fn a_malformed_batch_is_ignored() {
        let mut recorder = Recorder::new();
        let mut bad = batch(0, &[1]);
        bad.count = 1000;
        recorder.observe(&Observed::Timing(&bad));
        assert_eq!(recorder.records, 0);
    }

    #[test]
    fn force_is_the_length_of_the_vector() {
        let mut recorder = Recorder::new();
        for (at_ns, force_n) in [(0, [0.0; 3]), (1_000_000, [0.3, 0.0, 0.4])] {
            let tools = ToolFrame {
                at_ns,
                force_n,
                ..ToolFrame::zeroed()
            };
            recorder.observe(&Observed::Tools(&tools));
        }
        assert_eq!(recorder.force_min_max, Some((0.0, 0.5)));
        assert_eq!(recorder.force_course().len(), 1);
    }
}
