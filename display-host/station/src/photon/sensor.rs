//! The light sensor of a measurement, opened from its options.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use hardware::light::{BoardLight, Edge, PinLight, Sensor};
use jitter::photon::Change;
use shared_mem::inputs::InputRecord;

use super::args::SensorArgs;
use crate::problem::Problem;

/// A light sensor.
pub(super) struct Eye {
    pub(super) kind: &'static str,
    pub(super) name: String,
    from: From,
    /// Half of the time span within which each edge lies, ns.
    within_ns: Vec<u64>,
}

enum From {
    /// A sensor at a pin, a sound card or a board.
    Sensor(Sensor),
    /// A button of the haptic device, as the ticks read it: its mask, and its last state with the
    /// time of the sample, ns.
    Button(u8, Option<(bool, u64)>),
}

impl Eye {
    pub(super) fn open(args: &SensorArgs) -> Result<Self, Problem> {
        let (kind, name, from) = if let Some(it) = &args.pin {
            let sensor = Sensor::watch(PinLight::open(&it.tty, it.pin)?)?;
            let name = format!("{} of {}", it.pin.name(), it.tty.display());
            ("pin", name, From::Sensor(sensor))
        } else if let Some(path) = &args.audio {
            let (source, name) = sound(path)?;
            let sensor = Sensor::listen(source, args.rate)?;
            (
                "sound",
                format!("{name} at {} Hz", args.rate),
                From::Sensor(sensor),
            )
        } else if let Some(path) = &args.board {
            let sensor = Sensor::watch(BoardLight::open(path)?)?;
            ("board", path.display().to_string(), From::Sensor(sensor))
        } else {
            let button = args.button.unwrap_or(2);
            let name = format!("button {button} of the haptic device");
            ("button", name, From::Button(1 << button, None))
        };
        Ok(Self {
            kind,
            name,
            from,
            within_ns: Vec::new(),
        })
    }

    /// Takes the inputs of a tick. They count if a button of the haptic device is the sensor.
    pub(super) fn take_tick(&mut self, record: &InputRecord, into: &mut Vec<Change>) {
        let From::Button(mask, last) = &mut self.from else {
            return;
        };
        if record.bits & InputRecord::DEVICE_FRESH == 0 {
            return;
        }
        let (bright, at_ns) = (record.buttons & *mask != 0, record.device_at_ns);
        if let Some((was, before_ns)) = last.replace((bright, at_ns))
            && was != bright
        {
            let half_ns = at_ns.saturating_sub(before_ns) / 2;
            self.within_ns.push(half_ns);
            into.push(Change {
                at_ns: at_ns - half_ns,
                bright,
            });
        }
    }

    /// Takes the edges of a sensor at a pin, a sound card or a board. Fails once the sensor is
    /// lost.
    pub(super) fn take_edges(&mut self, into: &mut Vec<Change>) -> Result<(), Problem> {
        let From::Sensor(sensor) = &self.from else {
            return Ok(());
        };
        let mut edges: Vec<Edge> = Vec::new();
        let is_there = sensor.take(&mut edges);
        for edge in edges {
            self.within_ns.push(edge.within_ns);
            into.push(Change {
                at_ns: edge.at_ns,
                bright: edge.bright,
            });
        }
        match is_there {
            true => Ok(()),
            false => Err(format!("the light sensor is gone: {}", self.name).into()),
        }
    }

    /// Median over all edges of half the time span within which an edge lies, ms.
    pub(super) fn within_ms(&self) -> Option<f64> {
        let mut all = self.within_ns.clone();
        all.sort_unstable();
        all.get(all.len() / 2).map(|&ns| ns as f64 / 1e6)
    }
}

/// Opens a stream of sound.
fn sound(path: &Path) -> Result<(Box<dyn Read + Send>, String), Problem> {
    if path == Path::new("-") {
        return Ok((Box::new(std::io::stdin()), "standard input".to_owned()));
    }
    let file = File::open(path).map_err(|error| format!("--audio {}: {error}", path.display()))?;
    if file.metadata()?.is_file() {
        return Err(format!(
            "--audio {}: a file has no times; name a pipe into which a sound card records now",
            path.display()
        )
        .into());
    }
    Ok((Box::new(file), path.display().to_string()))
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    fn args(words: &[&str]) -> SensorArgs {
        #[derive(clap::Parser)]
        struct Alone {
            #[command(flatten)]
            sensor: SensorArgs,
        }
        let words = ["photon"].iter().chain(words);
        <Alone as clap::Parser>::parse_from(words).sensor
    }

    #[test]
    fn a_spare_button_of_the_device_is_a_sensor_at_the_times_of_its_samples() {
        let mut eye = Eye::open(&args(&["--button", "3"])).unwrap();
        let mut changes = Vec::new();
        let mut record = InputRecord::zeroed();
        for (at_ns, buttons, fresh) in [
            (1000, 0b0001, true),
            (2000, 0b1000, false),
            (3000, 0b1010, true),
            (4000, 0b1000, true),
            (5000, 0b0010, true),
        ] {
            record.device_at_ns = at_ns;
            record.buttons = buttons;
            record.bits = if fresh { InputRecord::DEVICE_FRESH } else { 0 };
            eye.take_tick(&record, &mut changes);
        }
        let told: Vec<(u64, bool)> = changes.iter().map(|it| (it.at_ns, it.bright)).collect();
        assert_eq!(told, [(2000, true), (4500, false)]);
        assert_eq!(eye.within_ms(), Some(1e-3));
        assert!(eye.take_edges(&mut changes).is_ok());
    }

    #[test]
    fn a_recording_and_a_missing_pipe_are_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let path = file.path().to_str().unwrap();
        let refused = |path: &str| {
            let opened = Eye::open(&args(&["--audio", path]));
            opened.err().map(|it| it.to_string()).unwrap_or_default()
        };
        assert!(refused(path).contains("a file has no times"));
        assert!(refused("/nowhere/pipe").contains("--audio /nowhere/pipe"));
    }
}
