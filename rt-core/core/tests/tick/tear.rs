//! Tears by pulling: attachments between organs, and tubes.

use super::grip::{count, largest_step, move_and_record};
use super::*;
use rt_core::scene::{Anchor, Attachment, Link};

/// Energy that tears one attachment, J: 0.1 mJ while the force rises to 100 mN at 2 mm, and 0.1 mJ
/// while the force falls to zero.
const BAND_J: f32 = 2.0e-4;
const BAND_N_M: f32 = 50.0;

/// A pad of tissue, 5 × 5 × 3 cm, attached to its bed by bands under its lower half.
pub(super) fn pad() -> Anatomy {
    let half_axes_m = Vec3::new(0.025, 0.025, 0.015);
    let mut pad = Anatomy::default().with_ellipsoid(Vec3::zeros(), half_axes_m, 100, 0);
    let down = Vec3::new(0.0, 0.0, -0.005);
    for (i, sphere) in (0u32..).zip(&mut pad.spheres) {
        sphere.held = false;
        if sphere.center_m.z < -0.006 {
            pad.attachments.push(Attachment {
                sphere: i,
                to: Anchor::World(sphere.center_m + down),
                rest_length_m: norm(&down),
                compliance_m_n: BAND_N_M.recip(),
                is_thread: false,
                tear_j: BAND_J,
            });
        }
    }
    pad
}

pub(super) const BITTEN: Vec3 = Vec3::new(0.0, 0.0, 0.006);

fn grasp_pad(sim: &mut Sim<'_>, bench: &mut Bench) {
    move_tip(sim, bench, &AWAY, &BITTEN, 500, NONE);
    hold_tip(sim, bench, &BITTEN, 300, NONE);
    hold_tip(sim, bench, &BITTEN, 700, Buttons::GRASP);
}

#[test]
fn a_pull_tears_band_after_band_and_takes_their_energy() {
    let anatomy = pad();
    let bands = anatomy.attachments.len();
    assert!(bands > 5, "{bands}");
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    grasp_pad(&mut sim, &mut bench);
    // After a small pull and back, nothing has torn, and the force is as before.
    let before_n = bench.force_n.z;
    let above = |by_m: f32| BITTEN + Vec3::new(0.0, 0.0, by_m);
    for (from, to) in [(0.0, 0.003), (0.003, 0.0)] {
        move_and_record(
            &mut sim,
            &mut bench,
            (&above(from), &above(to)),
            600,
            Buttons::GRASP,
        );
    }
    hold_tip(&mut sim, &mut bench, &BITTEN, 500, Buttons::GRASP);
    assert_eq!(count(&bench, EventKind::Tear), 0);
    assert!(
        (bench.force_n.z - before_n).abs() < 0.02,
        "{before_n} {}",
        bench.force_n.z
    );
    // The pad is pulled off its bed: 40 mm in 8 s.
    let (travel_m, ticks) = (0.04, 8000);
    let forces = move_and_record(
        &mut sim,
        &mut bench,
        (&BITTEN, &above(travel_m)),
        ticks,
        Buttons::GRASP,
    );
    assert_eq!(count(&bench, EventKind::Tear), bands, "all of them");
    assert_eq!(count(&bench, EventKind::LetGo), 0);
    let force_max_n = forces
        .iter()
        .fold(0.0f32, |force_max_n, f| force_max_n.max(-f));
    assert!(
        force_max_n > 0.3 && bench.force_n.z.abs() < 0.02,
        "{force_max_n} {}",
        bench.force_n.z
    );
    let work_j: f32 = forces.iter().map(|f| -f * travel_m / ticks as f32).sum();
    // When a band tears, elastic energy of the tissue is lost as well.
    let torn_j = BAND_J * bands as f32;
    assert!(
        (1.0..4.5).contains(&(work_j / torn_j)),
        "{work_j} J for {torn_j} J"
    );
    let step = largest_step(&forces);
    // The load vanishes as fast as fibres tear, within 50 ticks; then the pad springs against the
    // jaws.
    assert!(
        step < force_max_n / 4.0,
        "{step} of {force_max_n} N in a tick"
    );
    // A reset repairs the bands.
    bench.next_at(&AWAY, NONE).command = Some(Command::Reset);
    sim.tick(&mut bench);
    let events = bench.events.len();
    grasp_pad(&mut sim, &mut bench);
    move_and_record(
        &mut sim,
        &mut bench,
        (&BITTEN, &above(travel_m)),
        ticks,
        Buttons::GRASP,
    );
    let again = bench.events[events..]
        .iter()
        .filter(|event| event.kind == EventKind::Tear);
    assert_eq!(again.count(), bands);
}

/// 21 spheres in a row along x, the ends held; E A = 5 kPa · 28 mm² = 0.141 N.
pub(super) fn tube(toughness_j_m2: f32) -> Anatomy {
    let area_m2 = std::f32::consts::PI * 0.003 * 0.003;
    let spheres: Vec<RestSphere> = (0..21)
        .map(|i| RestSphere {
            center_m: Vec3::new(0.003 * (i as f32 - 10.0), 0.0, 0.0),
            radius_m: 0.003,
            mass_kg: 0.001,
            held: i == 0 || i == 20,
        })
        .collect();
    let links: Vec<Link> = (0..20)
        .map(|a| Link {
            a,
            b: a + 1,
            rest_length_m: 0.003,
            compliance_m_n: 0.003 / (SOFT.young_pa * area_m2),
        })
        .collect();
    let material = Material {
        toughness_j_m2,
        ..SOFT
    };
    Anatomy {
        organs: vec![Organ {
            gravity_share: 0.0,
            ..organ([0, 21], [0, 20], material)
        }],
        spheres,
        links,
        ..Anatomy::default()
    }
}

#[test]
fn a_tube_tears_where_its_toughness_ends() {
    let torn = |toughness_j_m2| {
        let anatomy = tube(toughness_j_m2);
        let mut state = new_state();
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
        let mut bench = Bench::new();
        let at = Vec3::new(0.0, 0.0, -0.003);
        move_tip(&mut sim, &mut bench, &AWAY, &at, 500, NONE);
        hold_tip(&mut sim, &mut bench, &at, 500, Buttons::GRASP);
        assert!(bench.grasped_count > 0);
        let above = at + Vec3::new(0.0, 0.0, 0.05);
        move_and_record(&mut sim, &mut bench, (&at, &above), 5000, Buttons::GRASP);
        // Tissue that moves along a touching tool is held back a little.
        hold_tip(&mut sim, &mut bench, &above, 300, Buttons::GRASP);
        (count(&bench, EventKind::Tear), -bench.force_n.z)
    };
    // Each link of 3 mm bears a stretch of √(Γ L / E): 0.55 mm at 0.5 J/m², 7.7 mm at 100 J/m².
    let (tears, left_n) = torn(0.5);
    assert!(tears >= 1 && left_n.abs() < 0.02, "{tears} {left_n}");
    let (tears, left_n) = torn(100.0);
    assert!(tears == 0 && left_n > 0.08, "{tears} {left_n}");
}
