//! `evaluate`: the charts of the solvers. Not shipped.
//!
//! ```text
//! accuracy   scene × method × spheres → reference (finite elements) → accuracy.{csv,svg}, index.html
//! ```

mod accuracy;
mod body;
mod chart;
mod convergence;
mod methods;
mod organ;
mod reference;
mod scene;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Charts of the solvers: accuracy against speed, measured against finite elements.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Displacement, force and volume error of every method, against its time.
    Accuracy {
        /// Where accuracy.csv, accuracy.svg and index.html go.
        #[arg(long)]
        out: PathBuf,
        /// Sphere counts.
        #[arg(long, value_delimiter = ',', default_values_t = [250, 581, 1200])]
        spheres: Vec<usize>,
        /// Layers of elements of the reference. Twice as many take ten times as long.
        #[arg(long, default_value_t = 12)]
        layers: usize,
    },
    /// How far the reference may be trusted: the same scenes on ever finer meshes.
    Reference {
        /// Where reference.csv goes.
        #[arg(long)]
        out: PathBuf,
        /// Layers of elements, rising.
        #[arg(long, value_delimiter = ',', default_values_t = [8, 12, 16])]
        layers: Vec<usize>,
    },
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Accuracy {
            out,
            spheres,
            layers,
        } => accuracy(&out, spheres, layers),
        Command::Reference { out, layers } => convergence(&out, &layers),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("evaluate: {message}");
            ExitCode::FAILURE
        }
    }
}

fn accuracy(out: &std::path::Path, spheres: Vec<usize>, layers: usize) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let ask = accuracy::Ask {
        spheres,
        layers,
        kinds: vec![scene::Kind::Sag, scene::Kind::Pull, scene::Kind::Twist(90)],
    };
    let rows = accuracy::run(&ask)?;
    let svg = chart::svg(&rows)?;
    let about = format!("Reference: {layers} layers of elements. {}", machine());
    let write = |name: &str, text: &str| {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
    };
    accuracy::write_csv(&rows, &out.join("accuracy.csv")).map_err(|e| e.to_string())?;
    write("accuracy.svg", &svg)?;
    write("index.html", &chart::page(&rows, &svg, &about))?;
    println!("{}", out.join("index.html").display());
    Ok(())
}

/// The processor's own name, for the page.
fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name"));
    name.map_or_else(
        || "Unknown processor.".to_owned(),
        |n| format!("{}.", n.trim_start_matches([' ', '\t', ':'])),
    )
}

fn convergence(out: &std::path::Path, layers: &[usize]) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let kinds = [scene::Kind::Sag, scene::Kind::Pull, scene::Kind::Twist(90)];
    let rows = convergence::run(&kinds, layers, 581)?;
    let path = out.join("reference.csv");
    std::fs::write(&path, convergence::csv(&rows)).map_err(|e| format!("{}: {e}", path.display()))
}
