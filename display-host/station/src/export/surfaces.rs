//! `calot export --surfaces`: the organs as the display draws them, at a stated rate, and pictures.

use std::path::{Path, PathBuf};

use bytemuck::Zeroable as _;
use display_host::skinning::organs::OrganSurfaces;
use display_host::words::Words;
use rt_process::replay::Replayed;
use session::{Surface, SurfaceFile};
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};

use crate::args::LanguageName;
use crate::build::build;
use crate::problem::Problem;
use crate::report;

/// Surfaces under construction.
pub(super) struct Surfaces {
    pub(super) path: PathBuf,
    file: SurfaceFile,
    scene_id: [u8; 16],
    organs: OrganSurfaces,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    period_s: f64,
    next_s: f64,
}

impl Surfaces {
    pub(super) fn create(path: &Path, hz: f64, scene: &SceneFile) -> Result<Self, Problem> {
        Ok(Self {
            path: path.to_owned(),
            file: SurfaceFile::create(path, &build())?,
            scene_id: scene.short_id(),
            organs: OrganSurfaces::of(scene),
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
        replayed.fill(self.scene_id, &mut self.state, &mut self.tools);
        self.organs.follow(&self.state, &self.tools);
        let organs = (0..self.organs.count()).filter_map(|organ| self.organs.get(organ));
        let surfaces = organs.map(|organ| Surface {
            name: organ.name.to_owned(),
            color: color(organ.kind),
            points_m: organ.points_m().collect(),
            triangles: organ.triangles,
        });
        let surfaces: Vec<Surface> = surfaces.collect();
        Ok(self.file.add(wall_ns, &surfaces, &self.tools)?)
    }

    /// Adds a picture of each alarm and critical view of the session at `path`: the one that the
    /// run kept, else a new one. Returns their number.
    pub(super) fn pictures(
        &mut self,
        path: &Path,
        wall_from_host_ns: i64,
    ) -> Result<usize, Problem> {
        let file = report::recording(path);
        let found = report::chapter(&file, None, None)?;
        let words = Words::new(LanguageName::or_users(None));
        let drawn = report::pictures::draw(&file, &found.wanted, &words)?;
        let count = drawn.len();
        for it in drawn {
            let kept = it
                .kept_in
                .filter(|_| path.is_dir())
                .map(|name| path.join(name));
            let kept = kept.and_then(|kept| std::fs::read(kept).ok());
            let wall_ns = it.at_ns.saturating_add_signed(wall_from_host_ns);
            self.file.picture(wall_ns, kept.unwrap_or(it.png))?;
        }
        Ok(count)
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
