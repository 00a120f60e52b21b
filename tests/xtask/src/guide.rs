//! `cargo xtask jitter guide`: measures every figure of time in the guide for latency testers, and
//! writes it there.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use crate::steps::step;

/// Rounds. In each round every kind of run is measured once.
const TURNS: usize = 5;
/// Kinds of run in each round: name, scene, and further options of `calot jitter`.
const KINDS: [(&str, &str, &[&str]); 4] = [
    ("without", TRIANGLE, &[]),
    ("why", TRIANGLE, &["--why"]),
    ("follow", TRIANGLE, &["--follow-device"]),
    ("small", "built-in", &["--follow-device"]),
];
const TRIANGLE: &str = "triangle";
/// Figures of the table: name, and row and column of `jitter.csv`. The table converts ns to µs.
const FIGURES: [(&str, &str, &str); 13] = [
    ("wake-up p50, µs", "wake_latency_ns", "p50"),
    ("wake-up p99, µs", "wake_latency_ns", "p99"),
    ("whole tick p50, µs", "tick_ns", "p50"),
    ("whole tick p99, µs", "tick_ns", "p99"),
    ("motion to force p50, µs", "motion_to_force_ns", "p50"),
    ("motion to force p99, µs", "motion_to_force_ns", "p99"),
    ("… before the tick p50, µs", "motion_to_tick_ns", "p50"),
    ("… before the tick p99, µs", "motion_to_tick_ns", "p99"),
    ("… sample p50, µs", "stage_ns.sample", "p50"),
    ("… tool p50, µs", "stage_ns.tool", "p50"),
    ("… contact p50, µs", "stage_ns.contact", "p50"),
    ("… solve p50, µs", "stage_ns.solve", "p50"),
    ("… force p50, µs", "stage_ns.force", "p50"),
];
/// A choice of one value from those of the turns.
type Choice = fn(Vec<f64>) -> Option<f64>;
/// Rows on how far the turns lie apart: name, row and column of `jitter.csv`, and choice.
const SPREADS: [(&str, &str, &str, Choice); 6] = [
    (
        "motion to force p50, least turn, µs",
        "motion_to_force_ns",
        "p50",
        least,
    ),
    (
        "motion to force p50, greatest turn, µs",
        "motion_to_force_ns",
        "p50",
        greatest,
    ),
    (
        "motion to force p99, least turn, µs",
        "motion_to_force_ns",
        "p99",
        least,
    ),
    (
        "motion to force p99, greatest turn, µs",
        "motion_to_force_ns",
        "p99",
        greatest,
    ),
    (
        "… before the tick p50, least turn, µs",
        "motion_to_tick_ns",
        "p50",
        least,
    ),
    (
        "… before the tick p50, greatest turn, µs",
        "motion_to_tick_ns",
        "p50",
        greatest,
    ),
];
/// Names of the last rows.
const MISSED: &str = "missed in a million periods";
const LOAD: &str = "load average before the run";
/// File of the table.
const FILE: &str = "tests/results/guide.csv";
const FOLDER: &str = "target/jitter/guide";

/// A run's `jitter.csv`: values by row and column.
type Run = BTreeMap<(String, String), f64>;

/// Measures, and rewrites the tables. `args` are the seconds of a turn, and a program that is built
/// already.
pub(crate) fn measure(args: &[String]) -> Result<(), String> {
    let seconds = args.first().map_or("12", String::as_str);
    let program = match args.get(1) {
        Some(program) => program.clone(),
        None => {
            step("build", &["build", "--locked", "--release", "-p", "calot"])?;
            let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| "target".to_owned());
            format!("{target}/release/calot")
        }
    };
    // One compiled scene for all turns: a recipe would be compiled more coarsely in a busy moment.
    std::fs::create_dir_all(FOLDER).map_err(|error| format!("{FOLDER}: {error}"))?;
    let compiled = |scene: &str| format!("{FOLDER}/{scene}.calot");
    for scene in [TRIANGLE, "built-in"] {
        let out = compiled(scene);
        ran(Command::new(&program).args(["prepare", scene, "--overwrite", "--out", &out]))?;
    }
    let mut runs: [Vec<Run>; KINDS.len()] = Default::default();
    for turn in 0..TURNS {
        // Each round begins with a different kind of run, so that no kind is always the first.
        for i in 0..KINDS.len() {
            let of = (turn + i) % KINDS.len();
            if let (Some((name, scene, words)), Some(runs)) = (KINDS.get(of), runs.get_mut(of)) {
                let scene = compiled(scene);
                let out = format!("{FOLDER}/{name}-{turn}");
                let begin = ["jitter", "--scene", &scene, "--seconds", seconds];
                let place = ["--station", "jitter-guide", "--overwrite", "--out", &out];
                println!("\n== {out}");
                let load = load();
                ran(Command::new(&program).args(begin).args(place).args(*words))?;
                let mut run = read(&Path::new(&out).join("jitter.csv"))?;
                run.extend(load.map(|load| (key(LOAD, "count"), load)));
                runs.push(run);
            }
        }
    }
    let table = table(&runs).ok_or("a run lacks a figure of the table")?;
    std::fs::write(FILE, table).map_err(|error| format!("{FILE}: {error}"))?;
    println!("wrote {FILE}");
    step(
        "tables",
        &["run", "--locked", "-q", "-p", "evaluate", "--", "tables"],
    )
}

fn ran(command: &mut Command) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{command:?} failed ({status})")),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}

fn read(path: &Path) -> Result<Run, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(parsed(&text))
}

fn key(row: &str, column: &str) -> (String, String) {
    (row.to_owned(), column.to_owned())
}

/// The machine's load average of a minute.
fn load() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

/// Reads a `jitter.csv`.
fn parsed(text: &str) -> Run {
    let mut lines = text.lines().map(|line| line.split(','));
    let header: Vec<&str> = lines.next().into_iter().flatten().collect();
    let mut run = Run::new();
    for mut cells in lines {
        let name = cells.next().unwrap_or_default();
        for (column, cell) in header.iter().skip(1).zip(cells) {
            if let Ok(value) = cell.parse() {
                run.insert((name.to_owned(), (*column).to_owned()), value);
            }
        }
    }
    run
}

fn missed(run: &Run) -> Option<f64> {
    let count = |name: &str| run.get(&key(name, "count"));
    let (missed, ticks) = (count("deadline_misses")?, count("ticks")?);
    Some(missed / (ticks + missed) * 1e6)
}

/// The table: medians of the turns, and medians of the ratios within a turn; and their least and
/// greatest values where a row says so.
fn table(runs: &[Vec<Run>; KINDS.len()]) -> Option<String> {
    let mut text = "figure,without,why,why_ratio,follow,follow_ratio,small\n".to_owned();
    let mut row = |name: &str, choice: Choice, of: &dyn Fn(&Run) -> Option<f64>| {
        let values = |runs: &Vec<Run>| runs.iter().map(of).collect::<Option<Vec<f64>>>();
        let [without, why, follow, small] = runs.each_ref().map(values);
        let (without, why, follow, small) = (without?, why?, follow?, small?);
        let ratio = |other: &[f64]| {
            let ratios = other.iter().zip(&without).map(|(b, a)| b / a);
            choice(ratios.collect())
        };
        let (why_ratio, follow_ratio) = (ratio(&why)?, ratio(&follow)?);
        let [without, why, follow, small] = [without, why, follow, small].map(choice);
        text += &format!(
            "\"{name}\",{:.1},{:.1},{why_ratio:.3},{:.1},{follow_ratio:.3},{:.1}\n",
            without?, why?, follow?, small?
        );
        Some(())
    };
    for (name, line, column) in FIGURES {
        let key = key(line, column);
        row(name, median, &|run| run.get(&key).map(|ns| ns / 1e3))?;
    }
    for (name, line, column, choice) in SPREADS {
        let key = key(line, column);
        row(name, choice, &|run| run.get(&key).map(|ns| ns / 1e3))?;
    }
    row(MISSED, median, &missed)?;
    row(LOAD, median, &|run| run.get(&key(LOAD, "count")).copied())?;
    Some(text)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn least(values: Vec<f64>) -> Option<f64> {
    values.into_iter().min_by(f64::total_cmp)
}

fn greatest(values: Vec<f64>) -> Option<f64> {
    values.into_iter().max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run whose times are `times` a hundred microseconds.
    fn of(times: f64) -> Run {
        let ns = times * 1e5;
        let mut text = "name,count,p50,p90,p99\n".to_owned();
        let mut names: Vec<&str> = FIGURES.iter().map(|figure| figure.1).collect();
        names.dedup();
        for name in names {
            text += &format!("{name},1000,{ns},{ns},{}\n", 2.0 * ns);
        }
        text += &format!("{LOAD},1.5,,,\n");
        text += "ticks,999000,,,\n";
        text += &format!("deadline_misses,{},,,\n", 1000.0 * times);
        parsed(&text)
    }

    #[test]
    fn the_table_has_medians_and_the_medians_of_ratios_within_a_turn() {
        // One round of five was slow for all kinds. It does not change the median ratios.
        let turns = [1.0, 1.0, 7.0, 1.0, 1.0];
        let runs = [1.0, 2.0, 0.5, 0.1].map(|k| turns.iter().map(|turn| of(k * turn)).collect());
        let table = table(&runs).unwrap();
        let lines: Vec<&str> = table.lines().collect();
        assert!(load().is_some_and(|load| load >= 0.0));
        assert_eq!(lines.len(), 1 + FIGURES.len() + SPREADS.len() + 2);
        assert_eq!(
            lines[1],
            "\"wake-up p50, µs\",100.0,200.0,2.000,50.0,0.500,10.0"
        );
        assert_eq!(
            lines[6],
            "\"motion to force p99, µs\",200.0,400.0,2.000,100.0,0.500,20.0"
        );
        assert_eq!(
            lines[15],
            "\"motion to force p50, greatest turn, µs\",700.0,1400.0,2.000,350.0,0.500,70.0"
        );
        assert!(
            lines[20].starts_with("\"missed in a million periods\",1000.0,"),
            "{table}"
        );
    }

    #[test]
    fn a_run_without_a_figure_makes_no_table() {
        let runs = [of(1.0), Run::new(), of(1.0), of(1.0)].map(|run| vec![run]);
        assert_eq!(table(&runs), None);
    }
}
