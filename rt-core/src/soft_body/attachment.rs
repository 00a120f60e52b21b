//! What ties organs to each other and to the world.

use crate::scene::{Anchor, Scene};
use crate::soft_body::Bodies;
use crate::soft_body::bar::Bar;
use crate::soft_body::lanes::Lanes;

/// Projects every attachment as a bar in the last substep of its first sphere's organ; a thread
/// only while it is taut, and none that has parted. Those held together at length zero are drawn into one place.
pub(crate) fn project_all(scene: &Scene<'_>, bodies: &mut Bodies) {
    let mut sutures = 0;
    for (i, tie) in scene.attachments.iter().enumerate() {
        let Some(tie) = bodies.sutures.now(tie, &mut sutures) else {
            continue;
        };
        let left = bodies.parted.left_of_tie(i);
        if left <= 0.0 {
            continue;
        }
        let step_s = scene.step_s_of(*bodies.organ.at(tie.sphere));
        let a = *bodies.nodes.at(tie.sphere);
        let length_m = tie.rest_length_m;
        let (difference, step, other) = match tie.to {
            Anchor::World(at_m) => (Lanes::new(&(a.center_m() - at_m), 0.0), a.step_m, None),
            Anchor::Sphere(sphere) => {
                let b = *bodies.nodes.at(sphere);
                // Equal impulses: what moves in a shorter step moves less.
                let other_s = scene.step_s_of(*bodies.organ.at(sphere));
                let weight = bodies.weight_per_kg(sphere) * other_s / step_s;
                let step = a.step_m - b.step_m;
                (a.from(&b), step, Some((sphere, b, weight)))
            }
        };
        let slack = length_m * length_m;
        if tie.is_thread && difference.norm_squared() <= slack {
            continue;
        }
        let bar = Bar {
            rest_length_m: length_m,
            compliance_m_n: tie.compliance_m_n / left,
            rate: 0.0,
            step_s,
        };
        let wa = bodies.weight_per_kg(tie.sphere);
        let wb = other.as_ref().map_or(0.0, |(_, _, weight)| *weight);
        let push = bar.push(difference, step, wa + wb);
        bodies.nodes.at_mut(tie.sphere).step_m = a.step_m + push.scaled(wa);
        if let Some((sphere, b, _)) = other {
            bodies.nodes.at_mut(sphere).step_m = b.step_m - push.scaled(wb);
        }
    }
}
