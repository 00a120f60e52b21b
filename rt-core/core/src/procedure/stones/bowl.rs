//! The abdomen below the organs, in which stones that miss them come to rest.
//!
//! It is the lower half of an ellipsoid around the organs at rest, which displays draw as the
//! abdominal wall (`render/cavity.rs` of the display). The organs lie on it, as the duodenum does
//! on the back of the abdomen.

use crate::math::{self, Vec3};
use crate::procedure::stones::touch::Touch;
use crate::scene::Scene;

/// Radii of the ellipsoid in half extents of the organs and the eye, and what is added to them
/// along right, up and back, m. The display has the same numbers.
const WIDER: f32 = 1.45;
const ADDED_M: [f32; 3] = [0.035, 0.02, 0.02];

/// Depth of the bowl below its middle in half extents, and what is added to it, m. The display has
/// the same numbers. No source: in a patient the bowl lies as deep as the duodenum, and the
/// instrument still reaches it (`a_spilled_stone_is_picked_up` of the surgeon).
const DEEPER: f32 = 0.75;
const ADDED_BELOW_M: f32 = 0.01;

/// An ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bowl {
    middle_m: Vec3,
    /// Unit vectors: right, up, back.
    axes: [Vec3; 3],
    radii_m: [f32; 3],
}

impl Bowl {
    /// No ellipsoid: nothing is near it.
    pub(super) const NONE: Self = Self {
        middle_m: Vec3::new(0.0, 0.0, 0.0),
        axes: [
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(0.0, 0.0, 1.0),
        ],
        radii_m: [f32::MAX; 3],
    };

    /// The ellipsoid around the organs at rest. O(spheres).
    pub(super) fn of(scene: &Scene<'_>) -> Self {
        let room = &scene.room;
        let up = math::unit(&-room.gravity_m_s2).unwrap_or_else(Vec3::y);
        let look = room.world_from_camera.rotation * -Vec3::z();
        let level = up * up.dot(&look) - look;
        let back = math::unit(&level).unwrap_or_else(|| math::perpendicular(&up));
        let axes = [up.cross(&back), up, back];
        let eye_m = room.world_from_camera.translation.vector;
        let mut bowl = Self {
            middle_m: Vec3::zeros(),
            axes,
            radii_m: [0.0; 3],
        };
        for ((axis, added_m), radius_m) in axes.iter().zip(ADDED_M).zip(&mut bowl.radii_m) {
            let eye = axis.dot(&eye_m);
            let (mut low, mut high) = (eye, eye);
            for sphere in scene.spheres {
                let at = axis.dot(&sphere.center_m);
                low = low.min(at - sphere.radius_m);
                high = high.max(at + sphere.radius_m);
            }
            bowl.middle_m += axis * (0.5 * (low + high));
            *radius_m = WIDER * 0.5 * (high - low) + added_m;
        }
        let [_, depth_m, _] = &mut bowl.radii_m;
        *depth_m = (*depth_m - ADDED_M[1]) / WIDER * DEEPER + ADDED_BELOW_M;
        bowl
    }

    /// Gap between the bowl and a ball below the bowl's middle; `None` above the middle.
    pub(super) fn touch(&self, at_m: &Vec3, radius_m: f32) -> Option<Touch> {
        let off_m = at_m - self.middle_m;
        let [_, up, _] = &self.axes;
        if off_m.dot(up) > 0.0 {
            return None;
        }
        // f = |p'| is 1 on the ellipsoid, and its gradient leads out.
        let (mut squared, mut gradient) = (0.0, Vec3::zeros());
        for (axis, radius_m) in self.axes.iter().zip(self.radii_m) {
            let share = axis.dot(&off_m) / radius_m;
            squared += share * share;
            gradient += axis * (share / radius_m);
        }
        let f = math::sqrt(squared).max(f32::MIN_POSITIVE);
        let steepness = math::norm(&gradient) / f;
        let normal = math::unit(&-gradient)?;
        (steepness > 0.0).then(|| Touch {
            gap_m: (1.0 - f) / steepness - radius_m,
            normal,
            sphere: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_in_a_round_bowl_touches_below_and_not_above() {
        let bowl = Bowl {
            radii_m: [0.1; 3],
            ..Bowl::NONE
        };
        let low = bowl.touch(&Vec3::new(0.0, -0.09, 0.0), 0.004).unwrap();
        assert!((low.gap_m - 0.006).abs() < 1.0e-6, "{low:?}");
        assert!((low.normal - Vec3::y()).norm() < 1.0e-5);
        let beyond = bowl.touch(&Vec3::new(0.0, -0.12, 0.0), 0.004).unwrap();
        assert!((beyond.gap_m + 0.024).abs() < 1.0e-6, "{beyond:?}");
        assert_eq!(bowl.touch(&Vec3::new(0.0, 0.2, 0.0), 0.004), None);
        assert_eq!(Bowl::NONE.touch(&Vec3::new(0.0, -1.0, 0.0), 0.004), None);
    }
}
