//! Test programs of `cargo xtask test`: two run at a time, and each is timed.
//!
//! Most tests wait: for devices, clocks and other processes. Cargo runs one test program after the
//! other, so several cargos share the programs. Each starts every test program through a copy of
//! this program, which takes it or finds that another cargo has taken it. The copy shows the
//! output once the program has ended, and writes a line with the seconds and the name.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

/// First argument of the copy that cargo starts: the folder and the test program follow.
const MARK: &str = "--share-a-test";
/// File of times in the folder.
const TIMES: &str = "times";
/// Rows of the table of test programs.
const SLOWEST: usize = 20;

/// Times of one `cargo xtask test`.
pub(crate) struct Timings {
    steps: Vec<(&'static str, f64)>,
    /// Has a file of times, with one line per test program: seconds, a tab, its name. Each
    /// program that is taken has a file of its output.
    folder: PathBuf,
    runner: PathBuf,
}

impl Timings {
    /// Puts the runner into `folder` and forgets earlier times.
    pub(crate) fn new(folder: &Path) -> io::Result<Self> {
        let (programs, runner) = (folder.join("programs"), folder.join("runner"));
        std::fs::copy(std::env::current_exe()?, &runner)?;
        if programs.exists() {
            std::fs::remove_dir_all(&programs)?;
        }
        std::fs::create_dir_all(&programs)?;
        std::fs::write(programs.join(TIMES), "")?;
        Ok(Self {
            steps: Vec::new(),
            folder: programs,
            runner,
        })
    }

    /// Cargo's setting that has test programs shared and timed.
    pub(crate) fn runner(&self) -> String {
        let words = [&self.runner, &PathBuf::from(MARK), &self.folder];
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
        let text = std::fs::read_to_string(self.folder.join(TIMES)).unwrap_or_default();
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

/// Runs and times a test program if cargo asks for that and no other cargo has taken it: then its
/// outcome.
pub(crate) fn run(args: &[OsString]) -> Option<ExitCode> {
    let [mark, folder, program, args @ ..] = args else {
        return None;
    };
    if mark != MARK {
        return None;
    }
    let (folder, program) = (Path::new(folder), Path::new(program));
    let outcome = match take(folder, program) {
        Ok(Some(output)) => run_taken(folder, program, args, &output),
        Ok(None) => return Some(ExitCode::SUCCESS),
        Err(error) => Err(error),
    };
    Some(outcome.unwrap_or_else(|error| {
        eprintln!("cannot run {}: {error}", program.display());
        ExitCode::FAILURE
    }))
}

/// Creates the file of a program's output. `None` if it is there already.
fn take(folder: &Path, program: &Path) -> io::Result<Option<File>> {
    let path = folder.join(program.file_name().unwrap_or_default());
    let mut options = OpenOptions::new();
    match options.read(true).append(true).create_new(true).open(path) {
        Ok(file) => Ok(Some(file)),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(None),
        Err(error) => Err(error),
    }
}

fn run_taken(
    folder: &Path,
    program: &Path,
    args: &[OsString],
    mut output: &File,
) -> io::Result<ExitCode> {
    let package = std::env::var("CARGO_PKG_NAME").unwrap_or_default();
    let name = format!("{package}: {}", name(program));
    println!("-- {name} begins");
    let start = Instant::now();
    let mut command = Command::new(program);
    command.args(args).stdout(output.try_clone()?);
    let status = command.stderr(output.try_clone()?).status()?;
    let seconds = start.elapsed().as_secs_f64();

    let mut times = OpenOptions::new().append(true).open(folder.join(TIMES))?;
    // Other programs' outputs wait until this one is shown.
    times.lock()?;
    times.write_all(format!("{seconds:.3}\t{name}\n").as_bytes())?;
    println!("\n-- {name}: {seconds:.1} s, {status}");
    io::Seek::rewind(&mut output)?;
    io::copy(&mut output, &mut io::stdout())?;
    io::stdout().flush()?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(ExitCode::from(code.unwrap_or(101)))
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
    fn a_program_is_taken_once() {
        let folder = std::env::temp_dir().join(format!("xtask-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let taken = |name: &str| take(&folder, Path::new(name)).unwrap().is_some();
        assert_eq!(
            ["/t/a-1", "/t/a-2", "/t/a-1"].map(taken),
            [true, true, false]
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn other_commands_are_not_taken() {
        assert!(run(&["test".into(), "a".into(), "b".into()]).is_none());
    }
}
