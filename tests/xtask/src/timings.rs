//! Times of the steps and of the slowest test programs of `cargo xtask test`, and the tests that
//! passed only when they were repeated.

use std::io;
use std::path::{Path, PathBuf};

use crate::program::{MARK, REPEATED};
/// Rows of the table of test programs.
const SLOWEST: usize = 20;
/// Times of one `cargo xtask test`.
pub(crate) struct Timings {
    steps: Vec<(&'static str, f64)>,
    /// One line per test program: seconds, a tab, its name. One line per repeated test: `REPEATED`,
    /// a tab, its name.
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
        if !programs.is_empty() {
            println!("\nseconds  slowest test programs");
        }
        for (seconds, name) in programs {
            println!("{seconds:7.1}  {name}");
        }
        let unsteady = unsteady(&text);
        if !unsteady.is_empty() {
            println!("\nunsteady: failed beside other tests, passed alone. Mend them.");
        }
        for name in unsteady {
            println!("         {name}");
        }
    }
}

/// Tests in a file of times that passed only when they were repeated.
fn unsteady(text: &str) -> Vec<&str> {
    text.lines()
        .filter_map(|line| line.strip_prefix(REPEATED)?.strip_prefix('\t'))
        .collect()
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
    fn repeated_tests_are_told_apart_from_times() {
        let text = "1.5\ta: b\nrepeated\ta: b: c\n";
        assert_eq!(unsteady(text), ["a: b: c"]);
        assert_eq!(slowest(text), [(1.5, "a: b")]);
    }
}
