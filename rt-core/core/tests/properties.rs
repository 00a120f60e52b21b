//! For any scene and any input the tick ends, all results are finite, and the force stays within
//! the device's peak.

mod rig;
#[path = "../src/testing.rs"]
mod testing;

use proptest::prelude::*;
use rig::{Bench, TOUCH, organ, room, sample_at_tip, tracker_at};
use rt_core::math::{Pose, Quat, Vec3, is_finite, norm};
use rt_core::port::{Buttons, DeviceSample, PedalSample, Polled};
use rt_core::scene::{Link, Material, Organ, RestSphere, Scene, Tetra, TetraBatch, batches};
use rt_core::sim::{Command, Parameters, Sim};
use rt_core::state::State;
use rt_core::tool::Instrument;
use testing::vector;

#[derive(Debug, Clone)]
struct Parts {
    organs: Vec<Organ>,
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    batches: Vec<TetraBatch>,
}

impl Parts {
    fn scene(&self) -> Scene<'_> {
        Scene::new(&self.organs, &self.spheres, &self.links, room())
            .and_then(|scene| scene.with_tetrahedra(&self.batches))
            .expect("a scene of values within their ranges")
    }
}

fn sphere() -> impl Strategy<Value = RestSphere> {
    (
        vector(0.05),
        -4.0f32..-1.5,
        -6.0f32..0.0,
        prop::bool::weighted(0.1),
    )
        .prop_map(|(center_m, radius, mass, held)| RestSphere {
            center_m,
            radius_m: 10.0f32.powf(radius),
            mass_kg: 10.0f32.powf(mass),
            held,
        })
}

fn material() -> impl Strategy<Value = Material> {
    let elastic = (0.0f32..=9.0, 0.0f32..=0.4999, 0.0f32..=1.0);
    let paper = (0.0f32..=1.0, 0.0f32..=1.0);
    let surface = (0.0f32..=1.0e6, 0.0f32..=2.0, 0.0f32..=1.0e6);
    (elastic, paper, 0.0f32..=1000.0, surface).prop_map(
        |(elastic, paper, damping_per_s, (contact_stiffness_n_m, friction, toughness_j_m2))| {
            let ((young, poisson, retardation_s), (stretch_stiffness, laplacian_stiffness)) =
                (elastic, paper);
            Material {
                young_pa: 10.0f32.powf(young),
                poisson,
                retardation_s,
                stretch_stiffness,
                laplacian_stiffness,
                damping_per_s,
                contact_stiffness_n_m,
                friction,
                toughness_j_m2,
            }
        },
    )
}

fn iterations() -> impl Strategy<Value = Option<u32>> {
    prop_oneof![(0u32..20).prop_map(Some), Just(None)]
}

/// One or two organs of random spheres; links at random, also doubled and of absurd lengths.
fn parts() -> impl Strategy<Value = Parts> {
    let drawn = || {
        let links = prop::collection::vec((any::<u16>(), any::<u16>(), -5.0f32..0.5), 0..80);
        let tetrahedra = prop::collection::vec(prop::array::uniform4(any::<u16>()), 0..60);
        (
            prop::collection::vec(sphere(), 1..40),
            links,
            tetrahedra,
            material(),
            (0u32..=4).prop_map(|twice| 1 << twice),
        )
    };
    prop::collection::vec(drawn(), 1..3).prop_map(|organs| {
        let mut parts = Parts {
            organs: vec![],
            spheres: vec![],
            links: vec![],
            batches: vec![],
        };
        for (spheres, links, tetrahedra, material, substeps) in organs {
            let (first, count) = (parts.spheres.len() as u32, spheres.len() as u32);
            let first_link = parts.links.len() as u32;
            for (a, b, length) in links {
                let (a, b) = (first + u32::from(a) % count, first + u32::from(b) % count);
                if a != b {
                    parts.links.push(Link {
                        a,
                        b,
                        rest_length_m: 10.0f32.powf(length),
                        compliance_m_n: 10.0f32.powf(length),
                    });
                }
            }
            parts.spheres.extend(spheres);
            let link_count = parts.links.len() as u32 - first_link;
            parts.organs.push(Organ {
                batch_start: parts.batches.len() as u32,
                substeps,
                ..organ([first, count], [first_link, link_count], material)
            });
            for corners in tetrahedra {
                let tetra = Tetra {
                    spheres: corners.map(|i| first + u32::from(i) % count),
                    volume_m3: 1.0e-7,
                };
                // Most are flat, inverted, or name a sphere twice, and are refused.
                let _ = batches(&[tetra], &parts.spheres, |batch| parts.batches.push(batch));
            }
            let last = parts.organs.len() - 1;
            parts.organs[last].batch_count =
                parts.batches.len() as u32 - parts.organs[last].batch_start;
        }
        parts
    })
}

#[derive(Debug, Clone)]
enum Input {
    Tip(Vec3, u8),
    Raw([f32; 7], Option<Vec3>),
    Lost,
    Silence,
    Tracker(Vec3),
    Pedal(bool, bool, bool),
    Command(Command),
}

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        any::<bool>().prop_map(Command::Pause),
        Just(Command::Reset),
        Just(Command::EnableForce(true)),
        any::<bool>().prop_map(Command::EnableForce),
        Just(Command::Instrument(Instrument::Hook)),
        Just(Command::Instrument(Instrument::Grasper)),
    ]
}

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<f32>(),
        -1.0f32..1.0,
        Just(f32::NAN),
        Just(f32::MAX),
        Just(f32::INFINITY)
    ]
}

fn input() -> impl Strategy<Value = Input> {
    let wild = [(); 7].map(|()| any_number());
    let velocity = prop::option::of((any_number(), any_number(), any_number()));
    let velocity = velocity.prop_map(|v| v.map(|(x, y, z)| Vec3::new(x, y, z)));
    prop_oneof![
        8 => (vector(0.08), 0u8..4).prop_map(|(tip, buttons)| Input::Tip(tip, buttons)),
        2 => (wild, velocity).prop_map(|(raw, velocity)| Input::Raw(raw, velocity)),
        1 => Just(Input::Lost),
        1 => Just(Input::Silence),
        1 => (any_number(), any_number()).prop_map(|(x, y)| Input::Tracker(Vec3::new(x, y, 0.0))),
        1 => any::<(bool, bool, bool)>().prop_map(|(a, b, c)| Input::Pedal(a, b, c)),
        2 => command().prop_map(Input::Command),
    ]
}

fn feed(bench: &mut Bench, input: &Input) {
    let samples = bench.next();
    let now = samples.now_ns;
    match input {
        Input::Tip(tip, buttons) => {
            samples.device = Polled::Fresh(sample_at_tip(tip, Buttons(*buttons), now));
        }
        Input::Raw(raw, velocity_m_s) => {
            let [x, y, z, i, j, k, w] = *raw;
            let turn = Quat::new_unchecked(nalgebra::Quaternion::new(w, i, j, k));
            samples.device = Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: Pose::from_parts(Vec3::new(x, y, z).into(), turn),
                velocity_m_s: *velocity_m_s,
                buttons: Buttons(255),
                sequence: 0,
                at_ns: now,
            });
        }
        Input::Lost => samples.device = Polled::Lost,
        Input::Silence => {}
        Input::Tracker(at) => samples.tracker = Polled::Fresh(tracker_at(*at, now)),
        Input::Pedal(cut, coagulate, camera_lock) => {
            samples.pedal = Polled::Fresh(PedalSample {
                cut: *cut,
                coagulate: *coagulate,
                camera_lock: *camera_lock,
                at_ns: now,
            });
        }
        Input::Command(command) => samples.command = Some(*command),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn random_scenes_and_hostile_input_stay_finite(
        parts in parts(),
        inputs in prop::collection::vec((input(), 1usize..6), 1..40),
        iterations in iterations(),
    ) {
        let scene = parts.scene();
        let (mut state, mut paper) = (Box::new(State::new()), rig::paper(iterations));
        let parameters = Parameters { force_ramp_s: 0.002, force_enabled: true };
        let mut sim = Sim::new(scene, &mut state, TOUCH, parameters);
        sim.solve_by(rig::method(&mut paper));
        let mut bench = Bench::new();
        for (input, times) in &inputs {
            for _ in 0..*times {
                feed(&mut bench, input);
                sim.tick(&mut bench);
                prop_assert_eq!(bench.sent.len(), 1);
                let sent = bench.sent[0].force_n;
                prop_assert!(is_finite(&sent) && norm(&sent) <= 3.3001, "{}", sent);
                prop_assert!(bench.contact_count > 0 || bench.grasped_count > 0
                    || norm(&bench.force_n) < f32::EPSILON || !bench.events.is_empty());
                prop_assert!(bench.centers_m.iter().all(is_finite));
                prop_assert!(is_finite(&bench.tip_m));
            }
        }
    }

    /// Equal inputs give equal bits.
    #[test]
    fn every_run_repeats(parts in parts(), inputs in prop::collection::vec(input(), 1..20)) {
        let run = || {
            let scene = parts.scene();
            let mut state = Box::new(State::new());
            let mut sim = Sim::new(scene, &mut state, TOUCH, Parameters::default());
            let mut bench = Bench::new();
            for input in &inputs {
                feed(&mut bench, input);
                sim.tick(&mut bench);
            }
            sim.state_hash()
        };
        prop_assert_eq!(run(), run());
    }
}
