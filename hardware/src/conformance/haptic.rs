//! The checks of a haptic device that speaks the rig protocol.

use std::path::Path;
use std::time::Instant;

use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, HapticDevice, Polled};

use super::watch::{Arrivals, PATIENCE, quantiles, silent_after_close, unplugged, until};
use super::{Options, Report};
use crate::rig::device::WATCHDOG_LIMIT_MS;
use crate::rig::wire::Status;
use crate::rig::{BAUD, RigHaptic};

const NO_FORCE: ForceCommand = ForceCommand {
    force_n: Vec3::new(0.0, 0.0, 0.0),
    torque_n_m: Vec3::new(0.0, 0.0, 0.0),
};
/// Tries of the watchdog: a busy host may spoil one.
const WATCHDOG_TRIES: u32 = 3;

/// Tests the device behind `path`.
pub fn haptic(path: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("haptic device");
    let Some(mut device) = open(&mut report, "handshake", path) else {
        return report;
    };
    let name = device.identity().name;
    let name = String::from_utf8_lossy(&name);
    report.device = format!(
        "haptic device \"{}\", serial {}",
        name.trim_end_matches('\0'),
        device.identity().serial
    );
    samples(&mut report, &mut device, options);
    watchdog(&mut report, &mut device);
    drop(device);
    silent_after_close(&mut report, path, BAUD);
    if let Some(mut device) = open(&mut report, "reopen", path) {
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

fn open(report: &mut Report, name: &'static str, path: &Path) -> Option<RigHaptic> {
    let start = Instant::now();
    match RigHaptic::open(path) {
        Ok(device) => {
            report.judge(
                name,
                true,
                format!("answered in {} ms", start.elapsed().as_millis()),
            );
            Some(device)
        }
        Err(error) => {
            report.judge(name, false, error.to_string());
            None
        }
    }
}

fn fresh(device: &mut RigHaptic) -> bool {
    until(PATIENCE, |now_ns| {
        !matches!(device.poll(now_ns), Polled::Fresh(_))
    })
}

/// Rate, gaps, ranges, and how soon a force is in effect.
fn samples(report: &mut Report, device: &mut RigHaptic, options: &Options<'_>) {
    let capabilities = device.capabilities();
    let before = device.counters();
    let mut arrivals = Arrivals::default();
    let mut farthest_m = 0.0f32;
    let mut fastest_m_s = 0.0f32;
    let mut finite = true;
    let mut under_way: Option<(u16, u64)> = None;
    let mut round_trips_ns = Vec::new();
    let start = Instant::now();
    until(options.watch, |now_ns| {
        if let Polled::Fresh(sample) = device.poll(now_ns) {
            arrivals.add(now_ns);
            let pose = sample.device_from_handle;
            let velocity_m_s = sample.velocity_m_s.unwrap_or_default();
            farthest_m = farthest_m.max(pose.translation.vector.norm());
            fastest_m_s = fastest_m_s.max(velocity_m_s.norm());
            finite &= pose.translation.vector.iter().all(|part| part.is_finite())
                && velocity_m_s.iter().all(|part| part.is_finite())
                && (pose.rotation.norm() - 1.0).abs() < 1e-3;
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
    let seconds = start.elapsed().as_secs_f32();
    let after = device.counters();
    let frames = after.frames - before.frames;
    let lost = after.lost_frames - before.lost_frames;
    let bad = after.bad_frames - before.bad_frames;
    let sent_hz = (frames + lost) as f32 / seconds;

    let declared_hz = capabilities.rate_hz;
    report.judge(
        "rate",
        (0.8..=1.2).contains(&(sent_hz / declared_hz)),
        format!("{sent_hz:.0} samples/s, declared are {declared_hz:.0}, allowed is ±20 %"),
    );
    report.judge(
        "intervals",
        arrivals.count() > 1,
        format!("between fresh samples {}", arrivals.intervals()),
    );
    let share = |part: u64| part as f32 / (frames + lost + bad).max(1) as f32;
    report.judge(
        "gaps",
        share(lost) < 0.01,
        format!("{lost} of {} samples lost, allowed is 1 %", frames + lost),
    );
    report.judge(
        "checksums",
        share(bad) < 0.01,
        format!("{bad} bad frames, allowed is 1 %"),
    );
    report.judge("finite", finite, "every pose and velocity is finite".into());
    let radius_m = capabilities.workspace_radius_m;
    report.judge(
        "workspace",
        farthest_m <= radius_m * 1.1,
        format!("farthest {farthest_m:.3} m, declared are {radius_m:.3} m, allowed is 10 % more"),
    );
    report.judge(
        "speed",
        fastest_m_s < 5.0,
        format!("fastest {fastest_m_s:.2} m/s, allowed is 5 m/s"),
    );
    report.judge(
        "force echo",
        !round_trips_ns.is_empty(),
        format!(
            "force to sample with it in effect {}",
            quantiles(&mut round_trips_ns)
        ),
    );
    let dropped = after.dropped_writes - before.dropped_writes;
    report.judge(
        "writes",
        dropped == 0,
        format!("{dropped} forces that the line did not take"),
    );
}

/// Stops sending, and measures on the device's clock how long the last force stays.
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
        // The last force is in effect from the first sample that names it.
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
                "force dropped {:.1} ms after the last command, declared are {declared_ms} ms, \
                 allowed are {WATCHDOG_LIMIT_MS} ms",
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
