//! Reference solution: force and torque on a tool as functions of its depth.

use super::wrench::{Wrench, force_rms_pct};

/// Depths, mm.
pub(crate) const DEPTHS_MM: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

/// Force and torque over depth by finite elements.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Curve {
    /// Wrenches on the finer mesh, at the first depths of [`DEPTHS_MM`], up to the last
    /// equilibrium.
    pub(crate) fine: Vec<Wrench>,
    /// Wrenches on the coarser mesh.
    pub(crate) coarse: Vec<Wrench>,
    /// Nodes of the coarser and the finer mesh.
    pub(crate) nodes: [usize; 2],
    /// Version of the mesher that made the meshes.
    pub(crate) mesher: usize,
}

impl Curve {
    /// Root mean square difference between the forces on the two meshes, relative to the finer
    /// mesh, %.
    pub(crate) fn doubt_pct(&self) -> f64 {
        force_rms_pct(&self.coarse, &self.fine)
    }

    /// True if the curve has torques. Older references have forces only.
    pub(crate) fn has_torque(&self) -> bool {
        let is_known = |wrench: &Wrench| wrench.torque_nm.norm().is_finite();
        self.fine.first().is_some_and(is_known)
    }
}
