//! `evaluate calculix`: computes two presses with the finite-element program CalculiX and with the
//! reference's elements, on the same mesh of the organ. CalculiX has its own contact and solver.
//! Its neo-Hookean law differs from Calot's, so the reference's elements solve each press with both
//! laws.
//!
//! The command needs the program `ccx` (Debian's package calculix-ccx).

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use fem_reference::Mesh as Solid;
use nalgebra::Vector3;

use super::case::Case;
use super::reference::{Law, Setup};
use crate::body::Tissue;

type Point = Vector3<f64>;

/// The presses, by name.
const CASES: [&str; 2] = ["liver left lobe: tip 5 mm", "stomach front: tip 10 mm"];
/// Depths, mm. CalculiX ends before 8 mm.
const DEPTHS_MM: [f64; 3] = [1.0, 2.0, 4.0];
/// Size of the elements as a multiple of the finer reference's.
const LARGER: f64 = 1.7;
/// Number of parts of each edge of the octahedron that is refined to the ball's facets.
const DIVISIONS: usize = 12;
/// Contact pressure per penetration, in Young's moduli per millimetre.
const PENALTY_MODULI_PER_MM: f64 = 10.0;

/// One depth of one press.
struct Row {
    case: String,
    nodes: usize,
    depth_mm: f64,
    calculix_n: f64,
    same_law_n: f64,
    calot_law_n: f64,
}

/// Runs the presses whose names contain `only`, and returns `force_calculix.csv`. CalculiX's files
/// are written to `out`/calculix.
///
/// # Errors
/// The reason in words.
pub(crate) fn run(out: &Path, only: &str) -> Result<String, String> {
    let folder = out.join("calculix");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut rows = Vec::new();
    let named = |case: &Case| CASES.contains(&case.name().as_str()) && case.name().contains(only);
    for case in Case::all().into_iter().filter(named) {
        let setup = Setup::new(&case)?;
        let mesh = setup.mesh(LARGER)?;
        let (_, same_law) = setup.solve_on(&mesh, Law::Isochoric, &DEPTHS_MM)?;
        let (_, calot_law) = setup.solve_on(&mesh, Law::Calot, &DEPTHS_MM)?;
        let name = if rows.is_empty() { "first" } else { "second" };
        let calculix = press(&setup, &mesh, &folder, name)?;
        let forces = calculix.iter().zip(same_law.iter().zip(&calot_law));
        for (depth_mm, (calculix_n, (same, calot))) in DEPTHS_MM.iter().zip(forces) {
            rows.push(Row {
                case: case.name(),
                nodes: mesh.nodes.len(),
                depth_mm: *depth_mm,
                calculix_n: *calculix_n,
                same_law_n: same.out_n(),
                calot_law_n: calot.out_n(),
            });
        }
    }
    Ok(csv(&rows))
}

fn csv(rows: &[Row]) -> String {
    let mut text = "case,nodes,depth_mm,calculix_n,same_law_n,calot_law_n\n".to_owned();
    for r in rows {
        let _ = writeln!(
            text,
            "\"{}\",{},{},{:.5},{:.5},{:.5}",
            r.case, r.nodes, r.depth_mm, r.calculix_n, r.same_law_n, r.calot_law_n
        );
    }
    text
}

/// Runs CalculiX. Returns the force against the tool's motion at each reached depth, N.
fn press(setup: &Setup, mesh: &Solid, folder: &Path, name: &str) -> Result<Vec<f64>, String> {
    let input = folder.join(format!("{name}.inp"));
    std::fs::write(&input, deck(setup, mesh)).map_err(|e| format!("{}: {e}", input.display()))?;
    eprintln!("  CalculiX, {} nodes …", mesh.nodes.len());
    let start = std::time::Instant::now();
    let log = folder.join(format!("{name}.log"));
    let log = std::fs::File::create(&log).map_err(|e| format!("{}: {e}", log.display()))?;
    let ended = Command::new("ccx")
        .arg(name)
        .current_dir(folder)
        .env("OMP_NUM_THREADS", "1")
        .stdout(Stdio::from(log))
        .status()
        .map_err(|e| format!("ccx: {e}; install Debian's package calculix-ccx"))?;
    let results = folder.join(format!("{name}.dat"));
    let text = std::fs::read_to_string(&results)
        .map_err(|e| format!("{}: {e}; ccx ended with {ended}", results.display()))?;
    let forces = forces(&text);
    let felt: Vec<f64> = forces
        .iter()
        .map(|f| f.dot(&setup.placed.outward))
        .collect();
    let took_s = start.elapsed().as_secs_f64();
    eprintln!("  CalculiX: {took_s:.0} s, {felt:.4?} N");
    Ok(felt)
}

/// Reads CalculiX's output: the total force on the held nodes at the end of each step, N.
fn forces(text: &str) -> Vec<Point> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.contains("total force") && line.contains("HELD") {
            let numbers = lines.find(|l| !l.trim().is_empty()).unwrap_or_default();
            let numbers: Vec<f64> = numbers
                .split_whitespace()
                .filter_map(|word| word.parse().ok())
                .collect();
            if let [x, y, z] = numbers[..] {
                found.push(Point::new(x, y, z));
            }
        }
    }
    found
}

/// CalculiX's input for a press.
fn deck(setup: &Setup, mesh: &Solid) -> String {
    let tissue = Tissue::LIVER;
    let (mu, lame) = (tissue.mu(), tissue.lame());
    let bulk = lame + 2.0 / 3.0 * mu;
    let mut text = String::from("*NODE, NSET=ORGAN\n");
    for (i, p) in mesh.nodes.iter().enumerate() {
        let _ = writeln!(text, "{}, {:.9e}, {:.9e}, {:.9e}", i + 1, p.x, p.y, p.z);
    }
    text += "*ELEMENT, TYPE=C3D10, ELSET=TISSUE\n";
    for (e, t) in mesh.tets.iter().enumerate() {
        let nodes: Vec<String> = t.iter().map(|n| (n + 1).to_string()).collect();
        let _ = writeln!(text, "{}, {}", e + 1, nodes.join(", "));
    }
    let _ = writeln!(text, "*SURFACE, NAME=SKIN, TYPE=ELEMENT");
    for (element, side) in sides(setup, mesh) {
        let _ = writeln!(text, "{}, S{side}", element + 1);
    }
    let held = mesh.nodes_where(|p| setup.is_held(p));
    let _ = writeln!(text, "*NSET, NSET=HELD");
    for n in &held {
        let _ = writeln!(text, "{},", n + 1);
    }
    text += &ball(setup, mesh.nodes.len(), mesh.tets.len());
    let _ = writeln!(
        text,
        "*MATERIAL, NAME=SOFT\n*HYPERELASTIC, NEO HOOKE\n{:.9e}, {:.9e}\n\
         *SOLID SECTION, ELSET=TISSUE, MATERIAL=SOFT\n\
         *MATERIAL, NAME=STIFF\n*ELASTIC\n1e9, 0.3\n\
         *SOLID SECTION, ELSET=BALL, MATERIAL=STIFF\n\
         *SURFACE INTERACTION, NAME=TOUCH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{:.6e}\n\
         *CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE\nSKIN, TOOL\n\
         *BOUNDARY\nHELD, 1, 3",
        mu / 2.0,
        2.0 / bulk,
        PENALTY_MODULI_PER_MM * tissue.young_pa * 1e3,
    );
    for depth_mm in DEPTHS_MM {
        let shift_m = -setup.placed.outward * (depth_mm * 1e-3);
        let _ = writeln!(
            text,
            "*STEP, NLGEOM, INC=200\n*STATIC\n0.2, 1.0, 1e-4, 0.34\n*BOUNDARY"
        );
        for axis in 0..3 {
            let _ = writeln!(text, "GRIP, {0}, {0}, {1:.9e}", axis + 1, shift_m[axis]);
        }
        text += "*NODE PRINT, NSET=HELD, TOTALS=ONLY, FREQUENCY=1000\nRF\n*END STEP\n";
    }
    text
}

/// Element and side of each face that the tool may touch, with CalculiX's numbers of the sides.
fn sides(setup: &Setup, mesh: &Solid) -> Vec<(usize, usize)> {
    let sorted = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let mut known = HashMap::new();
    for (e, t) in mesh.tets.iter().enumerate() {
        for (side, [a, b, c]) in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
            .iter()
            .enumerate()
        {
            known.insert(sorted([t[*a], t[*b], t[*c]]), (e, side + 1));
        }
    }
    let touchable = mesh.faces_where(|p| setup.may_touch(p));
    let faces = touchable.iter().map(|&f| mesh.faces[f as usize]);
    faces
        .map(|[a, b, c, ..]| known[&sorted([a, b, c])])
        .collect()
}

/// The lower half of the tip's ball: a shell of wedges. The displacements of all its nodes are
/// prescribed.
fn ball(setup: &Setup, nodes: usize, elements: usize) -> String {
    let bar = setup.placed.bars[0];
    let (centre, radius_m) = (bar.ends_m[0], bar.radius_m);
    let down = -setup.placed.outward;
    let (points, faces) = sphere();
    let kept: Vec<[usize; 3]> = faces
        .into_iter()
        .filter(|f| f.iter().any(|&i| points[i].dot(&down) > -0.1))
        .collect();
    let mut text = String::from("*NODE, NSET=GRIP\n");
    // Facets with corners on the ball would lie inside it. These corners are moved outwards, so
    // that the facets lie half inside and half outside.
    let outside = 1.0 + 0.25 * (std::f64::consts::FRAC_PI_4 / DIVISIONS as f64).powi(2);
    for (layer, share) in [0.8, outside].into_iter().enumerate() {
        for (i, p) in points.iter().enumerate() {
            let at = centre + p * (radius_m * share);
            let number = nodes + layer * points.len() + i + 1;
            let _ = writeln!(text, "{number}, {:.9e}, {:.9e}, {:.9e}", at.x, at.y, at.z);
        }
    }
    text += "*ELEMENT, TYPE=C3D6, ELSET=BALL\n";
    for (e, [a, b, c]) in kept.iter().enumerate() {
        let inner = [a, b, c].map(|i| nodes + i + 1);
        let [a, b, c] = inner;
        let [d, e2, f] = inner.map(|i| i + points.len());
        let number = elements + e + 1;
        let _ = writeln!(text, "{number}, {a}, {b}, {c}, {d}, {e2}, {f}");
    }
    text += "*SURFACE, NAME=TOOL, TYPE=ELEMENT\n";
    for e in 0..kept.len() {
        let _ = writeln!(text, "{}, S2", elements + e + 1);
    }
    text
}

/// A unit sphere of triangles, counter-clockwise as seen from outside.
fn sphere() -> (Vec<Point>, Vec<[usize; 3]>) {
    let n = DIVISIONS as i64;
    let mut numbers: HashMap<[i64; 3], usize> = HashMap::new();
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    let mut add = |at: [i64; 3]| {
        *numbers.entry(at).or_insert_with(|| {
            points.push(Point::from(at.map(|x| x as f64)).normalize());
            points.len() - 1
        })
    };
    for signs in [[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]] {
        for side in [1, -1] {
            let [x, y, z] = [signs[0] * side, signs[1], signs[2]];
            for i in 0..n {
                for j in 0..n - i {
                    let at = |i: i64, j: i64| [x * i, y * j, z * (n - i - j)];
                    let mut triangles = vec![[at(i, j), at(i + 1, j), at(i, j + 1)]];
                    if i + j + 1 < n {
                        triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                    for mut corners in triangles {
                        if x * y * z < 0 {
                            corners.swap(1, 2);
                        }
                        faces.push(corners.map(&mut add));
                    }
                }
            }
        }
    }
    (points, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_and_faces_outwards() {
        let (points, faces) = sphere();
        assert_eq!(faces.len(), 8 * DIVISIONS * DIVISIONS);
        assert_eq!(points.len(), faces.len() / 2 + 2);
        for [a, b, c] in faces.iter().map(|f| f.map(|i| points[i])) {
            assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) > 0.0);
        }
    }

    #[test]
    fn printed_forces_are_read() {
        let text = "\n total force (fx,fy,fz) for set HELD and time  0.1000000E+01\n\n       \
                    -1.5E-03  2.0E-03 -5.5E-02\n\n total force (fx,fy,fz) for set OTHER and time  1\n\n 1 2 3\n";
        assert_eq!(forces(text), [Point::new(-1.5e-3, 2e-3, -5.5e-2)]);
    }

    /// [`CASES`] names cases of [`Case::all`].
    #[test]
    fn presses_exist() {
        for name in CASES {
            assert!(Case::all().iter().any(|case| case.name() == name), "{name}");
        }
    }
}
