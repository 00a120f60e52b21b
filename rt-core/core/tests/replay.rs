//! Equal inputs give equal bits: in debug and release builds, and after changes of the code that do
//! not change the physics.

mod rig;

use rig::{Anatomy, Bench, PAPER, TOUCH, method, paper, pedal, tracker_at};
use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, Polled};
use rt_core::sim::{Command, Digest, Parameters, Sim};
use rt_core::state::State;

/// Hash of the run below without contact skins. The three hashes change only with an intended
/// change of the physics. After such a change, run the test, check the output of `poke`, and enter
/// the new hashes here.
const GOLDEN: u64 = 0x03ab3cd72c95e2ae;
/// Hash of the run with contact skins.
const GOLDEN_SKINS: u64 = 0x6d0694c194b8df03;
/// Hash of the run with the inner-sphere paper's method.
const GOLDEN_PAPER: u64 = 0xeaa964cfb45f7015;

/// The instrument approaches, presses, slides, grasps, lifts and releases. In between, the device
/// repeatedly sends no samples for some ticks. `iterations` is the number for the paper's method;
/// `None` uses Calot's method.
fn run(anatomy: &Anatomy, iterations: Option<u32>) -> u64 {
    let (mut state, mut paper) = (Box::new(State::new()), paper(iterations));
    let parameters = Parameters {
        force_ramp_s: 0.1,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
    sim.solve_by(method(&mut paper));
    let mut bench = Bench::new();
    let mut force_max_n = 0.0f32;
    let path = [
        (0, Vec3::new(0.0, 0.0, 0.12), Buttons(0)),
        (200, Vec3::new(0.01, 0.0, 0.038), Buttons(0)),
        (350, Vec3::new(-0.01, 0.005, 0.040), Buttons(0)),
        (600, Vec3::new(-0.01, 0.005, 0.040), Buttons::GRASP),
        (850, Vec3::new(-0.01, 0.02, 0.065), Buttons::GRASP),
        (1000, Vec3::new(0.02, 0.01, 0.09), Buttons(0)),
    ];
    for leg in path.windows(2) {
        let [(start, from, _), (end, to, buttons)] = [leg[0], leg[1]];
        for t in start..end {
            let share = (t - start) as f32 / (end - start) as f32;
            let samples = bench.next_at(&(from + (to - from) * share), buttons);
            let now = samples.now_ns;
            samples.tracker = Polled::Fresh(tracker_at(Vec3::new(0.1, share, 0.0), now));
            samples.pedal = Polled::Fresh(pedal(t % 300 > 200, t > 500, now));
            samples.command = (t == 120).then_some(Command::EnableForce(true));
            if t % 100 > 90 {
                samples.device = Polled::Nothing;
            }
            sim.tick(&mut bench);
            force_max_n = force_max_n.max(norm(&bench.force_n));
        }
    }
    assert!(force_max_n > 0.1, "it touched something: {force_max_n} N");
    assert!(
        bench.events.len() >= 4,
        "it did something: {:?}",
        bench.events
    );
    sim.state_hash()
}

#[test]
fn the_golden_run_repeats_bit_for_bit() {
    let bare = Anatomy::liver_and_gallbladder();
    let skins = bare.clone().with_skins();
    let runs = [
        ("spheres", &bare, None, GOLDEN),
        ("skins", &skins, None, GOLDEN_SKINS),
        ("the paper's", &bare, Some(PAPER), GOLDEN_PAPER),
    ];
    for (name, anatomy, iterations, golden) in runs {
        let hash = run(anatomy, iterations);
        assert_eq!(
            hash,
            run(anatomy, iterations),
            "{name}: twice in one process"
        );
        assert_eq!(hash, golden, "{name}: {hash:#018x}");
    }
}

/// Digests of 400 ticks of pressing; in the tick `nudged` the tip is 0.1 mm off its path.
fn digests(anatomy: &Anatomy, nudged: Option<u64>) -> Vec<Digest> {
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        force_ramp_s: 0.01,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
    let mut bench = Bench::new();
    for tick in 0..400u64 {
        let depth = (tick as f32 / 200.0).min(1.0);
        let mut tip = Vec3::new(0.01, 0.0, 0.12 - 0.08 * depth);
        if nudged == Some(tick) {
            tip.x += 1.0e-4;
        }
        bench.next_at(&tip, Buttons(0));
        sim.tick(&mut bench);
    }
    bench.digests
}

#[test]
fn digests_of_two_runs_part_where_the_runs_do_and_name_the_organ_then() {
    let anatomy = Anatomy::liver_and_gallbladder();
    let plain = digests(&anatomy, None);
    assert_eq!(plain, digests(&anatomy, None));
    let nudged = digests(&anatomy, Some(250));
    let differ = |(a, b): (&Digest, &Digest)| a != b;
    assert_eq!(plain.iter().zip(&nudged).position(differ), Some(250));
    let (a, b) = (plain[250], nudged[250]);
    assert_ne!(a.spheres, b.spheres);
    let organ = a.organs.iter().zip(&b.organs).position(|(a, b)| a != b);
    assert_eq!(organ, Some(0), "the liver is pressed");
}

/// Fills the inputs of the next tick, in which the tip presses or grasps.
fn work(bench: &mut Bench, tick: u64) {
    let depth = (tick as f32 / 200.0).min(1.0);
    let tip = Vec3::new(
        0.01,
        0.0,
        0.12 - 0.08 * depth + 0.02 * (tick as f32 / 400.0),
    );
    let held = (220..330).contains(&tick);
    let buttons = if held { Buttons::GRASP } else { Buttons(0) };
    bench.next_at(&tip, buttons).command = (tick == 3).then_some(Command::EnableForce(true));
}

#[test]
fn run_from_a_checkpoint_computes_the_same_again() {
    const TICKS: u64 = 420;
    for anatomy in [
        Anatomy::liver_and_gallbladder(),
        Anatomy::liver_and_gallbladder().with_skins(),
    ] {
        let again = move || {
            let mut state = Box::new(State::new());
            let parameters = Parameters::default();
            let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
            let mut straight = Bench::new();
            let mut checkpoints = Vec::new();
            for tick in 0..TICKS {
                if [0, 1, 205, 225, 300, 340].contains(&tick) {
                    checkpoints.push((tick, Box::new(sim.checkpoint())));
                }
                work(&mut straight, tick);
                sim.tick(&mut straight);
            }
            let end = sim.state_hash();
            // The run goes back to each checkpoint from a later state.
            for (from, checkpoint) in checkpoints.into_iter().rev() {
                let mut bench = Bench::new();
                (0..from).for_each(|tick| work(&mut bench, tick));
                sim.go_back(&checkpoint);
                for tick in from..TICKS {
                    work(&mut bench, tick);
                    sim.tick(&mut bench);
                }
                let straight = straight.digests.get(from as usize..);
                assert_eq!(Some(&bench.digests[..]), straight, "from tick {from}");
                assert_eq!(sim.state_hash(), end, "from tick {from}");
            }
        };
        // `checkpoint` builds its result on the stack.
        let thread = std::thread::Builder::new()
            .stack_size(64 << 20)
            .spawn(again);
        thread.expect("a thread").join().expect("the same again");
    }
}
