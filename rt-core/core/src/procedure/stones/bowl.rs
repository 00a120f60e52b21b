//! The abdomen below the organs, in which stones that miss them come to rest.

use crate::math::{self, Vec3};
use crate::procedure::stones::touch::Touch;
use crate::scene::Bowl;

impl Bowl {
    /// Gap between the bowl and a ball below the bowl's middle; `None` above the middle.
    pub(super) fn touch(&self, at_m: &Vec3, radius_m: f32) -> Option<Touch> {
        let turn = self.world_from_bowl.rotation;
        let off_m = turn.inverse() * (at_m - self.world_from_bowl.translation.vector);
        if off_m.y > 0.0 {
            return None;
        }
        // f = |p'| is 1 on the ellipsoid, and its gradient leads out.
        let radii_m = Vec3::from(self.radii_m);
        let shares = off_m.component_div(&radii_m);
        let f = math::norm(&shares).max(f32::MIN_POSITIVE);
        let gradient = shares.component_div(&radii_m) / f;
        let normal = math::unit(&(turn * -gradient))?;
        Some(Touch {
            gap_m: (1.0 - f) / math::norm(&gradient) - radius_m,
            normal,
            sphere: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Quat};
    use crate::scene::Stones;

    #[test]
    fn a_ball_in_a_round_bowl_touches_below_and_not_above() {
        let bowl = Bowl {
            radii_m: [0.1; 3],
            ..Stones::NONE.bowl
        };
        let low = bowl.touch(&Vec3::new(0.0, -0.09, 0.0), 0.004).unwrap();
        assert!((low.gap_m - 0.006).abs() < 1.0e-6, "{low:?}");
        assert!((low.normal - Vec3::y()).norm() < 1.0e-5);
        let beyond = bowl.touch(&Vec3::new(0.0, -0.12, 0.0), 0.004).unwrap();
        assert!((beyond.gap_m + 0.024).abs() < 1.0e-6, "{beyond:?}");
        assert_eq!(bowl.touch(&Vec3::new(0.0, 0.2, 0.0), 0.004), None);
    }

    #[test]
    fn a_bowl_that_is_turned_and_moved_has_the_same_gaps() {
        let level = Bowl {
            radii_m: [0.1, 0.05, 0.2],
            ..Stones::NONE.bowl
        };
        let turn = Quat::from_euler_angles(0.4, -1.1, 2.0);
        let moved = Pose::from_parts(Vec3::new(0.3, -0.2, 0.1).into(), turn);
        let turned = Bowl {
            world_from_bowl: moved,
            ..level
        };
        let at_m = Vec3::new(0.04, -0.03, -0.1);
        let [a, b] = [
            level.touch(&at_m, 0.004),
            turned.touch(&(moved * nalgebra::Point3::from(at_m)).coords, 0.004),
        ]
        .map(Option::unwrap);
        assert!((a.gap_m - b.gap_m).abs() < 1.0e-5, "{a:?} {b:?}");
        assert!((turn * a.normal - b.normal).norm() < 1.0e-4);
    }
}
