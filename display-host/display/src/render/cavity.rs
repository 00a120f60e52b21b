//! Surroundings of the organs, so that nothing floats in the dark: the abdominal wall as a shell,
//! and below the organs a fatty apron, the omentum. Both are scaled to the scene.

use glam::{Vec2, Vec3};
use shared_mem::scene::{OrganKind, SceneFile, StonesRecord};

use super::noise::{hash, noise};
use crate::skinning::RestVertex;

/// Numbers of points of the shell, around and from pole to pole.
const SHELL: [usize; 2] = [120, 72];
/// The wall is pulled to the instrument's trocar so that the trocar passes through it. This is the
/// largest angle about the trocar's direction over which the wall is pulled, rad.
const DRAWN_RAD: f32 = 0.5;
/// Range of a trocar's distance from the cavity's middle, as a share of the distance to the wall.
/// Within the range, the wall is pulled to the trocar. A nearer or farther trocar passes through no
/// wall.
const DRAWN: core::ops::Range<f32> = 0.45..1.4;
/// Least distance from the cavity's middle to the wall behind the eye. It is given as a multiple of
/// the eye's distance from the middle.
const BEHIND_EYE: f32 = 1.06;
/// Number of points along a side of the apron.
const APRON: usize = 150;

/// Vertices and triangles that never move.
#[derive(Debug, Clone, Default)]
pub(super) struct Cavity {
    /// Vertices.
    pub(super) vertices: Vec<RestVertex>,
    /// Triangles, counter-clockwise as seen by the camera inside.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Position and size of the cavity.
struct Space {
    centre: Vec3,
    radii: Vec3,
    /// Depth of the bowl below the middle on which stones lie, m.
    bowl_depth: f32,
    right: Vec3,
    up: Vec3,
    back: Vec3,
    /// Height of the middle of the apron relative to the centre, m.
    floor: f32,
    /// Position of the instrument's trocar, in shares of the radii, and the angle over which the
    /// wall is pulled to it, rad. `None` if the wall is left as it is.
    trocar: Option<(Vec3, f32)>,
}

/// The cavity of a scene. A scene with its own abdominal wall needs no shell, and one with fat or
/// intestine needs no apron.
#[must_use]
pub(super) fn around(scene: &SceneFile) -> Cavity {
    let stones = scene.stones();
    let space = match stones {
        Some(stones) => Space::of(scene).over_bowl(stones),
        None => Space::of(scene),
    };
    let mut cavity = Cavity::default();
    let walls = OrganKind::AbdominalWall as u32;
    if scene.organs().iter().all(|organ| organ.kind != walls) {
        cavity.add_shell(&space, stones.is_some());
    }
    let below = [OrganKind::Fat as u32, OrganKind::Intestine as u32];
    if scene
        .organs()
        .iter()
        .all(|organ| !below.contains(&organ.kind))
    {
        cavity.add_apron(&space);
    }
    cavity
}

impl Space {
    fn of(scene: &SceneFile) -> Self {
        let room = scene.room();
        let up = (-Vec3::from(room.gravity_m_s2)).normalize_or(Vec3::Y);
        let camera = super::camera::matrix(&room.world_from_camera);
        let look = camera.transform_vector3(Vec3::NEG_Z);
        let back = (-(look - up * look.dot(up))).normalize_or(up.any_orthonormal_vector());
        let right = up.cross(back);
        let within = |p: Vec3| Vec3::new(p.dot(right), p.dot(up), p.dot(back));
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for sphere in scene.spheres() {
            let (at, r) = (within(Vec3::from(sphere.center_m)), sphere.radius_m);
            low = low.min(at - r);
            high = high.max(at + r);
        }
        let floor_at = low.y;
        let eye = within(camera.transform_point3(Vec3::ZERO));
        low = low.min(eye);
        high = high.max(eye);
        let centre = (low + high) / 2.0;
        // The cavity leaves room to look around, but the wall behind the organs stays within reach
        // of the light.
        let half = (high - low) / 2.0;
        let radii = half * 1.45 + Vec3::new(0.035, 0.02, 0.02);
        let share = |p: Vec3| (p - centre) / radii;
        let trocar = share(within(Vec3::from(room.instrument_port_m)));
        Self {
            trocar: drawn_to(trocar, share(eye)),
            centre: right * centre.x + up * centre.y + back * centre.z,
            radii,
            bowl_depth: radii.y,
            right,
            up,
            back,
            floor: (floor_at - centre.y - 0.004).max(-0.8 * radii.y),
        }
    }

    /// This cavity with its lower part in the bowl on which stones lie.
    fn over_bowl(self, stones: &StonesRecord) -> Self {
        let world_from_bowl = super::camera::matrix(&stones.world_from_bowl);
        let [right, depth, back] = stones.bowl_radii_m;
        Self {
            centre: world_from_bowl.w_axis.truncate(),
            right: world_from_bowl.x_axis.truncate(),
            up: world_from_bowl.y_axis.truncate(),
            back: world_from_bowl.z_axis.truncate(),
            radii: Vec3::new(right, self.radii.y, back),
            bowl_depth: depth,
            ..self
        }
    }

    /// Distance from the middle to the wall in the direction `way`, in shares of the radii. `usual`
    /// is the distance without a trocar.
    fn wall(&self, way: Vec3, usual: f32) -> f32 {
        let Some((trocar, angle)) = self.trocar else {
            return usual;
        };
        usual + (trocar.length() - usual) * nearness(way, trocar, angle)
    }

    fn world(&self, p: Vec3) -> Vec3 {
        self.centre + self.right * p.x + self.up * p.y + self.back * p.z
    }
}

/// The trocar, and the largest angle over which the wall can be pulled to it without passing in
/// front of the eye. `None` if there is no such angle, or if the trocar's distance is outside
/// [`DRAWN`]. Positions are in shares of the radii.
fn drawn_to(trocar: Vec3, eye: Vec3) -> Option<(Vec3, f32)> {
    let far = trocar.length();
    let leaves_eye = |angle: &f32| {
        let near = nearness(eye.normalize_or(-trocar), trocar, *angle);
        1.0 + (far - 1.0) * near > BEHIND_EYE * eye.length()
    };
    let angles = (0..6).map(|k| DRAWN_RAD * 0.75f32.powi(k));
    let angle = angles.into_iter().find(leaves_eye)?;
    DRAWN.contains(&far).then_some((trocar, angle))
}

/// Nearness of a direction to the direction of a trocar: 1 if they agree, 0.37 at `angle` between
/// them, and about 0 at twice the angle.
fn nearness(way: Vec3, trocar: Vec3, angle: f32) -> f32 {
    let off = way.angle_between(trocar) / angle;
    (-off * off).exp()
}

fn fixed(position: Vec3, look: OrganKind, ambient: f32) -> RestVertex {
    RestVertex {
        position: position.to_array(),
        look: look as u32,
        normal: [0.0; 3],
        ambient,
        spheres: [0; 4],
        weights: [0; 4],
    }
}

impl Cavity {
    /// Adds the shell. Stones lie on an even bowl (`rt_core::procedure::stones`), so with stones
    /// the lower part is that bowl, without folds.
    fn add_shell(&mut self, space: &Space, has_stones: bool) {
        let [around, down] = SHELL;
        let first = self.vertices.len() as u32;
        for k in 0..=down {
            let height = (k as f32 / down as f32 * core::f32::consts::PI).cos();
            let flat = (1.0 - height * height).max(0.0).sqrt();
            for i in 0..around {
                let turn = i as f32 / around as f32 * core::f32::consts::TAU;
                let d = Vec3::new(flat * turn.cos(), height, flat * turn.sin());
                // The wall has broad, soft folds.
                let folds = noise(d * 2.1 + 3.7).1 * 0.10 + noise(d * 5.3 + 1.1).1 * 0.035;
                let is_bowl = has_stones && d.y < 0.0;
                let (even, tall) = match is_bowl {
                    true => ((1.0 + 2.0 * d.y).max(0.0), space.bowl_depth),
                    false => (1.0, space.radii.y),
                };
                let radii = Vec3::new(space.radii.x, tall, space.radii.z);
                let at = space.world(d * radii * space.wall(d, 1.0 + folds * even));
                self.vertices
                    .push(fixed(at, OrganKind::AbdominalWall, 0.85));
            }
        }
        let n = around as u32;
        for k in 0..down as u32 {
            for i in 0..n {
                let j = (i + 1) % n;
                let [a, b] = [first + k * n + i, first + k * n + j];
                let [c, d] = [a + n, b + n];
                if k > 0 {
                    self.triangles.push([a, c, b]);
                }
                if k + 1 < down as u32 {
                    self.triangles.push([b, c, d]);
                }
            }
        }
        self.set_normals(first, |v| space.centre - v);
    }

    fn add_apron(&mut self, space: &Space) {
        let first = self.vertices.len() as u32;
        let n = APRON;
        for k in 0..n {
            for i in 0..n {
                let at = Vec2::new(i as f32, k as f32) / (n - 1) as f32 * 2.0 - 1.0;
                let flat = at * Vec2::new(space.radii.x, space.radii.z) * 1.05;
                let (lobes, crevice) = lobes(flat / 0.019);
                let (small, small_crevice) = lobes_fine(flat / 0.0065);
                let swell = noise(Vec3::new(flat.x, 0.3, flat.y) * 22.0).1 * 0.012;
                // The apron sags in the middle, below the organs, and climbs the walls.
                let bowl = 0.55 * space.radii.y * at.length_squared().min(1.4) * 0.6;
                let height = space.floor - 0.012 + bowl + swell + lobes * 0.0085 + small * 0.0016;
                let p = space.world(Vec3::new(flat.x, height, flat.y));
                let ambient = (0.35 + 0.65 * crevice) * (0.75 + 0.25 * small_crevice);
                self.vertices.push(fixed(p, OrganKind::Fat, ambient));
            }
        }
        let n = n as u32;
        for k in 0..n - 1 {
            for i in 0..n - 1 {
                let a = first + k * n + i;
                self.triangles.push([a, a + n, a + 1]);
                self.triangles.push([a + 1, a + n, a + n + 1]);
            }
        }
        self.set_normals(first, |_| space.up);
    }

    /// Sets area-weighted normals of the vertices from `first` on. Turns every triangle to face
    /// along `facing`.
    fn set_normals(&mut self, first: u32, facing: impl Fn(Vec3) -> Vec3) {
        let at = |vertices: &[RestVertex], v: u32| Vec3::from(vertices[v as usize].position);
        let mut sums = vec![Vec3::ZERO; self.vertices.len()];
        for t in self.triangles.iter_mut().filter(|t| t[0] >= first) {
            let [a, b, c] = t.map(|v| at(&self.vertices, v));
            let mut area = (b - a).cross(c - a);
            if area.dot(facing(a)) < 0.0 {
                t.swap(1, 2);
                area = -area;
            }
            for &v in t.iter() {
                sums[v as usize] += area;
            }
        }
        for (vertex, sum) in self.vertices.iter_mut().zip(sums).skip(first as usize) {
            let fallback = facing(Vec3::from(vertex.position)).normalize_or(Vec3::Y);
            vertex.normal = sum.normalize_or(fallback).to_array();
        }
    }
}

/// Height of rounded lobes at a place, and the openness there: 0 in a crevice, up to 1.
fn lobes(at: Vec2) -> (f32, f32) {
    let warp = noise(Vec3::new(at.x, at.y, 2.0) * 0.6).0.truncate() * 0.35;
    cells(at + warp, 11)
}

fn lobes_fine(at: Vec2) -> (f32, f32) {
    let warp = noise(Vec3::new(at.x, at.y, 5.0) * 0.7).0.truncate() * 0.3;
    cells(at + warp, 29)
}

/// Height and openness of smooth, packed bumps. The height is a soft maximum over domes at jittered
/// grid points.
fn cells(at: Vec2, seed: u32) -> (f32, f32) {
    let cell = at.floor();
    let (mut sum, mut most) = (0.0f32, 0.0f32);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let c = cell + Vec2::new(dx as f32, dy as f32);
            let [x, y] = [c.x as i32 as u32, c.y as i32 as u32];
            let jitter = Vec2::new(hash(x, y, seed), hash(x, y, seed + 1));
            let size = 0.75 + 0.5 * hash(x, y, seed + 2);
            let d2 = (c + jitter - at).length_squared() / (size * size);
            let dome = (1.0 - d2).max(0.0);
            sum += (8.0 * dome).exp();
            most = most.max(dome);
        }
    }
    let soft = ((sum / 9.0).ln() / 8.0).max(0.0);
    (soft.sqrt().min(1.2), (most * 1.6).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wall_comes_to_the_trocar_and_stays_behind_the_eye() {
        let space = |trocar: Vec3, eye: Vec3| Space {
            centre: Vec3::ZERO,
            radii: Vec3::ONE,
            bowl_depth: 1.0,
            right: Vec3::X,
            up: Vec3::Y,
            back: Vec3::Z,
            floor: 0.0,
            trocar: drawn_to(trocar, eye),
        };
        let eye = Vec3::new(0.0, 0.1, 0.9);
        for trocar in [Vec3::X * 0.7, Vec3::new(0.4, 0.2, 0.75), Vec3::Z * 1.2] {
            let space = space(trocar, eye);
            let way = trocar.normalize();
            assert!((space.wall(way, 1.02) - trocar.length()).abs() < 1e-5);
            assert!((space.wall(-way, 1.02) - 1.02).abs() < 1e-3);
            assert!(space.wall(eye.normalize(), 1.0) > eye.length(), "{trocar}");
        }
        // A trocar in the middle of the cavity passes through no wall.
        assert_eq!(space(Vec3::X * 0.2, eye).trocar, None);
    }
}
