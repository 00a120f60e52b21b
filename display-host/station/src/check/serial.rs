//! Findings about serial lines.

use std::path::Path;

use super::finding::{Finding, Verdict, finding};
use super::system::System;

/// Longest good setting of an FTDI chip's latency timer, ms. The chip holds received bytes back
/// until the timer ends.
const LATENCY_TIMER_MAX_MS: u64 = 1;

pub(super) fn serial(system: &System) -> Finding {
    let name = "USB serial latency";
    let should = "latency timer of 1 ms: FTDI chips hold bytes back for 16 ms by default";
    let mut slow = Vec::new();
    let mut seen = 0;
    for port in system.entries("sys/bus/usb-serial/devices") {
        let timer = std::fs::read_to_string(port.join("latency_timer"));
        let Ok(timer) = timer else { continue };
        seen += 1;
        let ms: u64 = timer.trim().parse().unwrap_or(u64::MAX);
        if ms > LATENCY_TIMER_MAX_MS {
            slow.push((file_name(&port), ms));
        }
    }
    match (seen, slow.as_slice()) {
        (0, _) => finding(
            name,
            Verdict::Good,
            "no such adapter plugged in",
            should,
            "",
        ),
        (_, []) => finding(name, Verdict::Good, "1 ms", should, ""),
        (_, slow) => {
            let is: Vec<String> = slow
                .iter()
                .map(|(port, ms)| format!("{port} {ms} ms"))
                .collect();
            let mend: Vec<String> = slow
                .iter()
                .map(|(port, _)| {
                    format!("echo 1 | sudo tee /sys/bus/usb-serial/devices/{port}/latency_timer")
                })
                .collect();
            finding(
                name,
                Verdict::Better,
                is.join(", "),
                should,
                mend.join("; "),
            )
        }
    }
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}
