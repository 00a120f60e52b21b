//! `calot devices watch --csv`: every sample of a haptic device as a line of a table.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use rt_core::fault::{Fault, FaultSet};
use rt_core::port::Reading;

use crate::problem::Problem;
use crate::say;

/// Names of the columns, with units, in the device's base frame.
const HEAD: &str = "time_s,x_m,y_m,z_m,qx,qy,qz,qw,reported_vx_m_s,reported_vy_m_s,\
    reported_vz_m_s,opening,buttons,sequence,device_time_us,faults";

/// A table under construction.
pub(super) struct Samples {
    path: PathBuf,
    to: BufWriter<File>,
    first_ns: Option<u64>,
    lines: u64,
    last: Option<u16>,
    /// Number of sequence numbers that are missing between the lines.
    missing: u64,
    failed: Option<std::io::Error>,
}

impl Samples {
    pub(super) fn make(path: &Path) -> Result<Self, Problem> {
        let made = || {
            let mut to = BufWriter::new(File::create(path)?);
            writeln!(to, "{HEAD}").map(|()| to)
        };
        Ok(Self {
            path: path.to_owned(),
            to: made().map_err(|error| format!("--csv {}: {error}", path.display()))?,
            first_ns: None,
            lines: 0,
            last: None,
            missing: 0,
            failed: None,
        })
    }

    /// Adds a sample. `found` are the faults of the poll that brought it.
    pub(super) fn add(&mut self, reading: &Reading, found: FaultSet) {
        let Reading {
            sample,
            reported_m_s,
            device_time_us,
            ..
        } = reading;
        if self.failed.is_some() {
            return;
        }
        if let Some(last) = self.last.replace(sample.sequence) {
            let step = sample.sequence.wrapping_sub(last);
            // A step back means that the device has restarted.
            if (1..0x8000).contains(&step) {
                self.missing += u64::from(step - 1);
            }
        }
        let first_ns = *self.first_ns.get_or_insert(sample.at_ns);
        let at_s = sample.at_ns.saturating_sub(first_ns) as f64 * 1e-9;
        let pose = &sample.device_from_handle;
        let numbers = |values: &[f32]| {
            let words: Vec<String> = values.iter().map(f32::to_string).collect();
            words.join(",")
        };
        // A velocity that is not measured becomes three empty fields.
        let said = reported_m_s.map_or(",,".to_owned(), |it| numbers(it.as_slice()));
        let opening = sample.opening.map_or(String::new(), |it| it.to_string());
        let clock = device_time_us.map_or(String::new(), |it| it.to_string());
        let faults = Fault::ALL.iter().filter(|it| found.contains(**it));
        let faults: Vec<&str> = faults.map(|it| it.name()).collect();
        let line = format!(
            "{at_s:.6},{},{},{said},{opening},{},{},{clock},{}",
            numbers(pose.translation.vector.as_slice()),
            numbers(pose.rotation.coords.as_slice()),
            sample.buttons.0,
            sample.sequence,
            faults.join(" ")
        );
        self.failed = writeln!(self.to, "{line}").err();
        self.lines += 1;
    }

    /// Writes the buffered lines. Fails with the first error of any write.
    pub(super) fn end(mut self) -> Result<(), Problem> {
        let written = match self.failed.take() {
            Some(error) => Err(error),
            None => self.to.flush(),
        };
        written.map_err(|error| format!("--csv {}: {error}", self.path.display()))?;
        say::note(format_args!(
            "wrote {}: {} samples{}",
            self.path.display(),
            self.lines,
            match self.missing {
                0 => String::new(),
                missing => format!(
                    ". {missing} sequence numbers are missing between them: lost on the line, refused as \
                     bad, or not read in time by this computer"
                ),
            }
        ));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rt_core::math::Pose;
    use rt_core::port::{Buttons, DeviceSample};

    use super::*;

    fn reading(sequence: u16) -> Reading {
        Reading {
            sample: DeviceSample {
                device_from_handle: Pose::identity(),
                velocity_m_s: None,
                buttons: Buttons(1),
                opening: None,
                sequence,
                at_ns: 5_000_000,
            },
            reported_m_s: None,
            device_time_us: Some(7000),
            status: Some(1),
        }
    }

    #[test]
    fn missing_numbers_are_counted_over_a_wrap_and_a_restart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("samples.csv");
        let mut table = Samples::make(&path).unwrap();
        for sequence in [65_533, 65_534, 1, 2, 5, 0, 1] {
            table.add(&reading(sequence), FaultSet::NONE);
        }
        assert_eq!((table.lines, table.missing), (7, 4));
        table.end().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let fields = |line: &str| line.split(',').count();
        assert!(text.lines().all(|it| fields(it) == fields(HEAD)), "{text}");
        assert!(text.contains(",1,65533,7000,"), "{text}");
    }
}
