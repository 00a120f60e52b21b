//! Organs and layered tissue of a scene, as the assessment uses them.

use shared_mem::scene::{AttachmentRecord, CellRecord, OrganKind, SceneFile, WORLD, str_from_name};

use crate::vector::{Vec3, wide};

/// Distance around duct and artery within which the controller clears the triangle (`rt_core::sim`,
/// `CLEARED_M`), m.
const CLEARED_M: f64 = 0.008;

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
    /// Centroid of its spheres at rest, m.
    pub(crate) middle_m: Vec3,
}

/// A ball of a structure at rest: a sphere of an organ, or a cell of layered tissue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    /// Middle, world frame, m.
    pub(crate) at_m: Vec3,
    /// Radius, m.
    pub(crate) radius_m: f64,
    /// Index of the organ.
    pub(crate) organ: u32,
    /// Index of the cell, if it is one.
    pub(crate) cell: Option<usize>,
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
    /// Everything that can be seen or hide something.
    pub(crate) balls: Vec<Ball>,
    /// The endoscope's port, m.
    pub(crate) scope_port_m: Vec3,
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
        let organs = scene.organs().iter().map(|record| {
            let [first, count] = record.spheres.map(|number| number as usize);
            let spheres = scene.spheres().iter().skip(first).take(count);
            let centers: Vec<Vec3> = spheres.map(|it| wide(it.center_m)).collect();
            Organ {
                name: str_from_name(&record.name).unwrap_or_default().to_owned(),
                kind: OrganKind::from_u32(record.kind),
                middle_m: middle(&centers),
            }
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
            balls: balls(scene),
            scope_port_m: wide(scene.room().endoscope_port_m),
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
            middle_m: [0.0; 3],
        });
        let cells: Vec<_> = cells.iter().map(|region| (*region, 1.0)).collect();
        Self {
            organs: organs.collect(),
            cleared: Vec::new(),
            volume_in: volumes(&cells),
            cells,
            balls: Vec::new(),
            scope_port_m: [0.0; 3],
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

    pub(crate) fn kind(&self, index: u32) -> Option<OrganKind> {
        self.organ(index)?.kind
    }

    /// True if the scene has an organ of this kind.
    #[must_use]
    pub fn has(&self, kind: OrganKind) -> bool {
        self.organs.iter().any(|organ| organ.kind == Some(kind))
    }

    /// Places of the spheres of the first organ of this kind, in their order.
    pub(crate) fn places_of(&self, kind: OrganKind) -> impl Iterator<Item = Vec3> {
        let mut organs = (0u32..).zip(&self.organs);
        let found = organs.find(|(_, organ)| organ.kind == Some(kind));
        let index = found.map(|(index, _)| index);
        let own = self.balls.iter();
        let own = own.filter(move |it| Some(it.organ) == index && it.cell.is_none());
        own.map(|it| it.at_m)
    }

    /// True if a region has layered tissue.
    pub(crate) fn has_cells(&self, region: Region) -> bool {
        self.volume_in
            .get(region as usize)
            .is_some_and(|it| *it > 0.0)
    }
}

/// Spheres of the organs, and cells. The spheres of an organ that consists of cells are left out.
fn balls(scene: &SceneFile) -> Vec<Ball> {
    let organs = (0u32..).zip(scene.organs());
    let owner = |sphere: u32| {
        let holds = |record: &[u32; 2]| sphere.wrapping_sub(record[0]) < record[1];
        let found = (0u32..)
            .zip(scene.organs())
            .find(|(_, it)| holds(&it.spheres));
        found.map_or(u32::MAX, |(index, _)| index)
    };
    let cells: Vec<Ball> = (scene.cells().iter().enumerate())
        .map(|(index, cell)| Ball {
            at_m: wide(cell.center_m),
            radius_m: f64::from(cell.extent_m.iter().fold(0.0f32, |a, b| a.max(*b))) / 2.0,
            organ: owner(cell.spheres[0].into()),
            cell: Some(index),
        })
        .collect();
    let layered: Vec<u32> = cells.iter().map(|it| it.organ).collect();
    let solid = organs.filter(|(index, _)| !layered.contains(index));
    let spheres = solid.flat_map(|(organ, record)| {
        let [first, count] = record.spheres.map(|number| number as usize);
        let own = scene.spheres().iter().skip(first).take(count);
        own.map(move |sphere| Ball {
            at_m: wide(sphere.center_m),
            radius_m: sphere.radius_m.into(),
            organ,
            cell: None,
        })
    });
    let spheres: Vec<Ball> = spheres.collect();
    [spheres, cells].concat()
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

fn middle(points: &[Vec3]) -> Vec3 {
    let count = points.len().max(1) as f64;
    [0, 1, 2].map(|i| points.iter().map(|point| point[i]).sum::<f64>() / count)
}
