//! Conformance checks of a Haply hAPI board.

use std::path::Path;

use rt_core::port::HapticDevice;

use super::samples::samples;
use super::watch::{open, silent_after_close, unplugged};
use super::{Options, Report};
use crate::hapi::pantograph::Pantograph;
use crate::hapi::{BAUD, HapiHaptic};

/// Tests the board at `path` with a linkage of this generation. The handle must be in its home
/// position.
pub fn hapi(path: &Path, generation: Pantograph, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("Haply hAPI board");
    let attempt = || HapiHaptic::open(path, generation);
    let Some(mut device) = open(&mut report, "handshake", attempt) else {
        return report;
    };
    samples(&mut report, &mut device, options.watch);
    report.skip(
        "watchdog",
        "the board has no watchdog: it holds its last torque until it gets another. Calot removes the \
         torque when Calot ends or fails. Keep the board's switch within reach, in case the line is cut",
    );
    let before = device.position_m();
    drop(device);
    silent_after_close(&mut report, path, BAUD);
    if let Some(mut device) = open(&mut report, "reopen", attempt) {
        let off_m = (device.position_m() - before).norm();
        let is_kept = off_m < 0.02;
        let remedy = match is_kept {
            true => "",
            false => {
                "; hold the handle still and test again. If that fails, switch the board off and \
                 on, with the handle at home (near the motors)"
            }
        };
        report.judge(
            "position kept",
            is_kept,
            format!(
                "the handle's position changed by {off_m:.3} m while the board was opened \
                 again, allowed is less than 0.02 m{remedy}"
            ),
        );
        unplugged(&mut report, options, |now_ns| device.poll(now_ns));
    }
    report
}
