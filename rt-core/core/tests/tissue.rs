//! Robustness of tissue, and independence of its stiffness from substeps and damping.

mod rig;

use rig::{Anatomy, room};
use rt_core::math::{Quat, Vec3, norm};
use rt_core::scene::{Anchor, Attachment, Organ, Relaxation, RestSphere, Room, Scene};
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};

/// A cantilever of tissue, 12 × 5 × 5 cm, with its left end held.
struct Bar {
    anatomy: Anatomy,
    room: Room,
    attachments: Vec<Attachment>,
}

impl Bar {
    fn new() -> Self {
        let half_axes_m = Vec3::new(0.06, 0.025, 0.025);
        let mut anatomy = Anatomy::default().with_ellipsoid(Vec3::zeros(), half_axes_m, 220, 0);
        for sphere in &mut anatomy.spheres {
            sphere.held = sphere.center_m.x < -0.035;
        }
        anatomy.organs[0].material.damping_per_s = 2.0;
        let room = Room {
            gravity_m_s2: Vec3::zeros(),
            ..room()
        };
        Self {
            anatomy,
            room,
            attachments: Vec::new(),
        }
    }

    fn organ(&mut self) -> &mut Organ {
        &mut self.anatomy.organs[0]
    }

    /// Adds a tenth of gravity, so that the bar bends little and linearly.
    fn with_gravity(mut self) -> Self {
        self.organ().gravity_share = 1.0;
        self.room.gravity_m_s2 = Vec3::new(0.0, 0.0, -0.981);
        self
    }

    fn scene(&self) -> Scene<'_> {
        Scene::new(&self.anatomy.organs, &self.anatomy.spheres, &[], self.room)
            .and_then(|scene| scene.with_tetrahedra(&self.anatomy.batches))
            .and_then(|scene| scene.with_attachments(&self.attachments))
            .expect("a good scene")
    }

    /// Runs `simulate` on the tissue.
    fn simulate<T>(&self, simulate: impl FnOnce(&mut Tissue<'_>, &[RestSphere]) -> T) -> T {
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(self.scene(), &mut bodies, Method::NeoHookean);
        simulate(&mut tissue, &self.anatomy.spheres)
    }
}

fn step(tissue: &mut Tissue<'_>, ticks: usize) {
    for _ in 0..ticks {
        assert_eq!(tissue.step(), 0, "a sphere was put back");
    }
}

fn displacements(tissue: &Tissue<'_>, spheres: &[RestSphere]) -> Vec<Vec3> {
    (0..spheres.len() as u32)
        .map(|i| tissue.displacement_m(i))
        .collect()
}

fn farthest_m(tissue: &Tissue<'_>, spheres: &[RestSphere]) -> f32 {
    let all = displacements(tissue, spheres);
    all.iter().map(norm).fold(0.0, f32::max)
}

fn fastest_m_s(tissue: &Tissue<'_>, spheres: &[RestSphere]) -> f32 {
    let all = (0..spheres.len() as u32).map(|i| norm(&tissue.velocity_m_s(i)));
    all.fold(0.0, f32::max)
}

/// The sphere at the cantilever's free end.
fn tip(spheres: &[RestSphere]) -> u32 {
    let x = |i: &u32| spheres[*i as usize].center_m.x;
    let all = 0..spheres.len() as u32;
    all.max_by(|a, b| x(a).total_cmp(&x(b))).unwrap_or(0)
}

/// Sag of the cantilever's tip, m.
fn sag_m(bar: &Bar) -> f32 {
    bar.simulate(|tissue, spheres| {
        step(tissue, 4000);
        -tissue.displacement_m(tip(spheres)).z
    })
}

/// A deterministic number in −1..1.
fn noise(seed: &mut u32) -> f32 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*seed >> 8) as f32 / 8_388_608.0 - 1.0
}

#[test]
fn an_organ_at_rest_does_not_drift() {
    Bar::new().simulate(|tissue, spheres| {
        step(tissue, 3000);
        let drift_m = farthest_m(tissue, spheres);
        assert!(drift_m < 1.0e-6, "{drift_m}");
    });
}

#[test]
fn a_held_end_turned_by_a_quarter_turns_all_of_it() {
    Bar::new().simulate(|tissue, spheres| {
        let turned = |rest: &Vec3, share: f32| {
            let turn = Quat::from_axis_angle(&Vec3::y_axis(), share * core::f32::consts::FRAC_PI_2);
            turn * rest - rest
        };
        for tick in 1..=1500 {
            for (i, sphere) in (0u32..).zip(spheres).filter(|(_, sphere)| sphere.held) {
                tissue.lead(i, &turned(&sphere.center_m, tick as f32 / 1500.0));
            }
            step(tissue, 1);
        }
        step(tissue, 5000);
        let now = displacements(tissue, spheres);
        let errors = now
            .iter()
            .zip(spheres)
            .map(|(u, s)| u - turned(&s.center_m, 1.0));
        let worst_m = errors.map(|e| norm(&e)).fold(0.0, f32::max);
        assert!(worst_m < 5.0e-5, "{worst_m}");
    });
}

#[test]
fn stiffness_depends_neither_on_substeps_nor_on_damping() {
    let with = |substeps, retardation_s| {
        let mut bar = Bar::new().with_gravity();
        bar.organ().substeps = substeps;
        bar.organ().material.retardation_s = retardation_s;
        sag_m(&bar)
    };
    let usual = with(1, 0.001);
    assert!((0.003..0.05).contains(&usual), "{usual}");
    for other in [with(2, 0.001), with(8, 0.001), with(1, 0.0), with(1, 0.004)] {
        assert!((other / usual - 1.0).abs() < 0.003, "{other} {usual}");
    }
}

/// A ball whose poles are held, with the free spheres between them.
struct Ball {
    anatomy: Anatomy,
    top: Vec<u32>,
    free: Vec<u32>,
}

impl Ball {
    fn new(young_pa: f32, substeps: u32) -> Self {
        let mut anatomy =
            Anatomy::default().with_ellipsoid(Vec3::zeros(), Vec3::repeat(0.03), 220, 0);
        anatomy.organs[0].material.young_pa = young_pa;
        anatomy.organs[0].material.damping_per_s = 2.0;
        anatomy.organs[0].substeps = substeps;
        let (mut top, mut free) = (Vec::new(), Vec::new());
        for (i, sphere) in (0u32..).zip(&mut anatomy.spheres) {
            sphere.held = sphere.center_m.z.abs() > 0.015;
            match sphere.held {
                true if sphere.center_m.z > 0.0 => top.push(i),
                true => {}
                false => free.push(i),
            }
        }
        Self { anatomy, top, free }
    }

    /// Squeezes the tissue between the poles to `share` of its height and lets it rest. Returns the
    /// places of all spheres and the speed of the fastest.
    fn squeeze(&self, share: f32) -> (Vec<Vec3>, f32) {
        let scene = self.anatomy.scene();
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(scene, &mut bodies, Method::NeoHookean);
        let travel_m = (1.0 - share) * 0.03;
        for tick in 1..=2000 {
            for &i in &self.top {
                tissue.lead(i, &Vec3::new(0.0, 0.0, -travel_m * tick as f32 / 2000.0));
            }
            step(&mut tissue, 1);
        }
        step(&mut tissue, 3000);
        let speeds = self.free.iter().map(|&i| tissue.velocity_m_s(i).norm());
        let fastest_m_s = speeds.fold(0.0, f32::max);
        let spheres = (0u32..).zip(&self.anatomy.spheres);
        let places = spheres.map(|(i, it)| it.center_m + tissue.displacement_m(i));
        (places.collect(), fastest_m_s)
    }

    /// Smallest ratio of a tetrahedron's present volume to its volume at rest.
    fn least_volume(&self, places_m: &[Vec3]) -> f32 {
        let volume = |at: &dyn Fn(u32) -> Vec3, [a, b, c, d]: [u32; 4]| {
            (at(b) - at(a))
                .cross(&(at(c) - at(a)))
                .dot(&(at(d) - at(a)))
        };
        let rest = |i: u32| self.anatomy.spheres[i as usize].center_m;
        let now = |i: u32| places_m[i as usize];
        let all = self.anatomy.tetrahedra.iter();
        all.map(|it| volume(&now, it.spheres) / volume(&rest, it.spheres))
            .fold(f32::MAX, f32::min)
    }
}

/// Liver, and tissue that is eight times as stiff, comes to rest when squeezed to 40 % of its
/// height, and no tetrahedron is inverted. The shape of liver is the same with one substep and with
/// eight.
#[test]
fn squeezed_tissue_stays_whole() {
    let squeezed = |young_pa| {
        let ball = Ball::new(young_pa, 1);
        let (places_m, fastest_m_s) = ball.squeeze(0.4);
        assert!(fastest_m_s < 1.0e-4, "{young_pa} Pa: {fastest_m_s} m/s");
        let least = ball.least_volume(&places_m);
        assert!(least > 0.1, "{young_pa} Pa: a tetrahedron keeps {least}");
        places_m
    };
    squeezed(8.0 * 5400.0);
    let places_m = squeezed(5400.0);
    let (others_m, _) = Ball::new(5400.0, 8).squeeze(0.4);
    let pairs = places_m.iter().zip(&others_m);
    let apart_m = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
    assert!(apart_m < 1.0e-4, "{apart_m} m apart");
}

/// Shaken tissue comes to rest in one substep a tick, from jelly to tendon.
#[test]
fn stiff_tissue_comes_to_rest() {
    for young_pa in [1.0e3, 1.0e4, 1.0e5, 1.0e6, 5.0e7] {
        let ball = Ball::new(young_pa, 1);
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(ball.anatomy.scene(), &mut bodies, Method::NeoHookean);
        let mut seed = 3;
        for &i in &ball.free {
            let kick = Vec3::new(noise(&mut seed), noise(&mut seed), noise(&mut seed)) * 0.3;
            tissue.put(i, &Vec3::zeros(), &kick);
        }
        step(&mut tissue, 5000);
        let speeds = ball.free.iter().map(|&i| tissue.velocity_m_s(i).norm());
        let fastest_m_s = speeds.fold(0.0, f32::max);
        assert!(fastest_m_s < 1.0e-3, "{young_pa} Pa: {fastest_m_s} m/s");
    }
}

/// The rate of strain is zero at rest, so viscosity does not change a sag.
#[test]
fn viscosity_does_not_change_a_sag() {
    let sag_m = |retardation_s| {
        let mut bar = Bar::new().with_gravity();
        bar.organ().material.retardation_s = retardation_s;
        bar.simulate(|tissue, spheres| {
            step(tissue, 12_000);
            -tissue.displacement_m(tip(spheres)).z
        })
    };
    let plain_m = sag_m(0.0);
    for retardation_s in [0.00093, 0.0026, 0.02] {
        let share = sag_m(retardation_s) / plain_m;
        assert!((share - 1.0).abs() < 0.001, "{retardation_s} s: {share}");
    }
}

/// A sphere whose velocity is NaN in one tick is put back to its last place, and the organ
/// continues as before.
#[test]
fn nan_in_one_sphere_does_not_spread() {
    Bar::new().with_gravity().simulate(|tissue, spheres| {
        step(tissue, 10);
        let none = Vec3::new(f32::NAN, 0.0, 0.0);
        tissue.put(tip(spheres), &Vec3::zeros(), &none);
        assert!(tissue.step() > 0, "the sphere was put back");
        let again: u32 = (0..200).map(|_| tissue.step()).sum();
        assert_eq!(again, 0, "the sphere was put back only once");
        assert!(farthest_m(tissue, spheres) < 0.05);
    });
}

#[test]
fn deflection_goes_with_the_inverse_of_youngs_modulus_by_the_substep_rule() {
    let sag = |young_pa: f32, substeps| {
        let mut bar = Bar::new().with_gravity();
        bar.organ().material.young_pa = young_pa;
        bar.organ().material.retardation_s = 0.0;
        bar.organ().substeps = substeps;
        sag_m(&bar)
    };
    // There is no viscous damping, because one time constant would not suit both stiffnesses.
    let soft = sag(20_000.0, 2) * 20_000.0;
    let stiff = sag(320_000.0, 8) * 320_000.0;
    assert!((stiff / soft - 1.0).abs() < 0.06, "{stiff} {soft}");
}

#[test]
fn a_free_spin_keeps_momentum_and_gains_no_energy() {
    let mut bar = Bar::new();
    for sphere in &mut bar.anatomy.spheres {
        sphere.held = false;
    }
    bar.organ().material.damping_per_s = 0.0;
    bar.organ().material.retardation_s = 0.0;
    bar.simulate(|tissue, spheres| {
        let spin = Vec3::new(0.0, 0.0, 4.0);
        for (i, sphere) in (0u32..).zip(spheres) {
            tissue.put(
                i,
                &Vec3::zeros(),
                &(spin.cross(&sphere.center_m) + Vec3::x() * 0.1),
            );
        }
        let sums = |tissue: &Tissue<'_>| {
            let mut sums = (Vec3::zeros(), Vec3::zeros(), 0.0);
            for (i, sphere) in (0u32..).zip(spheres) {
                let velocity = tissue.velocity_m_s(i);
                let at = sphere.center_m + tissue.displacement_m(i);
                sums.0 += velocity * sphere.mass_kg;
                sums.1 += at.cross(&(velocity * sphere.mass_kg));
                sums.2 += 0.5 * sphere.mass_kg * velocity.norm_squared();
            }
            sums
        };
        let before = sums(tissue);
        let mut most = before.2;
        for _ in 0..2000 {
            step(tissue, 1);
            most = most.max(sums(tissue).2);
        }
        let after = sums(tissue);
        assert!(
            norm(&(after.0 - before.0)) < 2.0e-3 * norm(&before.0),
            "{after:?} {before:?}"
        );
        assert!(
            norm(&(after.1 - before.1)) < 0.05 * norm(&before.1),
            "{after:?} {before:?}"
        );
        assert!(most < 1.005 * before.2, "{most} {before:?}");
    });
}

#[test]
fn pulled_to_five_times_its_length_it_comes_back() {
    Bar::new().simulate(|tissue, spheres| {
        let far: Vec<u32> = (0..spheres.len() as u32)
            .filter(|&i| spheres[i as usize].center_m.x > 0.045)
            .collect();
        for &i in &far {
            tissue.hold(i, true);
        }
        for tick in 1..=600 {
            for &i in &far {
                tissue.lead(i, &Vec3::new(0.48 * tick as f32 / 600.0, 0.0, 0.0));
            }
            step(tissue, 1);
        }
        for &i in &far {
            tissue.hold(i, false);
        }
        step(tissue, 8000); // damping alone leaves 0.03 % of the swing
        let left_m = farthest_m(tissue, spheres);
        assert!(left_m < 1.0e-4, "{left_m}");
    });
}

/// Displaces every free sphere to `elsewhere`, and asserts that it comes back.
fn assert_recovers(name: &str, elsewhere: impl Fn(&Vec3, &mut u32) -> Vec3) {
    let bar = Bar::new();
    let left_m = bar.simulate(|tissue, spheres| {
        let mut seed = 7;
        for (i, sphere) in (0u32..).zip(spheres).filter(|(_, sphere)| !sphere.held) {
            let to = elsewhere(&sphere.center_m, &mut seed);
            tissue.put(i, &(to - sphere.center_m), &Vec3::zeros());
        }
        step(tissue, 10_000);
        farthest_m(tissue, spheres)
    });
    assert!(left_m < 1.0e-4, "{name}: {left_m} m from rest");
}

#[test]
fn flattened_to_a_plane_it_comes_back() {
    assert_recovers("plane", |at, _| Vec3::new(at.x, at.y, 0.0));
    assert_recovers("plane across", |at, _| Vec3::new(-0.03, at.y, at.z));
}

#[test]
fn drawn_into_a_line_or_a_point_it_comes_back() {
    assert_recovers("line", |at, _| Vec3::new(at.x, 0.0, 0.0));
    assert_recovers("point", |_, _| Vec3::new(-0.02, 0.0, 0.0));
}

#[test]
fn scrambled_it_comes_back() {
    assert_recovers("scrambled", |_, seed| {
        Vec3::new(0.05 * noise(seed), 0.03 * noise(seed), 0.03 * noise(seed))
    });
}

#[test]
fn swapped_spheres_return_to_their_places() {
    let bar = Bar::new();
    for seed in 1..=6 {
        let left_m = bar.simulate(|tissue, spheres| {
            let mut dice = seed;
            let mut free: Vec<u32> = (0..spheres.len() as u32)
                .filter(|&i| !spheres[i as usize].held)
                .collect();
            let homes = free.clone();
            for i in (1..free.len()).rev() {
                let other = (0.5 * (noise(&mut dice) + 1.0) * i as f32) as usize;
                free.swap(i, other);
            }
            for (&i, &place) in homes.iter().zip(&free) {
                let to = spheres[place as usize].center_m - spheres[i as usize].center_m;
                tissue.put(i, &to, &Vec3::zeros());
            }
            step(tissue, 10_000);
            farthest_m(tissue, spheres)
        });
        assert!(left_m < 1.0e-4, "seed {seed}: {left_m} m from rest");
    }
}

#[test]
fn turned_inside_out_it_comes_back() {
    assert_recovers("inside out", |at, _| Vec3::new(at.x, at.y, -at.z));
}

#[test]
fn hanging_far_from_the_origin_it_is_still() {
    // Displacement and step are stored, not positions, so rounding is not amplified into speed.
    for substeps in [1, 4, 8] {
        let mut bar = Bar::new().with_gravity();
        bar.organ().substeps = substeps;
        bar.organ().material.damping_per_s = 20.0;
        for sphere in &mut bar.anatomy.spheres {
            sphere.center_m += Vec3::new(0.6, 0.6, -0.6);
        }
        let fastest = bar.simulate(|tissue, spheres| {
            step(tissue, 5000);
            fastest_m_s(tissue, spheres)
        });
        assert!(fastest < 5.0e-5, "{substeps} substeps: {fastest} m/s");
    }
}

#[test]
fn a_thread_pulls_but_never_pushes_and_a_band_does_both() {
    let end = |is_thread, anchor: Vec3| {
        let mut bar = Bar::new();
        let tip = tip(&bar.anatomy.spheres);
        bar.attachments.push(Attachment {
            sphere: tip,
            to: Anchor::World(anchor),
            rest_length_m: 0.05,
            compliance_m_n: 1.0e-3,
            is_thread,
            tear_j: 0.0,
        });
        bar.simulate(|tissue, _| {
            step(tissue, 2000);
            tissue.displacement_m(tip)
        })
    };
    let tip_m = Vec3::new(0.057, 0.0, 0.0);
    let (near, far) = (tip_m + Vec3::x() * 0.03, tip_m + Vec3::x() * 0.08);
    assert!(norm(&end(true, near)) < 1.0e-6, "slack");
    assert!(end(true, far).x > 0.002, "taut");
    assert!(end(false, near).x < -0.002, "pushed");
}

#[test]
fn breathing_moves_held_spheres_and_attached_tissue() {
    let mut bar = Bar::new();
    bar.room.breath_s = 2.0;
    bar.organ().breath_m = Vec3::new(0.0, 0.0, 0.01);
    bar.simulate(|tissue, spheres| {
        let lowest = |tissue: &Tissue<'_>| {
            let all = displacements(tissue, spheres);
            all.iter().map(|u| u.z).fold(f32::MAX, f32::min)
        };
        step(tissue, 5000);
        assert!(lowest(tissue) > 0.008, "breathed in: {}", lowest(tissue));
        step(tissue, 1000);
        assert!(farthest_m(tissue, spheres) < 0.002, "breathed out");
    });
}

#[test]
fn a_load_creeps_by_the_retardation_of_its_terms() {
    let relaxes = |shares: [f32; 2]| {
        let mut bar = Bar::new().with_gravity();
        bar.organ().material.relaxation = Relaxation {
            shares,
            times_s: [0.5, 0.1],
        };
        bar
    };
    // Under a constant load the share g of the stress is lost with τ, and strain grows by 1 / (1 −
    // g) with τ / (1 − g).
    let first_m = sag_m(&Bar::new().with_gravity());
    let crept_m = sag_m(&relaxes([0.4, 0.0]));
    let expected = 1.0 / 0.6;
    assert!(
        (crept_m / first_m / expected - 1.0).abs() < 0.02,
        "{first_m} {crept_m}"
    );
    let crept_m = sag_m(&relaxes([0.2, 0.3]));
    assert!(
        (crept_m / first_m / 2.0 - 1.0).abs() < 0.03,
        "{first_m} {crept_m}"
    );
}

#[test]
fn relaxing_tissue_without_a_load_rests_and_comes_back() {
    let mut bar = Bar::new();
    bar.organ().material.relaxation = Relaxation {
        shares: [0.3, 0.3],
        times_s: [0.05, 0.5],
    };
    bar.simulate(|tissue, spheres| {
        step(tissue, 1000);
        assert!(farthest_m(tissue, spheres) < 1.0e-6);
        let at = tip(spheres);
        tissue.hold(at, true);
        for tick in 1..=500 {
            tissue.lead(at, &Vec3::new(0.0, 0.0, 0.01 * tick as f32 / 500.0));
            step(tissue, 1);
        }
        step(tissue, 1000);
        tissue.hold(at, false);
        step(tissue, 6000);
        let left_m = farthest_m(tissue, spheres);
        assert!(left_m < 2.0e-4, "{left_m} m are left of 10 mm");
    });
}
