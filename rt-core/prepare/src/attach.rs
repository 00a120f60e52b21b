//! Attachments between spheres, here called ties: those of the recipe's `attached` entries, and the
//! recipe's sutures and bands.

use std::f64::consts::PI;

use rt_core::capacity::MAX_ATTACHMENTS;
use shared_mem::scene::{AttachmentRecord, SceneData, WORLD};

use crate::Vec3;
use crate::error::PrepareError;
use crate::field::Nearest;
use crate::mesh::Mesh;
use crate::recipe::{OrganPlan, Packing, Place, Tie};

/// Number of ties from one sphere to another organ.
const TIES: usize = 2;
/// Number of ties from one sphere of a tube to another organ. Three ties hold the end of the tube
/// like a clamp.
const TIES_OF_TUBE: usize = 3;

/// Numbers of ties that are tried in turn, until the scene has room for them: two for each sphere,
/// one for each sphere, one for every second sphere, and so on. The area of ties that are left out
/// is added to the others. Ties of tubes are never left out, because a tube needs all three at its
/// end.
const THRIFT: [Thrift; 5] = [
    Thrift {
        ties: TIES,
        every: 1,
    },
    Thrift { ties: 1, every: 1 },
    Thrift { ties: 1, every: 2 },
    Thrift { ties: 1, every: 3 },
    Thrift { ties: 1, every: 4 },
];

/// Number of ties where two organs are grown together.
#[derive(Debug, Clone, Copy)]
struct Thrift {
    /// Number of ties from one sphere.
    ties: usize,
    /// One in this many spheres is tied.
    every: usize,
}

/// Attaches organs to each other. An `attached` entry ties the organ's spheres within `within_m` of
/// the other organ's skin to the nearest spheres of the other organ. There are fewer ties if the
/// realtime process has no room for all of them beside the recipe's `others` ([`THRIFT`]). Returns
/// the number of tied spheres of each organ.
///
/// A tie is a bar of the softer tissue. Each of the `n` ties of a sphere has an equal share of the
/// sphere's cross-section, so the tie's compliance is `n L / (E π r²)`. The energy that tears the
/// tie is the lower toughness of the two tissues times this area.
///
/// # Errors
/// When an `attached` entry catches none of the organ's spheres, or all of them in an organ without
/// layers. The error names the organ and the entry.
pub(crate) fn attach(
    organs: &[OrganPlan],
    skins: &[Mesh],
    others: usize,
    scene: &mut SceneData,
) -> Result<Vec<usize>, PrepareError> {
    let room = MAX_ATTACHMENTS.saturating_sub(others);
    let mut tied = Vec::new();
    for thrift in THRIFT {
        scene.attachments.clear();
        tied.clear();
        for own in 0..organs.len() {
            tied.push(attach_organ(own, organs, skins, thrift, scene)?);
        }
        if scene.attachments.len() <= room {
            break; // without a break, the scene's own check says that there are too many
        }
    }
    Ok(tied)
}

/// Ties the spheres of one organ, and returns their number.
fn attach_organ(
    own: usize,
    organs: &[OrganPlan],
    skins: &[Mesh],
    thrift: Thrift,
    scene: &mut SceneData,
) -> Result<usize, PrepareError> {
    let plan = &organs[own];
    let Thrift { ties, every } = match plan.packing {
        Packing::Line => Thrift {
            ties: TIES_OF_TUBE,
            every: 1,
        },
        Packing::Even | Packing::Paper => thrift,
    };
    let mut is_tied = vec![false; scene.organs[own].spheres[1] as usize];
    for (number, attached) in plan.attached.iter().enumerate() {
        let Some(other) = organs.iter().position(|o| o.name == attached.to) else {
            continue;
        };
        let young_pa = plan.material.young_pa.min(organs[other].material.young_pa);
        let toughness_j_m2 =
            (plan.material.toughness_j_m2).min(organs[other].material.toughness_j_m2);
        let nearest = Nearest::new(&skins[other]);
        let (mut caught, mut off) = (0, (f64::INFINITY, Vec3::zeros()));
        for (i, flag) in is_tied.iter_mut().enumerate() {
            let a = scene.organs[own].spheres[0] + i as u32;
            let (center, radius_m) = ball(scene, a);
            let gap_m = nearest
                .as_ref()
                .map_or(f64::INFINITY, |n| n.distance(&center));
            if gap_m - radius_m > attached.within_m {
                if gap_m - radius_m < off.0 {
                    off = (gap_m - radius_m, center);
                }
                continue;
            }
            caught += 1;
            if (caught - 1) % every != 0 {
                continue;
            }
            *flag = true;
            let area_m2 = PI * radius_m * radius_m * every as f64 / ties as f64;
            for (b, length_m) in nearest_spheres(scene, other, &center, ties) {
                scene.attachments.push(AttachmentRecord {
                    a,
                    b,
                    anchor_m: [0.0; 3],
                    rest_length_m: length_m as f32,
                    compliance_m_n: (length_m / (young_pa * area_m2)) as f32,
                    is_thread: 0,
                    tear_j: (toughness_j_m2 * area_m2) as f32,
                });
            }
        }
        check_caught(plan, number, (caught, is_tied.len()), off)?;
    }
    Ok(is_tied.iter().filter(|tied| **tied).count())
}

/// Refuses an `attached` entry that catches no sphere, or all spheres. `off` has the distance and
/// the place of the nearest sphere that the entry does not catch.
fn check_caught(
    plan: &OrganPlan,
    number: usize,
    (caught, spheres): (usize, usize),
    off: (f64, Vec3),
) -> Result<(), PrepareError> {
    if caught == 0 {
        let what = format!(
            "none of its {spheres} spheres; the nearest is {:.1} mm from it, at [{:.3}, {:.3}, {:.3}] m; \
             give a larger attached.within_m, or more spheres",
            1e3 * off.0,
            off.1.x,
            off.1.y,
            off.1.z
        );
        return Err(catches(plan, number, &what));
    }
    // All spheres of layered tissue between two organs may be attached to both.
    if caught == spheres && plan.layers.is_none() {
        let what = format!(
            "all of its {caught} spheres, so it can move with it only; give a smaller attached.within_m"
        );
        return Err(catches(plan, number, &what));
    }
    Ok(())
}

/// The error of an `attached` entry that catches no sphere, or every sphere.
fn catches(plan: &OrganPlan, number: usize, what: &str) -> PrepareError {
    let entry = &plan.attached[number];
    PrepareError::Organ {
        organ: plan.name.clone(),
        problem: format!(
            "attached[{number}], within {:.1} mm of '{}', catches {what}",
            1e3 * entry.within_m,
            entry.to
        ),
    }
}

/// Largest distance of the end of a suture or band from the surface of the nearest sphere of its
/// organ, m. A larger distance is an error: mostly, millimetres were given as metres.
const OFF_ORGAN_M: f64 = 0.02;

/// Checks that the place of a suture's or band's end lies on its organ. `found` has the organ and
/// its nearest sphere.
fn is_on_organ(
    place: &Place,
    found: Option<(usize, u32)>,
    scene: &SceneData,
) -> Result<(), PrepareError> {
    let (Place::Organ { organ, near_m }, Some((_, sphere))) = (place, found) else {
        return Ok(());
    };
    let (center, radius_m) = ball(scene, sphere);
    let off_m = (Vec3::from(*near_m) - center).norm() - radius_m;
    if off_m <= OFF_ORGAN_M {
        return Ok(());
    }
    let problem = format!(
        "a suture or band ends at {near_m:?} m, {:.0} mm off the organ; allowed: at most {:.0} mm; set \
         `near_m` on the organ, in metres",
        off_m * 1e3,
        OFF_ORGAN_M * 1e3
    );
    Err(PrepareError::Organ {
        organ: organ.clone(),
        problem,
    })
}

/// Tension of a thread per unit of strain, N: a 3-0 monofilament suture is 0.2 mm thick and has a
/// modulus of 1.3 GPa. Such a thread hardly stretches compared with tissue.
const THREAD_N: f64 = 40.0;
/// A tie shorter than this gets the stiffness of a tie of this length, m.
const SHORT_M: f64 = 1e-3;

/// Adds the recipe's sutures and bands. A suture does not tear.
///
/// # Errors
/// When both ends lie in one sphere, or a place lies off its organ.
pub(crate) fn sew(
    ties: &[Tie],
    organs: &[OrganPlan],
    scene: &mut SceneData,
) -> Result<(), PrepareError> {
    for tie in ties {
        let end = |place: &Place| match place {
            Place::Organ { organ, near_m } => {
                let index = organs.iter().position(|o| o.name == *organ)?;
                let near = nearest_spheres(scene, index, &Vec3::from(*near_m), 1);
                near.first().map(|&(sphere, _)| (index, sphere))
            }
            Place::World { .. } => None,
        };
        let Some((own, a)) = end(&tie.from) else {
            continue; // the recipe's check lets no tie start in the world
        };
        is_on_organ(&tie.from, end(&tie.from), scene)?;
        is_on_organ(&tie.to, end(&tie.to), scene)?;
        let (center, radius_m) = ball(scene, a);
        let (b, at) = match (&tie.to, end(&tie.to)) {
            (Place::World { world_m }, _) => (WORLD, Vec3::from(*world_m)),
            (_, Some((_, b))) => (b, ball(scene, b).0),
            (_, None) => continue,
        };
        if a == b {
            let organ = organs[own].name.clone();
            let problem = "a suture or band has both ends in one sphere; set its ends farther \
                           apart, or give the organ more spheres"
                .into();
            return Err(PrepareError::Organ { organ, problem });
        }
        let apart_m = (at - center).norm();
        let length_m = (tie.length_m.unwrap_or(apart_m) - tie.drawn_m).max(0.0);
        let (material, area_m2) = (organs[own].material, PI * radius_m * radius_m);
        let (tension_n, tear_j) = if tie.is_thread {
            (THREAD_N, 0.0)
        } else {
            (
                material.young_pa * area_m2,
                material.toughness_j_m2 * area_m2,
            )
        };
        let typical_n_m = tension_n / length_m.max(SHORT_M);
        let stiffness_n_m = tie.stiffness_n_m.unwrap_or(typical_n_m);
        let anchor_m = match b {
            WORLD => at.map(|x| x as f32).into(),
            _ => [0.0; 3],
        };
        scene.attachments.push(AttachmentRecord {
            a,
            b,
            anchor_m,
            rest_length_m: length_m as f32,
            compliance_m_n: stiffness_n_m.recip() as f32,
            is_thread: u32::from(tie.is_thread),
            tear_j: tear_j as f32,
        });
    }
    Ok(())
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
