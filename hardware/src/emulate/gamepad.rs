//! A gamepad that steers the emulated hand, read through evdev.
//!
//! The left stick moves the tip across the picture. The right stick controls depth and roll. The
//! cross turns the endoscope, and the shoulder buttons move it in and out. The south button or the
//! right trigger closes the jaws. East coagulates, west cuts, north holds the camera.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use evdev::{AbsoluteAxisCode as Axis, Device, EventSummary, KeyCode};
use rt_core::port::Buttons;

use super::Wish;
use crate::HardwareError;

/// Dead zone of a stick, share of its travel.
const DEAD: f64 = 0.15;
/// Speed of the tip with the stick at its end, m/s.
const TIP_M_S: f64 = 0.06;
/// Turning speed of the instrument with the stick at its end, rad/s.
const ROLL_RAD_S: f64 = 1.5;
/// Turning speed of the endoscope while the cross is pressed, rad/s.
const SCOPE_RAD_S: f64 = 0.4;
/// Speed of the endoscope while a shoulder button is pressed, m/s.
const SCOPE_M_S: f64 = 0.02;
/// Share of a trigger's travel beyond which the trigger counts as pressed.
const TRIGGER: f64 = 0.5;

/// Axes in use, in the order of [`Sticks::axes`].
const AXES: [Axis; 7] = [
    Axis::ABS_X,
    Axis::ABS_Y,
    Axis::ABS_RX,
    Axis::ABS_RY,
    Axis::ABS_RZ,
    Axis::ABS_HAT0X,
    Axis::ABS_HAT0Y,
];
const TRIGGER_AXIS: usize = 4;
/// Buttons in use, in the order of [`Sticks::keys`].
const KEYS: [KeyCode; 6] = [
    KeyCode::BTN_SOUTH,
    KeyCode::BTN_EAST,
    KeyCode::BTN_WEST,
    KeyCode::BTN_NORTH,
    KeyCode::BTN_TL,
    KeyCode::BTN_TR,
];

/// Positions of axes and buttons.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Sticks {
    /// −1 to 1; a trigger 0 to 1.
    axes: [f64; AXES.len()],
    keys: [bool; KEYS.len()],
}

impl Sticks {
    /// Position of an axis beyond its dead zone, −1 to 1.
    fn axis(&self, number: usize) -> f64 {
        let at = self.axes.get(number).copied().unwrap_or(0.0);
        let beyond = (at.abs() - DEAD).max(0.0) / (1.0 - DEAD);
        beyond.min(1.0).copysign(at)
    }

    fn key(&self, number: usize) -> bool {
        self.keys.get(number).copied().unwrap_or(false)
    }

    /// Adds the movement that the sticks ask for in `seconds`.
    fn add_to(&self, wish: &mut Wish, seconds: f64) {
        // A stick that is pulled towards the player has a positive value: the left stick moves
        // down, the right one out of the body.
        let [x, y, roll, depth] = [0, 1, 2, 3].map(|axis| self.axis(axis));
        for (moved, part) in wish.moved_m.iter_mut().zip([x, -y, depth]) {
            *moved += part * TIP_M_S * seconds;
        }
        wish.rolled_rad -= roll * ROLL_RAD_S * seconds;
        let [left, up] = [-self.axis(5), -self.axis(6)];
        for (turned, part) in wish.scope_turned_rad.iter_mut().zip([left, up]) {
            *turned += part * SCOPE_RAD_S * seconds;
        }
        let inwards = f64::from(i8::from(self.key(5)) - i8::from(self.key(4)));
        wish.scope_advanced_m += inwards * SCOPE_M_S * seconds;
        let closed = self.key(0) || self.axes[TRIGGER_AXIS] > TRIGGER;
        wish.buttons = Buttons(if closed { Buttons::GRASP.0 } else { 0 });
        wish.switches.coagulate = self.key(1);
        wish.switches.cut = self.key(2);
        wish.switches.camera_lock = self.key(3);
    }
}

/// A connected gamepad.
#[derive(Debug)]
pub struct Gamepad {
    device: Device,
    path: PathBuf,
    ranges: [[f64; 2]; AXES.len()],
    sticks: Sticks,
    wish: Wish,
    /// True once a stick or button was used. Until then the script goes on.
    used: bool,
}

impl Gamepad {
    /// Path of the first gamepad that may be read.
    #[must_use]
    pub fn find() -> Option<PathBuf> {
        let mut found: Vec<PathBuf> = evdev::enumerate()
            .filter(|(_, device)| is_gamepad(device))
            .map(|(path, _)| path)
            .collect();
        found.sort();
        found.into_iter().next()
    }

    /// Opens the gamepad at `path`, e.g. `/dev/input/by-id/…-event-joystick`.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        let failed = |doing: &'static str| {
            move |error: std::io::Error| HardwareError::Line {
                path: path.to_path_buf(),
                doing,
                what: error.to_string(),
            }
        };
        let device = Device::open(path).map_err(failed("opening the gamepad"))?;
        if !is_gamepad(&device) {
            return Err(HardwareError::WrongDevice {
                path: path.to_path_buf(),
                expected: "gamepad",
                found: device
                    .name()
                    .unwrap_or("a device without a name")
                    .to_owned(),
            });
        }
        device
            .set_nonblocking(true)
            .map_err(failed("opening the gamepad"))?;
        let mut ranges = [[-1.0, 1.0]; AXES.len()];
        for (axis, info) in device.get_absinfo().map_err(failed("reading its axes"))? {
            if let Some(at) = AXES.iter().position(|own| *own == axis) {
                ranges[at] = [info.minimum(), info.maximum()].map(f64::from);
            }
        }
        Ok(Self {
            device,
            path: path.to_path_buf(),
            ranges,
            sticks: Sticks::default(),
            wish: Wish::default(),
            used: false,
        })
    }

    /// Path of the gamepad.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The accumulated steering command, `seconds` after the last call. `None` until the gamepad is
    /// first used.
    ///
    /// # Errors
    /// When the gamepad is unplugged.
    pub fn wish(&mut self, seconds: f64) -> Result<Option<Wish>, HardwareError> {
        match self.device.fetch_events() {
            Ok(events) => {
                for event in events {
                    match event.destructure() {
                        EventSummary::AbsoluteAxis(_, axis, value) => {
                            let Some(at) = AXES.iter().position(|own| *own == axis) else {
                                continue;
                            };
                            self.sticks.axes[at] = place(value.into(), self.ranges[at], at);
                        }
                        EventSummary::Key(_, key, value) => {
                            if let Some(at) = KEYS.iter().position(|own| *own == key) {
                                self.sticks.keys[at] = value != 0;
                            }
                        }
                        _ => {}
                    }
                }
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => {
                return Err(HardwareError::Line {
                    path: self.path.clone(),
                    doing: "reading the gamepad",
                    what: error.to_string(),
                });
            }
        }
        let before = self.wish;
        self.sticks.add_to(&mut self.wish, seconds);
        self.used |= self.wish != before;
        Ok(self.used.then_some(self.wish))
    }
}

/// Normalised position of an axis: −1 to 1, a trigger 0 to 1.
fn place(value: f64, [low, high]: [f64; 2], axis: usize) -> f64 {
    let share = (value - low) / (high - low).max(1.0);
    let share = share.clamp(0.0, 1.0);
    if axis == TRIGGER_AXIS {
        share
    } else {
        2.0 * share - 1.0
    }
}

fn is_gamepad(device: &Device) -> bool {
    let has = |key| {
        device
            .supported_keys()
            .is_some_and(|keys| keys.contains(key))
    };
    let stick = device
        .supported_absolute_axes()
        .is_some_and(|axes| axes.contains(Axis::ABS_X) && axes.contains(Axis::ABS_Y));
    has(KeyCode::BTN_SOUTH) && stick
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sticks_move_the_documented_axes_and_are_neutral_in_their_middle() {
        let mut wish = Wish::default();
        let mut sticks = Sticks::default();
        sticks.axes[0] = 0.1;
        sticks.add_to(&mut wish, 1.0);
        assert_eq!(wish, Wish::default(), "inside the dead middle");
        sticks.axes = [1.0, -1.0, 0.0, -1.0, 0.9, 0.0, -1.0];
        sticks.keys[1] = true;
        sticks.keys[5] = true;
        sticks.add_to(&mut wish, 0.5);
        let way = wish.moved_m.map(|part| (part * 1e3).round() as i32);
        assert_eq!(way, [30, 30, -30], "mm right, up, deeper");
        assert!(wish.scope_turned_rad[1] > 0.1 && wish.scope_advanced_m > 0.0);
        assert!(wish.buttons.contains(Buttons::GRASP) && wish.switches.coagulate);
        assert!(!wish.switches.cut);
    }

    #[test]
    fn axes_of_any_range_are_scaled_to_one() {
        for (value, range, axis, share) in [
            (0.0, [0.0, 255.0], 0, -1.0),
            (255.0, [0.0, 255.0], 0, 1.0),
            (1023.0, [0.0, 1023.0], TRIGGER_AXIS, 1.0),
            // An empty range must not divide by zero.
            (7.0, [3.0, 3.0], 0, 1.0),
        ] {
            let placed = place(value, range, axis);
            assert!((placed - share).abs() < 1e-9, "{value}: {placed}");
        }
    }

    #[test]
    fn device_that_is_no_gamepad_is_refused_by_name() {
        let error = Gamepad::open("/dev/null".as_ref()).unwrap_err();
        assert!(error.to_string().contains("/dev/null"), "{error}");
    }
}
