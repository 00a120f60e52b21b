//! The compiler that `cargo xtask test` gives cargo for our own packages. It compiles a package,
//! and then lints and documents it as clippy and rustdoc do. Compiler, clippy and rustdoc read
//! dependencies that were compiled once. `cargo clippy` and `cargo doc` would go through the five
//! hundred dependencies again, which takes longer than our own code.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Environment variable that is set while this program is the compiler. It names the folder for the
/// output of clippy and rustdoc.
const FOLDER: &str = "CALOT_CHECKED";
/// Cargo's variable for the program that compiles the workspace's own packages.
const WRAPPER: &str = "RUSTC_WORKSPACE_WRAPPER";
/// Variable from which clippy reads its arguments, and its value: one argument, ended by clippy's
/// separator.
const CLIPPY: (&str, &str) = ("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__");

/// Environment that makes cargo compile through a copy of this program, in one target folder for
/// all workspaces.
pub(crate) fn environment() -> io::Result<[(&'static str, PathBuf); 3]> {
    const TARGET: &str = "CARGO_TARGET_DIR";
    let target = std::env::var_os(TARGET).map_or_else(|| "target".into(), PathBuf::from);
    let target = std::path::absolute(target)?;
    let folder = target.join("checked");
    std::fs::create_dir_all(&folder)?;
    // Cargo may build this program's own file again while it runs, so a copy of it is used as the
    // compiler.
    let compiler = folder.join("compiler");
    std::fs::copy(std::env::current_exe()?, &compiler)?;
    Ok([(FOLDER, folder), (WRAPPER, compiler), (TARGET, target)])
}

/// Compiles if cargo started this program for that, and returns the outcome. `args` are the
/// compiler's path and its arguments.
pub(crate) fn compile(args: &[OsString]) -> Option<ExitCode> {
    let folder = PathBuf::from(std::env::var_os(FOLDER)?);
    let (rustc, args) = args.split_first()?;
    Some(match compile_and_look(Path::new(rustc), args, &folder) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!(
                "cannot run {}, or clippy or rustdoc beside it: {error}",
                Path::new(rustc).display()
            );
            ExitCode::FAILURE
        }
    })
}

fn compile_and_look(rustc: &Path, args: &[OsString], folder: &Path) -> io::Result<bool> {
    let compiled = Command::new(rustc).args(args).status()?.success();
    let unit = Unit::of(args);
    if !compiled || !unit.is_ours {
        return Ok(compiled);
    }
    // Clippy and rustdoc lie next to cargo in any toolchain.
    let beside = |name: &str| {
        let cargo = std::env::var_os("CARGO").map(PathBuf::from);
        cargo.map_or_else(|| name.into(), |cargo| cargo.with_file_name(name))
    };
    let mut clippy = Command::new(beside("clippy-driver"));
    clippy.arg(rustc).args(&unit.args).arg("--emit=metadata");
    clippy.arg("--out-dir").arg(folder).env(CLIPPY.0, CLIPPY.1);
    if !clippy.status()?.success() {
        return Ok(false);
    }
    if !unit.is_documented {
        return Ok(true);
    }
    let mut rustdoc = Command::new(beside("rustdoc"));
    rustdoc.args(&unit.args).args(["-D", "warnings"]);
    rustdoc.arg("--document-private-items");
    rustdoc.arg("--out-dir").arg(folder.join("doc"));
    Ok(rustdoc.status()?.success())
}

/// One compilation.
struct Unit {
    /// Arguments of the compiler, except the kind and place of its output.
    args: Vec<OsString>,
    /// True for a crate of the workspace, except build scripts.
    is_ours: bool,
    /// True for crates that `cargo doc` documents: libraries and programs, but no tests or
    /// examples.
    is_documented: bool,
}

impl Unit {
    fn of(args: &[OsString]) -> Self {
        let mut unit = Self {
            args: Vec::new(),
            is_ours: false,
            is_documented: true,
        };
        let mut left = args.iter();
        while let Some(arg) = left.next() {
            let text = arg.to_string_lossy();
            match &*text {
                "--out-dir" | "--emit" => {
                    left.next();
                    continue;
                }
                "--crate-name" => {
                    // Cargo uses the name `___` to ask what the compiler can do.
                    let others = ["build_script_build", "___"];
                    let name = left.as_slice().first();
                    unit.is_ours = name.is_some_and(|name| others.iter().all(|it| name != it));
                }
                "--test" => unit.is_documented = false,
                source if source.ends_with(".rs") && !source.starts_with('-') => {
                    unit.is_documented &= !Path::new(source).iter().any(|it| it == "examples");
                }
                // Clippy must not list its artifacts: cargo would take them for the compiler's.
                json if json.starts_with("--json=") => {
                    unit.args.push(json.replace(",artifacts", "").into());
                    continue;
                }
                made if made.starts_with("--emit=") => continue,
                _ => {}
            }
            unit.args.push(arg.clone());
        }
        unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(line: &str) -> Unit {
        let args: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        Unit::of(&args)
    }

    #[test]
    fn options_of_output_are_left_out() {
        let unit = unit(
            "--crate-name calot --json=diagnostic-rendered-ansi,artifacts src/main.rs --emit=link --out-dir target -L x",
        );
        let kept = [
            "--crate-name",
            "calot",
            "--json=diagnostic-rendered-ansi",
            "src/main.rs",
            "-L",
            "x",
        ];
        assert_eq!(unit.args, kept.map(OsString::from));
        assert!(unit.is_ours && unit.is_documented);
    }

    #[test]
    fn tests_examples_and_questions_are_told_apart() {
        assert!(!unit("-vV").is_ours);
        assert!(!unit("- --crate-name ___ --print=file-names").is_ours);
        assert!(!unit("--crate-name build_script_build build.rs").is_ours);
        assert!(!unit("--crate-name a src/lib.rs --test").is_documented);
        assert!(!unit("--crate-name a examples/a.rs").is_documented);
    }
}
