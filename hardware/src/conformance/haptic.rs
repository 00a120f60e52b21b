//! Conformance checks of a haptic device that speaks the rig protocol.

use std::path::Path;
use std::time::Duration;

use rt_core::port::{HapticDevice, Polled};

use super::samples::{NO_FORCE, samples};
use super::watch::{PATIENCE, open, quantiles, silent_after_close, unplugged, until};
use super::{Options, Report};
use crate::rig::device::WATCHDOG_LIMIT_MS;
use crate::rig::wire::Status;
use crate::rig::{BAUD, RigHaptic};

/// Attempts at the watchdog check: a busy host may spoil one.
const WATCHDOG_TRIES: u32 = 3;

/// Tests the device at `path`.
pub fn haptic(path: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("haptic device");
    let Some(mut device) = open(&mut report, "handshake", || RigHaptic::open(path)) else {
        return report;
    };
    let name = device.identity().name;
    let name = String::from_utf8_lossy(&name);
    report.device = format!(
        "haptic device \"{}\", serial {}",
        name.trim_end_matches('\0'),
        device.identity().serial
    );
    samples(&mut report, &mut device, options.watch);
    force_echo(&mut report, &mut device, options.watch);
    watchdog(&mut report, &mut device);
    drop(device);
    silent_after_close(&mut report, path, BAUD);
    if let Some(mut device) = open(&mut report, "reopen", || RigHaptic::open(path)) {
        let forceless = fresh(&mut device) && !device.status().status.contains(Status::FORCE_ON);
        report.judge(
            "no old force",
            forceless,
            "a new host finds no force left over".into(),
        );
        unplugged(&mut report, options, |now_ns| device.poll(now_ns));
    }
    report
}

fn fresh(device: &mut RigHaptic) -> bool {
    until(PATIENCE, |now_ns| {
        !matches!(device.poll(now_ns), Polled::Fresh(_))
    })
}

/// Stops sending and measures, on the device's clock, how long the last force stays.
fn watchdog(report: &mut Report, device: &mut RigHaptic) {
    let limit_us = u32::from(WATCHDOG_LIMIT_MS) * 1000;
    let mut shortest_us = None;
    for _ in 0..WATCHDOG_TRIES {
        let on = until(PATIENCE, |now_ns| {
            device.send(NO_FORCE, now_ns);
            device.poll(now_ns);
            !device.status().status.contains(Status::FORCE_ON)
        });
        if !on {
            break;
        }
        // The last force takes effect with the first sample that names it.
        let last = device.sent_sequence();
        let mut since_us = None;
        let mut held_us = None;
        until(PATIENCE, |now_ns| {
            if matches!(device.poll(now_ns), Polled::Fresh(_)) {
                let status = device.status();
                if status.status.contains(Status::WATCHDOG) {
                    held_us = since_us.map(|since| status.device_time_us.wrapping_sub(since));
                    return false;
                }
                if status.applied_force == last && since_us.is_none() {
                    since_us = Some(status.device_time_us);
                }
            }
            true
        });
        shortest_us = match (shortest_us, held_us) {
            (Some(shortest), Some(held)) => Some(std::cmp::min::<u32>(shortest, held)),
            (shortest, held) => shortest.or(held),
        };
    }
    let declared_ms = device.identity().watchdog_ms;
    match shortest_us {
        Some(held_us) => report.judge(
            "watchdog",
            held_us <= limit_us,
            format!(
                "force dropped {:.1} ms after the last command, declared {declared_ms} ms, \
                 allowed {WATCHDOG_LIMIT_MS} ms",
                f64::from(held_us) * 1e-3
            ),
        ),
        None => report.judge(
            "watchdog",
            false,
            format!("the force was not dropped in {} s", PATIENCE.as_secs()),
        ),
    }
}

/// Measures the time from sending a force to the sample that confirms it.
fn force_echo(report: &mut Report, device: &mut RigHaptic, watch: Duration) {
    let mut under_way: Option<(u16, u64)> = None;
    let mut round_trips_ns = Vec::new();
    until(watch, |now_ns| {
        if matches!(device.poll(now_ns), Polled::Fresh(_)) {
            let applied = device.status().applied_force;
            if let Some((sent, sent_ns)) = under_way
                && applied.wrapping_sub(sent) < 0x8000
            {
                round_trips_ns.push(now_ns - sent_ns);
                under_way = None;
            }
            device.send(NO_FORCE, now_ns);
            under_way = under_way.or(Some((device.sent_sequence(), now_ns)));
        }
        true
    });
    report.judge(
        "force echo",
        !round_trips_ns.is_empty(),
        format!(
            "force to sample with it in effect {}",
            quantiles(&mut round_trips_ns)
        ),
    );
}
