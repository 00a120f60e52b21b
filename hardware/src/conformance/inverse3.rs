//! Conformance checks of an Inverse3 through its service.

use std::path::Path;

use rt_core::port::HapticDevice;

use super::samples::samples;
use super::watch::{open, unplugged};
use super::{Options, Report};
use crate::inverse3::Inverse3Haptic;

/// Tests the first Inverse3 of the service at `address`, usually `localhost`.
pub fn inverse3(address: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("Haply Inverse3");
    let attempt = || Inverse3Haptic::open(address, None);
    let Some(mut device) = open(&mut report, "handshake", attempt) else {
        return report;
    };
    samples(&mut report, &mut device, options.watch);
    report.skip(
        "watchdog",
        "the service does not report it: end Calot and feel that the handle is free",
    );
    drop(device);
    if let Some(mut device) = open(&mut report, "reopen", attempt) {
        unplugged(&mut report, options, |now_ns| device.poll(now_ns));
    }
    report
}
