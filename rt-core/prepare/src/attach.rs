//! What grows organs to each other: ties between their spheres.

use std::f64::consts::PI;

use shared_mem::scene::{AttachmentRecord, SceneData};

use crate::Vec3;
use crate::error::PrepareError;
use crate::field::Nearest;
use crate::mesh::Mesh;
use crate::recipe::{OrganPlan, Packing};

/// Ties of one sphere to another organ: those of a tube's end hold it like a clamp.
const TIES: usize = 2;
const TIES_OF_TUBE: usize = 3;

/// Ties every sphere that is near the skin of an organ its own is attached to, to the nearest
/// spheres of that organ; each organ's count of spheres that are tied.
///
/// A tie is a bar of the softer tissue, its share of the sphere's cross-section thick: compliance
/// `n L / (E π r²)` of `n` ties.
///
/// # Errors
/// Names the organ that no sphere reaches.
pub(crate) fn attach(
    organs: &[OrganPlan],
    skins: &[Mesh],
    scene: &mut SceneData,
) -> Result<Vec<usize>, PrepareError> {
    let mut tied = Vec::new();
    for (own, plan) in organs.iter().enumerate() {
        let ties = match plan.packing {
            Packing::Line => TIES_OF_TUBE,
            Packing::Even | Packing::Paper => TIES,
        };
        let mut is_tied = vec![false; scene.organs[own].spheres[1] as usize];
        for attached in &plan.attached {
            let Some(other) = organs.iter().position(|o| o.name == attached.to) else {
                continue;
            };
            let young_pa = plan.material.young_pa.min(organs[other].material.young_pa);
            let nearest = Nearest::new(&skins[other]);
            let mut some = false;
            for (i, flag) in is_tied.iter_mut().enumerate() {
                let a = scene.organs[own].spheres[0] + i as u32;
                let (center, radius_m) = ball(scene, a);
                let gap_m = nearest
                    .as_ref()
                    .map_or(f64::INFINITY, |n| n.distance(&center));
                if gap_m - radius_m > attached.within_m {
                    continue;
                }
                (*flag, some) = (true, true);
                for (b, length_m) in nearest_spheres(scene, other, &center, ties) {
                    let area_m2 = PI * radius_m * radius_m / ties as f64;
                    scene.attachments.push(AttachmentRecord {
                        a,
                        b,
                        anchor_m: [0.0; 3],
                        rest_length_m: length_m as f32,
                        compliance_m_n: (length_m / (young_pa * area_m2)) as f32,
                        is_thread: 0,
                    });
                }
            }
            if !some {
                return Err(PrepareError::Organ {
                    organ: plan.name.clone(),
                    problem: format!(
                        "no sphere of it comes within {:.1} mm of '{}'; give a larger \
                         attached.within_m, or more spheres",
                        1e3 * attached.within_m,
                        attached.to
                    ),
                });
            }
        }
        tied.push(is_tied.iter().filter(|tied| **tied).count());
    }
    Ok(tied)
}

fn ball(scene: &SceneData, sphere: u32) -> (Vec3, f64) {
    let s = &scene.spheres[sphere as usize];
    (Vec3::from(s.center_m.map(f64::from)), f64::from(s.radius_m))
}

fn nearest_spheres(scene: &SceneData, organ: usize, p: &Vec3, count: usize) -> Vec<(u32, f64)> {
    let [first, spheres] = scene.organs[organ].spheres;
    let mut near: Vec<(u32, f64)> = (first..first + spheres)
        .map(|i| (i, (ball(scene, i).0 - p).norm()))
        .collect();
    near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    near.truncate(count);
    near
}
