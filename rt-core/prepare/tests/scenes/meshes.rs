//! Meshes as they come: a box, a mesh in two pieces, a mesh whose unit is guessed.

use scene_prepare::{Recipe, Vec3, prepare};
use std::path::PathBuf;

use crate::sound::{assert_json_has_all_keys, check};

/// The coarsest closed mesh: none of its vertices lies where the hand is to work.
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

/// Two equal balls of 2 cm radius, 6 cm from middle to middle, in millimetres.
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

/// A ball of 3 mm, alone: no hand could work on it in the default room.
#[test]
fn an_organ_that_the_default_room_does_not_suit_is_prepared_with_a_warning() {
    let bounds = [Vec3::repeat(-0.002), Vec3::repeat(0.002)];
    let ball = scene_prepare::shape::skin(&|p: &Vec3| p.norm() - 0.0015, bounds, 0.0005);
    let mut text = String::new();
    for p in &ball.vertices {
        text.push_str(&format!("v {} {} {}\n", p.x, p.y, p.z));
    }
    for [a, b, c] in &ball.triangles {
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.obj"), text).unwrap();
    let told = |room: &str| {
        let text = format!(
            "name = \"ball\"\n[[organ]]\nname = \"ball\"\nkind = \"liver\"\nmesh = \"ball.obj\"\n\
             unit = \"m\"\nspheres = 60\n{room}"
        );
        let recipe = Recipe::parse(&text, "ball", folder.path()).unwrap();
        prepare(&recipe, &mut |_| {})
    };
    let report = told("").unwrap().report;
    let warnings = report.warnings.join("\n");
    for part in [
        "mm across, but such an organ has 50 to 400 mm",
        "no point of 'ball' can be reached and seen",
    ] {
        assert!(warnings.contains(part), "{warnings}");
    }
    assert!(
        report.organs[0]
            .size_mm
            .iter()
            .all(|mm| (mm - 3.0).abs() < 0.3)
    );
    assert!(report.to_string().contains("warning: "));
    let refused = told("[room]\ninstrument_port_m = [0.1, -0.1, 0.1]\n").unwrap_err();
    assert!(
        refused.to_string().contains("can be reached and seen"),
        "{refused}"
    );
}

/// A block of 4 × 2 × 1 inches, its longest side towards the head, in RAS.
#[test]
fn axes_and_inches_of_a_mesh_are_taken_as_told() {
    use scene_prepare::recipe::{Axes, MeshOptions, Unit};
    let sides = [2.0, 1.0, 4.0];
    let bounds = [Vec3::new(-1.2, -0.7, -2.2), Vec3::new(1.2, 0.7, 2.2)];
    let block = |p: &Vec3| {
        (0..3)
            .map(|k| p[k].abs() - sides[k] / 2.0)
            .fold(-9.0, f64::max)
    };
    let mesh = scene_prepare::shape::skin(&block, bounds, 0.2);
    let mut text = String::new();
    for p in &mesh.vertices {
        text.push_str(&format!("v {} {} {}\n", p.x, p.y, p.z));
    }
    for [a, b, c] in &mesh.triangles {
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("block.obj");
    std::fs::write(&path, text).unwrap();
    let options = MeshOptions {
        unit: Some(Unit::Inch),
        axes: Axes::Ras,
        ..MeshOptions::default()
    };
    let recipe = Recipe::from_mesh_as(&path, &options).unwrap();
    let prepared = prepare(&recipe.with_spheres(60).unwrap(), &mut |_| {}).unwrap();
    let organ = &prepared.report.organs[0];
    for (found, inches) in organ.size_mm.iter().zip([4.0, 2.0, 1.0]) {
        assert!((found / 25.4 - inches).abs() < 0.1, "{:?}", organ.size_mm);
    }
    assert!(
        organ.mesh.contains("a unit is 25.4 mm as told"),
        "{}",
        organ.mesh
    );
    assert!(!organ.mesh.contains("turned"), "{}", organ.mesh);
    let heads = prepared.scene.spheres.iter().map(|it| it.center_m[1].abs());
    assert!(
        heads.fold(0.0, f32::max) > 0.035,
        "its long side is not along y"
    );
}
