//! `calot replay --what-if`: applies the recorded hands to other tissue or to another solver.

use core::fmt::Write as _;
use std::cell::Cell;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use figures::html::{STYLE, escape};
use figures::times;
use rt_process::replay::Replay;
use serde::Serialize;
use session::{Session, printable};
use shared_mem::inputs::RunSetup;
use shared_mem::scene::SceneFile;

use super::args::ReplayArgs;
use super::judge::{Different, Judge};
use super::recorded::{LeftOut, without_gap};
use super::show::STACK_BYTES;
use crate::args::SceneArgs;
use crate::document;
use crate::problem::Problem;
use crate::say;
use crate::scene;

/// Largest number of points per line of a chart.
const POINTS: usize = 1500;
/// Ticks from one row of the table to the next. The ticks in between are left out.
const TICKS_A_ROW: usize = 10;

/// State of a run at a tick.
#[derive(Debug, Clone, Copy)]
struct Point {
    at_s: f64,
    force_n: f64,
    tip_m: [f64; 3],
}

/// Comparison of two runs of the same hands: as recorded, and on the other tissue or solver.
#[derive(Debug, Serialize)]
struct Compared {
    recorded: String,
    what_if: String,
    seconds: f64,
    /// Greatest force on the hand in each run, N.
    force_max_n: [f64; 2],
    /// Greatest difference between the two forces, N.
    force_difference_max_n: f64,
    /// Root mean square difference between the two forces, N.
    force_difference_rms_n: f64,
    /// Greatest distance between the two tips, mm.
    tip_apart_max_mm: f64,
    /// Root mean square distance between the two tips, mm.
    tip_apart_rms_mm: f64,
    /// First difference between the recording and its recomputation.
    first_difference: Option<Different>,
    #[serde(flatten)]
    left_out: LeftOut,
}

/// One of the two runs.
struct Run {
    points: Vec<Point>,
    first_difference: Option<Different>,
    left_out: LeftOut,
}

impl Compared {
    /// Warnings about the validity of the comparison.
    fn warnings(&self) -> Vec<String> {
        let different = self.first_difference.as_ref().map(|first| {
            format!(
                "{}: this program does not compute what was recorded",
                first.in_words()
            )
        });
        different
            .into_iter()
            .chain(self.left_out.in_words())
            .collect()
    }
}

/// Computes both runs, writes the page and the table, and prints their paths.
pub(super) fn run(
    args: &ReplayArgs,
    session: &Session,
    recorded: &SceneFile,
    out: &Path,
) -> Result<ExitCode, Problem> {
    let temporary =
        shared_mem::service::user_folder()?.join(format!("what-if-{}.calot", std::process::id()));
    let other = other_scene(args, &temporary);
    let _ = std::fs::remove_file(&temporary);
    let other = other?;
    let other = other.as_ref().unwrap_or(recorded);
    let mut setup = session.setup;
    setup.paper_iterations = args.what_if_iterations.unwrap_or(setup.paper_iterations);
    let names = [
        name(recorded, &session.setup, "recorded"),
        name(other, &setup, "what if"),
    ];
    say::note(format_args!("running {} and {}", names[0], names[1]));
    let path = session.path();
    let (first, second) = std::thread::scope(|scope| {
        let second = std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, || {
                play(path, other, &setup).map_err(|it| it.to_string())
            });
        let first = play(path, recorded, &session.setup);
        (first, second.map(std::thread::ScopedJoinHandle::join))
    });
    let second = second?.map_err(|_| "the second run panicked; please report this")??;
    let first = first?;
    let runs = [first.points, second.points];
    if runs.iter().any(Vec::is_empty) {
        return Err("the session holds no tick that can be run".into());
    }
    let compared = compare(&runs, names, first.first_difference, first.left_out);
    for warning in compared.warnings() {
        say::note(format_args!("warning: {warning}"));
    }
    write(out, &compared, &runs)?;
    if args.json {
        document::WHAT_IF.answer(&compared)?;
    }
    say::note(format_args!(
        "force differs by {:.3} N at most ({:.3} rms), the tips are {:.2} mm apart at most; wrote {} \
         and {}",
        compared.force_difference_max_n,
        compared.force_difference_rms_n,
        compared.tip_apart_max_mm,
        out.join("what_if.html").display(),
        out.join("what_if.csv").display()
    ));
    Ok(ExitCode::SUCCESS)
}

/// The scene named by --what-if, if any.
fn other_scene(args: &ReplayArgs, temporary: &Path) -> Result<Option<SceneFile>, Problem> {
    let Some(named) = &args.what_if else {
        return Ok(None);
    };
    let named = SceneArgs {
        scene: named.clone(),
        meshes: args.meshes.clone(),
    };
    let path = scene::compile(&named, temporary)?;
    Ok(Some(SceneFile::open(&path)?))
}

fn name(scene: &SceneFile, setup: &RunSetup, role: &str) -> String {
    let solver = match setup.paper_iterations {
        0 => String::new(),
        iterations => format!(", the paper's solver in {iterations} iterations"),
    };
    let spheres = scene.spheres().len();
    format!(
        "{role}: {}, {spheres} spheres{solver}",
        printable(scene.name())
    )
}

fn play(path: &Path, scene: &SceneFile, setup: &RunSetup) -> Result<Run, Problem> {
    let mut session = Session::open(path)?;
    let mut first_ns = None;
    let mut points = Vec::new();
    let mut judge = Judge::default();
    let (gap, done) = (Cell::new(None), Cell::new(0.0));
    let replay = Replay::new(scene, setup)?;
    replay.run(without_gap(&mut session, &gap, &done), |replayed| {
        let now_ns = replayed.record.now_ns;
        let tool = replayed.view.tool;
        let first_ns = *first_ns.get_or_insert(now_ns);
        let at_s = now_ns.saturating_sub(first_ns) as f64 / 1e9;
        points.push(Point {
            at_s,
            force_n: f64::from(tool.force_n.norm()),
            tip_m: tool.tip_m.map(f64::from).into(),
        });
        judge.look(replayed, at_s, replay.organs());
        true
    })?;
    Ok(Run {
        points,
        first_difference: judge.first,
        left_out: LeftOut::of(&session, gap.get()),
    })
}

fn apart_m(a: &Point, b: &Point) -> f64 {
    let squares = a.tip_m.iter().zip(&b.tip_m).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

fn compare(
    runs: &[Vec<Point>; 2],
    [recorded, what_if]: [String; 2],
    first_difference: Option<Different>,
    left_out: LeftOut,
) -> Compared {
    let [a, b] = runs;
    let pairs = || a.iter().zip(b);
    let max = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0), |(sum, n), x| (sum + x * x, n + 1));
        (sum / f64::from(count.max(1))).sqrt()
    };
    let force = || pairs().map(|(a, b)| (a.force_n - b.force_n).abs());
    let apart = || pairs().map(|(a, b)| apart_m(a, b) * 1e3);
    Compared {
        recorded,
        what_if,
        seconds: a.last().map_or(0.0, |point| point.at_s),
        force_max_n: runs
            .each_ref()
            .map(|run| max(&mut run.iter().map(|it| it.force_n))),
        force_difference_max_n: max(&mut force()),
        force_difference_rms_n: rms(&mut force()),
        tip_apart_max_mm: max(&mut apart()),
        tip_apart_rms_mm: rms(&mut apart()),
        first_difference,
        left_out,
    }
}

fn write(out: &Path, compared: &Compared, runs: &[Vec<Point>; 2]) -> Result<(), Problem> {
    let failed = |path: &Path, error| format!("{}: {error}", path.display());
    std::fs::create_dir_all(out).map_err(|error| failed(out, error))?;
    for (name, text) in [
        ("what_if.html", page(compared, runs)),
        ("what_if.csv", table(runs)),
    ] {
        let path = out.join(name);
        let file = session::create_private(&path);
        file.and_then(|mut file| file.write_all(text.as_bytes()))
            .map_err(|error| failed(&path, error))?;
    }
    Ok(())
}

fn table([a, b]: &[Vec<Point>; 2]) -> String {
    let mut text = "s,recorded_force_n,what_if_force_n,recorded_x_m,recorded_y_m,recorded_z_m,\
                    what_if_x_m,what_if_y_m,what_if_z_m\n"
        .to_owned();
    for (a, b) in a.iter().zip(b).step_by(TICKS_A_ROW) {
        let _ = write!(text, "{:.3},{:.4},{:.4}", a.at_s, a.force_n, b.force_n);
        for x in a.tip_m.iter().chain(&b.tip_m) {
            let _ = write!(text, ",{x:.6}");
        }
        text.push('\n');
    }
    text
}

fn page(compared: &Compared, runs: &[Vec<Point>; 2]) -> String {
    let [a, b] = runs;
    let line = |run: &[Point], value: &dyn Fn(usize, &Point) -> f64| {
        let step = run.len().div_ceil(POINTS).max(1);
        let all = run.iter().enumerate().step_by(step);
        all.map(|(i, point)| (point.at_s, value(i, point)))
            .collect::<Vec<_>>()
    };
    let force = [line(a, &|_, it| it.force_n), line(b, &|_, it| it.force_n)];
    let difference = line(a, &|i, it| b.get(i).map_or(0.0, |b| b.force_n - it.force_n));
    let way = |run: &[Point]| {
        let first = run.first().copied();
        line(run, &|_, it| {
            first.map_or(0.0, |first| apart_m(&first, it) * 1e3)
        })
    };
    let ways = [way(a), way(b)];
    let apart = line(a, &|i, it| b.get(i).map_or(0.0, |b| apart_m(it, b) * 1e3));
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Calot: what if</title><style>{STYLE}</style>\
         <h1>The same hands</h1><p class=\"lead\">{:.1} s. {}; {}.</p><p>Force on the hand differs by \
         <b>{:.3} N</b> at most, {:.3} N rms; the tips are <b>{:.2} mm</b> apart at most, {:.2} mm rms. The \
         hand does not feel the other force: it moves as it was recorded.</p>",
        compared.seconds,
        escape(&compared.recorded),
        escape(&compared.what_if),
        compared.force_difference_max_n,
        compared.force_difference_rms_n,
        compared.tip_apart_max_mm,
        compared.tip_apart_rms_mm,
    );
    for warning in compared.warnings() {
        let _ = write!(page, "<p><b>Warning</b>: {}</p>", escape(&warning));
    }
    let charts = [
        (
            "Force on the hand",
            times::courses(&[("recorded", &force[0]), ("what if", &force[1])], "N"),
        ),
        (
            "Difference of the force, what if − recorded",
            times::courses(&[("difference", &difference)], "N"),
        ),
        (
            "Distance of the tip from its start",
            times::courses(&[("recorded", &ways[0]), ("what if", &ways[1])], "mm"),
        ),
        (
            "Distance between the tips",
            times::courses(&[("distance", &apart)], "mm"),
        ),
    ];
    for (title, chart) in charts {
        let _ = write!(
            page,
            "<h2>{title}</h2><figure>{}</figure>",
            chart.unwrap_or_default()
        );
    }
    page + "</html>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_reports_a_gap_and_a_difference() {
        let point = Point {
            at_s: 0.0,
            force_n: 0.0,
            tip_m: [0.0; 3],
        };
        let runs = [vec![point], vec![point]];
        let difference = Different {
            tick: 7,
            at_s: 0.007,
            what: "organ",
            organ: Some("liver".to_owned()),
            organ_tick: Some(7),
        };
        let gap = LeftOut {
            gap_at_tick: Some(9),
            ..LeftOut::default()
        };
        let names = ["recorded", "what if"].map(str::to_owned);
        let page = page(&compare(&runs, names, Some(difference), gap), &runs);
        assert!(
            page.contains("tick 7 ") && page.contains("tick 9 "),
            "{page}"
        );
    }
}
