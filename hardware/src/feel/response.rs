//! Applies force steps, a sine and a chirp, and records the position. Only the steps are judged.

use rt_core::math::Vec3;

use super::Step;
use super::bench::{Bench, EndReason};
use crate::conformance::Report;

/// Amplitude of the force to and fro, N.
const FORCE_N: f32 = 0.5;
/// Time between two steps, ms.
const STEP_MS: u32 = 300;
const STEPS: u32 = 8;
/// Frequency of the sine, Hz.
const SINE_HZ: f32 = 2.0;
/// Length of the sine, ms.
const SINE_MS: u32 = 2500;
/// First and last frequency of the chirp, Hz.
const CHIRP_HZ: (f32, f32) = (1.0, 30.0);
/// Length of the chirp, ms.
const CHIRP_MS: u32 = 4000;
/// Smallest displacement (see [`step_displacement_m`]) that is judged, m. A smaller one may be
/// noise or backlash.
const ANSWER_MIN_M: f32 = 0.2e-3;

/// A moment of the response, along x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Time since the response began, s.
    pub at_s: f32,
    /// Commanded force, N.
    pub force_n: f32,
    /// Position, m.
    pub position_m: f32,
}

/// Force along x at this time, as a share of the amplitude.
fn force_share(ms: u32) -> f32 {
    let turn = core::f32::consts::TAU;
    let steps_ms = STEPS * STEP_MS;
    if ms < steps_ms {
        return if (ms / STEP_MS).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
    }
    let ms = ms - steps_ms;
    if ms < SINE_MS {
        return (turn * SINE_HZ * ms as f32 * 1e-3).sin();
    }
    let s = (ms - SINE_MS) as f32 * 1e-3;
    let (from_hz, to_hz) = CHIRP_HZ;
    let rate = (to_hz - from_hz) / (CHIRP_MS as f32 * 1e-3);
    (turn * (from_hz * s + 0.5 * rate * s * s)).sin()
}

/// Pushes to and fro along x and judges whether the handle follows the steps. `points` gets the
/// recording, even if the pushes end early.
pub(super) fn test(
    bench: &mut Bench<'_>,
    report: &mut Report,
    points: &mut Vec<Point>,
) -> Result<(), EndReason> {
    bench.until_done(&Step::Hold, Vec3::zeros(), |_| {})?;
    bench.guide().tell(&Step::Response);
    let force_n = bench.permitted_n(FORCE_N);
    let all_ms = STEPS * STEP_MS + SINE_MS + CHIRP_MS;
    let command = |ms: u32| Vec3::x() * (force_n * force_share(ms));
    bench.push(all_ms, command, |ms, seen| {
        points.push(Point {
            at_s: ms as f32 * 1e-3,
            force_n: command(ms).x,
            position_m: seen.at_m.x,
        });
    })?;
    let answer_m = step_displacement_m(points);
    let words = format!(
        "steps of ±{force_n:.1} N along x move the handle by {:.2} mm",
        answer_m * 1e3
    );
    if answer_m.abs() < ANSWER_MIN_M {
        let why = format!(
            "{words}: too little. Hold the handle more loosely and test again. If it still does not move, \
             its friction exceeds the force"
        );
        report.mark_not_judged("response", &why);
    } else {
        let good = answer_m > 0.0;
        let why = if good {
            ""
        } else {
            ": against the force. Force or positions have the wrong sign"
        };
        report.judge("response", good, format!("{words}{why}"));
    }
    Ok(())
}

/// Mean position in the second halves of the steps to the right, minus that in the second halves of
/// the steps to the left, m.
fn step_displacement_m(points: &[Point]) -> f32 {
    let end_of = |is_right: bool| {
        let ends: Vec<f32> = points
            .iter()
            .filter(|it| {
                let ms = (it.at_s * 1e3) as u32;
                let is_end = ms % STEP_MS > STEP_MS / 2 && ms < STEPS * STEP_MS;
                is_end && (it.force_n > 0.0) == is_right
            })
            .map(|it| it.position_m)
            .collect();
        ends.iter().sum::<f32>() / ends.len().max(1) as f32
    };
    end_of(true) - end_of(false)
}
