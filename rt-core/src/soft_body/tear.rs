//! Tearing of bars: elastic links, and attachments between organs.
//!
//! A bar is a bundle of fibres that part one after another (a cohesive law): its force rises with
//! its stiffness `k` up to a stretch `s`, and falls as fast from there to nothing at `2 s`. What that
//! takes is `k s²`: so `s = √(G c)` follows from the compliance `c` and from the energy `G` of the
//! tear, toughness times area, and nothing else. Let go half torn it comes back on a straight line
//! to nothing, without what was spent: no cycle gives energy.

use crate::capacity::{MAX_ATTACHMENTS, MAX_LINKS};
use crate::math::{self, Vec3};
use crate::scene::{Anchor, Attachment, Link, Material, Organ, Scene};
use crate::soft_body::Bodies;
use crate::state::SphereBits;

/// Ticks that a tear takes at least: fibres part at a finite speed, and what they bore is not let
/// off at once.
const TEAR_TICKS: f32 = 50.0;

/// How far a bar can be stretched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Strength {
    /// Up to here it is whole, m; torn at twice that.
    whole_m: f32,
}

impl Strength {
    /// Of an attachment; `None` if it does not tear. One that does not stretch does not either.
    pub(crate) fn of_tie(tie: &Attachment) -> Option<Self> {
        Self::new(tie.tear_j * tie.compliance_m_n)
    }

    /// Of an elastic link of this material: a bar of compliance `L / (E A)` that tears by its
    /// toughness over `A`.
    pub(crate) fn of_link(link: &Link, material: &Material) -> Option<Self> {
        let young_pa = material.young_pa.max(f32::MIN_POSITIVE);
        Self::new(material.toughness_j_m2 * link.rest_length_m / young_pa)
    }

    fn new(squared_m2: f32) -> Option<Self> {
        let whole_m = math::sqrt(squared_m2);
        (whole_m > 0.0 && whole_m.is_finite()).then_some(Self { whole_m })
    }

    /// Share of the stiffness that is left of a bar that has been stretched by `worn_m`.
    pub(crate) fn left(&self, worn_m: f32) -> f32 {
        if worn_m <= self.whole_m {
            1.0
        } else {
            ((2.0 * self.whole_m - worn_m) / worn_m).max(0.0)
        }
    }

    /// What a tick at this stretch makes of `worn_m`.
    fn wear(&self, worn_m: f32, stretch_m: f32) -> f32 {
        let most_m = worn_m.max(self.whole_m) + self.whole_m / TEAR_TICKS;
        worn_m.max(stretch_m.min(most_m))
    }
}

/// The furthest that every bar has been stretched, m.
#[derive(Debug)]
pub(crate) struct Wear {
    links: [f32; MAX_LINKS],
    ties: [f32; MAX_ATTACHMENTS],
}

impl Wear {
    /// Everything is whole.
    pub(crate) const NONE: Self = Self {
        links: [0.0; MAX_LINKS],
        ties: [0.0; MAX_ATTACHMENTS],
    };

    /// Everything is whole again.
    pub(crate) fn heal(&mut self, scene: &Scene<'_>) {
        for (worn_m, _) in self.links.iter_mut().zip(scene.links) {
            *worn_m = 0.0;
        }
        for (worn_m, _) in self.ties.iter_mut().zip(scene.attachments) {
            *worn_m = 0.0;
        }
    }

    /// Of the links of `organ`, in their order.
    pub(crate) fn links_of(&self, organ: &Organ) -> &[f32] {
        let first = organ.link_start as usize;
        self.links.get(first..).unwrap_or(&[])
    }

    /// Share of the stiffness that is left of the link with this index, of this material.
    pub(crate) fn left_of_link(&self, link: u32, scene: &Scene<'_>, material: &Material) -> f32 {
        let bar = scene.links.get(link as usize);
        let strength = bar.and_then(|bar| Strength::of_link(bar, material));
        let worn_m = self.links.get(link as usize);
        strength
            .zip(worn_m)
            .map_or(1.0, |(strength, worn_m)| strength.left(*worn_m))
    }

    /// Of the attachments, in their order.
    pub(crate) const fn ties(&self) -> &[f32; MAX_ATTACHMENTS] {
        &self.ties
    }
}

/// A bar that has just torn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Torn {
    /// The organ of its first end.
    pub(crate) organ: u8,
    /// Its middle, m.
    pub(crate) at_m: Vec3,
    /// What it took to tear it, J.
    pub(crate) energy_j: f32,
}

/// After a tick: what each bar's stretch has made of it. `torn` hears of those that have torn in
/// this tick. O(attachments and elastic links of organs that move).
pub(crate) fn wear_all(scene: &Scene<'_>, bodies: &mut Bodies, mut torn: impl FnMut(Torn)) {
    let Bodies {
        nodes,
        wear,
        bits,
        organ: organs,
        ..
    } = bodies;
    let moves = |sphere: u32| bits.at(sphere).contains(SphereBits::AWAKE);
    let mut note = |worn_m: &mut f32, strength: Strength, ends: [Vec3; 2], rest_m, organ, c| {
        let stretch_m = math::norm(&(ends[0] - ends[1])) - rest_m;
        let before = strength.left(*worn_m);
        *worn_m = strength.wear(*worn_m, stretch_m);
        if before > 0.0 && strength.left(*worn_m) <= 0.0 {
            torn(Torn {
                organ,
                at_m: (ends[0] + ends[1]) * 0.5,
                energy_j: strength.whole_m * strength.whole_m / c,
            });
        }
    };
    for (tie, worn_m) in scene.attachments.iter().zip(&mut wear.ties) {
        let Some(strength) = Strength::of_tie(tie) else {
            continue;
        };
        let a_m = nodes.at(tie.sphere).center_m();
        let (b_m, moves) = match tie.to {
            Anchor::World(at_m) => (at_m, moves(tie.sphere)),
            Anchor::Sphere(other) => {
                let moves = moves(tie.sphere) || moves(other);
                (nodes.at(other).center_m(), moves)
            }
        };
        if moves {
            let organ = *organs.at(tie.sphere);
            let rest_m = tie.rest_length_m;
            note(
                worn_m,
                strength,
                [a_m, b_m],
                rest_m,
                organ,
                tie.compliance_m_n,
            );
        }
    }
    for (index, organ) in (0u8..).zip(scene.organs) {
        if !moves(organ.sphere_start) {
            continue;
        }
        let first = organ.link_start as usize;
        let worn = wear.links.iter_mut().skip(first);
        for (link, worn_m) in scene.elastic_links_of(organ).iter().zip(worn) {
            if let Some(strength) = Strength::of_link(link, &organ.material) {
                let ends = [link.a, link.b].map(|sphere| nodes.at(sphere).center_m());
                let (rest_m, c) = (link.rest_length_m, link.compliance_m_n);
                note(worn_m, strength, ends, rest_m, index, c);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    fn tie(compliance_m_n: f32, tear_j: f32) -> Attachment {
        Attachment {
            sphere: 0,
            to: Anchor::World(Vec3::zeros()),
            rest_length_m: 0.01,
            compliance_m_n,
            is_thread: false,
            tear_j,
        }
    }

    #[test]
    fn by_hand() {
        // 100 N/m and 1 mJ: √(1e-3 · 1e-2) = 3.16 mm, at 0.316 N.
        let strength = Strength::of_tie(&tie(0.01, 1.0e-3)).unwrap();
        assert!((strength.whole_m - 3.162e-3).abs() < 1.0e-6);
        assert!((strength.left(0.003) - 1.0).abs() < f32::EPSILON);
        // At one and a half times that, half the force: a third of the stiffness.
        assert!((strength.left(1.5 * strength.whole_m) - 1.0 / 3.0).abs() < 1.0e-6);
        assert!(strength.left(2.0 * strength.whole_m) <= 0.0);
        assert_eq!(Strength::of_tie(&tie(0.01, 0.0)), None);
        assert_eq!(Strength::of_tie(&tie(0.0, 1.0)), None);
    }

    proptest! {
        /// Drawn apart slowly, forth and back as it may: what goes in is never less than what comes
        /// out, and to tear it takes the energy of the tear, no matter how it went there.
        #[test]
        fn a_tear_takes_its_energy(
            compliance in 1.0e-4f32..0.1, tear_j in 1.0e-6f32..0.1,
            ways in prop::collection::vec(0.0f32..2.2, 0..12),
        ) {
            let strength = Strength::of_tie(&tie(compliance, tear_j)).unwrap();
            let step_m = strength.whole_m / TEAR_TICKS;
            let (mut worn_m, mut at_m, mut work_j) = (0.0, 0.0, 0.0f32);
            for share in ways.into_iter().chain([2.2]) {
                let to_m = share * strength.whole_m;
                while (to_m - at_m).abs() > 1.0e-6 * strength.whole_m {
                    let way_m = (to_m - at_m).max(-step_m).min(step_m);
                    let force_n = |at_m: f32, worn_m| at_m * strength.left(worn_m) / compliance;
                    let before_n = force_n(at_m, worn_m);
                    at_m += way_m;
                    worn_m = strength.wear(worn_m, at_m);
                    work_j += way_m * 0.5 * (before_n + force_n(at_m, worn_m));
                    prop_assert!(work_j > -0.001 * tear_j);
                }
            }
            prop_assert!(strength.left(worn_m) <= 0.0);
            prop_assert!((work_j / tear_j - 1.0).abs() < 0.01, "{} of {}", work_j, tear_j);
        }
    }
}
