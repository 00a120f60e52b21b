//! Damage of elastic links and attachments: torn, cut or burnt.
//!
//! A link is a bundle of fibres that tear one after another (a cohesive law). Its force rises with
//! its stiffness `k` up to a stretch `s`, in m, and falls with the slope `−k` to zero at `2 s`. A
//! complete tear takes the energy `G = k s²`, which is toughness times area. So `s = √(G c)`
//! follows from `G` and the compliance `c = 1/k`. A half-torn link unloads along a straight line to
//! zero, so no cycle yields energy.

use crate::capacity::{MAX_ATTACHMENTS, MAX_LINKS, MAX_ORGANS};
use crate::math::{self, Vec3};
use crate::scene::{Anchor, Attachment, Material, Organ, Scene, is_suture, numbered};
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;
use crate::words::{Event, EventKind, SphereBits};

/// Least duration of a tear, ticks. Fibres tear at a finite speed, so their load does not vanish at
/// once. A larger value makes tears slower and smoother to feel.
const TEAR_TICKS: f32 = 50.0;

/// Remaining share of the stiffness of a link with damage `damage`: `(2 s − x) / x` after a stretch
/// to `x = s (1 + damage)`.
#[inline]
fn intact_share(damage: f32) -> f32 {
    (1.0 - damage) / (1.0 + damage)
}

/// Damage after a tick at the stretch `stretch_m`, of a link that is elastic up to
/// `elastic_stretch_m`.
fn damage_at_stretch(damage: f32, stretch_m: f32, elastic_stretch_m: f32) -> f32 {
    let damage_max = (damage + TEAR_TICKS.recip()).min(1.0);
    damage.max((stretch_m / elastic_stretch_m - 1.0).min(damage_max))
}

/// Damage of every link and attachment, 0 to 1.
#[derive(Debug, Clone)]
pub(crate) struct Damage {
    links: [f32; MAX_LINKS],
    ties: [f32; MAX_ATTACHMENTS],
    /// Rest length of each organ's links, as a share of their length in the scene.
    rest_length_share: [f32; MAX_ORGANS],
}

impl Damage {
    /// No damage.
    pub(crate) const NONE: Self = Self {
        links: [0.0; MAX_LINKS],
        ties: [0.0; MAX_ATTACHMENTS],
        rest_length_share: [1.0; MAX_ORGANS],
    };

    /// Removes all damage.
    pub(crate) fn heal(&mut self, scene: &Scene<'_>) {
        for (damage, _) in self.links.iter_mut().zip(scene.links) {
            *damage = 0.0;
        }
        for (damage, _) in self.ties.iter_mut().zip(scene.attachments) {
            *damage = 0.0;
        }
        self.rest_length_share = [1.0; MAX_ORGANS];
    }

    /// Remaining share of the stiffness of each link of `organ`, in their order.
    pub(crate) fn intact_of_links(&self, organ: &Organ) -> impl Iterator<Item = f32> {
        let own = self.links.get(organ.link_start as usize..);
        own.unwrap_or(&[])
            .iter()
            .map(|damage| intact_share(*damage))
    }

    /// Remaining share of the stiffness of the link with this index.
    pub(crate) fn intact_of_link(&self, link: u32) -> f32 {
        self.links
            .get(link as usize)
            .map_or(1.0, |it| intact_share(*it))
    }

    /// Severs the link with this index.
    pub(crate) fn sever_link(&mut self, link: u32) {
        if let Some(damage) = self.links.get_mut(link as usize) {
            *damage = 1.0;
        }
    }

    /// Rest length of the organ's links, as a share of the length in the scene.
    pub(crate) fn rest_length_share(&self, organ: u8) -> f32 {
        let own = self.rest_length_share.get(usize::from(organ));
        own.copied().unwrap_or(1.0)
    }

    /// Shortens the links of an organ by `step`, not below the share `share_min`.
    pub(crate) fn shorten_links(&mut self, organ: u8, share_min: f32, step: f32) {
        if let Some(own) = self.rest_length_share.get_mut(usize::from(organ)) {
            *own = (*own - step).max(share_min).min(*own);
        }
    }

    /// Damages the link with this index until at most this share of its stiffness remains.
    pub(crate) fn weaken_link(&mut self, link: u32, share: f32) {
        if let Some(damage) = self.links.get_mut(link as usize) {
            *damage = damage.max(intact_share(share));
        }
    }

    /// Damages the attachment with this index until at most this share of its stiffness remains.
    pub(crate) fn weaken_tie(&mut self, tie: usize, share: f32) {
        if let Some(damage) = self.ties.get_mut(tie) {
            // `intact_share` is its own inverse.
            *damage = damage.max(intact_share(share));
        }
    }

    /// Remaining share of the stiffness of the attachment with this index.
    pub(crate) fn intact_of_tie(&self, tie: usize) -> f32 {
        self.ties.get(tie).map_or(1.0, |it| intact_share(*it))
    }
}

/// A link or attachment in its position after a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BarView {
    /// Organ of its first end.
    pub(crate) organ: u8,
    /// Index in the scene, if it is a link.
    pub(crate) link: Option<u32>,
    /// Ends, world frame, m.
    pub(crate) ends_m: [Vec3; 2],
    /// Radius, m.
    pub(crate) radius_m: f32,
    /// Cross-section that it represents, m². The links along a tube divide the cross-section of the
    /// tube among them.
    pub(crate) area_m2: f32,
    rest_length_m: f32,
    /// Energy that tears it, J; 0 if it cannot tear.
    pub(crate) tear_j: f32,
    compliance_m_n: f32,
}

impl BarView {
    /// Damage after current has boiled the share `burnt` of the bar in a tick; `damage` is the
    /// damage before.
    pub(crate) fn damage_after_burn(&self, damage: f32, burnt: f32) -> f32 {
        damage + burnt.min(TEAR_TICKS.recip())
    }
}

/// A link or attachment that has just been severed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Severed {
    /// Organ of its first end.
    pub(crate) organ: u8,
    /// Middle, world frame, m.
    pub(crate) at_m: Vec3,
    /// Energy that severs it, J; 0 if it cannot tear.
    pub(crate) energy_j: f32,
}

impl Severed {
    /// The event of this kind.
    pub(crate) fn event(&self, kind: EventKind) -> Event {
        Event {
            kind,
            organ: Some(u32::from(self.organ)),
            at_m: self.at_m,
            value: self.energy_j,
        }
    }
}

/// Tears links and attachments that the tick has overstretched. `torn` receives each that was
/// severed. O(attachments and elastic links of organs that move).
pub(crate) fn tear_all(scene: &Scene<'_>, bodies: &mut Bodies, torn: impl FnMut(Severed)) {
    // A stretch below √`elastic_stretch_m2` cannot tear. Comparing squares avoids the root.
    let is_elastic = |ends_m: &[Vec3; 2], rest_length_m: f32, elastic_stretch_m2: f32| {
        let squared_m2 = (ends_m[0] - ends_m[1]).norm_squared();
        squared_m2 <= rest_length_m * rest_length_m + QUICK_TEST_MARGIN * elastic_stretch_m2
    };
    damage_all(scene, bodies, is_elastic, torn, |bar, damage| {
        let along_m = bar.ends_m[0] - bar.ends_m[1];
        let elastic_stretch_m = math::sqrt(bar.tear_j * bar.compliance_m_n);
        let can_tear = elastic_stretch_m > 0.0 && elastic_stretch_m.is_finite();
        let stretch_m = math::norm(&along_m) - bar.rest_length_m;
        if can_tear {
            damage_at_stretch(damage, stretch_m, elastic_stretch_m)
        } else {
            damage
        }
    });
}

/// Margin of the quick test, as a share: larger than its rounding error.
const QUICK_TEST_MARGIN: f32 = 0.999;

/// Damages the links and attachments of organs that move. `new_damage` receives each of them with
/// its damage, and returns the new damage. It is not called where `is_spared` is true; `is_spared`
/// receives the ends, m, the rest length, m, and the square of the stretch at which tearing begins,
/// m². `severed` receives each link or attachment that this call severs.
pub(crate) fn damage_all(
    scene: &Scene<'_>,
    bodies: &mut Bodies,
    is_spared: impl Fn(&[Vec3; 2], f32, f32) -> bool,
    mut severed: impl FnMut(Severed),
    mut new_damage: impl FnMut(&BarView, f32) -> f32,
) {
    let Bodies {
        nodes,
        damage,
        bits,
        radius_m,
        organ: organs,
        sutures,
        ..
    } = bodies;
    let moves = |sphere: u32| bits.at(sphere).contains(SphereBits::AWAKE);
    let mut apply = |bar: BarView, damage: &mut f32| {
        let before = *damage;
        *damage = new_damage(&bar, before).max(before).min(1.0);
        if before < 1.0 && *damage >= 1.0 {
            severed(Severed {
                organ: bar.organ,
                at_m: (bar.ends_m[0] + bar.ends_m[1]) * 0.5,
                energy_j: bar.tear_j,
            });
        }
    };
    for ((tie, suture), damage) in numbered(scene.attachments.iter()).zip(&mut damage.ties) {
        let Some(tie) = sutures.current(tie, suture) else {
            continue;
        };
        let (other_m, other_moves) = match tie.to {
            Anchor::World(at_m) => (at_m, false),
            Anchor::Sphere(other) => (nodes.at(other).center_m(), moves(other)),
        };
        let ends_m = [nodes.at(tie.sphere).center_m(), other_m];
        let is_spared = || is_spared(&ends_m, tie.rest_length_m, tie.tear_j * tie.compliance_m_n);
        // Scissors also cut a suture of an organ that sleeps.
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
            apply(bar, damage);
        }
    }
    for (index, organ) in (0u8..).zip(scene.organs) {
        if !moves(organ.sphere_start) {
            continue;
        }
        let tear_m = tear_length_m(&organ.material);
        let young_pa = organ.material.young_pa.max(f32::MIN_POSITIVE);
        let (link_damage, rest_length_share) = (&mut damage.links, &damage.rest_length_share);
        let own = link_damage.iter_mut().skip(organ.link_start as usize);
        let rest_length_share = rest_length_share
            .get(usize::from(index))
            .copied()
            .unwrap_or(1.0);
        let links = (organ.link_start..).zip(scene.elastic_links_of(organ));
        for ((number, link), damage) in links.zip(own) {
            let squared_m2 = tear_m * link.rest_length_m;
            let ends_m = [link.a, link.b].map(|sphere| nodes.at(sphere).center_m());
            if is_spared(&ends_m, link.rest_length_m * rest_length_share, squared_m2) {
                continue;
            }
            let bar = BarView {
                organ: index,
                link: Some(number),
                ends_m,
                radius_m: radius_m.at(link.a).min(*radius_m.at(link.b)),
                area_m2: link.rest_length_m
                    / (young_pa * link.compliance_m_n).max(f32::MIN_POSITIVE),
                rest_length_m: link.rest_length_m * rest_length_share,
                tear_j: squared_m2 / link.compliance_m_n.max(f32::MIN_POSITIVE),
                compliance_m_n: link.compliance_m_n,
            };
            apply(bar, damage);
        }
    }
}

/// Argument `is_spared` of [`damage_all`] that spares nothing.
pub(crate) const fn spare_none(
    _ends_m: &[Vec3; 2],
    _rest_length_m: f32,
    _elastic_stretch_m2: f32,
) -> bool {
    false
}

/// Cross-section of a suture, m²: 3-0, 0.2 mm thick.
const SUTURE_AREA_M2: f32 = 3.1e-8;

/// Cross-section of an attachment, m²: its energy of tearing divided by the toughness of the weaker
/// of the two organs. An attachment that cannot tear counts as a suture.
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
        SUTURE_AREA_M2
    }
}

/// `Γ / E`, toughness over Young's modulus, m. A link of length L and compliance `c = L / (E A)`
/// takes the energy `Γ A = Γ L / (E c)` to tear, and begins to tear at the stretch `√(Γ L / E)`.
fn tear_length_m(material: &Material) -> f32 {
    material.toughness_j_m2 / material.young_pa.max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn damage_grows_as_computed_by_hand() {
        assert!((intact_share(0.0) - 1.0).abs() < f32::EPSILON && intact_share(1.0) <= 0.0);
        // At one and a half times the stretch `s`, half of the largest force remains: a third of
        // the stiffness.
        assert!((intact_share(0.5) - 1.0 / 3.0).abs() < 1.0e-6);
        // Damage grows in bounded steps and never falls.
        assert!((damage_at_stretch(0.0, 0.009, 0.003) - 0.02).abs() < 1.0e-6);
        assert!((damage_at_stretch(0.4, 0.0, 0.003) - 0.4).abs() < f32::EPSILON);
        assert!(damage_at_stretch(0.0, 0.003, 0.003) <= 0.0);
    }

    proptest! {
        /// On any slow path of the stretch no energy is gained, and a complete tear takes the
        /// energy of the tear.
        #[test]
        fn a_tear_takes_its_energy(
            compliance in 1.0e-4f32..0.1, tear_j in 1.0e-6f32..0.1,
            ways in prop::collection::vec(0.0f32..2.2, 0..12),
        ) {
            let elastic_stretch_m = math::sqrt(tear_j * compliance);
            let step_m = elastic_stretch_m / TEAR_TICKS;
            let (mut damage, mut at_m, mut work_j) = (0.0, 0.0, 0.0f32);
            for share in ways.into_iter().chain([2.2]) {
                let to_m = share * elastic_stretch_m;
                while (to_m - at_m).abs() > 1.0e-6 * elastic_stretch_m {
                    let travel_m = (to_m - at_m).max(-step_m).min(step_m);
                    let force_n = |at_m: f32, damage| at_m * intact_share(damage) / compliance;
                    let before_n = force_n(at_m, damage);
                    at_m += travel_m;
                    damage = damage_at_stretch(damage, at_m, elastic_stretch_m);
                    work_j += travel_m * 0.5 * (before_n + force_n(at_m, damage));
                    prop_assert!(work_j > -0.001 * tear_j);
                }
            }
            prop_assert!(damage >= 1.0);
            prop_assert!((work_j / tear_j - 1.0).abs() < 0.01, "{} of {}", work_j, tear_j);
        }
    }
}
