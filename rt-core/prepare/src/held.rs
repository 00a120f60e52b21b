//! Held spheres, and the planes that bound held tissue.

use crate::Vec3;
use crate::error::PrepareError;
use crate::field::Nearest;
use crate::mesh::Mesh;
use crate::pack::{Ball, Interior};
use crate::recipe::{OrganPlan, Region};

/// A plane beyond which tissue is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point of the plane, m.
    pub point_m: Vec3,
    /// Unit vector to the held side.
    pub normal: Vec3,
}

/// A point on the free side of a plane counts as held up to this distance from the plane, m.
const ON_PLANE_M: f64 = 1e-6;
/// Spheres up to this far behind a plane may be moved onto it, in spacings of the spheres.
const BEHIND_SPACINGS: f64 = 1.2;
/// Spheres up to this far before a plane may be moved onto it, in spacings of the spheres.
const BEFORE_SPACINGS: f64 = 0.25;
/// Spheres that are moved onto a plane are at least this far apart, in spacings, so that tetrahedra
/// between them are not flat.
const APART_SPACINGS: f64 = 0.6;

impl Plane {
    /// Depth of a point behind the plane, on the held side, m; negative on the free side.
    #[must_use]
    pub fn depth_m(&self, p: &Vec3) -> f64 {
        (p - self.point_m).dot(&self.normal)
    }

    /// True if tissue at this point is held.
    #[must_use]
    pub fn holds(&self, p: &Vec3) -> bool {
        self.depth_m(p) > -ON_PLANE_M
    }

    /// The plane that bounds this region of an organ with this skin. `None` if the region is no
    /// half space and no base.
    pub(crate) fn of(region: &Region, skin: &Mesh, gravity: &Vec3) -> Option<Self> {
        let (point_m, normal) = match region {
            Region::Plane { point_m, normal } => (Vec3::from(*point_m), Vec3::from(*normal)),
            Region::Base(share) if *share > 0.0 => {
                let down = gravity.try_normalize(1e-9).unwrap_or(-Vec3::z());
                let height = |p: &Vec3| -p.dot(&down);
                let heights = || skin.vertices.iter().map(height);
                let low = heights().fold(f64::INFINITY, f64::min);
                let high = heights().fold(f64::NEG_INFINITY, f64::max);
                (-down * (low + share * (high - low)), down)
            }
            _ => return None,
        };
        let normal = normal.try_normalize(1e-12)?;
        Some(Self { point_m, normal })
    }
}

/// The planes beyond which an organ with this skin is held.
pub(crate) fn planes(plan: &OrganPlan, skin: &Mesh, gravity: &Vec3) -> Vec<Plane> {
    let all = plan.held.iter();
    all.filter_map(|region| Plane::of(region, skin, gravity))
        .collect()
}

/// Moves the spheres nearest to a plane onto it, so that tetrahedra between free and held spheres
/// end exactly at the plane, whatever the number of spheres. Without the move, a free lobe of 250
/// spheres was a quarter too soft. If the spheres up to half a spacing before the plane were held
/// instead, the lobe was a fifth too stiff.
pub fn onto_planes(planes: &[Plane], interior: &Interior<'_>, balls: &mut [Ball]) {
    let spacing_m = interior.spacing_m;
    let mut on_planes: Vec<Vec3> = Vec::new();
    for (number, plane) in planes.iter().enumerate() {
        let mut near: Vec<(f64, usize)> = (balls.iter().enumerate())
            .map(|(i, ball)| (plane.depth_m(&ball.center), i))
            .filter(|(depth_m, _)| {
                (-BEFORE_SPACINGS..BEHIND_SPACINGS).contains(&(depth_m / spacing_m))
            })
            .collect();
        near.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()).then(a.1.cmp(&b.1)));
        for (depth_m, i) in near {
            let place = balls[i].center - plane.normal * depth_m;
            let is_apart = |other: &Vec3| (other - place).norm() > APART_SPACINGS * spacing_m;
            let others = planes.iter().enumerate().filter(|(n, _)| *n != number);
            let is_held_by_other = || others.clone().any(|(_, p)| p.holds(&balls[i].center));
            // Near the organ's edge, the place on the plane may lie outside the organ.
            let is_inside = || interior.depth(&place) > 0.5 * balls[i].radius_m;
            if on_planes.iter().all(is_apart) && !is_held_by_other() && is_inside() {
                balls[i] = interior.inscribed(place, balls[i].radius_m);
                on_planes.push(place);
            }
        }
    }
}

/// The spheres of an organ that the plan holds.
pub(crate) struct Held {
    /// For each sphere, true if it is held.
    pub(crate) spheres: Vec<bool>,
    /// Distance of each sphere from the nearest held region, m; negative within a region.
    off_m: Vec<f64>,
}

/// Largest factor by which tissue between a free and a held sphere is made stiffer. With a larger
/// factor, a sphere close to the border would shake.
const STIFFER_MAX: f64 = 3.0;

impl Held {
    /// Factor by which tissue between these spheres is stiffer than between free ones, at most
    /// [`STIFFER_MAX`]. Only the part before the border deforms: a share `l` of the length, so the
    /// factor is `1 / l`. Without the factor, tissue would deform up to the centre of the held
    /// sphere beyond the border, and the organ's stiffness would jump as the border is moved past
    /// a centre.
    pub(crate) fn stiffer(&self, spheres: &[u32]) -> f64 {
        let mean_m = |held: bool| {
            let own = spheres.iter().map(|i| *i as usize);
            let of: Vec<f64> = own
                .filter(|i| self.spheres[*i] == held)
                .map(|i| self.off_m[i].abs())
                .collect();
            (!of.is_empty()).then(|| of.iter().sum::<f64>() / of.len() as f64)
        };
        match (mean_m(false), mean_m(true)) {
            (Some(before_m), Some(beyond_m)) if before_m > 0.0 => {
                (1.0 + beyond_m / before_m).min(STIFFER_MAX)
            }
            _ => 1.0,
        }
    }
}

/// Finds the spheres of the organ that the plan holds. `skin` is the organ's own skin, `skins` are
/// the skins of all `organs`.
///
/// # Errors
/// When an entry of `held` holds no sphere: the error names the entry, its place, and the distance
/// to the nearest sphere. When the entries hold all spheres, unless one of them holds the whole
/// height.
pub(crate) fn held(
    plan: &OrganPlan,
    skin: &Mesh,
    balls: &[Ball],
    organs: &[OrganPlan],
    skins: &[Mesh],
    gravity: &Vec3,
) -> Result<Held, PrepareError> {
    let error = |problem: String| PrepareError::Organ {
        organ: plan.name.clone(),
        problem,
    };
    let mut held = vec![false; balls.len()];
    let mut all_off_m = vec![f64::INFINITY; balls.len()];
    for (number, region) in plan.held.iter().enumerate() {
        let off_m = distance(region, skin, organs, skins, gravity);
        let mut nearest = (f64::INFINITY, Vec3::zeros());
        for ((flag, least_m), ball) in held.iter_mut().zip(&mut all_off_m).zip(balls) {
            let off_m = off_m(ball);
            *flag |= off_m <= 0.0;
            *least_m = least_m.min(off_m);
            if off_m < nearest.0 {
                nearest = (off_m, ball.center);
            }
        }
        if nearest.0 > 0.0 && !balls.is_empty() {
            let count = balls.len();
            return Err(error(says_nothing(number, region, nearest, count)));
        }
    }
    // If an entry holds the whole height, the organ is meant to be fixed.
    let is_fixed = (plan.held.iter()).any(|it| matches!(it, Region::Base(share) if *share >= 1.0));
    if !is_fixed && !held.is_empty() && held.iter().all(|held| *held) {
        let entries: Vec<String> = plan.held.iter().map(described).collect();
        let hint = plan
            .held
            .iter()
            .find_map(in_millimetres)
            .unwrap_or_default();
        return Err(error(format!(
            "held catches all of its {} spheres, so nothing of it can move ({}); hold a part of it, such \
             as held = [{{ base = 0.15 }}]{hint}",
            held.len(),
            entries.join(", ")
        )));
    }
    Ok(Held {
        spheres: held,
        off_m: all_off_m,
    })
}

/// Distance of a sphere from a region, m; within the region, minus the distance to its border.
fn distance<'a>(
    region: &'a Region,
    skin: &Mesh,
    organs: &[OrganPlan],
    skins: &'a [Mesh],
    gravity: &Vec3,
) -> Box<dyn Fn(&Ball) -> f64 + 'a> {
    match region {
        Region::Box { min_m, max_m } => {
            let (min, max) = (Vec3::from(*min_m), Vec3::from(*max_m));
            Box::new(move |b| {
                let off = (min - b.center).sup(&(b.center - max));
                off.sup(&Vec3::zeros()).norm() + off.max().min(0.0)
            })
        }
        Region::Plane { .. } | Region::Base(_) => {
            let plane = Plane::of(region, skin, gravity);
            let [low, high] = skin.bounds();
            let height_m = (high - low).norm();
            Box::new(move |b| match plane {
                Some(plane) => -plane.depth_m(&b.center) - ON_PLANE_M,
                None => height_m,
            })
        }
        Region::Ball { center_m, radius_m } => {
            let center = Vec3::from(*center_m);
            Box::new(move |b| (b.center - center).norm() - radius_m)
        }
        Region::Near { organ, within_m } => {
            let index = organs.iter().position(|o| o.name == *organ);
            let nearest = index.and_then(|i| Nearest::new(&skins[i]));
            Box::new(move |b| {
                nearest.as_ref().map_or(f64::INFINITY, |near| {
                    near.distance(&b.center) - b.radius_m - within_m
                })
            })
        }
    }
}

/// Message of an entry that holds nothing. `nearest` has the distance and the centre of the nearest
/// sphere.
fn says_nothing(number: usize, region: &Region, nearest: (f64, Vec3), count: usize) -> String {
    let (off_m, at) = nearest;
    let remedy = match region {
        Region::Near { .. } => "give a larger within_m",
        Region::Base(_) => "give a larger share, such as held = [{ base = 0.3 }] in a recipe",
        _ => "move it onto the organ, make it larger, or give the organ more spheres",
    };
    format!(
        "held[{number}], a {}, catches none of its {count} spheres; the nearest is {:.1} mm off, at \
         [{:.3}, {:.3}, {:.3}] m; {remedy}{}",
        described(region),
        1e3 * off_m,
        at.x,
        at.y,
        at.z,
        in_millimetres(region).unwrap_or_default()
    )
}

/// A region in words, with its place.
fn described(region: &Region) -> String {
    match region {
        Region::Box { min_m, max_m } => {
            let middle: Vec<f64> = (0..3).map(|k| 0.5 * (min_m[k] + max_m[k])).collect();
            let size: Vec<String> = (0..3)
                .map(|k| format!("{:.0}", 1e3 * (max_m[k] - min_m[k])))
                .collect();
            format!("box of {} mm around {middle:.3?} m", size.join(" x "))
        }
        Region::Plane { point_m, normal } => {
            format!("plane at {point_m:?} m that holds what lies towards {normal:?}")
        }
        Region::Ball { center_m, radius_m } => {
            format!(
                "ball of {:.1} mm radius around {center_m:?} m",
                1e3 * radius_m
            )
        }
        Region::Near { organ, within_m } => {
            format!("region within {:.1} mm of '{organ}'", 1e3 * within_m)
        }
        Region::Base(share) => format!("base of {:.0} % of the height", 1e2 * share),
    }
}

/// Coordinates larger than this were probably written in millimetres, m.
const SUSPECT_M: f64 = 2.0;

/// Hint for a region whose numbers are too large for metres.
fn in_millimetres(region: &Region) -> Option<&'static str> {
    let numbers: Vec<f64> = match region {
        Region::Box { min_m, max_m } => [*min_m, *max_m].concat(),
        Region::Plane { point_m, .. } => point_m.to_vec(),
        Region::Ball { center_m, radius_m } => [&center_m[..], &[*radius_m]].concat(),
        Region::Near { .. } | Region::Base(_) => Vec::new(),
    };
    let is_large = numbers.iter().any(|x| x.abs() > SUSPECT_M);
    is_large.then_some("; numbers above 2 m look like millimetres: write them in metres")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::pack_evenly;
    use crate::shape::{Form, Shape};
    use crate::tetra;

    /// Only the tissue before the plane deforms, whatever the number of spheres.
    #[test]
    fn tetrahedra_end_where_what_is_held_ends() {
        let mesh = Shape::from(Form::Liver).mesh();
        let volume_m3 = mesh.volume();
        let [min, max] = mesh.bounds();
        let plane = Plane {
            point_m: min * 0.4 + max * 0.6,
            normal: Vec3::new(1.0, 0.0, 0.2).normalize(),
        };
        for count in [120, 300] {
            let interior = Interior::new(&mesh, volume_m3, count).expect("thick enough");
            let points = interior.points.iter();
            let free = points
                .filter(|i| !plane.holds(&interior.position(**i)))
                .count();
            let free_m3 = volume_m3 * free as f64 / interior.points.len() as f64;
            let carried = |balls: &[Ball], planes: &[Plane]| {
                let tets = tetra::fill_between(&interior, balls, volume_m3, planes);
                let deforms = |t: &&tetra::Tetra| {
                    let mut corners = t.spheres.iter().map(|i| balls[*i as usize].center);
                    !corners.all(|p| plane.holds(&p))
                };
                tets.iter()
                    .filter(deforms)
                    .map(|t| t.volume_m3)
                    .sum::<f64>()
                    / free_m3
            };
            let mut balls = pack_evenly(&interior, count);
            let packed = carried(&balls, &[]);
            onto_planes(&[plane], &interior, &mut balls);
            let moved = carried(&balls, &[plane]);
            assert!(packed > 1.015, "{count}: {packed}");
            assert!((moved - 1.0).abs() < 0.02, "{count}: {moved}");
            let inside = balls.iter().all(|b| interior.depth(&b.center) > 0.0);
            assert!(inside, "{count}");
        }
    }

    #[test]
    fn a_base_is_a_share_of_the_height_and_other_regions_have_no_plane() {
        let mesh = Shape::from(Form::Stomach).mesh();
        let [min, max] = mesh.bounds();
        let plane = Plane::of(&Region::Base(0.25), &mesh, &(Vec3::z() * -9.81)).expect("a plane");
        let edge = min.z + 0.25 * (max.z - min.z);
        assert!((plane.depth_m(&Vec3::new(0.3, 0.1, edge))).abs() < 1e-9);
        assert!(plane.holds(&min) && !plane.holds(&max));
        let region = |region| Plane::of(&region, &mesh, &Vec3::z());
        assert_eq!(region(Region::Base(0.0)), None);
        let center_m = [0.0; 3];
        assert_eq!(
            region(Region::Ball {
                center_m,
                radius_m: 0.1
            }),
            None
        );
        let [point_m, normal] = [[0.0; 3]; 2];
        assert_eq!(region(Region::Plane { point_m, normal }), None);
    }
}
