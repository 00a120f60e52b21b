//! A hand that works slowly with an instrument in a whole scene, and the force that it feels.

use super::LoadedScene;
use rt_core::fault::Fault;
use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Polled};
use rt_core::sim::{Command, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::tool::{Instrument, Kinematics};
use rt_core::words::SphereBits;
use scene_prepare::Prepared;

/// A Touch-class device.
pub(crate) const TOUCH: DeviceCapabilities = DeviceCapabilities::TOUCH;

pub(crate) const OPEN: Buttons = Buttons(0);

struct Hand {
    samples: Samples,
    force_n: Vec3,
    step_n: Vec3,
    trips: u64,
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
        self.trips = view.fault_counters.of(Fault::SpeedTrip);
        let is_awake = |sphere: &rt_core::sim::SphereView| sphere.bits.contains(SphereBits::AWAKE);
        self.awake = view.spheres().filter(is_awake).count();
    }

    fn stamp(&mut self, _: Stage) {}
}

/// Place and tool of the work, in the world frame.
pub(crate) struct Site {
    pub(crate) target_m: Vec3,
    pub(crate) normal: Vec3,
    /// Unit vector across the normal: the direction of a [`Leg`]'s second number.
    pub(crate) along: Vec3,
    pub(crate) instrument: Instrument,
}

impl Site {
    /// The place where a line from the port meets sphere number `sphere` of a scene.
    pub(crate) fn facing_port(built: &Prepared, sphere: u32, instrument: Instrument) -> Self {
        let room = built.scene.room.expect("a room");
        let sphere = &built.scene.spheres[sphere as usize];
        let center_m = Vec3::from(sphere.center_m);
        let normal = (Vec3::from(room.instrument_port_m) - center_m).normalize();
        Self {
            target_m: center_m + normal * sphere.radius_m,
            normal,
            // The port is above, so the normal is not parallel to x.
            along: normal.cross(&Vec3::x()).normalize(),
            instrument,
        }
    }
}

/// A part of the hand's way, which begins and ends gently: the number of ticks, the tip's place at
/// the end (out of the tissue, along it), mm, and the handle's buttons. The way starts 20 mm above
/// the target.
#[derive(Clone, Copy)]
pub(crate) struct Leg(pub(crate) u16, pub(crate) [f32; 2], pub(crate) Buttons);

/// Measurements of one leg.
#[derive(Debug)]
pub(crate) struct Felt {
    pub(crate) largest_step_n: f32,
    /// Largest difference between a step and the step before, N per tick.
    pub(crate) largest_knock_n: f32,
    pub(crate) largest_n: f32,
    /// Largest force in the first ticks ([`FIRST`]) of the leg, N.
    pub(crate) first_n: f32,
    /// Trips so far. A trip switches the force off because something was too fast.
    pub(crate) trips: u64,
    /// Number of spheres that are awake at the leg's end.
    pub(crate) awake: usize,
}

/// Number of ticks for [`Felt::first_n`].
const FIRST: u16 = 30;

pub(crate) fn work_at(built: &Prepared, site: &Site, legs: &[Leg]) -> Vec<Felt> {
    let room = built.scene.room.expect("a room");
    let loaded = LoadedScene::new(&built.scene);
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
        trips: 0,
        awake: 0,
    };
    let (mut from, mut sequence) = ([20.0f32, 0.0], 0u16);
    let mut all = Vec::new();
    for Leg(ticks, to, buttons) in legs {
        let mut felt = Felt {
            largest_step_n: 0.0,
            largest_knock_n: 0.0,
            largest_n: 0.0,
            first_n: 0.0,
            trips: 0,
            awake: 0,
        };
        for tick in 1..=*ticks {
            let share = f32::from(tick) / f32::from(*ticks);
            let share = share * share * (3.0 - 2.0 * share);
            let at = [0, 1].map(|i| (from[i] + (to[i] - from[i]) * share) * 1.0e-3);
            let tip_m = site.target_m + site.normal * at[0] + site.along * at[1];
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
            if tick <= FIRST {
                felt.first_n = felt.largest_n;
            }
        }
        felt.trips = hand.trips;
        felt.awake = hand.awake;
        all.push(felt);
        from = *to;
    }
    all
}
