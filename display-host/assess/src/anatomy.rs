//! Organs and layered tissue of a scene, as the assessment uses them.

use shared_mem::scene::{AttachmentRecord, CellRecord, OrganKind, SceneFile, WORLD, str_from_name};

use crate::vector::{Vec3, sum, wide};

/// Distance around duct and artery within which the controller clears the triangle (`rt_core::sim`,
/// `CLEARED_M`), m.
const CLEARED_M: f64 = 0.008;

/// Parts of the phantom, by their names in its recipe.
pub(crate) mod phantom {
    pub(crate) const BALLS: [&str; 3] = ["upper left ball", "lower left ball", "right ball"];
    pub(crate) const ROPE: &str = "rope";
    pub(crate) const TUBE: &str = "tube";
    pub(crate) const FAT: &str = "fat";
}

/// Part of the layered tissue, as the procedure counts it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Region {
    /// Outside the regions below.
    Elsewhere,
    /// In Calot's triangle, over duct and artery.
    Triangle,
    /// Lower third of the gallbladder's bed: the critical view of safety requires it to be free.
    LowerBed,
    /// The rest of the bed.
    UpperBed,
}

impl Region {
    /// Number of regions.
    pub(crate) const COUNT: usize = 4;
    /// Regions whose removed share is reported.
    pub const COUNTED: [Self; 3] = [Self::Triangle, Self::LowerBed, Self::UpperBed];

    /// The region with this number in a compiled scene ([`CellRecord::region`]).
    #[must_use]
    pub fn from_number(number: u8) -> Self {
        match number {
            CellRecord::TRIANGLE => Self::Triangle,
            CellRecord::LOWER_BED => Self::LowerBed,
            CellRecord::UPPER_BED => Self::UpperBed,
            _ => Self::Elsewhere,
        }
    }
}

/// An organ of the scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Organ {
    pub(crate) name: String,
    pub(crate) kind: Option<OrganKind>,
    /// Middle of its spheres at rest, m; the origin in an anatomy without a compiled scene.
    pub(crate) middle: Vec3,
}

/// A scene's organs and its layered tissue.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Anatomy {
    pub(crate) organs: Vec<Organ>,
    /// Region and volume (m³) of each cell of layered tissue.
    pub(crate) cells: Vec<(Region, f64)>,
    /// Cells already removed when a task begins with the triangle cleared.
    pub(crate) cleared: Vec<usize>,
    /// Volume of each region, m³.
    pub(crate) volume_in: [f64; Region::COUNT],
    /// Number of sutures that hang organs on the abdominal wall.
    pub(crate) sutures: usize,
    /// Unit vector opposite to gravity; zero without gravity.
    pub(crate) up: Vec3,
}

impl Anatomy {
    /// The anatomy of a compiled scene.
    #[must_use]
    pub fn of(scene: &SceneFile) -> Self {
        let gravity = wide(scene.room().gravity_m_s2);
        let is_suture = |tie: &&AttachmentRecord| tie.is_thread != 0 && tie.b == WORLD;
        let sutures = scene.attachments().iter().filter(is_suture).count();
        let organs = scene.organs().iter().map(|record| Organ {
            name: str_from_name(&record.name).unwrap_or_default().to_owned(),
            kind: OrganKind::from_u32(record.kind),
            middle: middle(scene, record.spheres.map(|number| number as usize)),
        });
        let cells = scene.cells().iter().map(|cell| {
            let volume_m3 = f64::from(cell.volume_m3).max(0.0);
            (Region::from_number(cell.region), volume_m3)
        });
        let cells: Vec<_> = cells.collect();
        Self {
            organs: organs.collect(),
            cleared: cleared(scene),
            volume_in: volumes(&cells),
            cells,
            sutures,
            up: unit(gravity.map(|x| -x)),
        }
    }

    /// An anatomy of named organs and cells of equal volume, without a compiled scene: for tests.
    #[must_use]
    pub fn new(organs: &[(&str, OrganKind)], cells: &[Region]) -> Self {
        let organs = organs.iter().map(|&(name, kind)| Organ {
            name: name.to_owned(),
            kind: Some(kind),
            middle: [0.0; 3],
        });
        let cells: Vec<_> = cells.iter().map(|region| (*region, 1.0)).collect();
        Self {
            organs: organs.collect(),
            cleared: Vec::new(),
            volume_in: volumes(&cells),
            cells,
            sutures: 0,
            up: [0.0, 0.0, 1.0],
        }
    }

    /// Number of sutures that hang organs on the abdominal wall.
    #[must_use]
    pub fn sutures(&self) -> usize {
        self.sutures
    }

    pub(crate) fn organ(&self, index: u32) -> Option<&Organ> {
        self.organs.get(index as usize)
    }

    /// Index of the organ of this name.
    pub(crate) fn named(&self, name: &str) -> Option<u32> {
        let found = self.organs.iter().position(|it| it.name == name)?;
        u32::try_from(found).ok()
    }

    /// True if the scene is the phantom.
    pub(crate) fn is_phantom(&self) -> bool {
        let named = phantom::BALLS.into_iter();
        let mut named = named.chain([phantom::ROPE, phantom::TUBE, phantom::FAT]);
        named.all(|name| self.named(name).is_some()) && self.has_cells(Region::Elsewhere)
    }

    pub(crate) fn kind(&self, index: u32) -> Option<OrganKind> {
        self.organ(index)?.kind
    }

    /// True if the scene has an organ of this kind.
    #[must_use]
    pub fn has(&self, kind: OrganKind) -> bool {
        self.organs.iter().any(|organ| organ.kind == Some(kind))
    }

    /// Cystic duct and cystic artery, by their index.
    pub(crate) fn two(&self) -> [Option<usize>; 2] {
        [OrganKind::CysticDuct, OrganKind::CysticArtery].map(|kind| {
            let mut organs = self.organs.iter();
            organs.position(|organ| organ.kind == Some(kind))
        })
    }

    /// True if a region has layered tissue.
    pub(crate) fn has_cells(&self, region: Region) -> bool {
        self.volume_in
            .get(region as usize)
            .is_some_and(|it| *it > 0.0)
    }
}

/// Middle of `count` spheres from the `first` on, at rest, m.
fn middle(scene: &SceneFile, [first, count]: [usize; 2]) -> Vec3 {
    let own = scene.spheres().iter().skip(first).take(count);
    let total = own.fold([0.0; 3], |all, it| sum(all, wide(it.center_m)));
    total.map(|it| it / count.max(1) as f64)
}

/// Cells whose centre at rest is within the controller's clearing distance of cystic duct or
/// artery.
fn cleared(scene: &SceneFile) -> Vec<usize> {
    let is_bare = |kind| matches!(kind, Some(OrganKind::CysticDuct | OrganKind::CysticArtery));
    let tubes = scene.organs().iter();
    let tubes = tubes.filter(|organ| is_bare(OrganKind::from_u32(organ.kind)));
    let spheres: Vec<Vec3> = tubes
        .flat_map(|organ| {
            let [first, count] = organ.spheres.map(|number| number as usize);
            scene.spheres().iter().skip(first).take(count)
        })
        .map(|sphere| wide(sphere.center_m))
        .collect();
    let cells = scene.cells().iter().enumerate();
    let near = cells.filter(|(_, cell)| {
        let at = wide(cell.center_m);
        spheres
            .iter()
            .any(|it| crate::vector::distance(*it, at) < CLEARED_M)
    });
    near.map(|(index, _)| index).collect()
}

fn volumes(cells: &[(Region, f64)]) -> [f64; Region::COUNT] {
    let mut volumes = [0.0; Region::COUNT];
    for (region, volume_m3) in cells {
        if let Some(sum) = volumes.get_mut(*region as usize) {
            *sum += volume_m3;
        }
    }
    volumes
}

fn unit(v: Vec3) -> Vec3 {
    let length = crate::vector::norm(v);
    match length > 1e-12 && length.is_finite() {
        true => v.map(|x| x / length),
        false => [0.0; 3],
    }
}
