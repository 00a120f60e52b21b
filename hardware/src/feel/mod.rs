//! Tests axes, units and signs of positions and forces, before anybody trusts a device.
//!
//! A person moves the handle and says in which direction it pushes. A program with a sensor may do
//! both. Forces are at most 0.5 N, except one push of 2 N. A force that opens or shuts the handle
//! is at most 1 N. The test ends a force when the handle moves too far or too fast.

mod bench;
mod fingers;
mod moves;
mod pushes;
mod response;
mod silence;

use rt_core::math::Vec3;
use rt_core::port::HapticDevice;
use rt_core::time::TimeNs;

use crate::conformance::Report;
use bench::Bench;

pub use bench::EndReason;
pub use fingers::COUNT as SQUEEZES;
pub use moves::COUNT as MOVES;
pub use pushes::COUNT as PUSHES;
pub use response::Point;

/// Force of a push, N: above the friction of a good handle, and harmless.
pub const PUSH_N: f32 = 0.3;
/// Length of a move, m: a third of the smallest usual workspace.
const MOVE_M: f32 = 0.05;
/// Largest length of a move as a share of the workspace's radius.
const MOVE_SHARE: f32 = 0.5;

/// A direction in the base frame, as the person sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Positive x.
    Right,
    /// Negative x.
    Left,
    /// Positive y.
    Up,
    /// Negative y.
    Down,
    /// Positive z.
    Towards,
    /// Negative z.
    Away,
}

impl Direction {
    /// All directions.
    pub const ALL: [Self; 6] = [
        Self::Right,
        Self::Left,
        Self::Up,
        Self::Down,
        Self::Towards,
        Self::Away,
    ];

    /// Words for a person.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Right => "to the right",
            Self::Left => "to the left",
            Self::Up => "up",
            Self::Down => "down",
            Self::Towards => "towards you",
            Self::Away => "away from you",
        }
    }

    /// Name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
            Self::Up => "up",
            Self::Down => "down",
            Self::Towards => "towards",
            Self::Away => "away",
        }
    }

    /// Unit vector in the base frame.
    #[must_use]
    pub fn vector(self) -> Vec3 {
        match self {
            Self::Right => Vec3::x(),
            Self::Left => -Vec3::x(),
            Self::Up => Vec3::y(),
            Self::Down => -Vec3::y(),
            Self::Towards => Vec3::z(),
            Self::Away => -Vec3::z(),
        }
    }

    /// Direction nearest to `vector`, and the share of the vector's length along that direction.
    #[must_use]
    pub fn nearest(vector: &Vec3) -> (Self, f32) {
        let along = |it: Self| it.vector().dot(vector);
        let first = (Self::Right, along(Self::Right));
        let (best, length) = Self::ALL.into_iter().fold(first, |best, it| {
            let length = along(it);
            if length > best.1 { (it, length) } else { best }
        });
        (best, length / vector.norm().max(f32::MIN_POSITIVE))
    }
}

/// A step of the test, as the guide shows it to the person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Move the handle by `way_m` in this direction, then say that it is done.
    Move {
        /// Direction of the move.
        direction: Direction,
        /// Length of the move, m.
        way_m: f32,
    },
    /// Hold the handle loosely in the middle, then say that it is done.
    Hold,
    /// The handle pushes now.
    Push {
        /// Size of the force, N. The person must find out its direction.
        force_n: f32,
    },
    /// Shut the handle fully, then say that it is done.
    Shut,
    /// Open the handle fully, then say that it is done.
    Open,
    /// Hold the handle half open with loose fingers, then say that it is done.
    HoldFingers,
    /// The handle pushes the fingers now.
    PushFingers {
        /// Size of the force, N. The person must find out its sign.
        force_n: f32,
    },
    /// Stand the handle's tip on a scale, then say that it is done.
    Scale,
    /// The handle presses down on the scale now. Say that it is done once the scale is read.
    Press {
        /// Size of the force, N.
        force_n: f32,
    },
    /// The handle pushes back and forth along x now.
    Response,
    /// Hold the handle firmly in the middle, then say that it is done.
    HoldFirmly,
    /// Hold the handle loosely in the middle before it pushes and Calot falls silent, then say
    /// that it is done.
    HoldForSilence,
    /// The handle pushes now; then Calot sends nothing more.
    PushAndFallSilent {
        /// Size of the force, N.
        force_n: f32,
    },
}

/// Answer to the question after a push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// The person felt this direction.
    Felt(Direction),
    /// A sensor measured this force, base frame, N.
    Measured(Vec3),
    /// Nothing was felt.
    Nothing,
}

/// Answer to the question after a push of the fingers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Squeezed {
    /// The handle opened.
    Open,
    /// The handle shut.
    Shut,
    /// A sensor measured this force, N; positive opens.
    Measured(f32),
    /// Nothing was felt.
    Nothing,
}

impl Squeezed {
    /// Sign of a push along the opening: 1 opens, −1 shuts. A measured force has its own sign, so
    /// it gives 1.
    const fn sign(self) -> f32 {
        match self {
            Self::Shut => -1.0,
            _ => 1.0,
        }
    }

    /// Words for a person.
    const fn words(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Shut => "shut",
            Self::Measured(_) => "by a sensor",
            Self::Nothing => "nothing",
        }
    }
}

/// Answer to the question whether the handle still pushes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Left {
    /// It still pushes.
    Pushes,
    /// It pushes no more.
    Nothing,
    /// A sensor measures this force now, base frame, N.
    Measured(Vec3),
}

/// Question that the guide asks the person.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Direction in which the handle pushed.
    Pushed,
    /// Direction in which the handle pushed the fingers: open or shut.
    Squeezed,
    /// Is there a scale to press on?
    HasScale,
    /// Reading of the scale, N.
    Pressed,
    /// Does the handle still push, although Calot sends nothing?
    Left,
}

/// State of the device at one moment, to be shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Live {
    /// Position of the handle in the base frame, m. `None`: there was no sample yet.
    pub at_m: Option<Vec3>,
    /// Velocity as the device reports it, m/s. `None`: the device measures none.
    pub velocity_m_s: Option<Vec3>,
    /// Commanded force, N.
    pub force_n: Vec3,
    /// Opening of the handle, 0 shut to 1 wide open. `None`: the device measures none.
    pub opening: Option<f32>,
    /// Commanded force that opens the handle, N.
    pub opening_n: f32,
}

/// Interface to the person, or to a program with a sensor, who takes the test.
pub trait Guide {
    /// Shows a question. This method must not wait for the answer: see [`has_answer`].
    ///
    /// [`has_answer`]: Self::has_answer
    fn ask(&mut self, _question: Question) {}
    /// True once the question that was shown last is answered. The method is called every
    /// millisecond; meanwhile the device gets zero force. A guide whose [`Self::pushed`] and
    /// similar methods wait for the answer always returns true.
    fn has_answer(&mut self) -> bool {
        true
    }
    /// Takes the device's state. The method is called every millisecond; it must not wait.
    fn live(&mut self, _live: &Live) {}
    /// Shows the next step.
    fn tell(&mut self, step: &Step);
    /// True once the step that was shown last is done. The method is called every millisecond.
    fn is_done(&mut self) -> bool;
    /// Returns the direction in which the handle pushed. The call may wait.
    fn pushed(&mut self) -> Answer;
    /// Returns how the handle pushed the fingers. The call may wait.
    fn squeezed(&mut self) -> Squeezed;
    /// True if there is a scale to press on. The call may wait.
    fn has_scale(&mut self) -> bool;
    /// Returns the reading of the scale, N. The call may wait. `None` if it could not be read.
    fn pressed_n(&mut self) -> Option<f32>;
    /// Returns the force that the handle still renders while Calot sends nothing. The call may
    /// wait. `None` if nobody said.
    fn left(&mut self) -> Option<Left>;
    /// Waits for the next millisecond and returns the time.
    fn wait(&mut self) -> TimeNs;
    /// True if the test must end now.
    fn is_stopped(&self) -> bool;
}

/// Results of the test.
#[derive(Debug, Clone)]
pub struct Felt {
    /// The checks.
    pub report: Report,
    /// Recorded force and position during the force steps, the sine and the chirp.
    pub response: Vec<Point>,
}

/// Runs all steps of the test. `seed` decides the order of the pushes, so that the person does not
/// know this order.
pub fn feel(device: &mut dyn HapticDevice, guide: &mut dyn Guide, seed: u64) -> Felt {
    let identity = device.identity();
    let mut felt = Felt {
        report: Report::new(&match identity.name.as_str() {
            "" => "haptic device".to_owned(),
            name => format!("haptic device \"{name}\", serial {}", identity.serial),
        }),
        response: Vec::new(),
    };
    let mut bench = Bench::new(device, guide);
    if let Err(broken) = run(&mut bench, &mut felt, seed) {
        felt.report.judge("end", false, broken.words());
    }
    bench.rest();
    felt
}

fn run(bench: &mut Bench<'_>, felt: &mut Felt, seed: u64) -> Result<(), EndReason> {
    let radius_m = bench.capabilities().workspace_radius_m;
    let way_m = MOVE_M.min(MOVE_SHARE * radius_m);
    moves::test(bench, &mut felt.report, way_m)?;
    pushes::test(bench, &mut felt.report, seed)?;
    fingers::test(bench, &mut felt.report, seed)?;
    pushes::test_scale(bench, &mut felt.report)?;
    response::test(bench, &mut felt.report, &mut felt.response)?;
    pushes::test_hard(bench, &mut felt.report, seed)?;
    silence::test(bench, &mut felt.report)
}
