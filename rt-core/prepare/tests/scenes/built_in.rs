//! The built-in organs: they are sound, as large as in an atlas, and the same with any number of
//! threads.

use std::path::Path;

use scene_prepare::{Prepared, Recipe, Vec3, prepare, tetra};

use crate::sound::{assert_json_has_all_keys, check};

#[test]
fn built_in_scene_is_sound_and_anatomical() {
    let mut steps = Vec::new();
    let prepared = prepare(&Recipe::built_in().unwrap(), &mut |p| steps.push(p.done)).unwrap();
    check(&prepared);
    assert!(steps.is_sorted() && steps.len() >= 4, "{steps:?}");
    assert!(steps.iter().all(|done| (0.0..=1.0).contains(done)));
    let volume = |name: &str| {
        prepared
            .report
            .organs
            .iter()
            .find(|o| o.name == name)
            .unwrap()
            .volume_ml
    };
    assert!(
        (1200.0..1800.0).contains(&volume("liver")),
        "{}",
        volume("liver")
    );
    assert!(
        (30.0..50.0).contains(&volume("gallbladder")),
        "{}",
        volume("gallbladder")
    );
    assert_json_has_all_keys(&prepared.report);
}

/// Volumes, lengths and widths of the organs of the operation are as in an atlas.
#[test]
fn organs_are_as_large_as_in_an_atlas() {
    let prepared = crate::prepared_triangle(false);
    let scene = &prepared.scene;
    let organ = |name: &str| {
        let i = prepared
            .report
            .organs
            .iter()
            .position(|o| o.name == name)
            .unwrap();
        (&prepared.report.organs[i], &scene.organs[i])
    };
    let volume_ml = |name: &str| organ(name).0.volume_ml;
    let between = |what: &str, value: f64, range: std::ops::RangeInclusive<f64>| {
        assert!(
            range.contains(&value),
            "{what}: {value}, expected {range:?}"
        );
    };
    between("liver, mL", volume_ml("liver"), 1200.0..=1800.0);
    between("gallbladder, mL", volume_ml("gallbladder"), 30.0..=50.0);
    between("stomach, mL", volume_ml("stomach"), 400.0..=1200.0);

    let vertices = |name: &str| {
        let [first, count] = organ(name).1.vertices.map(|x| x as usize);
        let all = &scene.vertices[first..first + count];
        let points: Vec<Vec3> = all
            .iter()
            .map(|v| Vec3::from(v.position_m.map(f64::from)))
            .collect();
        points
    };
    // Find the greatest length, and the width across it.
    let gallbladder = vertices("gallbladder");
    let (mut length, mut axis) = (0.0, Vec3::x());
    for a in &gallbladder {
        for b in &gallbladder {
            if (b - a).norm() > length {
                length = (b - a).norm();
                axis = (b - a) / length;
            }
        }
    }
    let across = axis.cross(&Vec3::z()).normalize();
    let along: Vec<f64> = gallbladder.iter().map(|p| p.dot(&across)).collect();
    let width = along.iter().copied().fold(f64::MIN, f64::max)
        - along.iter().copied().fold(f64::MAX, f64::min);
    between("gallbladder's length, m", length, 0.075..=0.1);
    between("gallbladder's width, m", width, 0.028..=0.035);

    for (name, long, wide) in [
        ("cystic duct", 0.025..=0.04, 0.0025..=0.004),
        ("bile duct", 0.05..=0.09, 0.005..=0.0075),
        ("cystic artery", 0.01..=0.035, 0.0015..=0.003),
    ] {
        let (_, record) = organ(name);
        let [first, count] = record.spheres.map(|x| x as usize);
        let links = &scene.links[record.links[0] as usize..][..record.links[1] as usize];
        // The shortest links are those between spheres that follow each other.
        let mut steps: Vec<f64> = links.iter().map(|l| f64::from(l.rest_length_m)).collect();
        steps.sort_by(f64::total_cmp);
        let length: f64 =
            steps[..count - 1].iter().sum::<f64>() * count as f64 / (count - 1) as f64;
        between(&format!("{name}'s length, m"), length, long);
        let mut radii: Vec<f64> = scene.spheres[first..first + count]
            .iter()
            .map(|s| f64::from(s.radius_m))
            .collect();
        radii.sort_by(f64::total_cmp);
        between(&format!("{name}'s width, m"), 2.0 * radii[count / 2], wide);
    }
}

/// The table `[anatomy]` changes sizes and places. Organs still hardly overlap.
#[test]
fn sizes_and_places_are_parameters() {
    let changed = scene_prepare::recipe::TRIANGLE.replace(
        "course = \"usual\"",
        "course = \"usual\"\nliver = { size = 1.05 }\n\
         gallbladder = { width = 1.15, shift_mm = [-2, 0, -1] }\ncystic-duct = { width = 1.3 }",
    );
    let usual = crate::prepared_triangle(false);
    let recipe = Recipe::parse(&changed, "changed", Path::new(".")).unwrap();
    let other = prepare(&recipe, &mut |_| {}).unwrap();
    let ratio = |name: &str| {
        let volume = |p: &Prepared| {
            let organ = p.report.organs.iter().find(|o| o.name == name);
            organ.unwrap().volume_ml
        };
        volume(&other) / volume(usual)
    };
    assert!((1.1..1.2).contains(&ratio("liver")), "{}", ratio("liver"));
    assert!(
        (1.2..1.4).contains(&ratio("gallbladder")),
        "{}",
        ratio("gallbladder")
    );
    assert!(
        (1.5..1.8).contains(&ratio("cystic duct")),
        "{}",
        ratio("cystic duct")
    );
    assert!((ratio("stomach") - 1.0).abs() < 0.1);
    let overlap = deepest_overlap(&other);
    assert!(overlap < 0.0012, "organs overlap by {overlap} m");
}

/// Greatest depth of a sphere of one organ in a sphere of another, m.
pub(crate) fn deepest_overlap(prepared: &Prepared) -> f64 {
    let scene = &prepared.scene;
    let organ_of = |i: usize| {
        scene
            .organs
            .iter()
            .position(|o| i < (o.spheres[0] + o.spheres[1]) as usize)
    };
    let mut deepest = f64::NEG_INFINITY;
    for (i, a) in scene.spheres.iter().enumerate() {
        for (j, b) in scene.spheres.iter().enumerate().skip(i + 1) {
            let gap = Vec3::from(a.center_m.map(f64::from)) - Vec3::from(b.center_m.map(f64::from));
            let depth = f64::from(a.radius_m + b.radius_m) - gap.norm();
            if depth > deepest && organ_of(i) != organ_of(j) {
                deepest = depth;
            }
        }
    }
    deepest
}

#[test]
fn tetrahedra_carry_the_whole_volume_and_stand_upright() {
    let prepared = crate::prepared_built_in();
    for (organ, tets) in prepared.scene.organs.iter().zip(&prepared.tetrahedra) {
        let carried: f64 = tets.iter().map(|t| t.volume_m3).sum();
        // Tissue between a free and a held sphere counts more, because it is stiffer.
        let share = carried / f64::from(organ.volume_m3);
        assert!((1.0 - 1e-6..1.1).contains(&share), "{share}");
        let [first, count] = organ.spheres.map(|x| x as usize);
        let spheres = &prepared.scene.spheres[first..first + count];
        let centers: Vec<Vec3> = spheres
            .iter()
            .map(|s| Vec3::from(s.center_m.map(f64::from)))
            .collect();
        let mut used = vec![false; count];
        for t in tets {
            assert!(tetra::shape(&centers, &t.spheres) > 0.9 * tetra::SHAPE_MIN);
            assert!(t.volume_m3 > 0.0);
            t.spheres.iter().for_each(|&i| used[i as usize] = true);
        }
        let unused = used.iter().filter(|used| !**used).count();
        assert!(
            unused * 100 <= count,
            "{unused} of {count} spheres in no tetrahedron"
        );
    }
}

#[test]
fn same_bytes_on_any_number_of_threads() {
    let recipe = Recipe::built_in().unwrap();
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            prepare(&recipe, &mut |_| {})
                .unwrap()
                .scene
                .to_bytes()
                .unwrap()
        })
    };
    let one = bytes(1);
    for threads in [1, 2, 5] {
        assert!(one == bytes(threads), "on {threads} threads");
    }
}
