//! Mouse and keyboard instead of a haptic device. They lead the emulated hand, so that tissue
//! pushes back and the whole station runs as with a real device.

use std::time::{Duration, Instant};

use shared_mem::message::HandMsg;
use shared_mem::service::Station;
use shared_mem::words::{Buttons, Switches};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

use super::messenger::{Messenger, SEND_EVERY};
use super::refusal::Refusal;
use crate::latency::now_ns;

/// Motion of the tip per count of the mouse, m.
const TIP_M_COUNT: f64 = 0.08e-3;
/// Motion of the tip per notch of the wheel, m.
const TIP_M_NOTCH: f64 = 3.0e-3;
/// Turn of the endoscope per count of the mouse, rad.
const SCOPE_RAD_COUNT: f64 = 1.0e-3;
/// Advance of the endoscope per notch of the wheel, m.
const SCOPE_M_NOTCH: f64 = 2.0e-3;
/// Pixels of a touch pad's scrolling per notch.
const NOTCH_PIXELS: f64 = 40.0;
/// Speed of the tip under a held key, m/s. With Shift all speeds are a quarter.
const TIP_M_S: f64 = 0.04;
/// Speed of the instrument's roll under a held key, rad/s.
const ROLL_RAD_S: f64 = 1.2;
/// Speed of the endoscope's turn under a held key, rad/s.
const SCOPE_RAD_S: f64 = 0.3;
/// Speed of the endoscope's advance under a held key, m/s.
const SCOPE_M_S: f64 = 0.02;
/// Time after which a pressed pedal must act. One message to the hand and one picture of a fast
/// computer take less than a tenth of it.
const ACTS_WITHIN: Duration = Duration::from_millis(500);

/// Keys that lead the hand. All others belong to the interface.
const KEYS: [KeyCode; 16] = [
    KeyCode::ArrowLeft,
    KeyCode::ArrowRight,
    KeyCode::ArrowDown,
    KeyCode::ArrowUp,
    KeyCode::PageDown,
    KeyCode::PageUp,
    KeyCode::Comma,
    KeyCode::Period,
    KeyCode::Space,
    KeyCode::KeyC,
    KeyCode::KeyV,
    KeyCode::KeyL,
    KeyCode::ShiftLeft,
    KeyCode::ShiftRight,
    KeyCode::ControlLeft,
    KeyCode::ControlRight,
];

/// Input of mouse and keyboard while they lead the hand.
#[derive(Debug)]
struct Leading {
    /// The next message. Its motions are sums since the instrument was taken.
    message: HandMsg,
    /// For each of [`KEYS`]: true while it is held.
    held: [bool; KEYS.len()],
    /// True while the mouse button that closes the jaws is held.
    mouse_jaws: bool,
    /// True while the mouse button that coagulates is held.
    mouse_coagulates: bool,
    /// True while the middle button makes the mouse move the endoscope.
    mouse_scope: bool,
    lead: Lead,
}

/// Settings of mouse and keyboard as the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lead {
    /// True if the left and right buttons of the mouse change places.
    pub(super) left_handed: bool,
    /// Factor of every motion.
    pub(super) sensitivity: f64,
}

impl Default for Lead {
    fn default() -> Self {
        Self {
            left_handed: false,
            sensitivity: 1.0,
        }
    }
}

impl Leading {
    fn new(began_ns: u64) -> Self {
        Self {
            message: HandMsg {
                began_ns,
                ..bytemuck::Zeroable::zeroed()
            },
            held: [false; KEYS.len()],
            mouse_jaws: false,
            mouse_coagulates: false,
            mouse_scope: false,
            lead: Lead::default(),
        }
    }

    fn holds(&self, key: KeyCode) -> bool {
        let held = KEYS.iter().zip(&self.held);
        held.into_iter().any(|(own, held)| *own == key && *held)
    }

    fn holds_either(&self, one: KeyCode, other: KeyCode) -> bool {
        self.holds(one) || self.holds(other)
    }

    /// Takes a key. Returns true if it leads the hand.
    fn key(&mut self, key: KeyCode, down: bool) -> bool {
        let Some(at) = KEYS.iter().position(|own| *own == key) else {
            return false;
        };
        if let Some(held) = self.held.get_mut(at) {
            *held = down;
        }
        true
    }

    fn button(&mut self, button: MouseButton, down: bool) {
        let is_jaws = match self.lead.left_handed {
            true => MouseButton::Right,
            false => MouseButton::Left,
        };
        match button {
            MouseButton::Left | MouseButton::Right if button == is_jaws => self.mouse_jaws = down,
            MouseButton::Left | MouseButton::Right => self.mouse_coagulates = down,
            MouseButton::Middle => self.mouse_scope = down,
            _ => {}
        }
    }

    /// Takes a motion of the mouse, counts. Right and down are positive.
    fn mouse(&mut self, motion: [f64; 2]) {
        let [right, down] = motion.map(|it| it * self.lead.sensitivity);
        if self.mouse_scope {
            self.message.scope_turned_rad[0] -= right * SCOPE_RAD_COUNT;
            self.message.scope_turned_rad[1] -= down * SCOPE_RAD_COUNT;
        } else {
            self.message.moved_m[0] += right * TIP_M_COUNT;
            self.message.moved_m[1] -= down * TIP_M_COUNT;
        }
    }

    /// Takes a turn of the wheel away from the user, in notches.
    fn wheel(&mut self, notches: f64) {
        let notches = notches * self.lead.sensitivity;
        if self.mouse_scope {
            self.message.scope_advanced_m += notches * SCOPE_M_NOTCH;
        } else {
            self.message.moved_m[2] -= notches * TIP_M_NOTCH;
        }
    }

    /// Applies the keys and buttons that were held for the last `seconds`.
    fn advance(&mut self, seconds: f64) {
        use KeyCode as Key;
        let controls = self.holds_either(Key::ControlLeft, Key::ControlRight);
        let slow = self.holds_either(Key::ShiftLeft, Key::ShiftRight);
        let seconds = self.lead.sensitivity * if slow { 0.25 * seconds } else { seconds };
        let way = |less, more| {
            seconds * f64::from(i8::from(self.holds(more)) - i8::from(self.holds(less)))
        };
        let right = way(Key::ArrowLeft, Key::ArrowRight);
        let up = way(Key::ArrowDown, Key::ArrowUp);
        let deeper = way(Key::PageDown, Key::PageUp);
        let roll = way(Key::Comma, Key::Period);
        let message = &mut self.message;
        message.rolled_rad -= roll * ROLL_RAD_S;
        if controls {
            message.scope_turned_rad[0] -= right * SCOPE_RAD_S;
            message.scope_turned_rad[1] += up * SCOPE_RAD_S;
            message.scope_advanced_m += deeper * SCOPE_M_S;
        } else {
            message.moved_m[0] += right * TIP_M_S;
            message.moved_m[1] += up * TIP_M_S;
            message.moved_m[2] -= deeper * TIP_M_S;
        }
        let grasps = self.mouse_jaws || self.holds(Key::Space);
        let coagulates = self.mouse_coagulates || self.holds(Key::KeyV);
        let pedals = Switches::CUT.when(self.holds(Key::KeyC))
            | Switches::COAGULATE.when(coagulates)
            | Switches::CAMERA_LOCK.when(self.holds(Key::KeyL));
        self.message.buttons = Buttons::GRASP.when(grasps).bits();
        self.message.switches = pedals.bits();
    }
}

/// Control of the instrument by mouse and keyboard.
#[derive(Debug)]
pub(super) struct Operate {
    station: Station,
    /// Messenger and input, while mouse and keyboard lead the instrument.
    on: Option<(Messenger, Leading)>,
    /// Time up to which held keys have moved the hand.
    advanced: Instant,
    /// Pedals that are pressed, and the time since which they are.
    pressed: (Switches, Instant),
    lead: Lead,
}

impl Operate {
    pub(super) fn new(station: &Station) -> Self {
        Self {
            station: station.clone(),
            on: None,
            advanced: Instant::now(),
            pressed: (Switches::NONE, Instant::now()),
            lead: Lead::default(),
        }
    }

    pub(super) fn is_on(&self) -> bool {
        self.on.is_some()
    }

    /// Pedals that are pressed for so long that they must act by now.
    pub(super) fn pressed(&self) -> Switches {
        let (switches, since) = self.pressed;
        switches.when(self.is_on() && since.elapsed() >= ACTS_WITHIN)
    }

    /// Sets how mouse and keyboard lead.
    pub(super) fn set(&mut self, lead: Lead) {
        self.lead = lead;
        if let Some((_, leading)) = &mut self.on {
            leading.lead = lead;
        }
    }

    /// Takes or releases the instrument. Returns the reason if taking it fails.
    pub(super) fn toggle(&mut self) -> Result<(), Refusal> {
        if self.on.is_some() {
            self.let_go();
            return Ok(());
        }
        let leading = Leading {
            lead: self.lead,
            ..Leading::new(now_ns())
        };
        let messenger = Messenger::begin(&self.station, leading.message)?;
        self.advanced = Instant::now();
        self.on = Some((messenger, leading));
        Ok(())
    }

    /// Releases the instrument if it is taken. The pedal goes up at once, and the jaws stay as they
    /// are.
    pub(super) fn let_go(&mut self) {
        self.on = None;
        self.pressed.0 = Switches::NONE;
    }

    /// Takes input that leads the hand. Returns true if the interface must not see it.
    pub(super) fn take_event(&mut self, event: &WindowEvent) -> bool {
        let Some((_, leading)) = &mut self.on else {
            return false;
        };
        match event {
            WindowEvent::KeyboardInput { event, .. } => match event.physical_key {
                PhysicalKey::Code(key) => leading.key(key, event.state == ElementState::Pressed),
                PhysicalKey::Unidentified(_) => false,
            },
            WindowEvent::MouseInput { state, button, .. } => {
                leading.button(*button, *state == ElementState::Pressed);
                true
            }
            WindowEvent::MouseWheel { delta, .. } => {
                leading.wheel(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / NOTCH_PIXELS,
                });
                true
            }
            WindowEvent::CursorMoved { .. } => true,
            _ => false,
        }
    }

    /// Takes a raw motion of the mouse, wherever the cursor is.
    pub(super) fn mouse_moved(&mut self, (right, down): (f64, f64)) {
        if let Some((_, leading)) = &mut self.on {
            leading.mouse([right, down]);
        }
    }

    /// Gives a message to the messenger if one is due.
    pub(super) fn send_if_due(&mut self) {
        let since = self.advanced.elapsed();
        let Some((messenger, leading)) = &mut self.on else {
            return;
        };
        if since < SEND_EVERY {
            return;
        }
        self.advanced = Instant::now();
        leading.advance(since.as_secs_f64().min(0.1));
        messenger.say(leading.message);
        let switches = Switches::named(leading.message.switches);
        if switches != self.pressed.0 {
            self.pressed = (switches, self.advanced);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sums of the motions in thousandths of m and rad.
    fn thousandths(leading: &Leading) -> [i64; 6] {
        let message = &leading.message;
        let [x, y, z] = message.moved_m;
        let [yaw, pitch] = message.scope_turned_rad;
        [x, y, z, yaw, pitch, message.scope_advanced_m].map(|part| (part * 1e3).round() as i64)
    }

    #[test]
    fn the_mouse_moves_the_tip_and_with_its_middle_button_the_endoscope() {
        let mut leading = Leading::new(1);
        leading.mouse([100.0, 50.0]);
        leading.wheel(2.0);
        assert_eq!(thousandths(&leading), [8, -4, -6, 0, 0, 0]);
        leading.button(MouseButton::Middle, true);
        leading.mouse([100.0, 0.0]);
        leading.wheel(-1.0);
        assert_eq!(thousandths(&leading), [8, -4, -6, -100, 0, -2]);
        leading.button(MouseButton::Left, true);
        leading.button(MouseButton::Right, true);
        leading.advance(0.0);
        assert_eq!((leading.message.buttons, leading.message.switches), (1, 2));
    }

    #[test]
    fn a_left_hand_has_its_buttons_and_every_motion_its_sensitivity() {
        let mut leading = Leading {
            lead: Lead {
                left_handed: true,
                sensitivity: 0.5,
            },
            ..Leading::new(1)
        };
        leading.mouse([100.0, 50.0]);
        leading.wheel(2.0);
        assert_eq!(thousandths(&leading), [4, -2, -3, 0, 0, 0]);
        leading.key(KeyCode::ArrowRight, true);
        leading.advance(1.0);
        assert_eq!(thousandths(&leading), [24, -2, -3, 0, 0, 0]);
        leading.button(MouseButton::Right, true);
        leading.advance(0.0);
        assert_eq!((leading.message.buttons, leading.message.switches), (1, 0));
        leading.button(MouseButton::Left, true);
        leading.advance(0.0);
        assert_eq!((leading.message.buttons, leading.message.switches), (1, 2));
    }

    #[test]
    fn held_keys_move_and_shift_is_slow() {
        let mut leading = Leading::new(1);
        assert!(leading.key(KeyCode::ArrowRight, true));
        assert!(!leading.key(KeyCode::KeyE, true), "the interface's");
        leading.advance(1.0);
        assert_eq!(thousandths(&leading), [40, 0, 0, 0, 0, 0]);
        leading.key(KeyCode::ShiftLeft, true);
        leading.advance(1.0);
        assert_eq!(thousandths(&leading), [50, 0, 0, 0, 0, 0]);
        leading.key(KeyCode::ArrowRight, false);
        leading.key(KeyCode::ControlLeft, true);
        leading.key(KeyCode::PageUp, true);
        leading.advance(1.0);
        assert_eq!(thousandths(&leading), [50, 0, 0, 0, 0, 5]);
        leading.key(KeyCode::KeyC, true);
        leading.key(KeyCode::Space, true);
        leading.advance(0.0);
        assert_eq!((leading.message.buttons, leading.message.switches), (1, 1));
    }
}
