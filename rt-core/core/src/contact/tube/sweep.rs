//! Side of a tube on which a tool lies, followed through its motion.

use crate::math::{self, Vec3};

/// Largest step into which the motion of a tick is divided, as a share of the reach (the sum of
/// both radii).
const STEP_REACHES: f32 = 0.5;
/// Motion that needs more steps than this counts as a jump.
const STEPS_MAX: f32 = 16.0;

/// Margin along the tube, beyond the reach, within which a tool keeps its side, m: the tool's
/// travel in a tick.
const ENGAGED_MARGIN_M: f32 = 0.003;

/// Axis of a part of a tool at one moment, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    pub(crate) a_m: Vec3,
    pub(crate) b_m: Vec3,
}

impl Axis {
    fn point_at(&self, share: f32) -> Vec3 {
        self.a_m + (self.b_m - self.a_m) * share
    }

    fn moved_to(&self, to: &Self, share: f32) -> Self {
        Self {
            a_m: self.a_m + (to.a_m - self.a_m) * share,
            b_m: self.b_m + (to.b_m - self.b_m) * share,
        }
    }

    /// Squared distance from a point, m².
    pub(crate) fn distance_squared_m2(&self, point_m: &Vec3) -> f32 {
        (self.point_at(self.nearest_share(point_m)) - point_m).norm_squared()
    }

    /// Closest place on the axis to a point, 0 to 1.
    fn nearest_share(&self, point_m: &Vec3) -> f32 {
        self.line_share(point_m).clamp(0.0, 1.0)
    }

    /// Closest place on the infinite line through the axis: 0 at `a_m`, 1 at `b_m`.
    fn line_share(&self, point_m: &Vec3) -> f32 {
        let along_m = self.b_m - self.a_m;
        let squared = along_m.norm_squared().max(1.0e-12);
        (point_m - self.a_m).dot(&along_m) / squared
    }
}

/// Component of `v` perpendicular to the tube.
fn cross_section(v: &Vec3, along: &Vec3) -> Vec3 {
    v - along * along.dot(v)
}

const ANY_DIRECTION: Vec3 = Vec3::new(0.0, 0.0, 1.0);

/// The side of a bead on which a tool lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side {
    /// Unit vector from the bead to the tool.
    pub(crate) normal: Vec3,
    /// Place on the tool's axis that meets the bead: 0 at `a_m`, 1 at `b_m`.
    pub(crate) share: f32,
}

/// Motion of tool and bead in a tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    pub(crate) axis: [Axis; 2],
    pub(crate) bead_m: [Vec3; 2],
    /// Unit vector along the tube; zero for a single bead, which is round.
    pub(crate) along: Vec3,
    /// Sum of both radii, m.
    pub(crate) reach_m: f32,
    /// Slip around the bead that is allowed in each step of the motion even if nothing moves, m.
    pub(crate) slip_m: f32,
}

impl Motion {
    /// Upper bound of the travel of tool and bead relative to each other, m.
    pub(crate) fn travel_m(&self) -> f32 {
        let [from, to] = &self.axis;
        let tool_m = math::norm(&(to.a_m - from.a_m)).max(math::norm(&(to.b_m - from.b_m)));
        let [before_m, after_m] = &self.bead_m;
        tool_m + math::norm(&(after_m - before_m))
    }
}

impl Side {
    /// Side of a tool at its first tick near the bead.
    pub(crate) fn first(axis: &Axis, bead_m: &Vec3, along: &Vec3) -> Self {
        let share = axis.nearest_share(bead_m);
        let from_bead_m = cross_section(&(axis.point_at(share) - bead_m), along);
        // A bead on the axis gets an arbitrary side, which must always be the same.
        let fallback = || {
            math::perpendicular(if *along == Vec3::zeros() {
                &ANY_DIRECTION
            } else {
                along
            })
        };
        Self {
            normal: math::unit(&from_bead_m).unwrap_or_else(fallback),
            share,
        }
    }

    /// This side at a neighbouring bead: the side that [`Side::follow`] would have reached there.
    pub(crate) fn at_neighbour(
        &self,
        axis: &Axis,
        bead_m: &Vec3,
        along: &Vec3,
        reach_m: f32,
    ) -> Self {
        let normal = math::unit(&cross_section(&self.normal, along)).unwrap_or(self.normal);
        let nearest = Self {
            normal,
            share: axis.nearest_share(bead_m),
        };
        if !nearest.is_engaged(axis, bead_m, along, reach_m) {
            return nearest;
        }
        // Lifting an oblique axis moves its closest place along the axis, and the new place needs
        // another lift. `share` is the place to which these lifts converge.
        let axis_m = axis.b_m - axis.a_m;
        let rise_m = normal.dot(&axis_m);
        let level_m2 = (axis_m.norm_squared() - rise_m * rise_m).max(1.0e-12);
        let share = axis.line_share(bead_m);
        let overlap_m = -Self { normal, share }.separation_m(axis, bead_m, reach_m);
        Self {
            normal,
            share: (share - rise_m * overlap_m / level_m2).clamp(0.0, 1.0),
        }
    }

    /// True while a tool overlaps the tube, at this bead or within a margin along the tube.
    fn is_engaged(&self, axis: &Axis, bead_m: &Vec3, along: &Vec3, reach_m: f32) -> bool {
        let from_bead_m = axis.point_at(self.share) - bead_m;
        // With the margin, the beads next to those that the tool touches keep the same side.
        let is_alongside = along.dot(&from_bead_m).abs() < reach_m + ENGAGED_MARGIN_M;
        self.normal.dot(&from_bead_m) < reach_m && is_alongside
    }

    /// The axis; if the tool overlaps the tube, it is lifted until they just touch.
    fn lifted(&self, axis: &Axis, bead_m: &Vec3, along: &Vec3, reach_m: f32) -> Axis {
        if !self.is_engaged(axis, bead_m, along, reach_m) {
            return *axis;
        }
        let height_m = self.normal.dot(&(axis.point_at(self.share) - bead_m));
        let lift_m = self.normal * (reach_m - height_m);
        Axis {
            a_m: axis.a_m + lift_m,
            b_m: axis.b_m + lift_m,
        }
    }

    /// Side after this motion; `None` after a jump. A tool that overlaps is lifted out along the
    /// last normal and followed there, as a god-object is. So it keeps its side.
    pub(crate) fn follow(&self, motion: &Motion) -> Option<Self> {
        let travel_m = motion.travel_m();
        let steps = travel_m / (STEP_REACHES * motion.reach_m.max(1.0e-6));
        if steps.is_nan() || steps > STEPS_MAX {
            return None;
        }
        let count = (steps as u16).saturating_add(1); // `as` truncates
        let step_share = f32::from(count).recip();
        let slip_m = motion.slip_m + 2.0 * travel_m * step_share;
        let mut side = *self;
        for step in 1..=count {
            let share = f32::from(step) * step_share;
            let [from, to] = &motion.axis;
            let [before_m, after_m] = &motion.bead_m;
            let axis = from.moved_to(to, share);
            let bead_m = before_m + (after_m - before_m) * share;
            side = side.step(&axis, &bead_m, motion, slip_m);
        }
        Some(side)
    }

    fn step(&self, axis: &Axis, bead_m: &Vec3, motion: &Motion, slip_m: f32) -> Self {
        let along = &motion.along;
        let normal = math::unit(&cross_section(&self.normal, along)).unwrap_or(self.normal);
        let from = Self {
            normal,
            share: self.share,
        };
        let is_engaged = from.is_engaged(axis, bead_m, along, motion.reach_m);
        let lifted = from.lifted(axis, bead_m, along, motion.reach_m);
        let share = lifted.nearest_share(bead_m);
        let from_bead_m = cross_section(&(lifted.point_at(share) - bead_m), along);
        let direction = math::unit(&from_bead_m).unwrap_or(normal);
        // A tool that does not overlap the tube may change its side freely.
        let turn = direction - normal;
        let turn_max = if is_engaged {
            slip_m / motion.reach_m.max(1.0e-6)
        } else {
            2.0
        };
        let turn_size = math::norm(&turn);
        let turned = if turn_size > turn_max {
            normal + turn * (turn_max / turn_size)
        } else {
            direction
        };
        Self {
            normal: math::unit(&turned).unwrap_or(normal),
            share,
        }
    }

    /// Separation of tube and tool across the tube, m; negative where they overlap.
    pub(crate) fn separation_m(&self, axis: &Axis, bead_m: &Vec3, reach_m: f32) -> f32 {
        self.normal.dot(&(axis.point_at(self.share) - bead_m)) - reach_m
    }

    /// Share of the bead's stiffness that acts. The share falls to zero where the tool's point is a
    /// reach away from the bead along the tube. So a tool that slides along the tube passes from
    /// bead to bead without a step, and a tool that presses on the tube does not push along the
    /// tube.
    pub(crate) fn weight(&self, axis: &Axis, bead_m: &Vec3, along: &Vec3, reach_m: f32) -> f32 {
        let along_share = along.dot(&(axis.point_at(self.share) - bead_m)) / reach_m.max(1.0e-6);
        (1.0 - along_share * along_share).max(0.0)
    }

    /// Point of the tool's axis at `share`, m.
    pub(crate) fn at_m(&self, axis: &Axis) -> Vec3 {
        axis.point_at(self.share)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::testing::vector;
    use proptest::prelude::*;

    const REACH_M: f32 = 0.002;

    fn rod(middle_m: Vec3, half_m: Vec3) -> Axis {
        Axis {
            a_m: middle_m - half_m,
            b_m: middle_m + half_m,
        }
    }

    fn motion(from: Axis, to: Axis) -> Motion {
        Motion {
            axis: [from, to],
            bead_m: [Vec3::zeros(); 2],
            along: Vec3::y(),
            reach_m: REACH_M,
            slip_m: 3.0e-5,
        }
    }

    #[test]
    fn crossing_tool_keeps_its_side() {
        let along = Vec3::x() * 0.01;
        let [over, under] = [0.0035, -0.0025].map(|z| rod(Vec3::z() * z, along));
        let side = Side::first(&over, &Vec3::zeros(), &Vec3::y());
        assert!(math::norm(&(side.normal - Vec3::z())) < 1.0e-6);
        let side = side.follow(&motion(over, under)).unwrap();
        assert!(side.normal.z > 0.99, "{side:?}");
        let separation_m = side.separation_m(&under, &Vec3::zeros(), REACH_M);
        assert!((separation_m + 0.0045).abs() < 1.0e-5, "{separation_m}");
        // The bead may move instead.
        let bead = Motion {
            axis: [over; 2],
            bead_m: [Vec3::zeros(), Vec3::z() * 0.006],
            ..motion(over, over)
        };
        let side = Side::first(&over, &Vec3::zeros(), &Vec3::y())
            .follow(&bead)
            .unwrap();
        assert!(side.normal.z > 0.99, "{side:?}");
        assert!(
            Side::first(&over, &Vec3::zeros(), &Vec3::y())
                .follow(&motion(over, rod(Vec3::z(), along)))
                .is_none()
        );
    }

    proptest! {
        /// A tool that passes a bead without touching it makes no contact, however fast.
        #[test]
        fn passing_tool_makes_no_contact(from in vector(0.006), travel_m in vector(0.003), half in vector(0.02)) {
            let (from, to) = (rod(from, half), rod(from + travel_m, half));
            let nearest_m = |axis: &Axis| math::norm(&axis.point_at(axis.nearest_share(&Vec3::zeros())));
            for step in 0u8..=20 {
                let between = from.moved_to(&to, f32::from(step) / 20.0);
                prop_assume!(nearest_m(&between) > 1.1 * REACH_M);
            }
            let motion = Motion { along: Vec3::zeros(), ..motion(from, to) };
            let side = Side::first(&from, &Vec3::zeros(), &Vec3::zeros()).follow(&motion).unwrap();
            prop_assert!(side.separation_m(&to, &Vec3::zeros(), REACH_M) > 0.0, "{side:?}");
        }

        /// A bead that takes its neighbour's side gets the place on the tool at which
        /// [`Side::follow`] would settle. Otherwise the bead's separation would jump when its
        /// weight rises above zero, because from then on the bead is followed.
        #[test]
        fn bead_with_its_leaders_side_has_the_place_of_a_followed_bead(overlap_m in 1.0e-4f32..0.004, middle in vector(0.01), half in vector(0.02)) {
            let leader = Side { normal: Vec3::z(), share: 0.5 };
            let still = rod(Vec3::new(middle.x, middle.y, REACH_M - overlap_m), half);
            let motion = Motion { slip_m: 0.0, ..motion(still, still) };
            let led = leader.at_neighbour(&still, &Vec3::zeros(), &motion.along, REACH_M);
            let engaged = |side: &Side| side.is_engaged(&still, &Vec3::zeros(), &motion.along, REACH_M);
            prop_assume!(engaged(&led) && engaged(&Side { share: still.nearest_share(&Vec3::zeros()), ..led }));
            prop_assume!(half.z.abs() < 0.7 * math::norm(&half));
            let mut side = led;
            for _ in 0..100 {
                side = side.follow(&motion).unwrap();
            }
            prop_assert!((side.share - led.share).abs() < 1.0e-3, "{led:?} {side:?}");
        }

        /// In slow motion the separation changes no faster than the tool moves: the force has no
        /// step.
        #[test]
        fn separation_is_continuous(
            start in vector(1.0), steps_m in prop::collection::vec(vector(3.0e-5), 1..200), half in vector(0.02),
        ) {
            let start = cross_section(&start, &Vec3::y());
            let from = math::unit(&start).unwrap_or_else(Vec3::z) * (1.02 * REACH_M);
            let half = half - from * (half.dot(&from) / from.norm_squared());
            let mut axis = rod(from, half);
            let inward = -from * 0.01;
            let mut side = Side::first(&axis, &Vec3::zeros(), &Vec3::y());
            let mut separation_m = side.separation_m(&axis, &Vec3::zeros(), REACH_M);
            for step_m in steps_m {
                let step_m = step_m + inward;
                let to = rod((axis.a_m + axis.b_m) * 0.5 + step_m, half);
                side = side.follow(&motion(axis, to)).unwrap();
                axis = to;
                let next_m = side.separation_m(&axis, &Vec3::zeros(), REACH_M);
                if next_m < -REACH_M {
                    break; // past the bead's centre, where the side may turn round
                }
                let most_m = 8.0 * math::norm(&step_m) + 6.0e-5;
                prop_assert!((next_m - separation_m).abs() < most_m, "{separation_m} {next_m}");
                separation_m = next_m;
            }
        }
    }
}
