//! Checks a rig's answers to forces: the echo of a force, the rig's clock, and its reported
//! velocity.

use std::time::Duration;

use rt_core::port::{HapticDevice, Polled};

use super::Report;
use super::motion::{Clock, Motion};
use super::samples::NO_FORCE;
use super::watch::{Host, quantiles, watch};
use crate::rig::RigHaptic;

/// Largest relative deviation of a device's clock from this computer's. Quartz clocks differ by a
/// ten-thousandth.
const CLOCK_OFF: f64 = 0.01;

/// Largest relative deviation in any half second. It is larger, because arrivals jitter.
const CLOCK_WANDERS: f64 = 0.015;
/// Longest time between two forces, ns, while no valid sample comes.
const SEND_EVERY_NS: u64 = 2_000_000;

/// Sends zero forces for `time` and judges the samples that come meanwhile.
pub(super) fn answers(report: &mut Report, device: &mut RigHaptic, time: Duration) {
    let mut pending: Option<(u16, u64)> = None;
    let mut round_trips_ns = Vec::new();
    let mut clock = Clock::default();
    let mut motion = Motion::default();
    let mut last_us = None;
    let (mut last_ns, mut due_ns) = (0, 0);
    let unread = device.counters().unread_bytes;
    let host = watch(time, |now_ns| {
        let polled = device.poll(now_ns);
        let status = device.status();
        // The clock of a sample counts even if the sample was then judged wrong.
        if status.at_ns > last_ns {
            last_ns = status.at_ns;
            clock.take(status.at_ns, status.device_time_us);
        }
        let Polled::Fresh(sample) = polled else {
            // A device whose samples are all refused still gets forces.
            if now_ns >= due_ns {
                due_ns = now_ns + SEND_EVERY_NS;
                device.send(NO_FORCE, now_ns);
            }
            return;
        };
        if let Some(reported_m_s) = device.reported_velocity_m_s() {
            let at_m = sample.device_from_handle.translation.vector;
            let passed_us = last_us.map_or(0, |last| status.device_time_us.wrapping_sub(last));
            motion.take(at_m, reported_m_s, passed_us as f32 * 1.0e-6);
            last_us = Some(status.device_time_us);
        }
        if let Some((sent, sent_ns)) = pending
            && status.applied_force.wrapping_sub(sent) < 0x8000
        {
            round_trips_ns.push(now_ns - sent_ns);
            pending = None;
        }
        due_ns = now_ns + SEND_EVERY_NS;
        device.send(NO_FORCE, now_ns);
        pending = pending.or(Some((device.sent_sequence(), now_ns)));
    });
    let host = host.with_unread(device.counters().unread_bytes - unread);

    let echo = quantiles(&mut round_trips_ns);
    let words = format!("from a force to the first sample that confirms it: {echo}");
    report.judge("force echo", !round_trips_ns.is_empty(), words);
    if let Some(&median_ns) = round_trips_ns.get(round_trips_ns.len() / 2) {
        judge_delay(report, device, median_ns as f32 * 1.0e-9);
    }
    judge_clock(report, &clock, host);
    if !device.declared().measures_velocity {
        report.skip(
            "velocity",
            "the device declares that it measures no velocity",
        );
        return;
    }
    match motion.judged() {
        Some((good, words)) => report.judge("velocity", good, words),
        None => report.mark_not_judged(
            "velocity",
            "the handle hardly moved. Test again and move it by 5 cm to and fro meanwhile",
        ),
    }
}

/// Judges the rate of the device's clock, on the whole and in each half second.
fn judge_clock(report: &mut Report, clock: &Clock, host: Host) {
    let Some(rate) = clock.rate() else {
        report.mark_not_judged(
            "clock",
            "no sample came whose clock could be read: see `bad frames`",
        );
        return;
    };
    let mut good = (rate - 1.0).abs() <= CLOCK_OFF;
    let mut words =
        format!("the device's clock runs at {rate:.3} of this computer's, allowed is 1 % off");
    if let Some(worst) = clock
        .worst_rate()
        .filter(|it| (it - 1.0).abs() > CLOCK_WANDERS)
    {
        good = false;
        words += &format!("; for half a second at {worst:.3}, allowed is 1.5 % off");
    }
    report.judge_time("clock", good, words, host);
}

/// Judges the declared delay. It must be at least half of the echo, less three quarters of a sample
/// period.
fn judge_delay(report: &mut Report, device: &RigHaptic, echo_s: f32) {
    let said_s = device.declared().delay_s;
    let sample_s = 1.0 / f32::from(device.declared().rate_hz.max(1));
    let least_s = 0.5 * (echo_s - 1.5 * sample_s);
    let good = said_s >= least_s;
    let why = if good {
        ""
    } else {
        ". A delay that is declared too small makes hard contacts buzz"
    };
    report.judge(
        "delay",
        good,
        format!(
            "declares a delay of {:.2} ms, the force echo needs at least {:.2} ms{why}",
            said_s * 1e3,
            least_s.max(0.0) * 1e3
        ),
    );
}
