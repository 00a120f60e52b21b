//! Scenes of a few balls before a camera at the origin that looks along −z.

use super::*;
use crate::anatomy::Ball;

const DUCT: u32 = 0;
const ARTERY: u32 = 1;
const FAT: u32 = 2;
const LIVER: u32 = 3;

/// Duct and artery side by side 10 cm before the lens, and between them ten cells of the triangle.
/// The bed's cells lie beside.
fn scene() -> Anatomy {
    let organs = [
        ("cystic duct", OrganKind::CysticDuct),
        ("cystic artery", OrganKind::CysticArtery),
        ("fat", OrganKind::Fat),
        ("liver", OrganKind::Liver),
    ];
    let cells: Vec<Region> = [Region::Triangle, Region::LowerBed]
        .into_iter()
        .flat_map(|it| [it; 10])
        .collect();
    let mut anatomy = Anatomy::new(&organs, &cells);
    let ball = |organ, at_m, cell| Ball {
        at_m,
        radius_m: 0.002,
        organ,
        cell,
    };
    for step in 0..10 {
        let x_m = 0.004 * f64::from(step) - 0.018;
        let index = step as usize;
        anatomy.balls.extend([
            ball(DUCT, [x_m, -0.01, -0.1], None),
            ball(ARTERY, [x_m, 0.01, -0.1], None),
            ball(FAT, [x_m, 0.0, -0.1], Some(index)),
            ball(FAT, [x_m, 0.02, -0.1], Some(10 + index)),
        ]);
    }
    anatomy.scope_port_m = [0.0, 0.0, 0.1];
    anatomy
}

fn look(anatomy: &Anatomy, camera: &PoseMsg, gone: core::ops::Range<usize>) -> Cvs {
    let mut views = Views::default();
    views.look(1.0, camera, anatomy, &|cell| gone.contains(&cell));
    views.cvs()
}

fn is(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
}

#[test]
fn what_is_cleared_and_in_view_is_seen() {
    let cvs = look(&scene(), &PoseMsg::IDENTITY, 0..15);
    let shown = cvs.front.expect("from the port's side");
    is(shown.triangle, 1.0);
    is(shown.lower_bed, 0.5);
    is(shown.two, 1.0);
    assert_eq!(cvs.behind, None);
    is(cvs.lower_bed.achieved, 0.5);
    is(cvs.lower_bed.visible, 0.5);
    let whole = look(&scene(), &PoseMsg::IDENTITY, 0..0);
    is(whole.triangle.visible, 0.0);
}

#[test]
fn what_lies_behind_something_or_outside_of_the_picture_is_not_seen() {
    let mut hidden = scene();
    hidden.balls.push(Ball {
        at_m: [0.0, -0.008, -0.08],
        radius_m: 0.005,
        organ: LIVER,
        cell: None,
    });
    let cvs = look(&hidden, &PoseMsg::IDENTITY, 0..20);
    assert!((0.4..0.9).contains(&cvs.two.visible), "{cvs:?}");
    is(cvs.lower_bed.visible, 1.0);
    // The camera looks the other way.
    let away = PoseMsg {
        orientation: [0.0, 1.0, 0.0, 0.0],
        ..PoseMsg::IDENTITY
    };
    let cvs = look(&scene(), &away, 0..20);
    is(
        cvs.triangle.visible + cvs.lower_bed.visible + cvs.two.visible,
        0.0,
    );
}

#[test]
fn a_view_from_behind_is_kept_beside_that_from_the_front() {
    let anatomy = scene();
    let behind = PoseMsg {
        position_m: [0.0, 0.0, -0.2],
        orientation: [0.0, 1.0, 0.0, 0.0],
    };
    let mut views = Views::default();
    for (at_s, camera) in [
        (0.0, PoseMsg::IDENTITY),
        (1.0, behind),
        (1.1, PoseMsg::IDENTITY),
    ] {
        views.look(at_s, &camera, &anatomy, &|cell| cell < 10);
    }
    let cvs = views.cvs();
    let at_s = |shown: Option<Shown>| shown.expect("a view").at_s;
    is(at_s(cvs.front), 0.0);
    is(at_s(cvs.behind), 1.0);
    is(cvs.behind.expect("a view").triangle, 1.0);
}

#[test]
fn a_scene_without_the_two_structures_has_no_view() {
    let none = Anatomy::new(&[("liver", OrganKind::Liver)], &[Region::Triangle]);
    let cvs = look(&none, &PoseMsg::IDENTITY, 0..1);
    assert_eq!((cvs.front, cvs.behind), (None, None));
}
