//! Present places of the surfaces of a scene.

use shared_mem::message::SphereState;
use shared_mem::scene::{
    CONTACT_BINDINGS, CellRecord, NO_CELL, SceneFile, SphereRecord, VertexRecord, WEIGHT_SUM,
};

use super::canvas::{Canvas, Spot};
use super::vector::{Vec3, cross, mean, norm, sub};

/// Corners of a cell's faces, in the order of its neighbours.
const FACES: [[usize; 4]; 6] = [
    [0, 2, 6, 4],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 3, 7, 6],
    [0, 1, 3, 2],
    [4, 5, 7, 6],
];

/// Ranges of an organ in the scene's lists.
struct Organ {
    spheres: std::ops::Range<usize>,
    triangles: std::ops::Range<usize>,
    /// True for layered tissue, whose cells are drawn instead of its skin.
    is_layered: bool,
}

/// Skins and cells of a scene.
pub(super) struct Surface {
    organs: Vec<Organ>,
    rest: Vec<SphereRecord>,
    /// Movement of each sphere from rest, m.
    moved: Vec<Vec3>,
    vertices: Vec<VertexRecord>,
    triangles: Vec<[u32; 3]>,
    corners: Vec<VertexRecord>,
    /// Present places of the vertices and of the cells' corners, m.
    placed: [Vec<Vec3>; 2],
}

impl Surface {
    pub(super) fn of(scene: &SceneFile) -> Self {
        let range = |[first, count]: [u32; 2]| first as usize..(first + count) as usize;
        let owns_cells = |spheres: &std::ops::Range<usize>| {
            let mut cells = scene.cells().iter();
            cells.any(|cell| spheres.contains(&usize::from(cell.spheres[0])))
        };
        let organs = scene.organs().iter().map(|record| Organ {
            is_layered: owns_cells(&range(record.spheres)),
            spheres: range(record.spheres),
            triangles: range(record.triangles),
        });
        Self {
            organs: organs.collect(),
            rest: scene.spheres().to_vec(),
            moved: Vec::new(),
            vertices: scene.vertices().to_vec(),
            triangles: scene.triangles().to_vec(),
            corners: scene.cell_corners().to_vec(),
            placed: Default::default(),
        }
    }

    pub(super) fn sphere_count(&self) -> usize {
        self.rest.len()
    }

    /// Moves skins and cells with these spheres.
    pub(super) fn follow(&mut self, spheres: &[SphereState]) {
        self.moved.clear();
        let moved = spheres.iter().zip(&self.rest);
        self.moved
            .extend(moved.map(|(now, rest)| sub(now.center_m, rest.center_m)));
        for (records, placed) in [&self.vertices, &self.corners]
            .into_iter()
            .zip(&mut self.placed)
        {
            placed.clear();
            placed.extend(records.iter().map(|record| place(record, &self.moved)));
        }
    }

    /// Movement of a place that follows these spheres, m.
    pub(super) fn moved(
        &self,
        spheres: &[u16; CONTACT_BINDINGS],
        weights: &[f32; CONTACT_BINDINGS],
    ) -> Vec3 {
        let mut sum = [0.0; 3];
        for (sphere, weight) in spheres.iter().zip(weights) {
            if let Some(moved) = self.moved.get(usize::from(*sphere)) {
                sum = [0, 1, 2].map(|i| sum[i] + moved[i] * weight);
            }
        }
        sum
    }

    /// Share of an organ's surface that lies within the picture, hidden or not.
    pub(super) fn in_view(&self, organ: usize, canvas: &Canvas) -> f32 {
        let Some(organ) = self.organs.get(organ) else {
            return 0.0;
        };
        let own = self.triangles.get(organ.triangles.clone()).unwrap_or(&[]);
        let [vertices, _] = &self.placed;
        let (mut inside, mut all) = (0.0, 0.0);
        for triangle in own {
            let [Some(a), Some(b), Some(c)] = triangle.map(|it| vertices.get(it as usize)) else {
                continue;
            };
            let area = norm(cross(sub(*b, *a), sub(*c, *a)));
            all += area;
            inside += if canvas.has(mean(&[*a, *b, *c])) {
                area
            } else {
                0.0
            };
        }
        if all > 0.0 { inside / all } else { 0.0 }
    }

    /// Draws all skins, and the outer faces of the cells that are left.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas,
        cells: &[CellRecord],
        is_gone: &dyn Fn(usize) -> bool,
    ) {
        let [vertices, corners] = self.placed.each_ref().map(|placed| {
            placed
                .iter()
                .map(|it| canvas.project(*it))
                .collect::<Vec<Option<Spot>>>()
        });
        let spot = |list: &[Option<Spot>], index: usize| list.get(index).copied().flatten();
        for (number, organ) in (0u8..).zip(&self.organs) {
            if organ.is_layered {
                continue;
            }
            for triangle in self.triangles.get(organ.triangles.clone()).unwrap_or(&[]) {
                canvas.triangle(triangle.map(|it| spot(&vertices, it as usize)), number);
            }
        }
        let is_there = |cell: u16| cell != NO_CELL && !is_gone(cell.into());
        for (index, cell) in cells.iter().enumerate() {
            if is_gone(index) {
                continue;
            }
            let owns = |it: &Organ| it.spheres.contains(&usize::from(cell.spheres[0]));
            let owner = self.organs.iter().position(owns).unwrap_or(usize::MAX);
            let number = u8::try_from(owner).unwrap_or(u8::MAX - 2);
            for (face, neighbour) in FACES.iter().zip(cell.neighbours) {
                if is_there(neighbour) {
                    continue;
                }
                let [a, b, c, d] = face.map(|corner| {
                    let corner = cell.corners.get(corner);
                    corner.and_then(|it| spot(&corners, usize::from(*it)))
                });
                canvas.triangle([a, b, c], number);
                canvas.triangle([a, c, d], number);
            }
        }
    }
}

fn place(record: &VertexRecord, moved: &[Vec3]) -> Vec3 {
    let mut at = record.position_m;
    for (sphere, weight) in record.spheres.iter().zip(record.weights) {
        if let Some(moved) = moved.get(usize::from(*sphere)).filter(|_| weight > 0) {
            let share = f32::from(weight) / WEIGHT_SUM as f32;
            at = [0, 1, 2].map(|i| at[i] + moved[i] * share);
        }
    }
    at
}
