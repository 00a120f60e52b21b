//! `calot replay --csv`: every tick of a session as a line of a table.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use rt_process::replay::Replayed;
use shared_mem::inputs::InputRecord;

/// Names of the columns, with units. Positions are in the scene's frame unless a name says
/// otherwise.
const HEAD: &str = "tick,time_s,device_x_m,device_y_m,device_z_m,device_vx_m_s,\
    device_vy_m_s,device_vz_m_s,device_qx,device_qy,device_qz,device_qw,tip_x_m,tip_y_m,tip_z_m,\
    force_x_n,force_y_n,force_z_n,torque_x_n_m,torque_y_n_m,torque_z_n_m,opening_n,handle_opening,\
    jaw,buttons,cut,coagulate,camera_lock,contacts,instrument";

/// A table under construction.
pub(super) struct Table {
    to: BufWriter<File>,
    /// First error; later lines are left out.
    pub(super) failed: Option<std::io::Error>,
    /// Newest sample of the device. A tick without a new sample repeats it.
    device: [f32; 10],
    /// Opening of the handle in that sample.
    opening: f32,
}

impl Table {
    pub(super) fn make(path: &Path) -> std::io::Result<Self> {
        let mut to = BufWriter::new(File::create(path)?);
        writeln!(to, "{HEAD}")?;
        Ok(Self {
            to,
            failed: None,
            device: [f32::NAN; 10],
            opening: f32::NAN,
        })
    }

    /// Adds a tick, `at_s` after the session's start.
    pub(super) fn add(&mut self, replayed: &Replayed<'_>, at_s: f64) {
        if self.failed.is_some() {
            return;
        }
        let (record, tool) = (replayed.record, replayed.view.tool);
        if record.bits & InputRecord::DEVICE_FRESH != 0 {
            let [x, y, z] = record.device_from_handle.position_m;
            let [qx, qy, qz, qw] = record.device_from_handle.orientation;
            let measured = record.bits & InputRecord::HAS_VELOCITY != 0;
            let [vx, vy, vz] = match measured {
                true => record.velocity_m_s,
                false => [f32::NAN; 3],
            };
            self.device = [x, y, z, vx, vy, vz, qx, qy, qz, qw];
            let opens = record.bits & InputRecord::HAS_OPENING != 0;
            self.opening = if opens { record.opening } else { f32::NAN };
        }
        let mut line = format!("{},{at_s:.6}", replayed.view.tick);
        let vectors = [tool.tip_m, tool.force_n, tool.torque_nm];
        let numbers = vectors.iter().flat_map(|it| it.iter());
        let opening = [&tool.opening_n, &self.opening];
        for number in self.device.iter().chain(numbers).chain(opening) {
            // An unknown value is an empty field.
            line += ",";
            if number.is_finite() {
                line += &number.to_string();
            }
        }
        let pedal = tool.switches.pedal;
        line += &format!(
            ",{},{},{},{},{},{},{:?}",
            tool.jaw,
            tool.buttons.0,
            u8::from(pedal.cut),
            u8::from(pedal.coagulate),
            u8::from(pedal.camera_lock),
            tool.contact_count,
            tool.instrument
        );
        self.failed = writeln!(self.to, "{line}").err();
    }

    /// Writes the buffered lines. Returns the first error of any write.
    pub(super) fn end(mut self) -> std::io::Result<()> {
        match self.failed.take() {
            Some(error) => Err(error),
            None => self.to.flush(),
        }
    }
}
