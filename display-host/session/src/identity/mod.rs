//! Identity image: the structure that each pixel of the endoscope's picture shows, and how much of
//! each structure it shows.
//!
//! The image shows the skins of the organs where they lie now, the instrument, and the layered
//! tissue that is left. A pixel keeps the nearest surface, and also the organs behind it. The
//! processor alone draws such a small picture a few times a second. It gives three shares: how much
//! of an organ is in view, how much of this part nothing hides, and how large it is. The recorder
//! writes these shares into the course ([`crate::EntryContent::Seen`]). So an assessment of the
//! recording needs neither a graphics card nor the simulation.
//!
//! Smoke and dirt on the lens are left out.

mod canvas;
mod counted;
mod seen;
mod surface;
mod vector;

use shared_mem::message::{PoseMsg, StateFrame, ToolFrame};
use shared_mem::scene::{CellRecord, OrganKind, SceneFile};

use self::canvas::Canvas;
pub use self::counted::ORGANS_MAX;
pub use self::seen::{OrganSeen, Seen};
use self::surface::Surface;
use self::vector::{Vec3, cross, dot, mean, norm, sub};

/// A removed cell that has moved farther than this from rest is taken at its place at rest, m,
/// because its spheres may have come loose.
const ADRIFT_M: f32 = 0.025;

/// Draws identity images of a scene.
pub struct Identity {
    surface: Surface,
    canvas: Canvas,
    cells: Vec<CellRecord>,
    plane: Option<Plane>,
    port_m: Vec3,
}

/// Camera of an endoscope whose view is inclined by `off_rad` to its shaft and turned by
/// `turned_rad` about it (0: down).
fn view_of(shaft: &PoseMsg, [off_rad, turned_rad]: [f32; 2]) -> PoseMsg {
    let [x, y, z, w] = shaft.orientation;
    let (sin, cos) = (-0.5 * off_rad).sin_cos();
    let [a, b] = [sin * turned_rad.cos(), sin * turned_rad.sin()];
    PoseMsg {
        orientation: [
            w * a + x * cos - z * b,
            w * b + y * cos + z * a,
            z * cos + x * b - y * a,
            w * cos - x * a - y * b,
        ],
        ..*shaft
    }
}

/// Plane through cystic duct and artery at rest. It divides the front of the triangle from the
/// back. The plane does not move with the organs, which sag once they are free.
struct Plane {
    middle_m: Vec3,
    normal: Vec3,
}

impl Plane {
    /// The plane of a scene; `None` if the scene lacks duct or artery.
    fn of(scene: &SceneFile) -> Option<Self> {
        let places = |kind: OrganKind| {
            let mut organs = scene.organs().iter();
            let [first, count] = organs.find(|it| it.kind == kind as u32)?.spheres;
            let own = scene
                .spheres()
                .get(first as usize..(first + count) as usize)?;
            Some(own.iter().map(|it| it.center_m).collect::<Vec<Vec3>>())
        };
        let (duct, artery) = (
            places(OrganKind::CysticDuct)?,
            places(OrganKind::CysticArtery)?,
        );
        let (first, last) = (duct.first()?, duct.last()?);
        let beside = artery.get(artery.len() / 2)?;
        Some(Self {
            middle_m: mean(&[mean(&duct), mean(&artery)]),
            normal: cross(sub(*last, *first), sub(*beside, *first)),
        })
    }
}

impl core::fmt::Debug for Identity {
    fn fmt(&self, to: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        to.debug_struct("Identity").finish_non_exhaustive()
    }
}

impl Identity {
    /// Prepares the images of a scene.
    #[must_use]
    pub fn of(scene: &SceneFile) -> Self {
        Self {
            surface: Surface::of(scene),
            canvas: Canvas::new(),
            cells: scene.cells().to_vec(),
            plane: Plane::of(scene),
            port_m: scene.room().endoscope_port_m,
        }
    }

    /// Draws what the endoscope sees, and measures it. `sight_rad`: angle between view and shaft,
    /// and the view's turn about the shaft, rad. `None` for a malformed frame, or one of another
    /// scene.
    pub fn look(
        &mut self,
        sight_rad: [f32; 2],
        state: &StateFrame,
        tools: &ToolFrame,
    ) -> Option<Seen> {
        let spheres = state.spheres()?;
        let states = state.cells()?;
        let is_whole =
            spheres.len() == self.surface.sphere_count() && self.cells.len() <= states.len();
        if !is_whole || !tools.world_from_camera.is_sane() {
            return None;
        }
        let camera = &view_of(&tools.world_from_camera, sight_rad);
        let is_gone = |cell: usize| states.get(cell) == Some(&StateFrame::GONE);
        self.surface.follow(spheres);
        self.canvas.begin(camera);
        self.surface.draw(&mut self.canvas, &self.cells, &is_gone);
        for capsule in tools.capsules().unwrap_or(&[]) {
            self.canvas.capsule(capsule);
        }
        let counted = self.canvas.count();
        let mut organs = [OrganSeen::default(); ORGANS_MAX];
        for (index, into) in organs.iter_mut().enumerate() {
            let in_view = self.surface.in_view(index, &self.canvas);
            *into = OrganSeen::of(in_view, &counted, index);
        }
        let share = |region: u8| self.opened(region, &is_gone);
        Some(Seen {
            side_rad: self.side_rad(camera.position_m),
            triangle: share(CellRecord::TRIANGLE),
            lower_bed: share(CellRecord::LOWER_BED),
            organs,
        })
    }

    /// Width of the latest image, pixels, and the organ at each pixel, row by row from the upper
    /// left, for comparisons with other pictures: `None` where no organ is, or an instrument hides
    /// it.
    #[must_use]
    pub fn pixels(&self) -> (usize, Vec<Option<usize>>) {
        self.canvas.pixels()
    }

    /// Share of a region's cells, by volume, that are gone and whose place nothing hides; 0 for a
    /// region without cells.
    fn opened(&self, region: u8, is_gone: &dyn Fn(usize) -> bool) -> f32 {
        let (mut seen, mut all) = (0.0, 0.0);
        for (index, cell) in self.cells.iter().enumerate() {
            if cell.region != region {
                continue;
            }
            all += cell.volume_m3;
            let moved = self.surface.moved(&cell.spheres, &cell.weights);
            let moved = if norm(moved) < ADRIFT_M {
                moved
            } else {
                [0.0; 3]
            };
            let at = [0, 1, 2].map(|i| cell.center_m[i] + moved[i]);
            // The place counts as seen up to the side of the cell that faces the lens.
            let half_m = 0.5 * cell.extent_m.iter().fold(0.0f32, |a, b| a.max(*b));
            if is_gone(index) && self.canvas.is_open(at, half_m) {
                seen += cell.volume_m3;
            }
        }
        if all > 0.0 { seen / all } else { 0.0 }
    }

    /// Angle between the line of sight to the triangle and the plane of duct and artery, rad:
    /// positive if the lens is on the side of the endoscope's port, 0 for a scene without the
    /// triangle.
    fn side_rad(&self, lens_m: Vec3) -> f32 {
        let Some(&Plane { middle_m, normal }) = self.plane.as_ref() else {
            return 0.0;
        };
        let off = |place: Vec3| {
            let to = sub(place, middle_m);
            dot(to, normal) / (norm(to) * norm(normal)).max(1e-12)
        };
        let side = off(lens_m).clamp(-1.0, 1.0).asin();
        if off(self.port_m) < 0.0 { -side } else { side }
    }
}

#[cfg(test)]
mod tests;
