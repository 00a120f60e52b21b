//! Makes the tables of `tests/results/README.md` from the CSV files in the same folder.
//!
//! A table is the text between `<!-- table: NAME -->` and `<!-- end -->`. [`rewrite`] replaces this
//! text. All other text in the file is written by hand.

mod ablation;
mod competitors;
mod drawing;
mod force;
mod guide;
mod haptics;
mod measured;
mod rest;
mod stay;
mod surface;

use std::fmt::Write as _;
use std::path::Path;

use crate::csv::Csv;

/// A table: its columns, then its rows.
struct Table(Vec<Vec<String>>);

impl Table {
    fn new(columns: &[&str]) -> Self {
        Self(vec![columns.iter().map(ToString::to_string).collect()])
    }

    fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.0.push(cells.into_iter().collect());
    }

    fn markdown(&self) -> String {
        let mut text = String::new();
        for (at, row) in self.0.iter().enumerate() {
            let _ = writeln!(text, "| {} |", row.join(" | "));
            if at == 0 {
                let rules = (0..row.len()).map(|column| self.rule(column));
                let _ = writeln!(text, "|{}|", rules.collect::<Vec<_>>().join("|"));
            }
        }
        text
    }

    /// The rule under a column's name. It aligns columns of numbers to the right.
    fn rule(&self, column: usize) -> &'static str {
        let mut cells = self.0.iter().skip(1).filter_map(|row| row.get(column));
        if cells.all(|cell| cell.is_empty() || cell.parse::<f64>().is_ok()) {
            "--:"
        } else {
            "---"
        }
    }
}

/// Replaces every table in `text` by a table made from the CSV files in `folder`.
pub(crate) fn rewrite(text: &str, folder: &Path) -> Result<String, String> {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("<!-- table: ") {
        let (name, after) = after
            .split_once(" -->")
            .ok_or("a table's marker must end in ` -->`")?;
        let (_, after) = after
            .split_once("<!-- end -->")
            .ok_or_else(|| format!("table {name}: write `<!-- end -->` after it"))?;
        let table = table(name, folder)?.markdown();
        let _ = write!(
            out,
            "{before}<!-- table: {name} -->\n\n{table}\n<!-- end -->"
        );
        rest = after;
    }
    Ok(out + rest)
}

fn table(name: &str, folder: &Path) -> Result<Table, String> {
    let read = |file: &str| Csv::read(&folder.join(file));
    Ok(match name {
        "accuracy" => accuracy(&read("accuracy.csv")?),
        "competitors" => competitors::best(&read("accuracy.csv")?),
        "stability" => stability(&read("stability.csv")?),
        "reference" => reference(&read("reference.csv")?),
        "force" => force::by_law(&read("force.csv")?),
        "torque" => force::torque(&read("force.csv")?),
        "force reference" => force::reference(&read("force_reference.csv")?),
        "calculix" => force::calculix(&read("force_calculix.csv")?),
        "force steps" => force::steps(&read("force_steps.csv")?),
        "slow work" => slow_work(&read("slow_work.csv")?),
        "ablation" => ablation::by_criterion(&read("ablation.csv")?),
        "ablation by room" => ablation::by_room(&read("ablation.csv")?),
        "collision" => collision(&read("collision.csv")?),
        "collision by size" => {
            collision_by_size(&[read("collision.csv")?, read("collision-h200.csv")?])
        }
        "drawing" => drawing::by_tier(&read("drawing-h200.csv")?),
        "views" => drawing::by_view(&read("drawing-h200.csv")?),
        "haptics" => haptics::by_law(&read("haptics.csv")?),
        "haptics felt" => haptics::felt(&read("haptics.csv")?),
        "haptics wait" => guide::waits(&read("haptics_wait.csv")?),
        "guide" => guide::options(&read("guide.csv")?),
        "skinning" => skinning(&read("skinning.csv")?),
        "surface" => surface::by_hand(&read("surface.csv")?),
        "rest" => rest::by_sweep(&read("rest.csv")?),
        "stay" => stay::by_organ(&read("stay.csv")?),
        "silicones" => measured::silicones(&read("measured.csv")?),
        "measured" => measured::others(&read("measured.csv")?),
        "packing" => packing(&read("packing.csv")?),
        "jitter" => jitter(&[
            ("idle", read("jitter-idle.csv")?),
            ("loaded", read("jitter-loaded.csv")?),
            ("misses", read("jitter-misses.csv")?),
            ("soak", read("jitter-soak.csv")?),
        ]),
        "jitter counts" => jitter_counts(&[
            ("idle", read("jitter-idle.csv")?),
            ("loaded", read("jitter-loaded.csv")?),
            ("misses", read("jitter-misses.csv")?),
            ("soak", read("jitter-soak.csv")?),
        ]),
        _ => return Err(format!("table {name} is not known; correct its name")),
    })
}

/// Path of the guide for latency testers, relative to the folder of the results.
pub(crate) const GUIDE: &str = "../../rt-core/process/README.md";
const CALOT: &str = "Calot";
const PAPER: &str = "inner spheres (paper's), k fitted";
const OTHERS: [&str; 4] = [
    "mass-spring, semi-implicit",
    "PBD stretch + volume (paper's), k fitted",
    "XPBD springs + volume",
    "corotational hexahedra (paper's FEM)",
];

/// One row for each scene, with the number of spheres nearest to 581, the paper's number for the
/// liver.
fn accuracy(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "scene",
        "spheres",
        "Calot, µs",
        "Calot, rms mm",
        "paper's, µs",
        "paper's, rms mm",
        "most accurate other",
        "its µs",
        "its rms mm",
    ]);
    for scene in csv.distinct("scene") {
        let of = |method: &str| {
            csv.rows()
                .filter(|r| r.text("scene") == scene && r.text("method") == method)
                .min_by_key(|r| (r.number("spheres") as i64 - 581).abs())
        };
        let (Some(ours), Some(paper)) = (of(CALOT), of(PAPER)) else {
            continue;
        };
        let count = ours.text("spheres");
        let other = csv
            .rows()
            .filter(|r| r.text("scene") == scene && r.text("spheres") == count)
            .filter(|r| OTHERS.contains(&r.text("method")))
            .min_by(|a, b| a.number("rms_mm").total_cmp(&b.number("rms_mm")));
        let time = |x: f64| format!("{x:.1}");
        let error = |x: f64| format!("{x:.2}");
        let mut cells = vec![
            scene.clone(),
            count.to_owned(),
            time(ours.number("us_per_tick")),
            error(ours.number("rms_mm")),
            time(paper.number("us_per_tick")),
            error(paper.number("rms_mm")),
        ];
        cells.extend(other.map_or_else(
            || vec!["none".to_owned(), String::new(), String::new()],
            |r| {
                vec![
                    r.text("method").to_owned(),
                    time(r.number("us_per_tick")),
                    error(r.number("rms_mm")),
                ]
            },
        ));
        table.row(cells);
    }
    table
}

fn stability(csv: &Csv) -> Table {
    let mut table = Table::new(&["method", "cases survived", "of", "cases that it fails"]);
    for method in csv.distinct("method") {
        let rows: Vec<_> = csv.rows().filter(|r| r.text("method") == method).collect();
        let failed: Vec<&str> = rows
            .iter()
            .filter(|r| r.text("survived") != "true")
            .map(|r| r.text("case"))
            .collect();
        table.row([
            method.clone(),
            (rows.len() - failed.len()).to_string(),
            rows.len().to_string(),
            failed.join("; "),
        ]);
    }
    table
}

fn reference(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "scene",
        "layers",
        "nodes",
        "displacement, mm",
        "rms to the finest, mm",
        "largest, mm",
    ]);
    for r in csv.rows() {
        table.row([
            r.text("scene").to_owned(),
            r.text("layers").to_owned(),
            r.text("nodes").to_owned(),
            format!("{:.2}", r.number("displacement_mm")),
            format!("{:.2}", r.number("rms_to_finest_mm")),
            format!("{:.2}", r.number("max_to_finest_mm")),
        ]);
    }
    table
}

/// Steps of the force in slow work. A knock is the difference between the force changes of two
/// consecutive ticks.
fn slow_work(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "scene",
        "movement",
        "count",
        "knocks above 5 mN",
        "median knock, mN",
        "largest knock, mN",
    ]);
    for scene in csv.distinct("scene") {
        for leg in csv.distinct("leg") {
            let knocks = sorted(
                csv.rows()
                    .filter(|r| r.text("scene") == scene && r.text("leg") == leg)
                    .filter(|r| r.text("began_inside") == "false")
                    .map(|r| r.number("largest_knock_mn_per_tick")),
            );
            table.row([
                scene.clone(),
                leg,
                knocks.len().to_string(),
                knocks.iter().filter(|k| **k > 5.0).count().to_string(),
                format!("{:.2}", median(&knocks)),
                format!("{:.2}", largest(&knocks)),
            ]);
        }
    }
    table
}

fn collision(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "organ",
        "spheres",
        "way",
        "p50, µs",
        "p99, µs",
        "to follow the organ, µs",
        "found, %",
        "depth error, mm",
    ]);
    for r in csv.rows().filter(|r| r.text("organ") != "balls") {
        table.row([
            r.text("organ").to_owned(),
            r.text("spheres").to_owned(),
            r.text("way").to_owned(),
            format!("{:.1}", r.number("p50_us")),
            format!("{:.1}", r.number("p99_us")),
            format!("{:.0}", r.number("follow_us")),
            format!("{:.1}", r.number("recall") * 100.0),
            format!("{:.2}", r.number("depth_error_mm")),
        ]);
    }
    table
}

/// The paper's kernel alone: on the machine of the other tables, and on a machine with a graphics
/// card.
fn collision_by_size(machines: &[Csv; 2]) -> Table {
    let mut table = Table::new(&[
        "spheres",
        "one core, p50 µs",
        "software driver, p50 µs",
        "one core of the H200's host, p50 µs",
        "H200, p50 µs",
    ]);
    for count in machines[0].distinct("spheres") {
        let of = |machine: &Csv, way: &str| {
            machine
                .rows()
                .filter(|r| r.text("organ") == "balls")
                .find(|r| r.text("spheres") == count && r.text("way").contains(way))
                .map(|r| format!("{:.0}", r.number("p50_us")))
        };
        let cells = machines.each_ref().map(|it| [of(it, "CPU"), of(it, "GPU")]);
        let cells: Option<Vec<String>> = cells.into_iter().flatten().collect();
        if let Some(cells) = cells {
            table.row(core::iter::once(count).chain(cells));
        }
    }
    table
}

fn skinning(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "method",
        "liver, bend 90°, rms mm",
        "liver, twist 90°, rms mm",
        "gallbladder, bend 90°, rms mm",
        "gallbladder, twist 90°, rms mm",
        "a frame, µs",
    ]);
    for method in csv.distinct("method") {
        let of = |organ: &str, deformation: &str| {
            csv.rows().find(|r| {
                r.text("method") == method
                    && r.text("organ") == organ
                    && r.text("deformation") == deformation
            })
        };
        let rms = |organ, deformation| {
            of(organ, deformation)
                .map_or_else(String::new, |r| format!("{:.2}", r.number("rms_mm")))
        };
        table.row([
            method.clone(),
            rms("liver", "bend 90°"),
            rms("liver", "twist 90°"),
            rms("gallbladder", "bend 90°"),
            rms("gallbladder", "twist 90°"),
            of("liver", "bend 90°")
                .map_or_else(String::new, |r| format!("{:.0}", r.number("frame_us"))),
        ]);
    }
    table
}

/// Both packings at the paper's numbers of spheres, which are no multiples of 100, and at 1000.
fn packing(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "organ",
        "spheres",
        "packing",
        "mean gap, mm",
        "largest gap, mm",
        "coverage, %",
        "isotropy",
        "time, s",
    ]);
    for r in csv.rows() {
        let count = r.number("spheres") as u32;
        if count.is_multiple_of(100) && count != 1000 {
            continue;
        }
        table.row([
            r.text("organ").to_owned(),
            r.text("spheres").to_owned(),
            r.text("packing").to_owned(),
            format!("{:.2}", r.number("gap_mean_mm")),
            format!("{:.2}", r.number("gap_max_mm")),
            format!("{:.1}", r.number("coverage") * 100.0),
            format!("{:.2}", r.number("isotropy")),
            format!("{:.2}", r.number("build_s")),
        ]);
    }
    table
}

fn jitter(runs: &[(&str, Csv)]) -> Table {
    let mut table = Table::new(&["run", "µs", "p50", "p99", "p99.9", "p99.99", "largest"]);
    for (run, csv) in runs {
        for (name, told) in [
            ("wake_latency_ns", "wake-up latency"),
            ("cyclictest.wake_latency_ns", "… of cyclictest"),
            ("sleep.wake_latency_ns", "… of a bare loop"),
            ("burn.wake_latency_ns", "… of a bare loop with as much work"),
            ("tick_ns", "whole tick"),
            ("motion_to_force_ns", "motion to force"),
        ] {
            if let Some(r) = csv.rows().find(|r| r.text("name") == name) {
                let mut cells = vec![(*run).to_owned(), told.to_owned()];
                for column in ["p50", "p99", "p999", "p9999", "max"] {
                    cells.push(format!("{:.1}", r.number(column) / 1000.0));
                }
                table.row(cells);
            }
        }
    }
    table
}

fn jitter_counts(runs: &[(&str, Csv)]) -> Table {
    let mut table = Table::new(&[
        "run",
        "ticks",
        "missed in a million periods",
        "bare loop with as much work: missed",
        "allocations",
        "page faults",
        "blocks",
        "displays joined",
    ]);
    for (run, csv) in runs {
        let count = |name: &str| {
            csv.rows()
                .find(|r| r.text("name") == name)
                .map(|r| r.number("count"))
        };
        let plain = |name| count(name).map_or_else(|| "none".to_owned(), |n| format!("{n:.0}"));
        // A missed period has no tick.
        let share = |missed, ran| match (count(missed), count(ran)) {
            (Some(missed), Some(ran)) => format!("{:.0}", missed / (ran + missed) * 1.0e6),
            _ => "not run".to_owned(),
        };
        table.row([
            (*run).to_owned(),
            plain("ticks"),
            share("deadline_misses", "ticks"),
            share("burn.deadline_misses", "burn.ticks"),
            plain("allocations_after_start"),
            plain("page_faults_after_start"),
            plain("blocks"),
            plain("displays_joined"),
        ]);
    }
    table
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

fn median(sorted: &[f64]) -> f64 {
    let n = sorted.len();
    if n == 0 {
        return f64::NAN;
    }
    f64::midpoint(sorted[(n - 1) / 2], sorted[n / 2])
}

fn largest(sorted: &[f64]) -> f64 {
    sorted.last().copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    #[test]
    fn committed_tables_are_those_of_the_committed_csv_files() {
        let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../results"));
        let text = std::fs::read_to_string(folder.join("README.md")).unwrap();
        assert!(
            rewrite(&text, &folder).unwrap() == text,
            "tests/results/README.md is out of date: cargo run -p evaluate -- tables"
        );
    }

    #[test]
    fn the_guide_for_latency_testers_has_the_tables_of_the_same_files() {
        let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../results"));
        let text = std::fs::read_to_string(folder.join(GUIDE)).unwrap();
        assert!(text.contains("<!-- table: guide -->"));
        assert!(
            rewrite(&text, &folder).unwrap() == text,
            "rt-core/process/README.md is out of date: cargo run -p evaluate -- tables"
        );
    }

    #[test]
    fn the_guides_claim_on_motion_to_force_is_that_of_its_table() {
        let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../results"));
        let csv = Csv::read(&folder.join("guide.csv")).unwrap();
        let greatest = |figure: &str| {
            let mut rows = csv.rows();
            let found = rows.find(|row| row.text("figure") == figure);
            found.map(|row| row.number("small")).unwrap()
        };
        // The guide says "even in the greatest turn".
        assert!(greatest("motion to force p50, greatest turn, µs") <= 150.0);
        assert!(greatest("motion to force p99, greatest turn, µs") <= 250.0);
    }

    #[test]
    fn a_table_without_an_end_is_refused() {
        let text = "before <!-- table: accuracy --> after";
        assert!(rewrite(text, Path::new("nowhere")).is_err());
    }
}
