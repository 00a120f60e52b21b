//! Calot's triangle: tubes, cells, and attachments between organs.

use rt_core::capacity::MAX_ATTACHMENTS;
use scene_prepare::{Recipe, Vec3, prepare};
use shared_mem::scene::{CellRecord, OrganKind, WORLD};

use crate::built_in::deepest_overlap;
use crate::sound::check;

/// In both courses of cystic duct and cystic artery, each tube is a row of 12 to 80 spheres, of
/// which at least two are held or attached to other organs. Spheres of two organs hardly overlap.
#[test]
fn triangle_of_calot_is_sound_in_both_courses() {
    for variant in [false, true] {
        let prepared = crate::prepared_triangle(variant);
        check(prepared);
        let scene = &prepared.scene;
        for (organ, report) in scene.organs.iter().zip(&prepared.report.organs) {
            // Only tubes are checked here: they have no tetrahedra. Connective tissue has none
            // either, because it is a layer one sphere thick.
            if report.tetrahedra > 0 || organ.kind == OrganKind::ConnectiveTissue as u32 {
                continue;
            }
            let [first, count] = organ.spheres.map(|x| x as usize);
            assert!((12..=80).contains(&count), "{}: {count}", report.name);
            let spheres = &scene.spheres[first..first + count];
            let length: f64 = scene.links[organ.links[0] as usize..][..organ.links[1] as usize]
                .iter()
                .map(|l| f64::from(l.rest_length_m))
                .fold(f64::INFINITY, f64::min)
                * count as f64;
            assert!(
                (0.015..0.9).contains(&length),
                "{}: {length} m",
                report.name
            );
            let held = spheres.iter().filter(|s| s.held == 1).count();
            assert!(held + report.attached >= 2, "{}", report.name);
        }
        check_order(scene);
        check_ties(scene);
        check_cells(prepared);
        let overlap = deepest_overlap(prepared);
        assert!(overlap < 0.0005, "organs overlap by {overlap} m");
    }
}

/// The spheres of cystic duct and cystic artery are numbered from end to end. The start of a task
/// needs this to put clips at given shares of the length.
fn check_order(scene: &shared_mem::scene::SceneData) {
    for kind in [OrganKind::CysticDuct, OrganKind::CysticArtery] {
        let organ = scene.organs.iter().find(|organ| organ.kind == kind as u32);
        let [first, count] = organ.expect("it is there").spheres.map(|x| x as usize);
        let at =
            |sphere: &shared_mem::scene::SphereRecord| Vec3::from(sphere.center_m.map(f64::from));
        let steps = scene.spheres[first..first + count].windows(2);
        let lengths: Vec<f64> = steps
            .map(|two| (at(&two[1]) - at(&two[0])).norm())
            .collect();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        assert!(lengths.iter().all(|it| *it < 1.8 * mean), "{lengths:?}");
    }
}

/// Fat and connective tissue together have 3000 to 6000 cells, and each region over 200 of them.
fn check_cells(prepared: &scene_prepare::Prepared) {
    let scene = &prepared.scene;
    assert!(
        (3000..6000).contains(&scene.cells.len()),
        "{}",
        scene.cells.len()
    );
    for organ in &prepared.report.organs {
        let layered = ["fat", "connective tissue"].contains(&organ.name.as_str());
        assert_eq!(organ.cells.is_some(), layered, "{}", organ.name);
        let Some(cells) = organ.cells else { continue };
        assert!((cells.volume_share - 1.0).abs() < 0.04, "{cells:?}");
        assert!(cells.covered > 0.94, "{cells:?}");
        assert!(cells.shape_min > 0.0, "{cells:?}");
    }
    for region in [
        CellRecord::TRIANGLE,
        CellRecord::LOWER_BED,
        CellRecord::UPPER_BED,
    ] {
        let own = scene.cells.iter().filter(|cell| cell.region == region);
        assert!(own.count() > 200, "region {region}");
    }
    for cell in &scene.cells {
        let mut at = Vec3::zeros();
        for (&sphere, weight) in cell.spheres.iter().zip(cell.weights) {
            let center_m = scene.spheres[usize::from(sphere)].center_m;
            at += Vec3::from(center_m.map(f64::from)) * f64::from(weight);
        }
        // The weighted mean of a cell's spheres is the cell's middle. This is almost exact in fat,
        // which spheres fill. Connective tissue has a single sheet of spheres, and their mean lies
        // in the sheet.
        let off = (at - Vec3::from(cell.center_m.map(f64::from))).norm();
        let fat = cell.region <= CellRecord::TRIANGLE;
        assert!(off < if fat { 0.000_1 } else { 0.002 }, "{off} {cell:?}");
    }
}

/// Two threads lead to the world. Every other tie joins two organs, and its rest length is the
/// distance between its ends. Its compliance lies in the range of bars of tissue.
fn check_ties(scene: &shared_mem::scene::SceneData) {
    assert!(!scene.attachments.is_empty());
    let organ_of = |i: u32| {
        scene
            .organs
            .iter()
            .position(|o| i < o.spheres[0] + o.spheres[1])
    };
    let hung = scene.attachments.iter().filter(|tie| tie.b == WORLD);
    assert!(hung.clone().count() == 2 && hung.into_iter().all(|tie| tie.is_thread == 1));
    for tie in scene.attachments.iter().filter(|tie| tie.b != WORLD) {
        assert_ne!(organ_of(tie.a), organ_of(tie.b));
        let at = |i: u32| Vec3::from(scene.spheres[i as usize].center_m.map(f64::from));
        let length = (at(tie.a) - at(tie.b)).norm();
        assert!((length - f64::from(tie.rest_length_m)).abs() < 1e-6);
        assert!(length < 0.04, "{length}");
        assert!(
            tie.compliance_m_n > 1e-5 && tie.compliance_m_n < 100.0,
            "{tie:?}"
        );
    }
}

/// With 3200 spheres, more would be attached to other organs than the realtime process has room
/// for.
#[test]
fn triangle_of_many_spheres_has_fewer_ties_for_a_sphere() {
    let recipe = Recipe::triangle(false).unwrap().with_spheres(3200).unwrap();
    let prepared = prepare(&recipe, &mut |_| {}).unwrap();
    let ties = prepared.scene.attachments.len();
    println!("{ties} ties\n{}", prepared.report);
    assert!((512..=MAX_ATTACHMENTS).contains(&ties), "{ties} ties");
}
