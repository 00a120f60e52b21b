//! Runs the conformance suite on firmware in C. The good firmware must pass, and each mistake must
//! be named.

use std::time::{Duration, Instant};

use hardware::conformance::{CheckOutcome, Options, Report, haptic, pedal};
use hardware::rig::RigHaptic;
use hardware::rig::wire::Status;
use rt_core::port::HapticDevice;

use super::rig::Program;
use crate::conformance::once_good;
use crate::support::{PATIENCE, persist, poll_for};

fn shortly() -> Options<'static> {
    Options {
        // The judgement of the clock's unit takes 0.8 s.
        watch: Duration::from_secs(1),
        unplug: None,
    }
}

#[test]
fn a_haptic_device_in_c_passes() {
    let program = Program::new();
    let rig = program.start(&[]);
    let report = once_good(|| haptic(&rig.line, &mut shortly()));
    print!("{report}");
    assert!(report.device.contains("\"rig in C\", serial 3"), "{report}");
}

#[test]
fn the_velocity_of_a_resting_handle_is_not_judged() {
    let program = Program::new();
    let rig = program.start(&["--still"]);
    let start = Instant::now();
    loop {
        let report = haptic(&rig.line, &mut shortly());
        let is_late = start.elapsed() > 2 * PATIENCE;
        if report.names(CheckOutcome::NotJudged) == ["velocity"] && !report.has(CheckOutcome::Fail)
        {
            return;
        }
        assert!(!is_late, "{report}");
    }
}

#[test]
fn a_pedal_in_c_passes() {
    let program = Program::new();
    let rig = program.start(&["--pedal"]);
    let report = once_good(|| pedal(&rig.line, &mut shortly()));
    print!("{report}");
}

#[test]
fn a_board_that_boots_for_two_seconds_is_waited_for() {
    let program = Program::new();
    // Each repetition has a board of its own, since one that was open before answers at once.
    let report = once_good(|| {
        let rig = program.mistaken("slow-boot=2");
        haptic(&rig.line, &mut shortly())
    });
    let Some(handshake) = report.check("handshake") else {
        panic!("{report}");
    };
    let waited_ms = handshake
        .detail
        .split(' ')
        .find_map(|word| word.parse::<u32>().ok());
    assert!(waited_ms.is_some_and(|ms| ms >= 1500), "{report}");
}

/// Repeats the suite until `check` fails and says `why`. On a busy computer a mistake may stay
/// unjudged once, but not in every repetition.
fn found(mistake: &str, check: &str, why: &str) {
    let program = Program::new();
    let start = Instant::now();
    loop {
        let rig = program.mistaken(mistake);
        let report: Report = haptic(&rig.line, &mut shortly());
        let is_found = report
            .check(check)
            .is_some_and(|it| it.outcome == CheckOutcome::Fail && it.detail.contains(why));
        if is_found {
            return;
        }
        assert!(
            start.elapsed() < 2 * PATIENCE,
            "{mistake}: '{check}' should fail and say '{why}'\n{report}"
        );
    }
}

#[test]
fn mistakes_in_frames_fail_the_handshake() {
    found("wrong-crc", "handshake", "it must be");
    found("no-zero", "handshake", "none of which is 00");
    found("short-capabilities", "handshake", "44 bytes instead of 45");
}

#[test]
fn mistakes_in_samples_are_found() {
    found("nan", "gaps", "samples lost");
    found("slow", "rate", "declared 1000");
    found("far", "workspace", "declared 0.100 m");
    found("leap", "consistent", "device_leap");
    found("no-rotation", "bad frames", "no unit quaternion");
    found(
        "stuck-number",
        "bad frames",
        "with the same number as the frame before",
    );
}

#[test]
fn mistakes_of_the_clock_are_found() {
    found("frozen-clock", "consistent", "device_clock");
    found("clock-ms", "consistent", "device_clock");
    found("frozen-handle", "consistent", "frozen_device");
}

#[test]
fn mistakes_of_the_watchdog_are_found() {
    found("no-watchdog", "watchdog", "was not dropped");
    found("slow-watchdog", "watchdog", "at the latest 15");
    found("slow-watchdog=95", "watchdog", "declared 50 ms");
}

#[test]
fn mistakes_with_commands_are_found() {
    found("deaf", "force echo", "never measured");
    found("force-status", "watchdog", "even a zero one");
    found("no-stop", "close", "bytes in 300 ms after closing");
    found("fault", "consistent", "device_fault");
}

#[test]
fn a_device_that_is_limited_or_faulty_says_so() {
    let program = Program::new();
    for (mistake, bit) in [("limited", Status::LIMITED), ("fault", Status::FAULT)] {
        let rig = program.mistaken(mistake);
        let mut device = persist(|| RigHaptic::open(&rig.line));
        let mut is_said = false;
        poll_for(PATIENCE, |now_ns| {
            device.poll(now_ns);
            is_said = device.status().status.contains(bit);
            !is_said
        });
        assert!(is_said, "{mistake}");
    }
}
