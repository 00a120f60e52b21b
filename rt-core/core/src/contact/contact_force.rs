//! Forces of tissue on the tools.

use crate::math::Vec3;
use crate::tool::Tool;

/// A place where a tool touches tissue or the other tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactForce {
    /// Which tool.
    pub(crate) tool: Tool,
    /// The organ that it touches; none if that is the other tool.
    pub(crate) organ: Option<u8>,
    /// Where it touches the tool, world frame, m.
    pub(crate) at_m: Vec3,
    /// From tissue to tool.
    pub(crate) normal: Vec3,
    /// Force of tissue on tool along the normal, N.
    pub(crate) force_n: f32,
    /// Stiffness of that force, N/m.
    pub(crate) stiffness_n_m: f32,
    /// Friction of tissue on tool, across the normal, N.
    pub(crate) friction_n: Vec3,
    /// Stiffness of the friction while it sticks, N/m.
    pub(crate) friction_stiffness_n_m: f32,
}

impl ContactForce {
    /// Of tissue on tool, N.
    pub(crate) fn whole_force_n(&self) -> Vec3 {
        self.normal * self.force_n + self.friction_n
    }
}

/// A pull of tissue on the instrument that is no contact: what the jaws hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pull {
    /// Where, world frame, m.
    pub(crate) at_m: Vec3,
    /// World frame, N.
    pub(crate) force_n: Vec3,
    /// As a slow hand meets it, N/m.
    pub(crate) stiffness_n_m: f32,
    /// Of the grip alone, N/m.
    pub(crate) grip_n_m: f32,
}
