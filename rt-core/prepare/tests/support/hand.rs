//! A scripted hand that works with an instrument in a whole scene, and the forces that it feels.

use super::LoadedScene;
use rt_core::fault::Fault;
use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Polled};
use rt_core::sim::{Command, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::tool::{Instrument, Kinematics};
use rt_core::words::{EventKind, SphereBits};
use scene_prepare::Prepared;

const OPEN: Buttons = Buttons(0);

/// A length in a script.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Length {
    mm: f32,
}

pub(crate) const fn mm(mm: f32) -> Length {
    Length { mm }
}

/// A time in a script, in ticks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Time {
    ticks: u16,
}

/// Seconds, rounded to ticks.
pub(crate) fn s(seconds: f32) -> Time {
    let ticks = (seconds * 1.0e3).round() as u16;
    Time { ticks }
}

/// Place of the tip relative to the target.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Distance out of the tissue, along the normal, mm.
    height_mm: f32,
    /// Distance along the tissue, mm.
    along_mm: f32,
}

/// Place at which every script begins, with open jaws.
const START: Place = Place {
    height_mm: 20.0,
    along_mm: 0.0,
};

impl Place {
    /// Place in a motion from here to `end`, after this share of the motion's time. The motion has
    /// zero speed at its beginning and end.
    fn towards(&self, end: &Self, share: f32) -> Self {
        let share = share * share * (3.0 - 2.0 * share);
        let between = |from: f32, to: f32| from + (to - from) * share;
        Self {
            height_mm: between(self.height_mm, end.height_mm),
            along_mm: between(self.along_mm, end.along_mm),
        }
    }
}

/// A leg of a script: a motion to a place within a time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    pub(crate) name: &'static str,
    time: Time,
    /// Place at the leg's end.
    end: Place,
    pub(crate) buttons: Buttons,
}

/// A script, such as `Hand::new().press(mm(20.0), s(3.6)).rest(s(2.0))`. It begins at [`START`].
#[derive(Debug, Clone)]
pub(crate) struct Hand {
    legs: Vec<Leg>,
}

impl Hand {
    pub(crate) const fn new() -> Self {
        Self { legs: Vec::new() }
    }

    /// Goes straight to this depth below the target's height.
    pub(crate) fn press(self, depth: Length, within: Time) -> Self {
        let end = Place {
            height_mm: -depth.mm,
            ..self.end()
        };
        self.go("press", end, within)
    }

    /// Goes straight to this height above the target's height.
    pub(crate) fn lift(self, height: Length, within: Time) -> Self {
        let end = Place {
            height_mm: height.mm,
            ..self.end()
        };
        self.go("lift", end, within)
    }

    /// Goes along the tissue to this distance from the target.
    pub(crate) fn slide(self, along: Length, within: Time) -> Self {
        let end = Place {
            along_mm: along.mm,
            ..self.end()
        };
        self.go("slide", end, within)
    }

    /// Goes to this depth below the target itself.
    pub(crate) fn return_to_depth(self, depth: Length, within: Time) -> Self {
        let end = Place {
            height_mm: -depth.mm,
            along_mm: 0.0,
        };
        self.go("return", end, within)
    }

    /// Goes back to the place where the script began.
    pub(crate) fn leave(self, within: Time) -> Self {
        self.go("leave", START, within)
    }

    /// Keeps its place.
    pub(crate) fn rest(self, time: Time) -> Self {
        let end = self.end();
        self.go("rest", end, time)
    }

    /// Keeps its place and closes the jaws. They stay closed in the legs that follow.
    pub(crate) fn grasp(self, time: Time) -> Self {
        let end = self.end();
        let mut hand = self.go("grasp", end, time);
        hand.last().buttons = Buttons::GRASP;
        hand
    }

    /// Names the last leg. Without this, a leg has the name of its verb.
    pub(crate) fn named(mut self, name: &'static str) -> Self {
        self.last().name = name;
        self
    }

    fn go(mut self, name: &'static str, end: Place, time: Time) -> Self {
        let buttons = self.legs.last().map_or(OPEN, |leg| leg.buttons);
        self.legs.push(Leg {
            name,
            time,
            end,
            buttons,
        });
        self
    }

    fn last(&mut self) -> &mut Leg {
        self.legs.last_mut().expect("a leg")
    }

    fn end(&self) -> Place {
        self.legs.last().map_or(START, |leg| leg.end)
    }
}

/// The handle of a running simulation.
struct Handle {
    samples: Samples,
    force_n: Vec3,
    step_n: Vec3,
    trips: u64,
    awake: usize,
}

impl Ports for Handle {
    fn sample(&mut self) -> Samples {
        self.samples
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.step_n = command.force_n - self.force_n;
        self.force_n = command.force_n;
    }

    fn publish(&mut self, view: &TickView<'_>) {
        let mut events = view.events.iter();
        let shake = events.find(|event| event.kind == EventKind::Shake);
        assert!(shake.is_none(), "no organ shakes: {shake:?}");
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
    /// Direction along the tissue, perpendicular to the normal.
    pub(crate) along: Vec3,
    pub(crate) instrument: Instrument,
}

impl Site {
    /// The place where a line from the port to the centre of sphere `sphere` meets this sphere.
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

    fn tip_m(&self, place: Place) -> Vec3 {
        let [height_m, along_m] = [place.height_mm, place.along_mm].map(|mm| mm * 1.0e-3);
        self.target_m + self.normal * height_m + self.along * along_m
    }
}

/// Measurements of one leg.
#[derive(Debug)]
pub(crate) struct Felt {
    pub(crate) leg: Leg,
    pub(crate) largest_step_n: f32,
    /// Largest difference between a step and the step before, N per tick.
    pub(crate) largest_knock_n: f32,
    pub(crate) largest_n: f32,
    /// Largest force in the first ticks ([`FIRST`]) of the leg, N.
    pub(crate) first_n: f32,
    /// Number of speed trips so far. A trip switches the force off, because the handle was too
    /// fast.
    pub(crate) trips: u64,
    /// Number of spheres that are awake at the leg's end.
    pub(crate) awake: usize,
}

/// Number of ticks for [`Felt::first_n`].
const FIRST: u16 = 30;

/// Measurements of a performed script, leg by leg.
#[derive(Debug)]
pub(crate) struct Work {
    pub(crate) legs: Vec<Felt>,
}

impl Work {
    /// Measurements of the first leg of this name.
    pub(crate) fn leg(&self, name: &str) -> &Felt {
        let found = self.legs.iter().find(|felt| felt.leg.name == name);
        found.expect("a leg of this name")
    }
}

impl Hand {
    /// Performs the script in a scene. Panics if an organ shakes.
    pub(crate) fn work(&self, built: &Prepared, site: &Site) -> Work {
        let room = built.scene.room.expect("a room");
        let loaded = LoadedScene::new(&built.scene);
        let mut state = Box::new(State::new());
        let parameters = Parameters {
            force_ramp_s: 0.01,
            force_enabled: true,
        };
        let mut sim = Sim::new(
            loaded.scene(),
            &mut state,
            DeviceCapabilities::TOUCH,
            parameters,
        );
        let lever = Kinematics {
            port_m: Vec3::from(room.instrument_port_m),
            length_m: room.instrument_length_m,
        };
        let mut handle = Handle {
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
        let (mut from, mut sequence) = (START, 0u16);
        let mut legs = Vec::new();
        for leg in &self.legs {
            let ticks = leg.time.ticks;
            let mut felt = Felt {
                leg: *leg,
                largest_step_n: 0.0,
                largest_knock_n: 0.0,
                largest_n: 0.0,
                first_n: 0.0,
                trips: 0,
                awake: 0,
            };
            for tick in 1..=ticks {
                let at = from.towards(&leg.end, f32::from(tick) / f32::from(ticks));
                let tip_m = site.tip_m(at);
                sequence = sequence.wrapping_add(1);
                handle.samples.now_ns += 1_000_000;
                handle.samples.device = Polled::Fresh(DeviceSample {
                    opening: None,
                    device_from_handle: lever.handle_from_tip(&tip_m, &Vec3::y()),
                    velocity_m_s: None,
                    buttons: leg.buttons,
                    sequence,
                    at_ns: handle.samples.now_ns,
                });
                let before_n = handle.step_n;
                sim.tick(&mut handle);
                handle.samples.command = None;
                felt.largest_step_n = felt.largest_step_n.max(norm(&handle.step_n));
                felt.largest_knock_n = felt.largest_knock_n.max(norm(&(handle.step_n - before_n)));
                felt.largest_n = felt.largest_n.max(norm(&handle.force_n));
                if tick <= FIRST {
                    felt.first_n = felt.largest_n;
                }
            }
            felt.trips = handle.trips;
            felt.awake = handle.awake;
            legs.push(felt);
            from = leg.end;
        }
        Work { legs }
    }
}
