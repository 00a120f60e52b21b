//! The instruments: shapes, and angles of the jaws.
//!
//! The frame of every instrument is that of [`ToolFrame::world_from_instrument`]: origin at the jaw
//! joint, −z along the shaft towards the tip, the upper jaw at +y. Jaws are modelled closed and
//! turn about x. The biting face of the upper jaw points towards −y.

use glam::{Mat4, Quat, Vec2, Vec3};
use shared_mem::message::ToolFrame;
use shared_mem::words::CapsuleRole;

use super::look::{BLADE, CERAMIC, INSULATION, STEEL};
use super::solid::{Finish, RigidVertex, Solid, circle, curve};

/// The shaft and everything else that does not turn with the jaws.
const BODY: u32 = 0;
/// Upper jaw or blade.
const UPPER: u32 = 1;
/// Lower jaw or blade.
const LOWER: u32 = 2;
/// The trocar, which stays at its port.
const TROCAR: u32 = 3;
/// Distance from the joint to the end of the shaft outside the body, m.
const SHAFT_M: f32 = 0.34;
/// Opening of each jaw at `jaw` = 1 when the controller reports no jaws, rad.
const OPEN_RAD: f32 = 0.40;
/// Distance from the axis at which the capsule of a closed jaw ends, m. The capsules of the two
/// jaws lie side by side, so neither ends on the axis.
const CLOSED_OFF_M: f32 = 0.001;
/// Largest angle between two faces across which the surface looks smooth, rad.
const CREASE_RAD: f32 = 0.62;

/// An instrument's geometry.
#[derive(Debug, Clone, Default)]
pub(super) struct Model {
    /// Vertices.
    pub(super) vertices: Vec<RigidVertex>,
    /// Triangles.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// All instruments, in the order of [`ToolFrame::instrument`], then the trocar and the clips.
#[must_use]
pub(super) fn all() -> [Model; 7] {
    [
        grasper(),
        hook(),
        scissors(),
        clip_applier(),
        irrigator(),
        trocar(),
        super::clips::all(),
    ]
    .map(|solid| {
        let (vertices, triangles) = solid.finish(CREASE_RAD);
        Model {
            vertices,
            triangles,
        }
    })
}

/// Poses of the parts: body, upper jaw, lower jaw, and the trocar at `port`, which turns with the
/// shaft.
#[must_use]
pub(super) fn parts(tools: &ToolFrame, port: Vec3) -> [Mat4; 4] {
    let body = super::camera::matrix(&tools.world_from_instrument);
    let jaws = jaw_angles(tools, &body);
    let turned = |angle: f32| body * Mat4::from_quat(Quat::from_rotation_x(angle));
    let (_, turn, _) = body.to_scale_rotation_translation();
    let trocar = Mat4::from_rotation_translation(turn, port);
    [body, turned(jaws[0]), turned(-jaws[1]), trocar]
}

/// Opening of the upper and the lower jaw, rad. It comes from the controller's capsules, so that
/// the picture shows the jaws that touch the tissue.
fn jaw_angles(tools: &ToolFrame, body: &Mat4) -> [f32; 2] {
    let into_body = body.inverse();
    let angle = |role| {
        let capsules = tools.capsules().unwrap_or(&[]);
        let capsule = capsules.iter().find(|c| c.is(role))?;
        let along = Vec3::from(capsule.b_m) - Vec3::from(capsule.a_m);
        let d = into_body.transform_vector3(along);
        let off = (d.y.abs() - CLOSED_OFF_M).max(0.0);
        Some(off.atan2(d.z.abs()))
    };
    let shown = tools.jaw.clamp(0.0, 1.0) * OPEN_RAD;
    [CapsuleRole::UpperJaw, CapsuleRole::LowerJaw]
        .map(|role| angle(role).unwrap_or(shown).clamp(0.0, 1.2))
}

fn steel(part: u32) -> Finish {
    Finish { look: STEEL, part }
}

fn blade(part: u32) -> Finish {
    Finish { look: BLADE, part }
}

/// Adds a steel sleeve with a groove and then the insulated shaft, from `z_m` on.
fn shaft(solid: &mut Solid, z_m: f32, radius_m: f32) {
    let r = radius_m;
    let from = Vec3::Z * z_m;
    let sleeve = [
        [0.0, 0.80 * r],
        [0.0008, 0.94 * r],
        [0.0062, 0.94 * r],
        [0.0064, 0.86 * r],
        [0.0070, 0.86 * r],
        [0.0072, 0.94 * r],
        [0.0090, 0.94 * r],
    ];
    solid.turned(from, Vec3::Z, &sleeve, 40, steel(BODY));
    let skin = [
        [0.0086, 0.90 * r],
        [0.0088, 0.98 * r],
        [0.0094, r],
        [0.06, r],
        [0.12, r],
        [SHAFT_M - z_m, r],
    ];
    let insulation = Finish {
        look: INSULATION,
        part: BODY,
    };
    solid.turned(from, Vec3::Z, &skin, 40, insulation);
}

/// The fork that holds the jaws, with its pin.
fn fork(solid: &mut Solid, half_width_m: f32) {
    let w = half_width_m;
    for side in [-1.0, 1.0] {
        // The outline is a cheek of the fork, rounded towards the tip.
        let outline: Vec<Vec2> = {
            let mut points = vec![Vec2::new(0.0062, -0.0019), Vec2::new(0.0062, 0.0019)];
            points.extend((0..=12).map(|i| {
                let turn = core::f32::consts::FRAC_PI_2 + i as f32 / 12.0 * core::f32::consts::PI;
                Vec2::new(0.0022 * turn.cos(), 0.0020 * turn.sin())
            }));
            points
        };
        let x = [side * (w - 0.0007), side * w];
        let mut rings: Vec<Vec<Vec3>> = x
            .iter()
            .map(|&x| outline.iter().map(|p| Vec3::new(x, p.y, p.x)).collect())
            .collect();
        if side > 0.0 {
            rings.iter_mut().for_each(|ring| ring.reverse());
        }
        rings.iter_mut().for_each(|ring| ring.reverse());
        solid.loft(&rings, steel(BODY));
    }
    let pin = [
        [0.0, 0.0007],
        [0.0002, 0.0010],
        [2.0 * w + 0.0004, 0.0010],
        [2.0 * w + 0.0006, 0.0007],
    ];
    let from = Vec3::new(-w - 0.0003, 0.0, 0.0);
    solid.turned(from, Vec3::X, &pin, 20, blade(BODY));
    let neck = [
        [0.0042, 0.0014],
        [0.0046, 0.96 * w],
        [0.0068, 1.0 * w],
        [0.0092, 1.0 * w],
    ];
    solid.turned(Vec3::ZERO, Vec3::Z, &neck, 32, steel(BODY));
}

/// Adds a jaw along −z. `outline` takes a ring's index and its place along the jaw, 0 to 1. It
/// returns three lengths, m: the half width, the height of the back, and the height of the biting
/// face. `bend` returns the lift at a place, m. The upper jaw lies at +y; the lower one is turned
/// by 180° about z.
fn jaw(
    solid: &mut Solid,
    part: u32,
    length_m: f32,
    rings: usize,
    outline: impl Fn(usize, f32) -> [f32; 3],
    bend: impl Fn(f32) -> f32,
) {
    let mirror = if part == LOWER { -1.0 } else { 1.0 };
    let loops: Vec<Vec<Vec3>> = (0..=rings)
        .map(|k| {
            let t = k as f32 / rings as f32;
            let [half_width, back, bite] = outline(k, t);
            let z = 0.002 - t * (length_m + 0.002);
            let lift = bend(t);
            let across: Vec<Vec2> = (0..=14)
                .map(|i| {
                    let turn = i as f32 / 14.0 * core::f32::consts::PI;
                    // A flute runs along the back.
                    let flute = 1.0 - 0.22 * (-(turn.cos() / 0.38).powi(2)).exp() * (1.0 - t);
                    Vec2::new(turn.cos() * half_width, 0.0003 + turn.sin() * back * flute)
                })
                .chain([
                    Vec2::new(-half_width, 0.0001),
                    Vec2::new(-half_width * 0.82, bite),
                    Vec2::new(0.0, bite),
                    Vec2::new(half_width * 0.82, bite),
                    Vec2::new(half_width, 0.0001),
                ])
                .collect();
            across
                .iter()
                .rev()
                .map(|p| Vec3::new(p.x * mirror, (p.y + lift) * mirror, z))
                .collect()
        })
        .collect();
    solid.loft(&loops, steel(part));
}

/// Factor that rounds a jaw's end. It is 1 up to the place `from`, and falls to 0.3 at the tip.
fn tip(t: f32, from: f32) -> f32 {
    let s = ((t - from) / (1.0 - from)).clamp(0.0, 1.0);
    (1.0 - 0.91 * s * s).max(0.0).sqrt()
}

/// An atraumatic grasper of 5 mm: two toothed, fluted jaws in a fork.
fn grasper() -> Solid {
    let mut solid = Solid::default();
    shaft(&mut solid, 0.0088, 0.0025);
    fork(&mut solid, 0.0022);
    for part in [UPPER, LOWER] {
        jaw(
            &mut solid,
            part,
            0.020,
            76,
            |k, t| {
                let narrow = if t < 0.12 {
                    0.55 + 0.45 * (t / 0.12)
                } else {
                    1.0
                };
                let half_width = 0.00205 * narrow * (1.0 - 0.22 * t) * tip(t, 0.80);
                let back = (0.0021 - 0.0009 * t) * tip(t, 0.76);
                let toothed = t > 0.16 && t < 0.95 && k % 4 >= 2;
                let bite = if toothed { 0.00034 } else { 0.00002 };
                [half_width, back, bite]
            },
            |_| 0.0,
        );
    }
    solid
}

/// A monopolar L-hook: ceramic collar, steel wire, flattened heel.
fn hook() -> Solid {
    let mut solid = Solid::default();
    shaft(&mut solid, 0.0060, 0.0025);
    let collar = [
        [0.0, 0.0010],
        [0.0004, 0.0016],
        [0.0012, 0.0019],
        [0.0064, 0.0021],
        [0.0068, 0.0021],
    ];
    let ceramic = Finish {
        look: CERAMIC,
        part: BODY,
    };
    solid.turned(Vec3::ZERO, Vec3::Z, &collar, 32, ceramic);
    let mm = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * 0.001;
    let path = curve(
        &[
            mm(0.0, 0.0, 2.0),
            mm(0.0, 0.0, -5.0),
            mm(0.0, 0.1, -9.4),
            mm(0.0, -0.2, -11.2),
            mm(0.0, -1.2, -12.2),
            mm(0.0, -2.8, -12.3),
            mm(0.0, -4.2, -11.9),
        ],
        8,
    );
    solid.swept(
        &path,
        |t| {
            let flat = ((t - 0.62) / 0.38).clamp(0.0, 1.0);
            let r = 0.00062 * (1.0 - 0.25 * flat);
            circle(14)
                .map(|c| Vec2::new(c.x * r * (1.0 - 0.35 * flat), c.y * r * (1.0 + 0.45 * flat)))
                .collect()
        },
        blade(BODY),
    );
    solid
}

/// Curved scissors: two thin blades that taper.
fn scissors() -> Solid {
    let mut solid = Solid::default();
    shaft(&mut solid, 0.0088, 0.0025);
    fork(&mut solid, 0.0022);
    for part in [UPPER, LOWER] {
        let mirror = if part == LOWER { -1.0 } else { 1.0 };
        let rings: Vec<Vec<Vec3>> = (0..=40)
            .map(|k| {
                let t = k as f32 / 40.0;
                let z = 0.002 - t * 0.018;
                let curve_x = 0.0022 * t * t;
                let height = 0.0019 * (1.0 - 0.72 * t * t) * tip(t, 0.85);
                // The blades pass each other, each on its own side of the middle.
                let (inner, outer) = (0.00004 * mirror, 0.0010 * mirror * (1.0 - 0.5 * t));
                let corners = [
                    Vec2::new(inner, -0.0004),
                    Vec2::new(outer * 0.7, -0.0001),
                    Vec2::new(outer, height * 0.45),
                    Vec2::new(outer * 0.6, height),
                    Vec2::new(inner, height * 0.9),
                ];
                let ring = corners.map(|p| Vec3::new(p.x + curve_x, p.y * mirror, z));
                ring.iter().rev().copied().collect()
            })
            .collect();
        solid.loft(&rings, blade(part));
    }
    solid
}

/// A clip applier of 10 mm: two bent fingers with a groove for the clip.
fn clip_applier() -> Solid {
    let mut solid = Solid::default();
    shaft(&mut solid, 0.0120, 0.0050);
    let nose = [
        [0.0, 0.0030],
        [0.0005, 0.0036],
        [0.0080, 0.0042],
        [0.0125, 0.0047],
    ];
    solid.turned(Vec3::ZERO, Vec3::Z, &nose, 40, steel(BODY));
    for part in [UPPER, LOWER] {
        jaw(
            &mut solid,
            part,
            0.014,
            60,
            |_, t| {
                let half_width = 0.0022 * (1.0 - 0.15 * t) * tip(t, 0.82);
                let back = (0.0019 - 0.0006 * t) * tip(t, 0.80);
                [
                    half_width,
                    back,
                    if t > 0.35 && t < 0.96 { 0.0005 } else { 0.0 },
                ]
            },
            |t| 0.0016 * (1.0 - t) * t * 4.0 * 0.6,
        );
    }
    for part in [UPPER, LOWER] {
        clip_leg(&mut solid, part);
    }
    solid
}

/// Half of a titanium clip in a jaw's groove; the halves meet at the bend.
fn clip_leg(solid: &mut Solid, part: u32) {
    let side = if part == LOWER { -1.0 } else { 1.0 };
    let mm = |y: f32, z: f32| Vec3::new(0.0, y * side, z) * 0.001;
    let path = curve(
        &[
            mm(0.15, -4.4),
            mm(0.9, -5.2),
            mm(1.15, -7.0),
            mm(0.9, -10.0),
            mm(0.45, -13.2),
        ],
        6,
    );
    let section = |_| circle(10).map(|c| c * 0.000_42).collect();
    solid.swept(&path, section, blade(part));
}

/// An irrigator: a steel tube of 5 mm with holes around its end, on an insulated shaft.
fn irrigator() -> Solid {
    let mut solid = Solid::default();
    shaft(&mut solid, 0.004, 0.0025);
    let tube = [
        [0.0, 0.0017],
        [0.0002, 0.0022],
        [0.0007, 0.0025],
        [0.0160, 0.0025],
        [0.0165, 0.0022],
    ];
    solid.turned(Vec3::NEG_Z * 0.012, Vec3::Z, &tube, 40, steel(BODY));
    // The mouth is dark, and so are the holes.
    let dark = Finish {
        look: INSULATION,
        part: BODY,
    };
    let mouth = [[0.0, 0.0], [0.0002, 0.0016], [0.0004, 0.0016]];
    solid.turned(Vec3::NEG_Z * 0.012_1, Vec3::Z, &mouth, 24, dark);
    for row in 0..2u8 {
        for hole in 0..4u8 {
            let turn = (f32::from(hole) + 0.5 * f32::from(row)) * core::f32::consts::FRAC_PI_2;
            let out = Vec3::new(turn.cos(), turn.sin(), 0.0);
            let at = out * 0.0021 + Vec3::NEG_Z * (0.0085 - 0.0035 * f32::from(row));
            let disc = [[0.0, 0.0006], [0.000_42, 0.0006], [0.000_45, 0.0]];
            solid.turned(at, out, &disc, 12, dark);
        }
    }
    solid
}

/// A trocar's cannula, 13 mm thick, from 25 mm inside the port to 30 mm outside. It is ribbed, and
/// widens slightly from its inner end.
fn trocar() -> Solid {
    let mut solid = Solid::default();
    let plastic = Finish {
        look: CERAMIC,
        part: TROCAR,
    };
    let mut profile = vec![
        [0.0, 0.0056],
        [0.0003, 0.0061],
        [0.0040, 0.0062],
        [0.0060, 0.0064],
    ];
    for rib in 0..14 {
        let from = 0.007 + rib as f32 * 0.0028;
        profile.extend([
            [from, 0.0063],
            [from + 0.0019, 0.0070],
            [from + 0.0023, 0.0063],
        ]);
    }
    profile.push([0.055, 0.0063]);
    solid.turned(Vec3::NEG_Z * 0.025, Vec3::Z, &profile, 40, plastic);
    solid
}
