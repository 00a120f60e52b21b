//! Organs that are held, and warnings about organs that nothing holds.

use shared_mem::scene::{SceneData, WORLD};

use crate::recipe::OrganPlan;

/// For each organ, true if it is held: by held spheres of its own, by an attachment to the world,
/// or by attachments to organs that are held.
pub(crate) fn held(scene: &SceneData) -> Vec<bool> {
    let organ_of = |sphere: u32| {
        let mut all = scene.organs.iter();
        all.position(|it| (it.spheres[0]..it.spheres[0] + it.spheres[1]).contains(&sphere))
    };
    let held = scene.organs.iter().map(|it| {
        let own = scene.spheres.iter().skip(it.spheres[0] as usize);
        own.take(it.spheres[1] as usize)
            .any(|sphere| sphere.held != 0)
    });
    let mut is_held: Vec<bool> = held.collect();
    let mut ties: Vec<[usize; 2]> = Vec::new();
    for tie in &scene.attachments {
        match (organ_of(tie.a), tie.b) {
            (Some(own), WORLD) => is_held[own] = true,
            (Some(own), b) => ties.extend(organ_of(b).map(|other| [own, other])),
            (None, _) => {}
        }
    }
    // In each round, held organs pass on to the organs attached to them that these are held, too.
    // As many rounds as there are organs suffice.
    for _ in 0..is_held.len() {
        for [a, b] in &ties {
            let either = is_held[*a] || is_held[*b];
            (is_held[*a], is_held[*b]) = (either, either);
        }
    }
    is_held
}

/// A warning for each organ that is not held.
pub(crate) fn warnings(scene: &SceneData, organs: &[OrganPlan]) -> Vec<String> {
    let weight = scene.room.as_ref().map_or(0.0, |room| {
        room.gravity_m_s2.iter().map(|x| x * x).sum::<f32>()
    });
    let loose = organs.iter().zip(held(scene)).filter(|(_, held)| !held);
    loose
        .map(|(plan, _)| {
            let then = match plan.gravity_share > 0.0 && weight > 0.0 {
                true => "it falls unless another organ lies below it",
                false => "it floats away when it is touched",
            };
            format!(
                "nothing holds '{}' (held 0 spheres): {then}; give it held, such as held = [{{ base = 0.15 }}], \
                 attached, or a suture",
                plan.name
            )
        })
        .collect()
}
