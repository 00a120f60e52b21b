//! Copies the repository, makes the core's tuned values variable in the copy, and builds it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::source::{core_module, parameters, varied};

/// The core's sources in the repository.
const CORE: &str = "rt-core/core/src";
/// Rooms of the core whose tuned values act on contact and force.
const ROOMS: [&str; 4] = ["contact", "haptics", "organs", "tissue"];
/// Text that stands for the variable values in this program.
const STUB: &str = "tests/evaluate/src/ablation/varied.rs";
const REAL: &str = "//! The core's tuned values that this build can vary.\n\n\
                    pub(super) use rt_core::varied::{NAMES, forget_reads, vary, was_read};\n";
/// Folders that are not copied.
const LEFT_OUT: [&str; 2] = ["target", ".git"];

/// Makes the copy in `out`, builds it, and returns its `evaluate`. A file that is there already and
/// did not change is not written again, so that a second build is short.
///
/// # Errors
/// The reason in words.
pub(super) fn build(out: &Path) -> Result<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A canonical path, so that the copy never copies itself.
    let out = std::fs::canonicalize(out).map_err(|e| told(out, &e))?;
    let copy = Copy {
        made: made_variable(&root)?,
        out: &out,
    };
    let count = copy.made.len();
    let sources = out.join("sources");
    copy.folder(&root, &sources)?;
    for (path, text) in &copy.made {
        write(&sources.join(path), text.as_bytes())?;
    }
    eprintln!("ablation: {count} files differ; builds the copy …");
    let target = out.join("target");
    let built = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["build", "--locked", "--workspace", "--bin", "evaluate"])
        .current_dir(&sources)
        .env("CARGO_TARGET_DIR", &target)
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .status()
        .map_err(|e| format!("cargo does not start: {e}"))?;
    if !built.success() {
        return Err(format!(
            "the copy in {} does not compile",
            sources.display()
        ));
    }
    Ok(target.join("debug/evaluate"))
}

fn told(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| told(path, &e))
}

/// Writes a file that differs.
fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if std::fs::read(path).is_ok_and(|it| it == bytes) {
        return Ok(());
    }
    std::fs::write(path, bytes).map_err(|e| told(path, &e))
}

/// Files and folders in a folder, in order.
fn inside(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| told(folder, &e))?;
    let mut paths: Vec<_> = entries.flatten().map(|it| it.path()).collect();
    paths.sort();
    Ok(paths)
}

/// Files of the copy that differ from the repository's, by their paths in it.
type Made = BTreeMap<PathBuf, String>;

/// A copy that is made.
struct Copy<'a> {
    made: Made,
    /// The folder that receives it.
    out: &'a Path,
}

impl Copy<'_> {
    /// Copies what does not differ.
    fn folder(&self, from: &Path, to: &Path) -> Result<(), String> {
        std::fs::create_dir_all(to).map_err(|e| told(to, &e))?;
        for path in inside(from)? {
            let Some(name) = path.file_name() else {
                continue;
            };
            let is_left_out = path.is_symlink() || LEFT_OUT.iter().any(|it| name == *it);
            if is_left_out || std::fs::canonicalize(&path).is_ok_and(|it| it == self.out) {
                continue;
            }
            let copy = to.join(name);
            if path.is_dir() {
                self.folder(&path, &copy)?;
            } else if !self.made.keys().any(|made| copy.ends_with(made)) {
                let bytes = std::fs::read(&path).map_err(|e| told(&path, &e))?;
                write(&copy, &bytes)?;
            }
        }
        Ok(())
    }
}

/// Source files of a crate, each with the path of its module.
fn modules(folder: &Path, prefix: &str) -> Result<Vec<(String, PathBuf)>, String> {
    let mut found = Vec::new();
    for path in inside(folder)? {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let module = match (prefix, &*stem) {
            ("", stem) => stem.to_owned(),
            (prefix, "mod") => prefix.to_owned(),
            (prefix, stem) => format!("{prefix}::{stem}"),
        };
        if path.is_dir() {
            found.extend(modules(&path, &module)?);
        } else if stem != "tests" && path.extension().is_some_and(|it| it == "rs") {
            found.push((module, path));
        }
    }
    Ok(found)
}

/// The files in which the tuned values are variable.
fn made_variable(root: &Path) -> Result<Made, String> {
    let core = Path::new(CORE);
    let files = modules(&root.join(CORE), "")?;
    let mut all = Vec::new();
    for (module, path) in &files {
        let room = module.split("::").next().unwrap_or_default();
        if ROOMS.contains(&room) {
            all.extend(parameters(module, &read(path)?));
        }
    }
    let mut made = Made::new();
    for (module, path) in &files {
        let usual = read(path)?;
        let text = varied(module, &usual, &all);
        let place = path.strip_prefix(root).map_err(|e| e.to_string())?;
        if text != usual {
            made.insert(place.to_owned(), text);
        }
    }
    let lib = core.join("lib.rs");
    let text = read(&root.join(&lib))?;
    made.insert(lib, format!("{text}\npub mod varied;\n"));
    made.insert(core.join("varied.rs"), core_module(&all));
    made.insert(STUB.into(), REAL.to_owned());
    Ok(made)
}
