//! Keeps the worst times of each time step of a run. Memory is bounded, because a longer
//! run has longer steps.

use serde::{Deserialize, Serialize};
use shared_mem::message::STAGES;

/// Largest number of steps kept. When the run needs more, each pair becomes one step of twice the
/// length.
const STEPS_MAX: usize = 600;

/// Worst times of a step, ns; a pair in JSON.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "(u32, u32)", into = "(u32, u32)")]
pub struct Worst {
    /// Worst wake-up latency.
    pub wake_ns: u32,
    /// Longest tick.
    pub tick_ns: u32,
}

impl Worst {
    fn max(self, other: Self) -> Self {
        Self {
            wake_ns: self.wake_ns.max(other.wake_ns),
            tick_ns: self.tick_ns.max(other.tick_ns),
        }
    }
}

impl From<(u32, u32)> for Worst {
    fn from((wake_ns, tick_ns): (u32, u32)) -> Self {
        Self { wake_ns, tick_ns }
    }
}

impl From<Worst> for (u32, u32) {
    fn from(worst: Worst) -> Self {
        (worst.wake_ns, worst.tick_ns)
    }
}

/// Worst wake-up and longest tick of each step of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    /// Length of a step, s.
    pub step_s: u32,
    /// Worst times, one entry per step.
    pub worst_ns: Vec<Worst>,
    /// Longest time of each stage, one entry per step. Empty in reports of older versions.
    #[serde(default)]
    pub stages_ns: Vec<[u32; STAGES]>,
}

impl Default for Timeline {
    fn default() -> Self {
        Self {
            step_s: 1,
            worst_ns: Vec::new(),
            stages_ns: Vec::new(),
        }
    }
}

impl Timeline {
    /// Notes a tick at `at_s` seconds of measured time, with the times of its stages.
    pub fn note(&mut self, at_s: f64, now: Worst, stages_ns: [u32; STAGES]) {
        let mut step = self.step_of(at_s);
        while step >= STEPS_MAX {
            self.coarsen();
            step = self.step_of(at_s);
        }
        if self.worst_ns.len() <= step {
            self.worst_ns.resize(step + 1, Worst::default());
        }
        self.stages_ns.resize(self.worst_ns.len(), [0; STAGES]);
        if let Some(worst) = self.worst_ns.get_mut(step) {
            *worst = worst.max(now);
        }
        if let Some(worst) = self.stages_ns.get_mut(step) {
            *worst = longest(*worst, stages_ns);
        }
    }

    /// Appends the timeline of the next run. The run of this timeline lasted `seconds`.
    pub fn append(&mut self, seconds: f64, next: &Self) {
        for (i, &worst) in next.worst_ns.iter().enumerate() {
            let at_s = seconds + i as f64 * f64::from(next.step_s);
            let stages_ns = next.stages_ns.get(i).copied().unwrap_or_default();
            self.note(at_s, worst, stages_ns);
        }
    }

    /// The time that `of` selects, as a curve: start of each step, s, and its worst time, µs.
    pub fn course(&self, of: fn(&Worst) -> u32) -> Vec<(f64, f64)> {
        let steps = self.worst_ns.iter().enumerate();
        steps
            .map(|(i, worst)| {
                (
                    i as f64 * f64::from(self.step_s),
                    f64::from(of(worst)) / 1e3,
                )
            })
            .collect()
    }

    fn step_of(&self, at_s: f64) -> usize {
        // The clamp keeps the conversion in range. Real runs stay far below it.
        (at_s.clamp(0.0, 1e9) / f64::from(self.step_s.max(1))) as usize
    }

    fn coarsen(&mut self) {
        self.step_s = self.step_s.max(1).saturating_mul(2);
        let pairs = self.worst_ns.chunks(2);
        let worst = |pair: &[Worst]| pair.iter().fold(Worst::default(), |w, p| w.max(*p));
        self.worst_ns = pairs.map(worst).collect();
        let pairs = self.stages_ns.chunks(2);
        let worst = |pair: &[[u32; STAGES]]| pair.iter().fold([0; STAGES], |w, p| longest(w, *p));
        self.stages_ns = pairs.map(worst).collect();
    }
}

/// Longer time of each stage.
fn longest(mut a: [u32; STAGES], b: [u32; STAGES]) -> [u32; STAGES] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = (*a).max(b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_keeps_its_worst_in_few_steps() {
        let mut line = Timeline::default();
        for second in 0..86_400u32 {
            let worst = if second == 50_000 {
                9_999_999
            } else {
                second % 7
            };
            let mut stages_ns = [second % 7; STAGES];
            stages_ns[3] = worst;
            line.note(f64::from(second), Worst::from((worst, 1)), stages_ns);
        }
        assert!(line.worst_ns.len() <= STEPS_MAX && line.worst_ns.len() > STEPS_MAX / 2);
        let peak = line
            .worst_ns
            .iter()
            .position(|w| w.wake_ns == 9_999_999)
            .unwrap();
        assert_eq!(peak, 50_000 / line.step_s as usize);
        assert_eq!(line.stages_ns.len(), line.worst_ns.len());
        assert_eq!(line.stages_ns[peak], [6, 6, 6, 9_999_999, 6, 6, 6]);
        let mut twice = line.clone();
        twice.append(86_400.0, &line);
        assert_eq!(
            twice
                .worst_ns
                .iter()
                .filter(|w| w.wake_ns == 9_999_999)
                .count(),
            2
        );
    }
}
