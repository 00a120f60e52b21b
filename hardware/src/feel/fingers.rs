//! Tests a handle that opens and shuts: the opening that it reports at both ends, and the sign of
//! its force. With a force sensor, the size of the force is tested, too.

use super::bench::{Bench, EndReason};
use super::pushes::{PUSH_MS, force_share};
use super::{Squeezed, Step};
use crate::conformance::Report;

/// Force that pushes the fingers, N: above the friction of a good handle, and harmless.
const PUSH_N: f32 = 1.0;
/// Pushes on the fingers, each with its direction and the name of its check.
const PUSHES: [(Squeezed, &str); COUNT] =
    [(Squeezed::Open, "push open"), (Squeezed::Shut, "push shut")];
/// Number of pushes.
pub const COUNT: usize = 2;
/// Largest opening that a shut handle may report.
const SHUT_MAX: f32 = 0.2;
/// Least opening that a wide open handle may report.
const OPEN_MIN: f32 = 0.8;
/// The opening at the end of a step is the mean of this number of samples.
const END_SAMPLES: usize = 50;
/// Share of the commanded force below which a measured force counts as none.
const NOTHING_SHARE: f32 = 0.1;
/// Allowed measured force as a share of the commanded force.
const SIZE: core::ops::RangeInclusive<f32> = 0.8..=1.25;

/// Judges a handle that opens, if the device has one. `seed` decides the order of the pushes.
pub(super) fn test(bench: &mut Bench<'_>, report: &mut Report, seed: u64) -> Result<(), EndReason> {
    let can = bench.capabilities().opening;
    if !can.is_measured() {
        return Ok(());
    }
    let shut = end(bench, &Step::Shut)?;
    let open = end(bench, &Step::Open)?;
    let (good, words) = judge_ends(shut, open);
    report.judge("opening", good, words);
    if !can.is_rendered() {
        for (_, name) in PUSHES {
            report.skip(name, "the device renders no force along its opening");
        }
        return Ok(());
    }
    let force_n = PUSH_N.min(can.force_max_n);
    // `seed % 6` decides the order of the hand's pushes. The rest of the seed decides this order,
    // so the two orders are independent.
    let mut order = PUSHES;
    if seed / 6 % 2 == 1 {
        order.reverse();
    }
    let mut judged = Vec::new();
    for (way, name) in order {
        bench.until_done_without_force(&Step::HoldFingers)?;
        bench.guide().tell(&Step::PushFingers { force_n });
        bench.push_fingers(PUSH_MS, |ms| way.sign() * force_n * force_share(ms))?;
        let answer = bench.squeezed_which_way()?;
        judged.push((name, judge_push(way, force_n, answer)));
    }
    judged.sort_by_key(|(name, _)| PUSHES.iter().position(|(_, it)| it == name));
    for (name, (good, words)) in judged {
        report.judge(name, good, words);
    }
    Ok(())
}

/// Runs a step. Returns the opening at its end, 0 to 1; `None` if the samples have none.
fn end(bench: &mut Bench<'_>, step: &Step) -> Result<Option<f32>, EndReason> {
    let mut openings: Vec<f32> = Vec::new();
    bench.until_done(step, rt_core::math::Vec3::zeros(), |seen| {
        openings.extend(seen.opening);
    })?;
    let last = openings.len().saturating_sub(END_SAMPLES);
    let last = openings.get(last..).unwrap_or(&[]);
    let sum: f32 = last.iter().sum();
    Ok((!last.is_empty()).then(|| sum / last.len() as f32))
}

/// Judges the openings that the handle reported when shut and when wide open. Returns true if they
/// are good, and words for the report.
fn judge_ends(shut: Option<f32>, open: Option<f32>) -> (bool, String) {
    let (Some(shut), Some(open)) = (shut, open) else {
        let words = "the device declares an opening, but its samples have none";
        return (false, words.to_owned());
    };
    let measured = format!("the device reports {shut:.2} when shut and {open:.2} when wide open");
    if shut >= OPEN_MIN && open <= SHUT_MAX {
        let words = format!("{measured}: the wrong way round. 0 is shut, 1 is wide open");
        return (false, words);
    }
    if shut > SHUT_MAX || open < OPEN_MIN {
        let words = format!(
            "{measured}. Allowed: at most {SHUT_MAX} when shut, at least {OPEN_MIN} when wide open. Is the travel right?"
        );
        return (false, words);
    }
    (true, measured)
}

/// Judges the answer to a push of `asked_n` towards `asked`. Returns true if it is right, and words
/// for the report.
fn judge_push(asked: Squeezed, asked_n: f32, answer: Squeezed) -> (bool, String) {
    let asked_words = asked.words();
    let is = match answer {
        Squeezed::Nothing => {
            let words =
                format!("{asked_n:.1} N towards {asked_words}: nothing was felt. Is the motor on?");
            return (false, words);
        }
        Squeezed::Measured(force_n) if force_n.abs() < NOTHING_SHARE * asked_n => {
            let words = format!(
                "{asked_n:.1} N towards {asked_words}: the sensor measured {force_n:.2} N. Is the motor on?"
            );
            return (false, words);
        }
        Squeezed::Measured(force_n) if force_n < 0.0 => Squeezed::Shut,
        Squeezed::Measured(_) => Squeezed::Open,
        felt => felt,
    };
    let words = match answer {
        Squeezed::Measured(is_n) => format!(
            "{asked_n:.1} N towards {asked_words}, measured {:.2} N towards {}",
            is_n.abs(),
            is.words()
        ),
        _ => format!("{asked_n:.1} N towards {asked_words}, felt {}", is.words()),
    };
    if is != asked {
        return (false, format!("{words}: the force has the wrong sign"));
    }
    match answer {
        Squeezed::Measured(is_n) => (
            SIZE.contains(&(is_n.abs() / asked_n)),
            format!(
                "{words}, allowed {:.2} to {:.2} N",
                SIZE.start() * asked_n,
                SIZE.end() * asked_n
            ),
        ),
        _ => (true, words),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_must_be_far_apart_and_in_the_right_order() {
        for (shut, open, good, words) in [
            (Some(0.01), Some(0.98), true, "0.01 when shut"),
            (Some(0.98), Some(0.01), false, "the wrong way"),
            (Some(0.01), Some(0.5), false, "the travel"),
            (Some(0.4), Some(1.0), false, "the travel"),
            (None, Some(1.0), false, "samples have none"),
        ] {
            let (is_good, said) = judge_ends(shut, open);
            assert!(is_good == good && said.contains(words), "{said}");
        }
    }

    #[test]
    fn a_push_is_rated_by_its_sign_and_its_measured_size() {
        for (asked, answer, good, words) in [
            (Squeezed::Open, Squeezed::Open, true, "felt open"),
            (Squeezed::Open, Squeezed::Shut, false, "wrong sign"),
            (Squeezed::Shut, Squeezed::Nothing, false, "nothing was felt"),
            (
                Squeezed::Shut,
                Squeezed::Measured(-0.9),
                true,
                "0.90 N towards shut",
            ),
            (Squeezed::Shut, Squeezed::Measured(-0.4), false, "allowed"),
            (Squeezed::Shut, Squeezed::Measured(0.9), false, "wrong sign"),
            (Squeezed::Shut, Squeezed::Measured(0.0), false, "the motor"),
        ] {
            let (is_good, said) = judge_push(asked, 1.0, answer);
            assert!(is_good == good && said.contains(words), "{said}");
        }
    }
}
