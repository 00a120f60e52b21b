//! Builds a compiled scene from a recipe.

use std::time::Instant;

use shared_mem::scene::{
    ContactVertexRecord, LinkRecord, NO_CONTACT_VERTEX, OrganKind, OrganRecord, SceneData,
    SphereRecord, TetraRecord, VertexRecord, name_from_str,
};

use crate::budget::{self, Count};
use crate::cells::{self, Cells, Regions};
use crate::elastic::{self, Elastic};
use crate::error::{MeshError, MeshProblem, PrepareError};
use crate::held::{Held, Plane};
use crate::mesh::{self, Mended, Mesh};
use crate::pack::{self, Ball, Interior, Quality};
use crate::prepared::Prepared;
use crate::recipe::{OrganPlan, Packing, Pieces, Recipe, Surface};
use crate::report::{OrganReport, Report};
use crate::skeleton::{Skeleton, interior, skeleton};
use crate::skin::ContactSkin;
use crate::tetra::{self, Tetra};
use crate::thin::{self, Thin};
use crate::{
    Vec3, attach, bind, bowl, cost, held, links, overlap, rest, room, runs, space, support, tube,
};

/// Progress of the preparation.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Current activity, such as `liver: packing 581 spheres`.
    pub doing: String,
    /// Share of the whole, 0..=1.
    pub done: f64,
}

/// One organ as built.
struct Organ {
    balls: Vec<Ball>,
    masses_kg: Vec<f64>,
    links: Vec<[u32; 2]>,
    elastic: Elastic,
    tets: Vec<Tetra>,
    thin: Option<Thin>,
    vertices: Vec<VertexRecord>,
    skin: ContactSkin,
    quality: Quality,
    because: String,
}

impl Organ {
    /// Makes the tissue between free and held spheres stiffer ([`Held::stiffer`]).
    fn weigh(&mut self, held: &Held) {
        for tet in &mut self.tets {
            tet.volume_m3 *= held.stiffer(&tet.spheres);
        }
        for (spheres, compliance_m_n) in &mut self.elastic.links {
            *compliance_m_n /= held.stiffer(spheres);
        }
    }
}

/// Builds the scene that the recipe describes.
///
/// # Errors
/// The error says what is wrong with which organ, mesh or entry, and the remedy.
pub fn prepare(
    recipe: &Recipe,
    progress: &mut dyn FnMut(Progress),
) -> Result<Prepared, PrepareError> {
    let start = Instant::now();
    let count = recipe.organs.len();
    // Surfaces take the first third of the progress; counting and packing spheres take the rest.
    let mut tell = |organ: usize, from: f64, to: f64, doing: String| {
        let done = from + (to - from) * organ as f64 / count as f64;
        progress(Progress { doing, done });
    };
    let mut surfaces: Vec<Skin> = Vec::new();
    let mut times = Vec::new();
    for (i, plan) in recipe.organs.iter().enumerate() {
        let begun = Instant::now();
        tell(i, 0.0, 0.35, format!("{}: surface", plan.name));
        surfaces.push(surface(plan)?);
        times.push(begun.elapsed());
    }
    let skins: Vec<Mesh> = surfaces.iter().map(|s| s.mended.mesh.clone()).collect();
    let mut layered = Vec::new();
    for (i, plan) in recipe.organs.iter().enumerate() {
        if plan.layers.is_some() {
            tell(i, 0.35, 0.35, format!("{}: cells", plan.name));
        }
        layered.push(cells_of(plan, &skins[i], &recipe.organs, &skins)?);
    }
    let mut counts = Vec::new();
    for (i, plan) in recipe.organs.iter().enumerate() {
        tell(i, 0.35, 0.5, format!("{}: how many spheres", plan.name));
        let planes = held::planes(plan, &skins[i], &gravity(recipe));
        counts.push(budget::by_error(plan, &surfaces[i].mended, &planes)?);
    }
    let mut packing = 0;
    let mut assemble = |counts: &[Count]| {
        packing += 1;
        let round = packing;
        let mut doing = |i: usize, plan: &OrganPlan| {
            let again = match round {
                1 => String::new(),
                _ => format!(", try {round}"),
            };
            let doing = format!(
                "{}: packing {} spheres{again}",
                plan.name, counts[i].spheres
            );
            tell(i, 0.5, 0.95, doing);
        };
        assemble(recipe, counts, &surfaces, (&skins, &layered), &mut doing)
    };
    let mut prepared = match recipe.tick_us {
        Some(tick_us) => budget::by_time(recipe, tick_us, &counts, &mut assemble)?,
        None => assemble(&counts)?,
    };
    let report = &mut prepared.report;
    report.overlaps = overlap::overlaps(&recipe.organs, &skins);
    for (organ, time) in report.organs.iter_mut().zip(times) {
        organ.build_s += time.as_secs_f64();
    }
    report.build_s = start.elapsed().as_secs_f64();
    progress(Progress {
        doing: "done".into(),
        done: 1.0,
    });
    Ok(prepared)
}

fn gravity(recipe: &Recipe) -> Vec3 {
    let asked = recipe.room.gravity_m_s2;
    asked.unwrap_or_else(room::default_gravity)
}

/// Packs every organ with its count of spheres, and makes one scene of the organs.
fn assemble(
    recipe: &Recipe,
    counts: &[Count],
    surfaces: &[Skin],
    (skins, layered): (&[Mesh], &[Cells]),
    doing: &mut dyn FnMut(usize, &OrganPlan),
) -> Result<Prepared, PrepareError> {
    let gravity = gravity(recipe);
    let mut scene = SceneData::default();
    let mut tetrahedra = Vec::new();
    let mut thin_parts = Vec::new();
    let mut report = Report {
        scene: recipe.name.clone(),
        ..Report::default()
    };
    for ((i, plan), count) in recipe.organs.iter().enumerate().zip(counts) {
        let begun = Instant::now();
        doing(i, plan);
        let first_sphere = scene.spheres.len() as u32;
        let planes = held::planes(plan, &skins[i], &gravity);
        let mut organ = build(plan, &surfaces[i].mended, count, &planes, first_sphere)?;
        check_balls(plan, &organ.balls)?;
        check_sheet(plan, &surfaces[i].mended, &organ)?;
        let held = held::held(
            plan,
            &skins[i],
            &organ.balls,
            &recipe.organs,
            skins,
            &gravity,
        )?;
        organ.weigh(&held);
        if plan.packing == Packing::Line {
            tube::choose_substeps(&mut organ.elastic, &organ.masses_kg, &held.spheres);
        }
        append(&mut scene, plan, &surfaces[i].mended, &organ, &held.spheres);
        report.organs.push(OrganReport {
            build_s: begun.elapsed().as_secs_f64(),
            ..figures(plan, &surfaces[i], &organ, &held.spheres)
        });
        let warning = |thin: &Thin| thin.warning(&plan.name, organ.balls.len());
        thin_parts.extend(organ.thin.as_ref().map(warning));
        tetrahedra.push(organ.tets);
    }
    let tied = attach::attach(&recipe.organs, skins, recipe.ties.len(), &mut scene)?;
    attach::sew(&recipe.ties, &recipe.organs, &mut scene)?;
    for (organ, tied) in report.organs.iter_mut().zip(tied) {
        organ.attached = tied;
    }
    let regions = Regions::new(&recipe.organs, skins);
    for (i, plan) in recipe.organs.iter().enumerate() {
        if let Some(layers) = &plan.layers {
            let own = (&layered[i], &skins[i]);
            cells::append(&mut scene, i, plan, own, &regions);
            report.organs[i].cells = Some(layered[i].filling(&skins[i], layers.cell_m));
        }
    }
    let (room, warning) = room::place(recipe, skins)?;
    let stones = recipe.stones.as_ref();
    scene.stones = stones.map(|plan| bowl::stones(plan, &room, &scene.spheres));
    scene.room = Some(room);
    scene.trocar = recipe.room.trocar.as_ref().map(room::trocar);
    // Refuse a scene here that the processes would refuse.
    scene.to_bytes()?;
    runs::check(&scene, &recipe.organs, skins)?;
    report.warnings = support::warnings(&scene, &recipe.organs);
    report
        .warnings
        .extend(rest::bear(&mut scene, &recipe.organs)?);
    report.warnings.extend(thin_parts);
    report.warnings.extend(warning);
    for (plan, skin) in recipe.organs.iter().zip(surfaces) {
        let filled = skin.mended.filled();
        report
            .warnings
            .extend(filled.map(|it| format!("'{}': {it}", plan.name)));
    }
    let sizes = recipe.organs.iter().zip(skins);
    report
        .warnings
        .extend(sizes.filter_map(|(plan, skin)| unusual_size(plan, skin)));
    report.sum_up();
    report.tick_us = cost::work(&scene).tick_us();
    Ok(Prepared {
        scene,
        report,
        tetrahedra,
    })
}

/// Refuses an organ with a sphere whose centre or radius is not usable.
fn check_balls(plan: &OrganPlan, balls: &[Ball]) -> Result<(), PrepareError> {
    let is_good = |ball: &Ball| {
        ball.center.iter().all(|x| x.is_finite())
            && ball.radius_m > 0.0
            && ball.radius_m.is_finite()
    };
    let Some(number) = balls.iter().position(|ball| !is_good(ball)) else {
        return Ok(());
    };
    Err(PrepareError::Organ {
        organ: plan.name.clone(),
        problem: format!(
            "has no room for sphere {number} of {}: its surface has no inside there; set `closing = \
             \"solid\"` or \"wrap\", or mend the mesh",
            balls.len()
        ),
    })
}

/// Refuses an organ that is so thin that it has no tetrahedra: nothing would keep its shape.
fn check_sheet(plan: &OrganPlan, mended: &Mended, organ: &Organ) -> Result<(), PrepareError> {
    let is_solid = matches!(plan.packing, Packing::Even | Packing::Paper) && plan.layers.is_none();
    if !is_solid || !organ.tets.is_empty() {
        return Ok(());
    }
    Err(PrepareError::Organ {
        organ: plan.name.clone(),
        problem: format!(
            "is a sheet of about {:.1} mm, so thin that its {} spheres make no tetrahedra; give it more spheres \
             (`spheres`, --spheres), or a thicker mesh",
            2e3 * mended.volume_m3 / mended.mesh.area(),
            organ.balls.len()
        ),
    })
}

/// The cells of an organ; empty if the organ has no layers.
fn cells_of(
    plan: &OrganPlan,
    own: &Mesh,
    organs: &[OrganPlan],
    skins: &[Mesh],
) -> Result<Cells, PrepareError> {
    let Some(layers) = &plan.layers else {
        return Ok(Cells::default());
    };
    let around = organs.iter().position(|organ| organ.name == layers.around);
    let cells = around.map(|i| Cells::new(own, &skins[i], layers));
    cells
        .filter(|cells| !cells.is_empty())
        .ok_or_else(|| PrepareError::Organ {
            organ: plan.name.clone(),
            problem: format!(
                "no cells of {:.1} mm fit between it and '{}'; give a smaller layers.cell_m",
                1e3 * layers.cell_m,
                layers.around
            ),
        })
}

/// An organ's skin.
struct Skin {
    mended: Mended,
    /// Origin of the mesh and the repairs made to it.
    story: String,
}

fn surface(plan: &OrganPlan) -> Result<Skin, PrepareError> {
    let (name, from, read) = match &plan.surface {
        Surface::Shape(shape) => (
            "built-in shape".to_owned(),
            "built-in shape".to_owned(),
            Ok(shape.mesh()),
        ),
        Surface::Mesh {
            path,
            parts,
            unit_m,
            axes,
        } => {
            let mut name = path.display().to_string();
            if !parts.is_empty() {
                name = format!("{name} [{}]", parts.join(", "));
            }
            let read = mesh::read(path, parts);
            let mut from = name.clone();
            let scaled = read.map(|mesh| {
                let (mut mesh, note) = in_metres(mesh, *unit_m);
                for p in &mut mesh.vertices {
                    *p = axes.in_scene(*p);
                }
                from.push_str(&note);
                from.push_str(&space::note(path, *axes));
                mesh
            });
            (name, from, scaled)
        }
    };
    let problem = |problem: MeshProblem| PrepareError::Mesh {
        organ: plan.name.clone(),
        source: MeshError {
            mesh: name.clone(),
            problem,
        },
    };
    // A shape is the surface of a distance function that is negative all through the organ.
    let mend = match plan.surface {
        Surface::Shape(_) => mesh::mend_body,
        Surface::Mesh { .. } => mesh::mend,
    };
    let mended = read
        .and_then(|mesh| mend(&mesh, plan.closing))
        .map_err(|found| problem(with_guessed_unit(&plan.surface, found)))?;
    let mended = match plan.pieces {
        Pieces::Largest => mended.largest_piece(),
        Pieces::Near | Pieces::Join => mended,
    };
    let gaps_m = mended.gaps_m();
    let gap_m = gaps_m.iter().copied().fold(0.0, f64::max);
    let spacing_m = libm::cbrt(mended.volume_m3 / plan.spheres as f64);
    let [x, y, z] = extents_m(&mended.mesh).map(|it| 1e3 * it);
    let mut story = format!("{from}; {x:.0} × {y:.0} × {z:.0} mm; {mended}");
    if !gaps_m.is_empty() {
        let (count, gap_mm) = (gaps_m.len() + 1, 1e3 * gap_m);
        if plan.pieces == Pieces::Near && gap_m > spacing_m {
            return Err(problem(MeshProblem::FarPieces { count, gap_mm }));
        }
        story.push_str(&format!(
            ", {count} separate pieces linked across up to {gap_mm:.1} mm"
        ));
    }
    Ok(Skin { mended, story })
}

/// Lengths of a mesh along the axes, m.
fn extents_m(mesh: &Mesh) -> [f64; 3] {
    let [min, max] = mesh.bounds();
    (max - min).into()
}

/// For each kind, limits of an organ's longest extent, m, rare cases included. Livers have 15 to 25
/// cm, in children from 8 cm, enlarged up to 35 cm. Gallbladders have 7 to 10 cm, contracted from 2
/// cm, distended up to 18 cm. Stomachs have 20 to 30 cm (Gray's Anatomy, 42nd edition).
const USUAL_M: [(OrganKind, f64, f64); 3] = [
    (OrganKind::Liver, 0.08, 0.40),
    (OrganKind::Gallbladder, 0.02, 0.18),
    (OrganKind::Stomach, 0.10, 0.45),
];

/// A warning if an organ from a mesh file is larger or smaller than its kind of organ usually is.
fn unusual_size(plan: &OrganPlan, mesh: &Mesh) -> Option<String> {
    if !matches!(plan.surface, Surface::Mesh { .. }) {
        return None;
    }
    let (_, least_m, most_m) = USUAL_M.iter().find(|(kind, ..)| *kind == plan.kind)?;
    let longest_m = extents_m(mesh).into_iter().fold(0.0, f64::max);
    (!(*least_m..=*most_m).contains(&longest_m)).then(|| {
        format!(
            "'{}' is {:.0} mm across, and organs of its kind are {:.0} to {:.0} mm: is the unit right? Give \
             --unit or --scale (in a recipe: unit, scale), or another kind",
            plan.name,
            1e3 * longest_m,
            1e3 * least_m,
            1e3 * most_m
        )
    })
}

/// If the unit was guessed, replaces the hint of an extent error by the rule of the guess.
fn with_guessed_unit(surface: &Surface, mut problem: MeshProblem) -> MeshProblem {
    let guessed = matches!(surface, Surface::Mesh { unit_m: None, .. });
    if let (true, MeshProblem::Extent { hint, .. }) = (guessed, &mut problem) {
        *hint = ", with its numbers taken for metres, or for millimetres if it would be more than 2 m across";
    }
    problem
}

/// Scales a mesh to metres. Without a unit the numbers are taken for metres, or for millimetres if
/// the mesh would be more than 2 m across. The returned note names a guessed unit.
fn in_metres(mut mesh: Mesh, unit_m: Option<f64>) -> (Mesh, String) {
    let [min, max] = mesh.bounds();
    let across = (max - min).max();
    let (scale, note) = match unit_m {
        Some(scale) => (scale, String::new()),
        None => {
            let (scale, unit) = if across > 2.0 {
                (1e-3, "millimetres")
            } else {
                (1.0, "metres")
            };
            let size = 1e3 * scale * across;
            let note = format!(" in {unit} as its size suggests: {size:.0} mm across");
            (scale, note)
        }
    };
    for p in &mut mesh.vertices {
        *p *= scale;
    }
    (mesh, note)
}

fn build(
    plan: &OrganPlan,
    surface: &Mended,
    count: &Count,
    planes: &[Plane],
    first_sphere: u32,
) -> Result<Organ, PrepareError> {
    let spheres = count.spheres;
    let interior = interior(plan, surface, spheres)?;
    let Skeleton {
        balls,
        links,
        steps,
        tets,
    } = skeleton(plan, &interior, surface.volume_m3, spheres, planes);
    let mass_kg = plan.material.density_kg_m3 * surface.volume_m3;
    // Layered tissue is cut into cells, and a tube is one sphere wide: neither has thin parts.
    let is_solid = !tets.is_empty() && plan.layers.is_none();
    let thin = is_solid.then(|| thin::thin(&interior));
    Ok(Organ {
        masses_kg: masses(&interior, &balls, mass_kg),
        vertices: bind::bind(&surface.mesh, &balls, first_sphere),
        // A tube, or a layer one sphere thick, has no tetrahedra and no contact skin. Tools collide
        // with its spheres, which are as thick as the organ. A skin that follows spheres in a line
        // or plane would fold, because it lies outside of that line or plane.
        skin: if tets.is_empty() {
            ContactSkin::default()
        } else {
            ContactSkin::new(
                &interior,
                &surface.mesh,
                &balls,
                &tets,
                plan.material.poisson,
            )
        },
        quality: Quality::measure(&interior, &surface.mesh, &balls),
        elastic: elastic::elastic(
            &balls,
            &links,
            &steps,
            &tets,
            surface.volume_m3,
            &plan.material,
        ),
        balls,
        links,
        tets,
        thin: thin.flatten(),
        because: count.because.clone(),
    })
}

/// Shares the organ's mass among its spheres by the volume that is nearest to each. Each sphere
/// gets at least about a twentieth of the mean mass, so that no sphere is too light for a solver.
fn masses(interior: &Interior<'_>, balls: &[Ball], total_kg: f64) -> Vec<f64> {
    let centers: Vec<_> = balls.iter().map(|b| b.center).collect();
    let mut shares = vec![0.05 * interior.points.len() as f64 / balls.len() as f64; balls.len()];
    for owner in pack::owners(interior, &centers) {
        shares[owner as usize] += 1.0;
    }
    let sum: f64 = shares.iter().sum();
    shares
        .into_iter()
        .map(|share| total_kg * share / sum)
        .collect()
}

fn figures(plan: &OrganPlan, skin: &Skin, organ: &Organ, held: &[bool]) -> OrganReport {
    let surface = &skin.mended;
    let count = organ.balls.len();
    let mut degree = vec![0; count];
    for &i in organ.links.as_flattened() {
        degree[i as usize] += 1;
    }
    let quality = &organ.quality;
    OrganReport {
        name: plan.name.clone(),
        mesh: skin.story.clone(),
        vertices: surface.mesh.vertices.len(),
        triangles: surface.mesh.triangles.len(),
        build_s: 0.0,
        spheres: count,
        spheres_because: organ.because.clone(),
        held: held.iter().filter(|held| **held).count(),
        attached: 0,
        cells: None,
        is_tube: plan.packing == Packing::Line,
        springs: organ.links.len(),
        tetrahedra: organ.tets.len(),
        tetra_shape_min: worst_shape(organ),
        substeps: organ.elastic.substeps,
        stiffness_number: organ.elastic.stiffness_number,
        skin_cm2: 1e4 * surface.mesh.area(),
        coverage: quality.coverage,
        gap_mean_mm: 1e3 * quality.gap_mean_m,
        gap_95_mm: 1e3 * quality.gap_95_m,
        gap_max_mm: 1e3 * quality.gap_max_m,
        protrusion_max_mm: 1e3 * quality.protrusion_max_m,
        components: links::pieces(&organ.links, count).1,
        min_degree: degree.into_iter().min().unwrap_or(0),
        isotropy: pack::isotropy(&organ.balls, &organ.links),
        volume_ml: 1e6 * surface.volume_m3,
        mass_g: 1e3 * organ.masses_kg.iter().sum::<f64>(),
    }
}

fn worst_shape(organ: &Organ) -> Option<f64> {
    let centers: Vec<_> = organ.balls.iter().map(|b| b.center).collect();
    let shapes = organ
        .tets
        .iter()
        .map(|t| tetra::shape(&centers, &t.spheres));
    shapes.reduce(f64::min)
}

fn append(scene: &mut SceneData, plan: &OrganPlan, surface: &Mended, organ: &Organ, held: &[bool]) {
    let range = |first: usize, count: usize| [first as u32, count as u32];
    let (first_sphere, first_vertex) = (scene.spheres.len() as u32, scene.vertices.len() as u32);
    scene.organs.push(OrganRecord {
        name: name_from_str(&plan.name),
        kind: plan.kind as u32,
        spheres: range(scene.spheres.len(), organ.balls.len()),
        links: range(scene.links.len(), organ.links.len()),
        vertices: range(scene.vertices.len(), organ.vertices.len()),
        triangles: range(scene.triangles.len(), surface.mesh.triangles.len()),
        tetrahedra: range(scene.tetrahedra.len(), organ.tets.len()),
        elastic_links: organ.elastic.count as u32,
        substeps: organ.elastic.substeps,
        gravity_share: plan.gravity_share as f32,
        breath_m: plan.breath_m.map(|x| x as f32).into(),
        volume_m3: surface.volume_m3 as f32,
        material: plan.material.to_record(),
    });
    for (i, b) in organ.balls.iter().enumerate() {
        scene.spheres.push(SphereRecord {
            center_m: b.center.map(|x| x as f32).into(),
            radius_m: b.radius_m as f32,
            mass_kg: organ.masses_kg[i] as f32,
            held: u32::from(held[i]),
        });
    }
    for &([a, b], compliance_m_n) in &organ.elastic.links {
        let length = (organ.balls[a as usize].center - organ.balls[b as usize].center).norm();
        scene.links.push(LinkRecord {
            a: a + first_sphere,
            b: b + first_sphere,
            rest_length_m: length as f32,
            compliance_m_n: compliance_m_n as f32,
        });
    }
    scene
        .tetrahedra
        .extend(organ.tets.iter().map(|t| TetraRecord {
            spheres: t.spheres.map(|i| (i + first_sphere) as u16),
            volume_m3: t.volume_m3 as f32,
        }));
    scene.vertices.extend_from_slice(&organ.vertices);
    let shifted = surface
        .mesh
        .triangles
        .iter()
        .map(|t| t.map(|i| i + first_vertex));
    scene.triangles.extend(shifted);
    append_skin(scene, &organ.skin, first_sphere, organ.balls.len());
}

fn append_skin(scene: &mut SceneData, skin: &ContactSkin, first_sphere: u32, spheres: usize) {
    let first_vertex = scene.contact_vertices.len();
    let first_fan = scene.contact_fans.len() as u32;
    // The cast wraps only in scenes that the scene's check refuses for their number of vertices.
    let shifted = |vertex: u16| (first_vertex + usize::from(vertex)) as u16;
    scene
        .contact_vertices
        .extend(skin.vertices.iter().map(|v| ContactVertexRecord {
            spheres: v.spheres.map(|i| (u32::from(i) + first_sphere) as u16),
            weights: v.weights,
            fan: [v.fan_start + first_fan, v.fan_count],
            patch_m: v.patch_m,
            curvature_per_m: v.curvature_per_m,
        }));
    let fans = skin.fans.iter().map(|corners| corners.map(shifted));
    scene.contact_fans.extend(fans);
    let mut nearest = vec![NO_CONTACT_VERTEX; spheres];
    for (to, from) in nearest.iter_mut().zip(&skin.nearest) {
        // If `NO_CONTACT_VERTEX` were shifted, it would name a vertex of another organ.
        if *from != NO_CONTACT_VERTEX {
            *to = shifted(*from);
        }
    }
    scene.contact_nearest.extend(nearest);
}
