//! The conformance suite on emulated devices, healthy and faulty.

use std::time::{Duration, Instant};

use hardware::conformance::{CheckOutcome, Options, Report, hapi, haptic, pedal, tracker, woody};
use hardware::emulate::{Faults, HapticModel, LineFaults, Mistake};
use hardware::hapi::pantograph::Pantograph;

use crate::support::Emulator;

fn shortly() -> Options<'static> {
    Options {
        watch: Duration::from_secs(1),
        unplug: None,
    }
}

/// Repeats the suite until a report is good, for at most two minutes. The emulators share this
/// computer, and a busy one can spoil a healthy device's report; a faulty device never gets a good
/// one. A computer that stays busy may leave checks open.
pub(crate) fn once_good(mut suite: impl FnMut() -> Report) -> Report {
    let start = Instant::now();
    loop {
        let report = suite();
        let is_enough = match start.elapsed() > Duration::from_secs(120) {
            true => !report.has(CheckOutcome::Fail),
            false => report.passed(),
        };
        if is_enough || start.elapsed() > Duration::from_secs(240) {
            assert!(is_enough, "{report}");
            return report;
        }
    }
}

/// Repeats the suite until one of these checks fails. Each try watches twice as long as the one
/// before: on a busy computer the emulated hand moves late, and a mistake shows only in a movement.
fn fails_in(mistake: Mistake, checks: &[&str], words: &str) {
    const TRIES: u32 = 5;
    let mut options = moving();
    let mut reports = String::new();
    for _ in 0..TRIES {
        let emulator = Emulator::with_mistake(mistake);
        let report = haptic(&emulator.lines.haptic, &mut options);
        assert!(!report.passed(), "{mistake:?}: {report}");
        let failed = report.names(CheckOutcome::Fail);
        let text = report.to_string();
        if failed.iter().any(|name| checks.contains(name)) && text.contains(words) {
            return;
        }
        reports += &text;
        options.watch *= 2;
    }
    panic!("{mistake:?}: {words:?} in {checks:?}: {reports}");
}

/// Watches long enough for the scripted hand to move the handle.
fn moving() -> Options<'static> {
    Options {
        watch: Duration::from_millis(1500),
        unplug: None,
    }
}

#[test]
fn the_emulated_devices_pass() {
    let emulator = Emulator::start();
    let lines = &emulator.lines;
    for report in [
        once_good(|| haptic(&lines.haptic, &mut moving())),
        once_good(|| tracker(&lines.tracker, &mut shortly())),
        once_good(|| pedal(&lines.pedal, &mut shortly())),
    ] {
        print!("{report}");
        assert_eq!(
            report.check("unplug").map(|check| check.outcome),
            Some(CheckOutcome::Skipped)
        );
    }
}

#[test]
fn an_unplugged_device_is_noticed() {
    let path = |emulator: &Emulator| emulator.lines.haptic.clone();
    let mut emulator = Some(Emulator::start());
    let path = path(emulator.as_ref().unwrap());
    let mut pull = || drop(emulator.take());
    let mut options = Options {
        unplug: Some(&mut pull),
        ..shortly()
    };
    let report = haptic(&path, &mut options);
    assert_eq!(
        report.check("unplug").map(|check| check.outcome),
        Some(CheckOutcome::Pass),
        "{report}"
    );
}

#[test]
fn a_device_behind_a_bad_cable_fails() {
    let bad = Faults {
        lost: 0.002,
        ..Faults::default()
    };
    let emulator = Emulator::with_faults(LineFaults {
        haptic: bad,
        ..LineFaults::default()
    });
    // The fault may hit the greeting itself; then the report says so.
    let report = haptic(&emulator.lines.haptic, &mut shortly());
    // If this computer itself was late, the gaps are not judged.
    let gaps = report.check("gaps").map(|check| check.outcome);
    assert!(
        !report.passed() || gaps == Some(CheckOutcome::NotJudged),
        "{report}"
    );
}

#[test]
fn a_missing_device_gives_a_report_too() {
    let report = tracker("/dev/there-is-no-such-device".as_ref(), &mut shortly());
    assert!(!report.passed());
    assert!(report.to_string().contains("no such device"), "{report}");
}

#[test]
fn the_emulated_woody_passes() {
    let emulator = Emulator::with_model(HapticModel::Woody, LineFaults::default());
    let report = once_good(|| woody(&emulator.lines.haptic, &mut shortly()));
    print!("{report}");
}

#[test]
fn the_emulated_handle_that_opens_passes() {
    let emulator = Emulator::with_model(HapticModel::HandleRig, LineFaults::default());
    let report = once_good(|| hardware::conformance::haptic(&emulator.lines.haptic, &mut moving()));
    let said = &report.check("opening").expect("judged").detail;
    assert!(
        said.contains("opens by 30 mm with up to 5.0 N; 0 samples had no opening"),
        "{said}"
    );
}

#[test]
fn the_emulated_hapi_passes() {
    // A board that a busy machine lost needs a power cycle, so take another one.
    let report = once_good(|| {
        let emulator = Emulator::with_model(HapticModel::Hapi, LineFaults::default());
        hapi(&emulator.lines.haptic, Pantograph::GEN3, &mut shortly())
    });
    print!("{report}");
}

#[test]
fn a_watchdog_that_is_missing_fails() {
    fails_in(
        Mistake::WatchdogMissing,
        &["watchdog"],
        "not dropped in 5 s",
    );
}

#[test]
fn a_watchdog_that_works_only_sometimes_fails() {
    fails_in(Mistake::WatchdogFlaky, &["watchdog"], "at the latest");
}

#[test]
fn a_watchdog_slower_than_declared_fails() {
    fails_in(Mistake::WatchdogSlow, &["watchdog"], "declared 50 ms");
}

#[test]
fn a_clock_in_milliseconds_fails() {
    fails_in(
        Mistake::ClockInMilliseconds,
        &["clock", "consistent"],
        "device_clock",
    );
}

#[test]
fn a_clock_that_has_stopped_fails() {
    fails_in(Mistake::ClockZero, &["consistent"], "found: ");
}

#[test]
fn a_clock_that_is_fast_fails() {
    fails_in(Mistake::ClockFast, &["clock"], "1.03");
}

#[test]
fn a_velocity_that_is_always_zero_fails() {
    fails_in(Mistake::VelocityZero, &["velocity"], "leaves it zero");
}

#[test]
fn a_velocity_in_millimetres_fails() {
    fails_in(
        Mistake::VelocityInMillimetres,
        &["velocity"],
        "the velocity is 0.00",
    );
}

#[test]
fn a_velocity_with_the_wrong_sign_fails() {
    fails_in(Mistake::VelocityNegated, &["velocity"], "wrong sign");
}

#[test]
fn a_force_bit_that_is_clear_at_zero_force_fails() {
    fails_in(Mistake::StatusNonzero, &["watchdog"], "even a zero one");
}

#[test]
fn a_device_with_a_fault_fails() {
    fails_in(Mistake::Fault, &["consistent"], "device_fault");
}

#[test]
fn a_device_at_half_its_rate_fails() {
    fails_in(Mistake::RateHalf, &["rate"], "declared 1000");
}

#[test]
fn a_device_that_stands_in_one_place_fails() {
    fails_in(Mistake::Frozen, &["consistent"], "frozen_device");
}

#[test]
fn a_device_whose_positions_leap_fails() {
    fails_in(
        Mistake::Leaps,
        &["consistent", "bad frames"],
        "that contradict earlier ones",
    );
}

#[test]
fn a_device_with_noisy_positions_fails() {
    fails_in(Mistake::Noisy, &["noise"], "makes force steps of");
}

#[test]
fn a_device_with_absurd_damping_fails() {
    fails_in(Mistake::DampingAbsurd, &["handshake"], "damping_n_s_m");
}

#[test]
fn a_delay_that_is_not_declared_fails() {
    fails_in(Mistake::DelayUndeclared, &["delay"], "the force echo needs");
}

#[test]
fn a_checksum_in_the_wrong_order_fails() {
    fails_in(Mistake::ChecksumReversed, &["handshake"], "it must be");
}

#[test]
fn frames_without_an_end_fails() {
    fails_in(
        Mistake::NoClosingZero,
        &["handshake"],
        "none of which is 00",
    );
}

#[test]
fn an_answer_that_is_too_short_fails() {
    fails_in(
        Mistake::AnswerShort,
        &["handshake"],
        "44 bytes instead of 45",
    );
}

#[test]
fn samples_without_an_answer_fails() {
    fails_in(
        Mistake::NoAnswer,
        &["handshake"],
        "no answer from a haptic device in 5000 ms",
    );
}

#[test]
fn a_latency_timer_is_named_with_its_length() {
    let batches = Faults {
        batch_ms: 16,
        ..Faults::default()
    };
    let start = Instant::now();
    loop {
        let emulator = Emulator::with_faults(LineFaults {
            haptic: batches,
            ..LineFaults::default()
        });
        let report = haptic(&emulator.lines.haptic, &mut moving());
        let bundles = report.check("bundles");
        if bundles.is_some_and(|it| it.detail.contains("bundles of 16 ms")) {
            assert!(!report.passed(), "{report}");
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{report}");
    }
}
