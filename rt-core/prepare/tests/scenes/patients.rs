//! Patients: every case prepares, fits the realtime process, and is whole.

use std::path::Path;
use std::sync::OnceLock;

use rayon::prelude::*;
use rt_core::capacity::{MAX_ATTACHMENTS, MAX_CELLS};
use scene_prepare::patient::{NAMES, Patient, Wall};
use scene_prepare::recipe::{Recipe, TRIANGLE};
use scene_prepare::shape::Course;
use scene_prepare::{Prepared, Vec3, prepare};
use shared_mem::scene::{CellRecord, OrganKind, OrganRecord, SceneData, SphereRecord};

use crate::built_in::deepest_overlap;

/// Half of the endoscope's field of view, rad.
const HALF_RAD: f64 = 0.61;
/// Seeds that are prepared. The named patients have every course and every wall.
const SEEDS: [u64; 2] = [1, 2];

/// The named patients and those of the seeds, prepared once for all tests.
fn prepared() -> &'static [(Patient, Prepared)] {
    static ALL: OnceLock<Vec<(Patient, Prepared)>> = OnceLock::new();
    ALL.get_or_init(|| {
        let seeds = SEEDS.map(|seed| seed.to_string());
        let words = NAMES
            .iter()
            .copied()
            .chain(seeds.iter().map(String::as_str));
        let words: Vec<&str> = words.collect();
        words.par_iter().map(|word| prepare_one(word)).collect()
    })
}

fn prepare_one(word: &str) -> (Patient, Prepared) {
    let patient = Patient::of_word(word).expect("a patient");
    let recipe = patient.recipe().expect("a recipe");
    let prepared = prepare(&recipe, &mut |_| {});
    let prepared = prepared.unwrap_or_else(|problem| panic!("{patient}: {problem}"));
    (patient, prepared)
}

#[test]
fn every_patient_prepares_and_fits_the_tick() {
    for (patient, prepared) in prepared() {
        let (scene, report) = (&prepared.scene, &prepared.report);
        println!(
            "{patient}: {} cells, {} ties, {:.0} µs, built in {:.1} s",
            scene.cells.len(),
            scene.attachments.len(),
            report.tick_us,
            report.build_s
        );
        assert!(scene.cells.len() <= MAX_CELLS, "{patient}");
        assert!(scene.attachments.len() <= MAX_ATTACHMENTS, "{patient}");
        assert!(report.tick_us < 350.0, "{patient}: {} µs", report.tick_us);
        let overlap = deepest_overlap(prepared);
        assert!(overlap < 0.0012, "{patient}: organs overlap by {overlap} m");
        for organ in &report.organs {
            assert_eq!(organ.components, 1, "{patient}: {}", organ.name);
            let Some(cells) = organ.cells else { continue };
            let share = cells.volume_share;
            assert!((0.93..1.07).contains(&share), "{patient}: {cells:?}");
            assert!(cells.covered > 0.82, "{patient}: {cells:?}");
            assert!(cells.shape_min > 0.0, "{patient}: {cells:?}");
        }
    }
}

#[test]
fn every_patient_has_what_the_tasks_work_on() {
    for (patient, prepared) in prepared() {
        let scene = &prepared.scene;
        for kind in [
            OrganKind::CysticDuct,
            OrganKind::CysticArtery,
            OrganKind::BileDuct,
            OrganKind::Gallbladder,
        ] {
            let own = scene
                .organs
                .iter()
                .filter(|organ| organ.kind == kind as u32);
            assert_eq!(own.count(), 1, "{patient}: {kind:?}");
        }
        for region in [
            CellRecord::TRIANGLE,
            CellRecord::LOWER_BED,
            CellRecord::UPPER_BED,
        ] {
            let own = scene.cells.iter().filter(|cell| cell.region == region);
            let count = own.count();
            assert!(count > 100, "{patient}: {count} cells of region {region}");
        }
        let threads = scene.attachments.iter().filter(|tie| tie.is_thread == 1);
        assert_eq!(threads.count(), 2, "{patient}");
    }
}

/// Each end of a duct or vessel is at another organ, and duct and artery are in the first picture.
#[test]
fn no_tube_ends_in_the_air_or_leaves_the_field() {
    for (patient, prepared) in prepared() {
        let scene = &prepared.scene;
        for (number, organ) in scene.organs.iter().enumerate() {
            if !is_tube(organ) {
                continue;
            }
            let name = &prepared.report.organs[number].name;
            let own = spheres(scene, organ);
            for end in [own.first(), own.last()].into_iter().flatten() {
                let gap_mm = 1e3 * gap_to_others_m(scene, number, end);
                assert!(
                    gap_mm < 4.0,
                    "{patient}: {name} ends {gap_mm:.1} mm from all else"
                );
            }
            if [OrganKind::CysticDuct, OrganKind::CysticArtery]
                .iter()
                .any(|kind| organ.kind == *kind as u32)
            {
                for sphere in own {
                    let off = off_axis_rad(scene, sphere);
                    assert!(
                        off < HALF_RAD,
                        "{patient}: {name} is {off} rad off the picture"
                    );
                }
            }
        }
    }
}

fn is_tube(organ: &OrganRecord) -> bool {
    use OrganKind::{BileDuct, CysticArtery, CysticDuct, Vessel};
    let tubes = [BileDuct, CysticArtery, CysticDuct, Vessel];
    tubes.iter().any(|kind| organ.kind == *kind as u32)
}

fn spheres<'a>(scene: &'a SceneData, organ: &OrganRecord) -> &'a [SphereRecord] {
    let [first, count] = organ.spheres.map(|x| x as usize);
    &scene.spheres[first..first + count]
}

fn center(sphere: &SphereRecord) -> Vec3 {
    Vec3::from(sphere.center_m.map(f64::from))
}

/// Distance from a sphere to the skin of the nearest other organ that is no layered tissue, m.
fn gap_to_others_m(scene: &SceneData, own: usize, end: &SphereRecord) -> f64 {
    let layered = [OrganKind::Fat, OrganKind::ConnectiveTissue];
    let others = scene.organs.iter().enumerate().filter(|(number, organ)| {
        *number != own && layered.iter().all(|kind| organ.kind != *kind as u32)
    });
    let vertices = others.flat_map(|(_, organ)| {
        let [first, count] = organ.vertices.map(|x| x as usize);
        &scene.vertices[first..first + count]
    });
    let off_m = |at: [f32; 3]| (Vec3::from(at.map(f64::from)) - center(end)).norm();
    let nearest = vertices.map(|vertex| off_m(vertex.position_m));
    nearest.fold(f64::INFINITY, f64::min) - f64::from(end.radius_m)
}

fn off_axis_rad(scene: &SceneData, sphere: &SphereRecord) -> f64 {
    let camera = scene.room.expect("a room").world_from_camera;
    let [x, y, z, w] = camera.orientation.map(f64::from);
    let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let ahead = turn * -Vec3::z();
    (center(sphere) - Vec3::from(camera.position_m.map(f64::from))).angle(&ahead)
}

#[test]
fn same_seed_gives_the_same_bytes_and_another_seed_another_patient() {
    let bytes = |prepared: &Prepared| prepared.scene.to_bytes().unwrap();
    let of = |word: &str| {
        let all = prepared().iter();
        let mut own = all.filter(|(patient, _)| patient.name == word);
        own.next().map(|(_, prepared)| bytes(prepared)).unwrap()
    };
    let [one, two] = SEEDS.map(|seed| of(&seed.to_string()));
    assert!(one != two);
    assert!(one == bytes(&prepare_one("1").1));
}

/// Thousands of seeds stay within the limits of a recipe. All courses and walls occur.
#[test]
fn seeds_give_sound_recipes_and_every_kind_of_case() {
    let mut seen = Vec::new();
    for seed in (0..2000).chain([u64::MAX]) {
        let patient = Patient::of_seed(seed);
        assert_eq!(patient, Patient::of_word(&seed.to_string()).unwrap());
        assert!((18.0..=45.0).contains(&patient.bmi), "{patient}");
        assert!((3.4..=4.5).contains(&patient.cover_mm()), "{patient}");
        let stones = patient.stones;
        assert!(
            (1..=30).contains(&stones.count) && stones.share() < 0.6,
            "{patient}"
        );
        assert!((3.0..=25.0).contains(&stones.size_mm), "{patient}");
        patient
            .recipe()
            .unwrap_or_else(|problem| panic!("{patient}: {problem}"));
        seen.push((patient.course, patient.wall));
    }
    for course in [
        Course::Usual,
        Course::ShortDuct,
        Course::LowUnion,
        Course::ArteryInFront,
        Course::AccessoryArtery,
        Course::HumpedArtery,
    ] {
        for wall in [Wall::Normal, Wall::Acute, Wall::Scarred] {
            assert!(seen.contains(&(course, wall)), "{course:?}, {wall:?}");
        }
    }
}

#[test]
fn cover_and_adhesions_have_limits() {
    for (line, problem) in [
        ("cover_mm = 9", "anatomy.cover_mm: is 9; allowed: 0 to 8"),
        (
            "adhesion_mm = -1",
            "anatomy.adhesion_mm: is -1; allowed: 0 to 25",
        ),
    ] {
        let text = TRIANGLE.replace("course = \"usual\"", &format!("course = \"usual\"\n{line}"));
        let error = Recipe::parse(&text, "x", Path::new(".")).unwrap_err();
        assert!(error.to_string().contains(problem), "{error}");
    }
}
