//! Effect of a serial adapter or the USB on the samples of the named haptic device, judged from the
//! inputs of every tick.

use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

use hardware::arrivals::Arrivals;
use hardware::station::StationFile;
use shared_mem::inputs::InputRecord;
use shared_mem::service::{Station, Tap};

use crate::args::DeviceArgs;
use crate::problem::Problem;

/// The line of a named haptic device.
pub(super) struct Line {
    tap: Tap,
    samples: Samples,
}

/// Samples as the ticks read them.
struct Samples {
    path: PathBuf,
    arrivals: Arrivals,
    last: Option<u16>,
}

impl Line {
    /// Watches the line of the named haptic device, if its path is a character device.
    pub(super) fn of(devices: &DeviceArgs, station: &Station) -> Result<Option<Self>, Problem> {
        let Some(path) = named(devices)? else {
            return Ok(None);
        };
        Ok(Some(Self {
            tap: Tap::open(station)?,
            samples: Samples::of(path),
        }))
    }

    /// Takes the inputs since the last look.
    pub(super) fn look(&mut self) {
        let samples = &mut self.samples;
        self.tap.drain_inputs(|batch| {
            for record in batch.records().unwrap_or_default() {
                samples.take(record);
            }
        });
    }

    /// Remark about the arrivals, for the report.
    pub(super) fn remark(&self) -> String {
        self.samples.remark()
    }
}

impl Samples {
    fn of(path: PathBuf) -> Self {
        Self {
            path,
            arrivals: Arrivals::default(),
            last: None,
        }
    }

    fn take(&mut self, record: &InputRecord) {
        if record.bits & InputRecord::DEVICE_FRESH == 0 {
            return;
        }
        // A tick takes the newest sample only. The sequence numbers tell how many came since the
        // last one.
        let last = self.last.replace(record.sequence);
        let came = last.map_or(1, |last| record.sequence.wrapping_sub(last));
        self.arrivals.take(u64::from(came), record.device_at_ns);
    }

    fn remark(&self) -> String {
        let path = self.path.display();
        match self.arrivals.found() {
            Some(pattern) => format!("{path}: {}", pattern.in_words(&self.path)),
            None => format!(
                "{path}: its samples show no adapter's timer, no batches and no frames of full-speed USB"
            ),
        }
    }
}

/// Path of the named haptic device, if it is a character device.
fn named(devices: &DeviceArgs) -> Result<Option<PathBuf>, Problem> {
    let file = devices.station_file.as_deref().map(StationFile::read);
    let in_file = file.transpose()?.and_then(|file| file.haptic);
    let path = devices.haptic.clone().or(in_file.map(|spec| spec.path));
    Ok(path.filter(|path| is_character_device(path)))
}

fn is_character_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|it| it.file_type().is_char_device())
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    /// Remark on samples that are taken and read every ms. A sample taken at t arrives at
    /// `comes(t)`, both in ns.
    fn remark(comes: impl Fn(u64) -> u64) -> String {
        let mut samples = Samples::of("/dev/ttyUSB3".into());
        let mut record = InputRecord::zeroed();
        let mut next = 0u64;
        for tick in 0..5000u64 {
            let now_ns = tick * 1_000_000 + 500_000;
            let came = (next..)
                .take_while(|n| comes(n * 1_000_000) <= now_ns)
                .last();
            record.bits = 0;
            if let Some(newest) = came {
                record.bits = InputRecord::DEVICE_FRESH;
                record.sequence = newest as u16;
                // Jitter of up to 82 µs, with the factor 5 below.
                let jitter_ns = newest.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 50;
                record.device_at_ns = comes(newest * 1_000_000) + 1000 + 5 * jitter_ns;
                next = newest + 1;
            }
            samples.take(&record);
        }
        samples.remark()
    }

    #[test]
    fn the_setting_that_ends_a_pattern_is_named_with_its_line() {
        let timer = remark(|at_ns| at_ns.div_ceil(16_000_000) * 16_000_000);
        assert!(
            timer.contains("/dev/ttyUSB3: samples wait up to 16 ms"),
            "{timer}"
        );
        assert!(timer.contains("ttyUSB3/latency_timer"), "{timer}");
        let batches = remark(|at_ns| at_ns.div_ceil(5_000_000) * 5_000_000);
        assert!(batches.contains("batches of 5.0"), "{batches}");
        let plain = remark(|at_ns| at_ns);
        assert!(plain.contains("show no adapter's timer"), "{plain}");
    }

    #[test]
    fn only_a_named_character_device_is_watched() {
        let haptic = |path: &str| DeviceArgs {
            haptic: Some(path.into()),
            ..DeviceArgs::default()
        };
        assert_eq!(named(&DeviceArgs::default()).unwrap(), None);
        assert_eq!(named(&haptic("/nowhere")).unwrap(), None);
        assert_eq!(
            named(&haptic("/dev/null")).unwrap(),
            Some("/dev/null".into())
        );
    }
}
