//! Compares skinning methods: error against a known deformation, and time. `cargo run --release -p
//! display-host --example skinning -- SCENE.calot [--out DIR]` prints a table and writes
//! `skinning.csv` and `skinning.svg`. `calot prepare built-in --out SCENE.calot` makes a scene.
//!
//! The spheres and the skin of every organ undergo a bend and a twist of 90° along the organ's
//! longest side, a dent, and an affine stretch. The error is the distance between the skin that the
//! spheres move and the skin that undergoes the deformation itself. `noise` moves each sphere at
//! random by up to 0.2 mm along each axis. The skin should move no farther than that.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use display_host::skinning::motion::{Follow, Motion, Motions};
use glam::{DMat4, DVec3, DVec4, Mat3, Vec3};
use plotters::prelude::*;
use shared_mem::message::SphereState;
use shared_mem::scene::{BINDINGS, SceneFile, WEIGHT_SUM};

type Error = Box<dyn std::error::Error>;

/// The spheres that move a vertex, and their weights.
type Binding = [(u16, f32); BINDINGS];

struct Row {
    organ: String,
    deformation: &'static str,
    method: &'static str,
    rms_mm: f64,
    p99_mm: f64,
    max_mm: f64,
    /// Time to skin the whole scene once, µs.
    frame_us: f64,
}

const FOLLOWS: [Follow; 3] = [Follow::Shift, Follow::Turn, Follow::Deform];
const METHODS: [[&str; 3]; 2] = [
    ["Gauss, shift (Eq. 9-12)", "Gauss, turn", "Gauss, deform"],
    [
        "linear precision",
        "linear precision, turn",
        "linear precision, deform",
    ],
];
const DEFORMATIONS: [&str; 5] = ["bend 90°", "twist 90°", "dent", "stretch", "noise"];

fn main() -> Result<(), Error> {
    let (mut scene, mut out) = (None, PathBuf::from("."));
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--out" => out = arguments.next().ok_or("--out needs a folder")?.into(),
            _ => scene = Some(PathBuf::from(argument)),
        }
    }
    let scene = scene.ok_or("name a compiled scene: `calot prepare built-in --out x.calot`")?;
    let scene = SceneFile::open(&scene)?;
    let rows = measure(&scene);
    println!(
        "{:<14}{:<11}{:<26}{:>9}{:>9}{:>9}{:>10}",
        "organ", "", "method", "rms mm", "99 % mm", "max mm", "frame µs"
    );
    let mut csv = "organ,deformation,method,rms_mm,p99_mm,max_mm,frame_us\n".to_owned();
    for r in &rows {
        println!(
            "{:<14}{:<11}{:<26}{:>9.3}{:>9.3}{:>9.3}{:>10.0}",
            r.organ, r.deformation, r.method, r.rms_mm, r.p99_mm, r.max_mm, r.frame_us
        );
        let Row {
            organ,
            deformation,
            method,
            rms_mm,
            p99_mm,
            max_mm,
            frame_us,
        } = r;
        writeln!(
            csv,
            "{organ},{deformation},\"{method}\",{rms_mm:.5},{p99_mm:.5},{max_mm:.5},{frame_us:.1}"
        )?;
    }
    std::fs::create_dir_all(&out)?;
    std::fs::write(out.join("skinning.csv"), csv)?;
    std::fs::write(out.join("skinning.svg"), chart(&rows)?)?;
    println!("{}", out.join("skinning.svg").display());
    Ok(())
}

fn measure(scene: &SceneFile) -> Vec<Row> {
    let gauss: Vec<Binding> = scene
        .vertices()
        .iter()
        .map(|v| {
            std::array::from_fn(|k| (v.spheres[k], f32::from(v.weights[k]) / WEIGHT_SUM as f32))
        })
        .collect();
    let linear = linear_precision(scene);
    let mut rows = Vec::new();
    for (bindings, names) in [&gauss, &linear].into_iter().zip(METHODS) {
        for (follow, method) in FOLLOWS.into_iter().zip(names) {
            let frame_us = time(scene, bindings, follow);
            for organ in scene.organs() {
                for deformation in DEFORMATIONS {
                    let errors = errors(scene, organ, bindings, follow, deformation);
                    let rms =
                        (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
                    rows.push(Row {
                        organ: shared_mem::scene::str_from_name(&organ.name)
                            .unwrap_or("?")
                            .to_owned(),
                        deformation,
                        method,
                        rms_mm: rms * 1e3,
                        p99_mm: errors[errors.len() * 99 / 100] * 1e3,
                        max_mm: errors[errors.len() - 1] * 1e3,
                        frame_us,
                    });
                }
            }
        }
    }
    rows
}

/// Distances of the skin from the exact deformation, sorted, m.
fn errors(
    scene: &SceneFile,
    organ: &shared_mem::scene::OrganRecord,
    bindings: &[Binding],
    follow: Follow,
    deformation: &str,
) -> Vec<f64> {
    let range = |[first, count]: [u32; 2]| first as usize..(first + count) as usize;
    let vertices = &scene.vertices()[range(organ.vertices)];
    let map = Deformation::of(vertices.iter().map(|v| v.position_m.into()), deformation);
    let spheres = range(organ.spheres);
    let carried = |share: f32| -> Vec<SphereState> {
        let each = scene.spheres().iter().enumerate().map(|(i, s)| {
            let rest = Vec3::from(s.center_m);
            let to = if spheres.contains(&i) {
                map.at(rest, i, true)
            } else {
                rest
            };
            SphereState {
                center_m: rest.lerp(to, share).to_array(),
                bits: 0,
            }
        });
        each.collect()
    };
    let mut motions = Motions::new(scene, follow);
    // Move the tissue in small steps, as it moves from frame to frame.
    for step in 1..=8 {
        motions.update(&carried(step as f32 / 8.0));
    }
    let bindings = &bindings[range(organ.vertices)];
    let mut errors: Vec<f64> = vertices
        .iter()
        .zip(bindings)
        .map(|(v, binding)| {
            let rest = Vec3::from(v.position_m);
            let skin = blend(motions.now(), binding, rest);
            f64::from(skin.distance(map.at(rest, 0, false)))
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors
}

fn blend(motions: &[Motion], binding: &Binding, at: Vec3) -> Vec3 {
    let mut rows = Motion::default();
    for &(sphere, weight) in binding {
        for (sum, row) in rows.iter_mut().zip(&motions[usize::from(sphere)]) {
            for (sum, x) in sum.iter_mut().zip(row) {
                *sum += x * weight;
            }
        }
    }
    display_host::skinning::motion::moved(&rows, at)
}

/// Median time to skin the whole scene once on one core, µs.
fn time(scene: &SceneFile, bindings: &[Binding], follow: Follow) -> f64 {
    let mut motions = Motions::new(scene, follow);
    let mut skin = vec![Vec3::ZERO; bindings.len()];
    let mut times: Vec<f64> = (0..41)
        .map(|frame| {
            let spheres: Vec<SphereState> = scene
                .spheres()
                .iter()
                .map(|s| {
                    let c = Vec3::from(s.center_m);
                    let turned = glam::Quat::from_rotation_x(frame as f32 * 0.01) * c;
                    SphereState {
                        center_m: turned.to_array(),
                        bits: 0,
                    }
                })
                .collect();
            let start = Instant::now();
            motions.update(&spheres);
            for ((skin, v), binding) in skin.iter_mut().zip(scene.vertices()).zip(bindings) {
                *skin = blend(motions.now(), binding, v.position_m.into());
            }
            std::hint::black_box(&skin);
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A deformation of the space around an organ.
struct Deformation<'a> {
    name: &'a str,
    /// Coordinate axes as columns, the one along the organ's longest side first.
    axes: Mat3,
    middle: Vec3,
    length: f32,
}

impl<'a> Deformation<'a> {
    fn of(points: impl Iterator<Item = Vec3>, name: &'a str) -> Self {
        let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let size = high - low;
        let long = if size.x >= size.max_element() {
            [Vec3::X, Vec3::Y, Vec3::Z]
        } else if size.y >= size.max_element() {
            [Vec3::Y, Vec3::Z, Vec3::X]
        } else {
            [Vec3::Z, Vec3::X, Vec3::Y]
        };
        Self {
            name,
            axes: Mat3::from_cols(long[0], long[1], long[2]),
            middle: (low + high) / 2.0,
            length: size.max_element(),
        }
    }

    fn at(&self, p: Vec3, seed: usize, is_sphere: bool) -> Vec3 {
        let local = self.axes.transpose() * (p - self.middle);
        let (x, y, z) = (local.x, local.y, local.z);
        let angle = x / self.length * core::f32::consts::FRAC_PI_2;
        let moved = match self.name {
            "bend 90°" => {
                let radius = self.length / core::f32::consts::FRAC_PI_2;
                Vec3::new(
                    (radius - y) * angle.sin(),
                    radius - (radius - y) * angle.cos(),
                    z,
                )
            }
            "twist 90°" => {
                let (sin, cos) = angle.sin_cos();
                Vec3::new(x, y * cos - z * sin, y * sin + z * cos)
            }
            "dent" => {
                // A dent in the organ's side, about a quarter of its length wide.
                let wide = self.length / 8.0;
                let top = Vec3::Z * self.length * 0.25;
                let near = (-(local - top).length_squared() / (wide * wide)).exp();
                local - Vec3::Z * (near * wide * 0.5)
            }
            "stretch" => Vec3::new(1.3 * x + 0.2 * y, 0.8 * y, 0.9 * z - 0.1 * x),
            _ if is_sphere => {
                let random = |k: usize| ((seed * 3 + k) as f32 * 12.9898).sin() * 43_758.547;
                let noise = [0, 1, 2].map(|k| random(k).fract() * 2e-4);
                local + Vec3::from(noise)
            }
            _ => local,
        };
        self.axes * moved + self.middle
    }
}

/// Weights that carry affine maps of the spheres over to the skin almost exactly (linear
/// precision). They fit the nearest eight spheres by least squares, weighted by the Gaussian of Eq.
/// 9 of the paper. Some weights are negative.
fn linear_precision(scene: &SceneFile) -> Vec<Binding> {
    let mut bindings = Vec::with_capacity(scene.vertices().len());
    for organ in scene.organs() {
        let [first, count] = organ.spheres.map(|x| x as usize);
        let spheres = &scene.spheres()[first..first + count];
        let [v0, vn] = organ.vertices.map(|x| x as usize);
        for v in &scene.vertices()[v0..v0 + vn] {
            let at = Vec3::from(v.position_m);
            let mut near: Vec<(f32, usize)> = spheres
                .iter()
                .enumerate()
                .map(|(i, s)| (Vec3::from(s.center_m).distance(at), i))
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            near.truncate(BINDINGS);
            let wide = f64::from(near[near.len() / 2].0);
            let terms: Vec<(f64, DVec4)> = near
                .iter()
                .map(|&(far, i)| {
                    let d = (Vec3::from(spheres[i].center_m) - at).as_dvec3() / wide;
                    let phi = (-(f64::from(far) / wide).powi(2)).exp();
                    (phi, DVec3::extend(d, 1.0))
                })
                .collect();
            let mut moment = DMat4::ZERO;
            for (phi, d) in &terms {
                moment += DMat4::from_cols(*d * d.x, *d * d.y, *d * d.z, *d * d.w) * *phi;
            }
            moment += DMat4::from_diagonal(DVec4::new(1e-4, 1e-4, 1e-4, 0.0));
            let pull = moment.inverse() * DVec4::W;
            let mut binding = [((first + near[0].1) as u16, 0.0); BINDINGS];
            for (slot, ((phi, d), (_, i))) in binding.iter_mut().zip(terms.iter().zip(&near)) {
                *slot = ((first + i) as u16, (phi * pull.dot(*d)) as f32);
            }
            bindings.push(binding);
        }
    }
    bindings
}

/// Draws the error of the worst organ against time, with one mark for each method and deformation.
fn chart(rows: &[Row]) -> Result<String, Error> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (900, 460)).into_drawing_area();
        root.fill(&WHITE)?;
        let slowest = rows.iter().map(|r| r.frame_us).fold(0.0, f64::max) * 1.15;
        let most = rows.iter().map(|r| r.rms_mm).fold(0.0, f64::max) * 2.0;
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .caption(
                "Skinning: error of the skin against time of a frame",
                ("sans-serif", 17),
            )
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..slowest, (0.001..most).log_scale())?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(WHITE)
            .x_desc("a frame of the whole scene on one core, µs")
            .y_desc("error of the worst organ, rms, mm")
            .draw()?;
        let colours = [RED, BLUE, GREEN, MAGENTA, BLACK];
        for (deformation, colour) in DEFORMATIONS.into_iter().zip(colours) {
            let marks: Vec<(f64, f64, &str)> = METHODS
                .as_flattened()
                .iter()
                .map(|method| {
                    let of = rows
                        .iter()
                        .filter(|r| r.deformation == deformation && r.method == *method);
                    let (us, mm) =
                        of.fold((0.0, 0.001), |(_, mm), r| (r.frame_us, r.rms_mm.max(mm)));
                    (us, mm, *method)
                })
                .collect();
            chart
                .draw_series(
                    marks
                        .iter()
                        .map(|&(us, mm, _)| Circle::new((us, mm), 4, colour.filled())),
                )?
                .label(deformation)
                .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
            if deformation == DEFORMATIONS[0] {
                let mut marks = marks;
                marks.sort_by(|a, b| b.1.total_cmp(&a.1));
                // Move names down so that they do not overlap.
                let mut placed: Vec<(f64, f64)> = Vec::new();
                for (us, mm, method) in marks {
                    let near = placed.iter().filter(|p| (p.0 - us).abs() < 0.4 * slowest);
                    let below = near.map(|p| p.1 / 1.45).fold(f64::INFINITY, f64::min);
                    let at = (us - 0.33 * slowest, below.min(mm * 1.15));
                    placed.push((us, at.1));
                    let text = format!("{method}: {mm:.2} mm");
                    chart.draw_series([Text::new(text, at, ("sans-serif", 12).into_font())])?;
                }
            }
        }
        chart
            .configure_series_labels()
            .border_style(BLACK)
            .background_style(WHITE.mix(0.9))
            .position(SeriesLabelPosition::LowerLeft)
            .draw()?;
        root.present()?;
    }
    Ok(text)
}
