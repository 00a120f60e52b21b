//! `calot devices calibrate`: where haptic device and tracker stand, by touching landmarks.

use std::collections::VecDeque;
use std::io::BufRead as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use hardware::station::calibration::{Fit, fit};
use hardware::station::{HapticSpec, Landmark, StationFile};
use rt_core::math::{Pose, Vec3};
use rt_core::port::{Buttons, ForceCommand, HapticDevice, Polled, Tracker};
use rt_process::time_driver::now_ns;
use serde_json::json;

use crate::cli::CalibrateArgs;
use crate::say;
use crate::scene::Problem;
use crate::stop;

/// A place is measured over this time…
const MEASURED_FOR: Duration = Duration::from_millis(300);
/// …in which the device may move by so much, m.
const STILL_M: f32 = 1.5e-3;

/// One device that is to be placed.
struct Placed {
    /// As people call it, and as the station file calls its frame.
    name: &'static str,
    frame: &'static str,
    port: Port,
}

enum Port {
    Haptic(Box<dyn HapticDevice + Send>),
    Tracker(Box<dyn Tracker>),
}

impl Port {
    /// Where it is now in its own frame, m, and whether a button is down.
    fn poll(&mut self) -> Option<(Vec3, bool)> {
        let now_ns = now_ns();
        match self {
            Self::Haptic(device) => {
                // Without a command some devices stop reporting, and none shall push.
                device.send(ForceCommand::default(), now_ns);
                match device.poll(now_ns) {
                    Polled::Fresh(sample) => {
                        let pressed = sample.buttons.contains(Buttons::GRASP);
                        Some((sample.device_from_handle.translation.vector, pressed))
                    }
                    Polled::Nothing | Polled::Lost => None,
                }
            }
            Self::Tracker(tracker) => match tracker.poll(now_ns) {
                Polled::Fresh(sample) => {
                    Some((sample.tracker_from_sensor.translation.vector, false))
                }
                Polled::Nothing | Polled::Lost => None,
            },
        }
    }
}

pub(super) fn run(args: &CalibrateArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    let text = std::fs::read_to_string(&args.station_file)
        .map_err(|error| format!("{}: {error}", args.station_file.display()))?;
    let file = StationFile::parse(&text, &args.station_file)?;
    // Landmarks that could not tell are refused before anybody touches them.
    let known: Vec<_> = file
        .landmarks
        .iter()
        .map(|landmark| landmark.position_m)
        .collect();
    fit(&known.iter().map(|at| (*at, *at)).collect::<Vec<_>>())?;
    let mut devices = Vec::new();
    if let Some(spec) = &file.haptic {
        devices.push(Placed {
            name: "handle of the haptic device",
            frame: "world_from_device",
            // Landmarks are where they are: what it really moves counts.
            port: Port::Haptic(
                HapticSpec {
                    motion_scale: None,
                    ..spec.clone()
                }
                .open()?,
            ),
        });
    }
    if let Some(spec) = &file.tracker {
        devices.push(Placed {
            name: "tracker's sensor",
            frame: "world_from_tracker",
            port: Port::Tracker(Box::new(spec.open()?)),
        });
    }
    if devices.is_empty() {
        return Err("the station file names neither a haptic device nor a tracker".into());
    }
    let keys = enter_keys();
    let mut found = Vec::new();
    for device in &mut devices {
        let Some(pairs) = touch_all(device, &file.landmarks, &keys, &stop)? else {
            return Ok(ExitCode::FAILURE); // Ctrl-C
        };
        found.push((device.frame, fit(&pairs)?));
    }
    report(args, &text, &file.landmarks, &found)
}

/// Enter on standard input, from a thread: nothing else waits for it.
fn enter_keys() -> Receiver<()> {
    let (sender, keys) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            if line.is_err() || sender.send(()).is_err() {
                return;
            }
        }
    });
    keys
}

/// What the device measured at each landmark, and where that is. None: the person gave up.
fn touch_all(
    device: &mut Placed,
    landmarks: &[Landmark],
    keys: &Receiver<()>,
    stop: &AtomicBool,
) -> Result<Option<Vec<(Vec3, Vec3)>>, Problem> {
    let mut pairs = Vec::new();
    for (number, landmark) in (1..).zip(landmarks) {
        say::note(format_args!(
            "{number} of {}: hold the {} to '{}', then press its first button or Enter",
            landmarks.len(),
            device.name,
            landmark.name
        ));
        let Some(at) = touch(device, keys, stop)? else {
            return Ok(None);
        };
        say::note(format_args!(
            "    {:.1}  {:.1}  {:.1} mm",
            at.x * 1e3,
            at.y * 1e3,
            at.z * 1e3
        ));
        pairs.push((at, landmark.position_m));
    }
    Ok(Some(pairs))
}

/// Waits for a button or Enter, then for the device to be still; the mean of that.
fn touch(
    device: &mut Placed,
    keys: &Receiver<()>,
    stop: &AtomicBool,
) -> Result<Option<Vec3>, Problem> {
    while keys.try_recv().is_ok() {}
    let (mut asked, mut was_pressed, mut told) = (false, true, false);
    let mut recent: VecDeque<(Instant, Vec3)> = VecDeque::new();
    let mut heard = Instant::now();
    while !stop.load(Relaxed) {
        asked |= keys.try_recv().is_ok();
        if let Some((at, pressed)) = device.port.poll() {
            heard = Instant::now();
            asked |= pressed && !was_pressed;
            was_pressed = pressed;
            recent.push_back((heard, at));
        }
        while recent
            .front()
            .is_some_and(|(then, _)| then.elapsed() > MEASURED_FOR)
        {
            recent.pop_front();
        }
        if heard.elapsed() > Duration::from_secs(5) {
            return Err(format!("the {} is silent", device.name).into());
        }
        let long = recent
            .front()
            .is_some_and(|(then, _)| then.elapsed() > MEASURED_FOR * 9 / 10);
        if asked && long && recent.len() >= 10 {
            let mean = recent.iter().map(|(_, at)| at).sum::<Vec3>() / recent.len() as f32;
            let moved_m = recent
                .iter()
                .map(|(_, at)| (at - mean).norm())
                .fold(0.0, f32::max);
            if moved_m <= STILL_M {
                return Ok(Some(mean));
            }
            if !told {
                say::note(format_args!(
                    "    it moves by {:.1} mm: hold it still",
                    moved_m * 1e3
                ));
                told = true;
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(None)
}

/// Says how well it fits, and writes the frames if that is good enough.
fn report(
    args: &CalibrateArgs,
    text: &str,
    landmarks: &[Landmark],
    found: &[(&'static str, Fit)],
) -> Result<ExitCode, Problem> {
    let mut good = true;
    let mut frames = String::new();
    for (frame, fit) in found {
        let odd_one = landmarks
            .get(fit.odd_one)
            .map_or("", |landmark| &landmark.name);
        let [rms_mm, worst_mm] = [fit.rms_m, fit.worst_m].map(|m| m * 1e3);
        good &= rms_mm <= args.residual_mm;
        frames.push_str(&frame_text(frame, &fit.world_from_device));
        if args.json {
            let pose = &fit.world_from_device;
            say::answer(json!({
                "frame": frame,
                "position_m": pose.translation.vector.as_slice(),
                "rotation_xyzw": pose.rotation.coords.as_slice(),
                "rms_mm": rms_mm,
                "worst_mm": worst_mm,
                "odd_one": odd_one,
            }));
        } else {
            say::note(format_args!(
                "{frame}: residual {rms_mm:.2} mm rms, at most {worst_mm:.2} mm; '{odd_one}' fits the \
                 others least"
            ));
        }
    }
    if !good {
        return Err(format!(
            "the residual is over {} mm: touch the landmarks again (first the one that fits least), look whether the \
             station file has them where they are, or allow more with --residual-mm",
            args.residual_mm
        )
        .into());
    }
    match &args.out {
        None if args.json => {}
        None => say::answer(frames.trim_end()),
        Some(out) => {
            write(out, text, found, &frames)?;
            say::note(format_args!("wrote {}", out.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// A frame's section of the station file.
fn frame_text(frame: &str, pose: &Pose) -> String {
    let numbers = |values: &[f32]| {
        let words: Vec<String> = values.iter().map(|value| format!("{value:.6}")).collect();
        words.join(", ")
    };
    format!(
        "[frames.{frame}]\nposition_m = [{}]\nrotation_xyzw = [{}]\n\n",
        numbers(pose.translation.vector.as_slice()),
        numbers(pose.rotation.coords.as_slice())
    )
}

/// The station file with these frames instead of its own; all else, comments too, stays.
fn write(
    out: &Path,
    text: &str,
    found: &[(&'static str, Fit)],
    frames: &str,
) -> Result<(), Problem> {
    let heads: Vec<String> = found
        .iter()
        .map(|(frame, _)| format!("[frames.{frame}]"))
        .collect();
    let mut kept = String::new();
    let mut is_old = false;
    for line in text.lines() {
        if line.trim_start().starts_with('[') {
            is_old = heads.iter().any(|head| line.trim_start().starts_with(head));
        }
        if !is_old {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    let whole = format!("{}\n\n{}", kept.trim_end(), frames.trim_end());
    // What is written must read as what was found.
    StationFile::parse(&whole, out)?;
    std::fs::write(out, whole + "\n").map_err(|error| format!("{}: {error}", out.display()))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_frames_replace_old_ones_and_all_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("station.toml");
        let text = "# mine\n[frames.world_from_device] # old\nposition_m = [9.0, 9.0, 9.0]\n\
                    rotation_xyzw = [0.0, 0.0, 0.0, 1.0]\n\n[[landmarks]]\nname = \"a\"\n\
                    position_m = [0.0, 0.0, 0.1]\n";
        let pairs = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]
            .map(|at| (Vec3::from(at), Vec3::from(at) + Vec3::new(0.5, 0.0, 0.0)));
        let found = [("world_from_device", fit(&pairs).unwrap())];
        let frames = frame_text(found[0].0, &found[0].1.world_from_device);
        write(&out, text, &found, &frames).unwrap();
        let written = std::fs::read_to_string(&out).unwrap();
        assert!(
            written.starts_with("# mine\n") && !written.contains("9.0"),
            "{written}"
        );
        let file = StationFile::parse(&written, &out).unwrap();
        assert!((file.world_from_device.unwrap().translation.x - 0.5).abs() < 1e-5);
        assert_eq!(file.landmarks.len(), 1);
    }
}
