//! `calot devices calibrate`: finds the positions of haptic device and tracker from touched
//! landmarks.

use std::collections::VecDeque;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use hardware::station::calibration::{Fit, fit};
use hardware::station::{HapticSpec, Landmark, StationFile};
use rt_core::math::{Pose, Vec3};
use rt_core::port::{Buttons, ForceCommand, HapticDevice, Polled, Tracker};
use rt_process::time_driver::now_ns;
use serde_json::json;

use super::args::CalibrateArgs;
use super::sections::{Section, with_sections};
use super::typed::typed_lines;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// A device without a sample for this time counts as lost.
const SILENT: Duration = Duration::from_secs(20);
/// Time over which the position of a landmark is averaged.
const MEASURED_FOR: Duration = Duration::from_millis(300);
/// Largest distance from the mean position within [`MEASURED_FOR`], m.
const STILL_M: f32 = 1.5e-3;

/// A device whose position is sought.
struct Placed {
    /// Name in messages.
    name: &'static str,
    /// Name of its frame in the station file.
    frame: &'static str,
    port: Port,
}

enum Port {
    Haptic(Box<dyn HapticDevice + Send>),
    Tracker(Box<dyn Tracker>),
}

impl Port {
    /// Position in the frame of the device, m, and true if the handle's first button is down.
    /// `None` without a new sample.
    fn poll(&mut self) -> Option<(Vec3, bool)> {
        let now_ns = now_ns();
        match self {
            Self::Haptic(device) => {
                // Some devices report only while they get commands, so send zero force.
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
    say::keep_answers_apart()?;
    let text = std::fs::read_to_string(&args.station_file)
        .map_err(|error| format!("{}: {error}", args.station_file.display()))?;
    let file = StationFile::parse(&text, &args.station_file)?;
    if let Some(out) = &args.out {
        output::check("--out", out, Format::Station, args.overwrite)?;
    }
    // Refuse landmarks now if they cannot determine a frame, so that nobody touches them in vain.
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
            // Landmarks are real places, so the unscaled motion counts.
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
    // Refuse the station file now if the frames cannot be written into it later.
    let unmoved = devices
        .iter()
        .map(|device| (device.frame, Pose::identity()));
    with_frames(&args.station_file, &text, &unmoved.collect::<Vec<_>>())?;
    let keys = typed_lines();
    let mut found = Vec::new();
    for device in &mut devices {
        let Some(pairs) = touch_all(device, &file.landmarks, &keys, &stop)? else {
            return Ok(ExitCode::FAILURE); // Ctrl-C
        };
        found.push((device.frame, fit(&pairs)?));
    }
    report(args, &text, &file.landmarks, &found)
}

/// Pairs of the measured position and the known position of each landmark. `None`: the user gave
/// up.
fn touch_all(
    device: &mut Placed,
    landmarks: &[Landmark],
    keys: &Receiver<String>,
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

/// Waits for a button or Enter, and then until the device is still. Returns the mean position, m;
/// `None` if the user gave up.
fn touch(
    device: &mut Placed,
    keys: &Receiver<String>,
    stop: &AtomicBool,
) -> Result<Option<Vec3>, Problem> {
    let _ = keys.try_recv();
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
        if heard.elapsed() > SILENT {
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
                    "    it moves by {:.1} mm: please hold it still",
                    moved_m * 1e3
                ));
                told = true;
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(None)
}

/// Reports the quality of the fit, and writes the frames if the fit is good enough.
fn report(
    args: &CalibrateArgs,
    text: &str,
    landmarks: &[Landmark],
    found: &[(&'static str, Fit)],
) -> Result<ExitCode, Problem> {
    let mut good = true;
    let mut frames = String::new();
    for (frame, fit) in found {
        let odd_one = fit.odd_one.and_then(|at| landmarks.get(at));
        let odd_one = odd_one.map(|landmark| landmark.name.as_str());
        let [rms_mm, worst_mm] = [fit.rms_m, fit.worst_m].map(|m| m * 1e3);
        good &= rms_mm <= args.residual_mm;
        for section in sections(&[(*frame, fit.world_from_device)]) {
            frames.push_str(&section.text());
        }
        if args.json {
            let pose = &fit.world_from_device;
            document::CALIBRATION.line(json!({
                "frame": frame,
                "position_m": pose.translation.vector.as_slice(),
                "rotation_xyzw": pose.rotation.coords.as_slice(),
                "rms_mm": rms_mm,
                "worst_mm": worst_mm,
                "odd_one": odd_one,
            }))?;
        } else {
            let odd_one = odd_one.map_or(String::new(), |name| {
                format!("; '{name}' fits the others worst")
            });
            say::note(format_args!(
                "{frame}: residual {rms_mm:.2} mm rms, at most {worst_mm:.2} mm{odd_one}"
            ));
        }
    }
    if !good {
        return Err(format!(
            "the residual is over {} mm: touch the landmarks again (first the one that fits least), check their \
             positions in the station file, or allow more with --residual-mm",
            args.residual_mm
        )
        .into());
    }
    match &args.out {
        None if args.json => {}
        None => say::answer(frames.trim_end()),
        Some(out) => {
            let found = found
                .iter()
                .map(|(frame, fit)| (*frame, fit.world_from_device));
            let written = with_frames(out, text, &found.collect::<Vec<_>>())
                .and_then(|whole| Ok(output::write(out, &whole)?));
            if let Err(problem) = written {
                // Print the frames, so that nobody must touch the landmarks again.
                say::answer(frames.trim_end());
                return Err(format!("{}: {problem}; the frames are above", out.display()).into());
            }
            say::note(format_args!("wrote {}", out.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Sections of frames in the station file.
fn sections(frames: &[(&str, Pose)]) -> Vec<Section> {
    let numbers = |values: &[f32]| {
        let words: Vec<String> = values.iter().map(|value| format!("{value:.6}")).collect();
        words.join(", ")
    };
    let section = |(frame, pose): &(&str, Pose)| Section {
        head: format!("frames.{frame}"),
        body: format!(
            "position_m = [{}]\nrotation_xyzw = [{}]\n",
            numbers(pose.translation.vector.as_slice()),
            numbers(pose.rotation.coords.as_slice())
        ),
    };
    frames.iter().map(section).collect()
}

/// Text of a station file in which these frames replace the old ones. `path` appears in errors.
fn with_frames(path: &Path, text: &str, frames: &[(&str, Pose)]) -> Result<String, Problem> {
    with_sections(path, text, &sections(frames))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_frames_replace_old_ones_and_other_lines_stay() {
        let path = Path::new("station.toml");
        let text = "# mine\n[frames.world_from_device] # old\nposition_m = [9.0, 9.0, 9.0]\n\
                    rotation_xyzw = [0.0, 0.0, 0.0, 1.0]\n# the phantom's = its own\n[[landmarks]]\n\
                    name = \"a\"\nposition_m = [0.0, 0.0, 0.1]\n";
        let pose = Pose::translation(0.5, 0.0, 0.0);
        let written = with_frames(path, text, &[("world_from_device", pose)]).unwrap();
        assert!(
            written.starts_with("# mine\n") && !written.contains("9.0"),
            "{written}"
        );
        assert!(written.contains("# the phantom's"), "{written}");
        let file = StationFile::parse(&written, path).unwrap();
        assert!((file.world_from_device.unwrap().translation.x - 0.5).abs() < 1e-5);
        assert_eq!(file.landmarks.len(), 1);
        let inline = "frames = { world_from_device = { position_m = [0.0, 0.0, 0.0], \
                      rotation_xyzw = [0.0, 0.0, 0.0, 1.0] } }\n";
        let error = with_frames(path, inline, &[("world_from_device", pose)]).unwrap_err();
        assert!(
            error.to_string().contains("sections of their own"),
            "{error}"
        );
    }
}
