//! Geometry of a held hook: the directions of its bent end, and the room that its parts have.

use crate::sight::{Bar, between};
use crate::vector::Vec3;

/// Length of the hook's bent end, from heel to end, m. This size and those below are as in
/// `rt_core::tool`.
pub(crate) const BEND_M: f64 = 0.004;
/// Length of the neck between the heel and the shaft, m.
const STEM_M: f64 = 0.012;
/// Radius of the bent end, m.
pub(crate) const ELECTRODE_M: f64 = 0.0008;
/// Radius of the neck, m.
const NECK_M: f64 = 0.001;
/// Radius of the shaft, m.
const SHAFT_M: f64 = 0.0025;
/// Length of shaft that is checked, m.
const SEEN_M: f64 = 0.05;
/// Distance of the working point from the heel, as a share of the bent end's length.
pub(crate) const WORKS: f64 = 0.7;

/// A hook as the surgeon models it: the axes of its parts, end to end, and their radii, m.
#[derive(Debug, Clone)]
pub(crate) struct Hook {
    parts: [([Vec3; 2], f64); 3],
}

impl Hook {
    /// The hook through this port whose bent end works at `at`, in the direction `bend` (a unit
    /// vector).
    pub(crate) fn held(at: Vec3, bend: Vec3, port: Vec3) -> Self {
        let heel = at - bend * (WORKS * BEND_M);
        Self::along(heel, heel + bend * BEND_M, port)
    }

    /// The hook as seen in the picture.
    pub(crate) fn seen([heel, end]: [Vec3; 2], port: Vec3) -> Self {
        Self::along(heel, end, port)
    }

    fn along(heel: Vec3, end: Vec3, port: Vec3) -> Self {
        let out = (port - heel).normalize();
        let joint = heel + out * STEM_M;
        let parts = [
            ([heel, end], ELECTRODE_M),
            ([heel, joint], NECK_M),
            ([joint, joint + out * SEEN_M], SHAFT_M),
        ];
        Self { parts }
    }

    /// Room between the hook and the nearest of these bars, m, and the direction away from that
    /// bar.
    pub(crate) fn room<'a>(&self, bars: impl IntoIterator<Item = &'a Bar>) -> (f64, Vec3) {
        let mut least = (f64::MAX, Vec3::zeros());
        for bar in bars {
            for (ends, radius_m) in self.parts {
                let off = between(ends, bar.ends);
                let room_m = off.norm() - radius_m - bar.radius_m;
                if room_m < least.0 {
                    least = (room_m, off);
                }
            }
        }
        (least.0, least.1.try_normalize(1e-9).unwrap_or_default())
    }
}

/// Directions of the bent end about a shaft along `along`. The first is the present direction
/// `bend`. Each comes with its angle from the first, rad.
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

/// Room between the electrode's side and the nearest of these bars, m.
pub(crate) fn electrode_room_m<'a>(
    ends: [Vec3; 2],
    bars: impl IntoIterator<Item = &'a Bar>,
) -> f64 {
    let room_m = bars
        .into_iter()
        .map(|bar| between(ends, bar.ends).norm() - bar.radius_m - ELECTRODE_M);
    room_m.fold(f64::MAX, f64::min)
}

/// Point at which the hook takes a cell, m. If one of these bars is within `near_m`, the point is
/// `off_m` from the cell's centre, on the side that faces away from the bar. Otherwise it is the
/// centre.
pub(crate) fn free_side<'a>(
    at: Vec3,
    off_m: f64,
    near_m: f64,
    bars: impl IntoIterator<Item = &'a Bar>,
) -> Vec3 {
    let offs = bars.into_iter().map(|bar| {
        let off = between([at; 2], bar.ends);
        (off.norm() - bar.radius_m, off)
    });
    let nearest = offs.min_by(|a, b| a.0.total_cmp(&b.0));
    let away = nearest.filter(|(room_m, _)| *room_m < near_m);
    let away = away.and_then(|(_, off)| off.try_normalize(1e-9));
    at + away.unwrap_or_default() * off_m
}
