//! Forces along one axis from which the handle's inertia, damping, friction and delay follow: a
//! chirp, and a push with a run-out. During a run-out, the handle coasts without a driving force.

use std::f64::consts::TAU;

use super::bench::{Bench, HandleState, TickRecord, Vector};
use super::halt::Halt;
use super::hold::Hold;

/// First and last frequency of a chirp, Hz. Damping is measured best at the first frequency, delay
/// at the last: on 45 g, a delay of 0.1 ms has the effect of a damping of 0.003 N s/m at 4 Hz, but
/// of 0.4 N s/m at 50 Hz.
const CHIRP_HZ: [f64; 2] = [4.0, 50.0];
/// Length of a chirp, s.
const CHIRP_S: f64 = 2.0;
/// Time over which the amplitude of a chirp grows at its start and fades at its end, s.
const FADE_S: f64 = 0.2;
/// Largest speed that an experiment aims at, m/s: half of the speed that ends the experiment.
const SPEED_M_S: f64 = 0.25;
/// Speeds between which a force along the movement fades to zero, m/s. Without this limit, the
/// handle would move up to twice as fast at the start of a chirp, or if friction is less than
/// expected.
const GOVERNED_M_S: [f64; 2] = [0.25, 0.4];
/// Largest amplitude of movement that a chirp aims at, as a share of the region. The region is the
/// radius in which experiments take place.
const AMPLITUDE: f64 = 0.15;
/// Stiffness of the spring that keeps a chirp in its place, N/m. The spring's force is a small part
/// of the inertial forces.
const CENTRE_N_M: f64 = 15.0;
/// Largest distance of the handle from the start of a chirp, as a share of the region.
const CHIRP_EXCURSION_MAX: f64 = 0.5;
/// Share of the remaining force that an experiment uses along its axis.
const FORCE_SHARE: f64 = 0.95;
/// Smallest force beyond friction and weight with which the experiments work, N.
const MOVING_MIN_N: f64 = 0.03;
/// Distance over which a push accelerates the handle to its speed, m.
const PUSH_M: f64 = 0.006;
/// Largest distance of a run-out, as a share of the region.
const RUN_OUT: f64 = 0.25;
/// Longest push, s.
const PUSH_S: f64 = 0.2;
/// Time over which the force of a push grows to its full value, s.
const GROW_S: f64 = 0.01;
/// Longest run-out, s.
const RUN_OUT_S: f64 = 0.8;
/// Largest speed at which the handle counts as still, m/s.
const STILL_M_S: f64 = 0.004;
/// Time for which the handle must be still before a run-out ends, s.
const STILL_S: f64 = 0.02;

/// Rough values of an axis, from the break-away experiment.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoughEstimate {
    /// Mass, kg.
    pub(super) mass_kg: f64,
    /// Friction, N.
    pub(super) friction_n: f64,
}

/// Force along `axis` that remains after the forces that carry the weight, N.
fn available_n(bench: &Bench<'_>, hold: &Hold, axis: usize) -> f64 {
    let most_n = bench.limits().along_n(axis, &hold.carries_n);
    FORCE_SHARE * (most_n - hold.carries_n[axis].abs())
}

/// True if the permitted force moves the handle well.
pub(super) fn is_movable(
    bench: &Bench<'_>,
    hold: &Hold,
    axis: usize,
    rough: &RoughEstimate,
) -> bool {
    available_n(bench, hold, axis) >= rough.friction_n + MOVING_MIN_N
}

/// The force of `hold`, with its part along `axis` replaced by `along_n`.
fn with_axis(hold: &Hold, now: &HandleState, axis: usize, along_n: f64) -> Vector {
    let mut force_n = hold.force_n(now);
    force_n[axis] = along_n;
    force_n
}

/// `force_n`, reduced where it would make a fast handle faster.
fn speed_limited_n(force_n: f64, v_m_s: f64) -> f64 {
    if force_n * v_m_s <= 0.0 {
        return force_n;
    }
    let [from, to] = GOVERNED_M_S;
    force_n * ((to - v_m_s.abs()) / (to - from)).clamp(0.0, 1.0)
}

/// Shakes the handle, first slowly, then fast. `sign` is the first direction.
pub(super) fn chirp(
    bench: &mut Bench<'_>,
    hold: &Hold,
    axis: usize,
    rough: &RoughEstimate,
    sign: f64,
) -> Result<Vec<TickRecord>, Halt> {
    let start = bench.now();
    let amplitude_m = AMPLITUDE * bench.reach_m(axis);
    let available_n = available_n(bench, hold, axis);
    let first_hz = CHIRP_HZ[0].max(SPEED_M_S / (TAU * amplitude_m));
    let octaves = (CHIRP_HZ[1] / first_hz).ln();
    bench.limit_excursion(start.at_m, CHIRP_EXCURSION_MAX * bench.reach_m(axis));
    bench.start_record();
    let mut now = start;
    loop {
        let at_s = now.at_s - start.at_s;
        if at_s >= CHIRP_S {
            break;
        }
        let share = at_s / CHIRP_S;
        let turn = TAU * first_hz * (octaves * share).exp();
        let phase = TAU * first_hz * CHIRP_S / octaves * ((octaves * share).exp() - 1.0);
        // Force that overcomes friction and inertia at the speed aimed at.
        let amplitude_n = (rough.friction_n + rough.mass_kg * turn * SPEED_M_S).min(available_n);
        let fade = (at_s / FADE_S).min((CHIRP_S - at_s) / FADE_S).min(1.0);
        let off_m = now.at_m[axis] - start.at_m[axis];
        let swing_n = sign * fade * amplitude_n * phase.cos() - CENTRE_N_M * off_m;
        let swing_n = speed_limited_n(swing_n, now.v_m_s[axis]).clamp(-available_n, available_n);
        let along_n = hold.carries_n[axis] + swing_n;
        now = bench.tick(with_axis(hold, &now, axis, along_n))?;
    }
    bench.clear_excursion_limit();
    Ok(bench.take_record())
}

/// A push and the run-out after it.
#[derive(Debug, Clone)]
pub(super) struct Push {
    /// Record from the start of the push.
    pub(super) steps: Vec<TickRecord>,
    /// Time at which the push ended, s.
    pub(super) released_s: f64,
}

/// Pushes the handle in the direction `sign`, then lets it run out under the force that carries it.
pub(super) fn push(
    bench: &mut Bench<'_>,
    hold: &Hold,
    axis: usize,
    rough: &RoughEstimate,
    sign: f64,
) -> Result<Push, Halt> {
    let start = bench.now();
    let run_out_m = RUN_OUT * bench.reach_m(axis);
    // Friction alone must stop the handle within two thirds of `run_out_m`.
    let stopped_m_s = (1.3 * rough.friction_n / rough.mass_kg * run_out_m).sqrt();
    let goal_m_s = SPEED_M_S.min(stopped_m_s);
    let push_n = rough.friction_n + rough.mass_kg * goal_m_s.powi(2) / (2.0 * PUSH_M);
    let push_n = push_n.min(available_n(bench, hold, axis));
    bench.limit_excursion(start.at_m, 2.0 * run_out_m);
    bench.start_record();
    let carries_n = hold.carries_n[axis];
    let mut now = start;
    loop {
        let at_s = now.at_s - start.at_s;
        let way_m = (now.at_m[axis] - start.at_m[axis]).abs();
        let is_fast = now.v_m_s[axis].abs() >= goal_m_s;
        if is_fast || way_m >= 0.5 * run_out_m || at_s >= PUSH_S {
            break;
        }
        let along_n = carries_n + sign * push_n * (at_s / GROW_S).min(1.0);
        now = bench.tick(with_axis(hold, &now, axis, along_n))?;
    }
    let released_s = now.at_s;
    let mut still_s = now.at_s;
    while now.at_s - released_s < RUN_OUT_S && now.at_s - still_s < STILL_S {
        let way_m = (now.at_m[axis] - start.at_m[axis]).abs();
        if way_m >= 1.5 * run_out_m {
            break;
        }
        now = bench.tick(with_axis(hold, &now, axis, carries_n))?;
        if now.v_m_s[axis].abs() > STILL_M_S {
            still_s = now.at_s;
        }
    }
    bench.clear_excursion_limit();
    Ok(Push {
        steps: bench.take_record(),
        released_s,
    })
}
