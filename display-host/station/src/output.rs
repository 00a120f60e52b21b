//! One rule for every file that a command writes: an existing file is replaced only with
//! `--overwrite`, and only if Calot wrote it. Otherwise the command refuses before it begins. If
//! Calot chooses the name itself and the name is taken, Calot adds a number instead of refusing.

use std::fs;
use std::io::{self, Read as _, Seek as _};
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

use clap::Args;
use hardware::station::StationFile;

use crate::problem::Problem;
use crate::say;

/// Number of bytes in which Calot's name is searched: at the start of a file, at the end of a
/// Parquet file.
const HEAD_BYTES: u64 = 1 << 20;

/// Prefix of a close picture's file name. A debrief leaves these files out, because it draws the
/// pictures itself.
pub(crate) const CLOSE: &str = "close_";

/// Option that permits the replacement of files.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct Overwrite {
    /// Replace files that an earlier command of Calot wrote under these names; any other file stays
    #[arg(long)]
    pub(crate) overwrite: bool,
}

/// Format of an output file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Session,
    Surfaces,
    Scene,
    Page,
    Json,
    Table,
    Columnar,
    Picture,
    Animation,
    Drawing,
    Station,
}

impl Format {
    /// Format of a file that Calot writes under this name as a result.
    pub(crate) fn of_result(name: &str) -> Option<Self> {
        let numbered = name
            .strip_prefix("frame_")
            .or_else(|| name.strip_prefix(CLOSE))
            .and_then(|it| it.strip_suffix(".png"));
        match name {
            "session.mcap" => Some(Self::Session),
            "summary.json" | "jitter.json" | "jitter.trace.json" | "photon.json" => {
                Some(Self::Json)
            }
            "report.html" | "debrief.html" | "what_if.html" | "jitter.html" | "photon.html" => {
                Some(Self::Page)
            }
            "what_if.csv" | "jitter.csv" => Some(Self::Table),
            "deepest_press.png" | "before_press.png" | "grasp.png" => Some(Self::Picture),
            _ => numbered
                .filter(|it| it.bytes().all(|byte| byte.is_ascii_digit()))
                .map(|_| Self::Picture),
        }
    }

    /// Format of a table that Calot exports under this name.
    pub(crate) fn of_export(name: &str) -> Option<Self> {
        let (table, extension) = name.split_once('.')?;
        let is_table = ["ticks", "events", "metrics", "columns"].contains(&table);
        match extension {
            "csv" if is_table => Some(Self::Table),
            "parquet" if is_table => Some(Self::Columnar),
            _ => None,
        }
    }

    /// Format of a file that Calot writes under this name to a gallery.
    pub(crate) fn of_gallery(name: &str) -> Option<Self> {
        match name.ends_with(".png") {
            true => Some(Self::Picture),
            false => (name == "index.html").then_some(Self::Page),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::Surfaces => "file of surfaces",
            Self::Scene => "compiled scene",
            Self::Page => "page",
            Self::Json => "JSON report",
            Self::Table => "table",
            Self::Columnar => "Parquet table",
            Self::Picture => "picture",
            Self::Animation => "animation",
            Self::Drawing => "drawing",
            Self::Station => "station file",
        }
    }

    /// A file of this format that Calot wrote starts with one of these.
    fn starts(self) -> &'static [&'static [u8]] {
        match self {
            Self::Session | Self::Surfaces => &[b"\x89MCAP0\r\n"],
            Self::Scene => &[&shared_mem::scene::MAGIC],
            Self::Page => &[b"<!doctype html>"],
            Self::Json => &[b"{", b"["],
            // Tables have no place for a name, so their columns are the mark.
            Self::Table => &[
                b"name,count,p50,p90,",
                b"s,recorded_force_n,",
                b"tick,time_s,time_unix_ns,",
                b"tick,time_s,device_x_m,",
                b"name,value,unit,definition,",
                b"table,column,type,",
                b"time_s,x_m,y_m,z_m,",
                b"task,difficulty,metrics_version,group,",
            ],
            Self::Columnar => &[b"PAR1"],
            Self::Picture => &[b"\x89PNG\r\n"],
            Self::Animation => &[b"GIF8"],
            Self::Drawing => &[b"<svg "],
            Self::Station => &[b""],
        }
    }

    /// True if Calot wrote this file in this format, or if the file is empty. Any valid station
    /// file counts as Calot's.
    fn is_of_calot(self, path: &Path) -> io::Result<bool> {
        if self == Self::Station {
            return Ok(
                fs::read_to_string(path).is_ok_and(|text| StationFile::parse(&text, path).is_ok())
            );
        }
        let mut head = Vec::new();
        let mut file = fs::File::open(path)?;
        io::Read::by_ref(&mut file)
            .take(HEAD_BYTES)
            .read_to_end(&mut head)?;
        if self == Self::Columnar {
            // A Parquet file names its program at the end.
            let end = file.metadata()?.len().saturating_sub(HEAD_BYTES);
            file.seek(io::SeekFrom::Start(end))?;
            file.take(HEAD_BYTES).read_to_end(&mut head)?;
        }
        let starts = self.starts().iter().any(|start| head.starts_with(start));
        let has = |mark: &str| {
            let mut words = head.windows(mark.len());
            words.any(|it| it.eq_ignore_ascii_case(mark.as_bytes()))
        };
        let named = match self {
            Self::Scene | Self::Table => true,
            // A recording and a file of surfaces start alike, but must not replace each other.
            Self::Surfaces => has(session::SURFACES_BY),
            Self::Session => has("calot") && !has(session::SURFACES_BY),
            _ => has("calot"),
        };
        Ok(head.is_empty() || (starts && named))
    }
}

/// Checks that `path` may be written. Errors begin with `option` and `path`.
pub(crate) fn check(
    option: &str,
    path: &Path,
    format: Format,
    overwrite: Overwrite,
) -> Result<(), Problem> {
    let shown = path.display();
    let Ok(there) = fs::metadata(path) else {
        return Ok(());
    };
    if there.is_dir() {
        return Err(format!("{option} {shown}: is a folder; name a file in it").into());
    }
    if there.file_type().is_block_device() {
        return Err(format!("{option} {shown}: is a disk; name a file").into());
    }
    // Pipes, character devices and empty files hold nothing that could be lost.
    if !there.is_file() || there.len() == 0 {
        return Ok(());
    }
    let name = format.name();
    let own = format
        .is_of_calot(path)
        .map_err(|error| format!("{option} {shown}: {error}; name another file"))?;
    match (own, overwrite.overwrite) {
        (true, true) => Ok(()),
        (true, false) => Err(format!(
            "{option} {shown}: there is a {name} of Calot already ({} bytes); name another file, or replace \
             it with --overwrite",
            there.len()
        )
        .into()),
        (false, _) => Err(format!(
            "{option} {shown}: the file that is there is no {name} of Calot, so it is never replaced; name \
             another file"
        )
        .into()),
    }
}

/// Checks that a command may write to `folder`. `format_of` returns the format of a name that the
/// command may write, and `None` for other names.
pub(crate) fn check_folder(
    option: &str,
    folder: &Path,
    format_of: fn(&str) -> Option<Format>,
    overwrite: Overwrite,
) -> Result<(), Problem> {
    if fs::metadata(folder).is_ok_and(|it| !it.is_dir()) {
        return Err(format!(
            "{option} {}: is a file; name a folder, or one that is not there yet",
            folder.display()
        )
        .into());
    }
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(());
    };
    let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
    names.sort();
    for name in names {
        if let Some(format) = name.to_str().and_then(format_of) {
            check(option, &folder.join(&name), format, overwrite).map_err(|problem| {
                problem
                    .to_string()
                    .replace("another file", "another folder")
            })?;
        }
    }
    Ok(())
}

/// Makes the folder of results: `named`, or without a name the first of `default`, `default-2`, …
/// that may be written.
pub(crate) fn folder(
    named: Option<&Path>,
    default: &str,
    format_of: fn(&str) -> Option<Format>,
    overwrite: Overwrite,
) -> Result<PathBuf, Problem> {
    let folder = match named {
        Some(folder) => {
            check_folder("--out", folder, format_of, overwrite)?;
            folder.to_owned()
        }
        None => free(Path::new(default), |path| {
            check_folder("--out", path, format_of, overwrite).is_ok()
        }),
    };
    // Fail early: results that cannot be written are lost.
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}

/// Path for a file: `named`, or without a name the first of `default`, `default-2`, … that may be
/// written.
pub(crate) fn file(
    named: Option<&Path>,
    default: &str,
    format: Format,
    overwrite: Overwrite,
) -> Result<PathBuf, Problem> {
    match named {
        Some(path) => check("--out", path, format, overwrite).map(|()| path.to_owned()),
        None => Ok(free(Path::new(default), |path| {
            check("--out", path, format, overwrite).is_ok()
        })),
    }
}

/// The first of `name`, `name-2`, `name-3`, … that may be written.
fn free(name: &Path, may: impl Fn(&Path) -> bool) -> PathBuf {
    let stem = name.file_stem().unwrap_or_default().to_string_lossy();
    let extension = name
        .extension()
        .map_or_else(String::new, |it| format!(".{}", it.to_string_lossy()));
    let numbered = |number: u32| name.with_file_name(format!("{stem}-{number}{extension}"));
    if may(name) {
        return name.to_owned();
    }
    let found = (2..10_000).map(numbered).find(|path| may(path));
    let found = found.unwrap_or_else(|| name.to_owned());
    say::note(format_args!(
        "{} is taken by earlier results; these go to {}",
        name.display(),
        found.display()
    ));
    found
}

/// Writes a file by a rename, so that its path always names a whole file, the old or the new one.
pub(crate) fn write(path: &Path, text: &str) -> io::Result<()> {
    // The file behind a link is replaced, not the link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&target).is_ok_and(|it| !it.is_file()) {
        return fs::write(target, text);
    }
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let draft = target.with_file_name(format!(".{name}.new"));
    let written = fs::write(&draft, text).and_then(|()| {
        if let Ok(before) = fs::metadata(&target) {
            fs::set_permissions(&draft, before.permissions())?;
        }
        fs::rename(&draft, &target)
    });
    if written.is_err() {
        let _ = fs::remove_file(&draft);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEEP: Overwrite = Overwrite { overwrite: false };
    const REPLACE: Overwrite = Overwrite { overwrite: true };

    fn said(checked: Result<(), Problem>) -> String {
        checked.unwrap_err().to_string()
    }

    #[test]
    fn a_file_of_calot_is_replaced_only_on_request_and_any_other_never() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        let own: [(Format, &[u8]); 10] = [
            (Format::Session, b"\x89MCAP0\r\n\x01....calot 0.1.0"),
            (
                Format::Surfaces,
                b"\x89MCAP0\r\n\x01....surfaces by calot: calot 0.1.0",
            ),
            (Format::Scene, &shared_mem::scene::MAGIC),
            (Format::Page, b"<!doctype html><title>Calot: debrief"),
            (Format::Json, b"{\"program\": \"calot 0.1.0\"}"),
            (Format::Table, b"name,count,p50,p90,p99\n"),
            (Format::Columnar, b"PAR1........calot 0.1.0....PAR1"),
            (Format::Picture, b"\x89PNG\r\n\x1a\n....tEXtSoftware\0Calot"),
            (Format::Animation, b"GIF89a....Calot"),
            (
                Format::Station,
                b"[haptic]\ndriver = \"woody\"\npath = \"/dev/ttyACM0\"\n",
            ),
        ];
        for (format, bytes) in own {
            fs::write(&path, bytes).unwrap();
            let error = said(check("--out", &path, format, KEEP));
            assert!(error.contains("--overwrite"), "{format:?}: {error}");
            assert!(check("--out", &path, format, REPLACE).is_ok(), "{format:?}");
            // The same file does not count as ours where another format is expected.
            let other = match format {
                Format::Session => Format::Page,
                _ => Format::Session,
            };
            let error = said(check("--out", &path, other, REPLACE));
            assert!(error.contains("never replaced"), "{format:?}: {error}");
        }
        let foreign: [(Format, &[u8]); 6] = [
            (Format::Session, b"my notes"),
            (Format::Surfaces, b"\x89MCAP0\r\n\x01....calot 0.1.0"),
            (Format::Session, b"\x89MCAP0\r\n\x01....libmcap"),
            (Format::Picture, b"\x89PNG\r\n\x1a\n...."),
            (Format::Json, b"{\"a\": 1}"),
            (Format::Station, b"driver = ["),
        ];
        for (format, bytes) in foreign {
            fs::write(&path, bytes).unwrap();
            for how in [KEEP, REPLACE] {
                let error = said(check("--record", &path, format, how));
                assert!(error.starts_with("--record"), "{error}");
                assert!(error.contains("never replaced"), "{error}");
            }
        }
    }

    #[test]
    fn empty_and_missing_files_and_devices_may_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let empty = folder.path().join("empty");
        fs::write(&empty, "").unwrap();
        for path in [
            &empty,
            &folder.path().join("missing"),
            Path::new("/dev/null"),
        ] {
            assert!(check("--out", path, Format::Session, KEEP).is_ok());
        }
        let error = said(check("--out", folder.path(), Format::Session, REPLACE));
        assert!(error.contains("is a folder"), "{error}");
    }

    #[test]
    fn a_folder_is_judged_by_the_names_that_will_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let judge = |how| check_folder("--out", folder.path(), Format::of_result, how);
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        fs::write(folder.path().join("frame_of_mine.png"), "mine").unwrap();
        assert!(judge(KEEP).is_ok());
        fs::write(folder.path().join("report.html"), "<!doctype html>Calot").unwrap();
        assert!(said(judge(KEEP)).contains("another folder"));
        assert!(judge(REPLACE).is_ok());
        fs::write(folder.path().join("frame_0003.png"), "mine").unwrap();
        assert!(said(judge(REPLACE)).contains("frame_0003.png"));
    }

    #[test]
    fn a_default_name_that_is_taken_gets_a_number() {
        let taken = ["a/out", "a/out-2", "page.html"];
        let may = |path: &Path| !taken.contains(&path.to_str().unwrap());
        assert_eq!(free(Path::new("a/out"), may), Path::new("a/out-3"));
        assert_eq!(free(Path::new("page.html"), may), Path::new("page-2.html"));
        assert_eq!(free(Path::new("new"), may), Path::new("new"));
    }

    #[test]
    fn a_file_is_replaced_by_a_rename_and_a_link_stays() {
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["a", "link"].map(|it| folder.path().join(it));
        write(&path, "one").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write(&link, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert!(link.is_symlink());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
