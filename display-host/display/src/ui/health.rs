//! Health of the controller's ticks over the last seconds.

use std::collections::VecDeque;

use shared_mem::limits::FAULTS;
use shared_mem::message::{TickRecord, TimingBatch};
use shared_mem::words::Fault;

/// Number of ticks in the window: four seconds at 1 kHz.
const WINDOW: usize = 4096;
/// Number of bars of a histogram. Bar `k` holds 2^k to 2^(k+1) µs. The first one also holds all
/// shorter times, and the last one all longer times.
pub(super) const BARS: usize = 16;

/// Gates of the safety chain, in their order. Each has the name that the controller gives to its
/// counter.
const GATES: [&str; 12] = [
    "bad_sample",
    "speed_trip",
    "bad_force",
    "not_enabled",
    "lost_device",
    "stale_device",
    "ramped",
    "stiffness_capped",
    "damped",
    "clamped",
    "thermal_limited",
    "slewed",
];

/// Rolling view of the timing records.
#[derive(Debug, Clone, Default)]
pub struct TickHealth {
    /// Wake-up delay and duration of each of the last ticks, ns.
    recent: VecDeque<[u32; 2]>,
    /// Number and scheduled time (ns) of the newest tick.
    last: Option<(u64, u64)>,
    /// Rate of the ticks, averaged over the last batches, Hz.
    pub rate_hz: f32,
    /// Periods skipped since the controller started.
    pub missed: u64,
    /// Ticks that ended late since the controller started.
    pub late_ticks: u64,
    /// Heap allocations of the realtime thread.
    pub allocations: u64,
    /// Page faults of the realtime thread.
    pub page_faults: u64,
    /// Ticks with each fault since the controller started, in the order of
    /// [`shared_mem::words::Fault::NAMES`].
    pub faults: [u64; FAULTS],
    /// Bits of the realtime conditions that the system granted. `None` before the first batch.
    pub realtime: Option<u32>,
}

impl TickHealth {
    /// Takes a batch. If its count of records is invalid, the records are left out.
    pub fn take(&mut self, batch: &TimingBatch) {
        let records = batch.records().unwrap_or(&[]);
        for record in records {
            if self.recent.len() == WINDOW {
                self.recent.pop_front();
            }
            self.recent
                .push_back([record.wake_latency_ns, record.tick_ns]);
        }
        if let Some(newest) = records.last() {
            self.note_rate(newest);
        }
        self.missed = batch.missed_periods;
        self.late_ticks = batch.late_ticks;
        self.allocations = batch.allocations;
        self.page_faults = batch.page_faults;
        self.faults = batch.faults;
        self.realtime = Some(batch.realtime);
    }

    fn note_rate(&mut self, newest: &TickRecord) {
        let now = (newest.tick, newest.scheduled_ns);
        let Some(last) = self.last.replace(now) else {
            return;
        };
        let (ticks, ns) = (now.0.wrapping_sub(last.0), now.1.wrapping_sub(last.1));
        // A restarted controller counts from zero, so the pair of batches around the restart gives
        // no rate.
        if now.0 > last.0 && now.1 > last.1 {
            let rate = ticks as f32 / (ns as f32 * 1e-9);
            self.rate_hz += (rate - self.rate_hz) * if self.rate_hz == 0.0 { 1.0 } else { 0.2 };
        }
    }

    /// Wake-up delay and duration of a tick over the last four seconds, µs: 99th percentile and
    /// maximum of each.
    #[must_use]
    pub fn quantiles_us(&self) -> Option<[[f32; 2]; 2]> {
        if self.recent.is_empty() {
            return None;
        }
        Some([0, 1].map(|which| {
            let mut values: Vec<u32> = self.recent.iter().map(|pair| pair[which]).collect();
            values.sort_unstable();
            let at = (values.len() * 99 / 100).min(values.len() - 1);
            [values[at], values[values.len() - 1]].map(|ns| ns as f32 / 1000.0)
        }))
    }

    /// Name of each gate, in the order of the safety chain, and the number of ticks in which it
    /// acted.
    pub fn gates(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let count = |name: &str| {
            let named = Fault::NAMES.iter().zip(&self.faults);
            named
                .filter(|(own, _)| **own == name)
                .map(|(_, count)| *count)
                .sum()
        };
        GATES.into_iter().map(move |name| (name, count(name)))
    }

    /// Share of the ticks in each bar. With `which` 0 the bars count wake-up delays, with 1 the
    /// durations of ticks.
    pub(super) fn bars(&self, which: usize) -> [f64; BARS] {
        let mut bars = [0.0; BARS];
        for pair in &self.recent {
            let ns = pair.get(which).copied().unwrap_or(0);
            let us = (ns / 1000).max(1);
            bars[(us.ilog2() as usize).min(BARS - 1)] += 1.0 / self.recent.len() as f64;
        }
        bars
    }

    /// Missing conditions of real time, as ids of messages in [`crate::words`].
    #[must_use]
    pub fn lacks(&self) -> Vec<&'static str> {
        let Some(bits) = self.realtime else {
            return Vec::new();
        };
        let wanted = [
            (TimingBatch::FIFO, "lacks-fifo"),
            (TimingBatch::LOCKED, "lacks-locked"),
            (TimingBatch::PINNED, "lacks-core"),
        ];
        let missing = wanted.into_iter().filter(|(bit, _)| bits & bit == 0);
        missing.map(|(_, name)| name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(first: u64, wake_ns: impl Fn(u64) -> u32) -> Box<TimingBatch> {
        let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
        batch.count = 50;
        for (i, record) in batch.records.iter_mut().take(50).enumerate() {
            record.tick = first + i as u64;
            record.scheduled_ns = record.tick * 1_000_000;
            record.wake_latency_ns = wake_ns(record.tick);
            record.tick_ns = 200_000;
        }
        batch
    }

    #[test]
    fn rate_and_quantiles_come_from_the_records() {
        let mut health = TickHealth::default();
        assert!(health.quantiles_us().is_none());
        for k in 0..20 {
            // Every 200th tick wakes 400 µs late, so the 99th percentile stays at 20 µs.
            let wake = |tick: u64| if tick % 200 == 7 { 400_000 } else { 20_000 };
            health.take(&batch(k * 50, wake));
        }
        let [wake, tick] = health.quantiles_us().unwrap();
        let found = [wake[0], wake[1], tick[0], tick[1]].map(|us| us.round() as i32);
        assert_eq!(found, [20, 400, 200, 200]);
        assert!((health.rate_hz - 1000.0).abs() < 1.0, "{}", health.rate_hz);
        assert!((health.bars(0).iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert_eq!(health.lacks().len(), 3);
    }

    #[test]
    fn every_gate_has_its_counter() {
        let mut health = TickHealth::default();
        let mut newest = batch(0, |_| 10_000);
        for (place, count) in newest.faults.iter_mut().enumerate() {
            *count = 1 << place;
        }
        health.take(&newest);
        let counted: Vec<u64> = health.gates().map(|(_, count)| count).collect();
        assert!(
            counted.iter().all(|count| count.count_ones() == 1),
            "{counted:?}"
        );
        assert_eq!(counted[7], 1 << 8, "stiffness_capped");
    }

    #[test]
    fn a_restarted_controller_does_not_disturb_the_rate() {
        let mut health = TickHealth::default();
        for first in [5000, 5050, 0, 50, 100] {
            health.take(&batch(first, |_| 10_000));
        }
        assert!((health.rate_hz - 1000.0).abs() < 1.0, "{}", health.rate_hz);
    }
}
