//! `calot export --surfaces`: the organs as the display draws them, at a stated rate.

use std::path::{Path, PathBuf};

use bytemuck::Zeroable as _;
use display_host::skinning::motion::{Follow, Motions};
use display_host::skinning::parts::Pieces;
use display_host::skinning::{SkinMesh, SkinnedVertex, Touch};
use rt_process::replay::Replayed;
use session::{Surface, SurfaceFile};
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile, str_from_name};

use crate::build::build;
use crate::problem::Problem;

/// Surfaces under construction.
pub(super) struct Surfaces<'a> {
    pub(super) path: PathBuf,
    file: SurfaceFile,
    scene: &'a SceneFile,
    mesh: SkinMesh,
    motions: Motions,
    pieces: Pieces,
    now: Vec<SkinnedVertex>,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    period_s: f64,
    next_s: f64,
}

impl<'a> Surfaces<'a> {
    pub(super) fn create(path: &Path, hz: f64, scene: &'a SceneFile) -> Result<Self, Problem> {
        let mesh = SkinMesh::from_scene(scene);
        Ok(Self {
            path: path.to_owned(),
            file: SurfaceFile::create(path, &build())?,
            scene,
            motions: Motions::new(scene, Follow::Deform),
            pieces: Pieces::of(scene, &mesh),
            now: mesh.at_rest(),
            mesh,
            state: bytemuck::zeroed_box(),
            tools: Box::new(ToolFrame::zeroed()),
            period_s: 1.0 / hz,
            next_s: 0.0,
        })
    }

    /// Takes a tick, `at_s` after the first one. Writes the surfaces when they are due.
    pub(super) fn take(
        &mut self,
        replayed: &Replayed<'_>,
        at_s: f64,
        wall_ns: u64,
    ) -> Result<(), Problem> {
        if at_s < self.next_s {
            return Ok(());
        }
        self.next_s = (self.next_s + self.period_s).max(at_s);
        replayed.fill(self.scene.short_id(), &mut self.state, &mut self.tools);
        let spheres = self.state.spheres().unwrap_or(&[]);
        let parted = self.state.parted().into_iter().flatten();
        if self.pieces.set(parted, &mut self.mesh) {
            let severed: Vec<[u32; 2]> = self.pieces.severed().collect();
            self.motions.sever(&severed);
        }
        self.motions.update(spheres);
        let (organs, motions) = (self.scene.organs(), self.motions.now());
        let touch = Touch::of(&self.mesh, organs, spheres, motions, &self.tools);
        self.mesh.skin(motions, &touch, &mut self.now);
        Ok(self.file.add(wall_ns, &self.surfaces(), &self.tools)?)
    }

    /// The organs' present surfaces.
    fn surfaces(&self) -> Vec<Surface> {
        let organs = self.scene.organs().iter();
        let surfaces = organs.map(|organ| {
            let [vertices, triangles] = [organ.vertices, organ.triangles]
                .map(|[first, count]| first as usize..(first + count) as usize);
            let first = vertices.start as u32;
            let points = self.now.get(vertices).unwrap_or(&[]);
            let points_m = points.iter().map(|it| {
                let [x, y, z, _] = it.position;
                [x, y, z]
            });
            // Skin that is not drawn has triangles without area.
            let drawn = self.mesh.triangles.get(triangles).unwrap_or(&[]).iter();
            let drawn = drawn.filter(|[a, b, c]| a != b && b != c);
            Surface {
                name: str_from_name(&organ.name).unwrap_or_default().to_owned(),
                color: color(organ.kind),
                points_m: points_m.collect(),
                triangles: drawn.map(|it| it.map(|vertex| vertex - first)).collect(),
            }
        });
        surfaces.collect()
    }

    pub(super) fn end(self) -> Result<PathBuf, Problem> {
        self.file.end()?;
        Ok(self.path)
    }
}

/// Colour of an organ in a viewer.
fn color(kind: u32) -> [f32; 3] {
    let of = |wanted: OrganKind| wanted as u32 == kind;
    let is_any = |kinds: &[OrganKind]| kinds.iter().any(|it| of(*it));
    if of(OrganKind::Liver) {
        [0.45, 0.16, 0.12]
    } else if of(OrganKind::Gallbladder) {
        [0.35, 0.50, 0.25]
    } else if is_any(&[OrganKind::CysticDuct, OrganKind::BileDuct]) {
        [0.55, 0.62, 0.25]
    } else if is_any(&[OrganKind::CysticArtery, OrganKind::Vessel]) {
        [0.75, 0.12, 0.12]
    } else if is_any(&[OrganKind::Fat, OrganKind::ConnectiveTissue]) {
        [0.90, 0.80, 0.45]
    } else {
        [0.80, 0.55, 0.50]
    }
}
