//! Forces of tissue on the tools.

use crate::math::Vec3;
use crate::tool::Tool;

/// Force at a place where a tool touches tissue or the other tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactForce {
    /// The tool.
    pub(crate) tool: Tool,
    /// The organ that the tool touches; `None` if it touches the other tool.
    pub(crate) organ: Option<u8>,
    /// Contact point on the tool, world frame, m.
    pub(crate) at_m: Vec3,
    /// Unit vector from tissue (or the other tool) to this tool.
    pub(crate) normal: Vec3,
    /// Force of tissue on tool along the normal, N.
    pub(crate) force_n: f32,
    /// Stiffness along the normal, N/m.
    pub(crate) stiffness_n_m: f32,
    /// Friction of tissue on tool, across the normal, N.
    pub(crate) friction_n: Vec3,
    /// Stiffness of the friction, N/m; 0 while the contact slides.
    pub(crate) friction_stiffness_n_m: f32,
}

impl ContactForce {
    /// Whole force of tissue on tool, N.
    pub(crate) fn whole_force_n(&self) -> Vec3 {
        self.normal * self.force_n + self.friction_n
    }
}

/// Pull of held tissue on the instrument's jaws. It is not a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pull {
    /// Point of the pull, world frame, m.
    pub(crate) at_m: Vec3,
    /// Force on the jaws, world frame, N.
    pub(crate) force_n: Vec3,
    /// Stiffness against a slow pull: grip and tissue in series, N/m.
    pub(crate) stiffness_n_m: f32,
    /// Stiffness of the grip alone, N/m.
    pub(crate) grip_n_m: f32,
}
