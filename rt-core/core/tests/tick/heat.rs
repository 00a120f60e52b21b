//! Heat of the current: its balance, and the harm that it does beside the tip and along tubes.

use super::cautery::{COAGULATE, CUT, under_current};
use super::*;
use rt_core::port::{PedalSample, Polled};
use rt_core::procedure::heat::Balance;
use rt_core::scene::{Anchor, Attachment, Link};
use rt_core::tool::Instrument;

/// A place at the liver's top at which the tip presses.
const ON_LIVER: Vec3 = Vec3::new(0.0, 0.0, 0.034);
/// Distance of the duct's axis from the end of the tip, m.
const APART_M: f32 = 0.0038;

/// The liver, and a duct of 4 mm beside the tip. It keeps its place, and is attached to the liver.
fn liver_and_duct() -> Anatomy {
    let mut anatomy = Anatomy::liver().with_skins();
    let first = anatomy.spheres.len() as u32;
    let first_link = anatomy.links.len() as u32;
    let axis_m = ON_LIVER.z;
    let liver = anatomy.spheres.clone();
    for i in 0..16 {
        let center_m = Vec3::new(0.004 * (i as f32 - 7.5), APART_M, axis_m);
        anatomy.spheres.push(RestSphere {
            center_m,
            radius_m: 0.002,
            mass_kg: 1060.0 * 0.004 * std::f32::consts::PI * 0.002 * 0.002,
            held: true,
        });
        let nearest = (0u32..).zip(&liver).min_by(|a, b| {
            norm(&(a.1.center_m - center_m)).total_cmp(&norm(&(b.1.center_m - center_m)))
        });
        let (nearest, at) = nearest.expect("the liver has spheres");
        anatomy.attachments.push(Attachment {
            sphere: nearest,
            to: Anchor::Sphere(first + i),
            rest_length_m: norm(&(at.center_m - center_m)),
            compliance_m_n: 10.0,
            is_thread: false,
            tear_j: 0.0,
        });
    }
    anatomy.links.extend((0..15).map(|i| Link {
        a: first + i,
        b: first + i + 1,
        rest_length_m: 0.004,
        compliance_m_n: 0.01,
    }));
    anatomy.organs.push(Organ {
        gravity_share: 0.0,
        batch_start: anatomy.batches.len() as u32,
        ..organ([first, 16], [first_link, 15], SOFT)
    });
    anatomy
}

/// The bench after the hook has coagulated at `at` for `ticks`, and a wait of `wait` ticks.
fn coagulated(anatomy: &Anatomy, at: &Vec3, pedals: (bool, bool), ticks: u32, wait: u32) -> Bench {
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(&mut bench);
    move_tip(&mut sim, &mut bench, &AWAY, at, 500, NONE);
    under_current(&mut sim, &mut bench, at, pedals, ticks);
    move_tip(&mut sim, &mut bench, at, &AWAY, wait, NONE);
    bench
}

fn seared(bench: &Bench, organ: u32) -> Option<f32> {
    let own = |it: &&Event| it.kind == EventKind::Seared && it.organ == Some(organ);
    bench.events.iter().rfind(own).map(|it| it.value)
}

fn is_balanced(balance: &Balance) -> bool {
    let parts = [
        balance.stored_j,
        balance.boiled_j,
        balance.perfused_j,
        balance.cooled_j,
        balance.spread_j,
        balance.due_j,
    ];
    let sum_j: f64 = parts.iter().sum();
    parts.iter().all(|it| *it >= 0.0) && (sum_j / balance.given_j - 1.0).abs() < 1.0e-3
}

#[test]
fn the_generator_s_energy_is_somewhere() {
    let whole = liver_and_duct();
    let tube = super::tear::tube(0.0);
    let across = Vec3::new(0.0005, 0.002, 0.003_5);
    for (anatomy, at, pedals) in [
        (&whole, ON_LIVER, COAGULATE),
        (&whole, ON_LIVER, CUT),
        (&tube, across, COAGULATE),
        (&tube, across, CUT),
    ] {
        let bench = coagulated(anatomy, &at, pedals, 2000, 3000);
        let balance = bench.balance;
        assert!(balance.given_j > 1.0, "{balance:?}");
        assert!(balance.given_j <= 60.1, "30 W for 2 s: {balance:?}");
        assert!(is_balanced(&balance), "{balance:?}");
        let kept_j = balance.stored_j + balance.perfused_j + balance.cooled_j;
        assert!(kept_j > 0.01 * balance.given_j);
    }
}

#[test]
fn heat_on_its_way_into_a_tube_is_in_the_balance() {
    let tube = super::tear::tube(0.0);
    let mut state = new_state();
    let mut sim = Sim::new(tube.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(&mut bench);
    let across = Vec3::new(0.0005, 0.002, 0.003_5);
    move_tip(&mut sim, &mut bench, &AWAY, &across, 500, NONE);
    let mut most_j: f64 = 0.0;
    for _ in 0..20 {
        let samples = bench.next_at(&across, NONE);
        samples.pedal = Polled::Fresh(PedalSample {
            cut: false,
            coagulate: true,
            camera_lock: false,
            at_ns: samples.now_ns,
        });
        sim.tick(&mut bench);
        let balance = &bench.balance;
        assert!(
            balance.given_j < 0.01 || is_balanced(balance),
            "{balance:?}"
        );
        most_j = most_j.max(balance.due_j);
    }
    assert!(most_j > 0.01, "{most_j} J");
}

#[test]
fn a_current_held_too_long_destroys_the_duct_next_to_it() {
    let anatomy = liver_and_duct();
    let short = coagulated(&anatomy, &ON_LIVER, COAGULATE, 1000, 2000);
    assert!(short.balance.stored_j > 1.0, "{:?}", short.balance);
    assert_eq!(seared(&short, 1), None, "a second spares the duct");
    let burnt = |it: &Event| it.kind == EventKind::Burn && it.organ == Some(1);
    let long = coagulated(&anatomy, &ON_LIVER, COAGULATE, 12_000, 0);
    assert!(
        !long.events.iter().any(burnt),
        "the tip never touches the duct"
    );
    let volume_m3 = seared(&long, 1).expect("twelve seconds burn it");
    assert!((1.0e-8..1.0e-6).contains(&volume_m3), "{volume_m3}");
}

#[test]
fn nothing_is_warm_without_current_and_a_reset_cools() {
    let anatomy = liver_and_duct();
    let cold = coagulated(&anatomy, &ON_LIVER, (false, false), 500, 0);
    assert_eq!(cold.balance, Balance::default());
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Hook));
    sim.tick(&mut bench);
    move_tip(&mut sim, &mut bench, &AWAY, &ON_LIVER, 500, NONE);
    under_current(&mut sim, &mut bench, &ON_LIVER, COAGULATE, 1000);
    assert!(bench.heat.iter().any(|it| it.rise_k > 0));
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    assert!(bench.heat.iter().all(|it| *it == Default::default()));
    assert_eq!(bench.balance, Balance::default());
}

#[test]
fn along_a_tube_heat_reaches_far_and_farther_with_time() {
    // A strip of mesentery, 1.3 mm thick.
    let mut anatomy = super::tear::tube(0.0);
    for sphere in &mut anatomy.spheres {
        sphere.mass_kg = 1060.0 * 0.003 * 8.0e-6;
    }
    let at = Vec3::new(0.0005, 0.002, 0.003_5);
    let length_m = |ticks| {
        let bench = coagulated(&anatomy, &at, COAGULATE, ticks, 0);
        let hot = bench.heat.iter().filter(|it| it.rise_k >= 8).count();
        0.003 * hot as f32
    };
    let (short, long) = (length_m(500), length_m(4000));
    assert!(short < long && long > 0.02, "{short} {long}");
}

#[test]
fn the_irrigator_s_pedals_are_no_current() {
    let anatomy = liver_and_duct();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    bench.next_at(&AWAY, NONE).command = Some(Command::Instrument(Instrument::Irrigator));
    sim.tick(&mut bench);
    move_tip(&mut sim, &mut bench, &AWAY, &ON_LIVER, 500, NONE);
    under_current(&mut sim, &mut bench, &ON_LIVER, (true, true), 500);
    assert!(bench.events.iter().any(|it| it.kind == EventKind::Contact));
    let electric = [
        EventKind::Electro,
        EventKind::Burn,
        EventKind::Seared,
        EventKind::Fault,
    ];
    assert!(!bench.events.iter().any(|it| electric.contains(&it.kind)));
    assert!(bench.heat.iter().all(|it| it.rise_k == 0));
}
