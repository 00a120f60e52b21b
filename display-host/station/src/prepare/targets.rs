//! Checks, before any work, that no output of `calot prepare` replaces the source or another
//! output, or an older file without `--overwrite`.

use std::path::{Path, PathBuf};

use crate::output::{self, Format, Overwrite};
use crate::problem::Problem;

/// Checks output files against the source and each other. `-` is standard output.
pub(crate) fn check(
    source: &str,
    targets: &[(&str, Format, Option<&Path>)],
    overwrite: Overwrite,
) -> Result<(), Problem> {
    let mut taken = vec![("the source", place(Path::new(source)))];
    for (option, format, path) in targets {
        let Some(path) = path.filter(|path| *path != Path::new("-")) else {
            continue;
        };
        let shown = path.display();
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return Err(format!(
                "{option} {shown}: there is no folder {}; make it, or name another",
                folder.display()
            )
            .into());
        }
        let place = place(path);
        if let Some((other, _)) = taken.iter().find(|(_, other)| *other == place) {
            return Err(
                format!("{option} {shown}: would replace {other}; name another file").into(),
            );
        }
        output::check(option, path, *format, overwrite)?;
        taken.push((option, place));
    }
    Ok(())
}

/// Real path of a file. If the file does not exist, the path as given.
fn place(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_never_replace_their_source() {
        let here = std::env::current_exe().unwrap();
        let folder = here.parent().unwrap();
        let detour = folder.join(".").join(here.file_name().unwrap());
        let source = here.to_str().unwrap();
        let json = |path: &Path| {
            let targets = [
                ("--out", Format::Scene, None),
                ("--json", Format::Json, Some(path)),
            ];
            check(source, &targets, Overwrite::default()).map_err(|it| it.to_string())
        };
        for (path, problem) in [
            (here.clone(), "would replace the source"),
            (detour, "would replace the source"),
            (folder.to_owned(), "is a folder"),
            (folder.join("missing/x.json"), "there is no folder"),
        ] {
            let error = json(&path).unwrap_err();
            assert!(
                error.starts_with("--json") && error.contains(problem),
                "{error}"
            );
        }
        assert_eq!(json(Path::new("-")), Ok(()));
        assert_eq!(json(Path::new("report.json")), Ok(()));
        assert_eq!(json(&folder.join("report.json")), Ok(()));
    }

    #[test]
    fn two_options_do_not_share_a_file() {
        let same = Some(Path::new("x.calot"));
        let both = |source: &str, json| {
            let targets = [
                ("--out", Format::Scene, same),
                ("--json", Format::Json, json),
            ];
            check(source, &targets, Overwrite::default()).map_err(|it| it.to_string())
        };
        let error = both("built-in", same).unwrap_err();
        assert!(
            error.contains("--json x.calot: would replace --out"),
            "{error}"
        );
        let dash = Some(Path::new("-"));
        assert_eq!(both("-", dash), Ok(()));
    }
}
