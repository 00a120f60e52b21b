//! Elastic links of tubes, and of tissue without tetrahedra.

use heapless::Vec;

use crate::capacity::MAX_ORGANS;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::bar::{self, Bar};

/// Elastic links of an organ that begins a substep.
#[derive(Debug, Clone, Copy)]
struct OrganLinks {
    /// Index of the first link.
    first: u32,
    count: u32,
    /// Number of the first link in `Bodies::one_pass`.
    first_in_pass: u32,
    /// 1/dt², with dt the length of the substep.
    per_step_s2: f32,
    /// Weight of the strain rate relative to the strain: retardation time divided by dt.
    rate: f32,
    /// Rest length of the links, as a share of their length in the scene.
    rest_length_share: f32,
}

/// Projects the elastic links of these organs. The links of each organ keep their order. Links that
/// share a sphere depend on each other, and in a thin tube neighbours in the list do. So the organs
/// take turns, link by link, and the processor can work on several links at a time.
pub(crate) fn project(scene: &Scene<'_>, organs: impl Iterator<Item = u8>, bodies: &mut Bodies) {
    let mut all: Vec<OrganLinks, MAX_ORGANS> = Vec::new();
    let mut count_max = 0;
    for number in organs {
        if let Some(organ) = scene.organs.get(usize::from(number)) {
            let step_s = scene.step_s_of(number);
            let links = OrganLinks {
                first: organ.link_start,
                count: organ.elastic_links.min(organ.link_count),
                first_in_pass: bodies.one_pass.first(number),
                per_step_s2: (step_s * step_s).recip(),
                rate: organ.material.retardation_s / step_s,
                rest_length_share: bodies.damage.rest_length_share(number),
            };
            count_max = count_max.max(links.count);
            let _ = all.push(links); // there is room for all organs
        }
    }
    for step in 0..count_max {
        for links in all.iter().filter(|links| step < links.count) {
            links.project(step, scene, bodies);
        }
    }
}

impl OrganLinks {
    /// Projects the link with this number in the organ.
    #[inline(always)]
    fn project(&self, number: u32, scene: &Scene<'_>, bodies: &mut Bodies) {
        let index = self.first.saturating_add(number);
        let intact = bodies.damage.intact_of_link(index);
        if let Some(link) = scene.links.get(index as usize)
            && let Some(last_m) = bodies.warm_start.link_m(index)
            && intact > 0.0
        {
            let scaled_compliance_per_kg =
                bar::scaled_compliance_per_kg(link.compliance_m_n, intact, self.per_step_s2);
            let in_pass = self.first_in_pass.saturating_add(number);
            let bar = Bar {
                rest_length_m: link.rest_length_m * self.rest_length_share,
                scaled_compliance_per_kg: scaled_compliance_per_kg
                    - bodies.one_pass.added_per_kg(in_pass),
            };
            bar.project(&mut bodies.nodes, [link.a, link.b], self.rate, last_m);
        }
    }
}
