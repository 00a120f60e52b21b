//! Findings about serial adapters.

use std::io::ErrorKind;
use std::path::Path;

use super::finding::{Finding, Verdict, finding};
use super::system::System;

/// Longest good setting of an FTDI chip's latency timer, ms. The chip holds received bytes back
/// until the timer ends.
const LATENCY_TIMER_MAX_MS: u64 = 1;

/// Examines the latency timers of all plugged-in USB serial adapters that have one.
pub(super) fn serial(system: &System) -> Finding {
    let name = "USB serial latency";
    let should = "latency timer of 1 ms: FTDI chips hold bytes back for 16 ms by default";
    let (mut seen, mut is, mut mend) = (0, Vec::new(), Vec::new());
    let mut verdict = Verdict::Good;
    for port in system.entries("sys/bus/usb-serial/devices") {
        let timer = match std::fs::read_to_string(port.join("latency_timer")) {
            // Adapters without an FTDI chip have no timer.
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            timer => timer,
        };
        seen += 1;
        let timer_ms = timer.ok().and_then(|text| text.trim().parse::<u64>().ok());
        let port = file_name(&port);
        match timer_ms {
            Some(ms) if ms <= LATENCY_TIMER_MAX_MS => continue,
            Some(ms) => {
                is.push(format!("{port} {ms} ms"));
                verdict = Verdict::Better;
            }
            None => {
                is.push(format!("{port} cannot be read"));
                if verdict == Verdict::Good {
                    verdict = Verdict::Unknown;
                }
            }
        }
        mend.push(format!(
            "echo 1 | sudo tee /sys/bus/usb-serial/devices/{port}/latency_timer"
        ));
    }
    let is = match (seen, verdict) {
        (0, _) => "no such adapter plugged in".to_owned(),
        (_, Verdict::Good) => "1 ms".to_owned(),
        _ => is.join(", "),
    };
    finding(name, verdict, is, should, mend.join("; "))
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}
