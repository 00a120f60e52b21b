//! One test program of `cargo xtask test`. Cargo starts it through a copy of this program, which
//! times it, and repeats failed tests that wait in real time.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::OpenOptions;
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, Command, ExitCode, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// First argument of the copy that cargo starts. The file of times and the test program follow it.
pub(crate) const MARK: &str = "--time-a-test";
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
/// Test programs, or whole packages, whose tests wait for devices and processes in real time. A
/// shared machine can stop any of them for a second. A failed test is repeated alone, once: it must
/// pass then, and the table at the end names it. All other tests give the same result each time.
const REAL_TIME: [&str; 8] = [
    "calot",
    "centre",
    "deliver",
    "display-host: live",
    "hardware: devices",
    "link",
    "rt-process",
    "shared-mem",
];
/// First word of the line about a test that passed only when it was repeated, in the file of times.
pub(crate) const REPEATED: &str = "repeated";
/// Most failed tests that are repeated. More are no accident.
const REPEATED_MOST: usize = 3;

/// If cargo asks for it, runs and times a test program, and returns the program's outcome.
pub(crate) fn run(args: &[OsString]) -> Option<ExitCode> {
    let [mark, file, program, args @ ..] = args else {
        return None;
    };
    if mark != MARK {
        return None;
    }
    let program = Path::new(program);
    let package = std::env::var("CARGO_PKG_NAME").unwrap_or_default();
    let name = format!("{package}: {}", name(program));
    if std::env::var_os(BESIDE).is_some() && COMPUTING.contains(&name.as_str()) {
        println!("\n{name} runs beside the others; its output follows at their end");
        return Some(ExitCode::SUCCESS);
    }
    let start = Instant::now();
    let (outcome, lines) = match run_and_repeat(program, args, is_real_time(&package, &name)) {
        Ok((outcome, repeated)) => {
            let line = |test: &String| format!("{REPEATED}\t{name}: {test}\n");
            (outcome, repeated.iter().map(line).collect())
        }
        Err(error) => {
            eprintln!("cannot run {}: {error}", program.display());
            return Some(ExitCode::FAILURE);
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    let lines = [format!("{seconds:.3}\t{name}\n"), lines].concat();
    let append = || {
        let mut file = OpenOptions::new().append(true).open(file)?;
        file.write_all(lines.as_bytes())
    };
    if let Err(error) = append() {
        eprintln!("cannot note a test's time: {error}");
    }
    // A program that a signal ended has no code, so cargo cannot name the signal any more.
    if outcome.code().is_none() {
        eprintln!("{}: {outcome}", program.display());
    }
    let code = outcome.code().and_then(|code| u8::try_from(code).ok());
    Some(ExitCode::from(code.unwrap_or(101)))
}

fn is_real_time(package: &str, name: &str) -> bool {
    REAL_TIME.contains(&package) || REAL_TIME.contains(&name)
}

/// Runs a program, and its few failed tests a second time if they wait in real time. Returns the
/// outcome, and the tests that passed only then.
fn run_and_repeat(
    program: &Path,
    args: &[OsString],
    is_real_time: bool,
) -> io::Result<(ExitStatus, BTreeSet<String>)> {
    let mut command = Command::new(program);
    command.args(args);
    if !is_real_time {
        return Ok((command.status()?, BTreeSet::new()));
    }
    let (outcome, failed) = seen(command.stdout(Stdio::piped()).spawn()?)?;
    if outcome.success() || failed.is_empty() || failed.len() > REPEATED_MOST {
        return Ok((outcome, BTreeSet::new()));
    }
    println!("\nrepeated alone, because they wait in real time: {failed:?}");
    let mut again = Command::new(program);
    again.args(args).arg("--exact").args(&failed);
    let outcome = again.arg("--test-threads=1").status()?;
    let repeated = if outcome.success() {
        failed
    } else {
        BTreeSet::new()
    };
    Ok((outcome, repeated))
}

/// Passes on what a program prints, and returns its outcome and the tests that it lists as failed.
fn seen(mut program: Child) -> io::Result<(ExitStatus, BTreeSet<String>)> {
    /// Longest wait for the rest of what an ended program printed. A process that it left running
    /// may keep the pipe open.
    const REST: Duration = Duration::from_secs(1);
    let (send, lines) = mpsc::channel();
    let output = program.stdout.take();
    std::thread::spawn(move || {
        for line in BufReader::new(output?).split(b'\n') {
            send.send(line.ok()?).ok()?;
        }
        Some(())
    });
    let mut failed = Failed::default();
    let mut ended_at: Option<Instant> = None;
    while ended_at.is_none_or(|at| at.elapsed() < REST) {
        match lines.recv_timeout(Duration::from_millis(100)) {
            Ok(line) => {
                let line = String::from_utf8_lossy(&line);
                println!("{line}");
                failed.see(&line);
            }
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
        if ended_at.is_none() && program.try_wait()?.is_some() {
            ended_at = Some(Instant::now());
        }
    }
    Ok((program.wait()?, failed.tests))
}

/// Reads the list of failed tests at the end of a program's output.
#[derive(Default)]
struct Failed {
    is_listing: bool,
    tests: BTreeSet<String>,
}

impl Failed {
    fn see(&mut self, line: &str) {
        if line == "failures:" {
            // The last list counts: an earlier one precedes the failures' own output.
            (self.is_listing, self.tests) = (true, BTreeSet::new());
        } else if self.is_listing {
            match line.strip_prefix("    ") {
                Some(test) => {
                    self.tests.insert(test.to_owned());
                }
                None => self.is_listing = line.is_empty() && self.tests.is_empty(),
            }
        }
    }
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
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

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

    /// A shell script in place of a test program. It fails until `folder/healed` exists.
    fn script(folder: &Path, failures: &str) -> std::path::PathBuf {
        use std::os::unix::fs::PermissionsExt as _;
        let path = folder.join("program");
        let text = format!(
            "#!/bin/sh\n\
            echo \"$@\" >> {folder}/asked\n\
            [ -e {folder}/healed ] && exit 0\n\
            {heal}\n\
            sleep 5 &\n\
            printf 'failures:\\n\\n---- a stdout ----\\n    no test\\n\\nfailures:\\n{failures}\\ntest result'\n\
            exit 101\n",
            folder = folder.display(),
            heal = format_args!("[ -e {0}/ill ] || touch {0}/healed", folder.display()),
        );
        std::fs::write(&path, text).expect("a folder of this test");
        let mode = std::fs::Permissions::from_mode(0o700);
        std::fs::set_permissions(&path, mode).expect("a file of this test");
        path
    }

    fn outcome(failures: &str, is_ill: bool, is_real_time: bool) -> (bool, Vec<String>, String) {
        static FOLDERS: AtomicU32 = AtomicU32::new(0);
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let folder = format!("calot-xtask-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        std::fs::create_dir(&folder).expect("a folder of this test");
        let program = script(&folder, failures);
        if is_ill {
            std::fs::write(folder.join("ill"), "").expect("a file of this test");
        }
        let (outcome, repeated) =
            run_and_repeat(&program, &["-q".into()], is_real_time).expect("a shell");
        let asked = std::fs::read_to_string(folder.join("asked")).expect("a file of it");
        std::fs::remove_dir_all(&folder).expect("a folder of this test");
        (outcome.success(), repeated.into_iter().collect(), asked)
    }

    #[test]
    fn a_failed_test_in_real_time_is_repeated_alone_and_named() {
        let names = ["a::b".to_owned(), "c".to_owned()].to_vec();
        let asked = "-q\n-q --exact a::b c --test-threads=1\n".to_owned();
        let passed = outcome("    a::b\\n    c\\n", false, true);
        assert_eq!(passed, (true, names, asked.clone()));
        let failed = outcome("    a::b\\n    c\\n", true, true);
        assert_eq!(failed, (false, Vec::new(), asked));
    }

    #[test]
    fn other_failures_are_not_repeated() {
        let asked = "-q\n".to_owned();
        let failed = (false, Vec::new(), asked);
        assert_eq!(outcome("    a\\n", false, false), failed, "computing");
        let many = "    a\\n    b\\n    c\\n    d\\n";
        assert_eq!(outcome(many, false, true), failed, "many");
        assert_eq!(
            outcome("", false, true),
            failed,
            "no list, as after a crash"
        );
    }
}
