//! The methods that find contacts of the instruments. Each reports one depth per tick.

use nalgebra::Vector3;
use parry3d::glamx;
use parry3d::shape::{Capsule as Bar, TriMesh, TriMeshFlags};
use rt_core::tool::{Capsule, cylinder};
use scene_prepare::field::{Field, Grid, Nearest, Sign};
use scene_prepare::mesh::Mesh;

/// A point or direction in single precision.
pub(crate) type V3 = Vector3<f32>;

/// Depth of the deepest part in the organ, m; `None` without contact.
pub(crate) type Found = Option<f32>;

fn deeper(a: Found, depth_m: f32) -> Found {
    (depth_m > 0.0)
        .then(|| a.map_or(depth_m, |a| a.max(depth_m)))
        .or(a)
}

/// The paper's kernel on one thread: Algorithm 1 for every sphere and part.
pub(crate) fn spheres(spheres: &[(V3, f32)], parts: &[Capsule]) -> Found {
    let mut found = None;
    for (center_m, radius_m) in spheres {
        for part in parts {
            if cylinder::meets(center_m, *radius_m, &part.a_m, &part.b_m, part.radius_m) {
                found = deeper(found, cylinder::touch(center_m, *radius_m, part).depth_m);
            }
        }
    }
    found
}

/// Distance from a point to a part's axis, m.
fn from_axis_m(at_m: &V3, part: &Capsule) -> f32 {
    let axis = part.b_m - part.a_m;
    let along = (at_m - part.a_m).dot(&axis) / axis.norm_squared().max(1e-12);
    (at_m - part.a_m - axis * along.clamp(0.0, 1.0)).norm()
}

/// Tests every vertex of the mesh against every part, as in the paper's comparison.
pub(crate) fn vertices(vertices: &[V3], parts: &[Capsule]) -> Found {
    let mut found = None;
    for at_m in vertices {
        for part in parts {
            found = deeper(found, part.radius_m - from_axis_m(at_m, part));
        }
    }
    found
}

/// Skinning in which each vertex follows the four spheres that are nearest to it at rest.
pub(crate) struct Skinning(Vec<[(u32, f32); 4]>);

impl Skinning {
    /// Binds these vertices to these spheres; `None` if there are fewer than four spheres.
    pub(crate) fn new(vertices: &[V3], spheres: &[(V3, f32)]) -> Option<Self> {
        let near = |at_m: &V3| {
            let mut all: Vec<(u32, f32)> = (0..)
                .zip(spheres)
                .map(|(i, (center_m, _))| (i, (center_m - at_m).norm()))
                .collect();
            if all.len() > 4 {
                all.select_nth_unstable_by(3, |a, b| a.1.total_cmp(&b.1));
            }
            let nearest: [(u32, f32); 4] = all.get(..4)?.try_into().ok()?;
            let whole: f32 = nearest.iter().map(|(_, m)| m.max(1e-6).recip()).sum();
            Some(nearest.map(|(i, m)| (i, m.max(1e-6).recip() / whole)))
        };
        vertices.iter().map(near).collect::<Option<_>>().map(Self)
    }

    /// Positions of the vertices after the spheres have moved by `moves_m`.
    pub(crate) fn moved(&self, rest_m: &[V3], moves_m: &[V3], out_m: &mut Vec<V3>) {
        out_m.clear();
        out_m.extend(rest_m.iter().zip(&self.0).map(|(at_m, parts)| {
            let way = |&(i, weight): &(u32, f32)| moves_m[i as usize] * weight;
            parts.iter().map(way).fold(*at_m, |sum, part| sum + part)
        }));
    }
}

/// An octree over the faces (the paper's "adaptive octree"). A face is in every leaf that its box
/// meets.
pub(crate) struct Octree {
    nodes: Vec<Node>,
    faces: Vec<[V3; 3]>,
}

struct Node {
    low: V3,
    high: V3,
    /// Index of the first of eight children; 0 for a leaf.
    children: usize,
    inside: Vec<u32>,
}

/// A leaf with more faces than this is divided.
const LEAF_FACES: usize = 12;
/// Largest number of divisions from the root to a leaf.
const LEVELS: u32 = 9;

impl Octree {
    /// Builds the tree over these faces.
    pub(crate) fn new(faces: Vec<[V3; 3]>) -> Self {
        let corners = || faces.iter().flatten();
        let low = corners().fold(V3::repeat(f32::MAX), |m, p| m.inf(p));
        let high = corners().fold(V3::repeat(f32::MIN), |m, p| m.sup(p));
        let root = Node {
            low,
            high,
            children: 0,
            inside: (0..faces.len() as u32).collect(),
        };
        let mut tree = Self {
            nodes: vec![root],
            faces,
        };
        tree.cut(0, LEVELS);
        tree
    }

    fn cut(&mut self, at: usize, levels: u32) {
        if levels == 0 || self.nodes[at].inside.len() <= LEAF_FACES {
            return;
        }
        let inside = std::mem::take(&mut self.nodes[at].inside);
        let (low, high) = (self.nodes[at].low, self.nodes[at].high);
        let first = self.nodes.len();
        self.nodes[at].children = first;
        let half = (high - low) / 2.0;
        for i in 0..8 {
            let pick = |axis: usize| if i >> axis & 1 == 1 { half[axis] } else { 0.0 };
            let from = low + V3::new(pick(0), pick(1), pick(2));
            let to = from + half;
            let meets = |face: &&u32| {
                let t = self.faces[**face as usize];
                let min = t[0].inf(&t[1]).inf(&t[2]);
                let max = t[0].sup(&t[1]).sup(&t[2]);
                (0..3).all(|k| min[k] <= to[k] && max[k] >= from[k])
            };
            let inside = inside.iter().filter(meets).copied().collect();
            self.nodes.push(Node {
                low: from,
                high: to,
                children: 0,
                inside,
            });
        }
        for i in 0..8 {
            self.cut(first + i, levels - 1);
        }
    }

    /// Finds the deepest contact among the faces near each part.
    pub(crate) fn find(&self, parts: &[Capsule]) -> Found {
        let mut found = None;
        let mut open = Vec::new();
        for part in parts {
            let reach = V3::repeat(part.radius_m);
            let (low, high) = (
                part.a_m.inf(&part.b_m) - reach,
                part.a_m.sup(&part.b_m) + reach,
            );
            open.push(0);
            while let Some(at) = open.pop() {
                let node = &self.nodes[at];
                if (0..3).any(|k| node.low[k] > high[k] || node.high[k] < low[k]) {
                    continue;
                }
                // A thin slanted part fills little of its box, so a second test uses the node's
                // bounding sphere.
                let middle = (node.low + node.high) / 2.0;
                let around = (node.high - node.low).norm() / 2.0;
                if from_axis_m(&middle, part) > around + part.radius_m {
                    continue;
                }
                if node.children > 0 {
                    open.extend(node.children..node.children + 8);
                }
                for &face in &node.inside {
                    let gap_m = from_face_m(&self.faces[face as usize], part);
                    found = deeper(found, part.radius_m - gap_m);
                }
            }
        }
        found
    }
}

/// Distance from a triangle to a part's axis, m.
fn from_face_m(t: &[V3; 3], part: &Capsule) -> f32 {
    let normal = (t[1] - t[0]).cross(&(t[2] - t[0]));
    let inside =
        |p: &V3| (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(&(p - t[k])).dot(&normal) >= 0.0);
    let squared = normal.norm_squared();
    let mut least = f32::MAX;
    if squared > 0.0 {
        let height = |p: &V3| (p - t[0]).dot(&normal) / squared.sqrt();
        let (a, b) = (height(&part.a_m), height(&part.b_m));
        for (end, h) in [(&part.a_m, a), (&part.b_m, b)] {
            if inside(end) {
                least = least.min(h.abs());
            }
        }
        if a * b < 0.0 && inside(&(part.a_m + (part.b_m - part.a_m) * (a / (a - b)))) {
            return 0.0;
        }
    }
    for k in 0..3 {
        least = least.min(between_m([&t[k], &t[(k + 1) % 3]], [&part.a_m, &part.b_m]));
    }
    least
}

/// Distance between two line segments, m (Ericson, "Real-Time Collision Detection", 5.1.9).
fn between_m([p1, q1]: [&V3; 2], [p2, q2]: [&V3; 2]) -> f32 {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f) = (d1.norm_squared(), d2.norm_squared(), d2.dot(&r));
    let (b, c) = (d1.dot(&d2), d1.dot(&r));
    let flat = a * e - b * b;
    let mut s = if flat > 1e-12 * a * e {
        ((b * f - c * e) / flat).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut t = (b * s + f) / e.max(1e-20);
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((b * t - c) / a.max(1e-20)).clamp(0.0, 1.0);
    }
    (p1 + d1 * s - p2 - d2 * t).norm()
}

fn single(p: &V3) -> glamx::Vec3 {
    glamx::Vec3::new(p.x, p.y, p.z)
}

/// parry's bounding volume hierarchy over the faces.
pub(crate) struct Hierarchy(TriMesh);

impl Hierarchy {
    /// Builds the hierarchy over all faces; `None` without faces.
    pub(crate) fn new(vertices: &[V3], triangles: &[[u32; 3]]) -> Option<Self> {
        let vertices = vertices.iter().map(single).collect();
        let flags = TriMeshFlags::DEFORMABLE;
        let mesh = TriMesh::with_flags(vertices, triangles.to_vec(), flags);
        mesh.ok().map(Self)
    }

    /// Moves the vertices to these places. Boxes are refitted, but the tree is not built again.
    pub(crate) fn follow(&mut self, vertices: &[V3]) {
        self.0.update_vertices(|own| {
            for (own, now) in own.iter_mut().zip(vertices) {
                *own = single(now);
            }
        });
    }

    /// Finds the deepest contact. The depth of a part is its radius less parry's distance between
    /// the mesh and the part's axis.
    pub(crate) fn find(&self, parts: &[Capsule]) -> Found {
        let mut found = None;
        let here = parry3d::math::Pose::identity();
        for part in parts {
            let bar = Bar::new(single(&part.a_m), single(&part.b_m), 0.0).segment;
            let near = parry3d::query::closest_points(&here, &self.0, &here, &bar, part.radius_m);
            let depth_m = match near {
                Ok(parry3d::query::ClosestPoints::Intersecting) => part.radius_m,
                Ok(parry3d::query::ClosestPoints::WithinMargin(a, b)) => {
                    part.radius_m - (a - b).length()
                }
                _ => continue,
            };
            found = deeper(found, depth_m);
        }
        found
    }
}

/// The true contact. It is computed from the distance to the mesh (negative inside) at points 0.25
/// mm apart on each part's axis.
pub(crate) struct Exact<'a> {
    nearest: Nearest<'a>,
    inside: Field,
}

const STEP_M: f32 = 0.000_25;

impl<'a> Exact<'a> {
    /// Prepares a closed mesh; `None` if it has no faces.
    pub(crate) fn new(mesh: &'a Mesh) -> Option<Self> {
        let bounds = mesh.bounds();
        let cell_m = (bounds[1] - bounds[0]).max() / 120.0;
        Some(Self {
            nearest: Nearest::new(mesh)?,
            inside: Field::new(mesh, Grid::around(bounds, cell_m, 2), Sign::Closed),
        })
    }

    /// Finds the true contact.
    pub(crate) fn find(&self, parts: &[Capsule]) -> Found {
        let mut found = None;
        for part in parts {
            let length_m = (part.b_m - part.a_m).norm();
            let places = (length_m / STEP_M).ceil().max(1.0);
            let mut i = 0.0;
            while i <= places {
                let at: Vector3<f64> = (part.a_m + (part.b_m - part.a_m) * (i / places)).cast();
                let signed = self.inside.at(&at);
                // The field's error is less than a cell, so there is certainly no contact within
                // this distance.
                let skip_m = signed as f32 - 2.0 * self.inside.grid.cell_m as f32 - part.radius_m;
                if skip_m > 0.0 {
                    i += (skip_m / STEP_M).max(1.0).floor();
                    continue;
                }
                let gap_m = self.nearest.distance(&at) as f32;
                found = deeper(
                    found,
                    part.radius_m - if signed < 0.0 { -gap_m } else { gap_m },
                );
                i += 1.0;
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_core::tool::Role;

    #[test]
    fn the_octree_finds_what_every_face_says_and_parry_nearly() {
        let mesh =
            scene_prepare::shape::Shape::from(scene_prepare::shape::Form::Gallbladder).mesh();
        let points: Vec<V3> = mesh.vertices.iter().map(|p| p.cast()).collect();
        let corners = |t: &[u32; 3]| t.map(|i| points[i as usize]);
        let faces: Vec<_> = mesh.triangles.iter().map(corners).collect();
        let tree = Octree::new(faces.clone());
        let parry = Hierarchy::new(&points, &mesh.triangles).expect("faces");
        let motion = super::super::motion::motion(&mesh, 60).expect("a mesh");
        let (mut touched, mut agreed) = (0, 0);
        for parts in &motion {
            let every = |part: &Capsule| {
                let gaps = faces.iter().map(|t| from_face_m(t, part));
                part.radius_m - gaps.fold(f32::MAX, f32::min)
            };
            let truth = parts.iter().map(every).fold(f32::MIN, f32::max);
            let truth = (truth > 0.0).then_some(truth);
            touched += usize::from(truth.is_some());
            // parry reports an intersection where the gap is a quarter of a millimetre.
            agreed += usize::from(parry.find(parts).is_some() == truth.is_some());
            let found = tree.find(parts);
            let close = match (truth, found) {
                (Some(a), Some(b)) => (a - b).abs() < 2e-5,
                (None, None) => true,
                (Some(a), None) | (None, Some(a)) => a < 2e-5,
            };
            assert!(close, "{truth:?} {found:?}");
        }
        assert!(agreed >= 54, "{agreed} of 60");
        assert!((10..60).contains(&touched), "{touched}");
    }

    /// A mesh that follows its spheres moves as they do, and the refitted tree over it finds the
    /// same contacts as a new one.
    #[test]
    fn mesh_and_tree_follow_the_spheres() {
        let mesh = scene_prepare::shape::Shape::from(scene_prepare::shape::Form::Stomach).mesh();
        let rest: Vec<V3> = mesh.vertices.iter().map(|p| p.cast()).collect();
        let spheres: Vec<(V3, f32)> = rest.iter().step_by(40).map(|p| (p * 0.8, 0.01)).collect();
        let skinning = Skinning::new(&rest, &spheres).expect("spheres");
        let mut moved = Vec::new();
        let shift = V3::new(0.01, -0.02, 0.005);
        skinning.moved(&rest, &vec![shift; spheres.len()], &mut moved);
        let off = rest.iter().zip(&moved).map(|(a, b)| (b - a - shift).norm());
        assert!(off.fold(0.0, f32::max) < 1e-6);
        assert!(Skinning::new(&rest, &spheres[..3]).is_none());
        let squeeze = |(c, _): &(V3, f32)| V3::new(0.0, 0.0, -0.3 * c.z);
        let moves: Vec<V3> = spheres.iter().map(squeeze).collect();
        skinning.moved(&rest, &moves, &mut moved);
        let mut refitted = Hierarchy::new(&rest, &mesh.triangles).expect("faces");
        refitted.follow(&moved);
        let anew = Hierarchy::new(&moved, &mesh.triangles).expect("faces");
        let motion = super::super::motion::motion(&mesh, 100).expect("a mesh");
        let mut touched = 0;
        for parts in &motion {
            let (a, b) = (refitted.find(parts), anew.find(parts));
            assert!(
                (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-6,
                "{a:?} {b:?}"
            );
            touched += usize::from(b.is_some());
        }
        assert!((5..100).contains(&touched), "{touched}");
    }

    #[test]
    fn the_exact_test_knows_inside_from_outside() {
        let mesh =
            scene_prepare::shape::Shape::from(scene_prepare::shape::Form::Gallbladder).mesh();
        let exact = Exact::new(&mesh).expect("faces");
        let nearest = Nearest::new(&mesh).expect("faces");
        let [min, max] = mesh.bounds();
        let far = max + (max - min);
        let site = nearest.point(&far);
        let out = (far - site).normalize();
        for (height, depth) in [(0.004, None), (0.001, Some(0.001)), (-0.002, Some(0.004))] {
            let tip = site + out * height;
            let part = Capsule {
                a_m: (tip + out * 0.05).cast(),
                b_m: tip.cast(),
                radius_m: 0.002,
                role: Role::Tip,
            };
            match (exact.find(&[part]), depth) {
                (None, None) => {}
                (Some(found), Some(depth)) => assert!((found - depth).abs() < 3e-4_f32, "{found}"),
                other => panic!("{other:?} at {height}"),
            }
        }
    }
}
