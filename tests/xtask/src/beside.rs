//! Test programs that compute, beside those that wait.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use crate::program::COMPUTING;

/// Test programs that run at the lowest priority. They take no time from the others, whose devices
/// and stations work in real time.
pub(crate) struct Beside {
    cargo: Child,
    output: PathBuf,
}

impl Beside {
    /// Starts the programs. `settings` are arguments of cargo.
    pub(crate) fn start(
        settings: &[&str],
        environment: &[(&str, PathBuf)],
    ) -> Result<Self, String> {
        let folder = environment
            .first()
            .map_or("target".as_ref(), |it| it.1.as_path());
        let output = folder.join("computing-tests.log");
        let cargo = || {
            let out = File::create(&output)?;
            let errors = out.try_clone()?;
            let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
            Command::new("nice")
                .args(["-n", "19"])
                .arg(cargo)
                .args(words(settings))
                .envs(environment.iter().map(|(name, value)| (name, value)))
                .stdin(Stdio::null())
                .stdout(out)
                .stderr(errors)
                .spawn()
        };
        match cargo() {
            Ok(cargo) => Ok(Self { cargo, output }),
            Err(error) => Err(format!("cannot start tests beside the others: {error}")),
        }
    }

    /// Waits for the programs, prints their output, and returns whether they passed.
    pub(crate) fn finish(mut self) -> Result<(), String> {
        println!(
            "\n== waiting for the tests beside: {}",
            COMPUTING.join(", ")
        );
        let status = self.cargo.wait();
        print!("{}", read(&self.output));
        told(status.map_err(|error| error.to_string()))
    }
}

/// Arguments of cargo that run the programs.
fn words<'a>(settings: &[&'a str]) -> Vec<&'a str> {
    let mut words = [
        settings,
        &["test", "--locked", "--workspace", "--no-fail-fast"],
    ]
    .concat();
    for it in COMPUTING {
        let (_, program) = it.split_once(": ").unwrap_or(("", it));
        words.extend(["--test", program]);
    }
    words
}

fn read(output: &Path) -> String {
    let bytes = std::fs::read(output).unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn told(status: Result<ExitStatus, String>) -> Result<(), String> {
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("tests beside the others failed ({status})")),
        Err(error) => Err(format!("tests beside the others: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_programs_are_named_for_cargo() {
        let words = words(&["--config", "x"]);
        assert_eq!(words[..3], ["--config", "x", "test"]);
        assert_eq!(
            words[5..],
            [
                "--no-fail-fast",
                "--test",
                "all",
                "--test",
                "scenes",
                "--test",
                "operation"
            ][..]
        );
    }

    #[test]
    fn a_failure_beside_is_a_failure() {
        let status = |program: &str| Command::new(program).status().map_err(|it| it.to_string());
        assert!(told(status("true")).is_ok());
        let said = told(status("false")).unwrap_err();
        assert!(
            said.contains("tests beside the others failed (exit status: 1)"),
            "{said}"
        );
        assert!(told(status("/none")).is_err());
    }
}
