//! Bars that part: elastic links and attachments between organs, torn or cut.
//!
//! A bar is a bundle of fibres that part one after another (a cohesive law): its force rises with
//! its stiffness `k` up to a stretch `s`, and falls as fast from there to nothing at `2 s`. What that
//! takes is `k s²`: so `s = √(G c)` follows from the compliance `c` and from the energy `G` of the
//! tear, toughness times area, and nothing else. Let go half torn it comes back on a straight line
//! to nothing, without what was spent: no cycle gives energy.

use crate::capacity::{MAX_ATTACHMENTS, MAX_LINKS, MAX_ORGANS};
use crate::math::{self, Vec3};
use crate::scene::{Anchor, Attachment, Material, Organ, Scene, is_suture, numbered};
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;
use crate::words::{Event, EventKind, SphereBits};

/// Ticks that a tear takes at least: fibres part at a finite speed, and what they bore is not let
/// off at once.
const TEAR_TICKS: f32 = 50.0;

/// Share of the stiffness that is left of a bar, of which the share `parted` of the way from whole
/// to torn is done: `(2 s − x) / x` of one that has been stretched to `x = s (1 + parted)`.
#[inline]
fn left(parted: f32) -> f32 {
    (1.0 - parted) / (1.0 + parted)
}

/// What a tick at the stretch `stretch_m` makes of a bar that is whole up to `whole_m`.
fn torn_on(parted: f32, stretch_m: f32, whole_m: f32) -> f32 {
    let most = (parted + TEAR_TICKS.recip()).min(1.0);
    parted.max((stretch_m / whole_m - 1.0).min(most))
}

/// How far every bar has parted, 0 to 1.
#[derive(Debug, Clone)]
pub(crate) struct Parted {
    links: [f32; MAX_LINKS],
    ties: [f32; MAX_ATTACHMENTS],
    /// How long the links of each organ want to be, beside their length at rest.
    shrunk: [f32; MAX_ORGANS],
}

impl Parted {
    /// Everything is whole.
    pub(crate) const NONE: Self = Self {
        links: [0.0; MAX_LINKS],
        ties: [0.0; MAX_ATTACHMENTS],
        shrunk: [1.0; MAX_ORGANS],
    };

    /// Everything is whole again.
    pub(crate) fn heal(&mut self, scene: &Scene<'_>) {
        for (parted, _) in self.links.iter_mut().zip(scene.links) {
            *parted = 0.0;
        }
        for (parted, _) in self.ties.iter_mut().zip(scene.attachments) {
            *parted = 0.0;
        }
        self.shrunk = [1.0; MAX_ORGANS];
    }

    /// Share of the stiffness that is left of each link of `organ`, in their order.
    pub(crate) fn left_of_links(&self, organ: &Organ) -> impl Iterator<Item = f32> {
        let own = self.links.get(organ.link_start as usize..);
        own.unwrap_or(&[]).iter().map(|parted| left(*parted))
    }

    /// Share of the stiffness that is left of the link with this index.
    pub(crate) fn left_of_link(&self, link: u32) -> f32 {
        self.links.get(link as usize).map_or(1.0, |it| left(*it))
    }

    /// Parts the link with this index altogether.
    pub(crate) fn part_link(&mut self, link: u32) {
        if let Some(parted) = self.links.get_mut(link as usize) {
            *parted = 1.0;
        }
    }

    /// How long the links of the organ with this index want to be, beside their length at rest.
    pub(crate) fn shrunk(&self, organ: u8) -> f32 {
        let own = self.shrunk.get(usize::from(organ));
        own.copied().unwrap_or(1.0)
    }

    /// Shortens the links of the organ with this index a little, down to the share `least`.
    pub(crate) fn shrink(&mut self, organ: u8, least: f32, step: f32) {
        if let Some(own) = self.shrunk.get_mut(usize::from(organ)) {
            *own = (*own - step).max(least).min(*own);
        }
    }

    /// Leaves at most this share of the stiffness of the link with this index.
    pub(crate) fn leave_of_link(&mut self, link: u32, share: f32) {
        if let Some(parted) = self.links.get_mut(link as usize) {
            *parted = parted.max(left(share));
        }
    }

    /// Leaves at most this share of the stiffness of the attachment with this index.
    pub(crate) fn leave_of_tie(&mut self, tie: usize, share: f32) {
        if let Some(parted) = self.ties.get_mut(tie) {
            // The law is its own inverse.
            *parted = parted.max(left(share));
        }
    }

    /// Share of the stiffness that is left of the attachment with this index.
    pub(crate) fn left_of_tie(&self, tie: usize) -> f32 {
        self.ties.get(tie).map_or(1.0, |it| left(*it))
    }
}

/// A bar as it lies after a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BarView {
    /// The organ of its first end.
    pub(crate) organ: u8,
    /// Its index in the scene, if it is a link.
    pub(crate) link: Option<u32>,
    /// World frame, m.
    pub(crate) ends_m: [Vec3; 2],
    /// m.
    pub(crate) radius_m: f32,
    /// Cross-section of what it stands for, m²: bars of one tube share that of the tube.
    pub(crate) area_m2: f32,
    rest_length_m: f32,
    /// What it takes to tear it, J; 0 of one that does not tear.
    tear_j: f32,
    compliance_m_n: f32,
}

impl BarView {
    /// How far it has parted when fire takes the share `burnt` of it in a tick, and it had `parted`
    /// so far.
    pub(crate) fn parted_by(&self, parted: f32, burnt: f32) -> f32 {
        parted + burnt.min(TEAR_TICKS.recip())
    }
}

/// A bar that has just parted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Apart {
    /// The organ of its first end.
    pub(crate) organ: u8,
    /// Its middle, m.
    pub(crate) at_m: Vec3,
    /// What it takes to part it, J; 0 of what does not tear.
    pub(crate) energy_j: f32,
}

impl Apart {
    /// As an event of this kind.
    pub(crate) fn told(&self, kind: EventKind) -> Event {
        Event {
            kind,
            organ: Some(u32::from(self.organ)),
            at_m: self.at_m,
            value: self.energy_j,
        }
    }
}

/// After a tick: what is stretched too far parts. `torn` hears of what has parted in this tick.
/// O(attachments and elastic links of organs that move).
pub(crate) fn tear_all(scene: &Scene<'_>, bodies: &mut Bodies, torn: impl FnMut(Apart)) {
    // No root is needed to know that what is stretched by less than `whole_m` does not tear.
    let is_whole = |ends_m: &[Vec3; 2], rest_length_m: f32, whole_m2: f32| {
        let squared_m2 = (ends_m[0] - ends_m[1]).norm_squared();
        squared_m2 <= rest_length_m * rest_length_m + ROUNDED * whole_m2
    };
    part_all(scene, bodies, is_whole, torn, |bar, parted| {
        let along_m = bar.ends_m[0] - bar.ends_m[1];
        let whole_m = math::sqrt(bar.tear_j * bar.compliance_m_n);
        let tears = whole_m > 0.0 && whole_m.is_finite();
        let stretch_m = math::norm(&along_m) - bar.rest_length_m;
        if tears {
            torn_on(parted, stretch_m, whole_m)
        } else {
            parted
        }
    });
}

/// What is called whole at a glance is so by more than its computation rounds.
const ROUNDED: f32 = 0.999;

/// Parts every bar of organs that move as far as `part` says, which is given each with how far it
/// has parted, but those that `is_spared`, given ends, m, length at rest, m, and the square of how far they stretch
/// before they tear, m². `apart` hears of what that has severed.
pub(crate) fn part_all(
    scene: &Scene<'_>,
    bodies: &mut Bodies,
    is_spared: impl Fn(&[Vec3; 2], f32, f32) -> bool,
    mut apart: impl FnMut(Apart),
    mut part: impl FnMut(&BarView, f32) -> f32,
) {
    let Bodies {
        nodes,
        parted,
        bits,
        radius_m,
        organ: organs,
        sutures,
        ..
    } = bodies;
    let moves = |sphere: u32| bits.at(sphere).contains(SphereBits::AWAKE);
    let mut note = |bar: BarView, parted: &mut f32| {
        let before = *parted;
        *parted = part(&bar, before).max(before).min(1.0);
        if before < 1.0 && *parted >= 1.0 {
            apart(Apart {
                organ: bar.organ,
                at_m: (bar.ends_m[0] + bar.ends_m[1]) * 0.5,
                energy_j: bar.tear_j,
            });
        }
    };
    for ((tie, suture), parted) in numbered(scene.attachments.iter()).zip(&mut parted.ties) {
        let Some(tie) = sutures.now(tie, suture) else {
            continue;
        };
        let (other_m, other_moves) = match tie.to {
            Anchor::World(at_m) => (at_m, false),
            Anchor::Sphere(other) => (nodes.at(other).center_m(), moves(other)),
        };
        let ends_m = [nodes.at(tie.sphere).center_m(), other_m];
        let is_spared = || is_spared(&ends_m, tie.rest_length_m, tie.tear_j * tie.compliance_m_n);
        // A thread is cut beside an organ that sleeps, too.
        if (moves(tie.sphere) || other_moves || is_suture(&tie)) && !is_spared() {
            let bar = BarView {
                organ: *organs.at(tie.sphere),
                link: None,
                ends_m,
                radius_m: *radius_m.at(tie.sphere),
                area_m2: tie_area_m2(scene, organs, &tie),
                rest_length_m: tie.rest_length_m,
                tear_j: tie.tear_j,
                compliance_m_n: tie.compliance_m_n,
            };
            note(bar, parted);
        }
    }
    for (index, organ) in (0u8..).zip(scene.organs) {
        if !moves(organ.sphere_start) {
            continue;
        }
        let tear_m = tear_length_m(&organ.material);
        let young_pa = organ.material.young_pa.max(f32::MIN_POSITIVE);
        let (lefts, shrunk) = (&mut parted.links, &parted.shrunk);
        let own = lefts.iter_mut().skip(organ.link_start as usize);
        let shrunk = shrunk.get(usize::from(index)).copied().unwrap_or(1.0);
        let links = (organ.link_start..).zip(scene.elastic_links_of(organ));
        for ((number, link), parted) in links.zip(own) {
            let squared_m2 = tear_m * link.rest_length_m;
            let ends_m = [link.a, link.b].map(|sphere| nodes.at(sphere).center_m());
            if is_spared(&ends_m, link.rest_length_m * shrunk, squared_m2) {
                continue;
            }
            let bar = BarView {
                organ: index,
                link: Some(number),
                ends_m,
                radius_m: radius_m.at(link.a).min(*radius_m.at(link.b)),
                area_m2: link.rest_length_m
                    / (young_pa * link.compliance_m_n).max(f32::MIN_POSITIVE),
                rest_length_m: link.rest_length_m * shrunk,
                tear_j: squared_m2 / link.compliance_m_n.max(f32::MIN_POSITIVE),
                compliance_m_n: link.compliance_m_n,
            };
            note(bar, parted);
        }
    }
}

/// Spares no bar: see [`part_all`].
pub(crate) const fn sparing_none(_ends_m: &[Vec3; 2], _rest_length_m: f32, _whole_m2: f32) -> bool {
    false
}

/// Cross-section of a suture, m²: 3-0, 0.2 mm thick.
const THREAD_M2: f32 = 3.1e-8;

/// Cross-section of an attachment, m²: what it takes to tear it over the toughness of the weaker of what
/// it joins. One that does not tear is a suture.
fn tie_area_m2(scene: &Scene<'_>, organs: &PerSphere<u8>, tie: &Attachment) -> f32 {
    let toughness = |sphere| scene.material_of(*organs.at(sphere)).toughness_j_m2;
    let own_j_m2 = toughness(tie.sphere);
    let weaker_j_m2 = match tie.to {
        Anchor::Sphere(other) => own_j_m2.min(toughness(other)),
        Anchor::World(_) => own_j_m2,
    };
    if tie.tear_j > 0.0 && weaker_j_m2 > 0.0 {
        tie.tear_j / weaker_j_m2
    } else {
        THREAD_M2
    }
}

/// `Γ / E`: a bar of length `L` and compliance `c = L / (E A)` tears by `Γ A = Γ L / (E c)`, at a
/// stretch of `√(Γ L / E)`.
fn tear_length_m(material: &Material) -> f32 {
    material.toughness_j_m2 / material.young_pa.max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        assert!((left(0.0) - 1.0).abs() < f32::EPSILON && left(1.0) <= 0.0);
        // At one and a half times the stretch that it bears, half the force: a third of the
        // stiffness.
        assert!((left(0.5) - 1.0 / 3.0).abs() < 1.0e-6);
        // A little at a time; never back.
        assert!((torn_on(0.0, 0.009, 0.003) - 0.02).abs() < 1.0e-6);
        assert!((torn_on(0.4, 0.0, 0.003) - 0.4).abs() < f32::EPSILON);
        assert!(torn_on(0.0, 0.003, 0.003) <= 0.0);
    }

    proptest! {
        /// Drawn apart slowly, forth and back as it may: what goes in is never less than what comes
        /// out, and to tear it takes the energy of the tear, no matter how it went there.
        #[test]
        fn a_tear_takes_its_energy(
            compliance in 1.0e-4f32..0.1, tear_j in 1.0e-6f32..0.1,
            ways in prop::collection::vec(0.0f32..2.2, 0..12),
        ) {
            let whole_m = math::sqrt(tear_j * compliance);
            let step_m = whole_m / TEAR_TICKS;
            let (mut parted, mut at_m, mut work_j) = (0.0, 0.0, 0.0f32);
            for share in ways.into_iter().chain([2.2]) {
                let to_m = share * whole_m;
                while (to_m - at_m).abs() > 1.0e-6 * whole_m {
                    let way_m = (to_m - at_m).max(-step_m).min(step_m);
                    let force_n = |at_m: f32, parted| at_m * left(parted) / compliance;
                    let before_n = force_n(at_m, parted);
                    at_m += way_m;
                    parted = torn_on(parted, at_m, whole_m);
                    work_j += way_m * 0.5 * (before_n + force_n(at_m, parted));
                    prop_assert!(work_j > -0.001 * tear_j);
                }
            }
            prop_assert!(parted >= 1.0);
            prop_assert!((work_j / tear_j - 1.0).abs() < 0.01, "{} of {}", work_j, tear_j);
        }
    }
}
