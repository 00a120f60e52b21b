//! Tests whether the device drops a force when no command comes. A watchdog that only sets its
//! status bit while the motors keep the force fails.

use rt_core::math::Vec3;

use super::bench::{Bench, EndReason};
use super::{Direction, Left, Step};
use crate::conformance::Report;

/// Name of the check.
const NAME: &str = "silence";
/// Force before the silence, N.
const FORCE_N: f32 = 0.5;
/// Time in which the force rises, and for which it then stays, ms. A hand feels the end of such a
/// push.
const RISE_MS: u32 = 300;
const STAY_MS: u32 = 700;
/// Time without a command after which the force must be gone, ms: the longest watchdog is 100 ms,
/// and motors need some time.
const SILENT_MS: u32 = 150;
/// Share of the commanded force below which a measured force counts as none.
const NOTHING_SHARE: f32 = 0.1;

/// Pushes, sends nothing more, and judges whether the push has ended.
pub(super) fn test(bench: &mut Bench<'_>, report: &mut Report) -> Result<(), EndReason> {
    let Some(watchdog_ms) = bench.watchdog_ms() else {
        report.skip(
            NAME,
            "the driver knows no watchdog: end Calot while the handle pushes, and feel that the push ends",
        );
        return Ok(());
    };
    bench.until_done(&Step::HoldForSilence, Vec3::zeros(), |_| {})?;
    let force_n = bench.permitted_n(FORCE_N);
    bench.guide().tell(&Step::PushAndFallSilent { force_n });
    let full_n = Direction::Up.vector() * force_n;
    let force_share = |ms: u32| (ms as f32 / RISE_MS as f32).min(1.0);
    bench.push(RISE_MS + STAY_MS, |ms| full_n * force_share(ms), |_, _| {})?;
    let silent_ms = SILENT_MS.max(u32::from(watchdog_ms));
    match bench.stay_silent(silent_ms)? {
        None => report.mark_not_judged(NAME, "nobody said whether the push had ended"),
        Some(answer) => {
            let (good, words) = judge(force_n, silent_ms, answer);
            report.judge(NAME, good, words);
        }
    }
    Ok(())
}

fn judge(asked_n: f32, silent_ms: u32, answer: Left) -> (bool, String) {
    let words = format!("{asked_n:.1} N up, then no command for {silent_ms} ms:");
    let left = match answer {
        Left::Nothing => return (true, format!("{words} the force ended")),
        Left::Measured(force_n) if force_n.norm() < NOTHING_SHARE * asked_n => {
            let left_n = force_n.norm();
            return (true, format!("{words} {left_n:.2} N measured"));
        }
        Left::Measured(force_n) => format!("still {:.2} N measured", force_n.norm()),
        Left::Pushes => "the handle still pushes".to_owned(),
    };
    let why =
        "The motors keep the force: the watchdog must switch them off, not only set its status bit";
    (false, format!("{words} {left}. {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remaining_force_fails() {
        for (answer, good, words) in [
            (Left::Nothing, true, "the force ended"),
            (Left::Measured(Vec3::y() * 0.02), true, "0.02 N measured"),
            (
                Left::Measured(Vec3::y() * 0.5),
                false,
                "still 0.50 N measured",
            ),
            (Left::Pushes, false, "the handle still pushes. The motors"),
        ] {
            let (is_good, said) = judge(0.5, 200, answer);
            assert!(is_good == good && said.contains(words), "{said}");
            assert!(said.contains("no command for 200 ms"), "{said}");
        }
    }
}
