//! A hand with seeded random numbers that works with instruments at places of an organ's skin.

use glam::{Quat, Vec3};
use rt_process::rehearsal::Rehearsal;
use shared_mem::message::{CommandMsg, HandMsg, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::{Instrument, Switches};

/// Distance from the skin at which the hand starts, m.
const AWAY_M: f32 = 0.025;
/// Distance of the slide along the skin, m.
const SLIDE_M: f32 = 0.008;
/// Ticks of rest between two movements.
const REST: u64 = 200;
/// The button that closes the jaws.
const CLOSE: u32 = 1;

/// Manner of a hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Manner {
    Gentle,
    Rough,
}

impl Manner {
    pub(crate) const ALL: [Self; 2] = [Self::Gentle, Self::Rough];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Gentle => "gentle",
            Self::Rough => "rough",
        }
    }

    /// Depth of the tip below the skin's rest position, m.
    const fn depth_m(self) -> f32 {
        match self {
            Self::Gentle => 0.003,
            Self::Rough => 0.008,
        }
    }

    /// Length of a pull, m.
    const fn pull_m(self) -> f32 {
        match self {
            Self::Gentle => 0.010,
            Self::Rough => 0.030,
        }
    }

    /// Speed of the movements, m/s.
    const fn speed_m_s(self) -> f32 {
        match self {
            Self::Gentle => 0.03,
            Self::Rough => 0.15,
        }
    }
}

/// Pseudo-random numbers, determined by a seed (xorshift64*, Vigna 2016).
#[derive(Debug, Clone)]
pub(crate) struct Seeded(u64);

impl Seeded {
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// The next number, in [0, 1).
    pub(crate) fn share(&mut self) -> f32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// A place on an organ, and the direction into it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) at_m: Vec3,
    /// Unit vector into the organ.
    pub(crate) inwards: Vec3,
}

/// A random place of an organ that faces the instrument's port.
pub(crate) fn place(scene: &SceneFile, organ: usize, seeded: &mut Seeded) -> Option<Place> {
    let [first, count] = scene.organs().get(organ)?.vertices.map(|x| x as usize);
    let skin = scene.vertices().get(first..first + count)?;
    let port_m = Vec3::from(scene.room().instrument_port_m);
    let faces = |number: usize| {
        let vertex = skin.get(number)?;
        let at_m = Vec3::from(vertex.position_m);
        let normal = Vec3::from(vertex.normal);
        let to_port = (port_m - at_m).normalize_or_zero();
        (normal.dot(to_port) > 0.3).then_some(Place {
            at_m,
            inwards: -(normal + to_port).normalize_or(normal),
        })
    };
    let first = (seeded.share() * count as f32) as usize;
    (0..count).find_map(|step| faces((first + step) % count.max(1)))
}

/// The hand at an emulated device. It commands positions of the instrument's tip in the world
/// frame.
pub(crate) struct SeededHand<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    asked: HandMsg,
    /// Position of the tip at which `asked.moved_m` is zero, m.
    from_m: Option<Vec3>,
    at_m: Vec3,
    manner: Manner,
    /// Ticks between two calls of `watch`.
    look_every: u64,
    watch: &'a mut dyn FnMut(&mut Rehearsal<'b>),
}

impl<'a, 'b> SeededHand<'a, 'b> {
    /// A hand that calls `watch` every `look_every` ticks.
    pub(crate) fn new(
        rehearsal: &'a mut Rehearsal<'b>,
        manner: Manner,
        look_every: u64,
        watch: &'a mut dyn FnMut(&mut Rehearsal<'b>),
    ) -> Self {
        let asked: HandMsg = bytemuck::Zeroable::zeroed();
        let mut hand = Self {
            rehearsal,
            asked,
            from_m: None,
            at_m: Vec3::ZERO,
            manner,
            look_every,
            watch,
        };
        hand.wait(look_every);
        hand
    }

    /// Number of ticks so far.
    pub(crate) fn ticks(&self) -> u64 {
        self.rehearsal.ticks()
    }

    /// Tip of the instrument, m.
    pub(crate) fn tip_m(&self) -> Vec3 {
        tip_m(self.rehearsal.tools())
    }

    fn tick(&mut self, command: Option<CommandMsg>) {
        self.rehearsal.tick(&self.asked, command);
        if self.rehearsal.ticks().is_multiple_of(self.look_every) {
            (self.watch)(self.rehearsal);
        }
    }

    /// Keeps still for these ticks.
    pub(crate) fn wait(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.tick(None);
        }
    }

    fn command(&mut self, kind: u32, argument: u32) {
        self.tick(Some(CommandMsg { kind, argument }));
    }

    /// Moves the tip to a place at the manner's speed.
    pub(crate) fn go(&mut self, to_m: Vec3) {
        let tools = *self.rehearsal.tools();
        let from_m = *self.from_m.get_or_insert_with(|| tip_m(&tools));
        if self.at_m == Vec3::ZERO {
            self.at_m = from_m;
        }
        let picture = Quat::from_array(tools.world_from_camera.orientation);
        let step_m = self.manner.speed_m_s() * 1e-3;
        while self.at_m.distance(to_m) > step_m {
            self.at_m += (to_m - self.at_m).normalize_or_zero() * step_m;
            let moved = picture.inverse() * (self.at_m - from_m);
            self.asked.moved_m = moved.to_array().map(f64::from);
            self.tick(None);
        }
    }

    /// Moves the tip back to where it was before the first movement.
    pub(crate) fn leave(&mut self) {
        if let Some(from_m) = self.from_m {
            self.go(from_m);
        }
    }

    /// Takes another instrument in hand.
    pub(crate) fn take_up(&mut self, instrument: Instrument) {
        self.command(CommandMsg::INSTRUMENT, instrument.number());
    }

    /// Closes or opens the jaws.
    pub(crate) fn close(&mut self, closed: bool) {
        self.asked.buttons = if closed { CLOSE } else { 0 };
        self.wait(REST);
    }

    /// Works with an instrument at a place: presses, slides, closes the jaws or steps on the pedal,
    /// pulls, lets go and leaves.
    pub(crate) fn work(&mut self, instrument: Instrument, place: &Place, seeded: &mut Seeded) {
        let turn = std::f32::consts::TAU * seeded.share();
        let aside = place.inwards.any_orthonormal_vector();
        let along = Quat::from_axis_angle(place.inwards, turn) * aside;
        let deep_m = place.at_m + place.inwards * self.manner.depth_m();
        let away_m = place.at_m - place.inwards * AWAY_M;
        self.go(away_m);
        self.take_up(instrument);
        self.asked.rolled_rad += f64::from(turn);
        self.wait(REST);
        self.go(deep_m);
        self.wait(REST);
        self.go(deep_m + along * SLIDE_M);
        self.wait(REST);
        if instrument == Instrument::Hook {
            self.asked.switches = Switches::COAGULATE.bits();
        } else {
            self.asked.buttons = CLOSE;
        }
        self.wait(2 * REST);
        self.go(deep_m - place.inwards * self.manner.pull_m());
        self.wait(REST);
        self.asked.switches = 0;
        self.asked.buttons = 0;
        self.wait(REST);
        self.go(away_m);
        self.wait(REST);
    }

    /// Resets every organ.
    pub(crate) fn reset(&mut self) {
        self.command(CommandMsg::RESET, 0);
    }
}

/// Tip of the instrument: the end of a capsule that is farthest from the jaw joint, m.
pub(crate) fn tip_m(tools: &ToolFrame) -> Vec3 {
    let pose = &tools.world_from_instrument;
    let ends = tools
        .capsules()
        .unwrap_or(&[])
        .iter()
        .map(|c| Vec3::from(c.b_m));
    let joint_m = Vec3::from(pose.position_m);
    ends.max_by(|a, b| a.distance(joint_m).total_cmp(&b.distance(joint_m)))
        .unwrap_or(joint_m)
}
