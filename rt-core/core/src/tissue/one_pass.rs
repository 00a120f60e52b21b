//! Compliance that a single pass adds to the links of a tube, or of a sheet without tetrahedra.
//!
//! A substep solves each link once, from a zero multiplier. A link does not see the impulses that
//! act on its ends after it. At rest, a link with the impulse `P` and the compliance `α̃ = α / dt²`
//! therefore has the elongation
//!
//! ```text
//! e = α̃ P + w₁ A₁ + w₂ A₂
//! ```
//!
//! with the inverse masses `w` of its ends, and the sums `A` of the later impulses on each end,
//! away from the link. So the pass adds the compliance `δ = (w₁ A₁ + w₂ A₂) / P`. In a tube, all
//! impulses are known up to a factor if its strain is even: `P ∝ L / α`. The organ then needs no
//! memory of impulses to have its material's stiffness. Its links get the compliance `α̃ − δ`, and
//! the pass adds the rest.
//!
//! `δ` differs from link to link, and `α̃ − δ` may be negative. But each pair of links that meet
//! adds the same energy `w P₁ P₂ cos φ` in either order. So the mean of `δ / α̃` over the links
//! that meet, weighted by their energies, does not depend on the order. This mean is the share
//! `κ ≈ 0.31 E dt² / (ρ h²)`, which is used for each link. Links with less compliance share the
//! force less evenly, and the pass then adds less than `κ`: by `0.18 κ²` in the order in which
//! preparation puts links (`a_stretched_tube_has_its_materials_force`).
//!
//! No link pushes beyond its own solution, so a straight tube is stable with any stiffness. But a
//! curved tube that is drawn straight shakes without end if its links are too stiff for one pass:
//! if the stiffness of a sphere's links times `dt²` over its mass is 16 or more, with the
//! compliance that is left. So links keep at least the compliance of the number 10, and stiffer
//! ones get it (`a_curved_tube_that_is_drawn_straight_rests`). A tube beyond the number 3 is
//! softer than its material: it has the force of the number 3.1
//! (`a_tube_that_is_too_stiff_is_softer_and_rests`).

use crate::capacity::{MAX_ORGANS, MAX_TUBE_LINKS};
use crate::math;
use crate::scene::{Link, Organ, Scene};
use crate::tissue::inverse_mass_per_kg;
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;

/// A link has at least this multiple of `κ` times its own compliance. The stiffness number of its
/// spheres is `4 κ`, and `4 κ / (0.4 κ)` is 10. From `κ = 0.8` on, the tube is softer than its
/// material.
const KEPT_PER_SHARE: f32 = 0.4;
/// Factor of `κ²` by which the pass adds less.
const UNEVEN: f32 = 0.18;

/// Compliance that the pass adds to the links of organs without tetrahedra, 1/kg.
#[derive(Debug, Clone)]
pub(crate) struct OnePass {
    added_per_kg: [f32; MAX_TUBE_LINKS],
    /// First link of each organ in `added_per_kg`; `u32::MAX` for an organ without links there.
    first: [u32; MAX_ORGANS],
}

impl OnePass {
    /// Of no links.
    pub(crate) const NONE: Self = Self {
        added_per_kg: [0.0; MAX_TUBE_LINKS],
        first: [u32::MAX; MAX_ORGANS],
    };

    /// Computes it for the organs of `scene` without tetrahedra, once when it is loaded. Overwrites
    /// `scratch`. An organ whose links find no room is softer than its material. O(links).
    pub(crate) fn build(&mut self, scene: &Scene<'_>, scratch: &mut PerSphere<Lanes>) {
        *self = Self::NONE;
        let mut next = 0usize;
        for ((i, organ), first) in (0u8..).zip(scene.organs).zip(&mut self.first) {
            let links = scene.elastic_links_of(organ);
            let end = next.saturating_add(links.len());
            if let (true, Some(own)) = (organ.is_tube(), self.added_per_kg.get_mut(next..end)) {
                *first = next as u32; // at most `MAX_TUBE_LINKS`
                next = end;
                fill(scene, organ, scene.step_s_of(i), scratch, own);
            }
        }
    }

    /// First link of the organ with this index, for [`Self::added_per_kg`].
    pub(crate) fn first(&self, organ: u8) -> u32 {
        let first = self.first.get(usize::from(organ));
        first.copied().unwrap_or(u32::MAX)
    }

    /// Compliance that the pass adds to the link with this number, 1/kg; below 0 if the link is too
    /// stiff for one pass. 0 for other links.
    #[inline(always)]
    pub(crate) fn added_per_kg(&self, number: u32) -> f32 {
        let added = self.added_per_kg.get(number as usize);
        added.copied().unwrap_or(0.0)
    }
}

/// Fills `added_per_kg` for the elastic links of an organ in substeps of `step_s`.
fn fill(
    scene: &Scene<'_>,
    organ: &Organ,
    step_s: f32,
    scratch: &mut PerSphere<Lanes>,
    added_per_kg: &mut [f32],
) {
    let (start, count) = (organ.sphere_start, organ.sphere_count);
    let links = scene.elastic_links_of(organ);
    let compliance_per_kg = |link: &Link| link.compliance_m_n / (step_s * step_s);
    // What balances the links at each sphere acts after them: attachments, contacts, grip.
    scratch.range_mut(start, count).fill(Lanes::ZERO);
    for link in links {
        let pull = pull(scene, link);
        for (sphere, pull) in [(link.a, pull.scaled(-1.0)), (link.b, pull)] {
            *scratch.at_mut(sphere) = *scratch.at(sphere) + pull;
        }
    }
    for (link, added) in links.iter().zip(added_per_kg.iter_mut()).rev() {
        let pull = pull(scene, link);
        let weight = |sphere: u32| {
            let rest = scene.spheres.get(sphere as usize);
            rest.map_or(0.0, inverse_mass_per_kg)
        };
        let after =
            scratch.at(link.b).scaled(weight(link.b)) - scratch.at(link.a).scaled(weight(link.a));
        let squared = pull.norm_squared().max(f32::MIN_POSITIVE);
        *added = after.vec3().dot(&pull.vec3()) / squared;
        *scratch.at_mut(link.a) = *scratch.at(link.a) + pull;
        *scratch.at_mut(link.b) = *scratch.at(link.b) - pull;
    }
    // Sums of the energies at each sphere: of the added compliance, and of the links' own.
    scratch.range_mut(start, count).fill(Lanes::ZERO);
    for (link, added) in links.iter().zip(added_per_kg.iter()) {
        let squared = pull(scene, link).norm_squared();
        let energies = [
            *added * squared,
            compliance_per_kg(link) * squared,
            0.0,
            0.0,
        ];
        for sphere in [link.a, link.b] {
            *scratch.at_mut(sphere) = *scratch.at(sphere) + Lanes::from_array(energies);
        }
    }
    for (link, added) in links.iter().zip(added_per_kg) {
        let sums = *scratch.at(link.a) + *scratch.at(link.b);
        let [added_sum, own_sum, ..] = sums.to_array();
        let share = (added_sum / own_sum.max(f32::MIN_POSITIVE)).max(0.0);
        let most = 1.0 - KEPT_PER_SHARE * share;
        let added_share = share * (1.0 - UNEVEN * share.min(1.0));
        *added = compliance_per_kg(link) * added_share.min(most);
    }
}

/// Pull of a link on its first sphere in an even strain, in N per unit of strain.
fn pull(scene: &Scene<'_>, link: &Link) -> Lanes {
    let center_m = |sphere: u32| scene.spheres.get(sphere as usize).map(|it| it.center_m);
    let (Some(a_m), Some(b_m)) = (center_m(link.a), center_m(link.b)) else {
        return Lanes::ZERO;
    };
    let pull_n = link.rest_length_m / link.compliance_m_n.max(f32::MIN_POSITIVE);
    math::unit(&(b_m - a_m)).map_or(Lanes::ZERO, |along| Lanes::new(&along, 0.0).scaled(pull_n))
}
