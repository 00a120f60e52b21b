//! Elastic links of tubes, and of tissue without tetrahedra.

use heapless::Vec;

use crate::capacity::MAX_ORGANS;
use crate::scene::{Organ, Scene};
use crate::tissue::bar::{self, Bar};
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::{Bodies, Node, neo_hookean, warm_start};

/// Elastic links of an organ that begins a substep.
#[derive(Debug, Clone, Copy)]
struct OrganLinks<'a> {
    organ: &'a Organ,
    /// Share of its impulse with which a link begins the substep, and number of the first link
    /// among those of organs without tetrahedra. `None` for an organ whose links keep nothing.
    warm: Option<(f32, u32)>,
    /// Index of the first link.
    first: u32,
    count: u32,
    /// 1/dt², with dt the length of the substep.
    per_step_s2: f32,
    /// Weight of the strain rate relative to the strain: retardation time divided by dt.
    rate: f32,
    /// Rest length of the links, as a share of their length in the scene.
    rest_length_share: f32,
}

/// Projects the elastic links of these organs. In organs without tetrahedra the links begin with
/// their last impulses, and see those of attachments, contacts and grip. The links of each organ keep their order. Links that
/// share a sphere depend on each other, and in a thin tube neighbours in the list do. So the organs
/// take turns, link by link, and the processor can work on several links at a time.
pub(crate) fn project(scene: &Scene<'_>, organs: impl Iterator<Item = u8>, bodies: &mut Bodies) {
    let mut all: Vec<OrganLinks<'_>, MAX_ORGANS> = Vec::new();
    let mut count_max = 0;
    for number in organs {
        if let Some(organ) = scene.organs.get(usize::from(number)) {
            let step_s = scene.step_s_of(number);
            let limits = bodies.warm_start.limits(number);
            let keeps = organ.is_tube() && bodies.warm_start.keeps(organ, number);
            let links = OrganLinks {
                organ,
                warm: keeps.then(|| (limits.kept_share, scene.tube_links_before(organ))),
                first: organ.link_start,
                count: organ.elastic_links.min(organ.link_count),
                per_step_s2: (step_s * step_s).recip(),
                rate: match keeps {
                    true => neo_hookean::rate(&organ.material, step_s, limits),
                    false => organ.material.retardation_s / step_s,
                },
                rest_length_share: bodies.damage.rest_length_share(number),
            };
            count_max = count_max.max(links.count);
            if let Some((kept_share, _)) = links.warm {
                let memory = bodies.warm_start.of(organ).spheres;
                warm_start::begin(&mut bodies.nodes, organ, kept_share, memory);
            }
            let _ = all.push(links); // there is room for all organs
        }
    }
    for step in 0..count_max {
        for links in all.iter().filter(|links| step < links.count) {
            links.project(step, scene, bodies);
        }
    }
    for links in &all {
        if let Some((kept_share, _)) = links.warm {
            let memory = bodies.warm_start.of(links.organ).spheres;
            warm_start::end(&mut bodies.nodes, links.organ, kept_share, memory);
        }
    }
}

impl OrganLinks<'_> {
    /// Projects the link with this number in the organ.
    #[inline(always)]
    fn project(&self, number: u32, scene: &Scene<'_>, bodies: &mut Bodies) {
        let index = self.first.saturating_add(number);
        let intact = bodies.damage.intact_of_link(index);
        let Some(link) = scene.links.get(index as usize) else {
            return;
        };
        let ends = [link.a, link.b];
        let bar = Bar {
            rest_length_m: link.rest_length_m * self.rest_length_share,
            scaled_compliance_per_kg: bar::scaled_compliance_per_kg(
                link.compliance_m_n,
                intact,
                self.per_step_s2,
            ),
        };
        let Bodies {
            nodes, warm_start, ..
        } = bodies;
        match self.warm {
            Some((kept_share, first)) => {
                let number = first.saturating_add(number);
                match warm_start.tube_link(index, number) {
                    Some((_, impulse)) if intact <= 0.0 => {
                        release(nodes, ends, impulse.scaled(kept_share));
                        *impulse = Lanes::ZERO;
                    }
                    Some(memory) => bar.project_warm(nodes, ends, self.rate, kept_share, memory),
                    None => {}
                }
            }
            None => {
                if let (true, Some(last_m)) = (intact > 0.0, warm_start.link_m(index)) {
                    bar.project(nodes, ends, self.rate, last_m);
                }
            }
        }
    }
}

/// Takes back the impulse with which a severed link began the substep.
fn release(nodes: &mut PerSphere<Node>, [a, b]: [u32; 2], kept: Lanes) {
    for (sphere, impulse) in [(a, kept.scaled(-1.0)), (b, kept)] {
        let weight = nodes.at(sphere).inverse_mass_per_kg();
        nodes.at_mut(sphere).push(impulse, weight);
    }
}
