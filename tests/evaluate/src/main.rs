//! `evaluate`: the charts of the solvers. Not shipped.
//!
//! ```text
//! reference   scene × ever finer meshes: how far the reference may be trusted
//! accuracy    case × method × spheres → error against the reference, against time
//! haptics     device × delay × hand × law → what contact may be rendered, and is it still
//! stability   case × method → survives or not, and up to where
//! collision   organ × size × way → time, and agreement with the exact answer
//! force       case × contact law × spheres → force over depth against the reference
//! all         everything, as CSV, SVG and one offline page
//! tables      the CSV files in tests/results → the tables of its README.md
//! ```

mod accuracy;
mod body;
mod case;
mod chart;
mod collision;
mod convergence;
mod csv;
mod focus;
mod force;
mod haptics;
mod methods;
mod organ;
mod page;
mod reference;
mod scene;
mod stability;
mod tables;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

/// Charts of the solvers: speed against accuracy, measured against finite elements, and where
/// methods fail.
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
    /// A reduced run: seconds instead of many minutes. Its figures are coarse.
    #[arg(long)]
    quick: bool,
    /// Only the cases whose name contains this ("press", "liver: sag"); of accuracy also the first,
    /// on which settings are calibrated.
    #[arg(long, value_name = "TEXT")]
    case: Option<String>,
    /// Of `force` only the cases whose reference lies in DIR/reference or in the repository
    /// already, of whichever mesher: nothing is solved.
    #[arg(long)]
    kept: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Convergence of the reference: the same scenes on ever finer meshes.
    Reference(Asked),
    /// Displacement, force and volume error of every method, against its time.
    Accuracy(Asked),
    /// Stability limits: every case with every method, survived or not, and its limit.
    Stability(Asked),
    /// Force over depth under rigid tools, against finite elements.
    Force(Asked),
    /// Collision: time and agreement of the methods that find the spheres, vertices or faces that
    /// the instruments touch.
    Collision(Asked),
    /// Does contact stay still under a hand: devices, delays, hands, laws.
    Haptics(Asked),
    /// All of these. Real organs are read from the folder that CALOT_ANATOMY names.
    All(Asked),
    /// Rewrites the tables of README.md in a folder from the CSV files beside it.
    Tables {
        /// The folder.
        #[arg(long, default_value = "tests/results")]
        folder: PathBuf,
    },
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Reference(asked) => run(&asked, [true, false, false, false, false, false]),
        Command::Accuracy(asked) => run(&asked, [false, true, false, false, false, false]),
        Command::Stability(asked) => run(&asked, [false, false, true, false, false, false]),
        Command::Force(asked) => run(&asked, [false, false, false, true, false, false]),
        Command::Collision(asked) => run(&asked, [false, false, false, false, true, false]),
        Command::Haptics(asked) => run(&asked, [false, false, false, false, false, true]),
        Command::All(asked) => run(&asked, [true; 6]),
        Command::Tables { folder } => rewrite_tables(&folder),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("evaluate: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(asked: &Asked, [trust, speed, limits, feel, meet, still]: [bool; 6]) -> Result<(), String> {
    let (out, quick) = (&asked.out, asked.quick);
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let only = asked.case.as_deref().unwrap_or_default();
    let mut sections = Vec::new();
    if speed {
        let mut ask = accuracy::Ask::new(quick);
        let mut first = true;
        ask.cases
            .retain(|case| std::mem::take(&mut first) || case.name().contains(only));
        let rows = accuracy::run(&ask)?;
        write(out, "accuracy.csv", &accuracy::csv(&rows))?;
        let svg = page::accuracy_chart(&rows)?;
        write(out, "accuracy.svg", &svg)?;
        if let Some(svg) = page::main_chart(&rows)? {
            write(out, "main.svg", &svg)?;
        }
        sections.extend(page::accuracy(&rows, &svg)?);
    }
    if limits {
        let rows = stability::run(quick, only)?;
        write(out, "stability.csv", &stability::csv(&rows))?;
        let svg = page::stability_chart(&rows)?;
        write(out, "stability.svg", &svg)?;
        sections.push(page::stability(&rows, &svg));
    }
    if feel {
        let measured = force::run(out, quick, only, asked.kept)?;
        write(out, "force.csv", &force::csv(&measured.rows))?;
        write(out, "force_depth.csv", &force::depth_csv(&measured.rows))?;
        write(out, "force_reference.csv", &measured.references)?;
        write(out, "force_steps.csv", &force::steps_csv(&measured.steps))?;
        let svg = force::chart(&measured.rows)?;
        write(out, "force.svg", &svg)?;
        sections.push(force::section(&measured, &svg));
    }
    if meet {
        let measured = collision::run(quick, only)?;
        write(out, "collision.csv", &collision::csv(&measured))?;
        let svg = collision::chart(&measured)?;
        write(out, "collision.svg", &svg)?;
        sections.push(collision::section(&measured, &svg));
    }
    if still {
        let rows = haptics::run(quick)?;
        write(out, "haptics.csv", &haptics::csv(&rows))?;
        let svg = haptics::chart(&rows)?;
        write(out, "haptics.svg", &svg)?;
        sections.push(haptics::section(&rows, &svg));
    }
    if trust {
        let layers: &[usize] = if quick { &[4, 6] } else { &[6, 9, 12, 18] };
        let rows = convergence::run(layers, 581, only)?;
        write(out, "reference.csv", &convergence::csv(&rows))?;
        sections.push(page::reference(&rows));
    }
    write(out, "index.html", &page::whole(&sections, quick))?;
    println!("{}", out.join("index.html").display());
    Ok(())
}

fn rewrite_tables(folder: &Path) -> Result<(), String> {
    let path = folder.join("README.md");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    write(folder, "README.md", &tables::rewrite(&text, folder)?)
}

fn write(out: &Path, name: &str, text: &str) -> Result<(), String> {
    let path = out.join(name);
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}
