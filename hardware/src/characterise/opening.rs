//! The experiments along the opening of a handle that opens and shuts. A spring holds the handle
//! meanwhile.

use super::axis::{Recorded, both_ways, one_axis};
use super::bench::{Bench, OPENING, Vector};
use super::given::given_shares;
use super::halt::Halt;
use super::hold::{Hold, STIFFNESS_N_M};
use super::opened::Opened;

/// Speed at which the spring's free end moves to an end of the opening, m/s.
const TO_END_M_S: f64 = 0.03;
/// Force at which the spring's free end stops, as a share of the largest force. If the handle binds
/// against this force, that position counts as its end.
const STRETCH: f64 = 0.8;
/// Speed below which the opening is at its end, m/s.
const STILL_M_S: f64 = 0.004;
/// Time for which the opening must be still at its end, s.
const STILL_S: f64 = 0.1;
/// Longest time to an end, s: three times the time for the widest opening (0.3 m).
const PATIENCE_S: f64 = 30.0;

/// Records of the opening.
#[derive(Debug, Clone)]
pub(super) struct RecordedOpening {
    along: Recorded,
    /// Opening at both ends, 0 to 1: shut and wide open.
    range: [f64; 2],
}

impl RecordedOpening {
    /// Fits the model.
    pub(super) fn fitted(&self) -> Result<Opened, String> {
        let axis = self.along.fitted()?;
        let axis_records = self
            .along
            .repetitions
            .iter()
            .flat_map(|it| it.axis_records());
        Ok(Opened {
            given: given_shares(axis_records, &axis),
            range: self.range,
            axis,
        })
    }
}

/// Runs all experiments along the opening. The inner error is the reason for which the opening
/// cannot be measured; the results of the other axes remain valid.
pub(super) fn opening(
    bench: &mut Bench<'_>,
    hold: &mut Hold,
    goal_m: Vector,
    repetitions: u32,
    tell: &mut dyn FnMut(&str),
) -> Result<Result<RecordedOpening, String>, Halt> {
    if bench.limits().opening_n <= 0.0 {
        let reason = "the device renders no force along its opening, or hardly any";
        return Ok(Err(reason.to_owned()));
    }
    tell("opening: range, friction, chirp and run-out");
    match measured(bench, hold, goal_m, repetitions) {
        Err(
            halt @ (Halt::Away { .. }
            | Halt::Backwards { .. }
            | Halt::Fast { .. }
            | Halt::Unheld { .. }),
        ) => {
            bench.cut();
            Ok(Err(halt.to_string()))
        }
        other => other,
    }
}

fn measured(
    bench: &mut Bench<'_>,
    hold: &mut Hold,
    goal_m: Vector,
    repetitions: u32,
) -> Result<Result<RecordedOpening, String>, Halt> {
    bench.begin_opening()?;
    if let Err(halt) = hold.settle(bench, goal_m) {
        if !matches!(halt, Halt::Away { .. }) {
            return Err(halt);
        }
        bench.cut();
        return Ok(Err(
            "a force towards half open does not move it there: the motor is off or pushes the wrong \
             way, or it binds. Run `calot devices feel` first"
                .to_owned(),
        ));
    }
    // The direction of the force comes first: with the wrong sign the handle would go to the other
    // end.
    if both_ways(bench, hold, goal_m, OPENING, 0.0)?.is_none() {
        return Ok(Err(format!(
            "{:.2} N do not open and shut the handle: the motor is off, or friction is higher",
            bench.limits().opening_n
        )));
    }
    let half_m = bench.reach_m(OPENING);
    let mut range = [0.0; 2];
    for (end, sign) in range.iter_mut().zip([-1.0, 1.0]) {
        *end = 0.5 + 0.5 * to_end(bench, hold, sign)? / half_m;
    }
    hold.settle(bench, goal_m)?;
    let along = one_axis(bench, hold, goal_m, (OPENING, 0.0), repetitions)?;
    Ok(along.map(|along| RecordedOpening { along, range }))
}

/// Opens or shuts the handle slowly as far as it goes. Returns that position, m.
fn to_end(bench: &mut Bench<'_>, hold: &mut Hold, sign: f64) -> Result<f64, Halt> {
    let stretch_m = STRETCH * bench.limits().opening_n / STIFFNESS_N_M;
    let mut now = bench.now();
    let (begun_s, mut moved_s) = (now.at_s, now.at_s);
    while now.at_s - moved_s < STILL_S && now.at_s - begun_s < PATIENCE_S {
        let before_s = now.at_s;
        now = bench.tick(hold.force_n(&now))?;
        let passed_s = (now.at_s - before_s).clamp(0.0, 0.01);
        let stretched_m = sign * (hold.target_m[OPENING] - now.at_m[OPENING]);
        if stretched_m < stretch_m {
            hold.target_m[OPENING] += sign * TO_END_M_S * passed_s;
        }
        if stretched_m < stretch_m || now.v_m_s[OPENING].abs() > STILL_M_S {
            moved_s = now.at_s;
        }
    }
    Ok(now.at_m[OPENING])
}
