//! Measures how well spheres fit an organ, by the number of spheres: `cargo run --release -p
//! scene-prepare --example packing -- [--out DIR] [--quick]` writes `packing.csv` and
//! `packing.svg`, by default into `tests/results`.
//!
//! Coverage and mechanics conflict. Large spheres on the medial axis cover best. But their links
//! point along the axis (isotropy 0.1 to 0.35), and a large sphere cannot follow a small dent. So
//! preparation packs evenly, with radii up to 1.15 spacings: coverage is lower, and links are more
//! isotropic. The last panel shows coverage against isotropy with the paper's 581 spheres. It also
//! shows eight algorithms that a prototype study measured on another liver.

mod chart;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use scene_prepare::mesh::{Mesh, mend};
use scene_prepare::pack::{self, Interior, Quality};
use scene_prepare::recipe::Closing;
use scene_prepare::shape::{Form, Shape};
use scene_prepare::{Vec3, bind, links, tetra};

use chart::{Panel, Series};

type Failure = Box<dyn std::error::Error>;

/// The organs of the paper's Table 1, with its counts.
const ORGANS: [(&str, Form, usize); 4] = [
    ("liver", Form::Liver, 581),
    ("gallbladder", Form::Gallbladder, 475),
    ("intestine", Form::Intestine, 383),
    ("stomach", Form::Stomach, 452),
];
const COUNTS: [usize; 7] = [100, 200, 400, 1000, 2000, 4000, 8000];
/// Largest count for the paper's packing, which tests each pair of spheres against all spheres and
/// would take minutes beyond it.
const PAPER_MAX: usize = 1000;
/// Coverage and isotropy of the study's algorithms with 581 spheres.
const FRONT: [(&str, f64, f64); 8] = [
    ("medial axis and filling", 0.975, 0.13),
    ("greedy inscribed", 0.983, 0.35),
    ("Poisson disc", 0.958, 0.38),
    ("Voronoi, full radii", 0.960, 0.40),
    ("Voronoi, capped radii", 0.875, 0.41),
    ("Voronoi, outer layer set", 0.890, 0.53),
    ("the same, 0.06 h out of the skin", 0.934, 0.51),
    ("greedy, spaced", 0.951, 0.39),
];

/// Figures of one packing.
struct Row {
    organ: &'static str,
    packing: &'static str,
    asked: usize,
    spheres: usize,
    links: usize,
    tetrahedra: usize,
    spacing_mm: f64,
    quality: Quality,
    components: usize,
    min_degree: usize,
    isotropy: f64,
    /// Worst `V/L³` of a tetrahedron.
    shape_min: f64,
    /// Sum of the tetrahedra's volumes over the organ's volume.
    volume_share: f64,
    build_s: f64,
}

/// Packs every organ with every count; if `quick`, with counts up to 1000.
///
/// # Errors
/// When an organ cannot be packed. The error gives the reason in words.
fn run(quick: bool) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for (name, form, of_paper) in ORGANS {
        let mesh = Shape::from(form).mesh();
        let mut counts = COUNTS.to_vec();
        counts.push(of_paper);
        counts.sort_unstable();
        for count in counts {
            if quick && count > 1000 {
                continue;
            }
            eprintln!("{name}: {count} spheres");
            rows.push(row(name, "even", &mesh, count)?);
            if count <= PAPER_MAX {
                rows.push(row(name, "paper", &mesh, count)?);
            }
        }
    }
    Ok(rows)
}

fn row(
    organ: &'static str,
    packing: &'static str,
    mesh: &Mesh,
    count: usize,
) -> Result<Row, String> {
    let begun = Instant::now();
    let mended = mend(mesh, Closing::Refuse).map_err(|e| format!("{organ}: {e}"))?;
    let interior = Interior::new(&mended.mesh, mended.volume_m3, count)
        .ok_or_else(|| format!("{organ}: nothing inside"))?;
    let balls = match packing {
        "even" => pack::pack_evenly(&interior, count),
        _ => pack::pack_as_paper(&interior, count),
    };
    let tets = tetra::fill(&interior, &balls, mended.volume_m3);
    let list = match packing {
        "even" => links::link_edges(&balls, &tets),
        _ => links::link(&balls),
    };
    let bound = bind::bind(&mended.mesh, &balls, 0);
    let build_s = begun.elapsed().as_secs_f64();
    if bound.len() != mended.mesh.vertices.len() {
        return Err(format!("{organ}: a vertex is left unbound"));
    }
    let mut degree = vec![0; balls.len()];
    for &i in list.as_flattened() {
        degree[i as usize] += 1;
    }
    let centers: Vec<Vec3> = balls.iter().map(|b| b.center).collect();
    let carried_m3: f64 = tets.iter().map(|t| t.volume_m3).sum();
    Ok(Row {
        organ,
        packing,
        asked: count,
        spheres: balls.len(),
        links: list.len(),
        tetrahedra: tets.len(),
        spacing_mm: 1e3 * interior.spacing_m,
        quality: Quality::measure(&interior, &mended.mesh, &balls),
        components: links::pieces(&list, balls.len()).1,
        min_degree: degree.into_iter().min().unwrap_or(0),
        isotropy: pack::isotropy(&balls, &list),
        shape_min: tets
            .iter()
            .map(|t| tetra::shape(&centers, &t.spheres))
            .fold(f64::INFINITY, f64::min),
        volume_share: carried_m3 / mended.volume_m3,
        build_s,
    })
}

/// All figures as CSV.
fn csv(rows: &[Row]) -> String {
    let mut text = "organ,packing,spheres,springs,tetrahedra,spacing_mm,coverage,gap_mean_mm,\
                    gap_95_mm,gap_max_mm,protrusion_max_mm,components,min_degree,isotropy,\
                    tetra_shape_min,tetra_volume_share,build_s\n"
        .to_owned();
    for r in rows {
        let q = &r.quality;
        let _ = writeln!(
            text,
            "{},{},{},{},{},{:.2},{:.4},{:.3},{:.3},{:.3},{:.4},{},{},{:.3},{:.4},{:.6},{:.2}",
            r.organ,
            r.packing,
            r.spheres,
            r.links,
            r.tetrahedra,
            r.spacing_mm,
            q.coverage,
            1e3 * q.gap_mean_m,
            1e3 * q.gap_95_m,
            1e3 * q.gap_max_m,
            1e3 * q.protrusion_max_m,
            r.components,
            r.min_degree,
            r.isotropy,
            r.shape_min,
            r.volume_share,
            r.build_s
        );
    }
    text
}

/// Draws gap, coverage, isotropy and time against the number of spheres, and coverage against
/// isotropy with 581 spheres.
fn svg(rows: &[Row]) -> String {
    const SPHERES: &[f64] = &[100.0, 200.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0];
    let over = |title, axis, is_log, marks, value: fn(&Row) -> f64| {
        let mut series: Vec<Series> = Vec::new();
        for packing in ["even", "paper"] {
            for (name, _, _) in ORGANS {
                let own = rows
                    .iter()
                    .filter(|r| r.organ == name && r.packing == packing);
                series.push(Series {
                    name: format!("{name}, {}", in_words(packing)),
                    points: own.map(|r| [r.spheres as f64, value(r)]).collect(),
                    is_line: true,
                });
            }
        }
        Panel {
            title,
            axes: ["spheres", axis],
            is_log: [true, is_log],
            marks: [SPHERES, marks],
            series,
        }
    };
    let (liver, _, of_paper) = ORGANS[0];
    let ours = rows
        .iter()
        .filter(|r| r.organ == liver && r.asked == of_paper)
        .map(|r| Series {
            name: format!("{liver}, {}", in_words(r.packing)),
            points: vec![[r.isotropy, r.quality.coverage]],
            is_line: false,
        });
    let study = Series {
        name: "eight algorithms of the study".to_owned(),
        points: FRONT
            .map(|(_, coverage, isotropy)| [isotropy, coverage])
            .to_vec(),
        is_line: false,
    };
    let front = Panel {
        title: "At 581 spheres: covering against evenness",
        axes: ["isotropy of the links", "share of the volume covered"],
        is_log: [false; 2],
        marks: [
            &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7],
            &[0.8, 0.85, 0.9, 0.95, 1.0],
        ],
        series: ours.chain([study]).collect(),
    };
    let panels = [
        over(
            "Gap: 95 % of the skin is nearer to a sphere",
            "mm",
            true,
            &[0.2, 0.5, 1.0, 2.0, 5.0, 10.0],
            |r| 1e3 * r.quality.gap_95_m,
        ),
        over(
            "Coverage",
            "share of the volume covered",
            false,
            &[0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0],
            |r| r.quality.coverage,
        ),
        over(
            "Isotropy of the links",
            "mean λmin/λmax",
            false,
            &[0.0, 0.2, 0.4, 0.6, 0.8],
            |r| r.isotropy,
        ),
        over(
            "Time to build, from mesh to bound skin",
            "s",
            true,
            &[0.05, 0.1, 0.5, 1.0, 5.0, 10.0],
            |r| r.build_s,
        ),
        front,
    ];
    chart::draw(&panels)
}

fn in_words(packing: &str) -> &'static str {
    match packing {
        "even" => "packed evenly",
        _ => "as the paper does",
    }
}

fn main() -> Result<(), Failure> {
    let mut out = PathBuf::from("tests/results");
    let mut quick = false;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--out" => out = arguments.next().ok_or("--out needs a folder")?.into(),
            "--quick" => quick = true,
            _ => {
                return Err(
                    format!("{argument} is unknown; there are --out DIR and --quick").into(),
                );
            }
        }
    }
    std::fs::create_dir_all(&out)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let rows = pool.install(|| run(quick))?;
    std::fs::write(out.join("packing.csv"), csv(&rows))?;
    std::fs::write(out.join("packing.svg"), svg(&rows))?;
    println!("{}", out.join("packing.svg").display());
    Ok(())
}
