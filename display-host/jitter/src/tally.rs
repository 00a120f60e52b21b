//! Turns timing records into the figures of a report.

use figures::Distribution;
use shared_mem::message::{STAGE_NAMES, STAGES, TickRecord, TimingBatch};

use crate::blackbox::{BlackBox, Tick};
use crate::budgets::Budgets;
use crate::misses::Missed;
use crate::report::Report;
use crate::timeline::Worst;

/// Stages until the force has been written.
const UNTIL_FORCE: core::ops::RangeTo<usize> = ..AFTER_FORCE.start;
/// Stages after the force has been written.
const AFTER_FORCE: core::ops::Range<usize> = 5..STAGES;
/// Ticks whose number is a multiple of this publish a frame of 65 kB in their publish stage. In
/// other ticks that stage takes almost no time.
pub const PUBLISH_EVERY: u64 = 4;

/// Collects the timing records of a station's sessions, one after another.
#[derive(Debug, Default)]
pub struct Tally {
    wake: Distribution,
    period: Distribution,
    tick: Distribution,
    stages: [Distribution; STAGES],
    motion_to_force: Distribution,
    /// The part of motion to force before the tick: the sample's wait, wake-up latency included.
    motion_to_tick: Distribution,
    /// From hand to force by the device's clock.
    hand_to_force: Distribution,
    /// Hand to force minus motion to force, for the same forces.
    line_and_device: Distribution,
    force_to_publish: Distribution,
    /// Age of a state when a display first reads it.
    pub publish_to_display: Distribution,
    /// Time at the start of each session in which motions do not count, ns. The ticks then still
    /// shift towards the times of the device's samples.
    pub settle_ns: u64,
    /// Ticks around the worst moments.
    pub black_box: BlackBox,
    /// Causes of late ticks by stage.
    pub budgets: Budgets,
    session: Session,
    /// Sum of the counters of the finished sessions.
    over: Counters,
    batches_lost: u64,
    /// Settled ticks that rested instead of following the device's samples.
    not_following: u64,
    /// Realtime bits that were set in every batch so far; `None` before the first batch.
    pub realtime_bits: Option<u32>,
}

/// The running session.
#[derive(Debug, Default)]
struct Session {
    start_ns: Option<u64>,
    /// Time measured in earlier sessions, s.
    before_s: f64,
    last: Option<Tick>,
    next_sequence: Option<u64>,
    counters: Counters,
    /// Wake-up latency of this session alone.
    wake: Distribution,
    missed: Missed,
    /// Durations of the first `TICKS_KEPT` ticks, ns.
    ticks_ns: Vec<u32>,
}

/// Results of a finished session.
#[derive(Debug, Default)]
pub struct Over {
    /// Wake-up latency.
    pub wake: Distribution,
    /// Periods missed in this session.
    pub missed: Missed,
    /// Durations of the ticks of the first two minutes, in order, ns.
    pub ticks_ns: Vec<u32>,
}

/// Largest number of ticks of a session whose durations are kept: two minutes. The limit bounds the
/// memory of longer sessions.
const TICKS_KEPT: usize = 120_000;

/// The controller's own counters.
#[derive(Debug, Clone, Copy, Default)]
struct Counters {
    ticks: u64,
    missed_periods: u64,
    late_ticks: u64,
    allocations: u64,
    page_faults: u64,
    involuntary_switches: u64,
    blocks: u64,
}

impl Counters {
    fn of(batch: &TimingBatch) -> Self {
        Self {
            ticks: batch.ticks,
            missed_periods: batch.missed_periods,
            late_ticks: batch.late_ticks,
            // `u64::MAX` means that the station does not count allocations. The value is kept as it
            // is, because zero would claim that they were counted.
            allocations: batch.allocations,
            page_faults: batch.page_faults,
            involuntary_switches: batch.involuntary_switches,
            blocks: batch.blocks,
        }
    }

    fn add(&mut self, other: Self) {
        self.ticks += other.ticks;
        self.missed_periods += other.missed_periods;
        self.late_ticks += other.late_ticks;
        self.allocations = self.allocations.saturating_add(other.allocations);
        self.page_faults += other.page_faults;
        self.involuntary_switches += other.involuntary_switches;
        self.blocks += other.blocks;
    }
}

impl Tally {
    /// Takes a batch of the running session. Skips a malformed batch.
    pub fn take(&mut self, batch: &TimingBatch, report: &mut Report) {
        let Some(records) = batch.records() else {
            return;
        };
        let expected = self.session.next_sequence.unwrap_or(batch.sequence);
        self.batches_lost += batch.sequence.saturating_sub(expected);
        self.session.next_sequence = Some(batch.sequence + 1);
        if records.is_empty() {
            // A controller that refuses its scene runs no tick, realtime or not.
            return;
        }
        self.session.counters = Counters::of(batch);
        let so_far = self.realtime_bits.unwrap_or(u32::MAX);
        self.realtime_bits = Some(so_far & batch.realtime);
        for record in records {
            self.record(record, report);
        }
    }

    fn record(&mut self, record: &TickRecord, report: &mut Report) {
        let session = &mut self.session;
        let start_ns = *session.start_ns.get_or_insert(record.scheduled_ns);
        let tick = Tick::from(record);
        let wake_ns = u64::from(tick.wake_latency_ns);
        self.wake.record(wake_ns);
        session.wake.record(wake_ns);
        self.tick.record(tick.tick_ns.into());
        if let Some(last) = session.last
            && last.tick + 1 == tick.tick
        {
            let began = |t: &Tick| t.scheduled_ns + u64::from(t.wake_latency_ns);
            self.period
                .record(began(&tick).saturating_sub(began(&last)));
        }
        let in_row = |last: &Tick| last.tick + 1 == tick.tick;
        let last_overran = session
            .last
            .filter(in_row)
            .is_some_and(|last| last.overran());
        session
            .missed
            .note_tick(tick.missed, last_overran, tick.overran());
        self.budgets.take(&tick, last_overran);
        if session.ticks_ns.len() < TICKS_KEPT {
            session.ticks_ns.push(tick.tick_ns);
        }
        session.last = Some(tick);
        for (stage, &ns) in self.stages.iter_mut().zip(&tick.stage_ns) {
            stage.record(ns.into());
        }
        let is_settled = tick.scheduled_ns.saturating_sub(start_ns) >= self.settle_ns;
        if is_settled && tick.bits & TickRecord::NOT_FOLLOWING != 0 {
            self.not_following += 1;
        }
        if record.motion_to_force_ns > 0 && is_settled {
            self.motion_to_force
                .record(record.motion_to_force_ns.into());
            let work = tick.stage_ns.get(UNTIL_FORCE).unwrap_or_default();
            let work_ns: u64 = work.iter().map(|&ns| u64::from(ns)).sum();
            let before_ns = u64::from(record.motion_to_force_ns).saturating_sub(work_ns);
            self.motion_to_tick.record(before_ns);
        }
        if record.hand_to_force_ns > 0 {
            self.hand_to_force.record(record.hand_to_force_ns.into());
            if record.echoed_ns > 0 {
                let more_ns = record.hand_to_force_ns.saturating_sub(record.echoed_ns);
                self.line_and_device.record(more_ns.into());
            }
        }
        let left_out = TickRecord::NOT_PUBLISHED | TickRecord::DROPPED_PUBLISH;
        if tick.tick.is_multiple_of(PUBLISH_EVERY) && tick.bits & left_out == 0 {
            let after = tick.stage_ns.get(AFTER_FORCE).unwrap_or_default();
            let after: u64 = after.iter().map(|&ns| u64::from(ns)).sum();
            self.force_to_publish.record(after);
        }
        let since_ns = tick.scheduled_ns.saturating_sub(start_ns);
        let at_s = session.before_s + since_ns as f64 / 1e9;
        self.black_box.note(tick, (at_s * 1e3) as u64);
        let worst = Worst::from((tick.wake_latency_ns, tick.tick_ns));
        report.timeline.note(at_s, worst, tick.stage_ns);
        report.intervals.note(at_s, wake_ns);
    }

    /// Ends the session. Later batches belong to the next one, which starts at `measured_s` of
    /// measured time.
    pub fn end_session(&mut self, measured_s: f64) -> Over {
        self.black_box.interrupt();
        let session = core::mem::replace(
            &mut self.session,
            Session {
                before_s: measured_s,
                ..Session::default()
            },
        );
        self.over.add(session.counters);
        Over {
            wake: session.wake,
            missed: session.missed,
            ticks_ns: session.ticks_ns,
        }
    }

    /// Writes all figures so far into the report.
    pub fn fill(&self, report: &mut Report) {
        let mut put = |name: &str, times: &Distribution| {
            report.times.insert(name.to_owned(), times.clone());
        };
        put("wake_latency_ns", &self.wake);
        put("period_ns", &self.period);
        put("tick_ns", &self.tick);
        for (name, stage) in STAGE_NAMES.iter().zip(&self.stages) {
            put(&format!("stage_ns.{name}"), stage);
        }
        put("motion_to_force_ns", &self.motion_to_force);
        put("motion_to_tick_ns", &self.motion_to_tick);
        put("hand_to_force_ns", &self.hand_to_force);
        put("hand_to_force_more_ns", &self.line_and_device);
        put("force_to_publish_ns", &self.force_to_publish);
        put("publish_to_display_ns", &self.publish_to_display);
        let mut all = self.over;
        all.add(self.session.counters);
        for (name, count) in [
            ("ticks", all.ticks),
            ("deadline_misses", all.missed_periods),
            ("overruns", all.late_ticks),
            ("allocations_after_start", all.allocations),
            ("page_faults_after_start", all.page_faults),
            ("involuntary_switches", all.involuntary_switches),
            ("blocks", all.blocks),
            ("timing_batches_lost", self.batches_lost),
            ("ticks_not_following", self.not_following),
        ] {
            report.counts.insert(name.to_owned(), count);
        }
        report.incidents = self.black_box.incidents();
        report.budgets = self.budgets.table();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::sample;

    fn batch(sequence: u64, first: u64) -> Box<TimingBatch> {
        let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
        batch.sequence = sequence;
        batch.count = 4;
        batch.ticks = first + 4;
        batch.missed_periods = 1;
        batch.realtime = 7;
        for (i, record) in (0u64..).zip(batch.records.iter_mut().take(4)) {
            record.tick = first + i;
            record.scheduled_ns = 1_000_000 * (1 + first + i);
            record.wake_latency_ns = 1000 * (1 + i as u32);
            record.tick_ns = 50_000;
            record.stage_ns = [1, 2, 3, 4, 5, 600, 7000];
            record.motion_to_force_ns = if i == 2 { 0 } else { 9000 };
            record.hand_to_force_ns = if i < 2 { 25_000 } else { 0 };
            record.echoed_ns = if i == 0 { 9000 } else { 0 };
        }
        batch
    }

    #[test]
    fn figures_follow_from_the_records() {
        let mut report = sample();
        let mut tally = Tally::default();
        tally.take(&batch(0, 0), &mut report);
        tally.take(&batch(2, 8), &mut report);
        let over = tally.end_session(1.0);
        assert_eq!((over.wake.count(), over.missed.ticks), (8, 8));
        assert_eq!(over.ticks_ns, [50_000; 8]);
        tally.take(&batch(0, 0), &mut report);
        tally.fill(&mut report);
        let count = |name: &str| report.times[name].count();
        assert_eq!(count("wake_latency_ns"), 12);
        assert_eq!(
            count("period_ns"),
            3 * 3,
            "no period spans a gap or two runs"
        );
        assert_eq!(count("motion_to_force_ns"), 9, "0: no fresh sample");
        assert_eq!(count("motion_to_tick_ns"), 9);
        let before = report.times["motion_to_tick_ns"].quantiles();
        assert!(before.p50.abs_diff(9000 - 15) < 10, "{before:?}");
        assert_eq!(count("hand_to_force_ns"), 6, "0: no echo");
        assert_eq!(count("hand_to_force_more_ns"), 3, "of known ticks");
        let more = report.times["hand_to_force_more_ns"].quantiles();
        assert!(more.p50.abs_diff(16_000) < 100, "{more:?}");
        assert_eq!(count("force_to_publish_ns"), 3);
        let period = report.times["period_ns"].quantiles();
        assert!(period.p50.abs_diff(1_001_000) < 1000, "{period:?}");
        let after = report.times["force_to_publish_ns"].quantiles();
        assert!(after.p50.abs_diff(7600) < 10);
        assert_eq!(report.counts["ticks"], 16);
        assert_eq!(report.counts["deadline_misses"], 2);
        assert_eq!(report.counts["timing_batches_lost"], 1);
    }

    #[test]
    fn motions_count_once_the_ticks_have_settled() {
        let mut report = sample();
        let mut tally = Tally {
            settle_ns: 5_000_000,
            ..Tally::default()
        };
        // Ticks 0 to 3, then 4 to 7. In each batch the third tick has no motion.
        tally.take(&batch(0, 0), &mut report);
        let mut resting = batch(1, 4);
        for record in resting.records.iter_mut().take(4) {
            record.bits = TickRecord::NOT_FOLLOWING;
        }
        tally.take(&resting, &mut report);
        tally.fill(&mut report);
        assert_eq!(report.counts["ticks_not_following"], 3);
        assert_eq!(report.times["motion_to_force_ns"].count(), 2);
        assert_eq!(report.times["wake_latency_ns"].count(), 8);
    }

    /// A day at one tick a second, with times as irregular as possible.
    #[test]
    fn a_day_takes_no_more_memory_than_an_hour() {
        let mut report = sample();
        let mut tally = Tally::default();
        let mut size_after = |from_s: u64, to_s: u64| {
            for s in (from_s..to_s).step_by(4) {
                let mut batch = batch(s / 4, s);
                for record in batch.records.iter_mut().take(4) {
                    record.scheduled_ns = record.tick * 1_000_000_000;
                    let wild = record.tick.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
                    record.wake_latency_ns = wild as u32;
                    record.tick_ns = (wild ^ 0xffff) as u32;
                }
                tally.take(&batch, &mut report);
            }
            tally.fill(&mut report);
            assert!(tally.session.ticks_ns.len() <= TICKS_KEPT);
            assert!(report.timeline.worst_ns.len() <= 600 && report.incidents.len() <= 32);
            let in_each = report.incidents.iter().map(|i| i.ticks.len());
            assert!(in_each.max() <= Some(33));
            // The report holds all state that the tally keeps.
            report.to_json().to_string().len() as f64
        };
        let hour = size_after(0, 3600);
        let day = size_after(3600, 86_400);
        // The number of ticks grew 24-fold. Memory grows only where a bin of a histogram gets its
        // first tick.
        assert!(day < 2.0 * hour, "{hour} {day}");
    }

    #[test]
    fn a_malformed_batch_is_left_out() {
        let mut report = sample();
        let mut tally = Tally::default();
        tally.take(&bytemuck::allocation::zeroed_box(), &mut report);
        assert_eq!(
            tally.realtime_bits, None,
            "a batch without ticks says nothing of them"
        );
        let mut bad = batch(0, 0);
        bad.count = 1000;
        tally.take(&bad, &mut report);
        tally.fill(&mut report);
        assert_eq!(report.times["wake_latency_ns"].count(), 0);
    }
}
