//! The three emulated devices, one millisecond at a time.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::UnitQuaternion;
use rt_core::math::{Pose, Vec3};
use rt_core::port::Buttons;
use rustix::fs::{FlockOperation, flock};

use super::electronics::Electronics;
use super::fault::{Faults, FaultyLine};
use super::fingers::{Fingers, RING};
use super::hand::{Hand, REPEAT_S};
use super::holding::Holding;
use super::operated::{SteeringState, Wish};
use super::pty::Pty;
use super::random::Random;
use super::touch::{Grip, Touch};
use super::{EmulateConfig, InnerState, Lines};
use crate::HardwareError;
use crate::bird::device::Bird;
use crate::bird::wire::Record;
use crate::rig::device::{Device, Motion};
use crate::rig::frame::Frame;
use crate::rig::wire::{Capabilities, State};

/// Measurement period of the bird, ms.
const TRACKER_PERIOD_MS: u64 = 10;
/// Report period of the pedal, ms.
const PEDAL_PERIOD_MS: u64 = 10;
/// Silence of the controller after which the script of the hand starts anew, ms.
const ABANDONED_MS: u32 = 1000;
/// Noise of the bird, m.
const TRACKER_NOISE_M: f32 = 0.1e-3;
/// Interval at which [`Pty::lift_exclusive_use`] is called, ms.
const EXCLUSIVE_PERIOD_MS: u64 = 50;

/// All emulated devices.
pub(super) struct Station {
    lines: Lines,
    /// Locked while this emulator runs.
    _lock: File,
    started: Instant,
    /// Emulated time since the start, ms.
    tick: u64,
    hand: Hand,
    /// `None` until a person steers.
    operated: Option<SteeringState>,
    /// Time of the hand's script, ms.
    hand_time_ms: u32,
    /// Last target pose of the handle, device frame.
    wanted: Pose,
    /// Time since the controller last commanded a force, ms.
    silent_ms: u32,
    touch: Touch,
    haptic: Electronics,
    /// Fingers in a handle that opens.
    fingers: Option<Fingers>,
    holding: Holding,
    /// Force commanded to the motors now, N.
    force_n: Vec3,
    /// Motor command as a share of the largest permitted command.
    motor_load: f32,
    haptic_line: Plug,
    bird: Bird,
    tracker_noise: Random,
    tracker_line: Plug,
    pedal: Device,
    pedal_line: Plug,
}

impl Station {
    pub(super) fn new(config: &EmulateConfig) -> Result<Self, HardwareError> {
        let hand = Hand::new(config.script, config.seed)?;
        let directory = &config.directory;
        fs::create_dir_all(directory).map_err(|error| HardwareError::Line {
            path: directory.clone(),
            doing: "making the directory",
            what: error.to_string(),
        })?;
        let lock = lock(directory)?;
        let plug = |name: &str, faults: Faults, stream: u64| {
            let line = FaultyLine::new(faults, Random::new(config.seed, stream));
            Plug::new(directory.join(name), line)
        };
        let haptic = Electronics::new(config.haptic, config.mistake);
        let wanted = hand.intent(0.0).device_from_handle;
        let rest = haptic.constrained_m(wanted.translation.vector);
        let (grip, start) = config.holding.grip().unwrap_or((Grip::STYLUS, rest));
        Ok(Self {
            lines: Lines {
                haptic: directory.join("haptic"),
                tracker: directory.join("tracker"),
                pedal: directory.join("pedal"),
            },
            _lock: lock,
            started: Instant::now(),
            tick: 0,
            bird: Bird::new(record(hand.tracker_from_sensor(0.0), Vec3::zeros())),
            hand,
            operated: None,
            hand_time_ms: 0,
            wanted,
            silent_ms: 0,
            touch: Touch::new(haptic.body(), grip, start),
            haptic,
            fingers: Electronics::opening(config.haptic)
                .map(|it| Fingers::new(it, RING, config.holding.fingers())),
            holding: config.holding,
            force_n: Vec3::zeros(),
            motor_load: 0.0,
            haptic_line: plug("haptic", config.faults.haptic, 10)?,
            tracker_noise: Random::new(config.seed, 2),
            tracker_line: plug("tracker", config.faults.tracker, 11)?,
            pedal: Device::new(Capabilities::pedal(1000 / PEDAL_PERIOD_MS as u16)),
            pedal_line: plug("pedal", config.faults.pedal, 12)?,
        })
    }

    pub(super) fn lines(&self) -> &Lines {
        &self.lines
    }

    /// Advances everything by one millisecond.
    pub(super) fn tick(&mut self, wish: Option<Wish>) -> Result<(), HardwareError> {
        self.follow_controller();
        self.follow_person(wish.as_ref());
        self.haptic_millisecond()?;
        self.tracker_millisecond()?;
        self.pedal_millisecond()?;
        self.tick += 1;
        Ok(())
    }

    /// State inside the devices.
    pub(super) fn inside(&self) -> InnerState {
        InnerState {
            time_s: self.tick as f32 * 1e-3,
            force_n: self.force_n,
            motor_load: self.motor_load,
        }
    }

    fn time_s(&self) -> f64 {
        self.tick as f64 * 1e-3
    }

    /// The script goes on while a controller commands forces, unless the hand is parked. After a
    /// second of silence the script restarts.
    fn follow_controller(&mut self) {
        if self.haptic.is_commanded() {
            self.silent_ms = 0;
            if self.holding != Holding::Parked {
                self.hand_time_ms = self.hand_time_ms.wrapping_add(1);
            }
        } else {
            self.silent_ms = self.silent_ms.saturating_add(1);
            if self.silent_ms >= ABANDONED_MS {
                self.hand_time_ms = 0;
                self.operated = None;
            }
        }
    }

    /// Starts steering with the first command, and follows every command.
    fn follow_person(&mut self, wish: Option<&Wish>) {
        if let (None, Some(wish)) = (&self.operated, wish) {
            let tip_m = self.hand.intent(self.hand_time_s()).tip_m;
            self.operated = Some(SteeringState::begin(tip_m, wish));
        }
        if let Some(operated) = &mut self.operated {
            operated.follow(wish, &self.hand);
        }
    }

    fn hand_time_s(&self) -> f32 {
        // Reduced as an integer, so that precision does not decrease during a long run.
        (self.hand_time_ms % (REPEAT_S * 1e3) as u32) as f32 * 1e-3
    }

    fn haptic_millisecond(&mut self) -> Result<(), HardwareError> {
        // The watchdog runs on real time, so that a slow machine does not delay it.
        let now_us = self.started.elapsed().as_micros() as u32;
        let mut bytes = [0; 4096];
        let count = self.haptic_line.read(&mut bytes, self.tick)?;
        let time_s = self.time_s();
        let line = &mut self.haptic_line.line;
        let bytes = bytes.get(..count).unwrap_or(&[]);
        let degenerate = line.degenerate();
        let force_n = self
            .haptic
            .receive(bytes, &self.touch, now_us, degenerate, |answer| {
                line.send(answer, time_s);
            });
        self.force_n = force_n;
        self.motor_load = self.haptic.motor_load(now_us);

        let at_s = self.hand_time_s();
        let (handle, before, buttons, roll) = match &self.operated {
            Some(operated) => {
                let handle = operated.handle(&self.hand);
                (handle, self.wanted, operated.buttons(), operated.roll())
            }
            None => {
                let intent = self.hand.intent(at_s);
                let before = self.hand.intent(at_s - 1e-3).device_from_handle;
                let handle = intent.device_from_handle;
                (handle, before, intent.buttons, UnitQuaternion::identity())
            }
        };
        self.wanted = handle;
        let [target_m, before_m] =
            [handle, before].map(|wanted| self.haptic.constrained_m(wanted.translation.vector));
        let target_velocity_m_s = (target_m - before_m) / 1e-3;
        let (target_m, target_velocity_m_s) = match self.holding.target_m(time_s) {
            Some(target_m) => (target_m, Vec3::zeros()),
            None => (target_m, target_velocity_m_s),
        };
        self.touch.step(target_m, target_velocity_m_s, force_n);

        if let Some(fingers) = &mut self.fingers {
            let opening_n = self.haptic.opening_n(now_us);
            match self.holding.fingers_m(time_s) {
                Some(wanted_m) => fingers.pull(wanted_m, opening_n),
                None => fingers.step(buttons.contains(Buttons::GRASP), opening_n),
            }
        }
        let position_m = self.touch.measured_m();
        let q = self.hand.handle_at(position_m).rotation * roll;
        let motion = Motion {
            position_m: position_m.into(),
            velocity_m_s: self.touch.measured_velocity_m_s().into(),
            rotation_xyzw: if degenerate {
                [0.0; 4]
            } else {
                [q.i, q.j, q.k, q.w]
            },
            buttons: buttons.0,
            opening: self.fingers.as_ref().map_or(1.0, Fingers::opening),
        };
        let line = &mut self.haptic_line.line;
        self.haptic.report(&motion, &self.touch, now_us, |sample| {
            line.send(sample, time_s);
        });
        self.haptic_line.arrive(self.tick);
        Ok(())
    }

    fn tracker_millisecond(&mut self) -> Result<(), HardwareError> {
        let time_s = self.time_s();
        let mut bytes = [0; 256];
        let count = self.tracker_line.read(&mut bytes, self.tick)?;
        let line = &mut self.tracker_line.line;
        self.bird
            .receive(bytes.get(..count).unwrap_or(&[]), |answer| {
                line.send(answer, time_s);
            });
        if self.tick.is_multiple_of(TRACKER_PERIOD_MS) {
            let noise = Vec3::from_fn(|_, _| self.tracker_noise.between(-1.0, 1.0));
            let sensor = match &self.operated {
                Some(operated) => self.hand.sensor(operated.scope()),
                None => self.hand.tracker_from_sensor(self.hand_time_s()),
            };
            self.bird.set_pose(record(sensor, noise * TRACKER_NOISE_M));
            if self.bird.is_streaming() {
                let mut record = self.bird.record();
                if self.tracker_line.line.degenerate() {
                    // A quaternion of length zero. Its words follow the words of the position.
                    record.iter_mut().skip(6).for_each(|byte| *byte = 0);
                }
                self.tracker_line.line.send(&record, time_s);
            }
        }
        self.tracker_line.arrive(self.tick);
        Ok(())
    }

    fn pedal_millisecond(&mut self) -> Result<(), HardwareError> {
        let time_s = self.time_s();
        let mut bytes = [0; 256];
        let count = self.pedal_line.read(&mut bytes, self.tick)?;
        self.pedal.receive(bytes.get(..count).unwrap_or(&[]), 0);
        if let Some(answer) = self.pedal.answer() {
            self.pedal_line.send(&answer, time_s);
        }
        if self.tick.is_multiple_of(PEDAL_PERIOD_MS) {
            let switches = match &self.operated {
                Some(operated) => operated.switches(),
                None => self.hand.intent(self.hand_time_s()).switches,
            };
            if let Some(report) = self.pedal.switches(switches) {
                self.pedal_line.send(&report, time_s);
            }
        }
        self.pedal_line.arrive(self.tick);
        Ok(())
    }
}

fn record(tracker_from_sensor: Pose, noise_m: Vec3) -> Record {
    Record {
        position_m: (tracker_from_sensor.translation.vector + noise_m).into(),
        rotation: tracker_from_sensor.rotation,
    }
}

/// A line; `pty` is `None` during a hang-up.
struct Plug {
    path: PathBuf,
    pty: Option<Pty>,
    line: FaultyLine,
}

impl Plug {
    fn new(path: PathBuf, line: FaultyLine) -> Result<Self, HardwareError> {
        Ok(Self {
            pty: Some(Pty::plug_in(&path)?),
            path,
            line,
        })
    }

    fn send(&mut self, frame: &Frame, time_s: f64) {
        self.line.send(frame.as_bytes(), time_s);
    }

    /// Hangs up or reconnects as the faults demand, then reads the controller's bytes.
    fn read(&mut self, bytes: &mut [u8], tick: u64) -> Result<usize, HardwareError> {
        let at_s = tick as f32 * 1e-3;
        let faults = *self.line.faults();
        let gone = faults.hang_up_at_s.is_some_and(|hang_up| {
            let back = faults
                .back_after_s
                .map_or(f32::INFINITY, |after| hang_up + after);
            (hang_up..back).contains(&at_s)
        });
        if gone {
            self.pty = None;
        } else if self.pty.is_none() {
            self.pty = Some(Pty::plug_in(&self.path)?);
        }
        self.line.begin(at_s);
        let Some(pty) = &mut self.pty else {
            return Ok(0);
        };
        if tick.is_multiple_of(EXCLUSIVE_PERIOD_MS) {
            pty.lift_exclusive_use();
        }
        let room = self.line.bytes_taken(tick).min(bytes.len());
        let bytes = bytes.get_mut(..room).unwrap_or_default();
        let count = pty.read(bytes);
        self.line
            .arrive_at_device(bytes.get_mut(..count).unwrap_or_default());
        Ok(count)
    }

    fn arrive(&mut self, tick: u64) {
        let pty = &mut self.pty;
        self.line.arrive(tick, |bytes| {
            if let Some(pty) = pty {
                pty.write(bytes);
            }
        });
    }
}

/// Locks the directory for one emulator. The lock ends with the process.
fn lock(directory: &Path) -> Result<File, HardwareError> {
    let path = directory.join("emulator.lock");
    let file = File::create(&path).map_err(|error| HardwareError::Line {
        path: path.clone(),
        doing: "making the lock",
        what: error.to_string(),
    })?;
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(file),
        Err(_) => Err(HardwareError::Busy { path }),
    }
}

const _: () = assert!(
    State::POSITION_LIMIT_M > 0.2,
    "a STATE can carry every position of the handle"
);
