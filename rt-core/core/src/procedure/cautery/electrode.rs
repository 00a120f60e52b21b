//! The bare tip of the hook under current: position, contact area and energy.

use crate::math::{self, Vec3};
use crate::port::PedalSample;
use crate::scene::{Inside, Organ};
use crate::time::TICK_S;
use crate::tool::{Instrument, Role, ToolState};

/// Power of the generator, W, for both currents. Cholecystectomies are done at 25 to 35 W.
const POWER_W: f32 = 30.0;
/// Share of the power that becomes heat near the tip. Of the resistance around a small ball in
/// tissue, `(1/a − 1/r) / 4πσ`, half lies within one radius of the ball's surface. The rest of the
/// power spreads over the organ and hardly warms it.
const HEAT_SHARE: f32 = 0.5;
/// Share of the heat that divides tissue at the tip under a cutting current, which boils cells at
/// once. The rest desiccates the tissue around the tip. The share is assumed.
const CUTTING_SHARE: f32 = 0.9;
/// Share of the heat that divides tissue under a coagulating current, which is interrupted and
/// desiccates cells in its pauses. The share is assumed.
const COAGULATING_SHARE: f32 = 0.15;
/// Gap that steam and sparks bridge, m.
const BRIDGED_M: f32 = 0.000_3;

/// Energy that heats tissue from 37 to 100 °C and boils its water (three quarters of it), J/m³:
/// `1060 kg/m³ (3600 J/kg K · 63 K + 0.75 · 2.26 MJ/kg)`.
pub(super) const BOIL_J_M3: f32 = 2.0e9;

/// Current that the pedal switches on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Current {
    Cut,
    Coagulate,
}

/// The bare part of the hook while current flows: its bent end. The rest is insulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Electrode {
    ends_m: [Vec3; 2],
    radius_m: f32,
    current: Current,
}

/// Energy of a tick's current per contact area, J/m². It falls as the total contact area grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dose {
    /// Part of the energy that divides the touched tissue, J/m².
    pub(crate) dividing_j_m2: f32,
    /// Part of the energy that desiccates the touched tissue and the tissue around it, J/m².
    pub(crate) drying_j_m2: f32,
    /// Width of the division, m.
    kerf_m: f32,
}

impl Electrode {
    /// An electrode with a cutting current between these ends.
    #[cfg(test)]
    pub(super) const fn cutting(ends_m: [Vec3; 2]) -> Self {
        Self {
            ends_m,
            radius_m: 0.000_8,
            current: Current::Cut,
        }
    }

    /// Electrode of this tick; `None` without current or with another instrument. Both pedals
    /// together give no current.
    pub(crate) fn of(tool: &ToolState, pedal: PedalSample) -> Option<Self> {
        let current = match (pedal.cut, pedal.coagulate) {
            (true, false) => Current::Cut,
            (false, true) => Current::Coagulate,
            _ => return None,
        };
        let is_active = tool.instrument == Instrument::Hook && !tool.switches.paused;
        let tip = tool.capsules.iter().find(|part| part.role == Role::Tip)?;
        is_active.then_some(Self {
            ends_m: [tip.a_m, tip.b_m],
            radius_m: tip.radius_m,
            current,
        })
    }

    /// Middle, world frame, m.
    pub(crate) fn middle_m(&self) -> Vec3 {
        (self.ends_m[0] + self.ends_m[1]) * 0.5
    }

    /// Distance of a place from the electrode's axis, m.
    pub(crate) fn distance_m(&self, at_m: &Vec3) -> f32 {
        distance_m(&self.ends_m, &[*at_m; 2])
    }

    /// Diameter, m.
    pub(crate) fn diameter_m(&self) -> f32 {
        2.0 * self.radius_m
    }

    /// Contact area with an organ if the electrode lies on its surface with its whole length, m².
    pub(crate) fn side_m2(&self) -> f32 {
        math::norm(&(self.ends_m[1] - self.ends_m[0])) * self.diameter_m()
    }

    /// Contact with a ball of tissue: 1 if the electrode touches the ball. It falls to 0 at the
    /// widest gap that the current bridges.
    pub(crate) fn touches_ball(&self, center_m: &Vec3, radius_m: f32) -> f32 {
        self.touches_bar(&[*center_m; 2], radius_m)
    }

    /// Contact with a link of tissue, as in [`Self::touches_ball`].
    pub(crate) fn touches_bar(&self, ends_m: &[Vec3; 2], radius_m: f32) -> f32 {
        // Bounding boxes reject distant links without a square root. The margin covers rounding.
        let reach_m = 1.01 * (self.radius_m + radius_m + BRIDGED_M);
        if box_distance_m(&self.ends_m, ends_m) > reach_m {
            return 0.0;
        }
        let gap_m = distance_m(&self.ends_m, ends_m) - self.radius_m - radius_m;
        let share = (BRIDGED_M - gap_m) / BRIDGED_M;
        // NaN counts as no contact.
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    }

    /// Dose for the contact area `touched_m2`; `None` if there is none.
    pub(crate) fn dose(&self, touched_m2: f32) -> Option<Dose> {
        let share = match self.current {
            Current::Cut => CUTTING_SHARE,
            Current::Coagulate => COAGULATING_SHARE,
        };
        let total_j_m2 = POWER_W * HEAT_SHARE * TICK_S / touched_m2;
        (touched_m2 > 0.0 && total_j_m2.is_finite()).then_some(Dose {
            dividing_j_m2: total_j_m2 * share,
            drying_j_m2: total_j_m2 * (1.0 - share),
            kerf_m: self.diameter_m(),
        })
    }
}

impl Dose {
    /// Sum of both parts, J/m².
    pub(crate) fn total_j_m2(&self) -> f32 {
        self.dividing_j_m2 + self.drying_j_m2
    }

    /// Part of the energy that opens the wall of this organ, J/m². All heat near the tip opens a
    /// wall: it is released within 0.8 mm of the tip's surface, which is within the wall, and a
    /// desiccated wall gives way. In an artery only the dividing part opens the wall, because a
    /// desiccated artery shrinks and seals.
    pub(super) fn opening_j_m2(&self, organ: Option<&Organ>) -> f32 {
        match organ.map(|it| it.inside) {
            Some(Inside::Blood) => self.dividing_j_m2,
            _ => self.total_j_m2(),
        }
    }

    /// Share of a touched link that the dose boils away, over the width of the electrode.
    pub(crate) fn boiled_share(&self) -> f32 {
        self.dividing_j_m2 / (BOIL_J_M3 * self.kerf_m)
    }
}

/// Lower bound of the distance between two segments, m: the largest gap of their bounding boxes
/// along an axis. Negative if the boxes overlap.
fn box_distance_m([a, b]: &[Vec3; 2], [c, d]: &[Vec3; 2]) -> f32 {
    let first = a.inf(b) - c.sup(d);
    let second = c.inf(d) - a.sup(b);
    first.sup(&second).max()
}

/// Distance between two segments, m. Either may be a point.
fn distance_m([a, b]: &[Vec3; 2], [c, d]: &[Vec3; 2]) -> f32 {
    let (first, second, between) = (b - a, d - c, a - c);
    let (first2, second2) = (first.norm_squared(), second.norm_squared());
    let (product, on_first, on_second) = (
        first.dot(&second),
        first.dot(&between),
        second.dot(&between),
    );
    let share = |numerator: f32, denominator: f32| {
        let share = numerator / denominator;
        if denominator > 0.0 {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    // First the point of the first line nearest to the second line. Then the point of the second
    // segment nearest to this point. Then the point of the first segment nearest to that point.
    let s = share(
        product * on_second - on_first * second2,
        first2 * second2 - product * product,
    );
    let t = share(on_second + s * product, second2);
    let s = share(t * product - on_first, first2);
    math::norm(&(between + first * s - second * t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Quat};
    use crate::tool::capsules;
    use proptest::prelude::*;

    fn hook(instrument: Instrument, cut: bool, coagulate: bool) -> ToolState {
        let port_m = Vec3::new(0.0, 0.0, 0.1);
        let mut tool = ToolState::new(port_m, Pose::identity());
        tool.instrument = instrument;
        let pose = Pose::from_parts(Vec3::zeros().into(), Quat::identity());
        tool.capsules = capsules(instrument, &pose, &port_m, 1.0);
        tool.switches.pedal = PedalSample {
            cut,
            coagulate,
            ..PedalSample::default()
        };
        tool
    }

    /// Electrode of a tool whose pedal does not pass a needle.
    fn electrode_of(tool: &ToolState) -> Option<Electrode> {
        Electrode::of(tool, tool.switches.pedal)
    }

    #[test]
    fn current_flows_at_the_hook_s_bent_end_alone() {
        for (instrument, cut, coagulate) in [
            (Instrument::Grasper, true, false),
            (Instrument::Hook, false, false),
            (Instrument::Hook, true, true),
        ] {
            assert_eq!(electrode_of(&hook(instrument, cut, coagulate)), None);
        }
        let mut tool = hook(Instrument::Hook, true, false);
        let electrode = electrode_of(&tool).expect("current");
        // The bend lies 12 mm beyond the joint, and its end 4 mm to the side.
        assert!(electrode.touches_ball(&Vec3::new(0.0, -0.004, -0.0135), 0.000_8) >= 1.0);
        assert!(electrode.touches_ball(&Vec3::new(0.0, 0.0, -0.006), 0.003) <= 0.0);
        tool.switches.paused = true;
        assert_eq!(electrode_of(&tool), None);
    }

    #[test]
    fn dose_sums_to_the_power_and_cutting_divides_more_than_it_desiccates() {
        let dose = |cut| {
            let electrode = electrode_of(&hook(Instrument::Hook, cut, !cut));
            electrode.and_then(|it| it.dose(2.0e-6)).expect("current")
        };
        for cut in [true, false] {
            let total_j = dose(cut).total_j_m2() * 2.0e-6;
            assert!((total_j - POWER_W * HEAT_SHARE * TICK_S).abs() < 1.0e-7);
        }
        assert!(dose(true).dividing_j_m2 > dose(true).drying_j_m2);
        assert!(dose(false).dividing_j_m2 < dose(false).drying_j_m2);
        // A cord of 2 mm² that is boiled over the hook's width of 1.6 mm takes 6.4 J, at 13.5 W.
        let ticks = dose(true).boiled_share().recip();
        assert!((ticks - 474.0).abs() < 1.0, "{ticks}");
    }

    proptest! {
        /// The distance equals the smallest one between many pairs of points on the two segments.
        #[test]
        fn distance_is_the_smallest_between_two_points(
            points in prop::array::uniform4(prop::array::uniform3(-1.0f32..1.0)),
        ) {
            let [a, b, c, d] = points.map(Vec3::from);
            let found_m = distance_m(&[a, b], &[c, d]);
            let mut least_m = f32::MAX;
            for i in 0..=60u8 {
                for j in 0..=60u8 {
                    let (s, t) = (f32::from(i) / 60.0, f32::from(j) / 60.0);
                    least_m = least_m.min(math::norm(&(a + (b - a) * s - c - (d - c) * t)));
                }
            }
            prop_assert!(found_m <= least_m + 1.0e-4, "{} {}", found_m, least_m);
            prop_assert!(found_m >= least_m - 0.06, "{} {}", found_m, least_m);
        }

        /// A rejection by bounding boxes does not change the contact that the distance gives.
        #[test]
        fn bounding_boxes_do_not_change_the_contact(
            points in prop::array::uniform4(prop::array::uniform3(-0.004f32..0.004)),
        ) {
            let [a, b, c, d] = points.map(Vec3::from);
            let electrode = Electrode::cutting([a, b]);
            let gap_m = distance_m(&[a, b], &[c, d]) - electrode.radius_m - 0.001;
            let plain = ((BRIDGED_M - gap_m) / BRIDGED_M).clamp(0.0, 1.0);
            prop_assert!((electrode.touches_bar(&[c, d], 0.001) - plain).abs() < 1.0e-6);
        }

        #[test]
        fn electrode_survives_any_input(points in prop::array::uniform2(any::<[f32; 3]>()), m2 in any::<f32>()) {
            let electrode = electrode_of(&hook(Instrument::Hook, true, false)).expect("current");
            let share = electrode.touches_bar(&points.map(Vec3::from), 0.001);
            prop_assert!((0.0..=1.0).contains(&share));
            let boiled_share = electrode.dose(m2).map_or(0.0, |dose| dose.boiled_share());
            prop_assert!(boiled_share >= 0.0 && boiled_share.is_finite());
        }
    }
}
