//! The station file as written, and its checks.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use serde::Deserialize;
use toml::Spanned;

use super::{
    HandleButtons, HapticDriver, HapticSpec, Landmark, Limits, PedalDriver, PedalSpec, StationFile,
    TrackerDriver, TrackerSpec,
};
use crate::HardwareError;
use crate::bird::BirdSetup;
use crate::bird::wire::{Hemisphere, Scale};
use crate::hapi::pantograph::Pantograph;
use crate::pedal::Roles;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    haptic: Option<RawHaptic>,
    tracker: Option<RawTracker>,
    pedal: Option<RawPedal>,
    second_pedal: Option<Spanned<RawPedal>>,
    handle_buttons: Option<RawHandleButtons>,
    ports: Option<RawPorts>,
    frames: Option<RawFrames>,
    #[serde(default)]
    landmarks: Vec<RawLandmark>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHandleButtons {
    cut: Option<Spanned<u8>>,
    coagulate: Option<Spanned<u8>>,
    camera_lock: Option<Spanned<u8>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPorts {
    instrument_m: Option<Spanned<[f32; 3]>>,
    endoscope_m: Option<Spanned<[f32; 3]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLandmark {
    name: String,
    position_m: Spanned<[f32; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHaptic {
    driver: Spanned<RawHapticDriver>,
    path: Option<PathBuf>,
    device: Option<Spanned<String>>,
    force_max_n: Option<Spanned<f32>>,
    force_continuous_n: Option<Spanned<f32>>,
    stiffness_max_n_m: Option<Spanned<f32>>,
    damping_n_s_m: Option<Spanned<f32>>,
    delay_s: Option<Spanned<f32>>,
    motion_scale: Option<Spanned<f32>>,
    felt: Option<RawFelt>,
}

/// Result of `calot devices feel`. People read the other fields.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFelt {
    passed: bool,
    #[serde(rename = "on")]
    _on: Option<String>,
    #[serde(rename = "device")]
    _device: Option<String>,
    #[serde(rename = "failed")]
    _failed: Option<Vec<String>>,
}

#[derive(Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum RawHapticDriver {
    Rig,
    Woody,
    Hapi,
    Inverse3,
    Touch,
    #[serde(rename = "force-dimension")]
    ForceDimension,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTracker {
    driver: RawTrackerDriver,
    path: PathBuf,
    hemisphere: Option<RawHemisphere>,
    full_scale_in: Option<Spanned<u8>>,
    birds: Option<Spanned<u8>>,
    bird: Option<Spanned<u8>>,
    filter_rest_hz: Option<Spanned<f32>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawTrackerDriver {
    Bird,
    Trakstar,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawHemisphere {
    Forward,
    Aft,
    Right,
    Left,
    Lower,
    Upper,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPedal {
    driver: RawPedalDriver,
    path: PathBuf,
    cut_key: Option<Spanned<u16>>,
    coagulate_key: Option<Spanned<u16>>,
    camera_lock_key: Option<Spanned<u16>>,
}

#[derive(Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum RawPedalDriver {
    Rig,
    Evdev,
    Modem,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFrames {
    world_from_device: Option<RawPose>,
    world_from_tracker: Option<RawPose>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPose {
    position_m: Spanned<[f32; 3]>,
    rotation_xyzw: Spanned<[f32; 4]>,
}

/// Farthest position of a station, m.
const ROOM_M: f32 = 5.0;
/// The kernel's highest key code.
const KEY_MAX: u16 = 0x2FF;

/// Text and path of the file, for errors.
struct File<'a> {
    text: &'a str,
    path: &'a Path,
}

impl File<'_> {
    fn error(&self, at: usize, what: String) -> HardwareError {
        let before = self.text.get(..at).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        HardwareError::Station {
            path: self.path.to_path_buf(),
            line,
            what,
        }
    }

    fn within(
        &self,
        name: &str,
        unit: &str,
        value: Option<Spanned<f32>>,
        allowed: RangeInclusive<f32>,
    ) -> Result<Option<f32>, HardwareError> {
        let Some(value) = value else { return Ok(None) };
        let number = *value.get_ref();
        if allowed.contains(&number) {
            return Ok(Some(number));
        }
        let (low, high) = (allowed.start(), allowed.end());
        let what = format!("{name} is {number} {unit}, allowed is {low} to {high} {unit}");
        Err(self.error(value.span().start, what))
    }

    /// Checks a position in the room.
    fn place(&self, name: &str, raw: &Spanned<[f32; 3]>) -> Result<Vec3, HardwareError> {
        let position = Vec3::from(*raw.get_ref());
        if position
            .iter()
            .all(|part| (-ROOM_M..=ROOM_M).contains(part))
        {
            return Ok(position);
        }
        let what = format!("{name} lies outside ±{ROOM_M} m; is it in metres?");
        Err(self.error(raw.span().start, what))
    }

    fn landmarks(&self, raw: Vec<RawLandmark>) -> Result<Vec<Landmark>, HardwareError> {
        let landmark = |raw: RawLandmark| {
            let position_m = self.place("landmarks.position_m", &raw.position_m)?;
            let name = raw.name;
            Ok(Landmark { name, position_m })
        };
        raw.into_iter().map(landmark).collect()
    }

    fn pose(&self, name: &str, raw: Option<RawPose>) -> Result<Option<Pose>, HardwareError> {
        let Some(raw) = raw else { return Ok(None) };
        let position = self.place(&format!("{name}.position_m"), &raw.position_m)?;
        let [x, y, z, w] = *raw.rotation_xyzw.get_ref();
        let quaternion = Quaternion::new(w, x, y, z);
        let norm = quaternion.norm();
        if !(0.99..=1.01).contains(&norm) {
            let what = format!("{name}.rotation_xyzw has length {norm}, a rotation has length 1");
            return Err(self.error(raw.rotation_xyzw.span().start, what));
        }
        let rotation = UnitQuaternion::new_normalize(quaternion);
        Ok(Some(Pose::from_parts(position.into(), rotation)))
    }

    fn haptic(&self, raw: RawHaptic) -> Result<HapticSpec, HardwareError> {
        let named = matches!(
            *raw.driver.get_ref(),
            RawHapticDriver::Touch
                | RawHapticDriver::Hapi
                | RawHapticDriver::Inverse3
                | RawHapticDriver::ForceDimension
        );
        if let Some(device) = raw.device.as_ref().filter(|_| !named) {
            let what = "device names a Touch in the vendor's set-up, a Haply's generation, an Inverse3's \
                        number or a Force Dimension device's serial number: only drivers \"touch\", \
                        \"hapi\", \"inverse3\" and \"force-dimension\" have one";
            return Err(self.error(device.span().start, what.into()));
        }
        let force_at = raw
            .force_continuous_n
            .as_ref()
            .map_or(0, |force| force.span().start);
        let limits = Limits {
            force_max_n: self.within("force_max_n", "N", raw.force_max_n, 0.1..=40.0)?,
            force_continuous_n: self.within(
                "force_continuous_n",
                "N",
                raw.force_continuous_n,
                0.1..=40.0,
            )?,
            stiffness_max_n_m: self.within(
                "stiffness_max_n_m",
                "N/m",
                raw.stiffness_max_n_m,
                10.0..=20_000.0,
            )?,
            damping_n_s_m: self.within("damping_n_s_m", "N s/m", raw.damping_n_s_m, 0.0..=50.0)?,
            delay_s: self.within("delay_s", "s", raw.delay_s, 0.0..=0.05)?,
        };
        if let (Some(peak), Some(continuous)) = (limits.force_max_n, limits.force_continuous_n)
            && continuous > peak
        {
            let what = format!(
                "force_continuous_n is {continuous} N, allowed is at most force_max_n, {peak} N"
            );
            return Err(self.error(force_at, what));
        }
        Ok(HapticSpec {
            driver: self.haptic_driver(&raw.driver, raw.device)?,
            path: self.haptic_path(&raw.driver, raw.path)?,
            limits,
            motion_scale: self.within("motion_scale", "", raw.motion_scale, 0.5..=2.0)?,
            is_felt: raw.felt.is_some_and(|felt| felt.passed),
        })
    }

    fn haptic_path(
        &self,
        driver: &Spanned<RawHapticDriver>,
        path: Option<PathBuf>,
    ) -> Result<PathBuf, HardwareError> {
        match (path, driver.get_ref()) {
            (Some(path), _) => Ok(path),
            // An installed library has a name that the loader finds.
            (None, RawHapticDriver::ForceDimension) => Ok(PathBuf::from(crate::dhd::LIBRARY)),
            (None, _) => {
                let what =
                    "the haptic device has no path: name its line, its library or its service";
                Err(self.error(driver.span().start, what.into()))
            }
        }
    }

    fn haptic_driver(
        &self,
        driver: &Spanned<RawHapticDriver>,
        device: Option<Spanned<String>>,
    ) -> Result<HapticDriver, HardwareError> {
        Ok(match *driver.get_ref() {
            RawHapticDriver::Rig => HapticDriver::Rig,
            RawHapticDriver::Woody => HapticDriver::Woody,
            RawHapticDriver::Hapi => HapticDriver::Hapi(self.generation(driver, device.as_ref())?),
            RawHapticDriver::Inverse3 => HapticDriver::Inverse3 {
                device: device.map(Spanned::into_inner),
            },
            RawHapticDriver::Touch => HapticDriver::Touch {
                device: device.map(Spanned::into_inner),
            },
            RawHapticDriver::ForceDimension => HapticDriver::ForceDimension {
                serial: self.serial(device.as_ref())?,
            },
        })
    }

    fn serial(&self, device: Option<&Spanned<String>>) -> Result<Option<u16>, HardwareError> {
        let Some(device) = device else {
            return Ok(None);
        };
        device.get_ref().parse().map(Some).map_err(|_| {
            let what = format!(
                "device is \"{}\", allowed is a serial number, \"0\" to \"{}\", or no device: the first",
                device.get_ref(),
                u16::MAX
            );
            self.error(device.span().start, what)
        })
    }

    /// There is no default, because a wrong generation turns the motors the wrong way.
    fn generation(
        &self,
        driver: &Spanned<RawHapticDriver>,
        device: Option<&Spanned<String>>,
    ) -> Result<Pantograph, HardwareError> {
        let at = device.map_or(driver.span().start, |device| device.span().start);
        device
            .and_then(|device| Pantograph::named(device.get_ref()))
            .ok_or_else(|| {
                let what = "driver \"hapi\" needs device = \"gen2\", \"gen3\" or \"gen3.1\": \
                            the Haply's generation";
                self.error(at, what.into())
            })
    }

    fn tracker(&self, raw: RawTracker) -> Result<TrackerSpec, HardwareError> {
        let scale = match raw.full_scale_in.as_ref().map(|scale| *scale.get_ref()) {
            None | Some(36) => Scale::Inches36,
            Some(72) => Scale::Inches72,
            Some(other) => {
                let at = raw.full_scale_in.map_or(0, |scale| scale.span().start);
                let what = format!("full_scale_in is {other}, allowed is 36 or 72");
                return Err(self.error(at, what));
            }
        };
        let number = |name: &str, value: &Option<Spanned<u8>>, most: u8| match value {
            None => Ok(1),
            Some(value) if (1..=most).contains(value.get_ref()) => Ok(*value.get_ref()),
            Some(value) => {
                let what = format!("{name} is {}, allowed is 1 to {most}", value.get_ref());
                Err(self.error(value.span().start, what))
            }
        };
        let birds = number("birds", &raw.birds, 14)?;
        Ok(TrackerSpec {
            driver: match raw.driver {
                RawTrackerDriver::Bird => TrackerDriver::Bird,
                RawTrackerDriver::Trakstar => TrackerDriver::Trakstar,
            },
            path: raw.path,
            setup: BirdSetup {
                hemisphere: match raw.hemisphere {
                    Some(RawHemisphere::Forward) => Hemisphere::Forward,
                    Some(RawHemisphere::Aft) => Hemisphere::Aft,
                    Some(RawHemisphere::Right) => Hemisphere::Right,
                    Some(RawHemisphere::Left) => Hemisphere::Left,
                    Some(RawHemisphere::Lower) => Hemisphere::Lower,
                    Some(RawHemisphere::Upper) | None => Hemisphere::Upper,
                },
                scale,
                birds,
                bird: number("bird", &raw.bird, birds)?,
                filter_rest_hz: self
                    .within("filter_rest_hz", "Hz", raw.filter_rest_hz, 0.0..=50.0)?
                    .unwrap_or(BirdSetup::default().filter_rest_hz),
            },
        })
    }

    fn handle_buttons(
        &self,
        raw: Option<RawHandleButtons>,
    ) -> Result<HandleButtons, HardwareError> {
        let Some(raw) = raw else {
            return Ok(HandleButtons::default());
        };
        let mut taken = 0u8;
        let mut number = |name: &str, raw: Option<Spanned<u8>>| {
            let Some(raw) = raw else { return Ok(None) };
            let number = *raw.get_ref();
            let what = if !(1..=8).contains(&number) {
                format!("handle_buttons.{name} is {number}, allowed is 1 to 8")
            } else if taken & (1 << (number - 1)) != 0 {
                format!("handle_buttons.{name} is {number}, which has another role already")
            } else {
                taken |= 1 << (number - 1);
                return Ok(Some(number));
            };
            Err(self.error(raw.span().start, what))
        };
        Ok(HandleButtons {
            cut: number("cut", raw.cut)?,
            coagulate: number("coagulate", raw.coagulate)?,
            camera_lock: number("camera_lock", raw.camera_lock)?,
        })
    }

    fn pedals(
        &self,
        first: Option<RawPedal>,
        second: Option<Spanned<RawPedal>>,
    ) -> Result<Option<PedalSpec>, HardwareError> {
        let Some(first) = first else {
            return match second {
                Some(second) => {
                    let what = "there is a [second_pedal] but no [pedal]: name it [pedal]";
                    Err(self.error(second.span().start, what.into()))
                }
                None => Ok(None),
            };
        };
        let mut spec = self.pedal(first)?;
        if let Some(second) = second {
            let at = second.span().start;
            let second = self.pedal(second.into_inner())?;
            if second.path == spec.path {
                let what = "[second_pedal] has the path of [pedal]: one device is one pedal";
                return Err(self.error(at, what.into()));
            }
            spec.second = Some(Box::new(second));
        }
        Ok(Some(spec))
    }

    fn pedal(&self, raw: RawPedal) -> Result<PedalSpec, HardwareError> {
        let keys = [&raw.cut_key, &raw.coagulate_key, &raw.camera_lock_key];
        for key in keys.into_iter().flatten() {
            let what = if raw.driver != RawPedalDriver::Evdev {
                "keys are a USB pedal's: only driver \"evdev\" has them".to_owned()
            } else if *key.get_ref() > KEY_MAX {
                format!("the key is {}, allowed is 0 to {KEY_MAX}", key.get_ref())
            } else {
                continue;
            };
            return Err(self.error(key.span().start, what));
        }
        let driver = match raw.driver {
            RawPedalDriver::Rig => PedalDriver::Rig,
            RawPedalDriver::Modem => PedalDriver::Modem,
            RawPedalDriver::Evdev if keys.iter().all(|key| key.is_none()) => {
                PedalDriver::Evdev(Roles::default())
            }
            RawPedalDriver::Evdev => PedalDriver::Evdev(Roles {
                cut: raw.cut_key.map(Spanned::into_inner),
                coagulate: raw.coagulate_key.map(Spanned::into_inner),
                camera_lock: raw.camera_lock_key.map(Spanned::into_inner),
            }),
        };
        Ok(PedalSpec {
            driver,
            path: raw.path,
            second: None,
        })
    }
}

pub(super) fn parse(text: &str, path: &Path) -> Result<StationFile, HardwareError> {
    let file = File { text, path };
    let raw: Raw = toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        file.error(at, error.message().to_owned())
    })?;
    let (device, tracker) = raw.frames.map_or((None, None), |frames| {
        (frames.world_from_device, frames.world_from_tracker)
    });
    let (instrument, endoscope) = raw.ports.map_or((None, None), |ports| {
        (ports.instrument_m, ports.endoscope_m)
    });
    let port = |name, raw: Option<Spanned<[f32; 3]>>| {
        raw.map(|place| file.place(name, &place)).transpose()
    };
    Ok(StationFile {
        haptic: raw.haptic.map(|haptic| file.haptic(haptic)).transpose()?,
        tracker: raw
            .tracker
            .map(|tracker| file.tracker(tracker))
            .transpose()?,
        pedal: file.pedals(raw.pedal, raw.second_pedal)?,
        handle_buttons: file.handle_buttons(raw.handle_buttons)?,
        world_from_device: file.pose("world_from_device", device)?,
        world_from_tracker: file.pose("world_from_tracker", tracker)?,
        instrument_port_m: port("ports.instrument_m", instrument)?,
        endoscope_port_m: port("ports.endoscope_m", endoscope)?,
        landmarks: file.landmarks(raw.landmarks)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHOLE: &str = r#"
[haptic]
driver = "touch"
path = "libHD.so"
device = "right"
force_max_n = 2.5
force_continuous_n = 0.8
motion_scale = 1.5

[tracker]
driver = "bird"
path = "/dev/serial/by-id/tracker"
hemisphere = "forward"
filter_rest_hz = 2.0

[pedal]
driver = "evdev"
path = "/dev/input/by-id/pedal"
cut_key = 30

[frames.world_from_device]
position_m = [0.1, 0.0, 0.2]
rotation_xyzw = [0.0, 0.0, 0.0, 1.0]

[ports]
instrument_m = [0.0, 0.02, 0.18]

[[landmarks]]
name = "left rim"
position_m = [0.1, 0.0, 0.0]

[[landmarks]]
name = "right rim"
position_m = [-0.1, 0.0, 0.0]
"#;

    fn read(text: &str) -> Result<StationFile, String> {
        parse(text, "station.toml".as_ref()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_whole_file_is_read() {
        let station = read(WHOLE).unwrap();
        let haptic = station.haptic.unwrap();
        assert_eq!(
            haptic.driver,
            HapticDriver::Touch {
                device: Some("right".into())
            }
        );
        assert_eq!(haptic.limits.force_max_n, Some(2.5));
        assert_eq!(
            station.tracker.unwrap().setup.hemisphere,
            Hemisphere::Forward
        );
        let roles = Roles {
            cut: Some(30),
            coagulate: None,
            camera_lock: None,
        };
        assert_eq!(station.pedal.unwrap().driver, PedalDriver::Evdev(roles));
        let frame = station.world_from_device.unwrap();
        assert!((frame.translation.vector - Vec3::new(0.1, 0.0, 0.2)).norm() < 1e-7);
        assert_eq!(station.world_from_tracker, None);
        assert_eq!(haptic.motion_scale, Some(1.5));
        assert_eq!(station.instrument_port_m, Some(Vec3::new(0.0, 0.02, 0.18)));
        assert_eq!(station.endoscope_port_m, None);
        let names = station
            .landmarks
            .iter()
            .map(|landmark| landmark.name.as_str());
        assert!(names.eq(["left rim", "right rim"]));
    }

    #[test]
    fn a_force_dimension_device_needs_neither_path_nor_number() {
        let read = |lines: &str| {
            let text = format!("[haptic]\ndriver = \"force-dimension\"\n{lines}");
            read(&text).map(|station| station.haptic.unwrap())
        };
        let plain = read("").unwrap();
        assert_eq!(plain.path, PathBuf::from("libdhd.so.3"));
        assert_eq!(plain.driver, HapticDriver::ForceDimension { serial: None });
        let named = read("path = \"/opt/libdhd.so\"\ndevice = \"10432\"\n").unwrap();
        assert_eq!(named.path, PathBuf::from("/opt/libdhd.so"));
        let serial = Some(10432);
        assert_eq!(named.driver, HapticDriver::ForceDimension { serial });
        let error = read("device = \"omega\"\n").unwrap_err();
        assert!(
            error.contains(":3: device is \"omega\", allowed is a serial number"),
            "{error}"
        );
    }

    #[test]
    fn buttons_of_the_handle_may_be_a_pedal_s() {
        let roles = |text: &str| read(text).map(|station| station.handle_buttons.bits());
        assert_eq!(roles(""), Ok([0; 3]));
        assert_eq!(
            roles("[handle_buttons]\ncoagulate = 2\ncut = 8\n"),
            Ok([128, 2, 0])
        );
        for (wrong, expected) in [
            (
                "cut = 0\n",
                ":2: handle_buttons.cut is 0, allowed is 1 to 8",
            ),
            ("cut = 9\n", ":2: handle_buttons.cut is 9"),
            (
                "cut = 2\ncoagulate = 2\n",
                ":3: handle_buttons.coagulate is 2, which has another",
            ),
        ] {
            let error = roles(&format!("[handle_buttons]\n{wrong}")).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_second_pedal_stands_beside_a_first_one() {
        let second = "[second_pedal]\ndriver = \"modem\"\npath = \"/dev/ttyS0\"\n";
        let station = read(&format!("{WHOLE}\n{second}")).unwrap();
        let pedal = station.pedal.unwrap().second.unwrap();
        assert_eq!(pedal.driver, PedalDriver::Modem);
        let alone = read(second).unwrap_err();
        assert!(alone.contains("no [pedal]"), "{alone}");
        let twice = second.replace("/dev/ttyS0", "/dev/input/by-id/pedal");
        let twice = read(&format!("{WHOLE}\n{twice}")).unwrap_err();
        assert!(twice.contains("one device is one pedal"), "{twice}");
    }

    #[test]
    fn an_empty_file_is_a_station_without_devices() {
        assert_eq!(read("").unwrap(), StationFile::default());
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        for (right, wrong, expected) in [
            (
                "force_max_n = 2.5",
                "force_max_n = 250",
                ":6: force_max_n is 250 N",
            ),
            (
                "force_max_n = 2.5",
                "force_max_n = nan",
                ":6: force_max_n is NaN N",
            ),
            (
                "force_max_n = 2.5",
                "delay_s = 2.0",
                ":6: delay_s is 2 s, allowed is 0 to 0.05 s",
            ),
            (
                "force_max_n = 2.5",
                "damping_n_s_m = -0.1",
                ":6: damping_n_s_m is -0.1 N s/m",
            ),
            (
                "force_max_n = 2.5",
                "force_max = 2.5",
                ":6: unknown field `force_max`",
            ),
            (
                "force_max_n = 2.5",
                "force_max_n = \"2.5\"",
                ":6: invalid type: string",
            ),
            (
                "force_continuous_n = 0.8",
                "force_continuous_n = 3.0",
                ":7: force_continuous_n is 3",
            ),
            ("\"touch\"", "\"rig\"", ":5: device names a Touch"),
            (
                "path = \"libHD.so\"",
                "# no path",
                ":3: the haptic device has no path",
            ),
            ("\"touch\"", "\"omni\"", ":3: unknown variant `omni`"),
            (
                "hemisphere = \"forward\"",
                "full_scale_in = 100",
                ":13: full_scale_in is 100",
            ),
            (
                "hemisphere = \"forward\"",
                "bird = 2",
                ":13: bird is 2, allowed is 1 to 1",
            ),
            ("\"touch\"", "\"hapi\"", ":5: driver \"hapi\" needs device"),
            ("\"evdev\"", "\"modem\"", ":19: keys are a USB pedal's"),
            ("cut_key = 30", "cut_key = 3000", ":19: the key is 3000"),
            (
                "[0.1, 0.0, 0.2]",
                "[100.0, 0.0, 200.0]",
                ":22: world_from_device.position_m",
            ),
            (
                "0.0, 1.0]",
                "0.0, 0.5]",
                ":23: world_from_device.rotation_xyzw has length 0.5",
            ),
            ("[tracker]", "[trakcer]", ":10: unknown field `trakcer`"),
            (
                "motion_scale = 1.5",
                "motion_scale = 0.0",
                ":8: motion_scale is 0",
            ),
            (
                "filter_rest_hz = 2.0",
                "filter_rest_hz = -1.0",
                ":14: filter_rest_hz is -1 Hz",
            ),
            (
                "[0.0, 0.02, 0.18]",
                "[0.0, 20.0, 180.0]",
                ":26: ports.instrument_m lies outside",
            ),
            (
                "[-0.1, 0.0, 0.0]",
                "[-100.0, 0.0, 0.0]",
                ":34: landmarks.position_m lies outside",
            ),
            ("[pedal]", "[pedal", ":16: "),
        ] {
            let text = WHOLE.replace(right, wrong);
            assert_ne!(text, WHOLE, "{right}");
            let error = read(&text).unwrap_err();
            assert!(error.contains(expected), "{wrong}: {error}");
        }
    }

    proptest! {
        #[test]
        fn arbitrary_text_is_no_crash(text in ".{0,200}") {
            let _ = read(&text);
        }

        #[test]
        fn a_file_with_a_line_cut_out_is_read_or_refused_with_a_line(cut in 0usize..WHOLE.lines().count()) {
            let text: Vec<&str> =
                WHOLE.lines().enumerate().filter(|(at, _)| *at != cut).map(|(_, l)| l).collect();
            if let Err(error) = read(&text.join("\n")) {
                prop_assert!(error.starts_with("station.toml:"), "{error}");
            }
        }
    }
}
