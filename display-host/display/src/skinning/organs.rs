//! The organs' surfaces as they are drawn, for programs that pass them on.

use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::{OrganRecord, SceneFile, str_from_name};

use super::motion::{Follow, Motions};
use super::parts::Pieces;
use super::{SkinMesh, SkinnedVertex, Touch};

/// Surfaces of a scene's organs at one moment.
#[derive(Debug, Clone)]
pub struct OrganSurfaces {
    organs: Vec<OrganRecord>,
    mesh: SkinMesh,
    motions: Motions,
    pieces: Pieces,
    now: Vec<SkinnedVertex>,
}

/// Surface of one organ, world frame.
#[derive(Debug, Clone)]
pub struct OrganSurface<'a> {
    /// Name of the organ in the scene.
    pub name: &'a str,
    /// Number of its [`shared_mem::scene::OrganKind`].
    pub kind: u32,
    /// Vertices.
    pub vertices: &'a [SkinnedVertex],
    /// Triangles of `vertices`, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl OrganSurface<'_> {
    /// Places of the vertices, m.
    pub fn points_m(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        let point = |vertex: &SkinnedVertex| {
            let [x, y, z, _] = vertex.position;
            [x, y, z]
        };
        self.vertices.iter().map(point)
    }
}

impl OrganSurfaces {
    /// Surfaces at rest.
    #[must_use]
    pub fn of(scene: &SceneFile) -> Self {
        let mesh = SkinMesh::from_scene(scene);
        Self {
            organs: scene.organs().to_vec(),
            motions: Motions::new(scene, Follow::Deform),
            pieces: Pieces::of(scene, &mesh),
            now: mesh.at_rest(),
            mesh,
        }
    }

    /// Brings the surfaces to the moment of these frames, which must be of the same scene.
    pub fn follow(&mut self, state: &StateFrame, tools: &ToolFrame) {
        let spheres = state.spheres().unwrap_or(&[]);
        let parted = state.parted().into_iter().flatten();
        if self.pieces.set(parted, &mut self.mesh) {
            let severed: Vec<[u32; 2]> = self.pieces.severed().collect();
            self.motions.sever(&severed);
        }
        self.motions.update(spheres);
        let motions = self.motions.now();
        let touch = Touch::of(&self.mesh, &self.organs, spheres, motions, tools);
        self.mesh.skin(motions, &touch, &mut self.now);
    }

    /// Number of organs.
    #[must_use]
    pub fn count(&self) -> usize {
        self.organs.len()
    }

    /// Surface of an organ, by its number in the scene.
    #[must_use]
    pub fn get(&self, organ: usize) -> Option<OrganSurface<'_>> {
        let organ = self.organs.get(organ)?;
        let [vertices, triangles] = [organ.vertices, organ.triangles]
            .map(|[first, count]| first as usize..(first + count) as usize);
        let first = vertices.start as u32;
        // Triangles without area are not drawn, because the skin is hidden there.
        let drawn = self.mesh.triangles.get(triangles)?.iter();
        let drawn = drawn.filter(|[a, b, c]| a != b && b != c);
        Some(OrganSurface {
            name: str_from_name(&organ.name).unwrap_or_default(),
            kind: organ.kind,
            vertices: self.now.get(vertices)?,
            triangles: drawn.map(|it| it.map(|vertex| vertex - first)).collect(),
        })
    }
}
