//! A station file opens the devices that it names.

use hardware::emulate::{HapticModel, LineFaults};
use hardware::station::StationFile;
use rt_core::math::Vec3;
use rt_core::port::{ForceCommand, Polled, Tracker};

use crate::support::{Emulator, PATIENCE, persist, poll_for};

#[test]
fn the_named_devices_open_and_keep_to_the_stations_limits() {
    for (model, driver) in [
        (HapticModel::TouchRig, "rig"),
        (HapticModel::Woody, "woody"),
        (HapticModel::Hapi, "hapi\"\ndevice = \"gen3"),
    ] {
        let emulator = Emulator::with_model(model, LineFaults::default());
        let lines = &emulator.lines;
        let text = format!(
            "[haptic]\ndriver = \"{driver}\"\npath = {:?}\nforce_max_n = 0.5\n\
             damping_n_s_m = 0.25\ndelay_s = 0.004\n\
             [tracker]\ndriver = \"bird\"\npath = {:?}\n\
             [pedal]\ndriver = \"rig\"\npath = {:?}\n",
            lines.haptic, lines.tracker, lines.pedal
        );
        let file = lines.haptic.with_file_name("station.toml");
        std::fs::write(&file, text).unwrap();
        let station = StationFile::read(&file).unwrap();
        let haptic = station.haptic.unwrap();
        let mut opened = Some(persist(|| haptic.open()));
        let mut tracker = station.tracker.unwrap().open().unwrap();
        let mut pedal = station.pedal.unwrap().open().unwrap();
        let capabilities = opened.as_ref().expect("open").capabilities();
        assert!((capabilities.force_max_n - 0.5).abs() < 1e-6);
        assert!(capabilities.force_continuous_n <= 0.5);
        let measured = [capabilities.damping_n_s_m, capabilities.delay_s];
        let off = (measured[0] - 0.25).abs() + (measured[1] - 0.004).abs();
        assert!(
            off < 1e-6,
            "the station file's figures replace the device's: {measured:?}"
        );

        // A force of 100 N would push the hand far away; 0.5 N move it 1 mm.
        let push = ForceCommand {
            opening_n: 0.0,
            force_n: Vec3::new(-100.0, 0.0, 0.0),
            torque_nm: Vec3::zeros(),
        };
        let (mut first, mut last, mut seen) = (None, 0.0, (false, false));
        let mut samples = 0;
        poll_for(PATIENCE, |now_ns| {
            let device = opened.as_mut().expect("open");
            device.send(push, now_ns);
            match device.poll(now_ns) {
                Polled::Fresh(sample) => {
                    last = sample.device_from_handle.translation.x;
                    first.get_or_insert(last);
                    samples += 1;
                }
                Polled::Nothing => {}
                // The driver may lose the device on a busy machine. Open it again.
                Polled::Lost => {
                    drop(opened.take());
                    opened = Some(persist(|| haptic.open()));
                }
            }
            seen.0 |= matches!(tracker.poll(now_ns), Polled::Fresh(_));
            seen.1 |= matches!(pedal.poll(now_ns), Polled::Fresh(_));
            samples < 200 || !seen.0 || !seen.1
        });
        assert!(first.unwrap() - last < 2e-3, "{driver}: {first:?} {last}");
        assert!(seen.0 && seen.1);
        assert!(pedal.counters().frames > 0);
    }
}
