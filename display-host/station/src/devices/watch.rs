//! `calot devices watch`: shows the samples of devices live.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::sleep;
use std::time::{Duration, Instant};

use hardware::HardwareError;
use hardware::arrivals::{Arrivals, Pattern};
use hardware::bird::{BirdSetup, BirdTracker};
use hardware::pedal::{EvdevPedal, ModemPedal, Roles};
use hardware::rig::RigPedal;
use hardware::rig::wire::Status;
use hardware::station::{HapticDriver, StationFile, TrackerDriver};
use rt_core::fault::Fault;
use rt_core::math::Pose;
use rt_core::port::{ForceCommand, HapticDevice, LineCounters, Pedal, Polled, Reading, Tracker};
use rt_process::time_driver::now_ns;
use serde_json::{Value, json};

use super::args::{LineDriver, WatchArgs};
use super::open::open_haptic;
use super::samples::Samples;
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// Interval between two outputs at a terminal.
const TERMINAL_EVERY: Duration = Duration::from_millis(100);
/// Interval between two outputs to a file or pipe, or as JSON.
const PIPE_EVERY: Duration = Duration::from_secs(1);
/// Pause between two polls.
const POLL_EVERY: Duration = Duration::from_micros(200);
/// Least interval between two commands to a haptic device, ns: a little shorter than a tick.
const COMMAND_EVERY_NS: u64 = 900_000;

pub(super) fn run(args: &WatchArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    say::keep_answers_apart()?;
    let mut watched = match (&args.path, &args.station_file) {
        (Some(path), _) => vec![Watched::open(path, args.driver)?],
        (None, Some(file)) => named_in(&StationFile::read(file)?)?,
        (None, None) => return Err("name a PATH, or a --station-file".into()),
    };
    if watched.is_empty() {
        return Err("the station file names no device".into());
    }
    let mut table = match &args.csv {
        Some(path) => {
            output::check("--csv", path, Format::Table, args.overwrite)?;
            Some(Samples::make(path)?)
        }
        None => None,
    };
    let live = !args.json && say::is_terminal();
    let every = if live { TERMINAL_EVERY } else { PIPE_EVERY };
    let start = Instant::now();
    let mut shown = start;
    let mut lines = 0;
    let over = || {
        args.seconds
            .is_some_and(|s| start.elapsed().as_secs_f64() >= s)
    };
    while !stop.load(Relaxed) && !over() {
        for device in &mut watched {
            device.poll(table.as_mut());
        }
        if shown.elapsed() >= every {
            let since_s = shown.elapsed().as_secs_f64();
            shown = Instant::now();
            if live && lines > 0 {
                say::print(format_args!("\x1b[{lines}A"));
            }
            lines = watched.len();
            for device in &mut watched {
                let line = match args.json {
                    true => serde_json::to_string(&document::WATCH.of(device.as_json(since_s)))?,
                    false => device.in_words(since_s),
                };
                let erase = if live { "\x1b[K" } else { "" };
                say::answer(format_args!("{line}{erase}"));
            }
        }
        if watched.iter().all(|device| device.is_lost) {
            return Err("every device is gone".into());
        }
        // The pause is short, because the table takes each of up to 4000 samples a second, and
        // because the arrivals are judged.
        sleep(POLL_EVERY);
    }
    if let Some(table) = table {
        table.end()?;
    }
    Ok(ExitCode::SUCCESS)
}

fn named_in(file: &StationFile) -> Result<Vec<Watched>, HardwareError> {
    let mut all = Vec::new();
    if let Some(spec) = &file.haptic {
        let is_line = match spec.driver {
            HapticDriver::Rig | HapticDriver::Woody | HapticDriver::Hapi(_) => true,
            HapticDriver::Inverse3 { .. } => false,
            HapticDriver::Touch { .. } | HapticDriver::ForceDimension { .. } => false,
        };
        let line = is_line.then_some(spec.path.as_path());
        all.push(Watched::new(Port::Haptic(spec.open()?)).on(line));
    }
    if let Some(spec) = &file.tracker {
        let line = (spec.driver == TrackerDriver::Bird).then_some(spec.path.as_path());
        all.push(Watched::new(Port::Tracker(Box::new(spec.open()?))).on(line));
    }
    if let Some(spec) = &file.pedal {
        all.push(Watched::new(Port::Pedal(spec.open()?)));
    }
    Ok(all)
}

enum Port {
    Haptic(Box<dyn HapticDevice>),
    Tracker(Box<dyn Tracker>),
    Pedal(Box<dyn Pedal>),
}

/// A device and its last sample.
struct Watched {
    port: Port,
    /// The last sample as JSON.
    json: Value,
    /// The last sample in words.
    words: String,
    /// Number of frames when the device was last shown.
    frames: u64,
    /// Samples of the last poll of a haptic device.
    readings: Vec<Reading>,
    /// Time of the last sample, ns; 0 before the first.
    at_ns: u64,
    commanded_ns: u64,
    is_lost: bool,
    /// Serial line whose arrivals are judged, if any.
    line: Option<PathBuf>,
    arrivals: Arrivals,
    /// Number of frames at the last arrival.
    arrived: u64,
}

impl Watched {
    fn new(port: Port) -> Self {
        Self {
            port,
            json: Value::Null,
            words: "nothing yet".to_owned(),
            frames: 0,
            readings: Vec::new(),
            at_ns: 0,
            commanded_ns: 0,
            is_lost: false,
            line: None,
            arrivals: Arrivals::default(),
            arrived: 0,
        }
    }

    /// Also judges the arrivals on this serial line, if any.
    fn on(mut self, line: Option<&Path>) -> Self {
        self.line = line.map(Path::to_owned);
        self
    }

    fn open(path: &Path, driver: LineDriver) -> Result<Self, HardwareError> {
        Ok(Self::new(match driver {
            LineDriver::Rig => match open_haptic(path, driver) {
                Ok(haptic) => Port::Haptic(haptic),
                // A device with the rig protocol may also be a pedal.
                Err(HardwareError::WrongDevice { .. }) => {
                    Port::Pedal(Box::new(RigPedal::open(path)?))
                }
                Err(error) => return Err(error),
            },
            LineDriver::Evdev => Port::Pedal(Box::new(EvdevPedal::open(path, Roles::default())?)),
            LineDriver::Modem => Port::Pedal(Box::new(ModemPedal::open(path)?)),
            LineDriver::Bird => {
                Port::Tracker(Box::new(BirdTracker::open(path, BirdSetup::default())?))
            }
            LineDriver::Trakstar => {
                Port::Tracker(Box::new(BirdTracker::open_usb(path, BirdSetup::default())?))
            }
            _ => Port::Haptic(open_haptic(path, driver)?),
        })
        .on(driver.is_serial().then_some(path)))
    }

    fn poll(&mut self, table: Option<&mut Samples>) {
        let before_ns = self.at_ns;
        self.read(table);
        if self.at_ns > before_ns {
            let frames = self.counters().frames;
            let more = frames.saturating_sub(self.arrived);
            self.arrived = frames;
            self.arrivals.take(more, self.at_ns);
        }
    }

    /// Pattern of the arrivals on the serial line, with its remedy, if one was found.
    fn pattern(&self) -> Option<(Pattern, String)> {
        let (line, found) = (self.line.as_ref()?, self.arrivals.found()?);
        Some((found, found.in_words(line)))
    }

    fn read(&mut self, table: Option<&mut Samples>) {
        let now = now_ns();
        match &mut self.port {
            Port::Haptic(haptic) => {
                let readings = &mut self.readings;
                readings.clear();
                let polled = haptic.poll_each(now, &mut |reading| readings.push(*reading));
                let found = haptic.findings().faults;
                if let Some(table) = table {
                    readings.iter().for_each(|it| table.add(it, found));
                }
                let newest = readings.last().copied();
                if now.saturating_sub(self.commanded_ns) >= COMMAND_EVERY_NS {
                    self.commanded_ns = now;
                    // Some devices send a sample only after a command. This command has zero
                    // force, so it leaves the hand free.
                    haptic.send(ForceCommand::default(), now);
                }
                if let Some(sample) = self.take(polled) {
                    let pose = &sample.device_from_handle;
                    self.words =
                        format!("{}  buttons {:08b}", pose_in_words(pose), sample.buttons.0);
                    self.json = json!({ "pose": pose_as_json(pose), "buttons": sample.buttons.0 });
                    if let Some(opening) = sample.opening {
                        self.words += &format!("  {:3.0} % open", opening * 100.0);
                        self.json["opening"] = opening.into();
                    }
                    if let Some(newest) = newest {
                        add_reading(&mut self.json, &newest);
                    }
                    self.at_ns = sample.at_ns;
                }
            }
            Port::Tracker(tracker) => {
                let polled = tracker.poll(now);
                if let Some(sample) = self.take(polled) {
                    self.words = pose_in_words(&sample.tracker_from_sensor);
                    self.json = json!({ "pose": pose_as_json(&sample.tracker_from_sensor) });
                    self.at_ns = sample.at_ns;
                }
            }
            Port::Pedal(pedal) => {
                let polled = pedal.poll(now);
                if let Some(sample) = self.take(polled) {
                    let word = |pressed, word| if pressed { word } else { "-" };
                    self.words = format!(
                        "{} {} {}",
                        word(sample.cut, "CUT"),
                        word(sample.coagulate, "COAGULATE"),
                        word(sample.camera_lock, "CAMERA-LOCK")
                    );
                    self.json = json!({
                        "cut": sample.cut,
                        "coagulate": sample.coagulate,
                        "camera_lock": sample.camera_lock,
                    });
                    self.at_ns = sample.at_ns;
                }
            }
        }
    }

    fn take<T>(&mut self, polled: Polled<T>) -> Option<T> {
        match polled {
            Polled::Fresh(sample) => {
                self.is_lost = false;
                Some(sample)
            }
            Polled::Nothing => None,
            Polled::Lost => {
                self.is_lost = true;
                None
            }
        }
    }

    fn kind(&self) -> &'static str {
        match self.port {
            Port::Haptic(_) => "haptic",
            Port::Tracker(_) => "tracker",
            Port::Pedal(_) => "pedal",
        }
    }

    fn counters(&self) -> LineCounters {
        match &self.port {
            Port::Haptic(haptic) => haptic.counters(),
            Port::Tracker(tracker) => tracker.counters(),
            Port::Pedal(pedal) => pedal.counters(),
        }
    }

    /// Names of the faults that the haptic device or its driver reports now.
    fn faults(&self) -> Vec<&'static str> {
        let Port::Haptic(haptic) = &self.port else {
            return Vec::new();
        };
        let found = haptic.findings().faults;
        let present = Fault::ALL.into_iter().filter(|it| found.contains(*it));
        present.map(Fault::name).collect()
    }

    /// Good frames per second since the last call, `since_s` ago.
    fn rate_hz(&mut self, since_s: f64) -> f64 {
        let frames = self.counters().frames;
        let before = std::mem::replace(&mut self.frames, frames);
        (frames - before) as f64 / since_s.max(1e-3)
    }

    fn age_ms(&self) -> Option<f64> {
        let age_ns = now_ns().saturating_sub(self.at_ns);
        (self.at_ns > 0).then_some(age_ns as f64 * 1e-6)
    }

    fn in_words(&mut self, since_s: f64) -> String {
        let LineCounters {
            bad_frames,
            lost_frames,
            ..
        } = self.counters();
        let rate_hz = self.rate_hz(since_s);
        let state = match (self.is_lost, self.age_ms()) {
            (true, _) => "LOST".to_owned(),
            (_, None) => "silent".to_owned(),
            (_, Some(age_ms)) => format!("{rate_hz:5.0} Hz, {age_ms:6.1} ms old"),
        };
        let pattern = self.pattern();
        let pattern = pattern.map_or(String::new(), |(_, words)| format!("  [{words}]"));
        let faults = match self.faults().as_slice() {
            [] => String::new(),
            faults => format!("  {}", faults.join(" ").to_uppercase()),
        };
        format!(
            "{:<8} {state}, {bad_frames} bad, {lost_frames} lost  {}{faults}{pattern}",
            self.kind(),
            self.words
        )
    }

    fn as_json(&mut self, since_s: f64) -> Value {
        let counters = self.counters();
        json!({
            "device": self.kind(),
            "lost": self.is_lost,
            "rate_hz": self.rate_hz(since_s),
            "age_ms": self.age_ms(),
            "frames": counters.frames,
            "bad_frames": counters.bad_frames,
            "lost_frames": counters.lost_frames,
            "sample": self.json,
            "faults": self.faults(),
            "arrivals": self.pattern().map(|(pattern, words)| {
                json!({ "pattern": pattern.name(), "remedy": words })
            }),
        })
    }
}

/// Adds the values that only some devices report: velocity, clock, status.
fn add_reading(json: &mut Value, reading: &Reading) {
    if let Some(velocity_m_s) = reading.reported_m_s {
        json["velocity_m_s"] = json!(<[f32; 3]>::from(velocity_m_s));
    }
    if let Some(us) = reading.device_time_us {
        json["device_time_us"] = us.into();
    }
    if let Some(status) = reading.status {
        let bits = [
            ("force_on", Status::FORCE_ON),
            ("watchdog", Status::WATCHDOG),
            ("limited", Status::LIMITED),
            ("fault", Status::FAULT),
        ];
        let set = bits.iter().filter(|(_, bit)| Status(status).contains(*bit));
        json["status"] = set.map(|(name, _)| *name).collect();
    }
}

fn pose_in_words(pose: &Pose) -> String {
    let at_mm = pose.translation.vector * 1e3;
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    format!(
        "x {:+7.1}  y {:+7.1}  z {:+7.1} mm   roll {:+4.0}  pitch {:+4.0}  yaw {:+4.0}°",
        at_mm.x,
        at_mm.y,
        at_mm.z,
        roll.to_degrees(),
        pitch.to_degrees(),
        yaw.to_degrees()
    )
}

fn pose_as_json(pose: &Pose) -> Value {
    let [x, y, z, w]: [f32; 4] = pose.rotation.coords.into();
    let at_m: [f32; 3] = pose.translation.vector.into();
    json!({ "position_m": at_m, "rotation_xyzw": [x, y, z, w] })
}
