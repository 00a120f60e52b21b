//! Parts of an organ that are thin for its spheres.
//!
//! The thickness at a place is the diameter of the largest ball that lies inside the organ and
//! contains the place. A part thinner than two spacings has tetrahedra that span its whole
//! thickness and bend too stiffly. A liver of 2 l with 581 spheres pushes back up to 27 % too hard
//! at its thin margin.

use crate::Vec3;
use crate::pack::Interior;
use crate::recipe::SPHERES_MAX;

/// Thickness below which a part is thin, in spacings of the spheres.
const THIN_SPACINGS: f64 = 2.0;
/// Least thin share of an organ's volume that is worth a warning. Every organ is thin at its edges:
/// the built-in organs by 0.8 to 1.0 %, the atlas' liver with 581 spheres by 4.6 %.
const SHARE_MIN: f64 = 0.02;

/// The thin part of an organ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thin {
    /// Share of the organ's volume.
    pub(crate) share: f64,
    /// Mean thickness, m.
    pub(crate) thickness_m: f64,
    /// Place with the most thin tissue around it, world frame, m.
    pub(crate) at: Vec3,
    /// Spacing of the spheres, m.
    pub(crate) spacing_m: f64,
}

/// The part that is thin for its spheres; `None` if it is too little to matter.
pub(crate) fn thin(interior: &Interior<'_>) -> Option<Thin> {
    let thickness_m = thickness(interior);
    let limit_m = THIN_SPACINGS * interior.spacing_m;
    let thin: Vec<(u32, f64)> = (interior.points.iter().zip(thickness_m))
        .filter(|(_, thickness_m)| *thickness_m < limit_m)
        .map(|(i, thickness_m)| (*i, thickness_m))
        .collect();
    let share = thin.len() as f64 / interior.points.len() as f64;
    if share < SHARE_MIN {
        return None;
    }
    let mean_m = thin.iter().map(|(_, m)| m).sum::<f64>() / thin.len() as f64;
    // About 300 of the places are tried, because all pairs would take too long.
    let places: Vec<Vec3> = thin.iter().map(|(i, _)| interior.position(*i)).collect();
    let step = places.len().div_ceil(300);
    let some: Vec<&Vec3> = places.iter().step_by(step).collect();
    let around = |at: &Vec3| some.iter().filter(|p| (**p - at).norm() < limit_m).count();
    let (mut at, mut most) = (places[0], 0);
    for place in &some {
        let count = around(place);
        if count > most {
            (at, most) = (**place, count);
        }
    }
    Some(Thin {
        share,
        thickness_m: mean_m,
        at,
        spacing_m: interior.spacing_m,
    })
}

impl Thin {
    /// The warning for an organ that has this thin part and this many spheres.
    pub(crate) fn warning(&self, organ: &str, spheres: usize) -> String {
        let [x, y, z]: [f64; 3] = self.at.into();
        format!(
            "'{organ}' has thin parts, {:.0} % of its volume, most of them around [{x:.3}, {y:.3}, {z:.3}] m; \
             they are {:.1} mm or {:.1} spheres thick on average, so they push back too hard; give it \
             about {} spheres (`spheres`, --spheres)",
            1e2 * self.share,
            1e3 * self.thickness_m,
            self.thickness_m / self.spacing_m,
            self.enough(spheres).min(SPHERES_MAX)
        )
    }

    /// Number of spheres for which the mean thickness of the thin part is two spacings, rounded up
    /// to hundreds.
    fn enough(&self, spheres: usize) -> usize {
        let finer = THIN_SPACINGS * self.spacing_m / self.thickness_m;
        (spheres as f64 * finer.powi(3) / 100.0).ceil() as usize * 100
    }
}

/// The thickness at each point of [`Interior::points`], m.
fn thickness(interior: &Interior<'_>) -> Vec<f64> {
    let (field, grid) = (&interior.field, &interior.field.grid);
    let depth_m = |i: usize| f64::from(-field.distance_m[i]);
    let mut radius_m = vec![0.0; grid.len()];
    for &i in &interior.points {
        let own_m = depth_m(i as usize);
        // If a neighbour is deeper by nearly a step of the grid, its ball contains this ball.
        let is_within = |n: usize| depth_m(n) > own_m + 0.9 * grid.cell_m;
        if grid.neighbours(i as usize).any(is_within) {
            continue;
        }
        let center = interior.own_position(i);
        let span = |k: usize| grid.span(k, center[k] - own_m, center[k] + own_m);
        for z in span(2) {
            for y in span(1) {
                let line = grid.position([0, y, z]);
                let off = (line.y - center.y).powi(2) + (line.z - center.z).powi(2);
                let half = (own_m * own_m - off).max(0.0).sqrt();
                let row = grid.index([0, y, z]);
                for x in grid.span(0, center.x - half, center.x + half) {
                    let held: &mut f64 = &mut radius_m[row + x];
                    *held = held.max(own_m);
                }
            }
        }
    }
    // A point that no ball covers has at least the ball around itself.
    let of = |i: &u32| 2.0 * f64::max(radius_m[*i as usize], depth_m(*i as usize));
    interior.points.iter().map(of).collect()
}
