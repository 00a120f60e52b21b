//! A virtual wall that a person taps and presses lightly with the handle, or with the fingers in a
//! handle that opens. It becomes stiffer until it buzzes.
//!
//! The handle meets every wall from above. If it rested in a wall that becomes stiffer, dry
//! friction would hide the limit: a Touch then stays still up to three times the stiffness at which
//! it buzzes after a tap.

use rt_core::port::HapticDevice;

use super::bench::{Bench, Clock};
use super::buzz::Buzz;
use super::halt::Halt;
use super::place::Place;

/// Stiffness of the softest wall, N/m. The walls of `evaluate haptics` begin with this one too.
const SOFTEST_N_M: f64 = 100.0;
/// Stiffness of the stiffest wall, N/m. The walls of `evaluate haptics` end with this one too.
pub const STIFFEST_N_M: f64 = 20e3;
/// The search ends when the softest wall that buzzed is at most this many times as stiff as the
/// stiffest wall that did not buzz.
const RATIO: f64 = 1.1;
/// Time for which a person must press a wall without a buzz before the wall counts as still, s.
const STILL_S: f64 = 0.8;
/// Time for which the handle must be above the wall before the next one, s.
const ABOVE_S: f64 = 0.1;
/// Least and largest force of a press that counts, as shares of the force limit. At the limit the
/// force no longer grows with depth, which would hide the stiffness.
const PRESSURE: [f64; 2] = [0.1, 0.95];
/// Longest wait for a person, s.
const PATIENCE_S: f64 = 30.0;
/// Interval at which a person is asked again, s.
const ASK_S: f64 = 5.0;

/// A wall and its outcome.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Frequency, Hz, and swing, m, of the buzz. `None` if the wall was still.
    pub buzz: Option<(f64, f64)>,
}

/// Result of all walls.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Wall {
    /// All trials in their order.
    pub trials: Vec<Trial>,
    /// Stiffest wall that was still, N/m.
    pub still_n_m: Option<f64>,
    /// Softest wall that buzzed, N/m.
    pub buzzes_n_m: Option<f64>,
    /// True if nobody lifted or pressed the handle in time, so that the search ended early.
    pub was_left: bool,
}

impl Wall {
    /// Stiffness of the next wall, N/m. It doubles until a wall buzzes. Then it is the geometric
    /// mean of the stiffest still wall and the softest that buzzed. `None` ends the search.
    fn next_n_m(&self) -> Option<f64> {
        match (self.still_n_m, self.buzzes_n_m) {
            (None, None) => Some(SOFTEST_N_M),
            (None, Some(_)) => None,
            (Some(still), None) => (still < STIFFEST_N_M).then(|| (2.0 * still).min(STIFFEST_N_M)),
            (Some(still), Some(buzzes)) => {
                (buzzes > RATIO * still).then(|| (still * buzzes).sqrt())
            }
        }
    }

    fn note(&mut self, trial: Trial) {
        let stiffness = Some(trial.stiffness_n_m);
        match trial.buzz {
            None => self.still_n_m = stiffness,
            Some(_) => self.buzzes_n_m = stiffness,
        }
        self.trials.push(trial);
    }
}

/// Outcome of one wall.
enum WallOutcome {
    Still,
    Buzzed(f64, f64),
    Abandoned,
}

/// Renders one wall after another at a place, and asks a person to press each. `force_n` is the
/// largest force that a person allows.
pub fn wall(
    device: &mut dyn HapticDevice,
    clock: &mut dyn Clock,
    place: Place,
    force_n: Option<f64>,
    tell: &mut dyn FnMut(&str),
) -> Result<Wall, Halt> {
    let mut bench = Bench::new(device, clock, force_n)?;
    if place == Place::Opening {
        bench.begin_opening()?;
    }
    let mut walls = Wall::default();
    // A wall that was still is rendered until the handle is above it. A wall that buzzed is removed
    // at once.
    let mut stays_n_m = 0.0;
    while let Some(stiffness_n_m) = walls.next_n_m() {
        let outcome = if wait_until_lifted(&mut bench, place, stays_n_m, tell)? {
            press(&mut bench, place, stiffness_n_m, tell)?
        } else {
            WallOutcome::Abandoned
        };
        let buzz = match outcome {
            WallOutcome::Abandoned => {
                walls.was_left = true;
                break;
            }
            WallOutcome::Still => None,
            WallOutcome::Buzzed(hz, swing_m) => Some((hz, swing_m)),
        };
        tell(&said(stiffness_n_m, buzz));
        stays_n_m = if buzz.is_some() { 0.0 } else { stiffness_n_m };
        walls.note(Trial {
            stiffness_n_m,
            buzz,
        });
    }
    Ok(walls)
}

fn said(stiffness_n_m: f64, buzz: Option<(f64, f64)>) -> String {
    match buzz {
        None => format!("  {stiffness_n_m:.0} N/m: no buzz"),
        Some((hz, swing_m)) => format!(
            "  {stiffness_n_m:.0} N/m: buzzes with {hz:.0} Hz and swings by {:.2} mm",
            swing_m * 1e3
        ),
    }
}

/// Waits until the handle is above the last wall. Meanwhile that wall is rendered with the
/// stiffness `stays_n_m`. Returns false if nobody lifts the handle.
fn wait_until_lifted(
    bench: &mut Bench<'_>,
    place: Place,
    stays_n_m: f64,
    tell: &mut dyn FnMut(&str),
) -> Result<bool, Halt> {
    let mut now = bench.now();
    let begun_s = now.at_s;
    let mut below_s = now.at_s;
    let mut asked_s = f64::NEG_INFINITY;
    while now.at_s - begun_s < PATIENCE_S {
        if place.distance_m(&now) <= 0.0 {
            below_s = now.at_s;
        }
        if now.at_s - below_s >= ABOVE_S {
            return Ok(true);
        }
        if place.distance_m(&now) <= 0.0 && now.at_s - asked_s >= ASK_S {
            tell(place.lift_instruction());
            asked_s = now.at_s;
        }
        now = bench.tick(place.wall_force_n(&now, stays_n_m))?;
    }
    bench.cut();
    Ok(false)
}

/// Lets a person press a wall.
fn press(
    bench: &mut Bench<'_>,
    place: Place,
    stiffness_n_m: f64,
    tell: &mut dyn FnMut(&str),
) -> Result<WallOutcome, Halt> {
    let limit_n = bench.limits().of(place.axis());
    let [least_n, most_n] = PRESSURE.map(|share| share * limit_n);
    let mut now = bench.now();
    let mut buzz = Buzz::default();
    let (mut pressed_s, mut touched_s, mut asked_s) = (0.0, now.at_s, now.at_s);
    loop {
        let forces_n = place.wall_force_n(&now, stiffness_n_m);
        let force_n = forces_n[place.axis()];
        let before_s = now.at_s;
        now = bench.tick(forces_n)?;
        let is_touched = force_n > 0.0;
        if buzz.add(now.at_s, place.distance_m(&now)) && is_touched {
            bench.cut();
            let (hz, swing_m) = buzz.frequency_and_swing().unwrap_or_default();
            return Ok(WallOutcome::Buzzed(hz, swing_m));
        }
        if (least_n..=most_n).contains(&force_n) {
            touched_s = now.at_s;
            pressed_s += (now.at_s - before_s).clamp(0.0, 0.01);
        }
        if pressed_s >= STILL_S && !buzz.is_quick() {
            return Ok(WallOutcome::Still);
        }
        if now.at_s - touched_s > PATIENCE_S {
            bench.cut();
            return Ok(WallOutcome::Abandoned);
        }
        if now.at_s - touched_s >= ASK_S && now.at_s - asked_s >= ASK_S {
            asked_s = now.at_s;
            tell(if force_n > most_n {
                "  Press more lightly."
            } else {
                place.tap_instruction()
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_search_doubles_and_then_bisects() {
        let limit_n_m = 1234.0;
        let mut walls = Wall::default();
        while let Some(stiffness_n_m) = walls.next_n_m() {
            let buzz = (stiffness_n_m > limit_n_m).then_some((80.0, 1e-3));
            walls.note(Trial {
                stiffness_n_m,
                buzz,
            });
        }
        let still = walls.still_n_m.unwrap();
        assert!((limit_n_m / RATIO..=limit_n_m).contains(&still), "{still}");
        assert!(walls.trials.len() < 12, "{}", walls.trials.len());
        let mut rigid = Wall::default();
        while let Some(stiffness_n_m) = rigid.next_n_m() {
            let buzz = None;
            rigid.note(Trial {
                stiffness_n_m,
                buzz,
            });
        }
        assert_eq!(
            (rigid.still_n_m, rigid.buzzes_n_m),
            (Some(STIFFEST_N_M), None)
        );
    }
}
