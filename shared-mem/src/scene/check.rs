//! Checks a compiled scene's content: numbers must be in range, and indices inside their lists.

use core::fmt;

use super::error::SceneError;
use super::file::SceneFile;
use super::{
    AttachmentRecord, CellRecord, NO_CELL, NO_CONTACT_VERTEX, OrganKind, OrganRecord, WEIGHT_SUM,
    WORLD, str_from_name,
};
use crate::limits;
use crate::message::{MAX_CELLS, MAX_SPHERES, MAX_SUTURES, PoseMsg};

impl SceneFile {
    pub(super) fn check_content(&self) -> Result<(), SceneError> {
        check_count("room", self.sections[0].count as usize, 1, 1)?;
        check_count("organs", self.organs().len(), 1, 16)?;
        check_count("spheres", self.spheres().len(), 1, MAX_SPHERES)?;
        check_count("links", self.links().len(), 0, 8 * MAX_SPHERES)?;
        check_count("skin vertices", self.vertices().len(), 0, 4_000_000)?;
        check_count("skin triangles", self.triangles().len(), 0, 8_000_000)?;
        check_count("tetrahedra", self.tetrahedra().len(), 0, 6 * MAX_SPHERES)?;
        check_count("attachments", self.attachments().len(), 0, MAX_ATTACHMENTS)?;
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
        check_count("cells", self.cells().len(), 0, MAX_CELLS)?;
        check_count(
            "cell corners",
            self.cell_corners().len(),
            0,
            MAX_CELL_CORNERS,
        )?;
        check_count(
            "cell columns",
            self.cell_columns().len(),
            0,
            self.contact_vertices().len(),
        )?;
        for (what, found, max) in contact {
            check_count(what, found, 0, max)?;
        }
        self.check_room()?;

        let mut ends = [0u32; 5];
        for (i, organ) in self.organs().iter().enumerate() {
            let bad = |problem: String| record_error("organ", i, problem);
            if OrganKind::from_u32(organ.kind).is_none() {
                let kinds = OrganKind::ALL.len();
                return Err(bad(format!(
                    "kind is {}, allowed are 1 to {kinds}",
                    organ.kind
                )));
            }
            match str_from_name(&organ.name) {
                None => return Err(bad("its name is not UTF-8".into())),
                Some("") => return Err(bad("its name is empty".into())),
                Some(_) => {}
            }
            check_material(organ).map_err(bad)?;
            let ranges = [
                ("spheres", organ.spheres),
                ("links", organ.links),
                ("skin vertices", organ.vertices),
                ("skin triangles", organ.triangles),
                ("tetrahedra", organ.tetrahedra),
            ];
            for (end, (what, [first, n])) in ends.iter_mut().zip(ranges) {
                if first != *end {
                    return Err(bad(format!(
                        "the range of its {what} starts at {first}, allowed is {end}"
                    )));
                }
                *end = first.checked_add(n).ok_or_else(|| {
                    bad(format!("it has {n} {what} from {first}, more than exist"))
                })?;
            }
            if organ.spheres[1] == 0 {
                return Err(bad("it has no spheres, needed is at least 1".into()));
            }
            if organ.elastic_links > organ.links[1] {
                return Err(bad(format!(
                    "it has {} elastic links, allowed are at most its {} links",
                    organ.elastic_links, organ.links[1]
                )));
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
        let bad = |problem: String| record_error("room", 0, problem);
        let points = [
            ("gravity_m_s2", room.gravity_m_s2),
            ("instrument_port_m", room.instrument_port_m),
            ("endoscope_port_m", room.endoscope_port_m),
            ("target_m", room.target_m),
            ("target_normal", room.target_normal),
        ];
        for (name, point) in points {
            if point.iter().any(|x| !x.is_finite() || x.abs() > 1e3) {
                return Err(bad(format!(
                    "{name} is {point:?}, allowed are -1000 to 1000"
                )));
            }
        }
        for (name, pose) in [
            ("world_from_device", &room.world_from_device),
            ("world_from_tracker", &room.world_from_tracker),
            ("world_from_camera", &room.world_from_camera),
        ] {
            check_pose("room", name, pose)?;
        }
        if !(0.05..=1.0).contains(&room.instrument_length_m) {
            return Err(bad(format!(
                "instrument length is {} m, allowed are 0.05 to 1 m",
                room.instrument_length_m
            )));
        }
        if room.target_organ as usize >= self.organs().len() {
            return Err(bad(format!(
                "target organ {} does not exist, the scene has {} organs",
                room.target_organ,
                self.organs().len()
            )));
        }
        if !(0.0..=60.0).contains(&room.breath_s) {
            return Err(bad(format!(
                "breath_s is {}, allowed are 0 (nobody breathes) to 60",
                room.breath_s
            )));
        }
        str_from_name(&room.name).ok_or_else(|| bad("its name is not UTF-8".into()))?;
        self.check_trocar()?;
        self.check_stones()
    }

    fn check_stones(&self) -> Result<(), SceneError> {
        check_count("stones", self.sections[15].count as usize, 0, 1)?;
        let Some(stones) = self.stones() else {
            return Ok(());
        };
        let rules = [
            ("count", stones.count as f32, 0.0, limits::MAX_STONES as f32),
            ("diameter_m", stones.diameter_m, 0.001, 0.05),
            ("room_m3", stones.room_m3, 1.0e-6, 1.0e-3),
            ("bowl_radii_m right", stones.bowl_radii_m[0], 1.0e-3, 10.0),
            ("bowl_radii_m up", stones.bowl_radii_m[1], 1.0e-3, 10.0),
            ("bowl_radii_m back", stones.bowl_radii_m[2], 1.0e-3, 10.0),
        ];
        for (name, value, least, most) in rules {
            if !(least..=most).contains(&value) {
                let problem = format!("{name} is {value}, allowed are {least} to {most}");
                return Err(record_error("stones", 0, problem));
            }
        }
        check_pose("stones", "world_from_bowl", &stones.world_from_bowl)
    }

    fn check_trocar(&self) -> Result<(), SceneError> {
        check_count("trocar", self.sections[14].count as usize, 0, 1)?;
        let Some(trocar) = self.trocar() else {
            return Ok(());
        };
        let most_n = limits::TROCAR_FRICTION_MAX_N;
        let rules = [
            ("sliding_n", trocar.sliding_n, 0.0, most_n),
            ("breakaway_n", trocar.breakaway_n, trocar.sliding_n, most_n),
            (
                "wall_nm_rad",
                trocar.wall_nm_rad,
                0.0,
                limits::TROCAR_WALL_MAX_NM_RAD,
            ),
        ];
        for (name, value, least, most) in rules {
            if !(least..=most).contains(&value) {
                let problem = format!("{name} is {value}, allowed are {least} to {most}");
                return Err(record_error("trocar", 0, problem));
            }
        }
        Ok(())
    }

    fn check_elements(&self) -> Result<(), SceneError> {
        for (i, s) in self.spheres().iter().enumerate() {
            let ok = |x: f32, max: f32| x > 0.0 && x < max;
            let rules = [
                (
                    s.center_m.iter().all(is_near),
                    "center_m must be within 1000 m",
                ),
                (
                    ok(s.radius_m, 10.0),
                    "radius_m must be more than 0 and less than 10",
                ),
                (
                    ok(s.mass_kg, 1e4),
                    "mass_kg must be more than 0 and less than 10000",
                ),
                (s.held <= 1, "held must be 0 or 1"),
            ];
            require("sphere", i, s, &rules)?;
        }
        for organ in self.organs() {
            let own = |index: u32, [first, n]: [u32; 2]| index >= first && index < first + n;
            let [first, n] = organ.links;
            for i in first..first + n {
                let link = self.links()[i as usize];
                let bound = own(link.a, organ.spheres) && own(link.b, organ.spheres);
                let length_ok = link.rest_length_m > 0.0 && link.rest_length_m < 10.0;
                let compliance_ok = (0.0..=COMPLIANCE_MAX_M_N).contains(&link.compliance_m_n);
                let rules = [
                    (bound, "a and b must be spheres of its organ"),
                    (link.a != link.b, "a and b must differ"),
                    (
                        length_ok,
                        "rest_length_m must be more than 0 and less than 10",
                    ),
                    (compliance_ok, "compliance_m_n must be 0 to 1000000"),
                ];
                require("link", i as usize, &link, &rules)?;
            }
            let [first, n] = organ.tetrahedra;
            for i in first..first + n {
                let t = &self.tetrahedra()[i as usize];
                let corners = t.spheres.map(u32::from);
                let distinct = (1..4).all(|k| !corners[..k].contains(&corners[k]));
                let bound = corners.iter().all(|&s| own(s, organ.spheres));
                let volume_ok = t.volume_m3 > 0.0 && t.volume_m3 <= 1.0;
                let rules = [
                    (bound, "its corners must be spheres of its organ"),
                    (distinct, "its corners must differ"),
                    (volume_ok, "volume_m3 must be more than 0 and at most 1"),
                ];
                require("tetrahedron", i as usize, t, &rules)?;
            }
            let [first, n] = organ.vertices;
            for i in first..first + n {
                let v = &self.vertices()[i as usize];
                let sum: u32 = v.weights.iter().map(|&w| u32::from(w)).sum();
                let finite = v.position_m.iter().chain(&v.normal).all(|x| x.is_finite());
                let bound = v.spheres.iter().all(|&s| own(u32::from(s), organ.spheres));
                let rules = [
                    (sum == WEIGHT_SUM, "the sum of its weights must be 65535"),
                    (finite, "position_m and normal must be finite"),
                    (bound, "it must follow spheres of its organ"),
                ];
                require("skin vertex", i as usize, v, &rules)?;
            }
            let [first, n] = organ.triangles;
            for i in first..first + n {
                let t = self.triangles()[i as usize];
                if !t.iter().all(|&v| own(v, organ.vertices)) {
                    return Err(record_error(
                        "skin triangle",
                        i as usize,
                        format!("its corners {t:?} must be skin vertices of its organ"),
                    ));
                }
            }
        }
        self.check_attachments()?;
        self.check_contact_skin()?;
        self.check_cells()
    }

    /// Checks that each cell follows spheres of one organ, that the cells of an organ are
    /// consecutive, that neighbours list each other, and that numbers and indices are in range.
    fn check_cells(&self) -> Result<(), SceneError> {
        let (cells, corners) = (self.cells(), self.cell_corners());
        let organ_of = |sphere: u16| {
            let own = |o: &OrganRecord| u32::from(sphere) < o.spheres[0] + o.spheres[1];
            self.organs().iter().position(own)
        };
        let mut last = None;
        for (i, cell) in cells.iter().enumerate() {
            let bad = |problem: String| record_error("cell", i, problem);
            let organ = organ_of(cell.spheres[0]);
            if organ.is_none() || cell.spheres.iter().any(|&s| organ_of(s) != organ) {
                let problem = format!(
                    "it must follow spheres of one organ, not {:?}",
                    cell.spheres
                );
                return Err(bad(problem));
            }
            if last > organ {
                let problem = "its organ comes before the organ of the previous cell";
                return Err(bad(problem.into()));
            }
            last = organ;
            let sum: f32 = cell.weights.iter().sum();
            let exists = cell.corners.iter().all(|&c| usize::from(c) < corners.len());
            let weights_ok = cell.weights.iter().all(|w| w.abs() <= 8.0);
            let extent_ok = cell.extent_m.iter().all(|x| (1e-6..1.0).contains(x));
            let volume_ok = (1e-15..1.0).contains(&cell.volume_m3);
            let energy_ok = (1e-9..1e6).contains(&cell.energy_j);
            let rules = [
                (exists, "its corners must exist"),
                (weights_ok, "its weights must be -8 to 8"),
                (
                    (sum - 1.0).abs() <= 1e-3,
                    "the sum of its weights must be 1",
                ),
                (
                    cell.center_m.iter().all(is_near),
                    "center_m must be within 1000 m",
                ),
                (extent_ok, "extent_m must be at least 1e-6 and less than 1"),
                (
                    volume_ok,
                    "volume_m3 must be at least 1e-15 and less than 1",
                ),
                (
                    energy_ok,
                    "energy_j must be at least 1e-9 and less than 1e6",
                ),
                (
                    cell.region <= CellRecord::UPPER_BED,
                    "region must be 0 to 3",
                ),
            ];
            require("cell", i, cell, &rules)?;
            for (face, &other) in cell.neighbours.iter().enumerate() {
                if other == NO_CELL {
                    continue;
                }
                let Some(neighbour) = cells.get(usize::from(other)) else {
                    let problem = format!(
                        "neighbour {other} does not exist, the scene has {} cells",
                        cells.len()
                    );
                    return Err(bad(problem));
                };
                if organ_of(neighbour.spheres[0]) != organ {
                    return Err(bad(format!("neighbour {other} is of another organ")));
                }
                if neighbour.neighbours[face ^ 1] != i as u16 {
                    return Err(bad(format!(
                        "its neighbour {other} does not name it as a neighbour"
                    )));
                }
            }
        }
        for (i, v) in corners.iter().enumerate() {
            let sum: u32 = v.weights.iter().map(|&w| u32::from(w)).sum();
            let is_placed = v.position_m.iter().chain(&v.normal).all(is_near);
            let bound = v
                .spheres
                .iter()
                .all(|&s| usize::from(s) < self.spheres().len());
            let rules = [
                (sum == WEIGHT_SUM, "the sum of its weights must be 65535"),
                (is_placed, "position_m and normal must be within 1000"),
                (bound, "the spheres that it follows must exist"),
            ];
            require("cell corner", i, v, &rules)?;
        }
        for (i, column) in self.cell_columns().iter().enumerate() {
            let exists = |&c: &u16| usize::from(c) < cells.len() || c == NO_CELL;
            let rules = [
                (column.cells.iter().all(exists), "its cells must exist"),
                (
                    column.inwards.iter().all(|&f| f < 6),
                    "inwards must be 0 to 5",
                ),
            ];
            require("cell column", i, column, &rules)?;
        }
        Ok(())
    }

    /// Checks that numbers and indices are in range. The realtime process checks later that each
    /// contact vertex follows spheres of one organ.
    fn check_contact_skin(&self) -> Result<(), SceneError> {
        let (vertices, fans) = (self.contact_vertices(), self.contact_fans());
        for (i, v) in vertices.iter().enumerate() {
            let [first, n] = v.fan.map(|n| n as usize);
            let sum: f32 = v.weights.iter().sum();
            let bound = v
                .spheres
                .iter()
                .all(|&s| usize::from(s) < self.spheres().len());
            let fan_ok = first.checked_add(n).is_some_and(|end| end <= fans.len());
            let weights_ok = v.weights.iter().all(|w| w.abs() <= 8.0);
            let curvature_ok = v.curvature_per_m.abs() <= 1e4;
            let rules = [
                (bound, "the spheres that it follows must exist"),
                (fan_ok, "the triangles of its fan must exist"),
                (weights_ok, "its weights must be -8 to 8"),
                (
                    (sum - 1.0).abs() <= 1e-3,
                    "the sum of its weights must be 1",
                ),
                (
                    (1e-4..=1.0).contains(&v.patch_m),
                    "patch_m must be 0.0001 to 1",
                ),
                (curvature_ok, "curvature_per_m must be -10000 to 10000"),
            ];
            require("contact vertex", i, v, &rules)?;
        }
        let exists = |vertex: u16| usize::from(vertex) < vertices.len();
        for (i, corners) in fans.iter().enumerate() {
            if !corners.iter().all(|&corner| exists(corner)) {
                let problem = format!(
                    "its corners are {corners:?}, but the scene has {} contact vertices",
                    vertices.len()
                );
                return Err(record_error("contact triangle", i, problem));
            }
        }
        for (i, &vertex) in self.contact_nearest().iter().enumerate() {
            if !exists(vertex) && vertex != NO_CONTACT_VERTEX {
                let problem = format!(
                    "{vertex} does not exist, the scene has {} contact vertices",
                    vertices.len()
                );
                return Err(record_error("nearest contact vertex", i, problem));
            }
        }
        Ok(())
    }

    fn check_attachments(&self) -> Result<(), SceneError> {
        let exists = |sphere: u32| (sphere as usize) < self.spheres().len();
        let is_suture = |it: &&AttachmentRecord| it.is_thread == 1 && it.b == WORLD;
        let sutures = self.attachments().iter().filter(is_suture).count();
        check_count("sutures to the world", sutures, 0, MAX_SUTURES)?;
        for (i, attachment) in self.attachments().iter().enumerate() {
            let ends_ok = exists(attachment.a) && (exists(attachment.b) || attachment.b == WORLD);
            let length_ok = (0.0..10.0).contains(&attachment.rest_length_m);
            let compliance_ok = (0.0..=COMPLIANCE_MAX_M_N).contains(&attachment.compliance_m_n);
            let rules = [
                (
                    ends_ok,
                    "a must be a sphere, and b a sphere or 4294967295 (the world)",
                ),
                (attachment.a != attachment.b, "a and b must differ"),
                (
                    attachment.anchor_m.iter().all(is_near),
                    "anchor_m must be within 1000 m",
                ),
                (
                    length_ok,
                    "rest_length_m must be at least 0 and less than 10",
                ),
                (compliance_ok, "compliance_m_n must be 0 to 1000000"),
                (attachment.is_thread <= 1, "is_thread must be 0 or 1"),
                (
                    (0.0..=TEAR_MAX_J).contains(&attachment.tear_j),
                    "tear_j must be 0 to 1000",
                ),
            ];
            require("attachment", i, attachment, &rules)?;
        }
        Ok(())
    }
}

/// Largest number of attachments in a scene. The realtime process has the same limit.
const MAX_ATTACHMENTS: usize = 1024;
/// Largest number of contact vertices in a scene. The realtime process has the same limit.
const MAX_CONTACT_VERTICES: usize = 32_768;
/// Largest number of corners of cells in a scene. A cell has eight corners but shares most of them
/// with its neighbours.
const MAX_CELL_CORNERS: usize = 4 * MAX_CELLS;
/// Largest compliance of a link or attachment: 1 µN stretches it by 1 m.
const COMPLIANCE_MAX_M_N: f32 = 1e6;
/// Largest tearing energy, 1 kJ. A hand cannot supply more.
const TEAR_MAX_J: f32 = 1e3;
/// Largest number of substeps in one tick.
const SUBSTEPS_MAX: u32 = 16;

fn check_count(what: &'static str, found: usize, min: usize, max: usize) -> Result<(), SceneError> {
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

fn check_pose(what: &'static str, name: &str, pose: &PoseMsg) -> Result<(), SceneError> {
    match pose.is_sane() {
        true => Ok(()),
        false => Err(record_error(
            what,
            0,
            format!(
                "{name} is {pose:?}, allowed are a position within 1000 m and a quaternion of unit \
                 length"
            ),
        )),
    }
}

fn record_error(what: &'static str, index: usize, problem: String) -> SceneError {
    SceneError::Record {
        what,
        index,
        problem,
    }
}

/// Refuses a record that breaks one of its `rules`. A rule is a flag, true if the record obeys it,
/// and its text.
fn require(
    what: &'static str,
    index: usize,
    found: &impl fmt::Debug,
    rules: &[(bool, &str)],
) -> Result<(), SceneError> {
    match rules.iter().find(|(obeyed, _)| !obeyed) {
        None => Ok(()),
        Some((_, rule)) => Err(record_error(
            what,
            index,
            format!("{rule}; found {found:?}"),
        )),
    }
}

/// True for a finite coordinate of less than 1000 m.
fn is_near(x: &f32) -> bool {
    x.abs() < 1e3
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
