//! A centre of many stations: `calot centre`, and the process that tells one of this station. Both
//! are the program `calot-centre`, which stands beside this one, so that its packages are no part
//! of the station's programs.

use std::ffi::OsString;
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;

use crate::problem::Problem;
use crate::run::args::RunArgs;
use crate::say;

/// Name of the program.
const PROGRAM: &str = "calot-centre";
/// Longest wait for the process that tells the centre. It sends the last results.
const PATIENCE: Duration = Duration::from_secs(8);

#[derive(Debug, Clone, Args)]
#[command(disable_help_flag = true)]
pub(crate) struct CentreArgs {
    /// Arguments of the program; --help lists them
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "ARGUMENTS"
    )]
    arguments: Vec<OsString>,
}

/// Replaces this process by `calot-centre`.
pub(crate) fn run(args: &CentreArgs) -> Result<ExitCode, Problem> {
    let program = program()?;
    let error = Command::new(&program).args(&args.arguments).exec();
    Err(format!("{}: {error}", program.display()).into())
}

fn program() -> Result<PathBuf, Problem> {
    let program = std::env::current_exe()?.with_file_name(PROGRAM);
    match program.is_file() {
        true => Ok(program),
        false => Err(format!(
            "{} is not there: build it with `cargo build --release --manifest-path \
             display-host/centre/Cargo.toml --target-dir target`, or install it beside calot",
            program.display()
        )
        .into()),
    }
}

/// A process that tells a centre of this station. The run goes on without it.
#[derive(Debug)]
pub(crate) struct Told(Child);

impl Told {
    /// Starts the process, if the user names a centre.
    pub(crate) fn begin(args: &RunArgs) -> Result<Option<Self>, Problem> {
        let Some(address) = &args.centre.centre else {
            return Ok(None);
        };
        let mut command = Command::new(program()?);
        command.args(["join", "--connect", address, "--station", &args.station]);
        command.arg("--keys").arg(args.centre.keys()?);
        command.args(["--with-parent", &std::process::id().to_string()]);
        if let Some(trainee) = &args.task.trainee {
            command.args(["--trainee", trainee]);
            command.arg("--store").arg(args.task.store.path()?);
        }
        // A terminal's Ctrl-C reaches the station alone, which ends this process last.
        let command = command.stdin(Stdio::null()).process_group(0);
        let started = command.spawn();
        Ok(Some(Self(started.map_err(|error| {
            format!("cannot start {PROGRAM}: {error}")
        })?)))
    }

    /// Ends the process, which sends the last results before.
    pub(crate) fn end(mut self) {
        if let Ok(Some(status)) = self.0.try_wait() {
            if !status.success() {
                say::note(format_args!(
                    "warning: the centre heard nothing of the end: {PROGRAM} ended before ({status})"
                ));
            }
            return;
        }
        if let Some(id) = rustix::process::Pid::from_raw(self.0.id().cast_signed()) {
            let _ = rustix::process::kill_process(id, rustix::process::Signal::TERM);
        }
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if !matches!(self.0.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        // What it did not send waits in the store.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
