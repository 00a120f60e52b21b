//! The gallbladder's bed, which is the connective tissue between gallbladder and liver. The part of
//! the bed next to the gallbladder's neck is dissected. There the gallbladder is pulled away, so
//! that the camera sees into the gap.

use glam::Vec3;
use shared_mem::message::{SphereState, StateFrame};
use shared_mem::scene::{CellRecord, OrganKind, OrganRecord, SceneFile};

use super::{Chapter, Shot, camera_only, is_free, sides};
use crate::render::camera::looking;

/// Displacement of the gallbladder at its neck, m.
const DRAWN_M: f32 = 0.020;
/// Share of the bed's length that is dissected, from the neck.
const GONE: f32 = 0.45;
/// Share of the bed's length, from the neck, over which the gallbladder is pulled away.
const OPENS: f32 = 0.75;
/// Distance from the gallbladder beyond which other organs do not move with it, m. At its surface
/// they move fully.
const FOLLOWS_M: f32 = 0.018;
/// Distance of the camera from the middle of the dissection's edge, m.
const FAR_M: f32 = 0.055;

/// The picture. `None` if the scene has no bed between a gallbladder and a liver.
pub(super) fn open(scene: &SceneFile) -> Option<Shot> {
    let organ = |kind: OrganKind| scene.organs().iter().find(|it| it.kind == kind as u32);
    let bed = Bed::of(scene, organ(OrganKind::ConnectiveTissue)?)?;
    let [bladder, liver] = [OrganKind::Gallbladder, OrganKind::Liver].map(organ);
    let [bladder, liver] = [range(bladder?), range(liver?)];
    let at_rest = scene.spheres();
    let centre = |i: usize| Vec3::from(at_rest[i].center_m);
    let drawn = |i: usize| {
        let at = centre(i);
        let share = if bladder.contains(&i) {
            1.0
        } else if liver.contains(&i) {
            0.0
        } else if bed.spheres.contains(&i) {
            bed.share_of_bladder(at)
        } else {
            let off = bladder.clone().map(|it| centre(it).distance(at));
            (1.0 - off.fold(f32::INFINITY, f32::min) / FOLLOWS_M).max(0.0)
        };
        at + bed.away * (share * bed.opening_m(at))
    };
    let spheres: Vec<SphereState> = (0..at_rest.len())
        .map(|i| SphereState {
            center_m: drawn(i).to_array(),
            bits: SphereState::AWAKE,
        })
        .collect();
    let mut cells = vec![0; scene.cells().len()];
    let mut front = Vec::new();
    for (number, cell) in &bed.cells {
        let along = bed.along(cell.center_m.into());
        if along < GONE {
            cells[*number] = StateFrame::GONE;
        } else if along < GONE + 0.1 {
            front.push(Vec3::from(cell.center_m));
        }
    }
    let middle = front.iter().sum::<Vec3>() / front.len().max(1) as f32;
    let hides: Vec<(Vec3, f32)> = bladder
        .clone()
        .chain(liver.clone())
        .map(|i| (drawn(i), at_rest[i].radius_m))
        .collect();
    let eye = Vec3::from(scene.room().world_from_camera.position_m);
    let home = (eye - middle).normalize_or(Vec3::Z);
    let seen = |from: Vec3| {
        let free = front.iter().filter(|at| is_free(**at, from, &hides));
        // A direction is rated by the number of cells that it sees. The endoscope's direction rates
        // higher, and so does the side of the neck, from where the camera looks into the gap.
        (1.0 + free.count() as f32) * (1.0 + 0.2 * from.dot(home) - 0.7 * from.dot(bed.axis))
    };
    let from = sides().map(|side| (seen(side), side));
    let (_, from) = from.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let tools = camera_only(scene, looking(middle + from * FAR_M, middle));
    Some(Shot {
        cells,
        spheres: Some(spheres),
        ..Shot::new(
            Chapter::Organs,
            "The gallbladder's bed, half dissected",
            tools,
        )
    })
}

fn range(organ: &OrganRecord) -> core::ops::Range<usize> {
    organ.spheres[0] as usize..(organ.spheres[0] + organ.spheres[1]) as usize
}

struct Bed<'a> {
    /// Cells with their indices in the scene.
    cells: Vec<(usize, &'a CellRecord)>,
    layers: u8,
    spheres: core::ops::Range<usize>,
    /// Direction from the liver to the gallbladder.
    away: Vec3,
    /// Direction from the neck to the fundus.
    axis: Vec3,
    /// Both ends of the bed along `axis`, m.
    ends_m: [f32; 2],
}

impl<'a> Bed<'a> {
    fn of(scene: &'a SceneFile, organ: &OrganRecord) -> Option<Self> {
        let spheres = range(organ);
        let own = |cell: &CellRecord| spheres.contains(&usize::from(cell.spheres[0]));
        let cells = scene.cells().iter().enumerate();
        let cells: Vec<_> = cells.filter(|(_, cell)| own(cell)).collect();
        let corner = |k: u16| Vec3::from(scene.cell_corners()[usize::from(k)].position_m);
        let across = cells.iter().map(|(_, cell)| {
            let way = (0..4).map(|k| corner(cell.corners[k]) - corner(cell.corners[k | 4]));
            way.sum::<Vec3>()
        });
        let middle = |region: u8| {
            let of = cells.iter().filter(|(_, cell)| cell.region == region);
            let places: Vec<Vec3> = of.map(|(_, cell)| cell.center_m.into()).collect();
            (!places.is_empty()).then(|| places.iter().sum::<Vec3>() / places.len() as f32)
        };
        let axis = middle(CellRecord::UPPER_BED)? - middle(CellRecord::LOWER_BED)?;
        let axis = axis.normalize_or(Vec3::X);
        let along = cells
            .iter()
            .map(|(_, cell)| Vec3::from(cell.center_m).dot(axis));
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let ends_m = along.fold(none, |[low, high], it| [low.min(it), high.max(it)]);
        Some(Self {
            layers: cells.iter().map(|(_, cell)| cell.layer + 1).max()?,
            away: across.sum::<Vec3>().normalize_or(Vec3::Y),
            cells,
            spheres,
            axis,
            ends_m,
        })
    }

    /// Position along the bed: 0 at the neck, 1 at the fundus.
    fn along(&self, at: Vec3) -> f32 {
        let [low, high] = self.ends_m;
        (at.dot(self.axis) - low) / (high - low).max(1e-6)
    }

    /// Displacement of the gallbladder at a place along the bed, which is the width of the gap, m.
    fn opening_m(&self, at: Vec3) -> f32 {
        DRAWN_M * ((OPENS - self.along(at)) / OPENS).clamp(0.0, 1.3)
    }

    /// Share of the gallbladder's displacement by which a place in the bed moves. The layer of the
    /// nearest cell decides it: near 1 at the gallbladder, near 0 at the liver.
    fn share_of_bladder(&self, at: Vec3) -> f32 {
        let off = |cell: &CellRecord| Vec3::from(cell.center_m).distance_squared(at);
        let nearest = self
            .cells
            .iter()
            .min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
        nearest.map_or(0.5, |(_, cell)| {
            1.0 - (f32::from(cell.layer) + 0.5) / f32::from(self.layers)
        })
    }
}
