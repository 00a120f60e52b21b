//! Checks of the samples of any haptic device.

use std::path::Path;
use std::time::{Duration, Instant};

use rt_core::fault::{Fault, FaultSet};
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, Freedom, HapticDevice, Opening, Polled};

use super::Report;
use super::watch::{Arrivals, Host, watch};
use crate::arrivals::{self, Pattern};
use crate::noise::NOISY_M;

/// Allowed relative deviation from the declared rate.
const RATE_OFF: f32 = 0.05;

pub(super) const NO_FORCE: ForceCommand = ForceCommand {
    opening_n: 0.0,
    force_n: Vec3::new(0.0, 0.0, 0.0),
    torque_nm: Vec3::new(0.0, 0.0, 0.0),
};

/// Watches the samples of an open device for `time` at zero force: rate, gaps, ranges.
pub(super) fn samples(report: &mut Report, device: &mut impl HapticDevice, time: Duration) {
    samples_with_refused(report, device, time, |_| 0);
}

/// Like [`samples`], for a driver that counts the samples that it refused. Such samples arrived, so
/// they count for the rate.
pub(super) fn samples_with_refused<D: HapticDevice>(
    report: &mut Report,
    device: &mut D,
    time: Duration,
    refused: impl Fn(&D) -> u64,
) {
    let capabilities = device.capabilities();
    let period_ns = (1e9 / capabilities.rate_hz) as u64;
    let before = device.counters();
    let refused_before = refused(device);
    let mut arrivals = Arrivals::default();
    let (mut arrival_pattern, mut counted) = (arrivals::Arrivals::default(), before.frames);
    let mut farthest_m = 0.0f32;
    let mut fastest_m_s = 0.0f32;
    let mut finite = true;
    let mut turned = false;
    let mut openings = Openings::default();
    let mut noise_um = None;
    let mut due_ns = 0;
    let mut found = FaultSet::NONE;
    let mut bundle_ms = 0;
    let start = Instant::now();
    let host = watch(time, |now_ns| {
        if now_ns >= due_ns {
            device.send(NO_FORCE, now_ns);
            // Send at the declared rate, as a tick does. Missed periods are skipped.
            due_ns = if now_ns < due_ns + period_ns {
                due_ns
            } else {
                now_ns
            } + period_ns;
        }
        let polled = device.poll(now_ns);
        let findings = device.findings();
        found = found.with(findings.faults);
        bundle_ms = bundle_ms.max(findings.bundle_ms);
        noise_um = findings.noise_um.or(noise_um);
        if let Polled::Fresh(sample) = polled {
            arrivals.add(now_ns);
            let frames = device.counters().frames;
            arrival_pattern.take(frames.saturating_sub(counted), sample.at_ns);
            counted = frames;
            let pose = sample.device_from_handle;
            let velocity_m_s = sample.velocity_m_s.unwrap_or_default();
            farthest_m = farthest_m.max(pose.translation.vector.norm());
            fastest_m_s = fastest_m_s.max(velocity_m_s.norm());
            openings.add(sample.opening);
            turned |= pose.rotation.coords.xyz() != Vec3::zeros();
            finite &= pose.translation.vector.iter().all(|part| part.is_finite())
                && velocity_m_s.iter().all(|part| part.is_finite())
                && (pose.rotation.norm() - 1.0).abs() < 1e-3;
        }
    });
    let seconds = start.elapsed().as_secs_f32();
    let after = device.counters();
    let frames = after.frames - before.frames;
    let lost = after.lost_frames - before.lost_frames;
    let bad = after.bad_frames - before.bad_frames;
    let refused = refused(device) - refused_before;
    let sent_hz = (frames + lost + refused) as f32 / seconds;
    let host = host.with_unread(after.unread_bytes - before.unread_bytes);

    judge_freedom(report, device.freedom(), turned || arrivals.count() == 0);
    let declared_hz = capabilities.rate_hz;
    let of_them = match refused {
        0 => String::new(),
        count => format!(", of which {count} were refused in {seconds:.1} s: see `bad frames`"),
    };
    report.judge_time(
        "rate",
        (sent_hz / declared_hz - 1.0).abs() <= RATE_OFF + host.share(),
        format!(
            "{sent_hz:.0} samples/s, declared {declared_hz:.0}, allowed {:.0} % off{}{of_them}",
            (RATE_OFF + host.share()) * 100.0,
            match host.share() > 0.005 {
                true => ", because this computer was late for some of the time",
                false => "",
            }
        ),
        host,
    );
    if arrivals.count() > 1 {
        let intervals = format!("between fresh samples {}", arrivals.intervals());
        report.judge("intervals", true, intervals);
    } else {
        let count = arrivals.count();
        let detail = format!("{count} valid samples in {seconds:.1} s, needed are 2");
        report.judge_time("intervals", false, detail, host);
    }
    let share = |part: u64| part as f32 / (frames + lost + bad).max(1) as f32;
    report.judge_time(
        "gaps",
        share(lost) < 0.01,
        format!("{lost} of {} samples lost, allowed is 1 %", frames + lost),
        host,
    );
    report.judge_time(
        "bad frames",
        share(bad) < 0.01,
        format!("{bad} bad frames, allowed is 1 %"),
        host,
    );
    let dropped = after.dropped_writes - before.dropped_writes;
    report.judge_time(
        "writes",
        dropped == 0,
        format!("{dropped} forces refused by the line"),
        host,
    );
    judge_findings(report, found, bundle_ms, host);
    judge_arrivals(report, arrival_pattern.found(), host);
    if arrivals.count() == 0 {
        for name in ["finite", "noise", "opening", "workspace", "speed"] {
            report.mark_not_judged(name, "there was no valid sample");
        }
        return;
    }
    let words = match finite {
        true => "every pose and velocity is finite",
        false => "a pose or a velocity is not finite",
    };
    report.judge("finite", finite, words.into());
    judge_noise(report, noise_um, capabilities.stiffness_max_n_m);
    openings.judge(report, &capabilities.opening);
    let radius_m = capabilities.workspace_radius_m;
    report.judge(
        "workspace",
        farthest_m <= radius_m * 1.1,
        format!("farthest {farthest_m:.3} m, declared {radius_m:.3} m, allowed 10 % more"),
    );
    report.judge(
        "speed",
        fastest_m_s < 5.0,
        format!("fastest {fastest_m_s:.2} m/s, allowed is 5 m/s"),
    );
}

/// Adds the reasons for bad frames to their check.
pub(super) fn name_bad_frames(
    report: &mut Report,
    found: impl Iterator<Item = (&'static str, u64)>,
) {
    let found = found.filter(|(_, count)| *count > 0);
    let found: Vec<String> = found.map(|(why, count)| format!("{count} {why}")).collect();
    if !found.is_empty() {
        report.add_to("bad frames", &format!(": {}", found.join(", ")));
    }
}

/// Judges the directions that the device measures and renders. If no sample `turned`, the device
/// measures no rotation, or nobody turned the handle.
fn judge_freedom(report: &mut Report, freedom: Freedom, turned: bool) {
    let Freedom { measured, rendered } = freedom;
    let good = (1..=6).contains(&measured) && (1..=6).contains(&rendered);
    let measures = match turned || measured <= 3 {
        true => measured.to_string(),
        false => "3 (no sample has a rotation)".to_owned(),
    };
    let words = format!(
        "measures {measures} and renders {rendered} of 6 directions; the others are dropped"
    );
    report.judge("freedom", good, words);
}

/// Judges the noise of the positions, and states the force steps that it causes at the largest
/// stiffness.
fn judge_noise(report: &mut Report, noise_um: Option<u32>, stiffness_max_n_m: f32) {
    let Some(noise_um) = noise_um else {
        report.skip(
            "noise",
            "the driver does not measure it, or has too few samples",
        );
        return;
    };
    let rms_m = noise_um as f32 * 1.0e-6;
    // The difference of two consecutive samples has √2 times the noise of one sample.
    let step_n = core::f32::consts::SQRT_2 * rms_m * stiffness_max_n_m;
    let detail = format!(
        "positions are noisy by {:.3} mm rms, allowed is {:.1} mm; at {stiffness_max_n_m:.0} N/m that \
         makes force steps of {step_n:.2} N from sample to sample",
        rms_m * 1e3,
        NOISY_M * 1e3,
    );
    report.judge("noise", rms_m <= NOISY_M, detail);
}

/// Openings of the handle that the samples reported.
#[derive(Default)]
struct Openings {
    /// Least and greatest opening.
    seen: Option<(f32, f32)>,
    missing: u32,
    wrong: u32,
}

impl Openings {
    fn add(&mut self, opening: Option<f32>) {
        match opening {
            Some(opening) if (0.0..=1.0).contains(&opening) => {
                let (least, most) = self.seen.unwrap_or((opening, opening));
                self.seen = Some((least.min(opening), most.max(opening)));
            }
            Some(_) => self.wrong += 1,
            None => self.missing += 1,
        }
    }

    fn judge(&self, report: &mut Report, declared: &Opening) {
        if !declared.is_measured() {
            report.skip(
                "opening",
                "the handle does not open, or does not measure its opening",
            );
            return;
        }
        let Self { missing, wrong, .. } = self;
        let seen = self.seen.map_or_else(
            || "no opening was read".to_owned(),
            |(least, most)| format!("{:.0} to {:.0} % open", least * 100.0, most * 100.0),
        );
        let detail = format!(
            "{seen} while watched; the handle opens by {:.0} mm with up to {:.1} N; {missing} samples had \
             no opening, {wrong} were outside 0 to 100 %. Open and shut the handle during a test to see its \
             range",
            declared.travel_m * 1e3,
            declared.force_max_n
        );
        report.judge(
            "opening",
            self.seen.is_some() && missing + wrong == 0,
            detail,
        );
    }
}

/// Judges the arrivals of the samples. Waiting for the frames of full-speed USB is reported, but is
/// no fault.
fn judge_arrivals(report: &mut Report, pattern: Option<Pattern>, host: Host) {
    let is_good = !matches!(pattern, Some(Pattern::Ftdi | Pattern::Batches { .. }));
    let words = pattern.map_or_else(
        || {
            "samples come one by one: no adapter's timer, no batches, no frames of full-speed USB"
                .into()
        },
        |pattern| pattern.in_words(Path::new("ttyUSB0")) + " (with the name of its tty)",
    );
    report.judge_time("arrivals", is_good, words, host);
}

/// Judges the faults that the driver found in the samples.
fn judge_findings(report: &mut Report, found: FaultSet, bundle_ms: u32, host: Host) {
    report.judge_time(
        "bundles",
        !found.contains(Fault::DeviceBundles),
        if found.contains(Fault::DeviceBundles) {
            format!(
                "samples come in bundles of {bundle_ms} ms. An FTDI adapter's latency timer does \
                 that; as root: echo 1 > /sys/bus/usb-serial/devices/ttyUSB0/latency_timer (with \
                 the name of its tty)"
            )
        } else {
            "no bundles of 6 ms or longer".into()
        },
        host,
    );
    let names: Vec<&str> = [
        Fault::FrozenDevice,
        Fault::DeviceClock,
        Fault::DeviceLeap,
        Fault::DeafDevice,
        Fault::DeviceFault,
    ]
    .into_iter()
    .filter(|fault| found.contains(*fault))
    .map(Fault::name)
    .collect();
    let mut detail = if names.is_empty() {
        "positions, clock and confirmed forces agree".into()
    } else {
        format!("found: {}", names.join(", "))
    };
    // The next two findings are no faults of the samples. They explain a force that is weaker than
    // commanded.
    if found.contains(Fault::DeviceLimited) {
        detail += "; the device says that it limits its force (status bit 2: heat or current)";
    }
    if found.contains(Fault::DeviceWatchdog) {
        detail +=
            "; its watchdog acted (status bit 1): commands came late, or the line loses bytes";
    }
    report.judge("consistent", names.is_empty(), detail);
}
