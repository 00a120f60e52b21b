//! Which spheres are attached to the surroundings.

use crate::Vec3;
use crate::field::Nearest;
use crate::mesh::Mesh;
use crate::pack::Ball;
use crate::recipe::{OrganPlan, Region};

/// For each sphere of the organ: whether its centre lies in one of the plan's regions.
#[must_use]
pub(crate) fn held(
    plan: &OrganPlan,
    balls: &[Ball],
    organs: &[OrganPlan],
    skins: &[Mesh],
    gravity: &Vec3,
) -> Vec<bool> {
    let mut held = vec![false; balls.len()];
    for region in &plan.held {
        let contains: Box<dyn Fn(&Ball) -> bool + '_> = match region {
            Region::Box { min_m, max_m } => {
                let (min, max) = (Vec3::from(*min_m), Vec3::from(*max_m));
                Box::new(move |b| (0..3).all(|k| (min[k]..=max[k]).contains(&b.center[k])))
            }
            Region::Plane { point_m, normal } => {
                let (point, normal) = (Vec3::from(*point_m), Vec3::from(*normal));
                Box::new(move |b| (b.center - point).dot(&normal) > 0.0)
            }
            Region::Ball { center_m, radius_m } => {
                let center = Vec3::from(*center_m);
                Box::new(move |b| (b.center - center).norm() <= *radius_m)
            }
            Region::Near { organ, within_m } => {
                let skin = organs
                    .iter()
                    .position(|o| o.name == *organ)
                    .map(|i| &skins[i]);
                let nearest = skin.and_then(Nearest::new);
                Box::new(move |b| {
                    let distance = |near: &Nearest<'_>| near.distance(&b.center) - b.radius_m;
                    nearest
                        .as_ref()
                        .is_some_and(|near| distance(near) <= *within_m)
                })
            }
            Region::Base(share) => {
                let down = gravity.try_normalize(1e-9).unwrap_or(-Vec3::z());
                let height = |b: &Ball| -b.center.dot(&down);
                let low = balls.iter().map(height).fold(f64::INFINITY, f64::min);
                let high = balls.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
                let limit = low + share * (high - low);
                Box::new(move |b| *share > 0.0 && -b.center.dot(&down) <= limit)
            }
        };
        for (flag, ball) in held.iter_mut().zip(balls) {
            *flag |= contains(ball);
        }
    }
    held
}
