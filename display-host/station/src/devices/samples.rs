//! `calot devices watch --csv`: every sample of a haptic device as a line of a table.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use rt_core::fault::Fault;
use rt_core::math::Vec3;
use rt_core::port::{DeviceSample, Findings};

use crate::problem::Problem;
use crate::say;

/// Names of the columns, with units, in the device's base frame.
const HEAD: &str = "time_s,x_m,y_m,z_m,qx,qy,qz,qw,reported_vx_m_s,reported_vy_m_s,\
    reported_vz_m_s,opening,buttons,sequence,faults";

/// A table under construction.
pub(super) struct Samples {
    path: PathBuf,
    to: BufWriter<File>,
    first_ns: Option<u64>,
    lines: u64,
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
            failed: None,
        })
    }

    pub(super) fn add(&mut self, sample: &DeviceSample, said_m_s: Option<Vec3>, found: Findings) {
        if self.failed.is_some() {
            return;
        }
        let first_ns = *self.first_ns.get_or_insert(sample.at_ns);
        let at_s = sample.at_ns.saturating_sub(first_ns) as f64 * 1e-9;
        let pose = &sample.device_from_handle;
        let numbers = |values: &[f32]| {
            let words: Vec<String> = values.iter().map(f32::to_string).collect();
            words.join(",")
        };
        // A velocity that is not measured becomes three empty fields.
        let said = said_m_s.map_or(",,".to_owned(), |it| numbers(it.as_slice()));
        let opening = sample.opening.map_or(String::new(), |it| it.to_string());
        let faults = Fault::ALL.iter().filter(|it| found.faults.contains(**it));
        let faults: Vec<&str> = faults.map(|it| it.name()).collect();
        let line = format!(
            "{at_s:.6},{},{},{said},{opening},{},{},{}",
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
            "wrote {}: {} samples",
            self.path.display(),
            self.lines
        ));
        Ok(())
    }
}
