//! The kinds of hand at the emulated handle.

use rt_core::math::Vec3;

use super::touch::Grip;

/// Hand at the emulated handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Holding {
    /// The scripted hand, or a person who steers it.
    #[default]
    Script,
    /// A hand that rests where the script begins, until a person steers it.
    Parked,
    /// Nobody: the handle is free.
    Nobody,
    /// Two fingers that tap onto the middle of the workspace from above and press, again and again.
    /// In the same way they squeeze a handle that opens.
    Press,
}

/// Two fingers that hardly hold the handle.
const FINGERS: Grip = Grip {
    stiffness_n_m: 30.0,
    damping_n_s_m: 0.2,
};
/// Height from which the fingers come, m. In the middle of the workspace their grip pulls the
/// handle up with 0.6 N, against 0.26 N of dry friction.
const ABOVE_M: f32 = 0.02;
/// Depth to which the fingers pull the handle, m. In the middle of the workspace they pull it down
/// with 0.5 N.
const BELOW_M: f32 = 0.016;
/// Length of a round, s.
const ROUND_S: f64 = 4.0;
/// Time in which the fingers come down, s.
const DOWN_S: f64 = 0.5;
/// Time in the round at which the fingers begin to go up, s.
const LIFTS_AT_S: f64 = 3.0;
/// Time in which the fingers go up, s.
const UP_S: f64 = 0.3;

impl Holding {
    /// Grip on the handle, and position of the handle at the start. `None`: those of the script.
    pub(super) fn grip(self) -> Option<(Grip, Vec3)> {
        match self {
            Self::Script | Self::Parked => None,
            Self::Nobody => Some((Grip::NONE, Vec3::zeros())),
            Self::Press => Some((FINGERS, Vec3::y() * ABOVE_M)),
        }
    }

    /// Grip of the fingers in a handle that opens.
    pub(super) fn fingers(self) -> Grip {
        self.grip().map_or(Grip::STYLUS, |it| it.0)
    }

    /// Position to which the hand pulls the handle, m. `None`: that of the script.
    pub(super) fn target_m(self, at_s: f64) -> Option<Vec3> {
        match self {
            Self::Script | Self::Parked => None,
            Self::Nobody => Some(Vec3::zeros()),
            Self::Press => Some(pressing_m(at_s)),
        }
    }

    /// Position to which the fingers pull a handle that opens, m from half open. `None`: that of
    /// the script.
    pub(super) fn fingers_m(self, at_s: f64) -> Option<f32> {
        self.target_m(at_s).map(|it| it.y)
    }
}

/// Position to which the fingers of [`Holding::Press`] pull the handle, m.
pub(crate) fn pressing_m(at_s: f64) -> Vec3 {
    let phase_s = at_s.rem_euclid(ROUND_S);
    let up = (phase_s - LIFTS_AT_S) / UP_S;
    let down = (phase_s / DOWN_S).min(1.0 - up).clamp(0.0, 1.0) as f32;
    Vec3::y() * (ABOVE_M - (ABOVE_M + BELOW_M) * down)
}
