//! Checks of a compiled scene's content: every number in its range, every index in its list.

use super::error::SceneError;
use super::file::SceneFile;
use super::{
    AttachmentRecord, CellRecord, NO_CELL, NO_CONTACT_VERTEX, OrganKind, OrganRecord, WEIGHT_SUM,
    WORLD, str_from_name,
};
use crate::message::{MAX_CELLS, MAX_SPHERES, MAX_SUTURES};

impl SceneFile {
    pub(super) fn check_content(&self) -> Result<(), SceneError> {
        count("room", self.sections[0].count as usize, 1, 1)?;
        count("organs", self.organs().len(), 1, 16)?;
        count("spheres", self.spheres().len(), 1, MAX_SPHERES)?;
        count("links", self.links().len(), 0, 8 * MAX_SPHERES)?;
        count("skin vertices", self.vertices().len(), 0, 4_000_000)?;
        count("skin triangles", self.triangles().len(), 0, 8_000_000)?;
        count("tetrahedra", self.tetrahedra().len(), 0, 6 * MAX_SPHERES)?;
        count("attachments", self.attachments().len(), 0, MAX_ATTACHMENTS)?;
        let contact = [
            (
                "contact vertices",
                self.contact_vertices().len(),
                MAX_CONTACT_VERTICES,
            ),
            (
                "contact triangles",
                self.contact_fans().len(),
                16 * MAX_CONTACT_VERTICES,
            ),
            (
                "nearest contact vertices",
                self.contact_nearest().len(),
                self.spheres().len(),
            ),
        ];
        count("cells", self.cells().len(), 0, MAX_CELLS)?;
        count(
            "cell corners",
            self.cell_corners().len(),
            0,
            MAX_CELL_CORNERS,
        )?;
        count(
            "cell columns",
            self.cell_columns().len(),
            0,
            self.contact_vertices().len(),
        )?;
        for (what, found, max) in contact {
            count(what, found, 0, max)?;
        }
        self.check_room()?;

        let mut ends = [0u32; 5];
        for (i, organ) in self.organs().iter().enumerate() {
            let bad = |problem: String| record("organ", i, problem);
            if OrganKind::from_u32(organ.kind).is_none() {
                return Err(bad(format!("unknown kind {}", organ.kind)));
            }
            if str_from_name(&organ.name).is_none_or(str::is_empty) {
                return Err(bad("name is empty or not UTF-8".into()));
            }
            check_material(organ).map_err(bad)?;
            let ranges = [
                organ.spheres,
                organ.links,
                organ.vertices,
                organ.triangles,
                organ.tetrahedra,
            ];
            for (end, [first, n]) in ends.iter_mut().zip(ranges) {
                if first != *end {
                    return Err(bad(format!("range starts at {first}, expected {end}")));
                }
                *end = first
                    .checked_add(n)
                    .ok_or_else(|| bad("range overflows".into()))?;
            }
            if organ.spheres[1] == 0 {
                return Err(bad("has no spheres".into()));
            }
            if organ.elastic_links > organ.links[1] {
                return Err(bad("has more elastic links than links".into()));
            }
        }
        let sizes = [
            self.spheres().len(),
            self.links().len(),
            self.vertices().len(),
            self.triangles().len(),
            self.tetrahedra().len(),
        ];
        if ends.map(|end| end as usize) != sizes {
            return Err(SceneError::NotAScene("organs do not cover their sections"));
        }
        self.check_elements()
    }

    fn check_room(&self) -> Result<(), SceneError> {
        let room = self.room();
        let bad = |problem: &str| record("room", 0, problem.into());
        let points = [
            room.gravity_m_s2,
            room.instrument_port_m,
            room.endoscope_port_m,
            room.target_m,
            room.target_normal,
        ];
        if points
            .as_flattened()
            .iter()
            .any(|x| !x.is_finite() || x.abs() > 1e3)
        {
            return Err(bad("a point is not finite or beyond 1000"));
        }
        for pose in [
            &room.world_from_device,
            &room.world_from_tracker,
            &room.world_from_camera,
        ] {
            if !pose.is_sane() {
                return Err(bad(
                    "a pose is not finite or its quaternion not of unit length",
                ));
            }
        }
        if !(0.05..=1.0).contains(&room.instrument_length_m) {
            return Err(bad("instrument length is outside 0.05 to 1 m"));
        }
        if room.target_organ as usize >= self.organs().len() {
            return Err(bad("target organ does not exist"));
        }
        if !(0.0..=60.0).contains(&room.breath_s) {
            return Err(bad("a breath takes 0 (nobody breathes) to 60 s"));
        }
        str_from_name(&room.name)
            .map(|_| ())
            .ok_or_else(|| bad("name is not UTF-8"))
    }

    fn check_elements(&self) -> Result<(), SceneError> {
        for (i, s) in self.spheres().iter().enumerate() {
            let finite = s.center_m.iter().all(|x| x.is_finite() && x.abs() < 1e3);
            let ok = |x: f32, max: f32| x > 0.0 && x < max;
            if !finite || !ok(s.radius_m, 10.0) || !ok(s.mass_kg, 1e4) || s.held > 1 {
                return Err(record("sphere", i, format!("out of range: {s:?}")));
            }
        }
        for organ in self.organs() {
            let own = |index: u32, [first, n]: [u32; 2]| index >= first && index < first + n;
            let [first, n] = organ.links;
            for i in first..first + n {
                let link = self.links()[i as usize];
                let length_ok = link.rest_length_m > 0.0
                    && link.rest_length_m < 10.0
                    && (0.0..=COMPLIANCE_MAX_M_N).contains(&link.compliance_m_n);
                if !own(link.a, organ.spheres)
                    || !own(link.b, organ.spheres)
                    || link.a == link.b
                    || !length_ok
                {
                    return Err(record(
                        "link",
                        i as usize,
                        format!("out of range: {link:?}"),
                    ));
                }
            }
            let [first, n] = organ.tetrahedra;
            for i in first..first + n {
                let t = &self.tetrahedra()[i as usize];
                let corners = t.spheres.map(u32::from);
                let distinct = (1..4).all(|k| !corners[..k].contains(&corners[k]));
                let bound = corners.iter().all(|&s| own(s, organ.spheres));
                if !(bound && distinct && t.volume_m3 > 0.0 && t.volume_m3 <= 1.0) {
                    return Err(record(
                        "tetrahedron",
                        i as usize,
                        format!("out of range: {t:?}"),
                    ));
                }
            }
            let [first, n] = organ.vertices;
            for i in first..first + n {
                let v = &self.vertices()[i as usize];
                let sum: u32 = v.weights.iter().map(|&w| u32::from(w)).sum();
                let finite = v.position_m.iter().chain(&v.normal).all(|x| x.is_finite());
                let bound = v.spheres.iter().all(|&s| own(u32::from(s), organ.spheres));
                if sum != WEIGHT_SUM || !finite || !bound {
                    return Err(record(
                        "skin vertex",
                        i as usize,
                        format!("out of range: {v:?}"),
                    ));
                }
            }
            let [first, n] = organ.triangles;
            for i in first..first + n {
                let t = self.triangles()[i as usize];
                if !t.iter().all(|&v| own(v, organ.vertices)) {
                    return Err(record(
                        "skin triangle",
                        i as usize,
                        format!("{t:?} leaves its organ"),
                    ));
                }
            }
        }
        self.check_attachments()?;
        self.check_contact_skin()?;
        self.check_cells()
    }

    /// Checks that each cell follows spheres of one organ, that neighbours name each other, and
    /// that every number is in range.
    fn check_cells(&self) -> Result<(), SceneError> {
        let (cells, corners) = (self.cells(), self.cell_corners());
        let organ_of = |sphere: u16| {
            let own = |o: &OrganRecord| u32::from(sphere) < o.spheres[0] + o.spheres[1];
            self.organs().iter().position(own)
        };
        let mut last = None;
        for (i, cell) in cells.iter().enumerate() {
            let bad = |problem: String| record("cell", i, problem);
            let organ = organ_of(cell.spheres[0]);
            if organ.is_none() || cell.spheres.iter().any(|&s| organ_of(s) != organ) {
                let problem = format!("follows {:?}, not all of one organ", cell.spheres);
                return Err(bad(problem));
            }
            if last > organ {
                return Err(bad("is of an organ before that of the last cell".into()));
            }
            last = organ;
            let sum: f32 = cell.weights.iter().sum();
            let good = cell.corners.iter().all(|&c| usize::from(c) < corners.len())
                && cell.weights.iter().all(|w| w.abs() <= 8.0)
                && (sum - 1.0).abs() <= 1e-3
                && cell.center_m.iter().all(|x| x.abs() < 1e3)
                && cell.extent_m.iter().all(|x| (1e-6..1.0).contains(x))
                && (1e-15..1.0).contains(&cell.volume_m3)
                && (1e-9..1e6).contains(&cell.energy_j)
                && cell.region <= CellRecord::UPPER_BED;
            if !good {
                return Err(bad(format!("out of range: {cell:?}")));
            }
            for (face, &other) in cell.neighbours.iter().enumerate() {
                let back = cells
                    .get(usize::from(other))
                    .map(|it| it.neighbours[face ^ 1]);
                let same = |other: u16| {
                    let spheres = cells.get(usize::from(other)).map(|it| it.spheres[0]);
                    spheres.is_some_and(|sphere| organ_of(sphere) == organ)
                };
                if other != NO_CELL && (back != Some(i as u16) || !same(other)) {
                    let problem = format!("neighbour {other} is none, or does not name it");
                    return Err(bad(problem));
                }
            }
        }
        for (i, v) in corners.iter().enumerate() {
            let sum: u32 = v.weights.iter().map(|&w| u32::from(w)).sum();
            let finite = v.position_m.iter().chain(&v.normal).all(|x| x.abs() < 1e3);
            let bound = v
                .spheres
                .iter()
                .all(|&s| usize::from(s) < self.spheres().len());
            if sum != WEIGHT_SUM || !finite || !bound {
                return Err(record("cell corner", i, format!("out of range: {v:?}")));
            }
        }
        for (i, column) in self.cell_columns().iter().enumerate() {
            let exists = |&c: &u16| usize::from(c) < cells.len() || c == NO_CELL;
            if !column.cells.iter().all(exists) || column.inwards.iter().any(|&f| f >= 6) {
                return Err(record(
                    "cell column",
                    i,
                    format!("out of range: {column:?}"),
                ));
            }
        }
        Ok(())
    }

    /// Checks that every index exists. The realtime process checks later that each contact vertex
    /// follows spheres of one organ.
    fn check_contact_skin(&self) -> Result<(), SceneError> {
        let (vertices, fans) = (self.contact_vertices(), self.contact_fans());
        for (i, v) in vertices.iter().enumerate() {
            let [first, n] = v.fan.map(|n| n as usize);
            let sum: f32 = v.weights.iter().sum();
            let good = v
                .spheres
                .iter()
                .all(|&s| usize::from(s) < self.spheres().len())
                && first.checked_add(n).is_some_and(|end| end <= fans.len())
                && v.weights.iter().all(|w| w.abs() <= 8.0)
                && (sum - 1.0).abs() <= 1e-3
                && (1e-4..=1.0).contains(&v.patch_m)
                && v.curvature_per_m.abs() <= 1e4;
            if !good {
                return Err(record("contact vertex", i, format!("out of range: {v:?}")));
            }
        }
        let exists = |vertex: u16| usize::from(vertex) < vertices.len();
        for (i, corners) in fans.iter().enumerate() {
            if !corners.iter().all(|&corner| exists(corner)) {
                let problem = format!("{corners:?} do not exist");
                return Err(record("contact triangle", i, problem));
            }
        }
        for (i, &vertex) in self.contact_nearest().iter().enumerate() {
            if !exists(vertex) && vertex != NO_CONTACT_VERTEX {
                let problem = format!("{vertex} does not exist");
                return Err(record("nearest contact vertex", i, problem));
            }
        }
        Ok(())
    }

    fn check_attachments(&self) -> Result<(), SceneError> {
        let exists = |sphere: u32| (sphere as usize) < self.spheres().len();
        let is_suture = |it: &&AttachmentRecord| it.is_thread == 1 && it.b == WORLD;
        let sutures = self.attachments().iter().filter(is_suture).count();
        count("sutures to the world", sutures, 0, MAX_SUTURES)?;
        for (i, band) in self.attachments().iter().enumerate() {
            let ends_ok = exists(band.a) && (exists(band.b) || band.b == WORLD) && band.a != band.b;
            let numbers_ok = band.anchor_m.iter().all(|x| x.is_finite() && x.abs() < 1e3)
                && (0.0..10.0).contains(&band.rest_length_m)
                && (0.0..=COMPLIANCE_MAX_M_N).contains(&band.compliance_m_n)
                && band.is_thread <= 1
                && (0.0..=TEAR_MAX_J).contains(&band.tear_j);
            if !ends_ok || !numbers_ok {
                return Err(record("attachment", i, format!("out of range: {band:?}")));
            }
        }
        Ok(())
    }
}

/// Most attachments in a scene. The realtime process has the same limit.
const MAX_ATTACHMENTS: usize = 1024;
/// Most contact vertices in a scene. The realtime process has the same limit.
const MAX_CONTACT_VERTICES: usize = 32_768;
/// Most corners of cells in a scene. A cell has eight corners but shares most of them with its
/// neighbours.
const MAX_CELL_CORNERS: usize = 4 * MAX_CELLS;
/// Largest compliance: 1 µN stretches a link by 1 m. A softer link would hold nothing.
const COMPLIANCE_MAX_M_N: f32 = 1e6;
/// Largest tearing energy, 1 kJ. A hand cannot supply more.
const TEAR_MAX_J: f32 = 1e3;
/// Most solver steps in one tick.
const SUBSTEPS_MAX: u32 = 16;

fn count(what: &'static str, found: usize, min: usize, max: usize) -> Result<(), SceneError> {
    if (min..=max).contains(&found) {
        return Ok(());
    }
    Err(SceneError::Count {
        what,
        found,
        min,
        max,
    })
}

fn record(what: &'static str, index: usize, problem: String) -> SceneError {
    SceneError::Record {
        what,
        index,
        problem,
    }
}

fn check_material(organ: &OrganRecord) -> Result<(), String> {
    let m = &organ.material;
    for (name, value, min, max) in [
        ("density_kg_m3", m.density_kg_m3, 1.0, 1e5),
        ("young_pa", m.young_pa, 1.0, 1e9),
        ("poisson", m.poisson, 0.0, 0.4999),
        ("stretch_stiffness", m.stretch_stiffness, 0.0, 1.0),
        ("laplacian_stiffness", m.laplacian_stiffness, 0.0, 1.0),
        ("damping_per_s", m.damping_per_s, 0.0, 1e3),
        ("contact_stiffness_n_m", m.contact_stiffness_n_m, 0.0, 1e5),
        ("retardation_s", m.retardation_s, 0.0, 1.0),
        ("friction", m.friction, 0.0, 2.0),
        ("toughness_j_m2", m.toughness_j_m2, 0.0, 1e6),
        ("volume_m3", organ.volume_m3, 0.0, 1.0),
        ("substeps", organ.substeps as f32, 1.0, SUBSTEPS_MAX as f32),
        ("gravity_share", organ.gravity_share, 0.0, 1.0),
        ("breath_m", organ.breath_m[0], -0.1, 0.1),
        ("breath_m", organ.breath_m[1], -0.1, 0.1),
        ("breath_m", organ.breath_m[2], -0.1, 0.1),
    ] {
        if !(min..=max).contains(&value) {
            return Err(format!("{name} is {value}, allowed are {min} to {max}"));
        }
    }
    if !organ.substeps.is_power_of_two() {
        let substeps = organ.substeps;
        return Err(format!(
            "substeps is {substeps}, allowed are 1, 2, 4, 8 and 16"
        ));
    }
    Ok(())
}
