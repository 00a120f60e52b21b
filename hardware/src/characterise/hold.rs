//! A soft spring that holds the handle at the place of an experiment. Its integral term finds the
//! force that carries the handle's weight.

use super::bench::{Bench, HandleState, Vector};
use super::halt::Halt;
use super::limits::Limits;

/// Stiffness, N/m. Against 0.26 N of dry friction (Touch) it brings the handle to within about 4 mm
/// of its place.
pub(super) const STIFFNESS_N_M: f64 = 60.0;
/// Damping, N s/m: half of the critical damping of a handle of 45 g, a third for 120 g. With the
/// lag of the measured speed (4 ms) and a delay of 10 ms it is stable for handles of 30 g and more.
const DAMPING_N_S_M: f64 = 2.0;
/// Growth of the integral's force per distance and time, N/(m s).
const INTEGRAL_N_M_S: f64 = 150.0;
/// Distance below which the integral's force does not grow, m. Otherwise dry friction would cause a
/// limit cycle.
const NEAR_M: f64 = 1.0e-3;
/// Largest distance from its place at which the handle counts as held, m.
const HELD_M: f64 = 1.5e-3;
/// Largest speed at which the handle counts as held, m/s.
const STILL_M_S: f64 = 0.008;
/// Time for which the handle must be held, s.
const HELD_S: f64 = 0.2;
/// Longest time until the handle is held, s.
const PATIENCE_S: f64 = 6.0;
/// Speed at which the spring carries the handle to its place, m/s.
const CARRY_M_S: f64 = 0.06;
/// Longest distance between the spring's two ends, m; beyond it the experiment ends. On a device
/// whose force has the wrong sign, the spring drives the handle away. After the force is cut at
/// this distance, the handle coasts for less than 8 mm (Touch).
const EXCURSION_MAX_M: f64 = 0.012;

/// The spring.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    /// Place at which the spring holds the handle, m.
    pub(super) target_m: Vector,
    /// Force that carries the handle, N.
    pub(super) carries_n: Vector,
    /// Axes along which that force is known from break-away.
    known: [bool; 4],
    at_s: f64,
}

impl Hold {
    /// A spring without force at the handle's present place.
    pub(super) fn new(now: &HandleState) -> Self {
        Self {
            target_m: now.at_m,
            carries_n: Vector::zeros(),
            known: [false; 4],
            at_s: now.at_s,
        }
    }

    /// Sets the force that carries the handle along an axis, N, as break-away measured it. With
    /// another force, dry friction would balance the difference, and less friction would remain
    /// along the other axes.
    pub(super) fn set_holding(&mut self, axis: usize, carries_n: f64) {
        self.carries_n[axis] = carries_n;
        self.known[axis] = true;
    }

    /// Force now, N.
    pub(super) fn force_n(&self, now: &HandleState) -> Vector {
        (self.target_m - now.at_m) * STIFFNESS_N_M - now.v_m_s * DAMPING_N_S_M + self.carries_n
    }

    /// Force now, N, after the integral has grown.
    pub(super) fn integrated_n(&mut self, now: &HandleState, limits: &Limits) -> Vector {
        let passed_s = (now.at_s - self.at_s).clamp(0.0, 0.01);
        self.at_s = now.at_s;
        let off_m = self.target_m - now.at_m;
        if off_m.norm() > NEAR_M {
            self.carries_n += off_m * (INTEGRAL_N_M_S * passed_s);
            self.carries_n = limits.bounded_n(&self.carries_n);
        }
        self.force_n(now)
    }

    /// Holds the handle for a time.
    pub(super) fn keep(&mut self, bench: &mut Bench<'_>, seconds: f64) -> Result<(), Halt> {
        let mut now = bench.now();
        let begun_s = now.at_s;
        bench.limit_excursion(self.target_m, EXCURSION_MAX_M);
        while now.at_s - begun_s < seconds {
            let force_n = self.integrated_n(&now, bench.limits());
            now = bench.tick(force_n)?;
        }
        bench.clear_excursion_limit();
        Ok(())
    }

    /// Carries the handle to `goal_m` and waits until it is still. Afterwards the spring has no
    /// force, and [`Hold::carries_n`] alone holds the handle. Along each axis this force comes from
    /// break-away if that is known, otherwise from the integral.
    pub(super) fn settle(&mut self, bench: &mut Bench<'_>, goal_m: Vector) -> Result<(), Halt> {
        let mut now = bench.now();
        let known_n = self.carries_n;
        self.at_s = now.at_s;
        self.target_m = now.at_m;
        let begun_s = now.at_s;
        let (mut since_s, mut sum_n, mut count) = (now.at_s, Vector::zeros(), 0.0);
        loop {
            let before_s = now.at_s;
            let force_n = self.integrated_n(&now, bench.limits());
            bench.limit_excursion(self.target_m, EXCURSION_MAX_M);
            now = bench.tick(force_n)?;
            let passed_s = (now.at_s - before_s).clamp(0.0, 0.01);
            let way_m = goal_m - self.target_m;
            self.target_m += way_m * (CARRY_M_S * passed_s / way_m.norm().max(1e-9)).min(1.0);
            let is_held = (now.at_m - goal_m).norm() <= HELD_M && now.v_m_s.norm() <= STILL_M_S;
            if !is_held {
                (since_s, sum_n, count) = (now.at_s, Vector::zeros(), 0.0);
                if now.at_s - begun_s > PATIENCE_S {
                    bench.cut();
                    let off_m = now.at_m - goal_m;
                    return Err(Halt::Unheld {
                        force_n: bench.limits().of(off_m.iamax()),
                        allowed_mm: HELD_M * 1e3,
                    });
                }
                continue;
            }
            sum_n += force_n;
            count += 1.0;
            if now.at_s - since_s >= HELD_S {
                let found_n = sum_n / count;
                self.carries_n = Vector::from_fn(|axis, _| {
                    if self.known[axis] {
                        known_n[axis]
                    } else {
                        found_n[axis]
                    }
                });
                self.target_m = now.at_m;
                bench.clear_excursion_limit();
                return Ok(());
            }
        }
    }
}
