//! Model of a handle along one axis, for the fit: mass, viscous damping, dry friction, a constant
//! force that carries the weight, and a delay.

use super::bench::TickRecord;

/// Length of a step of the mechanics, s. Within a step the force is constant and reversals are
/// exact. Only viscous damping has an error: 0.1 % for 0.2 N s/m on 45 g.
const STEP_S: f64 = 5e-4;

/// Number of parameters.
pub(super) const COUNT: usize = 5;

/// Parameters of a handle: `m a = F(t − delay) − carries − b v − f sign(v)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Model {
    /// Mass, kg.
    pub(super) mass_kg: f64,
    /// Viscous damping, N s/m.
    pub(super) damping_n_s_m: f64,
    /// Dry friction, N.
    pub(super) friction_n: f64,
    /// Force that carries the handle against its weight, N.
    pub(super) carries_n: f64,
    /// Delay from a command to the sample that shows the command's effect, s, without the time for
    /// which a command is held.
    pub(super) delay_s: f64,
}

/// Smallest mass that the fit may find, kg.
const MASS_MIN_KG: f64 = 1e-3;
/// Longest delay that the fit may find, s: the limit of our serial protocol.
pub(super) const DELAY_MAX_S: f64 = 0.05;

impl Model {
    pub(super) const fn parameters(&self) -> [f64; COUNT] {
        [
            self.mass_kg,
            self.damping_n_s_m,
            self.friction_n,
            self.carries_n,
            self.delay_s,
        ]
    }

    /// The model with these parameters, clamped to possible values.
    pub(super) const fn of([mass, damping, friction, carries, delay]: [f64; COUNT]) -> Self {
        Self {
            mass_kg: mass.max(MASS_MIN_KG),
            damping_n_s_m: damping,
            friction_n: friction.max(0.0),
            carries_n: carries,
            delay_s: delay.clamp(0.0, DELAY_MAX_S),
        }
    }

    /// Position and speed after a step under a constant force. Where the movement reverses,
    /// friction stops the handle. If the force exceeds friction, the handle then starts in the
    /// other direction.
    fn step(&self, [at_m, v_m_s]: [f64; 2], drive_n: f64, step_s: f64) -> [f64; 2] {
        let holds = drive_n.abs() <= self.friction_n;
        let direction = if v_m_s != 0.0 {
            v_m_s.signum()
        } else if holds {
            return [at_m, 0.0];
        } else {
            drive_n.signum()
        };
        let sum_n = drive_n - self.damping_n_s_m * v_m_s - self.friction_n * direction;
        let a_m_s2 = sum_n / self.mass_kg;
        let next_m_s = v_m_s + a_m_s2 * step_s;
        if next_m_s * direction >= 0.0 {
            return [at_m + 0.5 * (v_m_s + next_m_s) * step_s, next_m_s];
        }
        let stop_s = -v_m_s / a_m_s2;
        let stop_m = at_m + 0.5 * v_m_s * stop_s;
        if holds {
            return [stop_m, 0.0];
        }
        let rest_s = step_s - stop_s;
        let a_m_s2 = (drive_n - self.friction_n * drive_n.signum()) / self.mass_kg;
        [stop_m + 0.5 * a_m_s2 * rest_s * rest_s, a_m_s2 * rest_s]
    }

    /// Computes the positions, m, of a handle at the times of the window's samples. At the first
    /// sample the handle has the window's initial position and speed.
    pub(super) fn run(
        &self,
        axis_record: &AxisRecord,
        window: &Window,
        positions_m: &mut Vec<f64>,
    ) {
        positions_m.clear();
        let samples = window.of(axis_record);
        let Some(first) = samples.first() else { return };
        let (mut at_s, mut at_m, mut speed_m_s) = (first.0, window.from_m, window.speed_m_s);
        let mut sends = Cursor::new(axis_record, at_s - self.delay_s);
        let mut before_n_s = sends.impulse_n_s(at_s - self.delay_s);
        positions_m.push(at_m);
        for &(until_s, _) in &samples[1..] {
            let steps = ((until_s - at_s) / STEP_S).round().max(1.0);
            let step_s = (until_s - at_s) / steps;
            for step in 1..=steps as u32 {
                let now_s = at_s + f64::from(step) * step_s;
                let now_n_s = sends.impulse_n_s(now_s - self.delay_s);
                let drive_n = (now_n_s - before_n_s) / step_s - self.carries_n;
                before_n_s = now_n_s;
                let moved = self.step([at_m, speed_m_s], drive_n, step_s);
                [at_m, speed_m_s] = moved;
            }
            at_s = until_s;
            positions_m.push(at_m);
        }
    }
}

/// Record of one experiment along one axis.
#[derive(Debug, Clone)]
pub(super) struct AxisRecord {
    /// For each command: its time, s, its force, N, and the impulse of all commands before it, N s.
    sends: Vec<(f64, f64, f64)>,
    /// Times of samples, s, and their positions, m.
    pub(super) samples: Vec<(f64, f64)>,
}

impl AxisRecord {
    pub(super) fn new(steps: &[TickRecord], axis: usize) -> Self {
        let mut sends: Vec<(f64, f64, f64)> = Vec::with_capacity(steps.len());
        for step in steps {
            let impulse_n_s = sends.last().map_or(0.0, |(at_s, force_n, impulse_n_s)| {
                impulse_n_s + force_n * (step.at_s - at_s)
            });
            sends.push((step.at_s, step.force_n[axis], impulse_n_s));
        }
        let seen = |step: &TickRecord| step.at_m.map(|at_m| (step.at_s, at_m[axis]));
        Self {
            sends,
            samples: steps.iter().filter_map(seen).collect(),
        }
    }

    /// The record as if the motors rendered only `share` of each force beyond `carries_n`.
    pub(super) fn scaled(&self, carries_n: f64, share: f64) -> Self {
        let scaled = |(at_s, force_n, impulse_n_s): &(f64, f64, f64)| {
            let carried_n_s = carries_n * (at_s - self.begun_s());
            let force_n = carries_n + share * (force_n - carries_n);
            let impulse_n_s = carried_n_s + share * (impulse_n_s - carried_n_s);
            (*at_s, force_n, impulse_n_s)
        };
        Self {
            sends: self.sends.iter().map(scaled).collect(),
            samples: self.samples.clone(),
        }
    }

    fn begun_s(&self) -> f64 {
        self.sends.first().map_or(0.0, |send| send.0)
    }

    /// Force commanded at a time, N.
    pub(super) fn force_n(&self, at_s: f64) -> f64 {
        let next = self.sends.partition_point(|send| send.0 <= at_s);
        let send = self.sends.get(next.saturating_sub(1));
        send.map_or(0.0, |send| send.1)
    }
}

/// An index into the commands that moves forward with time.
struct Cursor<'a> {
    sends: &'a [(f64, f64, f64)],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn new(axis_record: &'a AxisRecord, from_s: f64) -> Self {
        let next = axis_record.sends.partition_point(|send| send.0 <= from_s);
        Self {
            sends: &axis_record.sends,
            at: next.saturating_sub(1),
        }
    }

    /// Impulse of all commands up to a time, N s. The first force counts as acting even before its
    /// command.
    fn impulse_n_s(&mut self, at_s: f64) -> f64 {
        while self
            .sends
            .get(self.at + 1)
            .is_some_and(|next| next.0 <= at_s)
        {
            self.at += 1;
        }
        let send = self.sends.get(self.at);
        send.map_or(0.0, |(from_s, force_n, before_n_s)| {
            before_n_s + force_n * (at_s - from_s)
        })
    }
}

/// A part of a record in which the model starts from its own position and speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Index of the first sample.
    from: usize,
    /// Index after the last sample.
    to: usize,
    /// Initial position of the model, m.
    pub(super) from_m: f64,
    /// Initial speed of the model, m/s.
    pub(super) speed_m_s: f64,
}

/// Length of a window, s: two periods of 25 Hz. The window is so long that its initial position and
/// speed use up only a little of its information.
const WINDOW_S: f64 = 0.08;
/// Longest gap between samples of a window, s. After a longer gap the handle may be anywhere.
const GAP_S: f64 = 0.005;
/// Fewest samples of a window.
const SAMPLES_MIN: usize = 12;
/// Number of samples from which a window's initial speed is guessed.
const START_SAMPLES: usize = 8;
/// Least movement in a window that the fit uses, m: several encoder steps.
const MOVEMENT_MIN_M: f64 = 0.2e-3;

impl Window {
    /// All windows of a record.
    pub(super) fn all(axis_record: &AxisRecord) -> Vec<Self> {
        let samples = &axis_record.samples;
        let mut windows = Vec::new();
        let mut from = 0;
        while let Some(first) = samples.get(from) {
            let within = samples[from..].partition_point(|it| it.0 - first.0 <= WINDOW_S);
            let pairs = samples[from..from + within].windows(2);
            let gap = pairs
                .into_iter()
                .position(|pair| pair[1].0 - pair[0].0 > GAP_S);
            let to = from + gap.map_or(within, |at| at + 1);
            windows.extend(Self::new(samples, from, to));
            from = to;
        }
        windows
    }

    fn new(samples: &[(f64, f64)], from: usize, to: usize) -> Option<Self> {
        let of = &samples[from..to];
        let reach = |pick: fn(f64, f64) -> f64, start| of.iter().map(|it| it.1).fold(start, pick);
        let moved_m = reach(f64::max, f64::MIN) - reach(f64::min, f64::MAX);
        if of.len() < SAMPLES_MIN || moved_m < MOVEMENT_MIN_M {
            return None;
        }
        let start = &of[..START_SAMPLES];
        let [mean_s, mean_m] = [
            start.iter().map(|it| it.0).sum::<f64>() / START_SAMPLES as f64,
            start.iter().map(|it| it.1).sum::<f64>() / START_SAMPLES as f64,
        ];
        let product = |it: &(f64, f64)| (it.0 - mean_s) * (it.1 - mean_m);
        let square = |it: &(f64, f64)| (it.0 - mean_s).powi(2);
        let speed_m_s =
            start.iter().map(product).sum::<f64>() / start.iter().map(square).sum::<f64>();
        Some(Self {
            from,
            to,
            from_m: mean_m + speed_m_s * (start[0].0 - mean_s),
            speed_m_s,
        })
    }

    /// The window from a time to the end of the record.
    pub(super) fn since(axis_record: &AxisRecord, from_s: f64) -> Option<Self> {
        let samples = &axis_record.samples;
        let from = samples.partition_point(|it| it.0 < from_s);
        Self::new(samples, from, samples.len())
    }

    /// The window's samples.
    pub(super) fn of<'a>(&self, axis_record: &'a AxisRecord) -> &'a [(f64, f64)] {
        axis_record
            .samples
            .get(self.from..self.to)
            .unwrap_or_default()
    }
}
