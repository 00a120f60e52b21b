//! `calot centre`, a centre of many stations, and the process that reports this station to a
//! centre. Both are the program `calot-centre`, a file beside this program, so that this program
//! does not contain its packages.

use std::ffi::OsString;
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use hardware::station::StationFile;

use crate::home;
use crate::problem::Problem;
use crate::run::args::RunArgs;
use crate::say;

/// Name of the program.
const PROGRAM: &str = "calot-centre";
/// Longest wait for the reporting process to send the last results and end.
const PATIENCE: Duration = Duration::from_secs(13);

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
    let program = match program() {
        Ok(program) => program,
        // `--help` works even if the program is missing.
        Err(problem) if args.arguments.iter().any(|it| it == "--help" || it == "-h") => {
            println!("`calot centre` is a program of its own, and {problem}");
            return Ok(ExitCode::SUCCESS);
        }
        Err(problem) => return Err(problem),
    };
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

/// A centre to which this station will be reported.
#[derive(Debug)]
pub(crate) struct Centre(Command);

impl Centre {
    /// The centre that the user or the station file names. Fails if its program or its keys are
    /// missing.
    pub(crate) fn of(args: &RunArgs) -> Result<Option<Self>, Problem> {
        let Some((address, keys)) = named(args)? else {
            return Ok(None);
        };
        let mut command = Command::new(program()?);
        command.args(["join", "--connect", &address, "--station", &args.station]);
        command.arg("--keys").arg(keys);
        command.args(["--with-parent", &std::process::id().to_string()]);
        if let Some(trainee) = &args.task.trainee {
            command.args(["--trainee", trainee]);
            command.arg("--store").arg(args.task.store.path()?);
        }
        // A terminal's Ctrl-C reaches the station alone, which ends this process last.
        command.stdin(Stdio::null()).process_group(0);
        Ok(Some(Self(command)))
    }

    /// Starts the process that reports to the centre.
    pub(crate) fn tell(mut self) -> Result<Told, Problem> {
        match self.0.spawn() {
            Ok(child) => Ok(Told(child)),
            Err(error) => Err(format!("cannot start {PROGRAM}: {error}").into()),
        }
    }
}

/// Address, and folder of keys. The command line overrides the station file.
fn named(args: &RunArgs) -> Result<Option<(String, PathBuf)>, Problem> {
    // The run that started the station reports it.
    if args.attach {
        return Ok(None);
    }
    let file = args.controller.devices.station_file.as_deref();
    let file = file.map(StationFile::read).transpose()?;
    let (address, keys) = file
        .and_then(|it| it.centre)
        .map_or((None, None), |it| (Some(it.address), it.keys));
    let Some(address) = args.centre.centre.clone().or(address) else {
        return Ok(None);
    };
    let own = || home::config().map(|it| it.join("centre-keys"));
    let keys = args.centre.centre_keys.clone().or(keys).or_else(own);
    let keys = keys.ok_or("there is no home folder; name the keys with --centre-keys")?;
    if !keys.is_dir() {
        return Err(format!(
            "there is no folder of keys {}: `calot link keys` makes keys of a member; put them there, or \
             name their folder with --centre-keys",
            keys.display()
        )
        .into());
    }
    Ok(Some((address, keys)))
}

/// The process that reports this station to a centre. The run goes on without it.
#[derive(Debug)]
pub(crate) struct Told(Child);

impl Told {
    /// Lets the process send the last results, and ends it.
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
        // Results that were not sent wait in the store.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Alone {
        #[command(flatten)]
        run: RunArgs,
    }

    fn asked(words: &[&str]) -> Result<Option<(String, PathBuf)>, String> {
        let parsed = Alone::try_parse_from([&["run"], words].concat());
        let args = parsed.map_err(|error| error.to_string())?.run;
        named(&args).map_err(|problem| problem.to_string())
    }

    #[test]
    fn a_centre_is_named_by_the_user_or_by_the_station_file() {
        let folder = tempfile::tempdir().unwrap();
        let (file, keys) = (
            folder.path().join("station.toml"),
            folder.path().join("keys"),
        );
        let words = |path: &std::path::Path| path.display().to_string();
        let lines = format!("[centre]\naddress = \"a:1\"\nkeys = \"{}\"\n", words(&keys));
        std::fs::write(&file, lines).unwrap();
        let from_file = ["--station-file", &words(&file)];
        let said = asked(&from_file).unwrap_err();
        assert!(said.contains("there is no folder of keys"), "{said}");
        std::fs::create_dir(&keys).unwrap();
        let of = |address: &str, keys| Ok(Some((String::from(address), keys)));
        assert_eq!(asked(&from_file), of("a:1", keys.clone()));
        let both = [&from_file[..], &["--centre", "b:2"]].concat();
        assert_eq!(asked(&both), of("b:2", keys));
        let named = ["--centre", "b:2", "--centre-keys", &words(folder.path())];
        assert_eq!(asked(&named), of("b:2", folder.path().into()));
        let attached = [&from_file[..], &["--attach"]].concat();
        assert_eq!(asked(&attached), Ok(None), "the station's own run tells");
        assert_eq!(asked(&[]), Ok(None));
    }
}
