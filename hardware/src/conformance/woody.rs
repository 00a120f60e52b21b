//! Conformance checks of a WoodenHaptics device.

use std::path::Path;

use rt_core::port::HapticDevice;

use super::samples::samples;
use super::watch::{open, unplugged};
use super::{CheckOutcome, Options, Report};
use crate::woody::WoodyHaptic;

/// Tests the device at `path`.
pub fn woody(path: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("WoodenHaptics device");
    let Some(mut device) = open(&mut report, "handshake", || WoodyHaptic::open(path)) else {
        return report;
    };
    samples(&mut report, &mut device, options.watch);
    if report.names(CheckOutcome::Fail).contains(&"workspace") {
        let words =
            ". At home the handle is 0.21 m from the middle: move it to the middle and test again";
        report.add_to("workspace", words);
    }
    report.skip(
        "watchdog",
        "the firmware does not report it: end Calot and feel that the handle is free",
    );
    drop(device);
    if let Some(mut device) = open(&mut report, "reopen", || WoodyHaptic::open(path)) {
        unplugged(&mut report, options, |now_ns| device.poll(now_ns));
    }
    report
}
