//! Stones that leave the gallbladder through a hole, lie on tissue, and are picked up.
//!
//! Stones belong to the tick, unlike blood and bile, which only displays show. The jaws hold
//! stones, and only the tick knows the jaws at every moment. A replay then has the same stones bit
//! for bit, every display shows the same ones, and the score counts what the events say.
//!
//! # Spill
//!
//! Bile and stones are taken to be mixed evenly. With `N` stones in `V` of bile, a flow `Q` of bile
//! takes `Q N / V` stones a second along (`scene::Stones::per_bile_m3`). `Q` is the full
//! flow of the gallbladder times the share that the leak reports. The first stone is on average
//! half of `V / N` away. Only stones that fit through the hole leave: a wall stretches around a
//! stone by `STRETCH`. Holes that lie close together tear into one of their common area. The
//! pressure of bile does not fall, as in `procedure::vessel`, so stones leave until none
//! are left.
//!
//! # Motion
//!
//! A stone is a ball without weight on anything (25 mm weigh 9 g, and 4 mm weigh 0.04 g). It falls,
//! rolls on the contact skins and on the spheres of tubes (`surface`) and in the abdomen below the
//! organs (`bowl`), and comes to rest where it stays near a place (`motion`). Then it follows the
//! nearest sphere of the tissue. Tools push it. Stones push each other. Each stone moves in one of
//! `STEP_TICKS` ticks, so a tick moves four stones at most.
//!
//! # Picking up
//!
//! A grasper whose jaws close around a stone holds it. The stone keeps the jaws open. Its force on
//! the fingers is not rendered. A held stone is retrieved when it reaches the port, or when the
//! instrument is changed, because then the grasper leaves the body. Suction takes stones that are
//! smaller than its bore.

mod bowl;
pub(crate) mod grip;
mod motion;
mod surface;
mod touch;

use heapless::Vec;

use crate::capacity::{MAX_HOLES, MAX_ORGANS, MAX_STONES};
use crate::contact::skin::vertex_cache::VertexCache;
use crate::hash::Hash;
use crate::math::{self, Quat, Vec3};
use crate::procedure::journal::Journal;
use crate::procedure::vessel::{Mouth, Vessels};
use crate::scene::{Inside, Organ, Scene};
use crate::time::TICK_S;
use crate::tissue::{Bodies, Bounds};
use crate::tool::Capsule;
use crate::words::{Event, EventKind};
use grip::Held;
use motion::Rest;

/// Ticks from one step of a stone to its next.
const STEP_TICKS: u64 = 8;
/// Time of a step of a stone, s.
const STEP_S: f32 = STEP_TICKS as f32 * TICK_S;
/// Flow of bile from a gallbladder that is fully open, m³/s: 20 ml/min, as `flow_ml_min` of the
/// assessment's built-in rules (a test of `calot` compares them).
pub const FULL_FLOW_M3_S: f32 = 20.0e-6 / 60.0;
/// Width of the widest stone that passes a hole, in widths of the hole. No source: assumed, because
/// the wall is soft and full of pressed stones.
const STRETCH: f32 = 1.5;
/// Distance of holes at rest below which they are one hole, m: two widths of a burnt hole.
const JOINED_M: f32 = 0.006;
/// Speed at which a stone leaves a hole, m/s. Assumed: it is squeezed out and drops.
const LEAVES_M_S: f32 = 0.02;

/// Place of a stone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// In the gallbladder.
    Inside,
    /// Falls or rolls.
    Moves,
    /// Rests on tissue.
    Rests(Rest),
    /// Between the jaws.
    Held(Held),
    /// Out of the body.
    Retrieved,
    /// It has no finite place, so it counts as left in the body.
    Lost,
}

impl Place {
    /// Number of the kind of place.
    const fn number(&self) -> u32 {
        match self {
            Self::Inside => 0,
            Self::Moves => 1,
            Self::Rests(_) => 2,
            Self::Held(_) => 3,
            Self::Retrieved => 4,
            Self::Lost => 5,
        }
    }
}

/// A stone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stone {
    /// Its place.
    pub place: Place,
    /// Centre, world frame, m.
    pub at_m: Vec3,
    /// Orientation.
    pub turn: Quat,
    velocity_m_s: Vec3,
    /// Place near which it may come to rest, m, and its steps near that place.
    trail_m: Vec3,
    calm_steps: u16,
}

impl Stone {
    /// True if it is outside of the gallbladder and can be seen.
    #[must_use]
    pub const fn is_loose(&self) -> bool {
        matches!(self.place, Place::Moves | Place::Rests(_) | Place::Held(_))
    }

    /// True if the jaws hold it.
    #[must_use]
    pub const fn is_held(&self) -> bool {
        matches!(self.place, Place::Held(_))
    }

    /// True if it lies or moves on tissue.
    const fn is_free(&self) -> bool {
        matches!(self.place, Place::Moves | Place::Rests(_))
    }

    fn set_free(&mut self) {
        self.place = Place::Moves;
        self.velocity_m_s = Vec3::zeros();
        self.trail_m = self.at_m;
        self.calm_steps = 0;
    }
}

/// A stone in the gallbladder.
const INSIDE: Stone = Stone {
    place: Place::Inside,
    at_m: Vec3::new(0.0, 0.0, 0.0),
    turn: Quat::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
    velocity_m_s: Vec3::new(0.0, 0.0, 0.0),
    trail_m: Vec3::new(0.0, 0.0, 0.0),
    calm_steps: 0,
};

/// All stones, inside and outside of the gallbladder. Stones beyond the scene's number stay
/// [`Place::Inside`] and do not count.
#[derive(Debug, Clone)]
pub(crate) struct StoneState {
    stones: [Stone; MAX_STONES],
    /// Share of the next stone that has become due, 0 to 1.
    due: f32,
    /// Opening at which the held stone stops the jaws, and the least opening since they caught it.
    stop: f32,
    least_opening: f32,
    cache: VertexCache,
}

/// Tissue and tools that stones meet.
pub(crate) struct Surroundings<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) bodies: &'a Bodies,
    pub(crate) bounds: &'a [Bounds; MAX_ORGANS],
    pub(crate) tools: &'a [&'a Capsule],
}

impl StoneState {
    pub(crate) const fn new() -> Self {
        Self {
            stones: [INSIDE; MAX_STONES],
            due: 0.5,
            stop: 0.0,
            least_opening: 0.0,
            cache: VertexCache::new(),
        }
    }

    /// Puts all stones back into the gallbladder.
    pub(crate) fn reset(&mut self) {
        self.stones = [INSIDE; MAX_STONES];
        (self.due, self.stop) = (0.5, 0.0);
    }

    /// The scene's stones, in order.
    pub(crate) fn all(&self, scene: &Scene<'_>) -> &[Stone] {
        self.stones
            .get(..scene.stones.count as usize)
            .unwrap_or(&self.stones)
    }

    /// Adds the stones to a hash. A scene without stones adds nothing.
    pub(crate) fn hash_into(&self, scene: &Scene<'_>, hash: &mut Hash) {
        for stone in self.all(scene) {
            hash.word(stone.place.number());
            hash.vector(&stone.at_m);
            hash.vector(&stone.velocity_m_s);
        }
    }

    /// Lets stones leave through the holes of the gallbladder, and moves this tick's share of the
    /// stones that left.
    pub(crate) fn advance(
        &mut self,
        tick: u64,
        vessels: &Vessels,
        around: &Surroundings<'_>,
        journal: &mut Journal,
    ) {
        let scene = around.scene;
        if scene.stones.count == 0 {
            return;
        }
        self.cache.begin();
        self.spill(vessels, around, journal);
        for number in 0..self.all(scene).len() {
            let is_due = (tick.wrapping_add(number as u64)).is_multiple_of(STEP_TICKS);
            if is_due && self.stones.get(number).is_some_and(Stone::is_free) {
                self.step(number, tick, around);
            }
        }
    }

    /// Lets the stones leave that are due.
    fn spill(&mut self, vessels: &Vessels, around: &Surroundings<'_>, journal: &mut Journal) {
        let scene = around.scene;
        let is_inside = |it: &Stone| it.place == Place::Inside;
        let Some(number) = self.all(scene).iter().position(is_inside) else {
            return;
        };
        let Some((organ, bag)) = (0u32..).zip(scene.organs).find(|(_, it)| is_bag(it)) else {
            return;
        };
        let mouths: Vec<Mouth, MAX_HOLES> = vessels.mouths(bag).take(MAX_HOLES).collect();
        let (mut flow, mut widest): (f32, Option<&Mouth>) = (0.0, None);
        for mouth in &mouths {
            let width_m = joined_width_m(mouth, &mouths, scene);
            if mouth.flow > 0.0 && scene.stones.diameter_m <= STRETCH * width_m {
                flow += mouth.flow;
                if widest.is_none_or(|it| mouth.flow > it.flow) {
                    widest = Some(mouth);
                }
            }
        }
        let Some(mouth) = widest else { return };
        self.due += flow * FULL_FLOW_M3_S * scene.stones.per_bile_m3() * TICK_S;
        if self.due < 1.0 || !journal.has_room() {
            return;
        }
        let Some((at_m, normal)) = self.outside_of(mouth.sphere, around) else {
            return;
        };
        self.due -= 1.0;
        let radius_m = scene.stones.radius_m();
        if let Some(stone) = self.stones.get_mut(number) {
            stone.at_m = at_m + normal * radius_m;
            stone.turn = first_turn(number);
            stone.set_free();
            stone.velocity_m_s = normal * LEAVES_M_S;
            journal.raise(Event {
                kind: EventKind::StoneSpilled,
                organ: Some(organ),
                at_m: stone.at_m,
                value: number as f32,
            });
        }
    }

    /// Place on the skin at this sphere of the gallbladder, m, and the outward normal there.
    fn outside_of(&mut self, sphere: u32, around: &Surroundings<'_>) -> Option<(Vec3, Vec3)> {
        let (scene, bodies) = (around.scene, around.bodies);
        let vertex = scene.skin.near_sphere(sphere)?;
        let at_m = self.cache.at_m(vertex, &scene.skin, bodies)?;
        let normal = self.cache.normal(vertex, &scene.skin, bodies)?;
        Some((at_m, normal))
    }
}

/// True for an organ that holds bile, as the gallbladder does.
fn is_bag(organ: &Organ) -> bool {
    organ.inside == Inside::Bile && !organ.is_tube()
}

/// Width of the round hole that has the area of this hole and of all holes near it, m.
fn joined_width_m(mouth: &Mouth, mouths: &[Mouth], scene: &Scene<'_>) -> f32 {
    let at_rest_m = |sphere: u32| {
        let rest = scene.spheres.get(sphere as usize);
        rest.map_or_else(Vec3::zeros, |it| it.center_m)
    };
    let own_m = at_rest_m(mouth.sphere);
    let near = mouths
        .iter()
        .filter(|it| math::norm(&(at_rest_m(it.sphere) - own_m)) < JOINED_M);
    let area_m2: f32 = near.map(|it| it.area_m2).sum();
    math::sqrt(4.0 / core::f32::consts::PI * area_m2)
}

/// Orientation in which a stone leaves: each another one.
fn first_turn(number: usize) -> Quat {
    let along = |k: u32| {
        let hash = (number as u32).wrapping_mul(3).wrapping_add(k);
        let hash = hash.wrapping_mul(0x9e37_79b9);
        ((hash ^ hash >> 15) >> 8) as f32 / 8_388_608.0 - 1.0
    };
    motion::unit_turn(1.0, &Vec3::new(along(0), along(1), along(2)))
}
