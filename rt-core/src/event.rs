//! What happened in a tick that somebody outside may want to know.

use crate::math::Vec3;

/// Kind of an [`Event`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The instrument began to touch an organ; value: force on the hand, N.
    Contact,
    /// It left it; value: 0.
    Release,
    /// Jaws closed on tissue; value: spheres held.
    Grasp,
    /// Jaws let go; value: spheres that were held.
    LetGo,
    /// A fault was raised; value: [`crate::fault::Fault::code`].
    Fault,
    /// Electrosurgery: value 1 cut, 2 coagulate, 0 off.
    Electro,
}

/// An event of one tick. The tick's number and time stand in [`crate::sim::TickView`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// What.
    pub kind: EventKind,
    /// Organ's index in the scene, if it concerns one.
    pub organ: Option<u32>,
    /// Where, world frame, m.
    pub at_m: Vec3,
    /// Depends on the kind.
    pub value: f32,
}
