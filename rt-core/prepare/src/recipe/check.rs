//! Checks a recipe's text, and makes the recipe.

use std::path::Path;

use rt_core::capacity::{MAX_STONES, TROCAR_FRICTION_MAX_N, TROCAR_WALL_MAX_NM_RAD};
use shared_mem::scene::OrganKind;

use super::locate::{Step, line_of_offset, line_of_path};
use super::raw::{
    FrameRaw, MaterialRaw, OrganRaw, RecipeRaw, RoomRaw, StonesRaw, TieRaw, TrocarRaw,
};
use super::{
    Closing, Frame, Material, MeshOptions, OrganPlan, Packing, Place, Recipe, Region, RoomPlan,
    SPHERES_MAX, SPHERES_MIN, StonesPlan, Surface, Tie, TrocarPlan, Unit,
};
use crate::Vec3;
use crate::error::RecipeError;
use crate::shape::{Anatomy, Shape};

/// Largest number of organs of a scene.
const ORGANS_MAX: usize = rt_core::capacity::MAX_ORGANS;

/// Allowed time budgets of a tick, µs. The period is 1000 µs.
const TICK_US: std::ops::RangeInclusive<f64> = 5.0..=1000.0;

const KINDS: [(&str, OrganKind, usize); 11] = [
    ("liver", OrganKind::Liver, 581),
    ("gallbladder", OrganKind::Gallbladder, 240),
    ("cystic-duct", OrganKind::CysticDuct, 24),
    ("cystic-artery", OrganKind::CysticArtery, 24),
    ("bile-duct", OrganKind::BileDuct, 32),
    ("stomach", OrganKind::Stomach, 240),
    ("intestine", OrganKind::Intestine, 240),
    ("fat", OrganKind::Fat, 160),
    ("connective-tissue", OrganKind::ConnectiveTissue, 120),
    ("abdominal-wall", OrganKind::AbdominalWall, 240),
    ("vessel", OrganKind::Vessel, 32),
];

/// The kind of organ with this name.
pub(super) fn organ_kind(name: &str) -> Result<OrganKind, String> {
    let found = KINDS.iter().find(|(known, _, _)| *known == name);
    let known = || KINDS.map(|(name, _, _)| name).join(", ");
    found
        .map(|(_, kind, _)| *kind)
        .ok_or_else(|| format!("'{name}' is unknown; write one of {}", known()))
}

/// Number of spheres of this kind of organ if the recipe gives none. The liver's is from the paper
/// (Table 1).
fn default_spheres(kind: OrganKind) -> usize {
    let row = KINDS.iter().find(|(_, k, _)| *k == kind);
    row.map_or(240, |(_, _, spheres)| *spheres)
}

/// Packing of this kind of organ if the recipe names none. Tubes are packed along their centre
/// line.
fn default_packing(kind: OrganKind) -> Packing {
    use OrganKind::{BileDuct, CysticArtery, CysticDuct, Vessel};
    match kind {
        CysticDuct | CysticArtery | BileDuct | Vessel => Packing::Line,
        _ => Packing::Even,
    }
}

/// Text to which errors refer, and the name of its file.
struct Source<'a> {
    text: &'a str,
    file: &'a str,
}

impl Source<'_> {
    fn error(&self, path: &[Step<'_>], problem: impl Into<String>) -> RecipeError {
        let mut key = String::new();
        for step in path {
            match step {
                Step::Key(name) if key.is_empty() => key.push_str(name),
                Step::Key(name) => {
                    key.push('.');
                    key.push_str(name);
                }
                Step::Index(index) => key.push_str(&format!("[{index}]")),
            }
        }
        RecipeError {
            file: self.file.into(),
            line: line_of_path(self.text, path),
            key,
            problem: problem.into(),
        }
    }

    fn number(
        &self,
        path: &[Step<'_>],
        value: f64,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f64, RecipeError> {
        if range.contains(&value) {
            return Ok(value);
        }
        let problem = format!("is {value}; allowed: {} to {}", range.start(), range.end());
        Err(self.error(path, problem))
    }

    fn point(&self, path: &[Step<'_>], value: [f64; 3]) -> Result<Vec3, RecipeError> {
        if value.iter().all(|x| x.abs() <= 10.0) {
            return Ok(Vec3::from(value));
        }
        let problem = format!(
            "is {value:?} m; allowed: coordinates of -10 to 10; are these millimetres? Write metres"
        );
        Err(self.error(path, problem))
    }

    fn direction(&self, path: &[Step<'_>], value: [f64; 3]) -> Result<Vec3, RecipeError> {
        let vector = Vec3::from(value);
        vector
            .try_normalize(1e-9)
            .filter(|v| v.iter().all(|x| x.is_finite()))
            .ok_or_else(|| self.error(path, format!("is {value:?}; a direction needs a length")))
    }
}

pub(super) fn check(text: &str, file: &str, meshes_dir: &Path) -> Result<Recipe, RecipeError> {
    let place = Source { text, file };
    let raw: RecipeRaw = toml::from_str(text).map_err(|error| RecipeError {
        file: file.into(),
        line: error
            .span()
            .map_or(1, |span| line_of_offset(text, span.start)),
        key: "recipe".into(),
        problem: error.message().replace('\n', " "),
    })?;
    name_is_usable(&raw.name, 63).map_err(|problem| place.error(&[Step::Key("name")], problem))?;
    if raw.organ.is_empty() || raw.organ.len() > ORGANS_MAX {
        let problem = format!(
            "has {} organs; allowed: 1 to {ORGANS_MAX}; write a table [[organ]] for each",
            raw.organ.len()
        );
        return Err(place.error(&[Step::Key("organ")], problem));
    }
    let names: Vec<String> = raw.organ.iter().map(|organ| organ.name.clone()).collect();
    let mut organs = Vec::new();
    check_anatomy(&place, &raw.anatomy)?;
    for (index, organ) in raw.organ.into_iter().enumerate() {
        let organ = check_organ(&place, index, organ, &names, meshes_dir, raw.anatomy)?;
        organs.push(organ);
    }
    let tick_us = raw
        .tick_us
        .map(|us| place.number(&[Step::Key("tick_us")], us, TICK_US));
    let total: usize = organs.iter().map(|organ| organ.spheres).sum();
    if total > SPHERES_MAX {
        let problem =
            format!("organs have {total} spheres together; allowed: at most {SPHERES_MAX}");
        return Err(place.error(&[Step::Key("organ")], problem));
    }
    let mut ties = check_ties(&place, "suture", &raw.suture, &names)?;
    ties.extend(check_ties(&place, "band", &raw.band, &names)?);
    let stones = raw.stones.as_ref();
    Ok(Recipe {
        name: raw.name,
        tick_us: tick_us.transpose()?,
        room: check_room(&place, &raw.room, &names)?,
        organs,
        ties,
        stones: stones.map(|raw| check_stones(&place, raw)).transpose()?,
    })
}

fn check_ties(
    place: &Source<'_>,
    key: &'static str,
    ties: &[TieRaw],
    names: &[String],
) -> Result<Vec<Tie>, RecipeError> {
    let mut checked = Vec::new();
    for (index, raw) in ties.iter().enumerate() {
        let at = |name: &'static str| [Step::Key(key), Step::Index(index), Step::Key(name)];
        for (name, end) in [("from", &raw.from), ("to", &raw.to)] {
            match end {
                Place::World { .. } if name == "from" => {
                    let problem =
                        "starts at a point of the world; write from = { organ = …, near_m = … }";
                    return Err(place.error(&at(name), problem));
                }
                Place::World { world_m } => place.point(&at(name), *world_m)?,
                Place::Organ { organ, .. } if !names.contains(organ) => {
                    let problem = format!("'{organ}' is not an organ of this recipe");
                    return Err(place.error(&at(name), problem));
                }
                Place::Organ { near_m, .. } => place.point(&at(name), *near_m)?,
            };
        }
        let number = |name: &'static str, value: Option<f64>, min: f64, max: f64| {
            let checked = value.map(|value| place.number(&at(name), value, min..=max));
            checked.transpose()
        };
        checked.push(Tie {
            from: raw.from.clone(),
            to: raw.to.clone(),
            length_m: number("length_mm", raw.length_mm, 0.0, 1000.0)?.map(|mm| 1e-3 * mm),
            drawn_m: number("drawn_mm", raw.drawn_mm, 0.0, 50.0)?.map_or(0.0, |mm| 1e-3 * mm),
            stiffness_n_m: number("stiffness_n_m", raw.stiffness_n_m, 0.1, 1e6)?,
            is_thread: key == "suture",
        });
    }
    Ok(checked)
}

fn check_anatomy(place: &Source<'_>, anatomy: &Anatomy) -> Result<(), RecipeError> {
    for (organ, build) in anatomy.builds() {
        let path = |key| [Step::Key("anatomy"), Step::Key(organ), Step::Key(key)];
        place.number(&path("size"), build.size, 0.7..=1.4)?;
        place.number(&path("width"), build.width, 0.5..=2.0)?;
        for mm in build.shift_mm {
            place.number(&path("shift_mm"), mm, -30.0..=30.0)?;
        }
    }
    let path = |key| [Step::Key("anatomy"), Step::Key(key)];
    place.number(&path("cover_mm"), anatomy.cover_mm, 0.0..=8.0)?;
    place.number(&path("adhesion_mm"), anatomy.adhesion_mm, 0.0..=25.0)?;
    Ok(())
}

fn check_organ(
    place: &Source<'_>,
    index: usize,
    raw: OrganRaw,
    names: &[String],
    meshes_dir: &Path,
    anatomy: Anatomy,
) -> Result<OrganPlan, RecipeError> {
    let at = |key: &'static str| [Step::Key("organ"), Step::Index(index), Step::Key(key)];
    name_is_usable(&raw.name, 31).map_err(|problem| place.error(&at("name"), problem))?;
    if names[..index].contains(&raw.name) {
        let problem = format!("'{}' is used twice; names must differ", raw.name);
        return Err(place.error(&at("name"), problem));
    }
    let kind = organ_kind(&raw.kind).map_err(|problem| place.error(&at("kind"), problem))?;
    let unit_m = raw.unit.unwrap_or(Unit::Metre).metres();
    let scale = place.number(&at("scale"), raw.scale.unwrap_or(1.0), 1e-3..=1e3)?;
    let surface = match (raw.mesh, raw.shape) {
        (Some(mesh), None) => Surface::Mesh {
            path: meshes_dir.join(mesh),
            parts: raw.parts,
            unit_m: Some(unit_m * scale),
            axes: raw.axes,
        },
        (None, Some(table)) => {
            let shape = Shape::from_table(table, anatomy);
            let shape = shape.map_err(|problem| place.error(&at("shape"), problem))?;
            Surface::Shape(Box::new(shape))
        }
        _ => {
            let problem = "needs either `mesh = \"FILE\"` or `shape = { … }`, and not both";
            return Err(place.error(&at("name"), problem));
        }
    };
    let spheres = raw.spheres.unwrap_or_else(|| default_spheres(kind));
    if !(SPHERES_MIN..=SPHERES_MAX).contains(&spheres) {
        let problem = format!("is {spheres}; allowed: {SPHERES_MIN} to {SPHERES_MAX}");
        return Err(place.error(&at("spheres"), problem));
    }
    let gap_95_m = raw
        .gap_95_mm
        .map(|mm| place.number(&at("gap_95_mm"), mm, 0.05..=50.0));
    let gap_95_m = gap_95_m.transpose()?.map(|mm| 1e-3 * mm);
    let share = raw.gravity_share.unwrap_or(0.0);
    let gravity_share = place.number(&at("gravity_share"), share, 0.0..=1.0)?;
    let breath_mm = raw.breath_mm.unwrap_or_default();
    for mm in breath_mm {
        place.number(&at("breath_mm"), mm, -100.0..=100.0)?;
    }
    for (i, region) in raw.held.iter().enumerate() {
        let path = [at("held")[0], at("held")[1], at("held")[2], Step::Index(i)];
        check_region(place, &path, region, &raw.name, names)?;
    }
    for (i, attached) in raw.attached.iter().enumerate() {
        let [organ, index, key] = at("attached");
        let path = [organ, index, key, Step::Index(i)];
        if attached.to == raw.name || !names.contains(&attached.to) {
            let problem = format!("'{}' is not another organ of this recipe", attached.to);
            return Err(place.error(&path, problem));
        }
        place.number(&path, attached.within_m, 0.0..=0.1)?;
    }
    if let Some(layers) = &raw.layers {
        if layers.around == raw.name || !names.contains(&layers.around) {
            let problem = format!("'{}' is not another organ of this recipe", layers.around);
            return Err(place.error(&at("layers"), problem));
        }
        place.number(&at("layers"), layers.count as f64, 1.0..=32.0)?;
        place.number(&at("layers"), layers.cell_m, 0.000_3..=0.02)?;
    }
    Ok(OrganPlan {
        material: check_material(place, index, kind, &raw.material)?,
        name: raw.name,
        kind,
        surface,
        closing: raw.closing.unwrap_or(Closing::Auto),
        pieces: raw.pieces.unwrap_or_default(),
        spheres,
        gap_95_m,
        coarser: check_coarser(place, &at("coarser"), raw.coarser)?,
        gravity_share,
        breath_m: Vec3::from(breath_mm) * 1e-3,
        packing: raw.packing.unwrap_or_else(|| default_packing(kind)),
        held: raw.held,
        attached: raw.attached,
        layers: raw.layers,
    })
}

fn check_coarser(
    place: &Source<'_>,
    path: &[Step<'_>],
    counts: Vec<usize>,
) -> Result<Vec<usize>, RecipeError> {
    let most = shared_mem::scene::LEVELS_MAX - 1;
    let falls = counts.windows(2).all(|pair| pair[0] > pair[1]);
    let in_range = |count: &usize| (SPHERES_MIN..=SPHERES_MAX).contains(count);
    if counts.len() <= most && falls && counts.iter().all(in_range) {
        return Ok(counts);
    }
    let problem = format!(
        "is {counts:?}; allowed: at most {most} counts of {SPHERES_MIN} to {SPHERES_MAX} \
         spheres, each below the one before"
    );
    Err(place.error(path, problem))
}

fn check_region(
    place: &Source<'_>,
    path: &[Step<'_>],
    region: &Region,
    own_name: &str,
    names: &[String],
) -> Result<(), RecipeError> {
    match region {
        Region::Box { min_m, max_m } => {
            let (min, max) = (place.point(path, *min_m)?, place.point(path, *max_m)?);
            if (0..3).any(|k| min[k] >= max[k]) {
                return Err(place.error(path, "is an empty box; min_m must be below max_m"));
            }
        }
        Region::Plane { point_m, normal } => {
            place.point(path, *point_m)?;
            place.direction(path, *normal)?;
        }
        Region::Ball { center_m, radius_m } => {
            place.point(path, *center_m)?;
            place.number(path, *radius_m, 1e-4..=1.0)?;
        }
        Region::Near { organ, within_m } => {
            if organ == own_name || !names.contains(organ) {
                let problem = format!("'{organ}' is not another organ of this recipe");
                return Err(place.error(path, problem));
            }
            place.number(path, *within_m, 0.0..=0.1)?;
        }
        Region::Base(share) => {
            place.number(path, *share, 0.0..=1.0)?;
        }
    }
    Ok(())
}

fn check_material(
    place: &Source<'_>,
    organ: usize,
    kind: OrganKind,
    raw: &MaterialRaw,
) -> Result<Material, RecipeError> {
    let mut material = Material::typical(kind);
    let fields: [(&'static str, Option<f64>, &mut f64, f64, f64); 10] = [
        (
            "density_kg_m3",
            raw.density_kg_m3,
            &mut material.density_kg_m3,
            100.0,
            5000.0,
        ),
        ("young_pa", raw.young_pa, &mut material.young_pa, 10.0, 1e8),
        ("poisson", raw.poisson, &mut material.poisson, 0.0, 0.499),
        (
            "stretch_stiffness",
            raw.stretch_stiffness,
            &mut material.stretch_stiffness,
            0.0,
            1.0,
        ),
        (
            "laplacian_stiffness",
            raw.laplacian_stiffness,
            &mut material.laplacian_stiffness,
            0.0,
            1.0,
        ),
        (
            "damping_per_s",
            raw.damping_per_s,
            &mut material.damping_per_s,
            0.0,
            1000.0,
        ),
        (
            "retardation_s",
            raw.retardation_s,
            &mut material.retardation_s,
            0.0,
            1.0,
        ),
        (
            "contact_stiffness_n_m",
            raw.contact_stiffness_n_m,
            &mut material.contact_stiffness_n_m,
            0.0,
            10_000.0,
        ),
        ("friction", raw.friction, &mut material.friction, 0.0, 2.0),
        (
            "toughness_j_m2",
            raw.toughness_j_m2,
            &mut material.toughness_j_m2,
            0.0,
            1e6,
        ),
    ];
    for (key, given, value, min, max) in fields {
        if let Some(given) = given {
            let path = [
                Step::Key("organ"),
                Step::Index(organ),
                Step::Key("material"),
                Step::Key(key),
            ];
            *value = place.number(&path, given, min..=max)?;
        }
    }
    Ok(material)
}

fn check_room(
    place: &Source<'_>,
    raw: &RoomRaw,
    names: &[String],
) -> Result<RoomPlan, RecipeError> {
    let at = |key: &'static str| [Step::Key("room"), Step::Key(key)];
    let point = |key: &'static str, value: Option<[f64; 3]>| {
        value.map(|value| place.point(&at(key), value)).transpose()
    };
    let number = |key: &'static str, value: Option<f64>, min: f64, max: f64| {
        value
            .map(|value| place.number(&at(key), value, min..=max))
            .transpose()
    };
    let frame = |key: &'static str, value: &Option<FrameRaw>| {
        let Some(raw) = value else { return Ok(None) };
        let position_m = place.point(&at(key), raw.position_m)?;
        let length = raw.orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(0.99..=1.01).contains(&length) {
            let problem = format!("orientation has length {length}; a rotation needs length 1");
            return Err(place.error(&at(key), problem));
        }
        Ok(Some(Frame {
            position_m,
            orientation: raw.orientation.map(|x| x / length),
        }))
    };
    let mut target_organ = None;
    let mut target_near_m = None;
    if let Some(target) = &raw.target {
        target_organ = names.iter().position(|name| *name == target.organ);
        if target_organ.is_none() {
            let problem = format!("'{}' is not an organ of this recipe", target.organ);
            return Err(place.error(&at("target"), problem));
        }
        target_near_m = point("target", target.near_m)?;
    }
    Ok(RoomPlan {
        gravity_m_s2: raw
            .gravity_m_s2
            .map(|g| {
                let value = Vec3::from(g);
                place
                    .number(&at("gravity_m_s2"), value.norm(), 0.0..=20.0)
                    .map(|_| value)
            })
            .transpose()?,
        instrument_port_m: point("instrument_port_m", raw.instrument_port_m)?,
        instrument_length_m: number("instrument_length_m", raw.instrument_length_m, 0.1, 0.6)?,
        endoscope_port_m: point("endoscope_port_m", raw.endoscope_port_m)?,
        look_at_m: point("look_at_m", raw.look_at_m)?,
        breath_s: number("breath_s", raw.breath_s, 0.0, 60.0)?,
        trocar: raw
            .trocar
            .as_ref()
            .map(|raw| check_trocar(place, raw))
            .transpose()?,
        camera_distance_m: number("camera_distance_m", raw.camera_distance_m, 0.02, 0.5)?,
        up: raw
            .up
            .map(|up| place.direction(&at("up"), up))
            .transpose()?,
        device: frame("device", &raw.device)?,
        tracker: frame("tracker", &raw.tracker)?,
        target_organ,
        target_near_m,
    })
}

fn check_stones(place: &Source<'_>, raw: &StonesRaw) -> Result<StonesPlan, RecipeError> {
    let number = |key: &'static str, value: f64, least: f64, most: f64| {
        place.number(&[Step::Key("stones"), Step::Key(key)], value, least..=most)
    };
    number("count", raw.count.into(), 1.0, MAX_STONES as f64)?;
    Ok(StonesPlan {
        count: raw.count,
        diameter_m: 1e-3 * number("diameter_mm", raw.diameter_mm, 1.0, 50.0)?,
        room_m3: 1e-6 * number("room_ml", raw.room_ml, 1.0, 1000.0)?,
    })
}

fn check_trocar(place: &Source<'_>, raw: &TrocarRaw) -> Result<TrocarPlan, RecipeError> {
    let number = |key: &'static str, value: f64, least: f64, most: f32| {
        let at = [Step::Key("room"), Step::Key("trocar"), Step::Key(key)];
        place.number(&at, value, least..=most.into())
    };
    let sliding_n = number("sliding_n", raw.sliding_n, 0.0, TROCAR_FRICTION_MAX_N)?;
    let breakaway_n = raw.breakaway_n.unwrap_or(sliding_n);
    Ok(TrocarPlan {
        sliding_n,
        breakaway_n: number("breakaway_n", breakaway_n, sliding_n, TROCAR_FRICTION_MAX_N)?,
        wall_nm_rad: number("wall_nm_rad", raw.wall_nm_rad, 0.0, TROCAR_WALL_MAX_NM_RAD)?,
    })
}

fn name_is_usable(name: &str, bytes_max: usize) -> Result<(), String> {
    if name.is_empty() || name.len() > bytes_max || name.chars().any(char::is_control) {
        return Err(format!(
            "'{name}' must have 1 to {bytes_max} bytes and no control characters"
        ));
    }
    Ok(())
}

pub(super) fn from_mesh(path: &Path, options: &MeshOptions) -> Result<Recipe, RecipeError> {
    let stem = path
        .file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or("mesh");
    let mut name: String = stem.chars().filter(|c| !c.is_control()).collect();
    while name.len() > 31 {
        name.pop();
    }
    if name.is_empty() {
        return Err(RecipeError {
            file: path.display().to_string(),
            line: 0,
            key: "name".into(),
            problem: "the mesh's file name has no usable characters; rename the file".into(),
        });
    }
    let kind = options.kind;
    // If there is a scale but no unit, the unit is not guessed: it is the metre.
    let is_scaled = options.scale.to_bits() != 1f64.to_bits();
    let unit = options.unit.or(is_scaled.then_some(Unit::Metre));
    Ok(Recipe {
        name: name.clone(),
        tick_us: None,
        room: RoomPlan::default(),
        organs: vec![OrganPlan {
            name,
            kind,
            surface: Surface::Mesh {
                path: path.into(),
                parts: options.parts.clone(),
                unit_m: unit.map(|unit| unit.metres() * options.scale),
                axes: options.axes,
            },
            closing: options.closing,
            pieces: options.pieces,
            spheres: default_spheres(kind),
            gap_95_m: None,
            coarser: Vec::new(),
            gravity_share: 0.0,
            breath_m: Vec3::zeros(),
            packing: Packing::Even,
            material: Material::typical(kind),
            held: vec![Region::Base(0.15)],
            attached: Vec::new(),
            layers: None,
        }],
        ties: Vec::new(),
        stones: None,
    })
}
