//! Measures of felt quality, as OmniSurg's open haptic bench defines them (schema
//! `haptic-bench/v1`), at 1 kHz instead of 120 Hz.
//!
//! - **oscillation**: largest and rms amplitude of the acting force from 20 to 300 Hz, over the
//!   whole trial with a Hann window;
//! - **injected energy**: work of the acting force on the handle while the tip is in the wall;
//!   positive if the loop drives the hand;
//! - **rise time**: from the first tick in the wall to 90 % of the largest force, the mean over
//!   contacts of four ticks or more;
//! - **drag**: mean size of the acting force outside of the wall;
//! - **jerk**: rms of the third derivative of the handle's place relative to the hand's target;
//! - **depth**: largest depth of the handle in the wall.

use super::device::{Device, Hand, Loop};
use super::law::{Law, START_M};

/// Band of oscillations that a hand feels, Hz.
const BAND_HZ: [f64; 2] = [20.0, 300.0];
/// Time between two ticks, s.
const TICK_S: f64 = 1e-3;
/// Duration of each part of a trial, s: waving in free air, way in, hold, way out, rest.
const PARTS_S: [f64; 5] = [1.0, 0.3, 1.0, 0.3, 0.4];
/// Path of the waving hand, m: up from the start and back.
const WAVE_M: f64 = 0.01;
/// Fewest ticks of a contact that has a rise time.
const CONTACT_TICKS: usize = 4;
/// Share of the largest force at which a contact counts as risen.
const RISEN: f64 = 0.9;

/// Forces and places in each tick of a trial.
#[derive(Debug, Default)]
pub(super) struct Course {
    /// Acting force of the motors, N.
    force_n: Vec<f64>,
    /// Place of the handle, m; negative in the wall.
    x_m: Vec<f64>,
    v_m_s: Vec<f64>,
    /// Place of the handle relative to the hand's target, m.
    off_m: Vec<f64>,
}

/// The measures of one trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Felt {
    /// Largest amplitude in the band, N.
    pub(super) peak_n: f64,
    /// Rms amplitude in the band, N.
    pub(super) rms_n: f64,
    pub(super) injected_j: f64,
    /// `None` without a contact.
    pub(super) rise_s: Option<f64>,
    pub(super) drag_n: f64,
    pub(super) jerk_m_s3: f64,
    pub(super) deepest_m: f64,
}

/// A hand waves in free air, presses a wall of `stiffness_n_m` at 0 with about `press_n`, holds,
/// and leaves.
pub(super) fn stroke(
    law: &mut dyn Law,
    device: Device,
    hand: Hand,
    [press_n, stiffness_n_m]: [f64; 2],
) -> Felt {
    let mut handle = Loop::new(device, hand, START_M);
    let goal_m = -press_n / stiffness_n_m - press_n / hand.stiffness_n_m;
    let mut course = Course::default();
    let ticks = (PARTS_S.iter().sum::<f64>() / TICK_S).round() as u32;
    for tick in 0..ticks {
        let target_m = target_m(f64::from(tick) * TICK_S, goal_m);
        let sample = handle.sample();
        let force_n = law.force_n(sample);
        handle.tick(force_n, target_m, 0.0);
        course.force_n.push(handle.acting_n);
        course.x_m.push(handle.x_m);
        course.v_m_s.push(handle.v_m_s);
        course.off_m.push(handle.x_m - target_m);
    }
    Felt::of(&course)
}

/// Place of the hand's target at this time, m.
fn target_m(at_s: f64, goal_m: f64) -> f64 {
    let [wave_s, in_s, hold_s, out_s, _] = PARTS_S;
    let smooth = |share: f64| share * share * (3.0 - 2.0 * share);
    let way = |from_s: f64, long_s: f64| smooth(((at_s - from_s) / long_s).clamp(0.0, 1.0));
    let up_m = if at_s < wave_s {
        0.5 * WAVE_M * (1.0 - (std::f64::consts::TAU * 2.0 * at_s / wave_s).cos())
    } else {
        0.0
    };
    let in_share = way(wave_s, in_s) - way(wave_s + in_s + hold_s, out_s);
    START_M + up_m + (goal_m - START_M) * in_share
}

impl Felt {
    fn of(course: &Course) -> Self {
        let [peak_n, rms_n] = oscillation_n(&course.force_n);
        let inside = || course.x_m.iter().map(|x_m| *x_m < 0.0);
        let powers = course.force_n.iter().zip(&course.v_m_s);
        let works = powers.map(|(force_n, v_m_s)| force_n * v_m_s * TICK_S);
        let injected_j = works.zip(inside()).filter(|it| it.1).map(|it| it.0).sum();
        let outside = course.force_n.iter().zip(inside());
        let drags: Vec<f64> = outside
            .filter(|(_, is_inside)| !is_inside)
            .map(|(force_n, _)| force_n.abs())
            .collect();
        Self {
            peak_n,
            rms_n,
            injected_j,
            rise_s: rise_s(course),
            drag_n: drags.iter().sum::<f64>() / drags.len().max(1) as f64,
            jerk_m_s3: jerk_m_s3(&course.off_m),
            deepest_m: course.x_m.iter().map(|x_m| -x_m).fold(0.0, f64::max),
        }
    }
}

/// Largest and rms amplitude of a force within the band, N (Goertzel's algorithm, bin by bin).
fn oscillation_n(force_n: &[f64]) -> [f64; 2] {
    let count = force_n.len() as f64;
    let mean = force_n.iter().sum::<f64>() / count;
    let turn = std::f64::consts::TAU / (count - 1.0);
    let window = |i: usize| 0.5 - 0.5 * (turn * i as f64).cos();
    let windowed: Vec<f64> = force_n
        .iter()
        .enumerate()
        .map(|(i, n)| (n.abs() - mean.abs()) * window(i))
        .collect();
    let scale = 2.0 / (0..force_n.len()).map(window).sum::<f64>();
    let bins = BAND_HZ.map(|hz| hz * TICK_S * count);
    let (mut peak, mut sum, mut number) = (0.0_f64, 0.0, 0.0);
    for bin in (bins[0].ceil() as usize)..=(bins[1].floor() as usize) {
        let coefficient = 2.0 * (std::f64::consts::TAU * bin as f64 / count).cos();
        let (mut last, mut before) = (0.0, 0.0);
        for value in &windowed {
            (last, before) = (value + coefficient * last - before, last);
        }
        let power = last * last + before * before - coefficient * last * before;
        let amplitude = scale * power.max(0.0).sqrt();
        peak = peak.max(amplitude);
        sum += amplitude * amplitude;
        number += 1.0;
    }
    [peak, (sum / f64::max(number, 1.0)).sqrt()]
}

/// Mean time from the first tick of a contact to 90 % of its largest force, s.
fn rise_s(course: &Course) -> Option<f64> {
    let mut times = Vec::new();
    let mut contact: Vec<f64> = Vec::new();
    let after = std::iter::once((0.0, 0.0));
    let all = course
        .x_m
        .iter()
        .copied()
        .zip(course.force_n.iter().copied());
    for (x_m, force_n) in all.chain(after) {
        if x_m < 0.0 {
            contact.push(force_n.abs());
            continue;
        }
        let largest = contact.iter().copied().fold(0.0, f64::max);
        if contact.len() >= CONTACT_TICKS && largest > 1e-6 {
            let risen = contact.iter().position(|n| *n >= RISEN * largest);
            times.push((risen.unwrap_or(0) + 1) as f64 * TICK_S);
        }
        contact.clear();
    }
    (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
}

/// Rms of the third difference over the cube of a tick, m/s³.
fn jerk_m_s3(off_m: &[f64]) -> f64 {
    let thirds = off_m.windows(4).map(|it| {
        let third = it[3] - 3.0 * it[2] + 3.0 * it[1] - it[0];
        (third / TICK_S.powi(3)).powi(2)
    });
    let count = thirds.len().max(1) as f64;
    (thirds.sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Course of 2 s. The force is 1 N with a ripple of `ripple_n` at `hz`. After half a second,
    /// the handle is pushed in at 0.1 m/s and then held.
    fn course(ripple_n: f64, hz: f64) -> Course {
        let mut made = Course::default();
        for tick in 0..2000 {
            let at_s = f64::from(tick) * TICK_S;
            let depth_m = ((at_s - 0.5).max(0.0) * 0.1).min(0.01);
            let ripple = ripple_n * (std::f64::consts::TAU * hz * at_s).sin();
            made.force_n.push(100.0 * depth_m + ripple);
            made.x_m.push(1e-9 - depth_m);
            made.v_m_s.push(if (0.5..0.6).contains(&at_s) {
                -0.1
            } else {
                0.0
            });
            made.off_m.push(0.5 * at_s.powi(3));
        }
        made
    }

    #[test]
    fn measures_by_hand() {
        let still = Felt::of(&course(0.0, 50.0));
        let rippled = Felt::of(&course(0.1, 50.0));
        assert!(still.peak_n < 0.01, "{still:?}");
        assert!((rippled.peak_n - 0.1).abs() < 0.01, "{rippled:?}");
        let outside = Felt::of(&course(0.1, 400.0));
        assert!(
            outside.peak_n < 0.01,
            "400 Hz is not in the band: {outside:?}"
        );
        // The hand pushes 10 mm against 0 to 1 N: the force does −5 mJ.
        assert!((still.injected_j + 0.005).abs() < 1e-4, "{still:?}");
        // 90 % of the force is reached after 90 of 100 ms.
        assert!((still.rise_s.unwrap() - 0.09).abs() < 0.002, "{still:?}");
        assert!(still.drag_n < 1e-9 && (rippled.drag_n - 0.0637).abs() < 0.003);
        // The third derivative of t³/2 is 3.
        assert!((still.jerk_m_s3 - 3.0).abs() < 0.01, "{still:?}");
        assert!((still.deepest_m - 0.01).abs() < 1e-6);
    }
}
