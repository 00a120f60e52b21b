//! A body whose far parts are skipped has the same distances, bit for bit, as a body of which every
//! part is computed.

use super::anatomy::Anatomy;
use super::bodies::Bodies;
use super::primitive::{Tube, ball, carve, join, meet};
use super::{connective_tissue, fat, gallbladder, liver, place, stomach};
use crate::Vec3;

/// Anatomies without a cover of fat, with a usual one, and with the thickest that a recipe allows.
fn anatomies() -> [Bodies; 3] {
    [0.0, 3.0, 8.0].map(|cover_mm| {
        place::bodies(&Anatomy {
            cover_mm,
            ..Anatomy::default()
        })
    })
}

/// Places on a grid in a box around the fat. The steps of this grid coincide with the steps of no
/// organ's own grid.
fn places(bodies: &Bodies) -> Vec<Vec3> {
    const STEPS: usize = 17;
    let [low, high] = fat::bounds(bodies);
    let (low, side) = (low.add_scalar(-0.01), (high - low).add_scalar(0.02));
    let share = |i: usize| (i % STEPS) as f64 / (STEPS - 1) as f64;
    (0..STEPS.pow(3))
        .map(|i| Vec3::new(share(i), share(i / STEPS), share(i / STEPS / STEPS)))
        .map(|share| low + side.component_mul(&share))
        .collect()
}

/// Distance to the gallbladder, with every part computed.
fn plain_gallbladder(bodies: &Bodies, p: &Vec3) -> f64 {
    let (pouch, radius) = bodies.pouch;
    let pouch = ball(p, pouch.into(), radius);
    join(bodies.gallbladder.distance(p), pouch, 0.007)
}

/// Distance to the liver, with every part computed except those of `liver::body`.
fn plain_liver(bodies: &Bodies, p: &Vec3) -> f64 {
    let body = liver::body(p, &bodies.anatomy.liver);
    let fossa = plain_gallbladder(bodies, p) - gallbladder::FOSSA_GAP_M;
    carve(body, fossa, 0.006)
}

/// Distance to the fat's body, with every part computed.
fn plain_fat_body(bodies: &Bodies, p: &Vec3) -> f64 {
    let fat = bodies.fat.distance(p);
    let Some(cloak) = &bodies.cloak else {
        return fat;
    };
    let cover_m = 1e-3 * bodies.anatomy.cover_mm;
    let cuff = |tube: &Tube| tube.distance(p) - cover_m;
    let cuffs = join(
        cuff(&bodies.cystic_duct),
        cuff(&bodies.cystic_artery),
        0.004,
    );
    let near = (p - bodies.origin).norm() - 0.004 - cover_m;
    let cuffs = join(
        cuffs,
        meet(cuff(&bodies.hepatic_artery), near, 0.004),
        0.004,
    );
    join(join(fat, cuffs, 0.004), cloak.distance(p), 0.004)
}

#[test]
fn parts_that_are_skipped_change_no_bit() {
    let mut near = 0;
    for bodies in anatomies() {
        for p in places(&bodies) {
            let (told, plain) = (fat::body(&bodies, &p), plain_fat_body(&bodies, &p));
            let is_far = told > fat::FAR_M && plain > fat::FAR_M;
            assert!(is_far || told.to_bits() == plain.to_bits(), "fat at {p}");
            near += usize::from(!is_far);
            let (told, plain) = (
                gallbladder::distance(&bodies, &p),
                plain_gallbladder(&bodies, &p),
            );
            assert!(told.to_bits() == plain.to_bits(), "gallbladder at {p}");
            let (told, plain) = (liver::distance(&bodies, &p), plain_liver(&bodies, &p));
            assert!(told.to_bits() == plain.to_bits(), "liver at {p}");
        }
    }
    assert!(near > 1000, "{near} places in the fat or near it");
}

#[test]
fn a_limit_changes_only_bodies_beyond_it() {
    type Limited = fn(&Bodies, &Vec3, f64) -> f64;
    let limited: [(&str, Limited); 4] = [
        ("gallbladder", gallbladder::distance_below),
        ("liver", liver::distance_below),
        ("duodenum", stomach::duodenum_below),
        ("connective tissue", connective_tissue::distance_below),
    ];
    let [_, bodies, _] = anatomies();
    for p in places(&bodies) {
        for (name, below) in limited {
            let plain = below(&bodies, &p, f64::INFINITY);
            for limit_m in [-0.002, 0.001, 0.004, 0.012] {
                let told = below(&bodies, &p, limit_m);
                let is_same = told.to_bits() == plain.to_bits();
                assert!(
                    is_same || told >= limit_m && plain >= limit_m,
                    "{name} at {p}: {told}, without a limit of {limit_m} {plain}"
                );
            }
        }
    }
}
