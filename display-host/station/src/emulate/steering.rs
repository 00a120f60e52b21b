//! Steering of the emulated hand by a display's mouse and keyboard, a scripted surgeon's messages
//! or a gamepad. A [`Wish`] holds the sum of the requested motion since the start, and the pressed
//! buttons and switches. The first wish ends the script.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use hardware::emulate::{Gamepad, Wish};
use hardware::rig::wire::Switches;
use rt_core::port::Buttons;
use rt_process::rehearsal::wish as said;
use rt_process::time_driver::monotonic_ns;
use shared_mem::message::HandMsg;
use shared_mem::service::{HandReceiver, Station};

use super::args::EmulateArgs;
use crate::args::GamepadName;
use crate::problem::Problem;
use crate::say;

/// A display that has sent nothing for this long no longer steers the hand, ns.
const SILENT_NS: u64 = 500_000_000;
/// Interval between two searches for a gamepad.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// The display and the gamepad that may steer the hand, and the sum of their motion.
pub(super) struct Steering {
    display: Option<HandReceiver>,
    message: Option<HandMsg>,
    /// Sum of the motion by earlier displays.
    earlier: Wish,
    gamepad: Option<Gamepad>,
    /// Receives each gamepad that [`look_for_gamepads`] finds.
    found: Option<Receiver<Gamepad>>,
    polled: Instant,
    /// Sum of the motion by earlier gamepads.
    earlier_gamepads: Wish,
    /// Sum of the motion by all gamepads.
    latest: Wish,
}

impl Steering {
    pub(super) fn new(args: &EmulateArgs) -> Result<Self, Problem> {
        let station = args.station.as_deref().map(Station::new).transpose()?;
        let gamepad = match &args.gamepad.gamepad {
            GamepadName::Path(path) => Some(Gamepad::open(path)?),
            GamepadName::Auto | GamepadName::Off => None,
        };
        Ok(Self {
            display: station.as_ref().map(HandReceiver::open).transpose()?,
            message: None,
            earlier: Wish::default(),
            gamepad,
            found: (args.gamepad.gamepad == GamepadName::Auto).then(look_for_gamepads),
            polled: Instant::now(),
            earlier_gamepads: Wish::default(),
            latest: Wish::default(),
        })
    }

    /// Sum of all requested motion since the start. Returns `None` if nobody steers now.
    pub(super) fn wish(&mut self) -> Option<Wish> {
        let seconds = self.polled.elapsed().as_secs_f64().min(0.1);
        self.polled = Instant::now();
        if let Some(newer) = self.display.as_ref().and_then(HandReceiver::newest) {
            match &self.message {
                Some(last) if last.began_ns != newer.began_ns => {
                    self.earlier = both(&self.earlier, &let_go(&said(last)));
                }
                _ => {}
            }
            self.message = Some(newer);
        }
        let now_ns = monotonic_ns();
        let is_heard = |message: &HandMsg| now_ns.abs_diff(message.at_ns) < SILENT_NS;
        let display = self.message.map(|message| {
            let said = both(&self.earlier, &said(&message));
            (said, is_heard(&message))
        });
        let gamepad = self.gamepad(seconds);
        // The motion of a source that falls silent stays in the sum, so that the hand does not jump
        // back.
        match (display, gamepad) {
            (None, None) | (Some((_, false)), None) => None,
            (None, gamepad) => gamepad,
            (Some((said, true)), gamepad) => {
                Some(both(&said, &gamepad.unwrap_or(self.earlier_gamepads)))
            }
            (Some((said, false)), Some(gamepad)) => Some(both(&let_go(&said), &gamepad)),
        }
    }

    fn gamepad(&mut self, seconds: f64) -> Option<Wish> {
        if self.gamepad.is_none() {
            self.gamepad = self.found.as_ref().and_then(|found| found.try_recv().ok());
        }
        match self.gamepad.as_mut()?.wish(seconds) {
            Ok(wish) => {
                let wish = both(&self.earlier_gamepads, &wish?);
                self.latest = wish;
                Some(wish)
            }
            Err(error) => {
                say::note(format_args!("calot: {error}"));
                self.gamepad = None;
                self.earlier_gamepads = let_go(&self.latest);
                None
            }
        }
    }
}

/// Looks for a gamepad in a thread of its own, because it takes long to open every input device.
/// The thread looks for the next gamepad only after [`Steering`] has taken the last one.
fn look_for_gamepads() -> Receiver<Gamepad> {
    let (sender, found): (SyncSender<Gamepad>, _) = sync_channel(0);
    std::thread::spawn(move || {
        loop {
            if let Some(gamepad) = Gamepad::find().and_then(|path| Gamepad::open(&path).ok()) {
                let path = gamepad.path().to_path_buf();
                if sender.send(gamepad).is_err() {
                    return;
                }
                say::note(format_args!(
                    "calot: the gamepad {} leads the hand once it is used",
                    path.display()
                ));
            }
            std::thread::sleep(LOOK_EVERY);
        }
    });
    found
}

/// The wish with the same motion, and with all buttons and pedal switches released.
fn let_go(wish: &Wish) -> Wish {
    Wish {
        buttons: Buttons(0),
        switches: Switches::default(),
        ..*wish
    }
}

/// Sum of the motion of both. A button or switch is pressed if it is pressed in one of them.
fn both(one: &Wish, other: &Wish) -> Wish {
    let [a, b] = [one, other];
    Wish {
        moved_m: [0, 1, 2].map(|i| a.moved_m[i] + b.moved_m[i]),
        rolled_rad: a.rolled_rad + b.rolled_rad,
        scope_turned_rad: [0, 1].map(|i| a.scope_turned_rad[i] + b.scope_turned_rad[i]),
        scope_advanced_m: a.scope_advanced_m + b.scope_advanced_m,
        buttons: Buttons(a.buttons.0 | b.buttons.0),
        switches: Switches {
            cut: a.switches.cut || b.switches.cut,
            coagulate: a.switches.coagulate || b.switches.coagulate,
            camera_lock: a.switches.camera_lock || b.switches.camera_lock,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::GamepadArgs;

    fn args(station: &str) -> EmulateArgs {
        EmulateArgs {
            dir: "unused".into(),
            scene: "unused".into(),
            seed: 1,
            station: Some(station.to_owned()),
            gamepad: GamepadArgs {
                gamepad: GamepadName::Off,
            },
            mistake: None,
            handle: crate::emulate::args::HandleName::Stylus,
            hand: crate::emulate::args::HandName::Script,
            tick_core: None,
            with_parent: None,
        }
    }

    fn message(began_ns: u64, right_m: f64) -> HandMsg {
        HandMsg {
            at_ns: monotonic_ns(),
            began_ns,
            moved_m: [right_m, 0.0, 0.0],
            buttons: 1,
            switches: 2,
            ..bytemuck::Zeroable::zeroed()
        }
    }

    fn millimetres(wish: &Wish) -> i64 {
        (wish.moved_m[0] * 1e3).round() as i64
    }

    #[test]
    fn the_motion_of_a_display_is_added_to_that_of_earlier_displays() {
        let name = format!("lead-{}", std::process::id());
        let mut steering = Steering::new(&args(&name)).unwrap();
        assert_eq!(steering.wish(), None, "nobody steers");
        let station = Station::new(&name).unwrap();
        let sender = shared_mem::service::HandSender::open(&station).unwrap();
        assert!(sender.send(message(1, 0.02)));
        let wish = steering.wish().unwrap();
        assert_eq!(millimetres(&wish), 20);
        assert!(wish.switches.coagulate && wish.buttons.contains(Buttons::GRASP));
        // Another display starts its sums from zero: the 20 mm of the first display remain.
        assert!(sender.send(message(2, 0.0)));
        assert_eq!(millimetres(&steering.wish().unwrap()), 20);
        assert!(sender.send(message(2, -0.01)));
        assert_eq!(millimetres(&steering.wish().unwrap()), 10);
        let nonsense = HandMsg {
            moved_m: [f64::NAN, f64::INFINITY, 0.0],
            ..message(2, 0.0)
        };
        assert!(sender.send(nonsense));
        assert_eq!(millimetres(&steering.wish().unwrap()), 20);
        // A silent display does not steer, nor does one with a time stamp in the future.
        let early = HandMsg {
            at_ns: u64::MAX,
            ..message(2, 0.5)
        };
        assert!(sender.send(early));
        assert_eq!(steering.wish(), None);
        let old = HandMsg {
            at_ns: 1,
            ..message(2, 0.5)
        };
        assert!(sender.send(old));
        assert_eq!(steering.wish(), None);
        let second = shared_mem::service::HandSender::open(&station).unwrap_err();
        assert!(second.to_string().contains("let go"), "{second}");
    }
}
