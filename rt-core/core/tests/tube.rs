//! Tubes of links: the force and the rest of a stretched tube.

mod rig;

use std::cell::Cell;

use rig::{Anatomy, SOFT, organ, room};
use rt_core::math::{Vec3, norm};
use rt_core::scene::{Link, Material, Organ, RestSphere, Room, Scene};
use rt_core::study::{Correction, Tissue};
use rt_core::tissue::{Bodies, Method};

const SPHERES: u32 = 20;
const SPACING_M: f32 = 0.002;
const RADIUS_M: f32 = 0.002;
const DENSITY_KG_M3: f32 = 1060.0;
const AREA_M2: f32 = core::f32::consts::PI * RADIUS_M * RADIUS_M;
const STRAIN: f32 = 0.05;
const SUBSTEPS: u32 = 8;
const SUBSTEP_S: f32 = 0.001 / SUBSTEPS as f32;
/// Ticks in which the grip draws the tube out, and in which it rests.
const TICKS: [u32; 2] = [500, 1500];

/// A tube along x whose first two spheres are held, with links as preparation makes them.
fn tube(young_pa: f32, retardation_s: f32) -> Anatomy {
    let spheres: Vec<RestSphere> = (0..SPHERES)
        .map(|i| RestSphere {
            center_m: Vec3::new(SPACING_M * i as f32, 0.0, 0.0),
            radius_m: RADIUS_M,
            mass_kg: DENSITY_KG_M3 * AREA_M2 * SPACING_M,
            held: i < 2,
        })
        .collect();
    let link = |a: u32, steps: u32, share: f32| Link {
        a,
        b: a + steps,
        rest_length_m: SPACING_M * steps as f32,
        compliance_m_n: SPACING_M * steps as f32 / (young_pa * AREA_M2 * share),
    };
    let short = (0..SPHERES - 1).map(|a| link(a, 1, 0.5));
    let mut links: Vec<Link> = short
        .chain((0..SPHERES - 2).map(|a| link(a, 2, 0.25)))
        .collect();
    // Links that share no sphere come together, as preparation orders them.
    let group = |link: &Link| match link.b - link.a {
        1 => link.a % 2,
        _ => 2 + link.a % 4 / 2,
    };
    links.sort_by_key(group);
    let material = Material {
        young_pa,
        retardation_s,
        ..SOFT
    };
    Anatomy {
        organs: vec![Organ {
            gravity_share: 0.0,
            substeps: SUBSTEPS,
            ..organ([0, SPHERES], [0, links.len() as u32], material)
        }],
        spheres,
        links,
        ..Anatomy::default()
    }
}

/// Modulus for which the stiffness of a sphere's links times `dt²` over its mass is `number`.
fn young_pa(number: f32) -> f32 {
    number / 1.25 * DENSITY_KG_M3 * SPACING_M * SPACING_M / (SUBSTEP_S * SUBSTEP_S)
}

/// A grip that holds the last two spheres, as jaws do after each substep.
#[derive(Default)]
struct Grip {
    out_m: Cell<f32>,
    impulse_n_s: Cell<f32>,
}

impl Grip {
    fn hold(&self, tissue: &mut Correction<'_>, step_s: f32) {
        for i in SPHERES - 2..SPHERES {
            let to_m = Vec3::new(SPACING_M * i as f32 + self.out_m.get(), 0.0, 0.0);
            let step_m = to_m - tissue.center_m(i);
            let impulse_n_s = step_m.x / (tissue.inverse_mass_per_kg(i) * step_s);
            self.impulse_n_s.set(self.impulse_n_s.get() + impulse_n_s);
            tissue.move_by(i, &step_m);
        }
    }
}

/// Stretches a tube. Returns the mean force in the last tenth of a second, N, and the largest speed
/// in that time, m/s.
fn stretched(young_pa: f32, retardation_s: f32) -> (f32, f32) {
    let anatomy = tube(young_pa, retardation_s);
    let room = Room {
        gravity_m_s2: Vec3::zeros(),
        ..room()
    };
    let scene = Scene::new(&anatomy.organs, &anatomy.spheres, &anatomy.links, room);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(
        scene.expect("a good scene"),
        &mut bodies,
        Method::NeoHookean,
    );
    let grip = Grip::default();
    let mut fastest_m_s = 0.0f32;
    let out_m = STRAIN * SPACING_M * (SPHERES - 3) as f32;
    for tick in 1..=TICKS[0] + TICKS[1] {
        grip.out_m
            .set(out_m * (tick as f32 / TICKS[0] as f32).min(1.0));
        if tick == TICKS[0] + TICKS[1] - 100 {
            grip.impulse_n_s.set(0.0);
            fastest_m_s = 0.0;
        }
        let put_back = tissue.step_with(|tissue, step_s| grip.hold(tissue, step_s));
        if put_back > 0 {
            return (0.0, 99.0);
        }
        assert_eq!(put_back, 0, "a sphere was put back");
        let speeds = (0..SPHERES).map(|i| norm(&tissue.velocity_m_s(i)));
        fastest_m_s = speeds.fold(fastest_m_s, f32::max);
    }
    (grip.impulse_n_s.get() / 0.101, fastest_m_s)
}

#[test]
fn a_stretched_tube_has_its_materials_force() {
    let soft_pa = young_pa(0.02);
    let (soft_n, _) = stretched(soft_pa, 0.0);
    let rod_n = soft_pa * AREA_M2 * STRAIN;
    assert!(
        (soft_n / rod_n - 1.0).abs() < 0.1,
        "{soft_n} N of {rod_n} N"
    );
    for number in [0.5, 2.0, 3.9] {
        let young_pa = young_pa(number);
        let (force_n, fastest_m_s) = stretched(young_pa, 0.0);
        let ratio = force_n / soft_n * soft_pa / young_pa;
        assert!((ratio - 1.0).abs() < 0.01, "{number}: {ratio}");
        assert!(fastest_m_s < 1.0e-4, "{number}: {fastest_m_s} m/s");
    }
}

#[test]
fn a_tube_that_is_too_stiff_is_softer_and_rests() {
    for number in [4.1, 10.0, 100.0, 4.0e3] {
        let young_pa = young_pa(number);
        let (force_n, fastest_m_s) = stretched(young_pa, 0.0);
        let share = force_n / (young_pa * AREA_M2 * STRAIN);
        assert!((0.0..0.9).contains(&share), "{number}: {share}");
        assert!(fastest_m_s < 1.0e-4, "{number}: {fastest_m_s} m/s");
    }
}

#[test]
fn a_viscous_tube_rests() {
    for number in [0.02, 0.2, 2.0, 3.9] {
        let young_pa = young_pa(number);
        let (force_n, fastest_m_s) = stretched(young_pa, 1.0);
        let share = force_n / (young_pa * AREA_M2 * STRAIN);
        assert!((0.97..1.0).contains(&share), "{number}: {share}");
        assert!(fastest_m_s < 1.0e-4, "{number}: {fastest_m_s} m/s");
    }
}
