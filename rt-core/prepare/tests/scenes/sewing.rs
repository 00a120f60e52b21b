//! Sutures and bands, from the recipe to the simulated tissue.

use crate::support::LoadedScene;
use rt_core::math::Vec3;
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use scene_prepare::{Recipe, prepare};
use shared_mem::scene::WORLD;

const TICKS: usize = 2400;

/// Folder for the meshes of these tests.
const MESHES: &str = env!("CARGO_TARGET_TMPDIR");

/// Writes the mesh of an ellipsoid of 4 × 3 × 3 cm around a point.
fn pebble(name: &str, center_m: Vec3) {
    const RINGS: usize = 12;
    const ROUND: usize = 24;
    let mut text = String::new();
    let mut vertex = |ring: usize, step: usize| {
        let (down, about) = (ring as f32 / RINGS as f32, step as f32 / ROUND as f32);
        let (sin, cos) = libm::sincosf(down * std::f32::consts::PI);
        let (y, x) = libm::sincosf(about * std::f32::consts::TAU);
        let p = center_m + Vec3::new(0.02 * cos, 0.015 * sin * x, 0.015 * sin * y);
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    };
    vertex(0, 0);
    (1..RINGS).for_each(|ring| (0..ROUND).for_each(|step| vertex(ring, step)));
    vertex(RINGS, 0);
    let last = 2 + (RINGS - 1) * ROUND;
    let at = |ring: usize, step: usize| 2 + (ring - 1) * ROUND + step % ROUND;
    for step in 0..ROUND {
        text += &format!("f 1 {} {}\n", at(1, step), at(1, step + 1));
        let (a, b) = (at(RINGS - 1, step), at(RINGS - 1, step + 1));
        text += &format!("f {last} {b} {a}\n");
        for ring in 1..RINGS - 1 {
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step), at(ring + 1, step + 1)];
            text += &format!("f {a} {c} {d}\nf {a} {d} {b}\n");
        }
    }
    // The tests run in parallel and write the same files. Because of the rename, each test reads a
    // whole file.
    let path = std::path::Path::new(MESHES).join(format!("{name}.obj"));
    let own = path.with_extension(format!("{:?}", std::thread::current().id()));
    std::fs::write(&own, text).expect("writable");
    std::fs::rename(&own, &path).expect("writable");
}

/// Recipe of two pebbles, 2 cm apart, with their far ends held, and with these ties.
fn sewn(ties: &str) -> String {
    let mut recipe = String::from(
        "name = \"sewn\"\n[room]\ninstrument_port_m = [-0.03, 0, 0.19]\n\
         endoscope_port_m = [-0.03, 0.06, 0.17]\nlook_at_m = [-0.03, 0, 0.015]\n",
    );
    for (name, side) in [("left", -1.0f32), ("right", 1.0)] {
        pebble(name, Vec3::x() * (0.03 * side));
        recipe += &format!(
            "[[organ]]\nname = \"{name}\"\nkind = \"liver\"\nspheres = 60\n\
             mesh = \"{name}.obj\"\nunit = \"m\"\n\
             held = [{{ plane = {{ point_m = [{}, 0, 0], normal = [{side}, 0, 0] }} }}]\n",
            0.04 * side
        );
    }
    recipe + ties
}

/// Simulates a recipe until it rests. Returns each attachment's length at the end and its rest
/// length, m, and the displacement of the sphere that moved farthest, m.
fn settled(recipe: &str) -> (Vec<[f32; 2]>, f32) {
    let recipe = Recipe::parse(recipe, "sewn.toml", std::path::Path::new(MESHES)).expect("sound");
    let built = prepare(&recipe, &mut |_| {}).expect("sound");
    let loaded = LoadedScene::new(&built.scene);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    for _ in 0..TICKS {
        assert_eq!(tissue.step(), 0, "a sphere was put back");
    }
    let rest = |i: u32| Vec3::from(built.scene.spheres[i as usize].center_m);
    let now = |i: u32| rest(i) + tissue.displacement_m(i);
    let lengths = built.scene.attachments.iter().map(|tie| {
        let end = match tie.b {
            WORLD => Vec3::from(tie.anchor_m),
            b => now(b),
        };
        [(now(tie.a) - end).norm(), tie.rest_length_m]
    });
    let moved = (0..built.scene.spheres.len() as u32).map(|i| tissue.displacement_m(i).norm());
    (lengths.collect(), moved.fold(0.0, f32::max))
}

#[test]
fn sutures_and_bands_of_a_recipe_hold_what_they_are_sewn_to() {
    let tie = |what: &str, length_mm: f64, stiffness: &str| {
        sewn(&format!(
            "[[{what}]]\nfrom = {{ organ = \"left\", near_m = [-0.01, 0, 0] }}\n\
             to = {{ organ = \"right\", near_m = [0.01, 0, 0] }}\nlength_mm = {length_mm}\n{stiffness}"
        ))
    };
    // A suture pulls both pebbles together and hardly stretches.
    let (lengths, moved_m) = settled(&tie("suture", 12.0, ""));
    let [now_m, rest_m] = lengths[0];
    assert!((now_m - rest_m).abs() < 5e-4, "{now_m} {rest_m}");
    assert!(moved_m > 0.003, "{moved_m}");
    // A slack suture does nothing. A band that is as long pushes.
    let (_, moved_m) = settled(&tie("suture", 70.0, ""));
    assert!(moved_m < 5e-6, "slack: {moved_m}");
    let (lengths, moved_m) = settled(&tie("band", 70.0, "stiffness_n_m = 5.0"));
    assert!(
        moved_m > 0.001 && lengths[0][0] > 0.03,
        "{lengths:?} {moved_m}"
    );
    // A suture to the world pulls its end up.
    let (lengths, moved_m) = settled(&sewn(
        "[[suture]]\nfrom = { organ = \"left\", near_m = [-0.01, 0, 0] }\n\
         to = { world_m = [-0.01, 0.06, 0] }\nlength_mm = 40",
    ));
    let [now_m, rest_m] = lengths[0];
    assert!((now_m - rest_m).abs() < 5e-4, "{now_m} {rest_m}");
    assert!(moved_m > 0.003, "{moved_m}");
}

#[test]
fn a_place_far_from_its_organ_is_a_slip_that_is_named() {
    let recipe = sewn(
        "[[suture]]\nfrom = { organ = \"left\", near_m = [-10, 0, 0] }\n\
         to = { organ = \"right\", near_m = [0.01, 0, 0] }\n",
    );
    let recipe = Recipe::parse(&recipe, "sewn.toml", std::path::Path::new(MESHES)).expect("sound");
    let error = prepare(&recipe, &mut |_| {})
        .expect_err("10 m off")
        .to_string();
    assert!(
        error.contains("left") && error.contains("near_m") && error.contains("mm off"),
        "{error}"
    );
}

/// Both sutures pull the gallbladder by some millimetres, then it hangs still. Attachments between
/// organs stretch too little to tear.
#[test]
fn the_triangle_s_gallbladder_is_hung_and_nothing_tears() {
    let built = crate::prepared_triangle(false);
    let loaded = LoadedScene::new(&built.scene);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    let ties = &built.scene.attachments;
    let mut places = Vec::new();
    for ticks in [2600, 300] {
        for _ in 0..ticks {
            assert_eq!(tissue.step(), 0, "a sphere was put back");
        }
        let hung = ties.iter().filter(|tie| tie.b == WORLD);
        places.push(
            hung.map(|tie| tissue.displacement_m(tie.a))
                .collect::<Vec<Vec3>>(),
        );
    }
    for (before_m, now_m) in places[0].iter().zip(&places[1]) {
        let (moved_m, still_m) = (now_m.norm(), (now_m - before_m).norm());
        println!("hung by {:.2} mm", 1.0e3 * moved_m);
        assert!((0.001..0.006).contains(&moved_m), "{now_m}");
        assert!(still_m < 1.0e-4, "{still_m} m in 0.3 s");
    }
    let at =
        |i: u32| Vec3::from(built.scene.spheres[i as usize].center_m) + tissue.displacement_m(i);
    for tie in ties.iter().filter(|tie| tie.b != WORLD) {
        let stretch_m = (at(tie.a) - at(tie.b)).norm() - tie.rest_length_m;
        let bears_m = (tie.tear_j * tie.compliance_m_n).sqrt();
        assert!(stretch_m < bears_m, "{stretch_m} of {bears_m} m: {tie:?}");
    }
}
