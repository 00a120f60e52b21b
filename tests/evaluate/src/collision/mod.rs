//! `evaluate collision`, the paper's experiment 2: compares six ways (methods) to find contacts of
//! the instruments.

mod gpu;
mod methods;
mod motion;
mod page;

use std::hint::black_box;
use std::time::Instant;

use methods::{Exact, Found, Hierarchy, Octree, Skinning, V3};
use nalgebra::Vector3;
use rt_core::tool::Capsule;
use scene_prepare::mesh::Mesh;
use scene_prepare::shape::{Form, Shape};

use crate::body::Tissue;
use crate::methods::{Parts, Surroundings};
use crate::prepared::prepared;

pub(crate) use page::{chart, section};

/// A way to find contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// Calot's way: near spheres, then the contact skin.
    Ours,
    /// The paper's kernel on one thread of the CPU.
    Spheres,
    /// The paper's kernel on a graphics card. Each tick sends the spheres and reads their depths
    /// back.
    Card,
    /// Mesh vertices against the parts.
    Vertices,
    /// An octree over the faces.
    Octree,
    /// parry's bounding volumes over the faces.
    Parry,
}

impl Way {
    const ALL: [Self; 6] = [
        Self::Ours,
        Self::Spheres,
        Self::Card,
        Self::Vertices,
        Self::Octree,
        Self::Parry,
    ];

    /// Name of the way in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ours => "Calot, CPU",
            Self::Spheres => "inner spheres, CPU",
            Self::Card => "inner spheres, GPU (paper)",
            Self::Vertices => "mesh vertices",
            Self::Octree => "surface octree",
            Self::Parry => "parry BVH",
        }
    }
}

/// Results of one way on one organ at one size.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Name of the organ; "balls" for the sweep of the paper's kernel alone.
    pub(crate) organ: &'static str,
    /// Faces of its mesh.
    pub(crate) faces: usize,
    /// Number of spheres.
    pub(crate) spheres: usize,
    /// The way.
    pub(crate) way: Way,
    /// Time of a tick, median and 99th percentile, µs.
    pub(crate) us: [f64; 2],
    /// Median time to follow a moving organ, µs a tick: to move its mesh with the spheres, and to
    /// update the structure that is built over the mesh. 0 for ways without a mesh.
    pub(crate) follow_us: f64,
    /// Precision: share of the reported touches that are true. Recall: share of the true touches
    /// that are reported.
    pub(crate) precision_recall: [f64; 2],
    /// Root mean square error of the depth, over ticks with a true touch that is reported, mm.
    pub(crate) depth_error_mm: f64,
}

impl Row {
    /// Time of a tick in which the organ moves, µs.
    pub(crate) fn tick_us(&self) -> f64 {
        self.us[0] + self.follow_us
    }
}

/// Measurements.
pub(crate) struct Measured {
    /// Every way on every organ.
    pub(crate) rows: Vec<Row>,
    /// Name of the graphics card, or the reason why there is none.
    pub(crate) card: Result<String, String>,
}

/// The paper's organs with its numbers of spheres (Table 1).
const ORGANS: [(&str, Form, usize); 4] = [
    ("liver", Form::Liver, 581),
    ("gallbladder", Form::Gallbladder, 475),
    ("intestine", Form::Intestine, 383),
    ("stomach", Form::Stomach, 452),
];
/// Multiples of the paper's number of spheres. From one to the next, every face is cut into four.
const SIZES: [usize; 2] = [1, 4];
/// Number of timed updates of a structure. Their median is reported.
const FOLLOWED: usize = 21;
/// Numbers of balls with which the paper's kernel is timed alone.
const BALLS: [usize; 5] = [500, 2000, 8000, 32_000, 128_000];

/// Measures all organs whose names contain `only`.
///
/// # Errors
/// The error gives the reason in words.
pub(crate) fn run(quick: bool, only: &str) -> Result<Measured, String> {
    let card = gpu::Card::open();
    let mut rows = Vec::new();
    let ticks = if quick { 200 } else { 1000 };
    for (name, form, spheres) in ORGANS.into_iter().filter(|o| o.0.contains(only)) {
        let mut mesh = Shape::from(form).mesh();
        let sizes = if quick { &SIZES[..1] } else { &SIZES[..] };
        for (i, &times) in sizes.iter().enumerate() {
            if i > 0 {
                mesh = cut(&mesh);
            }
            eprintln!(
                "{name}, {} faces, {} spheres …",
                mesh.triangles.len(),
                spheres * times
            );
            rows.extend(organ(
                name,
                &mesh,
                spheres * times,
                ticks,
                card.as_ref().ok(),
            )?);
        }
    }
    if "balls".contains(only) {
        let counts = if quick { &BALLS[..2] } else { &BALLS[..] };
        for &count in counts {
            rows.extend(sweep(count, ticks / 10, card.as_ref().ok())?);
        }
    }
    Ok(Measured {
        rows,
        card: card.map(|card| card.name),
    })
}

/// Cuts every face into four.
fn cut(mesh: &Mesh) -> Mesh {
    let mut vertices = mesh.vertices.clone();
    let mut middles = std::collections::HashMap::new();
    let mut triangles = Vec::with_capacity(4 * mesh.triangles.len());
    for &[a, b, c] in &mesh.triangles {
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                vertices.push((mesh.vertices[i as usize] + mesh.vertices[j as usize]) / 2.0);
                vertices.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    Mesh {
        vertices,
        triangles,
    }
}

fn organ(
    name: &'static str,
    mesh: &Mesh,
    count: usize,
    ticks: usize,
    card: Option<&gpu::Card>,
) -> Result<Vec<Row>, String> {
    let tissue = Tissue::LIVER;
    let (body, skin) = prepared(mesh, count, tissue, &[]).map_err(|e| format!("{name}: {e}"))?;
    let around = Surroundings::weightless(&tissue);
    let mut parts = Parts::new(&body, &around, None)
        .map_err(|e| e.to_string())?
        .with_skin(skin);
    let mut ours = parts.bare().map_err(|e| e.to_string())?;
    let spheres: Vec<(V3, f32)> = body
        .rest_m
        .iter()
        .copied()
        .zip(body.radius_m.iter().copied())
        .collect();
    let vertices: Vec<V3> = mesh.vertices.iter().map(|p| p.cast()).collect();
    let faces = || -> Vec<[V3; 3]> {
        let corners = |t: &[u32; 3]| t.map(|i| vertices[i as usize]);
        mesh.triangles.iter().map(corners).collect()
    };
    let none = || format!("{name} has no faces");
    let motion = motion::motion(mesh, ticks).ok_or_else(none)?;
    let exact = Exact::new(mesh).ok_or_else(none)?;
    let truth: Vec<Found> = motion.iter().map(|parts| exact.find(parts)).collect();
    let mut rows = Vec::new();
    let skinning = Skinning::new(&vertices, &spheres).ok_or_else(none)?;
    // The time to follow the spheres does not depend on how far they move.
    let moves = vec![V3::repeat(1e-4); spheres.len()];
    let mut moved = Vec::new();
    let skin_us = median_us(|| skinning.moved(&vertices, &moves, &mut moved));
    for way in Way::ALL {
        let mut follow_us = 0.0;
        let (found, us) = match way {
            Way::Ours => timed(&motion, |parts| Ok(ours.meet(parts)))?,
            Way::Spheres => timed(&motion, |parts| Ok(methods::spheres(&spheres, parts)))?,
            Way::Card => {
                let Some(card) = card else { continue };
                let there = card.load(&spheres);
                timed(&motion, |parts| card.find(&there, &spheres, parts))?
            }
            Way::Vertices => {
                follow_us = skin_us;
                timed(&motion, |parts| Ok(methods::vertices(&vertices, parts)))?
            }
            Way::Octree => {
                let tree = Octree::new(faces());
                // The tree's cells stay where they are, so moved faces need a new tree.
                follow_us = skin_us + median_us(|| drop(black_box(Octree::new(faces()))));
                timed(&motion, |parts| Ok(tree.find(parts)))?
            }
            Way::Parry => {
                let tree = Hierarchy::new(&vertices, &mesh.triangles).ok_or_else(none)?;
                let mut moving = Hierarchy::new(&vertices, &mesh.triangles).ok_or_else(none)?;
                follow_us = skin_us + median_us(|| moving.follow(&moved));
                timed(&motion, |parts| Ok(tree.find(parts)))?
            }
        };
        let (precision_recall, depth_error_mm) = agreement(&found, &truth);
        let row = Row {
            organ: name,
            faces: mesh.triangles.len(),
            spheres: spheres.len(),
            way,
            us,
            follow_us,
            precision_recall,
            depth_error_mm,
        };
        eprintln!("  {row:?}");
        rows.push(row);
    }
    Ok(rows)
}

/// Times the paper's kernel alone, on `count` balls in a cube, on the CPU and on the card.
fn sweep(count: usize, ticks: usize, card: Option<&gpu::Card>) -> Result<Vec<Row>, String> {
    let side = (count as f64).cbrt().ceil() as usize;
    let pitch = 0.2 / side as f32;
    let ball = |i: usize| {
        let at = [i % side, i / side % side, i / side / side].map(|k| k as f32 * pitch);
        (V3::from(at), 0.6 * pitch)
    };
    let balls: Vec<(V3, f32)> = (0..count).map(ball).collect();
    let cube = fem_reference::block(Vector3::zeros(), Vector3::repeat(0.2), [4; 3]);
    let mesh = Mesh {
        vertices: cube.nodes,
        triangles: cube.faces.iter().map(|f| [f[0], f[1], f[2]]).collect(),
    };
    let motion = motion::motion(&mesh, ticks).ok_or("a cube has faces")?;
    let mut rows = Vec::new();
    let mut add = |way, us| {
        let row = Row {
            organ: "balls",
            faces: 0,
            spheres: count,
            way,
            us,
            follow_us: 0.0,
            precision_recall: [1.0; 2],
            depth_error_mm: 0.0,
        };
        eprintln!("  {row:?}");
        rows.push(row);
    };
    let (on_cpu, us) = timed(&motion, |parts| Ok(methods::spheres(&balls, parts)))?;
    add(Way::Spheres, us);
    if let Some(card) = card {
        let there = card.load(&balls);
        let (on_card, us) = timed(&motion, |parts| card.find(&there, &balls, parts))?;
        add(Way::Card, us);
        let off = on_cpu.iter().zip(&on_card).map(|pair| match pair {
            (Some(a), Some(b)) => (a - b).abs(),
            (a, b) => a.or(*b).unwrap_or(0.0),
        });
        let off_m = off.fold(0.0, f32::max);
        if off_m > 1e-5 {
            return Err(format!(
                "the card's depth differs from the CPU's by {off_m} m at {count} balls; allowed: 0.00001 m"
            ));
        }
    }
    Ok(rows)
}

/// Result of a way in every tick, and its median time and 99th percentile, µs.
fn timed(
    motion: &[Vec<Capsule>],
    mut find: impl FnMut(&[Capsule]) -> Result<Found, String>,
) -> Result<(Vec<Found>, [f64; 2]), String> {
    let mut found = Vec::with_capacity(motion.len());
    let mut times = Vec::with_capacity(motion.len());
    for parts in motion {
        let start = Instant::now();
        let one = black_box(find(black_box(parts))?);
        times.push(start.elapsed().as_secs_f64() * 1e6);
        found.push(one);
    }
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    Ok((found, [at(0.5), at(0.99)]))
}

/// Median time of work that is the same each time, µs.
fn median_us(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..FOLLOWED)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[FOLLOWED / 2]
}

/// Precision, recall, and root mean square error of the depth, mm.
fn agreement(found: &[Found], truth: &[Found]) -> ([f64; 2], f64) {
    let share = |both: usize, all: usize| both as f64 / all.max(1) as f64;
    let pairs = || found.iter().zip(truth);
    let both = pairs().filter_map(|(f, t)| Some(f64::from((*f)? - (*t)?) * 1e3));
    let errors: Vec<f64> = both.collect();
    let claimed = found.iter().flatten().count();
    let real = truth.iter().flatten().count();
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    let rms_mm = (squares / errors.len().max(1) as f64).sqrt();
    (
        [share(errors.len(), claimed), share(errors.len(), real)],
        rms_mm,
    )
}

/// The rows as `collision.csv`.
pub(crate) fn csv(measured: &Measured) -> String {
    let mut text = "organ,faces,spheres,way,p50_us,p99_us,follow_us,precision,recall,\
                    depth_error_mm\n"
        .to_owned();
    for r in &measured.rows {
        let ([p50, p99], [precision, recall]) = (r.us, r.precision_recall);
        text += &format!(
            "{},{},{},\"{}\",{p50:.2},{p99:.2},{:.0},{precision:.4},{recall:.4},{:.3}\n",
            r.organ,
            r.faces,
            r.spheres,
            r.way.name(),
            r.follow_us,
            r.depth_error_mm
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agreement_counts_what_both_find() {
        let found = [Some(0.002), None, Some(0.001), None];
        let truth = [Some(0.001), Some(0.004), None, None];
        let ([precision, recall], rms_mm) = agreement(&found, &truth);
        assert!((precision - 0.5).abs() < 1e-9 && (recall - 0.5).abs() < 1e-9);
        assert!((rms_mm - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_cut_mesh_is_the_same_body() {
        let mesh = Shape::from(Form::Gallbladder).mesh();
        let fine = cut(&mesh);
        assert!(fine.is_closed() && fine.triangles.len() == 4 * mesh.triangles.len());
        assert!((fine.volume() / mesh.volume() - 1.0).abs() < 1e-9);
    }
}
