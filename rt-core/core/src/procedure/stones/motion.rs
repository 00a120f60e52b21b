//! Fall, rolling and rest of a stone.

use crate::math::{self, Quat, Vec3};
use crate::procedure::stones::surface::off_tool;
use crate::procedure::stones::touch::Touch;
use crate::procedure::stones::{Place, STEP_S, STEP_TICKS, Stone, StoneState, Surroundings};
use crate::tissue::Bodies;

/// Fastest fall, m/s. A faster stone could pass through a thin tube within a step. It is the speed
/// after a fall of 8 mm.
const FASTEST_M_S: f32 = 0.4;
/// Steepest slope on which a stone rests, rise over run. No source: facets and wet tissue hold it
/// on 14°.
const HOLDS: f32 = 0.25;
/// Time in which the film between stone and tissue takes a rolling stone's speed by the factor e,
/// s. No source: a stone rolls down 45° at 0.2 m/s.
const FILM_S: f32 = 0.03;
/// Largest way out of tissue in a step, m.
const OUT_MAX_M: f32 = 0.002;
/// Overlap with a tool beyond which a resting stone moves, m.
const PUSHED_M: f32 = 0.000_1;
/// Distance from its trail below which a stone counts as calm, m.
const CALM_M: f32 = 0.000_5;
/// Steps of calm until a stone rests: 0.4 s. The distance decides, not the speed, as for organs
/// ([`crate::tissue::sleep`]), so a stone that trembles between two folds rests too.
const CALM_STEPS: u16 = 50;
/// Gap to its tissue at which a resting stone falls, m.
const LIFTED_M: f32 = 0.001;
/// Least cosine between directions in the tissue now and when the stone came to rest: at 18° it
/// moves.
const TURNED: f32 = 0.95;
/// Steps from one look of a resting stone at its tissue to the next: 0.1 s.
const LOOK_STEPS: u64 = 13;

/// Rest on tissue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// Sphere of the tissue that carries the stone; `None` for the abdomen below the organs.
    sphere: Option<u32>,
    /// Place of the stone from the sphere's centre, or in the world, m.
    from_sphere_m: Vec3,
    /// Directions from this sphere to its neighbours in the scene's order when the stone came to
    /// rest.
    towards: [Vec3; 2],
}

/// Centre of the sphere that carries a stone, m; zero for the abdomen.
fn carrier_m(sphere: Option<u32>, bodies: &Bodies) -> Vec3 {
    sphere.map_or_else(Vec3::zeros, |it| bodies.nodes.at(it).center_m())
}

/// Directions from a sphere to the spheres before and after it. They turn with the tissue. The
/// nearest place of a skin does not tell a turn: between two folds it changes from one to the
/// other.
fn towards_neighbours(sphere: Option<u32>, bodies: &Bodies) -> [Vec3; 2] {
    let Some(sphere) = sphere else {
        return [Vec3::zeros(); 2];
    };
    let own_m = bodies.nodes.at(sphere).center_m();
    let towards = |other: u32| {
        let displacement_m = bodies.nodes.at(other).center_m() - own_m;
        math::unit(&displacement_m).unwrap_or_else(Vec3::zeros)
    };
    [
        towards(sphere.saturating_sub(1)),
        towards(sphere.saturating_add(1)),
    ]
}

impl StoneState {
    /// Moves the free stone with this number by a step.
    pub(super) fn step(&mut self, number: usize, tick: u64, around: &Surroundings<'_>) {
        let Some(mut stone) = self.stones.get(number).copied() else {
            return;
        };
        if let Place::Rests(rest) = stone.place {
            stone.at_m = carrier_m(rest.sphere, around.bodies) + rest.from_sphere_m;
            let looks = (tick / STEP_TICKS + number as u64).is_multiple_of(LOOK_STEPS);
            if self.is_pushed(&stone, around)
                || looks && self.is_unseated(&stone, number, &rest, around)
            {
                stone.set_free();
            }
        } else {
            self.roll(&mut stone, number, around);
        }
        if let Some(own) = self.stones.get_mut(number) {
            *own = stone;
        }
    }

    fn is_pushed(&self, stone: &Stone, around: &Surroundings<'_>) -> bool {
        let radius_m = around.scene.stones.radius_m();
        let mut tools = around.tools.iter();
        tools.any(|tool| off_tool(tool, &stone.at_m, radius_m).0 < -PUSHED_M)
    }

    /// True if what carried a resting stone has gone, sunk or turned.
    fn is_unseated(
        &mut self,
        stone: &Stone,
        number: usize,
        rest: &Rest,
        around: &Surroundings<'_>,
    ) -> bool {
        let Some(seat) = self.seat(stone, number, around) else {
            return true;
        };
        let towards = towards_neighbours(rest.sphere, around.bodies);
        let is_turned = |(now, then): (&Vec3, &Vec3)| now.dot(then) < TURNED * then.norm_squared();
        seat.gap_m > LIFTED_M || towards.iter().zip(&rest.towards).any(is_turned)
    }

    /// The tissue or the other stone nearest to a stone. Either way the sphere is one of tissue.
    fn seat(&mut self, stone: &Stone, number: usize, around: &Surroundings<'_>) -> Option<Touch> {
        let radius_m = around.scene.stones.radius_m();
        let touches = around.touches(&stone.at_m, radius_m, &mut self.cache);
        let mut seat = nearest(&touches).copied();
        for (other, it) in self.all(around.scene).iter().enumerate() {
            let (Place::Rests(rest), true) = (it.place, other != number) else {
                continue;
            };
            let offset_m = stone.at_m - it.at_m;
            let gap_m = math::norm(&offset_m) - 2.0 * radius_m;
            if gap_m < LIFTED_M && seat.is_none_or(|it| gap_m < it.gap_m) {
                seat = Some(Touch {
                    gap_m,
                    normal: math::unit(&offset_m).unwrap_or_else(|| around.up()),
                    sphere: seat.map_or(rest.sphere, |it| it.sphere),
                });
            }
        }
        seat.filter(|it| it.gap_m < LIFTED_M)
    }

    fn roll(&mut self, stone: &mut Stone, number: usize, around: &Surroundings<'_>) {
        let scene = around.scene;
        let (radius_m, gravity_m_s2) = (scene.stones.radius_m(), scene.room.gravity_m_s2);
        stone.velocity_m_s += gravity_m_s2 * STEP_S;
        let speed_m_s = math::norm(&stone.velocity_m_s);
        stone.velocity_m_s *= FASTEST_M_S / speed_m_s.max(FASTEST_M_S);
        let from_m = stone.at_m;
        stone.at_m += stone.velocity_m_s * STEP_S;
        self.give_way(stone, number, around);
        if let Some((ground, pushed_m)) = self.come_out(stone, around) {
            slow_down(stone, &ground.normal, &from_m, pushed_m);
            let displacement_m = stone.at_m - from_m;
            stone.turn = rolled(&stone.turn, &ground.normal, &displacement_m, radius_m);
        }
        self.give_way(stone, number, around);
        self.come_out(stone, around);
        self.settle(stone, number, around);
    }

    /// Moves a stone out of tissue. Returns the deepest contact, and how far all have pushed it, m.
    fn come_out(&mut self, stone: &mut Stone, around: &Surroundings<'_>) -> Option<(Touch, f32)> {
        let radius_m = around.scene.stones.radius_m();
        let touches = around.touches(&stone.at_m, radius_m, &mut self.cache);
        let (mut ground, mut pushed_m): (Option<Touch>, f32) = (None, 0.0);
        for touch in touches.iter().filter(|it| it.gap_m < 0.0) {
            push(stone, &touch.normal, -touch.gap_m);
            pushed_m -= touch.gap_m;
            if ground.is_none_or(|it| touch.gap_m < it.gap_m) {
                ground = Some(*touch);
            }
        }
        ground.map(|it| (it, pushed_m))
    }

    /// Moves a stone out of tools and out of other stones.
    fn give_way(&self, stone: &mut Stone, number: usize, around: &Surroundings<'_>) {
        let radius_m = around.scene.stones.radius_m();
        for tool in around.tools {
            let (gap_m, direction) = off_tool(tool, &stone.at_m, radius_m);
            if gap_m < 0.0 {
                push(stone, &direction, -gap_m);
            }
        }
        for (other, it) in self.all(around.scene).iter().enumerate() {
            let offset_m = stone.at_m - it.at_m;
            let overlap_m = 2.0 * radius_m - math::norm(&offset_m);
            if other != number && it.is_loose() && overlap_m > 0.0 {
                let direction = math::unit(&offset_m).unwrap_or_else(|| around.up());
                push(stone, &direction, overlap_m);
            }
        }
    }

    /// Lets a stone rest that has stayed near its trail. A stone without a finite place is lost.
    fn settle(&mut self, stone: &mut Stone, number: usize, around: &Surroundings<'_>) {
        if !math::is_finite(&stone.at_m) {
            stone.place = Place::Lost;
            return;
        }
        if math::norm(&(stone.at_m - stone.trail_m)) > CALM_M {
            (stone.trail_m, stone.calm_steps) = (stone.at_m, 0);
            return;
        }
        stone.calm_steps = stone.calm_steps.saturating_add(1);
        if stone.calm_steps < CALM_STEPS {
            return;
        }
        if let Some(touch) = self.seat(stone, number, around) {
            stone.place = Place::Rests(Rest {
                sphere: touch.sphere,
                from_sphere_m: stone.at_m - carrier_m(touch.sphere, around.bodies),
                towards: towards_neighbours(touch.sphere, around.bodies),
            });
        }
    }
}

fn nearest(touches: &[Touch]) -> Option<&Touch> {
    touches.iter().min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

/// Moves a stone along `direction`, and takes its speed against this direction.
fn push(stone: &mut Stone, direction: &Vec3, by_m: f32) {
    stone.at_m += direction * by_m.min(OUT_MAX_M);
    let against_m_s = stone.velocity_m_s.dot(direction).min(0.0);
    stone.velocity_m_s -= direction * against_m_s;
}

/// Slows a rolling stone on tissue with this normal. Its rolling resistance is in proportion to how
/// far the tissue has pushed it out of its way; the film under it slows it too. A stone that
/// gravity does not move stays at `from_m`.
fn slow_down(stone: &mut Stone, normal: &Vec3, from_m: &Vec3, pushed_m: f32) {
    let displacement_m = stone.at_m - from_m;
    let along_m = displacement_m - normal * normal.dot(&displacement_m);
    let length_m = math::norm(&along_m);
    let left_m = ((length_m - HOLDS * pushed_m) * (1.0 - STEP_S / FILM_S)).max(0.0);
    let share = left_m / length_m.max(f32::MIN_POSITIVE);
    stone.at_m -= along_m * (1.0 - share);
    let outwards_m_s = normal.dot(&stone.velocity_m_s);
    stone.velocity_m_s = normal * outwards_m_s + along_m * (share / STEP_S);
}

/// Orientation after rolling by `displacement_m` over tissue with this normal.
fn rolled(turn: &Quat, normal: &Vec3, displacement_m: &Vec3, radius_m: f32) -> Quat {
    let half_turn = normal.cross(displacement_m) * (0.5 / radius_m.max(f32::MIN_POSITIVE));
    unit_turn(1.0, &half_turn) * turn
}

/// Rotation whose quaternion points along (w, v).
pub(super) fn unit_turn(w: f32, v: &Vec3) -> Quat {
    let length = math::sqrt(w * w + v.norm_squared()).max(f32::MIN_POSITIVE);
    let v = v / length;
    Quat::new_unchecked(nalgebra::Quaternion::new(w / length, v.x, v.y, v.z))
}
