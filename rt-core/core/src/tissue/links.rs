//! Elastic links of tubes, and of tissue that no tetrahedron joins.

use heapless::Vec;

use crate::capacity::MAX_ORGANS;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::bar::{self, Bar};

/// Elastic links of an organ that begins a substep.
#[derive(Debug, Clone, Copy)]
struct Strand {
    /// Index of the first link.
    first: u32,
    count: u32,
    /// 1/dt², with dt the length of the substep.
    per_step_s2: f32,
    /// Weight of the strain rate relative to the strain: retardation time over dt.
    rate: f32,
    /// Rest length, as a share of the length in the scene.
    shrunk: f32,
}

/// Projects the elastic links of these organs. The links of each organ keep their order. Links that
/// share a sphere wait for each other; in a thin tube, links that are close in the list share one.
/// So the organs take turns, link by link, and the processor works on several at a time.
pub(crate) fn project(scene: &Scene<'_>, organs: impl Iterator<Item = u8>, bodies: &mut Bodies) {
    let mut strands: Vec<Strand, MAX_ORGANS> = Vec::new();
    let mut longest = 0;
    for number in organs {
        if let Some(organ) = scene.organs.get(usize::from(number)) {
            let step_s = scene.step_s_of(number);
            let strand = Strand {
                first: organ.link_start,
                count: organ.elastic_links.min(organ.link_count),
                per_step_s2: (step_s * step_s).recip(),
                rate: organ.material.retardation_s / step_s,
                shrunk: bodies.parted.shrunk(number),
            };
            longest = longest.max(strand.count);
            let _ = strands.push(strand); // there is room for all organs
        }
    }
    for step in 0..longest {
        for strand in strands.iter().filter(|it| step < it.count) {
            strand.project(step, scene, bodies);
        }
    }
}

impl Strand {
    /// Projects the link with this number in the organ.
    #[inline(always)]
    fn project(&self, number: u32, scene: &Scene<'_>, bodies: &mut Bodies) {
        let index = self.first.saturating_add(number);
        let left = bodies.parted.left_of_link(index);
        if let Some(link) = scene.links.get(index as usize)
            && let Some(last_m) = bodies.warm_start.link_m(index)
            && left > 0.0
        {
            let bar = Bar {
                rest_length_m: link.rest_length_m * self.shrunk,
                softness_per_kg: bar::softness_per_kg(link.compliance_m_n, left, self.per_step_s2),
            };
            bar.project(&mut bodies.nodes, [link.a, link.b], self.rate, last_m);
        }
    }
}
