//! An instrument at work in whole scenes: what the hand feels has no step, and tissue comes to rest.

use crate::core;
use crate::{prepared_built_in, prepared_triangle};
use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Polled};
use rt_core::sim::{Command, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::{SphereBits, State};
use rt_core::tool::{Instrument, Kinematics};
use scene_prepare::Prepared;

/// A Touch-class device.
const TOUCH: DeviceCapabilities = DeviceCapabilities {
    force_max_n: 3.3,
    force_continuous_n: 0.88,
    torque_max_n_m: 0.0,
    stiffness_max_n_m: 1000.0,
    damping_max_n_s_m: 5.0,
    damping_n_s_m: 1.8,
    delay_s: 0.001,
    workspace_radius_m: 0.2,
    rate_hz: 1000.0,
};

const OPEN: Buttons = Buttons(0);

struct Hand {
    samples: Samples,
    force_n: Vec3,
    step_n: Vec3,
    awake: usize,
}

impl Ports for Hand {
    fn sample(&mut self) -> Samples {
        self.samples
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.step_n = command.force_n - self.force_n;
        self.force_n = command.force_n;
    }

    fn publish(&mut self, view: &TickView<'_>) {
        let is_awake = |sphere: &rt_core::sim::SphereView| sphere.bits.contains(SphereBits::AWAKE);
        self.awake = view.spheres().filter(is_awake).count();
    }

    fn stamp(&mut self, _: Stage) {}
}

/// Where and with what is worked, world frame, m.
struct Site {
    target_m: Vec3,
    normal: Vec3,
    instrument: Instrument,
}

impl Site {
    /// A scene's target, with the instrument that it begins with.
    fn target(built: &Prepared) -> Self {
        let room = built.scene.room.expect("a room");
        Self {
            target_m: Vec3::from(room.target_m),
            normal: Vec3::from(room.target_normal),
            instrument: Instrument::default(),
        }
    }
}

/// A part of the hand's way from 20 mm above the target, which begins and ends gently: ticks, where the
/// tip is at its end (out of the tissue, along it), mm, and the handle's buttons.
struct Leg(u16, [f32; 2], Buttons);

/// What a leg showed.
#[derive(Debug)]
struct Felt {
    largest_step_n: f32,
    /// How much a step differs from the one before.
    largest_knock_n: f32,
    largest_n: f32,
    /// Spheres awake at its end.
    awake: usize,
}

fn work(built: &Prepared, legs: &[Leg]) -> Vec<Felt> {
    work_at(built, &Site::target(built), legs)
}

fn work_at(built: &Prepared, site: &Site, legs: &[Leg]) -> Vec<Felt> {
    let room = built.scene.room.expect("a room");
    let loaded = core::Prepared::new(&built.scene);
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        force_ramp_s: 0.01,
        force_enabled: true,
        ..Parameters::default()
    };
    let mut sim = Sim::new(loaded.scene(), &mut state, TOUCH, parameters);
    let lever = Kinematics {
        port_m: Vec3::from(room.instrument_port_m),
        length_m: room.instrument_length_m,
    };
    let (target, normal) = (site.target_m, site.normal);
    let along = normal.cross(&(lever.port_m - target)).normalize();
    let mut hand = Hand {
        samples: Samples {
            now_ns: 0,
            device: Polled::Nothing,
            tracker: Polled::Nothing,
            pedal: Polled::Nothing,
            command: Some(Command::Instrument(site.instrument)),
        },
        force_n: Vec3::zeros(),
        step_n: Vec3::zeros(),
        awake: 0,
    };
    let (mut from, mut sequence) = ([20.0f32, 0.0], 0u16);
    let mut all = Vec::new();
    for Leg(ticks, to, buttons) in legs {
        let mut felt = Felt {
            largest_step_n: 0.0,
            largest_knock_n: 0.0,
            largest_n: 0.0,
            awake: 0,
        };
        for tick in 1..=*ticks {
            let share = f32::from(tick) / f32::from(*ticks);
            let share = share * share * (3.0 - 2.0 * share);
            let at = [0, 1].map(|i| (from[i] + (to[i] - from[i]) * share) * 1.0e-3);
            let tip_m = target + normal * at[0] + along * at[1];
            sequence = sequence.wrapping_add(1);
            hand.samples.now_ns += 1_000_000;
            hand.samples.device = Polled::Fresh(DeviceSample {
                device_from_handle: lever.handle_from_tip(&tip_m, &Vec3::y()),
                velocity_m_s: None,
                buttons: *buttons,
                sequence,
                at_ns: hand.samples.now_ns,
            });
            let before_n = hand.step_n;
            sim.tick(&mut hand);
            hand.samples.command = None;
            felt.largest_step_n = felt.largest_step_n.max(norm(&hand.step_n));
            felt.largest_knock_n = felt.largest_knock_n.max(norm(&(hand.step_n - before_n)));
            felt.largest_n = felt.largest_n.max(norm(&hand.force_n));
        }
        felt.awake = hand.awake;
        all.push(felt);
        from = *to;
    }
    all
}

/// Largest step of the force from a tick to the next where a hand works slowly, N.
const STEP_N: f32 = 0.005;
/// The same where jaws close, whose ends go through tissue at 50 mm/s; a tick's step is then as the one before.
const BITE_N: f32 = 0.008;

/// Some leg presses at least so hard, N: a tool that feels nothing has no step either.
const FELT_N: f32 = 0.1;

fn assert_smooth(built: &Prepared, legs: &[Leg]) {
    let all = work(built, legs);
    let most_n = all.iter().map(|felt| felt.largest_n).fold(0.0, f32::max);
    assert!(most_n > FELT_N, "{all:?}");
    for (number, (felt, leg)) in all.iter().zip(legs).enumerate() {
        println!("leg {number}: {felt:?}");
        let closes = leg.2.contains(Buttons::GRASP);
        let most_n = if closes { BITE_N } else { STEP_N };
        assert!(felt.largest_step_n < most_n, "leg {number}: {felt:?}");
        assert!(felt.largest_knock_n < STEP_N, "leg {number}: {felt:?}");
    }
}

/// Deep in Calot's triangle the shaft lies on the liver's edge and on the layer beside it.
#[test]
fn deep_in_the_triangle_no_tick_has_a_step() {
    let legs = [
        Leg(3600, [-20.0, 0.0], OPEN),
        Leg(2000, [-20.0, 0.0], OPEN),
        Leg(1500, [-20.0, 8.0], OPEN),
        Leg(3600, [20.0, 0.0], OPEN),
    ];
    assert_smooth(prepared_triangle(false), &legs);
}

/// Off the liver's edge, and back.
#[test]
fn sliding_and_biting_in_the_triangle_have_no_step() {
    let legs = [
        Leg(2000, [-6.0, 0.0], OPEN),
        Leg(750, [-6.0, 8.0], OPEN),
        Leg(1500, [-6.0, -8.0], OPEN),
        Leg(1500, [-6.0, 8.0], OPEN),
        Leg(1500, [-6.0, -8.0], OPEN),
        Leg(1500, [-6.0, 0.0], OPEN),
        Leg(500, [-6.0, 0.0], Buttons::GRASP),
        Leg(2000, [4.0, 0.0], Buttons::GRASP),
    ];
    assert_smooth(prepared_triangle(true), &legs);
}

#[test]
fn on_the_built_in_organs_no_tick_has_a_step() {
    let legs = [
        Leg(3600, [-20.0, 0.0], OPEN),
        Leg(1500, [-20.0, 8.0], OPEN),
        Leg(3600, [-6.0, 0.0], OPEN),
        Leg(500, [-6.0, 0.0], Buttons::GRASP),
        Leg(2000, [0.0, 0.0], Buttons::GRASP),
    ];
    assert_smooth(prepared_built_in(), &legs);
}

/// A fast press is felt, and when the tool has gone nothing is.
#[test]
fn after_a_fast_press_nothing_is_felt() {
    let legs = [
        Leg(100, [-20.0, 0.0], OPEN),
        Leg(500, [-20.0, 0.0], OPEN),
        Leg(100, [40.0, 0.0], OPEN),
        Leg(500, [40.0, 0.0], OPEN),
        Leg(500, [40.0, 0.0], OPEN),
    ];
    let felt = work(prepared_triangle(false), &legs);
    assert!(felt[1].largest_n > 0.1 && felt[1].awake > 0, "{felt:?}");
    assert!(felt[4].largest_n < 1.0e-6, "{felt:?}");
}

/// What nobody touches comes to rest, and costs nothing from then on.
#[test]
fn scenes_that_are_left_alone_sleep() {
    let away = Leg(4000, [20.0, 0.0], OPEN);
    for built in [
        prepared_triangle(false),
        prepared_triangle(true),
        prepared_built_in(),
    ] {
        let all = work(built, std::slice::from_ref(&away));
        assert_eq!(all[0].awake, 0);
    }
}

/// A thin duct that a hand holds aside comes to rest: a push that turned with it at once would make it flutter.
#[test]
fn a_duct_under_a_tool_does_not_flutter() {
    let built = prepared_triangle(false);
    let room = built.scene.room.expect("a room");
    let port_m = Vec3::from(room.instrument_port_m);
    let duct = built
        .report
        .organs
        .iter()
        .position(|it| it.name == "cystic duct");
    let [first, count] = built.scene.organs[duct.expect("it has one")].spheres;
    let legs = [
        Leg(2600, [-8.0, 0.0], OPEN),
        Leg(700, [-8.0, 6.0], OPEN),
        Leg(1000, [-8.0, 6.0], OPEN),
        Leg(300, [-8.0, 6.0], OPEN),
        Leg(900, [-8.0, -4.0], OPEN),
        Leg(1000, [-8.0, -4.0], OPEN),
        Leg(300, [-8.0, -4.0], OPEN),
    ];
    let mut most_n = 0.0f32;
    for eighth in [3, 4] {
        for instrument in [Instrument::Hook, Instrument::ClipApplier] {
            let sphere = &built.scene.spheres[(first + count * eighth / 8) as usize];
            let center_m = Vec3::from(sphere.center_m);
            let normal = (port_m - center_m).normalize();
            let site = Site {
                target_m: center_m + normal * sphere.radius_m,
                normal,
                instrument,
            };
            let all = work_at(built, &site, &legs);
            for held in [3, 6] {
                most_n = most_n.max(all[held].largest_n);
                println!("{eighth} {instrument:?}: {:?}", all[held]);
                assert!(
                    all[held].largest_step_n < 0.5 * STEP_N,
                    "{eighth} {instrument:?}: {:?}",
                    all[held]
                );
            }
        }
    }
    assert!(most_n > 0.001, "{most_n}");
}
