//! Stability cases, one function each. The function returns true if a method survives one value of
//! the swept quantity.

use nalgebra::{Rotation3, Unit};

use super::Lab;
use super::rig::{Rig, Stand, TICK_S};
use crate::body::{Body, V3};
use crate::methods::Way;

/// A case.
pub(crate) struct Case {
    /// Name of the case.
    pub(crate) name: &'static str,
    /// Unit of the swept quantity.
    pub(crate) unit: &'static str,
    /// The sweep: from a harmless value to the value that a method should survive.
    pub(crate) sweep: [f64; 2],
    /// Returns true if a method survives a value.
    pub(crate) survives: fn(&Lab, Way, f64) -> bool,
}

/// All cases, in the chart's order.
pub(crate) const ALL: [Case; 16] = [
    case("time step", "ms", [0.25, 16.0], time_step),
    case(
        "Young's modulus, tick of 1 ms",
        "kPa",
        [1.0, 1e5],
        stiffness,
    ),
    case("masses side by side, ratio", "", [1.0, 1e4], mass_ratio),
    case("rigid rotation", "°", [1.0, 180.0], rotation),
    case("free spin, momentum and energy", "rad/s", [0.1, 4.0], spin),
    case("pulled to multiples of its length", "×", [1.05, 5.0], pull),
    case("tool through the organ", "m/s", [0.05, 3.0], tool),
    case("flattened to a plane", "share", [0.1, 1.0], plane),
    case("drawn into a point", "share", [0.1, 1.0], point),
    case("scrambled", "share", [0.02, 1.0], scrambled),
    case(
        "slivers, flatter than their face by",
        "×",
        [2.0, 20.0],
        slivers,
    ),
    case(
        "hook in a 2 mm duct, in one tick",
        "share",
        [0.1, 1.0],
        duct,
    ),
    case("conflicting holds", "mm", [1.0, 50.0], conflict),
    case("constraints removed mid-step", "share", [0.05, 0.5], cut),
    case("violent handling", "min", [0.01, 10.0], violence),
    case("noise at the grasp", "mm", [0.05, 30.0], noise),
];

const fn case(
    name: &'static str,
    unit: &'static str,
    sweep: [f64; 2],
    survives: fn(&Lab, Way, f64) -> bool,
) -> Case {
    Case {
        name,
        unit,
        sweep,
        survives,
    }
}

/// Pseudo-random numbers, equal in every run (xorshift).
struct Dice(u64);

impl Dice {
    fn new() -> Self {
        Self(0x9E37_79B9_7F4A_7C15)
    }

    /// A number from −1 to 1.
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> V3 {
        V3::new(self.next(), self.next(), self.next())
    }
}

const GRAVITY: V3 = V3::new(0.0, 0.0, -9.81);

fn end(held: &[bool]) -> Vec<usize> {
    (0..held.len()).filter(|&i| held[i]).collect()
}

fn time_step(lab: &Lab, way: Way, ms: f64) -> bool {
    let mut stand = lab.stand(way);
    stand.dt_s = ms as f32 * 1e-3;
    stand.damping_per_s = 3.0;
    let back = stand.run(way, |rig| bent(lab, rig));
    back.unwrap_or(false)
}

/// One half of the organ is bent upwards and let go.
fn bent(lab: &Lab, rig: &mut Rig<'_>) -> bool {
    rig.place(|_, x| V3::new(0.0, 0.0, 0.3 * (x.x - lab.middle_m.x).max(0.0)));
    rig.comes_back()
}

fn stiffness(lab: &Lab, way: Way, kpa: f64) -> bool {
    let mut body = lab.body(way).clone();
    body.tissue.young_pa = kpa * 1e3;
    let mut stand = Stand::new(&body, lab.half(way));
    stand.gravity_m_s2 = GRAVITY;
    let pulled = stand.run(way, |rig| {
        let grasp = end(&lab.moved(way));
        rig.hold(&grasp, true);
        for i in 0..300 {
            for &n in &grasp {
                rig.state.target_m[n] = V3::new(0.0, 0.0, 1e-4) * i as f32;
            }
            if !rig.tick() {
                return false;
            }
        }
        rig.hold(&grasp, false);
        rig.ticks(1000) && rig.farthest_m() < 0.3
    });
    pulled.unwrap_or(false)
}

/// The organ hangs from its thicker half. It must neither become unstable nor fall off.
fn mass_ratio(lab: &Lab, way: Way, ratio: f64) -> bool {
    let mut body = lab.body(way).clone();
    // The total mass stays the same. Every second sphere has `ratio` times the mass of the others.
    for (i, mass) in body.mass_kg.iter_mut().enumerate() {
        *mass *= (2.0 / (1.0 + ratio) * if i % 2 == 0 { ratio } else { 1.0 }) as f32;
    }
    let mut stand = Stand::new(&body, lab.half(way));
    stand.gravity_m_s2 = GRAVITY;
    let hung = stand.run(way, |rig| rig.ticks(2000) && rig.farthest_m() < 0.3);
    hung.unwrap_or(false)
}

/// The whole organ is rotated, with its holds. It must stay in this pose within 1 mm.
fn rotation(lab: &Lab, way: Way, degrees: f64) -> bool {
    let stand = lab.stand(way);
    let axis = Unit::new_normalize(V3::new(0.3, 1.0, 0.2));
    let stays = stand.run(way, |rig| {
        // Rotate step by step, so that a method that tracks rotations can follow.
        let steps = (degrees / 3.0).ceil().max(1.0) as usize;
        for step in 1..=steps + 300 {
            let share = step.min(steps) as f32 / steps as f32;
            let turn = Rotation3::from_axis_angle(&axis, (degrees as f32).to_radians() * share);
            if step <= steps {
                rig.place(|_, x| turn * x - x);
            }
            for i in end(&stand.held) {
                rig.state.target_m[i] = turn * rig.body.rest_m[i] - rig.body.rest_m[i];
            }
            if !rig.tick() {
                return false;
            }
        }
        let turn = Rotation3::from_axis_angle(&axis, (degrees as f32).to_radians());
        let off = |(u, x): (&V3, &V3)| (u - (turn * x - x)).norm();
        rig.state
            .u_m
            .iter()
            .zip(&rig.body.rest_m)
            .map(off)
            .fold(0.0, f32::max)
            < 1e-3
    });
    stays.unwrap_or(false)
}

/// The organ spins freely for two seconds. Its momentum must stay below 1 % of the sum of the
/// spheres' momenta. Its angular momentum may change by 15 %, and its energy may grow by 1 %.
fn spin(lab: &Lab, way: Way, rad_s: f64) -> bool {
    let mut stand = lab.stand(way);
    stand.held.fill(false);
    stand.damping_per_s = 0.0;
    let keeps = stand.run(way, |rig| {
        let mass: f32 = rig.body.mass_kg.iter().sum();
        let parts = rig.body.rest_m.iter().zip(&rig.body.mass_kg);
        let centre = parts.map(|(x, m)| x * *m).sum::<V3>() / mass;
        let omega = V3::new(0.0, 0.0, rad_s as f32);
        let turning = |x: &V3| omega.cross(&(x - centre));
        for (v, x) in rig.state.v_m_s.iter_mut().zip(&rig.body.rest_m) {
            *v = turning(x);
        }
        rig.state.is_edited = true;
        let [_, l0, e0, p_scale] = motion(rig, &centre);
        if !rig.ticks((2.0 / TICK_S) as usize) {
            return false;
        }
        let [p1, l1, e1, _] = motion(rig, &centre);
        p1 < 0.01 * p_scale && (l1 / l0 - 1.0).abs() < 0.15 && e1 < 1.01 * e0
    });
    keeps.unwrap_or(false)
}

/// Magnitudes of momentum and of angular momentum about `centre`, kinetic energy, and the sum of
/// the magnitudes of the spheres' momenta.
fn motion(rig: &Rig<'_>, centre: &V3) -> [f64; 4] {
    let (mut p, mut l) = (
        nalgebra::Vector3::<f64>::zeros(),
        nalgebra::Vector3::zeros(),
    );
    let (mut energy, mut scale) = (0.0, 0.0);
    for (i, v) in rig.state.v_m_s.iter().enumerate() {
        let (mass, v) = (f64::from(rig.body.mass_kg[i]), v.cast::<f64>());
        let arm = (rig.body.rest_m[i] + rig.state.u_m[i] - centre).cast::<f64>();
        p += v * mass;
        l += arm.cross(&v) * mass;
        energy += 0.5 * mass * v.norm_squared();
        scale += mass * v.norm();
    }
    [p.norm(), l.norm(), energy, scale]
}

fn pull(lab: &Lab, way: Way, times: f64) -> bool {
    let stand = lab.stand(way);
    let back = stand.run(way, |rig| {
        let grasp = end(&lab.moved(way));
        let long = lab.length_m * (times as f32 - 1.0);
        rig.hold(&grasp, true);
        let ticks = (long / 1.0 / TICK_S).ceil().max(1.0) as usize;
        for i in 1..=ticks {
            for &n in &grasp {
                rig.state.target_m[n] = V3::x() * (long * i as f32 / ticks as f32);
            }
            if !rig.tick() {
                return false;
            }
        }
        rig.hold(&grasp, false);
        rig.comes_back()
    });
    back.unwrap_or(false)
}

fn tool(lab: &Lab, way: Way, speed: f64) -> bool {
    let stand = lab.stand(way);
    let back = stand.run(way, |rig| {
        let ticks = (0.2 / speed as f32 / TICK_S) as usize;
        for i in 0..=ticks {
            let z = 0.1 - 0.2 * i as f32 / ticks as f32;
            rig.ball = Some((lab.middle_m + V3::new(0.0, 0.0, z), 0.012));
            if !rig.tick() {
                return false;
            }
        }
        rig.comes_back()
    });
    back.unwrap_or(false)
}

/// Places every free sphere and lets it go.
fn released(lab: &Lab, way: Way, to: impl Fn(usize, &V3) -> V3) -> bool {
    let back = lab.stand(way).run(way, |rig| {
        rig.place(&to);
        rig.comes_back()
    });
    back.unwrap_or(false)
}

fn plane(lab: &Lab, way: Way, share: f64) -> bool {
    let z = lab.middle_m.z;
    released(lab, way, |_, x| V3::new(0.0, 0.0, (z - x.z) * share as f32))
}

fn point(lab: &Lab, way: Way, share: f64) -> bool {
    released(lab, way, |_, x| (lab.middle_m - x) * share as f32)
}

/// Every sphere is moved by this share of the way to another sphere's position. The method must
/// survive three such shuffles.
fn scrambled(lab: &Lab, way: Way, share: f64) -> bool {
    let mut dice = Dice::new();
    let rest = &lab.body(way).rest_m;
    (0..3).all(|_| {
        let mut order: Vec<usize> = (0..rest.len()).collect();
        for i in (1..order.len()).rev() {
            let other = (0.5 * (dice.next() + 1.0) * i as f32) as usize;
            order.swap(i, other);
        }
        released(lab, way, |i, x| (rest[order[i]] - x) * share as f32)
    })
}

fn slivers(lab: &Lab, way: Way, times: f64) -> bool {
    let body = lab.with_slivers(way, times);
    let mut held = lab.fixed(way);
    held.resize(body.rest_m.len(), false);
    let back = Stand::new(&body, held).run(way, |rig| bent(lab, rig));
    back.unwrap_or(false)
}

/// A hook appears within one tick, at this share of the way from outside a duct to its middle. It
/// stays for 50 ticks and disappears.
fn duct(lab: &Lab, way: Way, share: f64) -> bool {
    let body = &lab.duct;
    let ends = |x: &V3| x.x < -0.017 || x.x > 0.017;
    let stand = Stand::new(body, body.rest_m.iter().map(ends).collect());
    let back = stand.run(way, |rig| {
        let z = 2.5e-3 * (1.0 - share as f32);
        rig.ball = Some((V3::new(0.0, 0.0, z), 1.5e-3));
        rig.ticks(50) && rig.comes_back()
    });
    back.unwrap_or(false)
}

/// Four neighbouring spheres are moved through each other, held until one second has passed, and
/// let go. (After 100 mm, five times their spacing, the tissue would stay in a knot in which no
/// tetrahedron is inverted.)
fn conflict(lab: &Lab, way: Way, mm: f64) -> bool {
    let stand = lab.stand(way);
    let back = stand.run(way, |rig| {
        let near = |i: &usize| (rig.body.rest_m[*i] - lab.middle_m).norm();
        let mut order: Vec<usize> = (0..stand.held.len()).collect();
        order.sort_by(|a, b| near(a).total_cmp(&near(b)));
        let chosen = &order[..4.min(order.len())];
        rig.hold(chosen, true);
        for i in 0..1000 {
            let far = mm as f32 * 1e-3 * (i as f32 / 300.0).min(1.0);
            for (k, &n) in chosen.iter().enumerate() {
                let out = (lab.middle_m - rig.body.rest_m[n]).normalize();
                rig.state.target_m[n] = if k % 2 == 0 { out * far } else { V3::y() * far };
            }
            if !rig.tick() {
                return false;
            }
        }
        rig.hold(chosen, false);
        rig.comes_back()
    });
    back.unwrap_or(false)
}

/// While the organ is stretched, a share of its tetrahedra and edges is removed. The rest may hang
/// loose, but it must not fly away.
fn cut(lab: &Lab, way: Way, share: f64) -> bool {
    let stand = lab.stand(way);
    let before = stand.run(way, |rig| {
        rig.place(|_, x| V3::x() * (0.15 * (x.x - lab.start_x_m)));
        rig.ticks(5);
        rig.state.clone()
    });
    let Some(before) = before else { return false };
    let mut dice = Dice::new();
    let mut body: Body = lab.body(way).clone();
    let mut stays = |_: usize| f64::from(dice.next() + 1.0) / 2.0 >= share;
    body.tets.retain(|_| stays(0));
    body.edges.retain(|_| stays(0));
    body.cells.retain(|_| stays(0));
    let stand = Stand::new(&body, stand.held);
    let sound = stand.run(way, |rig| {
        rig.state = before;
        rig.state.is_edited = true;
        rig.ticks(3000) && rig.farthest_m() < 0.3
    });
    sound.unwrap_or(false)
}

/// A grasp jumps about, a tool beats the organ, and the organ is let go suddenly.
fn violence(lab: &Lab, way: Way, minutes: f64) -> bool {
    let stand = lab.stand(way);
    let back = stand.run(way, |rig| {
        let mut dice = Dice::new();
        let grasp = end(&lab.moved(way));
        let (mut goal, mut at, mut is_held) = (V3::zeros(), V3::zeros(), false);
        for i in 0..(minutes * 60e3) as usize {
            if i % 150 == 0 {
                goal = dice.vector() * 0.08;
                if is_held != (dice.next() > -0.5) {
                    is_held = !is_held;
                    rig.hold(&grasp, is_held);
                    at = grasp.first().map_or(at, |&n| rig.state.u_m[n]);
                }
            }
            // The grasp moves at up to 3 m/s.
            let way_to = goal - at;
            at += way_to * (3e-3 / way_to.norm().max(3e-3));
            if is_held {
                for &n in &grasp {
                    rig.state.target_m[n] = at;
                }
            }
            let beat = (i as f32 * 0.02).sin() * 0.1;
            rig.ball = Some((lab.middle_m + V3::new(0.02, 0.0, beat), 0.015));
            if !rig.tick() {
                return false;
            }
        }
        rig.hold(&grasp, false);
        rig.comes_back()
    });
    back.unwrap_or(false)
}

fn noise(lab: &Lab, way: Way, mm: f64) -> bool {
    let stand = lab.stand(way);
    let back = stand.run(way, |rig| {
        let mut dice = Dice::new();
        let grasp = end(&lab.moved(way));
        rig.hold(&grasp, true);
        for _ in 0..1000 {
            for &n in &grasp {
                rig.state.target_m[n] = dice.vector() * (mm as f32 * 1e-3);
            }
            if !rig.tick() {
                return false;
            }
        }
        rig.hold(&grasp, false);
        rig.comes_back()
    });
    back.unwrap_or(false)
}
