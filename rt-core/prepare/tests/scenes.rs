//! Whole scenes: the built-in one, the atlas', and random blobs.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use scene_prepare::mesh::mend;
use scene_prepare::pack::{Interior, Quality, isotropy, pack_as_paper, pack_evenly};
use scene_prepare::recipe::Closing;
use scene_prepare::{Prepared, Recipe, Vec3, bind, links, prepare, tetra};
use shared_mem::scene::{OrganKind, SceneFile, WEIGHT_SUM};

fn check(prepared: &Prepared) {
    let scene = &prepared.scene;
    let file =
        SceneFile::from_bytes(&scene.to_bytes().expect("scene writes")).expect("scene reads");
    for (organ, report) in file.organs().iter().zip(&prepared.report.organs) {
        assert_eq!(report.components, 1, "{}", report.name);
        assert!(report.min_degree >= 3, "{}", report.name);
        assert!(report.protrusion_max_mm < 0.1, "{}", report.name);
        // A tube is packed along its line: no tetrahedra, all links one way.
        let is_tube = report.tetrahedra == 0;
        // A layer two millimetres thick is one sphere thick: spheres cannot fill it.
        let is_layer = organ.kind == OrganKind::ConnectiveTissue as u32;
        let least = match (is_tube, is_layer) {
            (_, true) => 0.35,
            (true, _) => 0.6,
            _ => 0.7,
        };
        assert!(
            report.coverage > least,
            "{}: {}",
            report.name,
            report.coverage
        );
        let [first, count] = organ.spheres.map(|x| x as usize);
        let spheres = &file.spheres()[first..first + count];
        let mass: f64 = spheres.iter().map(|s| f64::from(s.mass_kg)).sum();
        let expected = f64::from(organ.material.density_kg_m3) * f64::from(organ.volume_m3);
        assert!(
            (mass / expected - 1.0).abs() < 1e-5,
            "mass is density times volume"
        );
        let is_joined = file.attachments().iter().any(|tie| {
            [tie.a, tie.b]
                .iter()
                .any(|&s| s >= organ.spheres[0] && s < organ.spheres[0] + organ.spheres[1])
        });
        assert!(
            is_joined || spheres.iter().any(|s| s.held == 1),
            "{} is held or attached somewhere",
            report.name
        );
        assert!(
            spheres.iter().any(|s| s.held == 0),
            "{} is free somewhere",
            report.name
        );

        let is_tube = is_tube || is_layer;
        assert!(
            is_tube || report.tetrahedra > 3 * report.spheres / 2,
            "{}",
            report.name
        );
        assert!(
            is_tube || report.tetra_shape_min >= Some(tetra::SHAPE_MIN),
            "{}: {:?}",
            report.name,
            report.tetra_shape_min
        );
        assert!(
            is_tube || report.isotropy > 0.3,
            "{}: {}",
            report.name,
            report.isotropy
        );

        let [first, count] = organ.links.map(|x| x as usize);
        let list = &file.links()[first..first + count];
        let clashes = (1..list.len())
            .filter(|&i| {
                let recent = &list[i.saturating_sub(7)..i];
                let shares = |l: &shared_mem::scene::LinkRecord| {
                    [l.a, l.b]
                        .iter()
                        .any(|s| [list[i].a, list[i].b].contains(s))
                };
                recent.iter().any(shares)
            })
            .count();
        assert!(
            is_tube || clashes * 40 < list.len(),
            "{}: {clashes} of {} links wait",
            report.name,
            list.len()
        );
        for link in list {
            let at = |i: u32| Vec3::from(file.spheres()[i as usize].center_m.map(f64::from));
            let length = (at(link.a) - at(link.b)).norm();
            assert!((length - f64::from(link.rest_length_m)).abs() < 1e-6);
        }
    }
    for v in file.vertices() {
        let normal = Vec3::from(v.normal.map(f64::from)).norm();
        assert!((normal - 1.0).abs() < 1e-4);
        assert_eq!(
            v.weights.iter().map(|&w| u32::from(w)).sum::<u32>(),
            WEIGHT_SUM
        );
    }
    check_room(&file);
}

/// The instrument can work on the target: the handle stays within the device's reach.
fn check_room(file: &SceneFile) {
    let room = file.room();
    let port = Vec3::from(room.instrument_port_m.map(f64::from));
    let base = Vec3::from(room.world_from_device.position_m.map(f64::from));
    let target = Vec3::from(room.target_m.map(f64::from));
    let normal = Vec3::from(room.target_normal.map(f64::from));
    let length = f64::from(room.instrument_length_m);
    for offset in [-0.02, 0.0, 0.03, 0.05] {
        let tip = target + normal * offset;
        let inside = (tip - port).norm();
        assert!(
            (0.06..0.22).contains(&(length - inside)),
            "{} m outside",
            length - inside
        );
        let handle = port - (tip - port) / inside * (length - inside);
        assert!(
            (handle - base).norm() < 0.08,
            "handle {} m off",
            (handle - base).norm()
        );
    }
    assert!(
        (target - port).normalize().dot(&normal) < -0.3,
        "the shaft comes in steeply"
    );
}

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

/// Every figure that the report promises, of the whole and of each organ.
fn assert_json_has_all_keys(report: &scene_prepare::Report) {
    let json = serde_json::to_value(report).expect("JSON");
    let organs = json["organs"].as_array().expect("a list");
    assert_eq!(organs.len(), report.organs.len());
    for key in [
        "build_s",
        "spheres",
        "springs",
        "tetrahedra",
        "coverage",
        "gap_mean_mm",
        "gap_95_mm",
        "gap_max_mm",
        "protrusion_max_mm",
        "components",
        "min_degree",
        "isotropy",
        "tetra_shape_min",
        "volume_ml",
        "mass_g",
    ] {
        for figures in organs.iter().chain([&json]) {
            assert!(figures[key].is_number(), "{key} of {figures}");
        }
    }
}

/// A mesh by itself, as coarse as can be: no vertex of it lies where the hand is to work.
#[test]
fn a_box_of_twelve_triangles_becomes_a_scene() {
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(|step| 100 * step);
        text.push_str(&format!("v {x} {y} {z}\n"));
    }
    for [a, b, c, d] in [
        [1, 3, 4, 2],
        [5, 6, 8, 7],
        [1, 2, 6, 5],
        [3, 7, 8, 4],
        [1, 5, 7, 3],
        [2, 4, 8, 6],
    ] {
        text.push_str(&format!("f {a} {b} {c} {d}\n"));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.obj");
    std::fs::write(&path, text).unwrap();
    let recipe = Recipe::from_mesh(&path, None).unwrap();
    let prepared = prepare(&recipe.with_spheres(60).unwrap(), &mut |_| {}).unwrap();
    check(&prepared);
    assert_json_has_all_keys(&prepared.report);
    assert!((prepared.report.volume_ml - 1000.0).abs() < 0.01);
}

/// Both courses of duct and artery: tubes of few spheres in a row, held at both ends, free
/// between them, and nothing of one organ inside another.
#[test]
fn triangle_of_calot_is_sound_in_both_courses() {
    for variant in [false, true] {
        let prepared = prepare(&Recipe::triangle(variant).unwrap(), &mut |_| {}).unwrap();
        check(&prepared);
        let scene = &prepared.scene;
        for (organ, report) in scene.organs.iter().zip(&prepared.report.organs) {
            // A layer one sphere thick has no tetrahedra either.
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
        check_ties(scene);
        let overlap = deepest_overlap(&prepared);
        assert!(overlap < 0.0005, "organs overlap by {overlap} m");
    }
}

/// Ties join different organs, are as long as their ends are apart, and give as a bar of tissue
/// that thick would: not nothing, and not more than the softest, fat, would.
fn check_ties(scene: &shared_mem::scene::SceneData) {
    assert!(!scene.attachments.is_empty());
    let organ_of = |i: u32| {
        scene
            .organs
            .iter()
            .position(|o| i < o.spheres[0] + o.spheres[1])
    };
    for tie in &scene.attachments {
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

/// As in an atlas: volumes, lengths and widths of what the procedure is about.
#[test]
fn organs_are_as_large_as_in_an_atlas() {
    let prepared = prepare(&Recipe::triangle(false).unwrap(), &mut |_| {}).unwrap();
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
    // Longest, and widest across it.
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
        // The row: links between spheres next to each other, the shortest at each.
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

/// The recipe's parameters do what they say, and neighbours make room.
#[test]
fn sizes_and_places_are_parameters() {
    let changed = scene_prepare::recipe::TRIANGLE.replace(
        "course = \"usual\"",
        "course = \"usual\"\nliver = { size = 1.05 }\n\
         gallbladder = { width = 1.15, shift_mm = [-2, 0, -1] }\ncystic-duct = { width = 1.3 }",
    );
    let of = |text: &str| {
        let recipe = Recipe::parse(text, "changed", Path::new(".")).unwrap();
        prepare(&recipe, &mut |_| {}).unwrap()
    };
    let (usual, other) = (of(scene_prepare::recipe::TRIANGLE), of(&changed));
    let ratio = |name: &str| {
        let volume = |p: &Prepared| {
            let organ = p.report.organs.iter().find(|o| o.name == name);
            organ.unwrap().volume_ml
        };
        volume(&other) / volume(&usual)
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

/// How deep a sphere of one organ reaches into a sphere of another.
fn deepest_overlap(prepared: &Prepared) -> f64 {
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
    let prepared = prepare(&Recipe::built_in().unwrap(), &mut |_| {}).unwrap();
    for (organ, tets) in prepared.scene.organs.iter().zip(&prepared.tetrahedra) {
        let carried: f64 = tets.iter().map(|t| t.volume_m3).sum();
        assert!((carried / f64::from(organ.volume_m3) - 1.0).abs() < 1e-6);
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
fn error_budget_chooses_the_smallest_count_that_keeps_it() {
    let text = "name = \"b\"\n[[organ]]\nname = \"liver\"\nkind = \"liver\"\nspheres = 300\n\
                shape = { form = \"liver\" }\nheld = [{ base = 0.2 }]\n";
    let with = |budget: &str| {
        let text = text.replace(
            "spheres = 300",
            &format!("spheres = 300\ngap_95_mm = {budget}"),
        );
        prepare(
            &Recipe::parse(&text, "budget", Path::new(".")).unwrap(),
            &mut |_| {},
        )
    };
    let coarse = with("6.0").unwrap().report;
    let fine = with("4.0").unwrap().report;
    assert!(coarse.gap_95_mm <= 6.0 && fine.gap_95_mm <= 4.0);
    assert!(
        coarse.gap_95_mm > 5.0 && fine.gap_95_mm > 3.5,
        "no more spheres than needed"
    );
    assert!(coarse.spheres < fine.spheres);
    assert!(fine.organs[0].spheres_because.contains("budget of 4.00 mm"));
    let impossible = with("0.06").unwrap_err().to_string();
    assert!(impossible.contains("allow a larger gap"), "{impossible}");
}

fn liver(keys: &str) -> Result<Prepared, scene_prepare::PrepareError> {
    let text = format!(
        "name = \"b\"\n{keys}\nshape = {{ form = \"liver\" }}\nheld = [{{ base = 0.2 }}]\n"
    );
    let text = text.replace("[[organ]]", "[[organ]]\nname = \"liver\"\nkind = \"liver\"");
    prepare(
        &Recipe::parse(&text, "budget", Path::new("."))?,
        &mut |_| {},
    )
}

#[test]
fn time_budget_chooses_the_largest_count_that_keeps_it() {
    let coarse = liver("tick_us = 25\n[[organ]]").unwrap().report;
    let fine = liver("tick_us = 90\n[[organ]]").unwrap().report;
    assert!(
        (0.9 * 25.0..=25.0).contains(&coarse.tick_us),
        "{}",
        coarse.tick_us
    );
    assert!(
        (0.9 * 90.0..=90.0).contains(&fine.tick_us),
        "{}",
        fine.tick_us
    );
    assert!(2 * coarse.spheres < fine.spheres);
    let because = &fine.organs[0].spheres_because;
    assert!(because.contains("of 90 µs allowed"), "{because}");
    // An error budget goes first; what is left cannot keep the time.
    let both = liver("tick_us = 25\n[[organ]]\ngap_95_mm = 4.5");
    let refused = both.unwrap_err().to_string();
    assert!(refused.contains("cannot keep tick_us = 25"), "{refused}");
}

#[test]
fn levels_of_detail_are_coarser_each() {
    let text = "name = \"b\"\n[[organ]]\nname = \"liver\"\nkind = \"liver\"\nspheres = 300\n\
                coarser = [150, 80]\nshape = { form = \"liver\" }\nheld = [{ base = 0.2 }]\n";
    let recipe = Recipe::parse(text, "levels", Path::new(".")).unwrap();
    assert_eq!(recipe.levels(), 3);
    let scenes: Vec<_> = (0..3)
        .map(|level| prepare(&recipe.level(level), &mut |_| {}).unwrap().scene)
        .collect();
    let spheres: Vec<usize> = scenes.iter().map(|scene| scene.spheres.len()).collect();
    assert_eq!(spheres, [300, 150, 80]);
    for coarser in &scenes[1..] {
        assert_eq!(
            coarser.room, scenes[0].room,
            "hand and camera stay where they are"
        );
        assert_eq!(coarser.triangles, scenes[0].triangles, "one skin");
    }
    let halved = recipe.with_levels(3, &[400]);
    assert_eq!(halved.organs[0].coarser, [200, 100]);
    let wrong = text.replace("[150, 80]", "[150, 160]");
    let refused = Recipe::parse(&wrong, "levels", Path::new("."))
        .unwrap_err()
        .to_string();
    assert!(refused.contains("each below the one before"), "{refused}");
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

/// Two balls of 2 cm, 6 cm from middle to middle, in millimetres.
fn two_balls() -> (tempfile::TempDir, PathBuf) {
    let ball = |x: f64| {
        let bounds = [
            Vec3::new(x - 0.022, -0.022, -0.022),
            Vec3::new(x + 0.022, 0.022, 0.022),
        ];
        let distance = move |p: &Vec3| (p - Vec3::x() * x).norm() - 0.02;
        scene_prepare::shape::skin(&distance, bounds, 0.004)
    };
    let mut mesh = ball(0.0);
    mesh.append(&ball(0.06));
    let mut text = String::new();
    for p in &mesh.vertices {
        text.push_str(&format!("v {} {} {}\n", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z));
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| i + 1);
        text.push_str(&format!("f {a} {b} {c}\n"));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("two.obj");
    std::fs::write(&path, text).expect("a file");
    (folder, path)
}

#[test]
fn far_pieces_are_refused_unless_the_recipe_says_what_to_do() {
    let (folder, _path) = two_balls();
    let with = |line: &str| {
        let text = format!(
            "name = \"two\"\n[[organ]]\nname = \"two\"\nkind = \"liver\"\nmesh = \"two.obj\"\n\
             unit = \"mm\"\nspheres = 120\nheld = [{{ base = 0.2 }}]\n{line}\n\
             [room]\nlook_at_m = [0.0, 0.0, 0.0]\n"
        );
        prepare(
            &Recipe::parse(&text, "two", folder.path()).unwrap(),
            &mut |_| {},
        )
    };
    let refused = with("").unwrap_err().to_string();
    assert!(
        refused.contains("two.obj") && refused.contains("2 separate pieces, up to 20.0 mm"),
        "{refused}"
    );
    assert!(refused.contains("pieces = \"largest\""), "{refused}");
    let joined = with("pieces = \"join\"").unwrap().report;
    assert_eq!(joined.components, 1);
    assert!(
        joined.organs[0]
            .mesh
            .contains("linked across up to 20.0 mm"),
        "{}",
        joined.organs[0].mesh
    );
    let largest = with("pieces = \"largest\"").unwrap().report;
    assert!((largest.volume_ml / joined.volume_ml - 0.5).abs() < 0.01);
}

#[test]
fn a_guessed_unit_is_said() {
    let (_folder, path) = two_balls();
    let mut recipe = Recipe::from_mesh(&path, None).unwrap();
    recipe.organs[0].pieces = scene_prepare::recipe::Pieces::Join;
    recipe.room.look_at_m = Some(Vec3::zeros());
    let story = |recipe: &Recipe| {
        prepare(recipe, &mut |_| {}).unwrap().report.organs[0]
            .mesh
            .clone()
    };
    let guessed = story(&recipe);
    assert!(
        guessed.contains("in millimetres as its size suggests: 100 mm across"),
        "{guessed}"
    );
    let told = Recipe::from_mesh(&path, Some(scene_prepare::recipe::Unit::Centimetre)).unwrap();
    let scene_prepare::recipe::Surface::Mesh { unit_m, .. } = &told.organs[0].surface else {
        panic!("a mesh")
    };
    assert_eq!(*unit_m, Some(0.01));
}

#[test]
fn a_count_for_the_whole_scene_is_shared_among_its_organs() {
    let recipe = Recipe::built_in().unwrap().with_spheres(1642).unwrap();
    let counts: Vec<usize> = recipe.organs.iter().map(|o| o.spheres).collect();
    assert_eq!(counts, [1162, 480]);
    let refused = Recipe::built_in().unwrap().with_spheres(10).unwrap_err();
    assert!(
        refused.to_string().contains("allowed are at least 8"),
        "{refused}"
    );
}

/// The folder of real organ meshes, if this machine has it.
fn anatomy() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/anatomy");
    let folder = std::env::var_os("CALOT_ANATOMY").map_or(beside, PathBuf::from);
    if folder.join("hra-female").is_dir() {
        return Some(folder);
    }
    println!(
        "skipped: no anatomy in {}; set CALOT_ANATOMY to its folder",
        folder.display()
    );
    None
}

#[test]
fn atlas_scene_is_sound() {
    let Some(folder) = anatomy() else { return };
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/hra-female.toml");
    let recipe = Recipe::load(&recipe, Some(&folder.join("hra-female"))).unwrap();
    let prepared = prepare(&recipe, &mut |_| {}).unwrap();
    check(&prepared);
    assert!(
        prepared.report.organs[0]
            .mesh
            .contains("1 open loops closed")
    );
}

/// Open-ended ducts, an artery with branches, the liver as 26 patches.
#[test]
fn atlas_tubes_and_patches_prepare() {
    let Some(folder) = anatomy() else { return };
    let organ = |name: &str, kind: &str, file: &str, part: &str, spheres: usize| {
        format!(
            "[[organ]]\nname = \"{name}\"\nkind = \"{kind}\"\nmesh = \"{file}\"\nparts = [\"{part}\"]\nspheres = {spheres}\nheld = [{{ base = 0.2 }}]\n"
        )
    };
    let text = [
        "name = \"atlas\"\n[room.target]\norgan = \"liver\"\n".to_owned(),
        organ(
            "liver",
            "liver",
            "VH_F_Liver.glb",
            "VH_F_capsule_of_the_liver",
            300,
        ),
        organ(
            "gallbladder",
            "gallbladder",
            "VH_F_Gallbladder.glb",
            "VH_F_gallbladder",
            100,
        ),
        organ(
            "cystic duct",
            "cystic-duct",
            "VH_F_Biliary_Tree.glb",
            "VH_F_cystic_duct",
            20,
        ),
        organ(
            "bile duct",
            "bile-duct",
            "VH_F_Biliary_Tree.glb",
            "VH_F_common_bile_duct",
            30,
        ),
        organ(
            "hepatic duct",
            "bile-duct",
            "VH_F_Biliary_Tree.glb",
            "VH_F_common_hepatic_duct",
            10,
        ),
        organ(
            "cystic artery",
            "cystic-artery",
            "VH_F_Blood_Vasculature_Gallbladder.glb",
            "VH_F_cystic_artery",
            40,
        ),
    ]
    .concat();
    let recipe = Recipe::parse(&text, "atlas", &folder.join("hra-female")).unwrap();
    let prepared = prepare(&recipe, &mut |_| {}).unwrap();
    println!("{}", prepared.report);
    for report in &prepared.report.organs {
        assert_eq!(report.components, 1, "{}", report.name);
        assert!(
            report.min_degree >= 3 && report.spheres >= 8,
            "{}: {report:?}",
            report.name
        );
    }
    // The ducts are hollow walls in the atlas; what counts is what they enclose.
    for (name, low_ml, high_ml) in [("cystic duct", 0.03, 0.06), ("bile duct", 0.12, 0.19)] {
        let report = prepared
            .report
            .organs
            .iter()
            .find(|o| o.name == name)
            .unwrap();
        assert!(
            (low_ml..high_ml).contains(&report.volume_ml),
            "{name}: {}",
            report.volume_ml
        );
    }
    let patches = "VH_F_liver";
    let mesh =
        scene_prepare::mesh::read(&folder.join("hra-female/VH_F_Liver.glb"), &[patches.into()]);
    let solid = mend(&mesh.unwrap(), Closing::Solid).unwrap();
    println!("26 patches: {solid}, {} mL", solid.volume_m3 * 1e6);
    assert!(
        (1.8e-3..2.2e-3).contains(&solid.volume_m3),
        "{}",
        solid.volume_m3
    );
}

#[test]
fn paper_meshes_of_table_1_prepare_with_both_packings() {
    let Some(folder) = anatomy() else { return };
    for (file, spheres) in [("liver_8128.obj", 581), ("gallbladder_1461.obj", 475)] {
        let mesh = scene_prepare::mesh::read(&folder.join("derived").join(file), &[]).unwrap();
        let mended = mend(&mesh, Closing::Auto).unwrap();
        let interior = Interior::new(&mended.mesh, mended.volume_m3, spheres).unwrap();
        for balls in [
            pack_evenly(&interior, spheres),
            pack_as_paper(&interior, spheres),
        ] {
            let quality = Quality::measure(&interior, &mended.mesh, &balls);
            println!("{file}: {} spheres, {quality:?}", balls.len());
            assert!(balls.len() > spheres * 9 / 10);
            assert!(
                quality.coverage > 0.8 && quality.protrusion_max_m < 1e-4,
                "{quality:?}"
            );
        }
    }
}

/// Equation 1 by hand: in a box 2 × 4 × 6 cm the middle is 1 cm from the nearest side, and a
/// point 3 mm from a side has D = 3 mm.
#[test]
fn equation_1_by_hand() {
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let mesh = scene_prepare::mesh::Mesh {
        vertices: (0..8)
            .map(|i| {
                let step = |bit: usize, size: f64| size * (i >> bit & 1) as f64;
                Vec3::new(step(0, 0.02), step(1, 0.04), step(2, 0.06))
            })
            .collect(),
        triangles: sides
            .iter()
            .flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]])
            .collect(),
    };
    let interior = Interior::new(&mesh, mesh.volume(), 40).unwrap();
    let cases = [
        ([0.01, 0.02, 0.03], 0.01),
        ([0.01, 0.003, 0.03], 0.003),
        ([0.01, 0.02, 0.0599], 0.0001),
    ];
    for (center, expected) in cases {
        assert!(
            (interior.depth(&Vec3::from(center)) - expected).abs() < 1e-8,
            "{center:?}"
        );
    }
    assert!(
        (interior.depth(&Vec3::new(0.01, 0.02, 0.065)) + 0.005).abs() < 1e-8,
        "outside is negative"
    );
    let ball = interior.inscribed(Vec3::new(0.01, 0.02, 0.03), f64::INFINITY);
    assert!((ball.radius_m - 0.01).abs() < 1e-8);
}

#[test]
fn links_are_the_nearest_overlapping_ones() {
    use scene_prepare::pack::Ball;
    // A row of overlapping balls and one far away.
    let at = |x: f64| Ball {
        center: Vec3::new(x, 0.0, 0.0),
        radius_m: 0.6,
    };
    let mut balls: Vec<Ball> = (0..12).map(|i| at(f64::from(i))).collect();
    balls.push(at(30.0));
    let list = links::link(&balls);
    let (_, pieces) = links::pieces(&list, balls.len());
    assert_eq!(pieces, 1);
    for i in 0..12u32 {
        let degree = list.iter().flatten().filter(|&&j| j == i).count();
        assert!(degree >= 3, "{i} has {degree}");
    }
    // Neighbours overlap, so they are linked.
    assert!((0..11).all(|i| list.contains(&[i, i + 1])));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Random blobs: spheres inside, one piece, degree, weights; the same again on every run.
    #[test]
    fn blobs_are_packed_soundly(
        lumps in prop::collection::vec(
            ((-0.03f64..0.03), (-0.03f64..0.03), (-0.03f64..0.03), 0.008f64..0.03), 1..5),
        spheres in 8usize..220,
        paper in any::<bool>(),
    ) {
        let blob = |p: &Vec3| {
            let lump = |(x, y, z, r): &(f64, f64, f64, f64)| (p - Vec3::new(*x, *y, *z)).norm() - r;
            let nearest = lumps.iter().map(lump).fold(f64::INFINITY, f64::min);
            // One blob in any case: a core joins the lumps.
            nearest.min(p.norm() - 0.02)
        };
        let bounds = [Vec3::repeat(-0.065), Vec3::repeat(0.065)];
        let mended = mend(&scene_prepare::shape::skin(&blob, bounds, 0.004), Closing::Auto).unwrap();
        let interior = Interior::new(&mended.mesh, mended.volume_m3, spheres).unwrap();
        let balls = if paper { pack_as_paper(&interior, spheres) } else { pack_evenly(&interior, spheres) };
        prop_assert!(balls.len() >= 4 && balls.len() <= spheres);
        let quality = Quality::measure(&interior, &mended.mesh, &balls);
        prop_assert!(quality.protrusion_max_m < 0.02 * interior.spacing_m, "{quality:?}");
        let list = links::link(&balls);
        prop_assert_eq!(links::pieces(&list, balls.len()).1, 1);
        let mut degree = vec![0; balls.len()];
        for &i in list.as_flattened() {
            degree[i as usize] += 1;
        }
        prop_assert!(degree.iter().all(|&d| d >= 3));
        prop_assert!((0.0..=1.0).contains(&isotropy(&balls, &list)));
        for v in bind::bind(&mended.mesh, &balls, 0) {
            prop_assert_eq!(v.weights.iter().map(|&w| u32::from(w)).sum::<u32>(), WEIGHT_SUM);
            prop_assert!(v.spheres.iter().all(|&s| usize::from(s) < balls.len()));
        }
    }
}
