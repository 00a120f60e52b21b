//! Black box: keeps the ticks around the most delayed ones, in constant memory.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use shared_mem::message::{STAGES, TickRecord};

use crate::slice::Slice;

/// Number of ticks kept before the late tick that opens an incident, and after it.
const AROUND: usize = 16;
/// Largest number of incidents kept.
const INCIDENTS_MAX: usize = 32;

/// A tick with its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tick {
    /// Number of the tick.
    pub tick: u64,
    /// Due time, `CLOCK_MONOTONIC`.
    pub scheduled_ns: u64,
    /// Wake-up latency: actual minus scheduled wake-up.
    pub wake_latency_ns: u32,
    /// Duration of the tick.
    pub tick_ns: u32,
    /// Whole periods skipped before the tick began.
    pub missed: u32,
    /// Time of each stage, in the order of a tick.
    pub stage_ns: [u32; STAGES],
    /// Flags: the constants of `TickRecord`.
    pub bits: u32,
}

impl Tick {
    /// Lateness of the tick: time from its due time to its end, whatever delayed it.
    pub fn late_ns(&self) -> u64 {
        u64::from(self.wake_latency_ns) + u64::from(self.tick_ns)
    }

    /// Time of its end, `CLOCK_MONOTONIC`.
    pub fn end_ns(&self) -> u64 {
        self.scheduled_ns.saturating_add(self.late_ns())
    }

    /// True if the tick ended after its deadline.
    pub fn overran(&self) -> bool {
        self.bits & TickRecord::OVERRAN != 0
    }

    /// True if the tick missed a deadline: it skipped periods or ended too late.
    pub fn is_miss(&self) -> bool {
        self.missed > 0 || self.overran()
    }
}

impl From<&TickRecord> for Tick {
    fn from(r: &TickRecord) -> Self {
        Self {
            tick: r.tick,
            scheduled_ns: r.scheduled_ns,
            wake_latency_ns: r.wake_latency_ns,
            tick_ns: r.tick_ns,
            missed: r.missed,
            stage_ns: r.stage_ns,
            bits: r.bits,
        }
    }
}

/// The ticks around a bad one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Incident {
    /// Time of the bad tick, ms. Only measured time counts; pauses between sessions do not.
    pub at_ms: u64,
    /// Index of the bad tick in `ticks`.
    pub worst: usize,
    /// Ticks in order.
    pub ticks: Vec<Tick>,
    /// Everything that ran on the tick's core meanwhile; empty without `--why`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slices: Vec<Slice>,
}

impl Incident {
    /// Returns the bad tick.
    pub fn peak(&self) -> Option<&Tick> {
        self.ticks.get(self.worst)
    }

    fn late_ns(&self) -> u64 {
        self.peak().map_or(0, Tick::late_ns)
    }
}

/// An incident that still waits for the ticks after it.
#[derive(Debug)]
struct Open {
    incident: Incident,
    /// Ticks still to come.
    left: usize,
}

/// Keeps recent ticks and the worst incidents.
#[derive(Debug, Default)]
pub struct BlackBox {
    before: VecDeque<Tick>,
    open: Option<Open>,
    kept: Vec<Incident>,
}

impl BlackBox {
    /// Takes the next tick. `at_ms` is the time measured before it.
    pub fn note(&mut self, tick: Tick, at_ms: u64) {
        if let Some(Open { incident, left }) = &mut self.open {
            incident.ticks.push(tick);
            *left -= 1;
            if tick.late_ns() > incident.late_ns() {
                // A worse tick within an incident becomes its worst tick.
                incident.worst = incident.ticks.len() - 1;
                incident.at_ms = at_ms;
            }
            if *left == 0 {
                self.close();
            }
        } else if tick.late_ns() > self.least_ns() {
            let mut ticks: Vec<Tick> = self.before.iter().copied().collect();
            ticks.push(tick);
            let worst = ticks.len() - 1;
            let incident = Incident {
                at_ms,
                worst,
                ticks,
                slices: Vec::new(),
            };
            self.open = Some(Open {
                incident,
                left: AROUND,
            });
        }
        if self.before.len() == AROUND {
            self.before.pop_front();
        }
        self.before.push_back(tick);
    }

    /// Closes the open incident and forgets earlier ticks, because the next tick belongs to a new
    /// run of the station.
    pub fn interrupt(&mut self) {
        self.close();
        self.before.clear();
    }

    /// Returns the worst incidents so far, worst first.
    pub fn incidents(&self) -> Vec<Incident> {
        let open = self.open.iter().map(|open| &open.incident);
        worst(self.kept.iter().chain(open).cloned().collect())
    }

    /// Gives slices to the finished incidents that have none. `between` finds the slices of a span
    /// of time. Skips incidents that ended after `known_to_ns`, because their slices are not known
    /// yet.
    pub fn explain(&mut self, known_to_ns: u64, between: impl Fn(u64, u64) -> Vec<Slice>) {
        for incident in self.kept.iter_mut().filter(|it| it.slices.is_empty()) {
            if let (Some(first), Some(last)) = (incident.ticks.first(), incident.ticks.last())
                && last.end_ns() <= known_to_ns
            {
                incident.slices = between(first.scheduled_ns, last.end_ns());
            }
        }
    }

    /// Lateness that a tick must exceed to open an incident, ns.
    fn least_ns(&self) -> u64 {
        match self.kept.len() < INCIDENTS_MAX {
            true => 0,
            false => self.kept.iter().map(Incident::late_ns).min().unwrap_or(0),
        }
    }

    fn close(&mut self) {
        if let Some(Open { incident, .. }) = self.open.take() {
            self.kept.push(incident);
            self.kept = worst(std::mem::take(&mut self.kept));
        }
    }
}

/// Sorts incidents worst first and keeps the worst.
pub fn worst(mut incidents: Vec<Incident>) -> Vec<Incident> {
    incidents.sort_by_key(|incident| core::cmp::Reverse(incident.late_ns()));
    incidents.truncate(INCIDENTS_MAX);
    incidents
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(number: u64, wake_latency_ns: u32) -> Tick {
        Tick {
            tick: number,
            scheduled_ns: number * 1_000_000,
            wake_latency_ns,
            tick_ns: 1000,
            missed: wake_latency_ns / 1_000_000,
            stage_ns: [100; STAGES],
            bits: 0,
        }
    }

    #[test]
    fn the_worst_ticks_are_kept_with_their_neighbours() {
        let mut recorder = BlackBox::default();
        for i in 0..100_000u64 {
            let wake_ns = if i % 1000 == 500 {
                2_000_000 + i as u32
            } else {
                3000 + (i % 7) as u32
            };
            recorder.note(tick(i, wake_ns), i);
        }
        let incidents = recorder.incidents();
        assert_eq!(incidents.len(), INCIDENTS_MAX);
        let peaks: Vec<u64> = incidents.iter().map(|i| i.peak().unwrap().tick).collect();
        let expected: Vec<u64> = (68..100).rev().map(|k| k * 1000 + 500).collect();
        assert_eq!(peaks, expected, "the latest are the worst here");
        for incident in &incidents {
            assert_eq!(
                (incident.ticks.len(), incident.worst),
                (2 * AROUND + 1, AROUND)
            );
            assert!(incident.peak().unwrap().is_miss());
            assert!(
                incident
                    .ticks
                    .windows(2)
                    .all(|p| p[1].tick == p[0].tick + 1)
            );
        }
    }

    #[test]
    fn ticks_after_a_miss_belong_to_it_and_an_open_incident_is_told() {
        let mut recorder = BlackBox::default();
        recorder.note(tick(0, 5_000_000), 0);
        recorder.note(tick(1, 9_000_000), 1);
        let incidents = recorder.incidents();
        assert_eq!(incidents.len(), 1);
        assert_eq!(incidents[0].peak().unwrap().tick, 1);
        recorder.interrupt();
        assert_eq!(recorder.incidents(), incidents);
    }
}
