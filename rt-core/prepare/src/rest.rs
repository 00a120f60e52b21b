//! Checks that organs come to rest under their own weight. An organ that is too soft for its weight
//! collapses or shakes without end. It gets a smaller share of gravity, and a warning says so. An
//! organ that moves even so is refused.

use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use scene_load::{Records, SceneStorage};
use shared_mem::scene::SceneData;

use crate::error::PrepareError;
use crate::recipe::OrganPlan;
use crate::support;

/// Time within which organs must come to rest, ticks: 5 s.
const TICKS: u32 = 5000;
/// Speed below which a sphere is at rest, m/s.
const STILL_M_S: f32 = 1.0e-4;
/// Number of ticks for which an organ must be still, in a row, to count as at rest. A sphere that
/// reverses its motion is slow for a moment only.
const STILL_TICKS: u32 = 200;
/// Largest number of times that a share of gravity is halved, to a thousandth. So little weight
/// bends no organ.
const HALVINGS: u32 = 10;

/// Simulates the scene to see whether each organ that is held and has weight comes to rest. Halves
/// the shares of gravity of organs that do not come to rest, at most `HALVINGS` times. Returns a
/// warning for each organ whose share it changed.
///
/// When an organ does not come to rest with the smallest share. Almost nothing holds such an organ.
pub(crate) fn bear(
    scene: &mut SceneData,
    plans: &[OrganPlan],
) -> Result<Vec<String>, PrepareError> {
    let held = support::held(scene);
    let has_weight = |it: &SceneData, i: usize| held[i] && it.organs[i].gravity_share > 0.0;
    if !(0..plans.len()).any(|i| has_weight(scene, i)) {
        return Ok(Vec::new());
    }
    let shakes = |it: &SceneData| -> Vec<usize> {
        let moving = unquiet(it).into_iter().enumerate();
        moving
            .filter(|(i, moves)| *moves && has_weight(it, *i))
            .map(|(i, _)| i)
            .collect()
    };
    let mut shaking = shakes(scene);
    for _ in 0..HALVINGS {
        if shaking.is_empty() {
            break;
        }
        for i in &shaking {
            scene.organs[*i].gravity_share *= 0.5;
        }
        shaking = shakes(scene);
    }
    if let Some((plan, organ)) = shaking
        .first()
        .and_then(|i| plans.get(*i).zip(scene.organs.get(*i)))
    {
        let [first, count] = organ.spheres.map(|it| it as usize);
        let own = scene.spheres.iter().skip(first).take(count);
        return Err(PrepareError::Organ {
            organ: plan.name.clone(),
            problem: format!(
                "does not come to rest, even with a thousandth of its weight: {} of its {count} spheres are \
                 held; hold more of it, or give it more than material.young_pa = {}",
                own.filter(|it| it.held != 0).count(),
                plan.material.young_pa
            ),
        });
    }
    let pairs = plans.iter().zip(&scene.organs);
    let lightened = pairs.filter(|(plan, organ)| organ.gravity_share < plan.gravity_share as f32);
    let warnings = lightened.map(|(plan, organ)| {
        format!(
            "'{}' cannot bear its weight: with gravity_share {} its tissue of {} Pa does not come to \
             rest; it was prepared with gravity_share = {}; give it that, a larger \
             material.young_pa, or more held spheres",
            plan.name, plan.gravity_share, plan.material.young_pa, organ.gravity_share
        )
    });
    Ok(warnings.collect())
}

/// For each organ, true if it does not come to rest in time.
fn unquiet(scene: &SceneData) -> Vec<bool> {
    let all_quiet = vec![false; scene.organs.len()];
    // Breath moves held tissue, so that tissue would never be at rest.
    let mut scene = scene.clone();
    if let Some(room) = &mut scene.room {
        room.breath_s = 0.0;
    }
    let Some(records) = Records::of_data(&scene) else {
        return all_quiet;
    };
    // Other checks refuse a scene that cannot be loaded.
    let Ok(storage) = SceneStorage::new(records) else {
        return all_quiet;
    };
    let Ok(loaded) = storage.scene() else {
        return all_quiet;
    };
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded, &mut bodies, Method::NeoHookean);
    let mut still = vec![0; scene.organs.len()];
    for _ in 0..TICKS {
        tissue.step();
        for (still, organ) in still.iter_mut().zip(&scene.organs) {
            let [first, count] = organ.spheres;
            let mut spheres = first..first + count;
            let is_still = spheres.all(|i| tissue.velocity_m_s(i).norm() < STILL_M_S);
            *still = if is_still { *still + 1 } else { 0 };
        }
        if still.iter().all(|ticks| *ticks >= STILL_TICKS) {
            break;
        }
    }
    still.iter().map(|ticks| *ticks < STILL_TICKS).collect()
}
