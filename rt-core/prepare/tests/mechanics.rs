//! Prepared scenes in the core's own solver: what is built stands, and organs hold each other.

mod core;

use rt_core::math::Vec3;
use rt_core::soft_body::{Bodies, Method, Tissue};
use scene_prepare::{Recipe, prepare};

const TICKS: usize = 400;

/// The sphere in the middle of a tube.
fn middle_of(prepared: &core::Prepared, organ: usize) -> u32 {
    let o = &prepared.organs[organ];
    o.sphere_start + o.sphere_count / 2
}

#[test]
fn triangle_rests_and_its_organs_hold_each_other() {
    let built = prepare(&Recipe::triangle(false).unwrap(), &mut |_| {}).unwrap();
    let loaded = core::Prepared::new(&built.scene);
    let organ = |name: &str| {
        let all = &built.report.organs;
        all.iter().position(|o| o.name == name).unwrap()
    };
    let spheres = built.scene.spheres.len() as u32;
    let largest = |tissue: &Tissue<'_>, range: std::ops::Range<u32>| {
        range
            .map(|i| tissue.displacement_m(i).norm())
            .fold(0.0, f32::max)
    };
    let of = |organ: usize| {
        let o = &loaded.organs[organ];
        o.sphere_start..o.sphere_start + o.sphere_count
    };

    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    for _ in 0..TICKS {
        tissue.step();
    }
    let moved_m = largest(&tissue, 0..spheres);
    assert!(moved_m < 5e-6, "at rest it moves by {moved_m} m");

    // The cystic duct is drawn 6 mm towards the feet: gallbladder and bile duct come along, and
    // go back when it is let go.
    let duct = organ("cystic duct");
    let led = middle_of(&loaded, duct);
    tissue.hold(led, true);
    for tick in 0..TICKS {
        let share = (tick as f32 / 200.0).min(1.0);
        tissue.lead(led, &Vec3::new(0.0, -0.006 * share, 0.0));
        tissue.step();
    }
    for name in ["gallbladder", "bile duct"] {
        let moved_m = largest(&tissue, of(organ(name)));
        assert!((0.0001..0.006).contains(&moved_m), "{name}: {moved_m} m");
    }
    let mut duct_lengths = built.scene.links[loaded.organs[duct].link_start as usize..]
        [..loaded.organs[duct].link_count as usize]
        .iter()
        .map(|l| {
            let at = |i: u32| {
                Vec3::from(built.scene.spheres[i as usize].center_m) + tissue.displacement_m(i)
            };
            (at(l.a) - at(l.b)).norm() / l.rest_length_m
        });
    assert!(duct_lengths.all(|stretch| stretch.is_finite() && stretch < 2.0));
    tissue.hold(led, false);
    for _ in 0..3 * TICKS {
        tissue.step();
    }
    // The duct itself may stay kinked: a row of spheres has no stiffness against it.
    for (name, limit_m) in [
        ("gallbladder", 0.002),
        ("bile duct", 0.002),
        ("cystic duct", 0.006),
    ] {
        let left_m = largest(&tissue, of(organ(name)));
        assert!(left_m < limit_m, "let go, {name} is still {left_m} m off");
    }
}
