//! Recipes that are accepted, and the error of each mistake.

use std::path::Path;

use scene_prepare::recipe::{BUILT_IN, Material, Surface};
use scene_prepare::{PrepareError, Recipe, prepare};
use shared_mem::scene::OrganKind;

const GOOD: &str = r#"name = "test"

[room]
instrument_length_m = 0.3

[[organ]]
name = "liver"
kind = "liver"
mesh = "liver.obj"
unit = "mm"
spheres = 100
material = { young_pa = 4000.0 }
held = [{ base = 0.2 }, { ball = { center_m = [0, 0, 0], radius_m = 0.02 } }]
"#;

#[test]
fn layers_name_what_they_lie_around() {
    let layers = |text: &str| parse(&format!("{GOOD}layers = {text}\n"));
    for (text, words) in [
        (
            "{ around = \"liver\", count = 3, cell_m = 0.001 }",
            "'liver' is not another organ",
        ),
        (
            "{ around = \"lever\", count = 3, cell_m = 0.001 }",
            "'lever' is not another organ",
        ),
        ("{ around = \"liver\", count = 3 }", "cell_m"),
    ] {
        let error = layers(text).expect_err(text);
        assert!(error.problem.contains(words), "{error}");
    }
}

#[test]
fn sutures_and_bands_name_their_places() {
    let tie = |ends: &str| parse(&format!("{GOOD}\n[[suture]]\n{ends}"));
    let near = "{ organ = \"liver\", near_m = [0, 0, 0] }";
    let good = format!("from = {near}\nto = {{ world_m = [0, 0.1, 0] }}\nlength_mm = 20");
    let recipe = tie(&good).unwrap();
    assert_eq!(recipe.ties.len(), 1);
    assert!(recipe.ties[0].is_thread);
    assert_eq!(recipe.ties[0].length_m, Some(0.02));
    for (from, to, line, key, words) in [
        (
            "liver",
            "lever",
            16,
            "suture[0].from",
            "'lever' is not an organ",
        ),
        ("0.1", "11", 17, "suture[0].to", "of -10 to 10"),
        (
            "= 20",
            "= -1",
            18,
            "suture[0].length_mm",
            "allowed: 0 to 1000",
        ),
        (
            near,
            "{ world_m = [0, 0, 0] }",
            16,
            "suture[0].from",
            "write from = { organ",
        ),
    ] {
        let error = tie(&good.replacen(from, to, 1)).expect_err(to);
        assert_eq!((error.line, error.key.as_str()), (line, key), "{error}");
        assert!(error.problem.contains(words), "{error}");
    }
}

fn parse(text: &str) -> Result<Recipe, scene_prepare::RecipeError> {
    Recipe::parse(text, "test.toml", Path::new("meshes"))
}

#[test]
fn good_recipe_is_read_in_metres_with_defaults() {
    let recipe = parse(GOOD).unwrap();
    let organ = &recipe.organs[0];
    assert_eq!(
        (organ.spheres, organ.kind, organ.held.len()),
        (100, OrganKind::Liver, 2)
    );
    let Surface::Mesh { path, unit_m, .. } = &organ.surface else {
        panic!()
    };
    assert_eq!(
        (path.as_path(), *unit_m),
        (Path::new("meshes/liver.obj"), Some(1e-3))
    );
    let expected = Material {
        young_pa: 4000.0,
        ..Material::typical(OrganKind::Liver)
    };
    assert_eq!(organ.material, expected);
    assert_eq!(recipe.room.instrument_length_m, Some(0.3));
}

/// Each case has a text, the mistake that replaces it, and the line, key and words of the error.
#[test]
fn mistakes_name_line_key_value_and_remedy() {
    let cases = [
        (
            "spheres = 100",
            "sphere = 100",
            11,
            "recipe",
            "unknown field `sphere`",
        ),
        (
            "unit = \"mm\"",
            "unit = \"inch\"",
            10,
            "recipe",
            "expected one of `m`, `cm`, `mm`",
        ),
        (
            "spheres = 100",
            "spheres = 3",
            11,
            "organ[0].spheres",
            "is 3; allowed: 8 to 4096",
        ),
        (
            "kind = \"liver\"",
            "kind = \"spleen\"",
            8,
            "organ[0].kind",
            "one of liver, gallbladder",
        ),
        (
            "young_pa = 4000.0",
            "young_pa = -1.0",
            12,
            "organ[0].material.young_pa",
            "allowed: 10",
        ),
        (
            "young_pa = 4000.0",
            "friction = 3.0",
            12,
            "organ[0].material.friction",
            "allowed: 0 to 2",
        ),
        (
            "young_pa = 4000.0",
            "toughness_j_m2 = -1.0",
            12,
            "organ[0].material.toughness_j_m2",
            "allowed: 0 to 1000000",
        ),
        (
            "base = 0.2",
            "base = 1.2",
            13,
            "organ[0].held[0]",
            "allowed: 0 to 1",
        ),
        (
            "radius_m = 0.02",
            "radius_m = 9",
            13,
            "organ[0].held[1]",
            "allowed: 0.0001 to 1",
        ),
        (
            "{ base = 0.2 }",
            "{ near = { organ = \"x\", within_m = 0.0 } }",
            13,
            "organ[0].held[0]",
            "'x' is not another organ",
        ),
        (
            "_length_m = 0.3",
            "_length_m = 3",
            4,
            "room.instrument_length_m",
            "is 3; allowed: 0.1 to 0.6",
        ),
        (
            "_length_m = 0.3",
            "_length_m = 0.3\n[room.trocar]\nsliding_n = 9",
            6,
            "room.trocar.sliding_n",
            "is 9; allowed: 0 to 8",
        ),
        (
            "_length_m = 0.3",
            "_length_m = 0.3\n[stones]\ncount = 31\ndiameter_mm = 4\nroom_ml = 40",
            6,
            "stones.count",
            "is 31; allowed: 1 to 30",
        ),
        (
            "_length_m = 0.3",
            "_length_m = 0.3\ntrocar = { sliding_n = 2, breakaway_n = 1 }",
            5,
            "room.trocar.breakaway_n",
            "is 1; allowed: 2 to 8",
        ),
        (
            "mesh = \"liver.obj\"",
            "",
            7,
            "organ[0].name",
            "needs either `mesh",
        ),
        (
            "mesh = \"liver.obj\"",
            "shape = { form = \"cube\" }",
            9,
            "organ[0].shape",
            "unknown variant `cube`",
        ),
        (
            "name = \"test\"",
            "name = \"\"",
            1,
            "name",
            "must have 1 to 63 bytes",
        ),
        ("[[organ]]", "[[organ]", 6, "recipe", ""),
        (
            "[room]",
            "[room]\ntarget = { organ = \"liver2\" }",
            4,
            "room.target",
            "'liver2' is not an organ",
        ),
    ];
    for (from, to, line, key, words) in cases {
        assert!(GOOD.contains(from), "{from}");
        let error = parse(&GOOD.replacen(from, to, 1)).expect_err(to);
        assert_eq!((error.line, error.key.as_str()), (line, key), "{error}");
        assert!(
            error
                .to_string()
                .starts_with(&format!("test.toml:{line}: ")),
            "{error}"
        );
        assert!(error.problem.contains(words), "{error}");
    }
}

#[test]
fn two_organs_of_one_name_and_too_many_spheres_are_refused() {
    let organ = &GOOD[GOOD.find("[[organ]]").unwrap()..];
    let twice = parse(&format!("{GOOD}\n{organ}")).unwrap_err();
    assert!(twice.problem.contains("used twice"), "{twice}");
    let second = organ
        .replace("\"liver\"\nkind", "\"liver2\"\nkind")
        .replace("100", "4000");
    let too_many = parse(&format!("{GOOD}\n{second}")).unwrap_err();
    assert!(
        too_many.problem.contains("4100 spheres together"),
        "{too_many}"
    );
}

#[test]
fn missing_files_are_named() {
    let missing = Recipe::load(Path::new("no/such.toml"), None)
        .unwrap_err()
        .to_string();
    assert!(
        missing.contains("no/such.toml") && missing.contains("cannot be read"),
        "{missing}"
    );
    let recipe = parse(GOOD).unwrap();
    let error = prepare(&recipe, &mut |_| {}).unwrap_err();
    assert!(matches!(error, PrepareError::Mesh { .. }));
    let error = error.to_string();
    for words in ["organ 'liver'", "meshes/liver.obj", "--meshes DIR"] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn built_in_recipe_is_valid() {
    assert!(!Recipe::built_in().unwrap().organs.is_empty());
    assert!(BUILT_IN.is_ascii());
}

proptest::proptest! {
    /// Any text gives a recipe or an error with a line, never a panic.
    #[test]
    fn arbitrary_recipes_never_panic(cut in 0usize..400, insert in "\\PC{0,20}") {
        let at = (0..=cut.min(GOOD.len())).rev().find(|&i| GOOD.is_char_boundary(i)).unwrap();
        let text = format!("{}{insert}{}", &GOOD[..at], &GOOD[at..]);
        if let Err(error) = parse(&text) {
            proptest::prop_assert!(error.line >= 1);
        }
    }
}
