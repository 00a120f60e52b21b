//! Tests in which the handle pushes a person's hand: sign, axes and size of the force.

use rt_core::math::Vec3;

use super::bench::{Bench, EndReason};
use super::{Answer, Direction, PUSH_N, Step};
use crate::conformance::Report;

/// Number of pushes.
pub const COUNT: usize = 3;
/// Pushes, with the names of their checks.
const PUSHES: [(Direction, &str); COUNT] = [
    (Direction::Right, "push right"),
    (Direction::Up, "push up"),
    (Direction::Towards, "push towards"),
];
/// Time in which a push rises, and in which it falls, ms. So slow a push does not make a hand jerk.
const RISE_MS: u32 = 300;
/// Time for which a push stays at its full force, ms. A person feels a direction within half a
/// second.
const STAY_MS: u32 = 1000;
/// Time of a whole push, ms.
pub(super) const PUSH_MS: u32 = 2 * RISE_MS + STAY_MS;
/// Force on a scale, N. A kitchen scale shows 51 g.
const PRESS_N: f32 = 0.5;
/// Force of the hard push, N. A firm hand can hold against it.
const HARD_N: f32 = 2.0;
/// Share of the commanded force below which a measured force counts as none.
const NOTHING_SHARE: f32 = 0.1;
/// Allowed measured force as a share of the commanded force.
const SIZE: core::ops::RangeInclusive<f32> = 0.8..=1.25;

/// Judges three pushes in an order that `seed` decides.
pub(super) fn test(bench: &mut Bench<'_>, report: &mut Report, seed: u64) -> Result<(), EndReason> {
    let force_n = bench.permitted_n(PUSH_N);
    let mut order = PUSHES;
    order.rotate_left((seed % 3) as usize);
    if seed / 3 % 2 == 1 {
        order.reverse();
    }
    let mut judged = Vec::new();
    for (direction, name) in order {
        bench.until_done(&Step::Hold, Vec3::zeros(), |_| {})?;
        bench.guide().tell(&Step::Push { force_n });
        let full_n = direction.vector() * force_n;
        bench.push(PUSH_MS, |ms| full_n * force_share(ms), |_, _| {})?;
        let answer = bench.pushed_which_way()?;
        judged.push((name, judge(direction, force_n, answer)));
    }
    judged.sort_by_key(|(name, _)| PUSHES.iter().position(|(_, it)| it == name));
    for (name, (good, words)) in judged {
        report.judge(name, good, words);
    }
    Ok(())
}

/// Judges one push with the largest force of the test, in a direction that `seed` decides. Some
/// mistakes, such as a number that overflows, show in large forces only.
pub(super) fn test_hard(
    bench: &mut Bench<'_>,
    report: &mut Report,
    seed: u64,
) -> Result<(), EndReason> {
    const NAME: &str = "push hard";
    let force_n = bench.permitted_n(HARD_N);
    let most_n = bench.capabilities().force_max_n;
    if force_n <= PRESS_N {
        report.skip(
            NAME,
            &format!("the test may push this device with {force_n:.1} N at most; no harder push was tested"),
        );
        return Ok(());
    }
    let direction = match seed / 12 % 3 {
        0 => Direction::Right,
        1 => Direction::Up,
        _ => Direction::Towards,
    };
    bench.until_done(&Step::HoldFirmly, Vec3::zeros(), |_| {})?;
    bench.guide().tell(&Step::Push { force_n });
    let full_n = direction.vector() * force_n;
    bench.push(PUSH_MS, |ms| full_n * force_share(ms), |_, _| {})?;
    let answer = bench.pushed_which_way()?;
    let (good, words) = judge(direction, force_n, answer);
    let untested = format!("{words}; forces from {force_n:.1} to {most_n:.1} N were not tested");
    report.judge(NAME, good, if good { untested } else { words });
    Ok(())
}

/// Share of a push's force at this time.
pub(super) fn force_share(ms: u32) -> f32 {
    let rise = ms as f32 / RISE_MS as f32;
    let fall = PUSH_MS.saturating_sub(ms) as f32 / RISE_MS as f32;
    rise.min(fall).min(1.0)
}

fn judge(asked: Direction, asked_n: f32, answer: Answer) -> (bool, String) {
    let (is, measured_n) = match answer {
        Answer::Nothing => {
            let words = format!(
                "{asked_n:.1} N {} and nothing was felt. Is the driver of the motors on?",
                asked.words()
            );
            return (false, words);
        }
        Answer::Measured(force_n) if force_n.norm() < NOTHING_SHARE * asked_n => {
            let words = format!(
                "{asked_n:.1} N {}: the sensor measured {:.2} N. Is the driver of the motors on?",
                asked.words(),
                force_n.norm()
            );
            return (false, words);
        }
        Answer::Felt(direction) => (direction, None),
        Answer::Measured(force_n) => {
            let (is, along) = Direction::nearest(&force_n);
            if along < 0.8 {
                let words = format!(
                    "{asked_n:.1} N {}, measured {:.2} N obliquely: is the base frame turned?",
                    asked.words(),
                    force_n.norm()
                );
                return (false, words);
            }
            (is, Some(force_n.norm()))
        }
    };
    let words = format!("{asked_n:.1} N {}, felt {}", asked.words(), is.words());
    if is.vector() == -asked.vector() {
        return (false, format!("{words}: the force has the wrong sign"));
    }
    if is != asked {
        return (false, format!("{words}: axes of the force are exchanged"));
    }
    match measured_n {
        Some(is_n) if !SIZE.contains(&(is_n / asked_n)) => (
            false,
            format!("{words}, measured {is_n:.2} N, allowed is 0.8 to 1.25 of the command"),
        ),
        Some(is_n) => (true, format!("{words}, measured {is_n:.2} N")),
        None => (true, words),
    }
}

/// Judges the size of a force that presses down on a scale.
pub(super) fn test_scale(bench: &mut Bench<'_>, report: &mut Report) -> Result<(), EndReason> {
    if !bench.has_scale()? {
        report.skip("scale", "there is no scale");
        return Ok(());
    }
    bench.until_done(&Step::Scale, Vec3::zeros(), |_| {})?;
    let force_n = bench.permitted_n(PRESS_N);
    let down_n = Direction::Down.vector() * force_n;
    bench.push(RISE_MS, |ms| down_n * force_share(ms), |_, _| {})?;
    bench.until_done(&Step::Press { force_n }, down_n, |_| {})?;
    bench.push(
        RISE_MS,
        |ms| down_n * force_share(ms + RISE_MS + STAY_MS),
        |_, _| {},
    )?;
    match bench.pressed_n()? {
        None => report.skip("scale", "the scale was not read"),
        Some(read_n) => report.judge(
            "scale",
            SIZE.contains(&(read_n / force_n)),
            format!(
                "{force_n:.2} N commanded, {read_n:.2} N on the scale, allowed 0.8 to 1.25 of the command"
            ),
        ),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_that_measures_nothing_does_not_mean_exchanged_axes() {
        for (measured_n, words) in [
            (Vec3::zeros(), "the sensor measured 0.00 N. Is the driver"),
            (Vec3::new(0.01, 0.01, 0.0), "the sensor measured 0.01 N"),
            (Vec3::new(0.2, 0.2, 0.0), "obliquely"),
        ] {
            let (good, said) = judge(Direction::Right, 0.3, Answer::Measured(measured_n));
            assert!(!good && said.contains(words), "{said}");
        }
    }
}
