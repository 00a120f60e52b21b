//! A round tip presses on the contact skin. The force on the tip depends on the tissue and not on
//! the number of spheres, and changes without steps.

use crate::support::LoadedScene;
use rt_core::math::{Vec3, norm};
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use rt_core::tool::{Capsule, Role};
use scene_prepare::{Prepared, Recipe, prepare};

fn liver(spheres: usize) -> Prepared {
    organ("liver", spheres, 0.2)
}

/// An organ of this form and of a liver's stiffness. It is held up to the share `base` of its
/// height.
fn organ(form: &str, spheres: usize, base: f64) -> Prepared {
    let text = format!(
        "name = \"one organ\"\n[[organ]]\nname = \"organ\"\nkind = \"{form}\"\nspheres = {spheres}\n\
         shape = {{ form = \"{form}\" }}\ngravity_share = 0.0\nheld = [{{ base = {base} }}]\n\
         [organ.material]\nyoung_pa = 5000.0\npoisson = 0.45\n"
    );
    let recipe = Recipe::parse(&text, "a test", std::path::Path::new(".")).expect("a good recipe");
    prepare(&recipe, &mut |_| {}).expect("an organ")
}

fn ball(center_m: Vec3, radius_m: f32) -> Capsule {
    Capsule {
        a_m: center_m,
        b_m: center_m,
        radius_m,
        role: Role::Tip,
    }
}

/// Presses a ball to `depth_m` at the target within `ticks`, and holds it there for as many ticks.
/// Returns the force along the normal at each tick, N.
fn press(built: &Prepared, radius_m: f32, depth_m: f32, ticks: u16) -> Vec<f32> {
    let room = built.scene.room.expect("a room");
    let (site, normal) = (Vec3::from(room.target_m), Vec3::from(room.target_normal));
    let loaded = LoadedScene::new(&built.scene);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    let mut felt = Vec::new();
    for tick in 0..2 * ticks {
        let share = (f32::from(tick) / f32::from(ticks)).min(1.0);
        let center_m = site + normal * (radius_m + 0.001 - (depth_m + 0.001) * share);
        let pressed = tissue.press(&[ball(center_m, radius_m)]);
        assert_eq!(pressed.quarantined, 0);
        let off_m = norm(&(center_m - site)) - radius_m;
        assert!(
            pressed.contacts == 0 || off_m < 0.0005,
            "felt {off_m} m away"
        );
        felt.push(pressed.force_n.dot(&normal));
    }
    felt
}

#[test]
fn the_force_is_the_tissues_and_not_the_spheres() {
    let (radius_m, depth_m) = (0.005f32, 0.004f32);
    let modulus_pa = 5000.0 / (1.0 - 0.45f32 * 0.45);
    let hertz_n = 4.0 / 3.0 * modulus_pa * radius_m.sqrt() * depth_m * depth_m.sqrt();
    let felt_n = [250, 581, 1200].map(|spheres| {
        let felt = press(&liver(spheres), radius_m, depth_m, 400);
        felt.last().copied().unwrap_or_default()
    });
    // The force is below that of Hertz's half-space, because the tissue is not linear and the body
    // yields as a whole.
    let share = felt_n[1] / hertz_n;
    assert!((0.5..0.9).contains(&share), "{share} of Hertz");
    for (i, spheres) in [(0, 250), (2, 1200)] {
        let to_581 = felt_n[i] / felt_n[1];
        assert!(
            (to_581 - 1.0).abs() < 0.15,
            "{spheres} spheres: {to_581} of 581's"
        );
    }
}

/// With spheres this close together, one pass over the constraints in a substep is not exact. The
/// contact force must be exact nevertheless.
#[test]
fn the_force_is_that_of_many_more_substeps() {
    let mut built = organ("gallbladder", 250, 0.6);
    let last = |built: &Prepared| press(built, 0.005, 0.004, 400).last().copied();
    let felt_n = last(&built).unwrap();
    built.scene.organs[0].substeps *= 8;
    let exact_n = last(&built).unwrap();
    let share = felt_n / exact_n;
    assert!(
        exact_n > 0.01 && (share - 1.0).abs() < 0.04,
        "{felt_n} N, {share} of what many substeps give"
    );
}

#[test]
fn deeper_is_more_and_no_tick_has_a_step() {
    // A ball goes 6 mm deep at 10 mm/s.
    let felt = press(&liver(581), 0.005, 0.006, 700);
    for (tick, pair) in felt.windows(2).enumerate() {
        let step_n = pair[1] - pair[0];
        assert!(step_n.abs() < 0.002, "tick {tick}: {step_n} N");
        assert!(
            tick >= 690 || step_n > -1e-4,
            "tick {tick}: {step_n} N while it goes in"
        );
    }
    assert!(felt[0] <= 0.0 && felt[1399] > 0.15, "{felt:?}");
}

/// A tip goes into the tissue at up to 3 m/s, 3 mm a tick, from twelve starting heights.
#[test]
fn no_speed_passes_the_skin_unfelt() {
    let built = liver(581);
    let room = built.scene.room.unwrap();
    let (site, normal) = (Vec3::from(room.target_m), Vec3::from(room.target_normal));
    let loaded = LoadedScene::new(&built.scene);
    let radius_m = 0.0008;
    for start in 0u8..12 {
        for step_m in [0.001f32, 0.002, 0.003] {
            let mut bodies = Box::new(Bodies::new());
            let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
            let mut height_m = 0.015 + step_m * f32::from(start) / 12.0;
            while height_m > -0.008 {
                let center_m = site + normal * (radius_m + height_m);
                let pressed = tissue.press(&[ball(center_m, radius_m)]);
                let out_n = pressed.force_n.dot(&normal);
                let is_in = height_m < -0.000_5;
                assert!(
                    out_n > 0.0 || !is_in,
                    "{out_n} N at {height_m} m by {step_m} m a tick"
                );
                height_m -= step_m;
            }
        }
    }
}

#[test]
fn a_shaft_and_a_tip_behind_each_other_count_once() {
    let built = liver(581);
    let room = built.scene.room.unwrap();
    let (site, normal) = (Vec3::from(room.target_m), Vec3::from(room.target_normal));
    let loaded = LoadedScene::new(&built.scene);
    let felt = |parts: &[Capsule]| {
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
        let mut force_n = 0.0;
        for tick in 0u16..600 {
            let depth_m = 0.004 * (f32::from(tick) / 300.0).min(1.0);
            let moved: Vec<Capsule> = parts
                .iter()
                .map(|part| Capsule {
                    a_m: part.a_m - normal * depth_m,
                    b_m: part.b_m - normal * depth_m,
                    ..*part
                })
                .collect();
            force_n = tissue.press(&moved).force_n.dot(&normal);
        }
        force_n
    };
    let tip = ball(site + normal * 0.003, 0.003);
    let with_shank = Capsule {
        a_m: site + normal * 0.05,
        ..tip
    };
    let (alone_n, whole_n) = (felt(&[tip]), felt(&[with_shank]));
    assert!(
        (whole_n / alone_n - 1.0).abs() < 0.03,
        "{alone_n} N, with its shank {whole_n} N"
    );
}

/// Presses a ball of 3 mm radius `depth_m` deep, draws it 6 mm along the skin at 6 mm/s, and draws
/// it back. Returns the forces along the normal and along the skin at each tick, N.
fn slide(tissue: &mut Tissue<'_>, site: Vec3, normal: Vec3, depth_m: f32) -> Vec<[f32; 2]> {
    let radius_m = 0.003;
    let along = normal.cross(&Vec3::x()).normalize();
    let mut felt = Vec::new();
    for tick in 0u16..2400 {
        let depth_m = depth_m * (f32::from(tick) / 400.0).min(1.0);
        let ahead_m = (f32::from(tick) - 400.0).max(0.0) * 6.0e-6;
        let ahead_m = ahead_m.min(0.012 - ahead_m);
        let center_m = site + normal * (radius_m - depth_m) + along * ahead_m;
        let force_n = tissue.press(&[ball(center_m, radius_m)]).force_n;
        felt.push([force_n.dot(&normal), force_n.dot(&along)]);
    }
    felt
}

#[test]
fn friction_holds_back_both_ways_and_has_no_step() {
    let built = liver(581);
    let room = built.scene.room.unwrap();
    let loaded = LoadedScene::new(&built.scene);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    let (site, normal) = (Vec3::from(room.target_m), Vec3::from(room.target_normal));
    let felt = slide(&mut tissue, site, normal, 0.003);
    for (tick, pair) in felt.windows(2).enumerate() {
        let step_n = libm::hypotf(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        assert!(step_n < 0.005, "tick {tick}: {step_n} N");
    }
    // Each pair is at one place on the way there and on the way back. In both, the force of the
    // skin's slope is equal, and the force of friction is opposite.
    let mut shares = Vec::new();
    for off in (100..600).step_by(50) {
        let (there, back) = (felt[1400 - off], felt[1400 + off]);
        let across_n = 0.5 * (there[0] + back[0]);
        shares.push(0.5 * (back[1] - there[1]) / across_n);
    }
    let mean = shares.iter().sum::<f32>() / shares.len() as f32;
    assert!(
        (0.07..0.12).contains(&mean),
        "{shares:?} of the force across"
    );
}
