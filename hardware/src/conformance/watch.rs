//! Functions shared by the checks of all devices.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::port::Polled;
use rt_core::time::TimeNs;

use super::{Options, Report};
use crate::HardwareError;
use crate::line::{Line, Read};

/// Longest wait for an expected event.
pub(super) const TIMEOUT: Duration = Duration::from_secs(5);

/// `CLOCK_MONOTONIC`, ns.
pub(super) fn now_ns() -> TimeNs {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Calls `step` about 4000 times a second until it returns false or `limit` is over. Returns true
/// if `step` returned false.
pub(super) fn until(limit: Duration, step: impl FnMut(TimeNs) -> bool) -> bool {
    until_timed(&mut Host::default(), limit, step)
}

/// Like [`until`]; also adds the delays of this computer to `host`.
pub(super) fn until_timed(
    host: &mut Host,
    limit: Duration,
    mut step: impl FnMut(TimeNs) -> bool,
) -> bool {
    let since = |then: TimeNs, now: TimeNs| Duration::from_nanos(now.saturating_sub(then));
    let start_ns = now_ns();
    let (mut began_ns, mut done_ns) = (start_ns, start_ns);
    loop {
        let at_ns = now_ns();
        host.add_step(since(began_ns, done_ns), since(done_ns, at_ns));
        if since(start_ns, at_ns) >= limit {
            return false;
        }
        let goes_on = step(at_ns);
        (began_ns, done_ns) = (at_ns, now_ns());
        if !goes_on {
            host.add_step(since(began_ns, done_ns), Duration::ZERO);
            return true;
        }
        thread::sleep(Duration::from_micros(250));
    }
}

/// Time for which this computer itself was late. Samples that came late or were lost in that time
/// are not the device's fault.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Host {
    watched: Duration,
    waited: Duration,
    /// Number of bytes that this computer did not read in time.
    unread: u64,
}

impl Host {
    /// Duration above which a sleep of 0.25 ms counts as a delay of this computer.
    const LATE: Duration = Duration::from_millis(2);
    /// Largest share of late time with which this computer may judge a device's timing.
    const SHARE_MAX: f32 = 0.05;

    /// A computer that slept for these times.
    #[cfg(test)]
    pub(super) fn of_sleeps_ms(sleeps_ms: &[u64]) -> Self {
        let mut host = Self::default();
        for &ms in sleeps_ms {
            host.add_step(Duration::ZERO, Duration::from_millis(ms));
        }
        host
    }

    /// Records one step and the sleep after it. Only a sleep that took too long counts as a delay,
    /// so a slow driver is no excuse.
    fn add_step(&mut self, took: Duration, slept: Duration) {
        self.watched += took + slept;
        if slept > Self::LATE {
            self.waited += slept;
        }
    }

    /// Notes bytes that this computer did not read in time.
    pub(super) const fn with_unread(mut self, unread: u64) -> Self {
        self.unread += unread;
        self
    }

    /// Only the bytes that this computer did not read in time.
    pub(super) fn unread_only(self) -> Self {
        Self::default().with_unread(self.unread)
    }

    /// Share of the time for which this computer was late.
    pub(super) fn share(self) -> f32 {
        self.waited.as_secs_f32() / self.watched.as_secs_f32().max(1e-6)
    }

    /// Reason for which timing cannot be judged; `None` if it can.
    pub(super) fn excuse(self) -> Option<String> {
        if self.unread > 0 {
            return Some(format!(
                "not judged: this computer did not read {} bytes in time; end other programs and \
                 test again",
                self.unread
            ));
        }
        let share = self.share();
        (share > Self::SHARE_MAX).then(|| {
            format!(
                "not judged: this computer was busy for {} of {} ms; end other programs and test again",
                self.waited.as_millis(),
                self.watched.as_millis()
            )
        })
    }
}

/// Calls `step` like [`until`] for all of `limit`, and returns the delays of this computer.
pub(super) fn watch(limit: Duration, mut step: impl FnMut(TimeNs)) -> Host {
    let mut host = Host::default();
    until_timed(&mut host, limit, |at_ns| {
        step(at_ns);
        true
    });
    host
}

/// Arrival times of samples.
#[derive(Debug, Default)]
pub(super) struct Arrivals {
    at_ns: Vec<TimeNs>,
}

impl Arrivals {
    pub(super) fn add(&mut self, at_ns: TimeNs) {
        self.at_ns.push(at_ns);
    }

    pub(super) fn count(&self) -> usize {
        self.at_ns.len()
    }

    /// Median, 99th percentile and maximum of the intervals, as text.
    pub(super) fn intervals(&self) -> String {
        let mut intervals: Vec<u64> = self
            .at_ns
            .windows(2)
            .map(|pair| pair[1].saturating_sub(pair[0]))
            .collect();
        quantiles(&mut intervals)
    }
}

/// Median, 99th percentile and maximum of times, as text.
pub(super) fn quantiles(times_ns: &mut [u64]) -> String {
    if times_ns.is_empty() {
        return "never measured".to_owned();
    }
    times_ns.sort_unstable();
    let at = |share: f64| {
        let index = (times_ns.len().saturating_sub(1) as f64 * share) as usize;
        times_ns.get(index).map_or(f64::NAN, |&ns| ns as f64 * 1e-6)
    };
    format!(
        "p50 {:.2} ms, p99 {:.2} ms, max {:.2} ms",
        at(0.5),
        at(0.99),
        at(1.0)
    )
}

/// Checks that the line is silent after the driver has closed.
pub(super) fn silent_after_close(report: &mut Report, path: &Path, baud: u32) {
    let heard = Line::open(path, baud).map(|mut line| {
        let mut bytes = [0; 256];
        let mut heard = 0;
        until(Duration::from_millis(300), |_| {
            if let Read::Bytes(count, _) = line.read(&mut bytes) {
                heard += count;
            }
            true
        });
        heard
    });
    match heard {
        // Bytes that were already sent at closing may still arrive.
        Ok(heard) => report.judge(
            "close",
            heard < 256,
            format!("{heard} bytes in 300 ms after closing, allowed are fewer than 256"),
        ),
        Err(error) => report.judge("close", false, error.to_string()),
    }
}

/// Unplugs the device and waits for `poll` to report the loss.
pub(super) fn unplugged<T>(
    report: &mut Report,
    options: &mut Options<'_>,
    mut poll: impl FnMut(TimeNs) -> Polled<T>,
) {
    let Some(unplug) = &mut options.unplug else {
        report.skip("unplug", "nobody to pull the plug");
        return;
    };
    unplug();
    let start = Instant::now();
    let lost = until(TIMEOUT, |now_ns| !matches!(poll(now_ns), Polled::Lost));
    let stays = matches!(poll(now_ns()), Polled::Lost);
    let ms = start.elapsed().as_millis();
    let words = match (lost, stays) {
        (true, true) => format!("the loss is reported after {ms} ms, and stays"),
        (true, false) => format!("the loss is reported after {ms} ms, but then withdrawn"),
        (false, _) => format!("the loss is not reported within {ms} ms"),
    };
    report.judge("unplug", lost && stays, words);
}

/// Opens a device, and reports the time until it answered.
pub(super) fn open<D>(
    report: &mut Report,
    name: &'static str,
    open: impl FnOnce() -> Result<D, HardwareError>,
) -> Option<D> {
    let start = Instant::now();
    match open() {
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

#[cfg(test)]
mod tests {
    use super::super::CheckOutcome;
    use super::*;

    fn host(sleeps_ms: &[u64]) -> Host {
        Host::of_sleeps_ms(sleeps_ms)
    }

    #[test]
    fn a_punctual_computer_excuses_no_late_sample() {
        assert_eq!(host(&[1; 1000]).excuse(), None);
        // One delay in a watch of one second: 3 %.
        let mut looks = vec![1; 970];
        looks.push(30);
        assert_eq!(host(&looks).excuse(), None);
    }

    #[test]
    fn a_driver_that_blocks_its_caller_excuses_nothing() {
        let mut slow = Host::default();
        (0..10).for_each(|_| slow.add_step(Duration::from_millis(90), Duration::from_millis(1)));
        assert_eq!(slow.excuse(), None);
    }

    #[test]
    fn a_pause_of_the_computer_is_reported_with_its_length() {
        let excuse = host(&[1, 1, 90, 1, 1, 6]).excuse().unwrap();
        assert!(excuse.contains("96 of 100 ms"), "{excuse}");
    }

    #[test]
    fn lateness_is_tested_only_on_a_punctual_computer() {
        let mut report = Report::new("a device");
        let [idle, busy] = [host(&[1; 10]), host(&[9; 10])];
        report.judge_time("rate", false, "too slow".into(), idle);
        report.judge_time("rate", false, "too slow".into(), busy);
        report.judge_time("rate", true, "well".into(), busy);
        let outcomes: Vec<_> = report.checks.iter().map(|check| check.outcome).collect();
        assert_eq!(
            outcomes,
            [
                CheckOutcome::Fail,
                CheckOutcome::NotJudged,
                CheckOutcome::Pass
            ]
        );
        assert!(report.checks[1].detail.starts_with("too slow; not judged"));
    }
}
