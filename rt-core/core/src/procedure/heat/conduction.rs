//! Conduction of heat along links and attachments.
//!
//! A link conducts as much as its share of the tissue. With the volume `V` of the tissue, the sum
//! of `section · length` over all links is `V` for a row of spheres, `2 V` for a sheet and `3 V`
//! for a solid. So a bar, a sheet or a block of links conducts as a bar, a sheet or a block of
//! tissue.

use super::{Heat, STEP_S, TURNS};
use crate::scene::{Attachment, Inside, Link, Scene};
use crate::tissue::Bodies;
use crate::words::SphereBits;

/// Thermal conductivity of fat and loose tissue, which is mostly fat, W/(m K).
const FAT_W_M_K: f32 = 0.2;
/// Thermal conductivity of wet soft tissue, W/(m K).
const WET_W_M_K: f32 = 0.5;

/// Largest energy that flows between two spheres in a step, for each kelvin of their difference. It
/// is a share of a heat capacity: each sphere's capacity is divided by the number of its links, and
/// the smaller quotient counts. Below 1, no sphere becomes warmer than its warmest neighbour.
const FLOW_MAX: f32 = 0.5;

impl Heat {
    /// Lets heat flow along the links and attachments of this turn.
    pub(super) fn conduct(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        let turn = self.turn as usize;
        let links = scene.links.iter().enumerate().skip(turn);
        for (i, link) in links.step_by(TURNS as usize) {
            if bodies.damage.intact_of_link(i as u32) > 0.0 {
                let section_m = self.section_of_link_m(link, scene, bodies);
                self.flow(link.a, link.b, section_m, scene, bodies);
            }
        }
        let ties = scene.attachments.iter().enumerate().skip(turn);
        for (i, tie) in ties.step_by(TURNS as usize) {
            if let (Some(other), true) = (tie.other_sphere(), bodies.damage.intact_of_tie(i) > 0.0)
            {
                self.flow(
                    tie.sphere,
                    other,
                    section_of_tie_m(tie, other, scene),
                    scene,
                    bodies,
                );
            }
        }
    }

    /// Lets heat flow from the warmer to the colder of two spheres.
    fn flow(&mut self, a: u32, b: u32, section_m: f32, scene: &Scene<'_>, bodies: &Bodies) {
        let (rise_a, rise_b) = (self.rise_k(a), self.rise_k(b));
        let (from, to, difference_k) = match rise_a > rise_b {
            true => (a, b, rise_a - rise_b),
            false => (b, a, rise_b - rise_a),
        };
        let is_removed = |sphere| bodies.bits.at(sphere).contains(SphereBits::REMOVED);
        if difference_k <= 0.0 || is_removed(a) || is_removed(b) {
            return;
        }
        let most = |sphere: u32| {
            *self.capacity_j_k.at(sphere) / f32::from((*self.link_count.at(sphere)).max(1))
        };
        let most_j_k = FLOW_MAX * most(a).min(most(b));
        let [own_w_m_k, other_w_m_k] =
            [a, b].map(|sphere| conductivity_w_m_k(sphere, scene, bodies));
        // Heat flows through half of the way in each.
        let in_series_w_m_k = 2.0 * own_w_m_k * other_w_m_k / (own_w_m_k + other_w_m_k);
        let energy_j = (in_series_w_m_k * section_m * STEP_S).min(most_j_k) * difference_k;
        *self.warmth_j.at_mut(from) -= energy_j;
        self.warm(to, energy_j);
    }

    /// Section of the tissue of a link, divided by its length, m.
    pub(super) fn section_of_link_m(&self, link: &Link, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
        let counts = [link.a, link.b].map(|it| (*self.link_count.at(it)).max(1));
        let organ = scene.organs.get(usize::from(*bodies.organ.at(link.a)));
        let dimensions = match organ {
            Some(it) if it.batch_count > 0 => 3.0,
            _ if counts.iter().all(|it| *it <= 2) => 1.0,
            _ => 2.0,
        };
        let volume_m3: f32 = [link.a, link.b]
            .iter()
            .zip(counts)
            .map(|(sphere, count)| self.volume_m3(*sphere) / f32::from(count))
            .sum();
        let length_m = link.rest_length_m.max(1.0e-4);
        dimensions * volume_m3 / (length_m * length_m)
    }
}

pub(super) fn conductivity_w_m_k(sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
    let organ = scene.organs.get(usize::from(*bodies.organ.at(sphere)));
    match organ.map(|it| it.inside) {
        Some(Inside::Solid) => FAT_W_M_K,
        _ => WET_W_M_K,
    }
}

/// Section of the contact at an attachment, divided by its length, m: a disc as wide as the smaller
/// sphere, between the centres of both.
pub(super) fn section_of_tie_m(tie: &Attachment, other: u32, scene: &Scene<'_>) -> f32 {
    let radius_m = |sphere: u32| {
        let rest = scene.spheres.get(sphere as usize);
        rest.map_or(0.0, |it| it.radius_m)
    };
    let (own_m, other_m) = (radius_m(tie.sphere), radius_m(other));
    let smaller_m = own_m.min(other_m);
    core::f32::consts::PI * smaller_m * smaller_m / (own_m + other_m).max(1.0e-4)
}
