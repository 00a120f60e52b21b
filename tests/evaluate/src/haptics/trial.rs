//! One trial: a hand presses, then the handle's motion is measured.

use super::device::{Device, Hand, Loop};
use super::law::{Law, START_M};

/// Time in which the hand moves to the wall, s.
const APPROACH_S: f64 = 0.3;
/// Time in which the handle may come to rest, s.
const SETTLE_S: f64 = 1.2;
/// Time in which the handle's motion is then measured, s.
const WATCH_S: f64 = 0.5;
/// Largest swing that nobody feels or sees, m: five encoder steps of a Touch.
pub(super) const STILL_M: f64 = 0.275e-3;

/// Outcome of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrialOutcome {
    /// Swing of the handle in the measured time, m.
    pub(super) swing_m: f64,
    /// Swing in the half second before it, m.
    pub(super) before_m: f64,
    /// Largest change of the command from one tick to the next in the measured time, N.
    pub(super) step_n: f64,
    /// Command at the end, N.
    pub(super) force_n: f64,
    /// Position of the handle at the end, m.
    pub(super) x_m: f64,
    /// Largest net work of the motors on the handle during the trial, J. A passive system does no
    /// positive net work from rest to rest.
    pub(super) given_j: f64,
    /// True if the law switched its force off.
    pub(super) gave_up: bool,
}

impl TrialOutcome {
    /// A handle that did not move.
    pub(super) const NONE: Self = Self {
        swing_m: 0.0,
        before_m: 0.0,
        step_n: 0.0,
        force_n: 0.0,
        x_m: 0.0,
        given_j: 0.0,
        gave_up: false,
    };

    /// True if the handle is still or its swing gets smaller, and the law did not switch its force
    /// off.
    pub(super) fn is_stable(&self) -> bool {
        let still = self.swing_m <= STILL_M || self.swing_m < 0.7 * self.before_m;
        still && !self.gave_up
    }
}

/// Presses with about `press_n` into a body of stiffness `stiffness_n_m`, and holds.
pub(super) fn press(
    law: &mut dyn Law,
    device: Device,
    hand: Hand,
    [press_n, stiffness_n_m]: [f64; 2],
) -> TrialOutcome {
    let mut handle = Loop::new(device, hand, START_M);
    let goal_m = if hand.stiffness_n_m > 0.0 {
        -press_n / stiffness_n_m - press_n / hand.stiffness_n_m
    } else {
        START_M
    };
    let ticks = ((APPROACH_S + SETTLE_S + WATCH_S) * 1e3) as u32;
    let watched = (WATCH_S * 1e3) as u32;
    // Lowest and highest position in the half second before the measured time, and during it.
    let mut range_m = [[f64::MAX, f64::MIN]; 2];
    let (mut last_n, mut step_n, mut given_j) = (0.0_f64, 0.0_f64, 0.0_f64);
    for tick in 0..ticks {
        let share = (f64::from(tick) * 1e-3 / APPROACH_S).min(1.0);
        let smooth = share * share * (3.0 - 2.0 * share);
        let target_m = START_M + (goal_m - START_M) * smooth;
        let pull_n = if hand.stiffness_n_m > 0.0 {
            0.0
        } else {
            -press_n * smooth
        };
        let sample = handle.sample();
        let force_n = law.force_n(sample);
        handle.tick(force_n, target_m, pull_n);
        given_j = given_j.max(handle.motor_j);
        if tick >= ticks - 2 * watched {
            let [low, high] = &mut range_m[usize::from(tick >= ticks - watched)];
            (*low, *high) = (low.min(handle.x_m), high.max(handle.x_m));
        }
        if tick >= ticks - watched {
            step_n = step_n.max((force_n - last_n).abs());
        }
        last_n = force_n;
    }
    TrialOutcome {
        swing_m: range_m[1][1] - range_m[1][0],
        before_m: range_m[0][1] - range_m[0][0],
        step_n,
        force_n: last_n,
        x_m: handle.x_m,
        given_j,
        gave_up: law.gave_up(),
    }
}

/// Largest force in free space, N, while the hand moves up and down above the wall at up to 0.25
/// m/s.
pub(super) fn wave(law: &mut dyn Law, device: Device) -> f64 {
    let mut handle = Loop::new(device, Hand::FIRM, START_M);
    let mut most_n = 0.0_f64;
    for tick in 0..2000 {
        let target_m = START_M + 0.01 * (1.0 - (25.0 * f64::from(tick) * 1e-3).cos());
        let sample = handle.sample();
        let force_n = law.force_n(sample);
        most_n = most_n.max(force_n.abs());
        handle.tick(force_n, target_m, 0.0);
    }
    most_n
}

/// Gain (N/m) and delay (s) of the force on a handle that moves sinusoidally by 0.5 mm at `hz`
/// around `depth_m`. The delay includes the device's own, and half a tick because a command is held
/// for a tick.
pub(super) fn respond(law: &mut dyn Law, device: Device, depth_m: f64, hz: f64) -> [f64; 2] {
    const AMPLITUDE_M: f64 = 0.5e-3;
    let turn = std::f64::consts::TAU * hz * 1e-3;
    let whole = (2000.0 * hz / 1e3).floor().max(1.0) * 1e3 / hz;
    let (mut cosine, mut sine) = (0.0, 0.0);
    for tick in 0..(500 + whole as u32) {
        let in_s = (f64::from(tick) / 300.0).min(1.0);
        let phase = turn * f64::from(tick);
        let x_m = START_M - (START_M + depth_m) * in_s + AMPLITUDE_M * phase.sin() * in_s;
        let step = device.encoder_m;
        let force_n = law.force_n(Some((x_m / step).round() * step));
        if tick >= 500 {
            sine -= force_n * phase.sin();
            cosine -= force_n * phase.cos();
        }
    }
    let ticks = f64::from(whole as u32);
    let gain = 2.0 * (sine * sine + cosine * cosine).sqrt() / (ticks * AMPLITUDE_M);
    let lag_s = (-cosine).atan2(sine) / (turn * 1e3) + device.delay_s + 0.5e-3;
    [gain, lag_s]
}
