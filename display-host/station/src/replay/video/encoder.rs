//! ffmpeg, which makes a film of raw pictures.

use std::ffi::OsStr;
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};

use crate::problem::Problem;

/// A running encoder.
#[derive(Debug)]
pub(super) struct Encoder {
    child: Child,
    pictures: Option<ChildStdin>,
    path: PathBuf,
}

impl Encoder {
    /// Starts ffmpeg. The ending of `path` names the format: mp4, mkv, webm.
    pub(super) fn begin(path: &Path, size: [u32; 2], rate: u32) -> Result<Self, Problem> {
        Self::begin_as(OsStr::new("ffmpeg"), path, size, rate)
    }

    fn begin_as(
        program: &OsStr,
        path: &Path,
        [width, height]: [u32; 2],
        rate: u32,
    ) -> Result<Self, Problem> {
        if width % 2 + height % 2 > 0 {
            return Err(format!("--size {width}x{height}: a film needs even sides").into());
        }
        let mut command = Command::new(program);
        command
            .args([
                "-loglevel",
                "error",
                "-nostdin",
                "-y",
                "-f",
                "rawvideo",
                "-pix_fmt",
                "rgba",
            ])
            .args([
                "-s",
                &format!("{width}x{height}"),
                "-r",
                &rate.to_string(),
                "-i",
                "-",
            ])
            // Raters must not find out when and by whom the film was made.
            .args([
                "-an",
                "-map_metadata",
                "-1",
                "-fflags",
                "+bitexact",
                "-flags:v",
                "+bitexact",
            ])
            .args(["-pix_fmt", "yuv420p"])
            .arg(path.file_name().map_or_else(
                || path.into(),
                |it| {
                    // A name that begins with a dash is no option.
                    let folder = path.parent().filter(|it| !it.as_os_str().is_empty());
                    folder.unwrap_or(Path::new(".")).join(it)
                },
            ))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| match error.kind() {
            ErrorKind::NotFound => "a film needs ffmpeg, which is not installed: \
                                    `apt install ffmpeg`. Without it, --frames draws pictures"
                .to_owned(),
            _ => format!("cannot start ffmpeg: {error}"),
        })?;
        Ok(Self {
            pictures: child.stdin.take(),
            child,
            path: path.to_owned(),
        })
    }

    /// Takes the next picture, RGBA.
    pub(super) fn push(&mut self, picture: &[u8]) -> Result<(), Problem> {
        let pictures = self.pictures.as_mut();
        let written = pictures.is_some_and(|it| it.write_all(picture).is_ok());
        match written {
            true => Ok(()),
            // ffmpeg gave up, and says why.
            false => Err(self.problem()),
        }
    }

    /// Ends the film.
    pub(super) fn end(mut self) -> Result<(), Problem> {
        self.pictures = None;
        let status = self.child.wait();
        match status.is_ok_and(|it| it.success()) {
            true => Ok(()),
            false => Err(self.problem()),
        }
    }

    fn problem(&mut self) -> Problem {
        self.pictures = None;
        let mut said = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            let _ = errors.read_to_string(&mut said);
        }
        let _ = self.child.wait();
        let said = session::printable(said.lines().last().unwrap_or("no reason given"));
        format!(
            "{}: ffmpeg failed: {said}; name another file, e.g. film.mp4 or film.mkv",
            self.path.display()
        )
        .into()
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        self.pictures = None;
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_computer_without_ffmpeg_is_told_what_to_install() {
        let nothing = OsStr::new("/nowhere/ffmpeg");
        let path = Path::new("film.mp4");
        let said = Encoder::begin_as(nothing, path, [64, 64], 25).expect_err("no ffmpeg");
        assert!(said.to_string().contains("apt install ffmpeg"), "{said}");
        let said = Encoder::begin_as(nothing, path, [65, 64], 25).expect_err("odd");
        assert!(
            said.to_string().contains("65x64: a film needs even sides"),
            "{said}"
        );
    }

    #[test]
    fn an_encoder_that_gives_up_says_why() {
        // Ends at once, as ffmpeg does when it does not know a format.
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("ffmpeg");
        let script = "#!/bin/sh\necho 'no such format' >&2\nexit 1\n";
        std::fs::write(&program, script).unwrap();
        let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(&program, mode).unwrap();
        let path = folder.path().join("film.xyz");
        let encoder = Encoder::begin_as(program.as_os_str(), &path, [64, 64], 25).unwrap();
        let said = encoder.end().expect_err("it gave up").to_string();
        assert!(
            said.contains("ffmpeg failed: no such format; name another file"),
            "{said}"
        );
    }
}
