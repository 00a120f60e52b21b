//! The trainee hangs an organ on a suture: from the place that the tip touched, in the direction in
//! which the tip was carried.

use super::grip::count;
use super::*;
use rt_core::port::{PedalSample, Polled};
use rt_core::scene::{Anchor, Attachment};
use rt_core::sim::Task;
use rt_core::tissue::suture::Placed;
use rt_core::tool::Instrument;

/// Height of the wall, m.
const WALL_M: f32 = 0.12;
/// A place above the liver's top, away from the scene's sutures.
const ADJACENT: Vec3 = Vec3::new(0.02, 0.0, 0.1);
/// A place deep enough in the liver to touch it.
const TOUCHES: Vec3 = Vec3::new(0.02, 0.0, 0.043);

/// The liver, hung by two sutures that are drawn in by 8 mm and 4 mm.
fn hung_liver() -> Anatomy {
    let mut liver = Anatomy::liver();
    let top = |x: f32| {
        let distance = |it: &RestSphere| norm(&(it.center_m - Vec3::new(x, 0.0, 0.04)));
        let spheres = liver.spheres.iter().enumerate();
        let nearest = spheres.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        nearest.expect("spheres").0
    };
    let ties = [(-0.03, 0.008), (-0.01, 0.004)].map(|(x, drawn_m)| {
        let sphere = top(x);
        let center_m = liver.spheres[sphere].center_m;
        let at_m = Vec3::new(center_m.x, center_m.y, WALL_M);
        Attachment {
            sphere: sphere as u32,
            to: Anchor::World(at_m),
            rest_length_m: norm(&(at_m - center_m)) - drawn_m,
            compliance_m_n: 1.0e-3,
            is_thread: true,
            tear_j: 0.0,
        }
    });
    liver.attachments.extend(ties);
    liver
}

/// Presses and releases the pedal with the tip at this place.
fn press_pedal(sim: &mut Sim<'_>, bench: &mut Bench, at: &Vec3) {
    for tick in 0..200 {
        let samples = bench.next_at(at, NONE);
        samples.pedal = Polled::Fresh(PedalSample {
            cut: false,
            coagulate: tick < 100,
            camera_lock: false,
            at_ns: samples.now_ns,
        });
        sim.tick(bench);
    }
}

fn placed(bench: &Bench) -> Vec<Placed> {
    bench.sutures.iter().map(|(it, _)| it.placed).collect()
}

fn command(sim: &mut Sim<'_>, bench: &mut Bench, command: Command) {
    bench.next_at(&AWAY, NONE).command = Some(command);
    sim.tick(bench);
}

#[test]
fn scene_starts_hung_and_task_hang_takes_the_sutures_down() {
    let anatomy = hung_liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    hold_tip(&mut sim, &mut bench, &AWAY, 3000, NONE);
    assert_eq!(placed(&bench), [Placed::Hung; 2]);
    assert!(moved_m(&bench, &anatomy) > 0.003, "drawn up");
    command(&mut sim, &mut bench, Command::Start(Task::Hang));
    assert_eq!(placed(&bench), [Placed::Away; 2]);
    hold_tip(&mut sim, &mut bench, &AWAY, 3000, NONE);
    assert!(
        moved_m(&bench, &anatomy) < 1.0e-4,
        "no suture holds the liver"
    );
    command(&mut sim, &mut bench, Command::Reset);
    assert_eq!(placed(&bench), [Placed::Hung; 2]);
}

#[test]
fn pedal_presses_stitch_and_hang_a_suture_that_is_drawn_in() {
    let anatomy = hung_liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    command(&mut sim, &mut bench, Command::Start(Task::Hang));
    // In the air there is no tissue to pierce.
    press_pedal(&mut sim, &mut bench, &AWAY);
    assert_eq!(placed(&bench), [Placed::Away; 2]);
    move_tip(&mut sim, &mut bench, &ADJACENT, &TOUCHES, 500, NONE);
    press_pedal(&mut sim, &mut bench, &TOUCHES);
    assert_eq!(placed(&bench), [Placed::AtHand, Placed::Away]);
    let through = bench.sutures[0].0.sphere;
    let distance_m = norm(&(bench.centers_m[through as usize] - TOUCHES));
    assert!(distance_m < 0.02, "{distance_m}");
    // A tip that has not moved gives no direction. A tip that moves along the liver gives a
    // direction that does not lead to the wall.
    press_pedal(&mut sim, &mut bench, &TOUCHES);
    let aside = Vec3::new(0.1, 0.0, 0.055);
    move_tip(&mut sim, &mut bench, &ADJACENT, &aside, 200, NONE);
    press_pedal(&mut sim, &mut bench, &aside);
    assert_eq!(placed(&bench), [Placed::AtHand, Placed::Away]);
    move_tip(&mut sim, &mut bench, &aside, &ADJACENT, 200, NONE);
    hold_tip(&mut sim, &mut bench, &ADJACENT, 1000, NONE);
    let before_m = bench.centers_m[through as usize];
    press_pedal(&mut sim, &mut bench, &ADJACENT);
    assert_eq!(placed(&bench), [Placed::Hung, Placed::Away]);
    let at_m = bench.sutures[0].0.at_m;
    assert!((at_m.z - WALL_M).abs() < 1.0e-5, "{at_m}");
    let carried = (ADJACENT - before_m).normalize();
    assert!(
        (at_m - before_m).normalize().dot(&carried) > 0.999,
        "{at_m}"
    );
    // The suture is drawn in, although the liver was asleep.
    hold_tip(&mut sim, &mut bench, &AWAY, 4000, NONE);
    let now_m = bench.centers_m[through as usize];
    let drawn_m = norm(&(at_m - before_m)) - norm(&(at_m - now_m));
    assert!((0.005..0.009).contains(&drawn_m), "{drawn_m} of 8 mm");
    move_tip(&mut sim, &mut bench, &ADJACENT, &TOUCHES, 500, NONE);
    press_pedal(&mut sim, &mut bench, &TOUCHES);
    move_tip(&mut sim, &mut bench, &TOUCHES, &ADJACENT, 500, NONE);
    press_pedal(&mut sim, &mut bench, &ADJACENT);
    assert_eq!(placed(&bench), [Placed::Hung; 2]);
    // The pedal was still down when the last suture was hung, but no current flowed.
    let reported = [EventKind::Stitch, EventKind::Hung].map(|kind| count(&bench, kind));
    assert_eq!(reported, [2, 2]);
    assert_eq!(count(&bench, EventKind::Electro), 0, "no current");
}

#[test]
fn a_hook_sews_nothing_and_scissors_cut_what_the_trainee_has_sewn() {
    let anatomy = hung_liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    command(&mut sim, &mut bench, Command::Start(Task::Hang));
    command(&mut sim, &mut bench, Command::Instrument(Instrument::Hook));
    move_tip(&mut sim, &mut bench, &ADJACENT, &TOUCHES, 500, NONE);
    press_pedal(&mut sim, &mut bench, &TOUCHES);
    assert_eq!(placed(&bench), [Placed::Away; 2]);
    assert!(
        count(&bench, EventKind::Electro) > 0,
        "the hook's current flows"
    );
    move_tip(&mut sim, &mut bench, &TOUCHES, &ADJACENT, 500, NONE);
    command(
        &mut sim,
        &mut bench,
        Command::Instrument(Instrument::Grasper),
    );
    move_tip(&mut sim, &mut bench, &ADJACENT, &TOUCHES, 500, NONE);
    press_pedal(&mut sim, &mut bench, &TOUCHES);
    // The thread is oblique, so it crosses the blades, which come from above.
    let aslant = Vec3::new(0.055, 0.0, 0.07);
    move_tip(&mut sim, &mut bench, &TOUCHES, &aslant, 500, NONE);
    press_pedal(&mut sim, &mut bench, &aslant);
    assert_eq!(placed(&bench), [Placed::Hung, Placed::Away]);
    hold_tip(&mut sim, &mut bench, &AWAY, 3000, NONE);
    command(
        &mut sim,
        &mut bench,
        Command::Instrument(Instrument::Scissors),
    );
    let thread = bench.sutures[0].0;
    let end_m = bench.centers_m[thread.sphere as usize];
    // The blades reach beyond the thread's middle.
    let across = (end_m + thread.at_m) * 0.5 - Vec3::z() * 0.004;
    move_tip(&mut sim, &mut bench, &AWAY, &across, 500, NONE);
    hold_tip(&mut sim, &mut bench, &across, 300, Buttons::GRASP);
    hold_tip(&mut sim, &mut bench, &across, 300, NONE);
    assert!(
        bench.sutures[0].1,
        "cut through: {end_m:?} {thread:?} {across:?} {:?}",
        bench.tip_m
    );
    assert!(!bench.sutures[1].1);
    hold_tip(&mut sim, &mut bench, &AWAY, 3000, NONE);
    assert!(moved_m(&bench, &anatomy) < 2.0e-3, "let go");
}

#[test]
fn pedal_that_leads_a_needle_gives_no_current_until_pressed_again() {
    let anatomy = hung_liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    command(&mut sim, &mut bench, Command::Start(Task::Hang));
    move_tip(&mut sim, &mut bench, &ADJACENT, &TOUCHES, 500, NONE);
    let mut held = |sim: &mut Sim<'_>, is_down: bool, change: Option<Command>| {
        let samples = bench.next_at(&TOUCHES, NONE);
        samples.command = change;
        samples.pedal = Polled::Fresh(PedalSample {
            cut: false,
            coagulate: is_down,
            camera_lock: false,
            at_ns: samples.now_ns,
        });
        sim.tick(&mut bench);
        [EventKind::Electro, EventKind::Burn].map(|kind| count(&bench, kind))
    };
    for tick in 0..600 {
        let change = (tick == 100).then_some(Command::Instrument(Instrument::Hook));
        assert_eq!(held(&mut sim, true, change), [0; 2], "tick {tick}");
    }
    held(&mut sim, false, None);
    let reported = (0..600).map(|_| held(&mut sim, true, None)).last();
    let [electro, burns] = reported.expect("ticks");
    assert!(electro > 0 && burns > 0, "{electro}, {burns}");
}

#[test]
fn checkpoint_and_digest_contain_the_sutures() {
    let anatomy = hung_liver();
    let mut state = new_state();
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, FORCE_ENABLED);
    let mut bench = Bench::new();
    command(&mut sim, &mut bench, Command::Start(Task::Hang));
    let down = bench.digests.last().expect("a tick").tools;
    move_tip(&mut sim, &mut bench, &ADJACENT, &TOUCHES, 500, NONE);
    let checkpoint = sim.checkpoint();
    let samples = bench.samples;
    let mut sewn = |sim: &mut Sim<'_>| {
        bench.samples = samples;
        bench.digests.clear();
        press_pedal(sim, &mut bench, &TOUCHES);
        (bench.digests.clone(), placed(&bench))
    };
    let first = sewn(&mut sim);
    sim.go_back(&checkpoint);
    let again = sewn(&mut sim);
    assert_eq!(first.1, [Placed::AtHand, Placed::Away]);
    assert!(first == again && first.0.iter().all(|it| it.tools != down));
}
