//! Makes a film of raw pictures with ffmpeg.

use std::ffi::{OsStr, OsString};
use std::io::{BufRead as _, BufReader, ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use crate::problem::Problem;

/// A running encoder. It writes to a temporary file next to the film. [`Encoder::keep`] gives this
/// file the film's name; otherwise the file is removed.
#[derive(Debug)]
pub(super) struct Encoder {
    child: Child,
    pictures: Option<ChildStdin>,
    /// Thread that reads the messages of ffmpeg. It returns the last line.
    said: Option<JoinHandle<String>>,
    path: PathBuf,
    partial: PathBuf,
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
        let partial = partial_of(path);
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
            // No metadata: raters must not learn when and by whom the film was made.
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
            .arg(&partial)
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
            said: child.stderr.take().map(last_line),
            child,
            path: path.to_owned(),
            partial,
        })
    }

    /// Takes the next picture, RGBA.
    pub(super) fn push(&mut self, picture: &[u8]) -> Result<(), Problem> {
        let pictures = self.pictures.as_mut();
        let written = pictures.is_some_and(|it| it.write_all(picture).is_ok());
        match written {
            true => Ok(()),
            // ffmpeg ended early. Its last line gives the reason.
            false => Err(self.problem()),
        }
    }

    /// Ends the film. [`Encoder::keep`] gives it its name.
    pub(super) fn end(&mut self) -> Result<(), Problem> {
        self.pictures = None;
        let status = self.child.wait();
        match status.is_ok_and(|it| it.success()) {
            true => Ok(()),
            false => Err(self.problem()),
        }
    }

    /// Gives the ended film its name.
    pub(super) fn keep(self) -> Result<(), Problem> {
        let named = std::fs::rename(&self.partial, &self.path);
        named.map_err(|error| format!("{}: cannot name the film: {error}", self.path.display()))?;
        Ok(())
    }

    fn problem(&mut self) -> Problem {
        self.pictures = None;
        let _ = self.child.wait();
        let said = self.said.take().and_then(|it| it.join().ok());
        let said = session::printable(said.as_deref().unwrap_or("no reason given"));
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
        // After `keep`, the process has ended and the temporary file has the film's name: these
        // calls then fail without harm.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.partial);
    }
}

/// Temporary file next to the film. It has the same extension, which names the format. Its name
/// does not begin with a dash, because ffmpeg would take it for an option.
fn partial_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|it| !it.as_os_str().is_empty());
    let mut name = OsString::from(format!(".part-{}-", std::process::id()));
    name.push(path.file_name().unwrap_or_default());
    folder.unwrap_or(Path::new(".")).join(name)
}

/// Reads the messages of ffmpeg, so that it never waits for a reader. The thread returns the last
/// line.
fn last_line(errors: ChildStderr) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut last = String::from("no reason given");
        for line in BufReader::new(errors).split(b'\n').map_while(Result::ok) {
            if !line.is_empty() {
                last = String::from_utf8_lossy(&line).into_owned();
            }
        }
        last
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_ffmpeg_the_error_names_the_package() {
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

    /// A shell script in place of ffmpeg. `$file` is the last argument: the file to write.
    fn program(folder: &Path, script: &str) -> PathBuf {
        let program = folder.join("ffmpeg");
        let script = format!("#!/bin/bash\nfile=\"${{@: -1}}\"\n{script}\n");
        std::fs::write(&program, script).unwrap();
        let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(&program, mode).unwrap();
        program
    }

    /// Names of the files in a folder, without the program.
    fn files(folder: &Path) -> Vec<OsString> {
        let all = std::fs::read_dir(folder).unwrap();
        let names = all.map(|it| it.unwrap().file_name());
        names.filter(|it| it != "ffmpeg").collect()
    }

    fn begun(folder: &Path, script: &str) -> Encoder {
        let program = program(folder, script);
        Encoder::begin_as(program.as_os_str(), &folder.join("film.mkv"), [64, 64], 25).unwrap()
    }

    #[test]
    fn an_encoder_that_ends_early_gives_the_reason_and_leaves_no_file() {
        // The script ends at once, as ffmpeg does when it does not know a format. It prints more
        // than a pipe holds.
        let folder = tempfile::tempdir().unwrap();
        let script = "echo half > \"$file\"; seq 20000 >&2; echo 'no such format' >&2; exit 1";
        let mut encoder = begun(folder.path(), script);
        let said = encoder.end().expect_err("it gave up").to_string();
        assert!(
            said.contains("ffmpeg failed: no such format; name another file"),
            "{said}"
        );
        drop(encoder);
        assert_eq!(files(folder.path()), Vec::<OsString>::new());
    }

    #[test]
    fn only_a_kept_film_gets_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let mut encoder = begun(folder.path(), "cat > \"$file\"");
        encoder.push(b"picture").unwrap();
        encoder.end().unwrap();
        assert!(!folder.path().join("film.mkv").exists());
        encoder.keep().unwrap();
        assert_eq!(files(folder.path()), ["film.mkv"]);
        let film = std::fs::read(folder.path().join("film.mkv")).unwrap();
        assert_eq!(film, b"picture");
    }

    #[test]
    fn a_dropped_encoder_is_ended() {
        let folder = tempfile::tempdir().unwrap();
        let encoder = begun(folder.path(), "echo half > \"$file\"; exec sleep 600");
        drop(encoder);
        assert_eq!(files(folder.path()), Vec::<OsString>::new());
    }

    #[test]
    fn a_film_that_cannot_be_named_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let mut encoder = begun(folder.path(), "cat > /dev/null");
        encoder.end().unwrap();
        let said = encoder.keep().expect_err("no file").to_string();
        assert!(said.contains("film.mkv: cannot name the film:"), "{said}");
    }
}
