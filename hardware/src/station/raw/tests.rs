//! Tests whole station files, and every mistake that one may contain.

use std::path::PathBuf;

use rt_core::math::Vec3;
use rt_core::scene::TrocarChoice;

use super::*;
use crate::bird::wire::Hemisphere;
use crate::pedal::Roles;
use crate::station::{HapticDriver, PedalDriver, StationFile};
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
trocar = "wet"

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
    assert_eq!(station.trocar, TrocarChoice::Wet);
    assert_eq!(station.instrument_port_m, Some(Vec3::new(0.0, 0.02, 0.18)));
    assert_eq!(station.endoscope_port_m, None);
    let names = station
        .landmarks
        .iter()
        .map(|landmark| landmark.name.as_str());
    assert!(names.eq(["left rim", "right rim"]));
}

#[test]
fn the_guide_has_a_station_file_for_each_driver_and_all_are_read() {
    let guide = include_str!("../../../README.md");
    let blocks = guide.split("```toml\n").skip(1);
    let files: Vec<_> = blocks
        .filter_map(|block| block.split("```").next())
        .filter(|text| text.contains("driver = "))
        .map(|text| read(text).unwrap_or_else(|error| panic!("{error}:\n{text}")))
        .collect();
    let drivers: Vec<_> = (files.iter())
        .filter_map(|it| it.haptic.as_ref())
        .map(|haptic| haptic.driver.clone())
        .collect();
    let has = |is_it: fn(&HapticDriver) -> bool| drivers.iter().any(is_it);
    assert!(has(|it| *it == HapticDriver::Rig), "{drivers:?}");
    assert!(has(|it| *it == HapticDriver::Woody), "{drivers:?}");
    assert!(has(|it| matches!(it, HapticDriver::Hapi(_))));
    assert!(has(|it| matches!(it, HapticDriver::Inverse3 { .. })));
    assert!(has(|it| matches!(it, HapticDriver::Touch { .. })));
    assert!(has(|it| matches!(it, HapticDriver::ForceDimension { .. })));
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
fn buttons_of_the_handle_may_replace_a_pedal() {
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
            ":3: handle_buttons.coagulate is 2, a button that has another",
        ),
    ] {
        let error = roles(&format!("[handle_buttons]\n{wrong}")).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_station_may_have_a_second_pedal() {
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
        ("\"evdev\"", "\"modem\"", ":19: only a USB pedal"),
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
            ":26: ports.instrument_m is 0, 20, 180, allowed is -5 to 5 m",
        ),
        (
            "[-0.1, 0.0, 0.0]",
            "[-100.0, 0.0, 0.0]",
            ":35: landmarks.position_m is -100, 0, 0",
        ),
        (
            "\"wet\"",
            "\"damp\"",
            ":27: unknown variant `damp`, expected one of `real`",
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
    fn arbitrary_text_is_harmless(text in ".{0,200}") {
        let _ = read(&text);
    }

    #[test]
    fn a_file_without_one_of_its_lines_is_read_or_refused_with_a_line_number(cut in 0usize..WHOLE.lines().count()) {
        let text: Vec<&str> =
            WHOLE.lines().enumerate().filter(|(at, _)| *at != cut).map(|(_, l)| l).collect();
        if let Err(error) = read(&text.join("\n")) {
            prop_assert!(error.starts_with("station.toml:"), "{error}");
        }
    }
}
