//! Prepares the four organs of the paper's Table 1 with the table's counts of spheres, on one
//! thread: `cargo bench -p scene-prepare --bench table1`. The paper needed 2207, 1179, 754 and
//! 2050 s.
//!
//! The organs are built-in shapes of the same kind and size as the paper's, not the paper's meshes.

use std::time::Instant;

use scene_prepare::mesh::mend;
use scene_prepare::pack::{Ball, Interior, Quality, isotropy, pack_as_paper, pack_evenly};
use scene_prepare::recipe::Closing;
use scene_prepare::shape::{Form, Shape};
use scene_prepare::{Vec3, bind, links, tetra};

type Failure = Box<dyn std::error::Error + Send + Sync>;

const ORGANS: [(&str, Form, usize, f64); 4] = [
    ("liver", Form::Liver, 581, 2207.0),
    ("gallbladder", Form::Gallbladder, 475, 1179.0),
    ("intestine", Form::Intestine, 383, 754.0),
    ("stomach", Form::Stomach, 452, 2050.0),
];

/// True under `cargo bench`. Under `cargo test`, one count and one organ show that the program
/// runs.
fn is_measured() -> bool {
    std::env::args().any(|word| word == "--bench")
}

fn main() -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(front)?;
    pool.install(table)
}

/// Prints the fit of the spheres for both packings of the liver with several counts: coverage,
/// gaps, protrusion and isotropy.
fn front() -> Result<(), Failure> {
    let mended = mend(&Shape::from(Form::Liver).mesh(), Closing::Refuse)?;
    println!(
        "liver: packing,spheres,links,tetrahedra,coverage,gap_mean_mm,gap_95_mm,gap_max_mm,protrusion_max_mm,isotropy,build_s"
    );
    let counts = [100, 250, 581, 1200, 2500, 4000, 8000];
    for &count in if is_measured() {
        &counts[..]
    } else {
        &counts[..1]
    } {
        for even in [true, false] {
            // The paper's packing tests each pair of spheres against all spheres, which takes
            // minutes above 2500 spheres.
            if !even && count > 2500 {
                continue;
            }
            let begun = Instant::now();
            let interior =
                Interior::new(&mended.mesh, mended.volume_m3, count).ok_or("nothing inside")?;
            let balls = if even {
                pack_evenly(&interior, count)
            } else {
                pack_as_paper(&interior, count)
            };
            let tets = tetra::fill(&interior, &balls, mended.volume_m3);
            let list = if even {
                links::link_edges(&balls, &tets)
            } else {
                links::link(&balls)
            };
            let build_s = begun.elapsed().as_secs_f64();
            let q = Quality::measure(&interior, &mended.mesh, &balls);
            println!(
                "{},{},{},{},{:.3},{:.2},{:.2},{:.2},{:.3},{:.2},{build_s:.2}",
                if even { "even" } else { "paper" },
                balls.len(),
                list.len(),
                tets.len(),
                q.coverage,
                1e3 * q.gap_mean_m,
                1e3 * q.gap_95_m,
                1e3 * q.gap_max_m,
                1e3 * q.protrusion_max_m,
                isotropy(&balls, &list),
            );
        }
    }
    Ok(())
}

fn table() -> Result<(), Failure> {
    println!(
        "organ        packing spheres springs  tets  pieces deg  iso  cover  gap95/h  gap max   out  sliver | mend  field  pack  link  tets  bind  total (paper)"
    );
    let organs = if is_measured() {
        &ORGANS[..]
    } else {
        &ORGANS[1..2]
    };
    for even in [true, false] {
        let mut sum_s = 0.0;
        for (name, shape, count, paper_s) in organs {
            let mesh = Shape::from(*shape).mesh();
            let mut clock = Instant::now();
            let mut lap = || {
                std::mem::replace(&mut clock, Instant::now())
                    .elapsed()
                    .as_secs_f64()
            };
            let mended = mend(&mesh, Closing::Refuse)?;
            let mend_s = lap();
            let interior =
                Interior::new(&mended.mesh, mended.volume_m3, *count).ok_or("nothing inside")?;
            let field_s = lap();
            let balls: Vec<Ball> = if even {
                pack_evenly(&interior, *count)
            } else {
                pack_as_paper(&interior, *count)
            };
            let pack_s = lap();
            let tets = tetra::fill(&interior, &balls, mended.volume_m3);
            let tets_s = lap();
            let list = if even {
                links::link_edges(&balls, &tets)
            } else {
                links::link(&balls)
            };
            let link_s = lap();
            let bound = bind::bind(&mended.mesh, &balls, 0);
            let bind_s = lap();
            let total = mend_s + field_s + pack_s + link_s + tets_s + bind_s;
            sum_s += total;
            let quality = Quality::measure(&interior, &mended.mesh, &balls);
            let mut degree = vec![0; balls.len()];
            for &i in list.as_flattened() {
                degree[i as usize] += 1;
            }
            let centers: Vec<Vec3> = balls.iter().map(|b| b.center).collect();
            let sliver = tets.iter().map(|t| tetra::shape(&centers, &t.spheres));
            println!(
                "{name:<12} {:<7} {:>7} {:>7} {:>5} {:>7} {:>3} {:>4.2} {:>5.1}% {:>7.2} {:>6.2}mm {:>4.2}mm {:>6.3} | {mend_s:>5.3} {field_s:>5.3} {pack_s:>5.3} {link_s:>5.3} {tets_s:>5.3} {bind_s:>5.3} {total:>6.3} s ({paper_s} s), {} vertices",
                if even { "even" } else { "paper" },
                balls.len(),
                list.len(),
                tets.len(),
                links::pieces(&list, balls.len()).1,
                degree.iter().min().unwrap_or(&0),
                isotropy(&balls, &list),
                100.0 * quality.coverage,
                quality.gap_95_m / interior.spacing_m,
                1e3 * quality.gap_max_m,
                1e3 * quality.protrusion_max_m,
                sliver.fold(f64::INFINITY, f64::min),
                bound.len(),
            );
        }
        println!("all four: {sum_s:.3} s");
    }
    Ok(())
}
