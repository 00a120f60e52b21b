//! How a hook is held: which way its bent end turns, and what its parts pass on the way to a place.

use crate::sight::{Bar, off_line};
use crate::work::Vec3;

/// From the heel to the end, and from the heel to the shaft, m; radii, m (`rt_core::tool`).
pub(crate) const BEND_M: f64 = 0.004;
const STEM_M: f64 = 0.012;
pub(crate) const ELECTRODE_M: f64 = 0.0008;
const NECK_M: f64 = 0.001;
const SHAFT_M: f64 = 0.0025;
/// So much of the shaft is looked after, m.
const SEEN_M: f64 = 0.05;
/// Which part of the bent end works, from the heel.
pub(crate) const WORKS: f64 = 0.7;

/// A hook as a surgeon thinks of it: places along its middle, and how thick it is there, m.
#[derive(Debug, Clone)]
pub(crate) struct Hook {
    places: [(Vec3, f64); 15],
}

impl Hook {
    /// One whose bent end works at `at` and turns this way (of unit length), through this port.
    pub(crate) fn held(at: Vec3, bend: Vec3, port: Vec3) -> Self {
        let heel = at - bend * (WORKS * BEND_M);
        Self::along(heel, heel + bend * BEND_M, port)
    }

    /// The one in the picture.
    pub(crate) fn seen([heel, end]: [Vec3; 2], port: Vec3) -> Self {
        Self::along(heel, end, port)
    }

    fn along(heel: Vec3, end: Vec3, port: Vec3) -> Self {
        let out = (port - heel).normalize();
        let joint = heel + out * STEM_M;
        let places = std::array::from_fn(|number| match number {
            0..=2 => (heel.lerp(&end, 0.5 * number as f64), ELECTRODE_M),
            3..=6 => (heel.lerp(&joint, 0.25 * (number - 2) as f64), NECK_M),
            _ => {
                let share = (number - 6) as f64 / 8.0;
                (joint + out * (SEEN_M * share * share), SHAFT_M)
            }
        });
        Self { places }
    }

    /// How much room there is between it and the nearest of these, m, and the way from there.
    pub(crate) fn room<'a>(&self, bars: impl IntoIterator<Item = &'a Bar>) -> (f64, Vec3) {
        let mut least = (f64::MAX, Vec3::zeros());
        for bar in bars {
            let [a, b] = bar.ends;
            let way = b - a;
            let squared = way.norm_squared().max(1e-12);
            for (place, radius_m) in &self.places {
                let share = ((place - a).dot(&way) / squared).clamp(0.0, 1.0);
                let off = place - a - way * share;
                let room_m = off.norm() - radius_m - bar.radius_m;
                if room_m < least.0 {
                    least = (room_m, off);
                }
            }
        }
        (least.0, least.1.try_normalize(1e-9).unwrap_or_default())
    }
}

/// Ways that the bent end can turn about a shaft along `along`, beginning with `bend` as it is: each
/// with how far it is to turn, rad.
pub(crate) fn turns(bend: Vec3, along: Vec3, count: u32) -> impl Iterator<Item = (Vec3, f64)> {
    let first = (bend - along * bend.dot(&along)).normalize();
    let side = along.cross(&first);
    (0..count).map(move |number| {
        let mut angle = std::f64::consts::TAU * f64::from(number) / f64::from(count);
        if angle > std::f64::consts::PI {
            angle -= std::f64::consts::TAU;
        }
        (first * angle.cos() + side * angle.sin(), angle)
    })
}

/// Room between an electrode's side and the nearest of these bars, m.
pub(crate) fn electrode_room_m<'a>(
    [a, b]: [Vec3; 2],
    bars: impl IntoIterator<Item = &'a Bar>,
) -> f64 {
    let room_m = bars.into_iter().flat_map(|bar| {
        let places = (0..=4).map(move |step| a.lerp(&b, f64::from(step) / 4.0));
        places.map(|at| off_line(at, bar.ends) - bar.radius_m - ELECTRODE_M)
    });
    room_m.fold(f64::MAX, f64::min)
}
