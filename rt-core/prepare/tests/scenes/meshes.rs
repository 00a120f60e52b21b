//! Meshes as users bring them: a box, a mesh in two pieces, a mesh whose unit is guessed.

use scene_prepare::recipe::{Axes, MeshOptions, Unit};
use scene_prepare::{Recipe, Vec3, prepare};
use std::path::PathBuf;

use crate::sound::{assert_json_has_all_keys, check};

/// A box of this height, mm, on a square of 100 mm.
#[allow(clippy::unwrap_used)]
fn box_of(height_mm: u32) -> (tempfile::TempDir, Recipe) {
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [100 * (i & 1), 100 * (i >> 1 & 1), height_mm * (i >> 2)];
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
    let options = MeshOptions {
        unit: Some(Unit::Millimetre),
        ..MeshOptions::default()
    };
    let recipe = Recipe::from_mesh(&path, &options).unwrap();
    (folder, recipe.with_spheres(60).unwrap())
}

#[test]
fn a_sheet_whose_spheres_lie_in_one_layer_is_refused() {
    let (_folder, sheet) = box_of(3);
    let refused = prepare(&sheet, &mut |_| {}).unwrap_err().to_string();
    for words in [
        "is a sheet of about 2.8 mm",
        "60 spheres make no tetrahedra",
        "--spheres",
    ] {
        assert!(refused.contains(words), "{refused}");
    }
}

/// In this very coarse mesh, no vertex is suitable as the target of the scripted hand.
#[test]
fn a_box_of_twelve_triangles_becomes_a_scene() {
    let (_folder, cube) = box_of(100);
    let prepared = prepare(&cube, &mut |_| {}).unwrap();
    check(&prepared);
    assert_json_has_all_keys(&prepared.report);
    assert!((prepared.report.volume_ml - 1000.0).abs() < 0.01);
}

/// A mesh file, in millimetres, of two equal balls of 2 cm radius, 6 cm from middle to middle.
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
        refused.contains("two.obj") && refused.contains("2 separate pieces, up to 20."),
        "{refused}"
    );
    assert!(refused.contains("pieces = \"largest\""), "{refused}");
    let joined = with("pieces = \"join\"").unwrap().report;
    assert_eq!(joined.components, 1);
    assert!(
        joined.organs[0].mesh.contains("linked across up to 20."),
        "{}",
        joined.organs[0].mesh
    );
    let largest = with("pieces = \"largest\"").unwrap().report;
    assert!((largest.volume_ml / joined.volume_ml - 0.5).abs() < 0.01);
}

#[test]
fn a_guessed_unit_is_said() {
    let (_folder, path) = two_balls();
    let mut recipe = Recipe::from_mesh(&path, &MeshOptions::default()).unwrap();
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
    let told = Recipe::from_mesh(
        &path,
        &MeshOptions {
            unit: Some(Unit::Centimetre),
            ..MeshOptions::default()
        },
    )
    .unwrap();
    let scene_prepare::recipe::Surface::Mesh { unit_m, .. } = &told.organs[0].surface else {
        panic!("a mesh")
    };
    assert_eq!(*unit_m, Some(0.01));
}

/// A mesh read in inches, or with other axes, gives an organ of the same size.
#[test]
fn units_and_axes_lead_to_the_same_organ() {
    let (_folder, path) = two_balls();
    let size_of = |options: MeshOptions| {
        let recipe = Recipe::from_mesh(&path, &options).unwrap();
        let built = prepare(&recipe.with_spheres(60).unwrap(), &mut |_| {}).unwrap();
        let mesh = built.report.organs[0].mesh.clone();
        (built.report.volume_ml, mesh, built.report.warnings)
    };
    let joined = || MeshOptions {
        pieces: scene_prepare::recipe::Pieces::Join,
        unit: Some(Unit::Millimetre),
        ..MeshOptions::default()
    };
    let (volume_ml, story, _) = size_of(joined());
    assert!(story.contains("100 × 40 × 40 mm"), "{story}");
    let inches = MeshOptions {
        unit: Some(Unit::Inch),
        scale: 1.0 / 25.4,
        ..joined()
    };
    assert!((size_of(inches).0 / volume_ml - 1.0).abs() < 1e-6);
    for axes in [Axes::Lps, Axes::Ras] {
        let (turned_ml, story, _) = size_of(MeshOptions { axes, ..joined() });
        assert!((turned_ml / volume_ml - 1.0).abs() < 1e-6);
        assert!(story.contains("100 × 40 × 40 mm"), "{story}");
    }
    let tenth = MeshOptions {
        scale: 0.1,
        ..joined()
    };
    let (_, story, warnings) = size_of(tenth);
    let asked = warnings.iter().any(|it| it.contains("--unit or --scale"));
    assert!(asked, "{story}: {warnings:?}");
}
