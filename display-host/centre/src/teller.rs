//! The program `calot tell` as a process: its frames, and the lines that it reads.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use tokio::io::AsyncWriteExt as _;
use tokio::process::{Child, ChildStdin, Command};

use crate::error::CentreError;

/// Starts `calot tell` for a station of this computer.
pub(crate) fn start(
    program: &Path,
    station: &str,
    trainee: Option<&str>,
) -> Result<Child, CentreError> {
    let mut command = Command::new(program);
    command.args(["tell", "--station", station, "--with-parent"]);
    command.arg(std::process::id().to_string());
    if let Some(trainee) = trainee {
        command.args(["--trainee", trainee]);
    }
    let command = command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let started = command.kill_on_drop(true).spawn();
    started.map_err(|error| CentreError::Teller {
        program: program.to_owned(),
        problem: error.to_string(),
    })
}

/// Writes a line to `calot tell`. If the program has ended, the end of its frames shows that.
pub(crate) async fn write(input: &mut ChildStdin, line: &[u8]) {
    let is_line = line.len() < 2000 && !line.contains(&b'\n');
    if is_line && input.write_all(&[line, b"\n"].concat()).await.is_ok() {
        let _ = input.flush().await;
    }
}

/// The program `calot` beside this one.
///
/// # Errors
/// [`CentreError::Teller`] if it is not there.
pub fn sibling(own: &Path) -> Result<PathBuf, CentreError> {
    let program = own.with_file_name("calot");
    match program.is_file() {
        true => Ok(program),
        false => Err(CentreError::Teller {
            program,
            problem: "it is not there".to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_of_the_station_stands_beside_this_one() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("calot-centre");
        let said = sibling(&own).unwrap_err().to_string();
        assert!(
            said.contains("tell`: it is not there. It belongs beside"),
            "{said}"
        );
        std::fs::write(folder.path().join("calot"), "").unwrap();
        assert!(sibling(&own).is_ok());
    }
}
