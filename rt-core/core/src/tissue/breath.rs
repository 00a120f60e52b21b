//! Breathing: the held spheres of an organ follow the diaphragm.

use crate::scene::{Organ, Scene};
use crate::time::TICK_S;
use crate::tissue::{Bodies, Vec3};

impl Bodies {
    /// Leads the held spheres of `organ` to the displacement that the breath has at the end of this
    /// tick. The displacement follows a raised cosine in time; at full inspiration it is
    /// `breath_m`.
    pub(crate) fn breathe(&mut self, scene: &Scene<'_>, organ: &Organ, tick: u64) {
        let breath_s = scene.room.breath_s;
        if breath_s <= 0.0 || organ.breath_m == Vec3::zeros() {
            return;
        }
        let ticks = (breath_s / TICK_S) as u64;
        let phase = (tick % ticks.max(1)) as f32 / ticks.max(1) as f32;
        let share = 0.5 - 0.5 * nalgebra::ComplexField::cos(core::f32::consts::TAU * phase);
        let at_m = organ.breath_m * share;
        let held = (organ.sphere_start..).zip(scene.spheres_of(organ));
        for (sphere, _) in held.filter(|(_, rest)| rest.held) {
            self.lead(sphere, &at_m);
        }
    }
}
