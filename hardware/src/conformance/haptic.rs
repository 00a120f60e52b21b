//! Conformance checks of a haptic device that speaks the rig protocol.

use std::path::Path;

use rt_core::port::{HapticDevice, Identity, Polled};

use super::answers::answers;
use super::samples::{NO_FORCE, name_bad_frames, samples_with_refused};
use super::watch::{Host, TIMEOUT, open, silent_after_close, unplugged, until, until_timed};
use super::{Options, Report};
use crate::rig::device::WATCHDOG_LIMIT_MS;
use crate::rig::wire::{Capabilities, Status};
use crate::rig::{BAUD, RigHaptic};

/// Number of tries of the watchdog, because a faulty one may work in some tries.
const WATCHDOG_TRIES: u32 = 6;
/// Largest number of tries. A try in which this computer lost bytes is repeated.
const WATCHDOG_TRIES_MAX: u32 = 30;
/// Time, µs, by which a force may outlast the declared time plus one sample, because times are
/// rounded.
const WATCHDOG_ROUNDING_US: u64 = 2000;
/// Further time, µs, for which a force may stay as seen by this computer's clock, because samples
/// arrive late.
const WATCHDOG_ARRIVAL_US: u64 = 20_000;

/// Tests the device at `path`.
pub fn haptic(path: &Path, options: &mut Options<'_>) -> Report {
    let mut report = Report::new("haptic device");
    let Some(mut device) = open(&mut report, "handshake", || RigHaptic::open(path)) else {
        return report;
    };
    let Identity { name, serial } = device.identity();
    report.device = format!("haptic device \"{name}\", serial {serial}");
    samples_with_refused(
        &mut report,
        &mut device,
        options.watch,
        RigHaptic::refused_samples,
    );
    name_bad_frames(&mut report, device.bad_frames());
    answers(&mut report, &mut device, options.watch);
    watchdog(&mut report, &mut device);
    drop(device);
    silent_after_close(&mut report, path, BAUD);
    if let Some(mut device) = open(&mut report, "reopen", || RigHaptic::open(path)) {
        let heard = has_fresh_sample(&mut device);
        let is_on = device.status().status.contains(Status::FORCE_ON);
        let words = match (heard, is_on) {
            (false, _) => "no valid sample came, so it is not known whether a force is left over",
            (true, true) => "a force of the previous host is still in effect: HELLO must end it",
            (true, false) => "a new host finds no force left over",
        };
        report.judge("no old force", heard && !is_on, words.into());
        unplugged(&mut report, options, |now_ns| device.poll(now_ns));
    }
    report
}

fn has_fresh_sample(device: &mut RigHaptic) -> bool {
    until(TIMEOUT, |now_ns| {
        !matches!(device.poll(now_ns), Polled::Fresh(_))
    })
}

/// Time for which the last force stayed, µs, by the device's clock and by this computer's.
#[derive(Debug, Clone, Copy, Default)]
struct HoldTime {
    device_us: u32,
    host_us: u64,
}

impl HoldTime {
    /// The longer of both by each clock.
    fn max(self, other: Self) -> Self {
        Self {
            device_us: self.device_us.max(other.device_us),
            host_us: self.host_us.max(other.host_us),
        }
    }
}

/// Stops sending and measures how long the last force stays. The longest of several tries counts.
fn watchdog(report: &mut Report, device: &mut RigHaptic) {
    let mut longest = HoldTime::default();
    let mut longest_whole = HoldTime::default();
    let mut whole = 0;
    let mut host = Host::default();
    let unread = device.counters().unread_bytes;
    for _ in 0..WATCHDOG_TRIES_MAX {
        let before = device.counters().unread_bytes;
        let held = match held(device, &mut host) {
            Ok(held) => held,
            Err(words) => {
                report.judge("watchdog", false, words);
                return;
            }
        };
        longest = longest.max(held);
        // The first sample after the drop may be among bytes that this computer did not read.
        if device.counters().unread_bytes == before {
            longest_whole = longest_whole.max(held);
            whole += 1;
        }
        if whole == WATCHDOG_TRIES {
            judge_held(report, device.declared(), longest_whole, host);
            return;
        }
    }
    let host = host.with_unread(device.counters().unread_bytes - unread);
    judge_held(report, device.declared(), longest, host);
}

/// Judges the longest time for which a force stayed. `host` has the delays of this computer during
/// the tries.
fn judge_held(report: &mut Report, declared: &Capabilities, held: HoldTime, host: Host) {
    let HoldTime { device_us, host_us } = held;
    let declared_ms = declared.watchdog_ms.min(WATCHDOG_LIMIT_MS);
    // The next sample reports the drop.
    let sample_us = 1_000_000 / u64::from(declared.rate_hz.max(1));
    let allowed_us = u64::from(declared_ms) * 1000 + sample_us + WATCHDOG_ROUNDING_US;
    let ms = |us: u64| us as f64 * 1e-3;
    let words = format!(
        "force dropped at the latest {:.1} ms after the last command by the device's clock, {:.1} ms \
         by this computer's; declared {declared_ms} ms",
        ms(device_us.into()),
        ms(host_us)
    );
    if u64::from(device_us) > allowed_us {
        // These times come from the samples. A late computer reads the same samples, unless it lost
        // some.
        report.judge_time("watchdog", false, words, host.unread_only());
    } else {
        // A busy computer sees the drop late. A watchdog that fails drops the force even later.
        let late_us = allowed_us + WATCHDOG_ARRIVAL_US;
        report.judge_time("watchdog", host_us <= late_us, words, host);
    }
}

/// One try: sends zero force until it is in effect, stops sending, and waits for the watchdog.
/// Adds the delays of this computer to `host`.
fn held(device: &mut RigHaptic, host: &mut Host) -> Result<HoldTime, String> {
    let mut heard = false;
    let on = until_timed(host, TIMEOUT, |now_ns| {
        device.send(NO_FORCE, now_ns);
        heard |= matches!(device.poll(now_ns), Polled::Fresh(_));
        !device.status().status.contains(Status::FORCE_ON)
    });
    if !on {
        return Err(match heard {
            false => "no valid sample came".into(),
            true => {
                "status bit 0 never came on. It says that a FORCE is in effect, even a zero one"
                    .into()
            }
        });
    }
    // The last force is in effect from the first sample on that names its number.
    let last = device.sent_sequence();
    let before = device.drops().count;
    let mut since_ns = None;
    let mut held = None;
    let mut is_off = false;
    until_timed(host, TIMEOUT, |now_ns| {
        device.poll(now_ns);
        let status = device.status();
        is_off = !status.status.contains(Status::FORCE_ON);
        if status.applied_force == last && since_ns.is_none() {
            since_ns = Some(now_ns);
        }
        let drops = device.drops();
        if drops.count == before {
            return true;
        }
        held = Some(HoldTime {
            device_us: drops.held_us,
            host_us: since_ns.map_or(0, |it| now_ns.saturating_sub(it) / 1000),
        });
        false
    });
    held.ok_or_else(|| {
        if is_off {
            return "the force went off, and status bit 1 does not say that the watchdog dropped it"
                .to_owned();
        }
        format!("the force was not dropped in {} s", TIMEOUT.as_secs())
    })
}

#[cfg(test)]
mod tests {
    use super::super::CheckOutcome;
    use super::*;

    /// Outcome for a device that declares 50 ms.
    fn outcome(device_us: u32, host_us: u64, host: Host) -> CheckOutcome {
        let mut report = Report::new("a device");
        let declared = Capabilities::touch_class();
        assert_eq!(declared.watchdog_ms, 50);
        judge_held(
            &mut report,
            &declared,
            HoldTime { device_us, host_us },
            host,
        );
        report.checks[0].outcome
    }

    #[test]
    fn a_late_computer_is_not_reported_as_a_late_watchdog() {
        let calm = Host::default();
        let busy = Host::of_sleeps_ms(&[1, 1, 70]);
        assert_eq!(outcome(50_500, 51_000, calm), CheckOutcome::Pass);
        assert_eq!(outcome(50_500, 120_000, busy), CheckOutcome::NotJudged);
        assert_eq!(outcome(50_500, 120_000, calm), CheckOutcome::Fail);
    }

    #[test]
    fn a_late_watchdog_fails_on_a_busy_computer_too_unless_samples_were_lost() {
        let busy = Host::of_sleeps_ms(&[1, 1, 70]);
        assert_eq!(outcome(95_000, 95_000, busy), CheckOutcome::Fail);
        let missed = busy.with_unread(80);
        assert_eq!(outcome(95_000, 95_000, missed), CheckOutcome::NotJudged);
    }
}
