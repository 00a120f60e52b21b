//! Conformance checks of a Touch through the vendor's library.

use std::path::Path;

use rt_core::port::HapticDevice;

use super::samples::{name_bad_frames, samples};
use super::watch::{open, unplugged};
use super::{Options, Report};
use crate::touch::TouchHaptic;

/// Tests the Touch named `device` (`None`: the default one) through `library`.
pub fn touch(library: &Path, device: Option<&str>, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("Touch");
    let attempt = || TouchHaptic::open(library, device);
    let Some(mut device) = open(&mut report, "handshake", attempt) else {
        return report;
    };
    report.device = format!("Touch \"{}\"", device.identity().name);
    samples(&mut report, &mut device, options.watch);
    name_bad_frames(&mut report, device.bad_frames());
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
