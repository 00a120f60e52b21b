//! Times of the steps and of the slowest test programs of `cargo xtask test`.
//!
//! Cargo starts each test program through a copy of this program, which writes a line with the
//! seconds and the name.

use std::ffi::OsString;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

/// First argument of the copy that cargo starts. The file of times and the test program follow it.
const MARK: &str = "--time-a-test";
/// Rows of the table of test programs.
const SLOWEST: usize = 20;
/// Test programs that compute all the time, by package and name. Most other programs wait for
/// devices and stations: the end-to-end tests computed for 1080 s while 2 cores had 1349 s each. So
/// these run beside the others and get what those leave.
pub(crate) const COMPUTING: [&str; 3] = [
    "display-host: all",
    "scene-prepare: scenes",
    "surgeon: operation",
];
/// Variable that makes the runner leave out the programs that run beside the others.
pub(crate) const BESIDE: &str = "CALOT_COMPUTING_TESTS_BESIDE";

/// Times of one `cargo xtask test`.
pub(crate) struct Timings {
    steps: Vec<(&'static str, f64)>,
    /// One line per test program: seconds, a tab, its name.
    file: PathBuf,
    runner: PathBuf,
}

impl Timings {
    /// Puts the runner into `folder` and forgets earlier times.
    pub(crate) fn new(folder: &Path) -> io::Result<Self> {
        let (file, runner) = (folder.join("times"), folder.join("runner"));
        std::fs::copy(std::env::current_exe()?, &runner)?;
        std::fs::write(&file, "")?;
        Ok(Self {
            steps: Vec::new(),
            file,
            runner,
        })
    }

    /// Cargo's setting that makes it start test programs through the runner.
    pub(crate) fn runner(&self) -> String {
        let words = [&self.runner, &PathBuf::from(MARK), &self.file];
        let words = words.map(|it| format!("{:?}", it.display().to_string()));
        format!("target.'cfg(all())'.runner = [{}]", words.join(", "))
    }

    pub(crate) fn add(&mut self, step: &'static str, seconds: f64) {
        self.steps.push((step, seconds));
    }

    /// Prints both tables.
    pub(crate) fn print(&self) {
        println!("\nseconds  step");
        for (name, seconds) in &self.steps {
            println!("{seconds:7.0}  {name}");
        }
        let text = std::fs::read_to_string(&self.file).unwrap_or_default();
        let programs = slowest(&text);
        if programs.is_empty() {
            return;
        }
        println!("\nseconds  slowest test programs");
        for (seconds, name) in programs {
            println!("{seconds:7.1}  {name}");
        }
    }
}

/// The slowest programs in a file of times, slowest first.
fn slowest(text: &str) -> Vec<(f64, &str)> {
    let mut programs: Vec<(f64, &str)> = text
        .lines()
        .filter_map(|line| line.split_once('\t'))
        .filter_map(|(seconds, name)| Some((seconds.parse().ok()?, name)))
        .collect();
    programs.sort_by(|a, b| b.0.total_cmp(&a.0));
    programs.truncate(SLOWEST);
    programs
}

/// If cargo asks for it, runs and times a test program, and returns the program's outcome.
pub(crate) fn run(args: &[OsString]) -> Option<ExitCode> {
    let [mark, file, program, args @ ..] = args else {
        return None;
    };
    if mark != MARK {
        return None;
    }
    let package = std::env::var("CARGO_PKG_NAME").unwrap_or_default();
    let name = format!("{package}: {}", name(Path::new(program)));
    if std::env::var_os(BESIDE).is_some() && COMPUTING.contains(&name.as_str()) {
        println!("\n{name} runs beside the others; its output follows at their end");
        return Some(ExitCode::SUCCESS);
    }
    let start = Instant::now();
    let status = match Command::new(program).args(args).status() {
        Ok(status) => status,
        Err(error) => {
            eprintln!("cannot run {}: {error}", Path::new(program).display());
            return Some(ExitCode::FAILURE);
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    let line = format!("{seconds:.3}\t{name}\n");
    let append = || {
        let mut file = OpenOptions::new().append(true).open(file)?;
        file.write_all(line.as_bytes())
    };
    if let Err(error) = append() {
        eprintln!("cannot note a test's time: {error}");
    }
    // A program that a signal ended has no code, so cargo cannot name the signal any more.
    if status.code().is_none() {
        eprintln!("{}: {status}", Path::new(program).display());
    }
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Some(ExitCode::from(code.unwrap_or(101)))
}

/// A test program's name without the hash that cargo appends.
fn name(program: &Path) -> String {
    let stem = program.file_stem().unwrap_or_default().to_string_lossy();
    let is_hash = |it: &str| it.len() == 16 && it.bytes().all(|it| it.is_ascii_hexdigit());
    match stem.rsplit_once('-') {
        Some((name, hash)) if is_hash(hash) => name.to_owned(),
        _ => stem.into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_programs_come_first_and_other_lines_are_left_out() {
        assert_eq!(
            slowest("1.5\ta: b\nnoise\n12.0\tc: d\n"),
            [(12.0, "c: d"), (1.5, "a: b")]
        );
    }

    #[test]
    fn a_program_is_named_without_its_hash() {
        let named = |path: &str| name(Path::new(path));
        assert_eq!(named("/t/deps/rt_core-0123456789abcdef"), "rt_core");
        assert_eq!(named("/t/deps/one-two"), "one-two");
    }

    #[test]
    fn programs_that_compute_are_test_programs_there_are() {
        let folders = [
            "display-host/display",
            "rt-core/prepare",
            "display-host/surgeon",
        ];
        for (name, folder) in COMPUTING.iter().zip(folders) {
            let (_, program) = name.split_once(": ").expect("package and name");
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
            let tests = root.join(folder).join("tests");
            let is_there =
                tests.join(program).is_dir() || tests.join(format!("{program}.rs")).is_file();
            assert!(is_there, "{name}");
        }
    }

    #[test]
    fn other_commands_are_not_timed() {
        assert!(run(&["test".into(), "a".into(), "b".into()]).is_none());
    }
}
