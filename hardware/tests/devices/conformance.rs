//! The conformance suite on emulated devices, healthy and faulty.

use std::time::{Duration, Instant};

use hardware::conformance::{Options, Outcome, Report, hapi, haptic, pedal, tracker, woody};
use hardware::emulate::{Faults, HapticModel, LineFaults};
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
/// one.
pub(crate) fn once_good(mut suite: impl FnMut() -> Report) -> Report {
    let start = Instant::now();
    loop {
        let report = suite();
        if report.passed() || start.elapsed() > Duration::from_secs(120) {
            return report;
        }
    }
}

#[test]
fn the_emulated_devices_pass() {
    let emulator = Emulator::start();
    let lines = &emulator.lines;
    for report in [
        once_good(|| haptic(&lines.haptic, &mut shortly())),
        once_good(|| tracker(&lines.tracker, &mut shortly())),
        once_good(|| pedal(&lines.pedal, &mut shortly())),
    ] {
        print!("{report}");
        assert!(report.passed(), "{report}");
        assert_eq!(
            report.check("unplug").map(|check| check.outcome),
            Some(Outcome::Skipped)
        );
    }
}

#[test]
fn a_pulled_plug_is_noticed() {
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
        Some(Outcome::Pass),
        "{report}"
    );
}

#[test]
fn a_device_behind_a_bad_cable_fails() {
    let bad = Faults {
        lost: 0.002,
        ..Faults::default()
    };
    let emulator = Emulator::with(LineFaults {
        haptic: bad,
        ..LineFaults::default()
    });
    // The fault may hit the greeting itself; then the report says so.
    let report = haptic(&emulator.lines.haptic, &mut shortly());
    // A computer that was itself late must neither judge nor pass the gaps.
    let gaps = report.check("gaps").map(|check| check.outcome);
    assert!(
        !report.passed() || gaps == Some(Outcome::Skipped),
        "{report}"
    );
}

#[test]
fn a_missing_device_is_a_report_too() {
    let report = tracker("/dev/there-is-no-such-device".as_ref(), &mut shortly());
    assert!(!report.passed());
    assert!(report.to_string().contains("no such device"), "{report}");
}

#[test]
fn the_emulated_woody_passes() {
    let emulator = Emulator::of(HapticModel::Woody, LineFaults::default());
    let report = once_good(|| woody(&emulator.lines.haptic, &mut shortly()));
    print!("{report}");
    assert!(report.passed(), "{report}");
}

#[test]
fn the_emulated_hapi_passes() {
    // A board that a busy machine lost needs a power cycle, so take another one.
    let report = once_good(|| {
        let emulator = Emulator::of(HapticModel::Hapi, LineFaults::default());
        hapi(&emulator.lines.haptic, Pantograph::GEN3, &mut shortly())
    });
    print!("{report}");
    assert!(report.passed(), "{report}");
}
