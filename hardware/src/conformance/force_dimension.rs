//! Conformance checks of a Force Dimension device or a Falcon through the vendor's library.

use std::path::Path;

use rt_core::port::HapticDevice;

use super::samples::samples;
use super::watch::{open, unplugged};
use super::{Options, Report};
use crate::dhd::DhdHaptic;

/// Tests the device with this serial number (`None`: the first that is free) through `library`.
pub fn force_dimension(library: &Path, serial: Option<u16>, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("Force Dimension device");
    let attempt = || DhdHaptic::open(library, serial);
    let Some(mut device) = open(&mut report, "handshake", attempt) else {
        return report;
    };
    report.device = format!("Force Dimension \"{}\"", device.identity().name);
    samples(&mut report, &mut device, options.watch);
    report.skip(
        "watchdog",
        "the library does not report it: end Calot and feel that the handle is free",
    );
    drop(device);
    if let Some(mut device) = open(&mut report, "reopen", attempt) {
        unplugged(&mut report, options, |now_ns| device.poll(now_ns));
    }
    report
}
