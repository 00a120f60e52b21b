//! `evaluate`: measures solvers, contact, haptics and the drawn skin, as charts. Not shipped.
//!
//! ```text
//! reference   scene × finer and finer meshes → difference between the meshes
//! accuracy    case × method × spheres → error against the reference, and time
//!             with --peers: competitors in Python, beside Calot
//! haptics     device × delay × hand × law → stiffest stable contact
//! stability   case × method → largest value that the method survives
//! collision   organ × size × way → time, and agreement with the exact contact
//! force       case × contact law × spheres → force over depth against the reference
//! surface     scene × hand × organ → faults of the drawn skin under tools
//! rest        value of a recipe → speed of tissue that should rest
//! stay        organ × work → where everything lies two seconds later
//! heat        structure × current × time → how far heat spreads
//! solve-force solves the missing references of force
//! calculix    two references of force, by CalculiX → comparison of the forces
//! measured    published measurement → Calot's result under the same condition
//! hands       recorded hands of surgeons and novices → the metrics that separate them
//! ablation    tuned value × change → what becomes better or worse
//! all         the first ten, as CSV, SVG and one offline page
//! tables      the CSV files in tests/results → the tables of its README.md
//! ```

mod ablation;
mod accuracy;
mod body;
mod case;
mod collision;
mod csv;
mod focus;
mod force;
mod hands;
mod haptics;
mod heat;
mod measured;
mod methods;
mod organ;
mod page;
mod peers;
mod prepared;
mod reference;
mod rest;
mod scene;
mod seeded_hand;
mod solved;
mod stability;
mod stay;
mod surface;
mod tables;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread::{Builder, JoinHandle};

use clap::{Args, Parser, Subcommand};

use crate::page::Section;

/// Makes charts of the solvers: speed against accuracy, in comparison with finite elements, and the
/// limits of the methods.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// Options that every chart takes.
#[derive(Args)]
struct Asked {
    /// Folder for the CSV files, charts and index.html.
    #[arg(long)]
    out: PathBuf,
    /// Makes a reduced run that takes seconds instead of many minutes. Its results are coarse.
    #[arg(long)]
    quick: bool,
    /// Runs only the cases whose name contains this ("press", "liver: sag"). `accuracy` also runs
    /// the first case, on which settings are calibrated.
    #[arg(long, value_name = "TEXT")]
    case: Option<String>,
    /// Runs `force` only for cases with a reference, of any mesher, in OUT/reference or in the
    /// repository. No reference is solved.
    #[arg(long)]
    kept: bool,
}

/// Options of `solve-force`.
#[derive(Args)]
struct AskedSolve {
    #[command(flatten)]
    all: Asked,
    /// Makes elements as large as the contact, so that a case takes minutes. Its table has mesher
    /// 3. References without torque are solved again.
    #[arg(long, conflicts_with = "quick")]
    large: bool,
}

/// Options of `accuracy`.
#[derive(Args)]
struct AskedAccuracy {
    #[command(flatten)]
    all: Asked,
    /// Runs competitors (MuJoCo, Newton and others) in turns with Calot, in the first three scenes
    /// alone. PYTHON is the one in which tests/evaluate/peers/README.md installs them.
    #[arg(long, value_name = "PYTHON")]
    peers: Option<PathBuf>,
    /// Takes what is not measured from this accuracy.csv: other scenes and, with `--peers`, all
    /// other methods; without it, the competitors.
    #[arg(long, value_name = "FILE")]
    merge: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Command {
    /// Measures the reference: the same scenes on finer and finer meshes.
    Reference(Asked),
    /// Measures displacement, force and volume errors of every method against its time, and of
    /// competitors with `--peers`.
    Accuracy(AskedAccuracy),
    /// Finds stability limits: which method survives which case, and up to which value.
    Stability(Asked),
    /// Compares force and torque over depth under rigid tools with finite elements.
    Force(Asked),
    /// Solves the missing references of `force`, and stores them in OUT/reference.
    SolveForce(AskedSolve),
    /// Compares two references of `force` with CalculiX (`ccx`).
    Calculix(Asked),
    /// Measures time and agreement of the methods that find the spheres, vertices or faces that the
    /// instruments touch.
    Collision(Asked),
    /// Tests whether contact is stable under a hand: devices, delays, hands, laws.
    Haptics(Asked),
    /// Finds faults of the drawn skin under tools: stretched edges, folds, gaps, loose ends.
    Surface(Asked),
    /// Tests whether tissue comes to rest: sweeps of material, spheres, hold, gravity and form, and
    /// the remaining speed after 5 s.
    Rest(Asked),
    /// Presses, pulls and sweeps every organ with a tool. Finds tissue that left its place, lies in
    /// another organ or still moves 2 s later.
    Stay(Asked),
    /// Holds the hook's current on a mesentery and a duct. Measures how far heat spreads, beside a
    /// published figure.
    Heat(Asked),
    /// Measures recorded hands of surgeons and novices with the metrics of sessions. Finds which
    /// metrics separate the two groups, at which rates and with which noise.
    ///
    /// The repository has no such recordings. Example: evaluate hands TRIALS --out DIR --leave-out
    /// Lung/N4/05
    Hands(hands::HandsArgs),
    /// Compares Calot with measurements that others published: silicones between plates, a swinging
    /// beam, organs, instruments.
    Measured(measured::MeasuredArgs),
    /// Changes each tuned value of contact, force and tissue: off, 30 % less, 30 % more. Measures
    /// what becomes better or worse. Takes hours: it builds a copy of the sources in which the
    /// values are variable.
    Ablation(ablation::AblationArgs),
    /// Measures everything but `ablation`, `calculix`, `hands` and `measured`. Real organs are read
    /// from the folder that CALOT_ANATOMY names.
    All(Asked),
    /// Rewrites the tables of README.md in a folder from the CSV files in the same folder, and
    /// those of the guide for latency testers.
    Tables {
        /// Folder of README.md and the CSV files.
        #[arg(long, default_value = "tests/results")]
        folder: PathBuf,
    },
}

/// One chart. Its command and its module have the same name.
#[derive(Clone, Copy)]
enum Chart {
    Accuracy,
    Stability,
    Force,
    Collision,
    Haptics,
    Surface,
    Rest,
    Stay,
    Heat,
    Reference,
}

impl Chart {
    /// All charts in the order of the page.
    const ALL: [Self; 10] = [
        Self::Accuracy,
        Self::Stability,
        Self::Force,
        Self::Collision,
        Self::Haptics,
        Self::Surface,
        Self::Rest,
        Self::Stay,
        Self::Heat,
        Self::Reference,
    ];

    /// Measures, writes the chart's files, and returns its sections of the page.
    fn measure(self, asked: &Asked) -> Result<Vec<Section>, String> {
        match self {
            Self::Accuracy => measure_accuracy(asked, None, None),
            Self::Stability => measure_stability(asked),
            Self::Force => measure_force(asked),
            Self::Collision => measure_collision(asked),
            Self::Haptics => measure_haptics(asked),
            Self::Surface => measure_surface(asked),
            Self::Rest => measure_rest(asked),
            Self::Stay => measure_stay(asked),
            Self::Heat => measure_heat(asked),
            Self::Reference => measure_reference(asked),
        }
    }
}

/// Stack of the thread that measures, bytes. Simulation states of 4 MB each are built on it.
const STACK_BYTES: usize = 64 << 20;

fn main() -> ExitCode {
    let command = Cli::parse().command;
    let measures = Builder::new().stack_size(STACK_BYTES);
    let done = match measures
        .spawn(move || perform(command))
        .map(JoinHandle::join)
    {
        Ok(Ok(done)) => done,
        Ok(Err(_)) => Err("it panicked; please report this".to_owned()),
        Err(error) => Err(format!("cannot start a thread: {error}")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("evaluate: {message}");
            ExitCode::FAILURE
        }
    }
}

fn perform(command: Command) -> Result<(), String> {
    command.refuse_unused()?;
    match command {
        Command::Reference(asked) => run(&asked, &[Chart::Reference]),
        Command::Accuracy(asked) => run_accuracy(&asked),
        Command::Stability(asked) => run(&asked, &[Chart::Stability]),
        Command::Force(asked) => run(&asked, &[Chart::Force]),
        Command::Calculix(asked) => compare_with_calculix(&asked),
        Command::SolveForce(asked) => {
            let meshes = match (asked.all.quick, asked.large) {
                (true, _) => force::Meshes::Quick,
                (false, true) => force::Meshes::Large,
                (false, false) => force::Meshes::Fine,
            };
            force::solve(&asked.all.out, meshes, asked.all.only())
        }
        Command::Collision(asked) => run(&asked, &[Chart::Collision]),
        Command::Haptics(asked) => run(&asked, &[Chart::Haptics]),
        Command::Surface(asked) => run(&asked, &[Chart::Surface]),
        Command::Rest(asked) => run(&asked, &[Chart::Rest]),
        Command::Stay(asked) => run(&asked, &[Chart::Stay]),
        Command::Heat(asked) => run(&asked, &[Chart::Heat]),
        Command::Hands(asked) => measure_hands(&asked),
        Command::Measured(asked) => compare_with_measured(&asked),
        Command::Ablation(asked) => ablation::run(&asked),
        Command::All(asked) => run(&asked, &Chart::ALL),
        Command::Tables { folder } => rewrite_tables(&folder),
    }
}

impl Command {
    /// Refuses an option that would have no effect.
    fn refuse_unused(&self) -> Result<(), String> {
        let (Self::Reference(asked)
        | Self::Accuracy(AskedAccuracy { all: asked, .. })
        | Self::Stability(asked)
        | Self::Calculix(asked)
        | Self::SolveForce(AskedSolve { all: asked, .. })
        | Self::Collision(asked)
        | Self::Haptics(asked)
        | Self::Surface(asked)
        | Self::Rest(asked)
        | Self::Stay(asked)
        | Self::Heat(asked)) = self
        else {
            return Ok(());
        };
        if asked.kept {
            return Err("--kept has no effect here: it belongs to `force` and `all`".to_owned());
        }
        match self {
            Self::Haptics(_) if !["", WAIT, FELT].contains(&asked.only()) => Err(format!(
                "--case has no effect here but `--case {WAIT}`, which measures waits for the tick \
                 alone, and `--case {FELT}`, which measures strokes alone: `haptics` measures all \
                 of its cases"
            )),
            _ => Ok(()),
        }
    }
}

/// Case of `haptics`: samples that wait for the tick.
const WAIT: &str = "wait";
/// Case of `haptics`: strokes into walls, with the measures of OmniSurg's haptic bench.
const FELT: &str = "felt";

fn run(asked: &Asked, charts: &[Chart]) -> Result<(), String> {
    let mut sections = Vec::new();
    make_folder(&asked.out)?;
    for chart in charts {
        sections.extend(chart.measure(asked)?);
    }
    finish(asked, &sections)
}

fn run_accuracy(asked: &AskedAccuracy) -> Result<(), String> {
    make_folder(&asked.all.out)?;
    let sections = measure_accuracy(&asked.all, asked.peers.as_deref(), asked.merge.as_deref())?;
    finish(&asked.all, &sections)
}

fn make_folder(out: &Path) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))
}

/// Writes the page.
fn finish(asked: &Asked, sections: &[Section]) -> Result<(), String> {
    let out = &asked.out;
    write(out, "index.html", &page::whole(sections, asked.quick))?;
    println!("{}", out.join("index.html").display());
    Ok(())
}

fn rewrite_tables(folder: &Path) -> Result<(), String> {
    let path = folder.join("README.md");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    write(folder, "README.md", &tables::rewrite(&text, folder)?)?;
    let guide = folder.join(tables::GUIDE);
    match std::fs::read_to_string(&guide) {
        Ok(text) => write(folder, tables::GUIDE, &tables::rewrite(&text, folder)?),
        // The guide is missing if the folder is a copy elsewhere.
        Err(_) => Ok(()),
    }
}

impl Asked {
    /// Text that a case's name must contain; empty for all cases.
    fn only(&self) -> &str {
        self.case.as_deref().unwrap_or_default()
    }
}

fn measure_accuracy(
    asked: &Asked,
    peers: Option<&Path>,
    merge: Option<&Path>,
) -> Result<Vec<Section>, String> {
    let (out, only) = (&asked.out, asked.only());
    let mut ask = match peers {
        None => accuracy::Ask::new(asked.quick),
        Some(python) => {
            let python = python.to_owned();
            let folder = out.join("peers");
            accuracy::Ask::beside(peers::Peers { python, folder }, asked.quick)
        }
    };
    // The first case calibrates the methods, which a run beside competitors does not need.
    let mut first = peers.is_none();
    ask.cases
        .retain(|case| std::mem::take(&mut first) || case.name().contains(only));
    let whole = |rows: &[accuracy::Row]| match merge {
        Some(file) => accuracy::with_kept(rows, file),
        None => Ok(rows.to_vec()),
    };
    let mut keep = |rows: &[accuracy::Row]| {
        let rows = whole(rows)?;
        write(out, "accuracy.csv", &accuracy::csv(&rows))?;
        if let Some(svg) = page::competitors_chart(&rows)? {
            write(out, "competitors.svg", &svg)?;
        }
        write(out, "accuracy.svg", &page::accuracy_chart(&rows)?)
    };
    let rows = whole(&accuracy::run(&ask, &mut keep)?)?;
    if let Some(svg) = page::main_chart(&rows)? {
        write(out, "main.svg", &svg)?;
    }
    page::accuracy(&rows, &page::accuracy_chart(&rows)?)
}

fn measure_stability(asked: &Asked) -> Result<Vec<Section>, String> {
    let out = &asked.out;
    let rows = stability::run(asked.quick, asked.only())?;
    write(out, "stability.csv", &stability::csv(&rows))?;
    let svg = page::stability_chart(&rows)?;
    write(out, "stability.svg", &svg)?;
    Ok(vec![page::stability(&rows, &svg)])
}

fn measure_force(asked: &Asked) -> Result<Vec<Section>, String> {
    let out = &asked.out;
    let measured = force::run(out, asked.quick, asked.only(), asked.kept)?;
    write(out, "force.csv", &force::csv(&measured.rows))?;
    write(out, "force_depth.csv", &force::depth_csv(&measured.rows))?;
    write(out, "force_reference.csv", &measured.references)?;
    write(out, "force_steps.csv", &force::steps_csv(&measured.steps))?;
    let svg = force::chart(&measured.rows)?;
    write(out, "force.svg", &svg)?;
    Ok(vec![force::section(&measured, &svg)])
}

fn compare_with_calculix(asked: &Asked) -> Result<(), String> {
    let table = force::run_calculix(&asked.out, asked.only())?;
    write(&asked.out, "force_calculix.csv", &table)
}

fn measure_collision(asked: &Asked) -> Result<Vec<Section>, String> {
    let out = &asked.out;
    let measured = collision::run(asked.quick, asked.only())?;
    write(out, "collision.csv", &collision::csv(&measured))?;
    let svg = collision::chart(&measured)?;
    write(out, "collision.svg", &svg)?;
    Ok(vec![collision::section(&measured, &svg)])
}

fn measure_haptics(asked: &Asked) -> Result<Vec<Section>, String> {
    let out = &asked.out;
    if asked.only() == FELT {
        let rows = haptics::felt(asked.quick)?;
        write(out, "haptics.csv", &haptics::csv(&rows))?;
        return Ok(Vec::new());
    }
    let waits = haptics::waits(asked.quick)?;
    write(out, "haptics_wait.csv", &haptics::waits_csv(&waits))?;
    if asked.only() == WAIT {
        return Ok(Vec::new());
    }
    let rows = haptics::run(asked.quick)?;
    write(out, "haptics.csv", &haptics::csv(&rows))?;
    let svg = haptics::chart(&rows)?;
    write(out, "haptics.svg", &svg)?;
    Ok(vec![haptics::section(&rows, &svg)])
}

fn measure_surface(asked: &Asked) -> Result<Vec<Section>, String> {
    let rows = surface::run(&asked.out, asked.quick, asked.only())?;
    write(&asked.out, "surface.csv", &surface::csv(&rows))?;
    Ok(vec![surface::section(&rows)])
}

fn measure_hands(asked: &hands::HandsArgs) -> Result<(), String> {
    let out = &asked.out;
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let measured = hands::run(asked)?;
    write(out, "hands.csv", &hands::csv(&measured))?;
    let title = "Calot: experts and novices, measured";
    let html = page::titled(title, &hands::sections(&measured)?, "");
    write(out, "hands.html", &html)?;
    println!("{}", out.join("hands.html").display());
    Ok(())
}

fn compare_with_measured(asked: &measured::MeasuredArgs) -> Result<(), String> {
    let out = &asked.out;
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let measured = measured::run(asked)?;
    write(out, "measured.csv", &measured::csv(&measured))?;
    let title = "Calot beside published measurements";
    let warning = if asked.quick { page::QUICK } else { "" };
    let html = page::titled(title, &measured::sections(&measured)?, warning);
    write(out, "measured.html", &html)?;
    println!("{}", out.join("measured.html").display());
    Ok(())
}

fn measure_rest(asked: &Asked) -> Result<Vec<Section>, String> {
    let rows = rest::run(&asked.out, asked.quick, asked.only())?;
    write(&asked.out, "rest.csv", &rest::csv(&rows))?;
    Ok(vec![rest::section(&rows)])
}

fn measure_stay(asked: &Asked) -> Result<Vec<Section>, String> {
    let rows = stay::run(asked.quick, asked.only())?;
    write(&asked.out, "stay.csv", &stay::csv(&rows))?;
    Ok(vec![stay::section(&rows)])
}

fn measure_heat(asked: &Asked) -> Result<Vec<Section>, String> {
    let rows = heat::run(asked.quick, asked.only())?;
    write(&asked.out, "heat.csv", &heat::csv(&rows))?;
    let svg = heat::chart(&rows)?;
    write(&asked.out, "heat.svg", &svg)?;
    Ok(vec![heat::section(&rows, &svg)])
}

fn measure_reference(asked: &Asked) -> Result<Vec<Section>, String> {
    let layers: &[usize] = if asked.quick {
        &[4, 6]
    } else {
        &[6, 9, 12, 18]
    };
    let rows = reference::run(layers, 581, asked.only())?;
    write(&asked.out, "reference.csv", &reference::csv(&rows))?;
    Ok(vec![page::reference(&rows)])
}

fn write(out: &Path, name: &str, text: &str) -> Result<(), String> {
    let path = out.join(name);
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}
