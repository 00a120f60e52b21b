//! Figures of a graphics card: drawing, skinning, reading back, and the paper's collision kernel.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps::step;

/// Folder of the results, relative to the folder of the build.
const OUT: &str = "gpu";

/// Sizes of the pictures. The gallery's views are drawn in the first one.
const SIZES: [&str; 3] = ["1920x1080", "1280x720", "3840x2160"];

/// Options of the command.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Asked {
    /// Runs what is built already.
    built: bool,
    /// One small size, and each picture once: a trial, minutes on a software driver.
    short: bool,
}

fn asked(args: &[String]) -> Result<Asked, String> {
    let mut asked = Asked::default();
    for word in args {
        match &**word {
            "--built" => asked.built = true,
            "--short" => asked.short = true,
            _ => return Err(format!("gpu takes --built and --short, not '{word}'")),
        }
    }
    Ok(asked)
}

/// Builds the programs, unless they are `--built`, and measures into one JSON file.
pub(crate) fn measure(args: &[String]) -> Result<(), String> {
    let asked = asked(args)?;
    if !asked.built {
        let build = ["build", "--locked", "--release"];
        let programs = ["-p", "calot", "-p", "evaluate"];
        step("build", &[&build[..], &programs].concat())?;
        let example = ["-p", "display-host", "--example", "frame_cost"];
        step("build what draws", &[&build[..], &example].concat())?;
    }
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| "target".to_owned());
    let (built, out) = (
        Path::new(&target).join("release"),
        Path::new(&target).join(OUT),
    );
    let file = |name: &str| out.join(name).display().to_string();
    std::fs::create_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    let (scene, drawing, collision) = (
        file("triangle.calot"),
        file("drawing.csv"),
        file("collision"),
    );
    let prepare = ["prepare", "triangle", "--overwrite", "--out", &scene];
    run(&built.join("calot"), &prepare)?;
    let mut draw = vec![&*scene, "--views", "--csv", &drawing];
    if asked.short {
        draw.extend(["--size", "320x240", "--frames", "1"]);
    } else {
        draw.extend(SIZES.iter().flat_map(|size| ["--size", size]));
    }
    run(&built.join("examples/frame_cost"), &draw)?;
    run(&built.join("evaluate"), &["collision", "--out", &collision])?;
    let read = |path: PathBuf| {
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let collision = read(Path::new(&collision).join("collision.csv"))?;
    let [drawing, collision] = [read(drawing.into())?, collision].map(|table| rows(&table));
    let json = format!(
        "{{\"commit\": \"{}\",\n\"short\": {},\n\"drawing\": {drawing},\n\"collision\": {collision}}}\n",
        commit(),
        asked.short
    );
    let path = out.join("gpu.json");
    std::fs::write(&path, json).map_err(|error| format!("{}: {error}", path.display()))?;
    println!("\n{}", path.display());
    Ok(())
}

/// Commit of the checkout, or `unknown` where there is none.
fn commit() -> String {
    let asked = Command::new("git").args(["rev-parse", "HEAD"]).output();
    let said = asked.ok().filter(|it| it.status.success());
    let said = said.and_then(|it| String::from_utf8(it.stdout).ok());
    said.map_or_else(|| "unknown".to_owned(), |it| it.trim().to_owned())
}

fn run(program: &Path, args: &[&str]) -> Result<(), String> {
    println!("\n== {} {}", program.display(), args.join(" "));
    let status = Command::new(program).args(args).status();
    let status = status.map_err(|error| format!("cannot run {}: {error}", program.display()))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{} failed ({status})", program.display()))
    }
}

/// The lines of a table as JSON objects. Quotation marks stand only around whole fields.
fn rows(csv: &str) -> String {
    let mut lines = csv.lines().map(fields);
    let head = lines.next().unwrap_or_default();
    let object = |row: Vec<String>| {
        let pair = |(name, value): (&String, String)| match value.parse::<f64>() {
            Ok(number) if number.is_finite() => format!("\"{name}\": {value}"),
            _ => format!("\"{name}\": \"{value}\""),
        };
        let pairs: Vec<String> = head.iter().zip(row).map(pair).collect();
        format!("{{{}}}", pairs.join(", "))
    };
    let objects: Vec<String> = lines.map(object).collect();
    format!("[{}]", objects.join(",\n"))
}

fn fields(line: &str) -> Vec<String> {
    let (mut fields, mut is_quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => fields.push(String::new()),
            _ => {
                if let Some(field) = fields.last_mut() {
                    field.push(letter);
                }
            }
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_in_any_order_and_others_are_refused() {
        let both = ["--short", "--built"].map(str::to_owned);
        let all = Asked {
            built: true,
            short: true,
        };
        assert_eq!(asked(&both), Ok(all));
        assert_eq!(asked(&[]), Ok(Asked::default()));
        let said = asked(&["--fast".to_owned()]).unwrap_err();
        assert_eq!(said, "gpu takes --built and --short, not '--fast'");
    }

    #[test]
    fn a_table_becomes_objects_with_numbers_and_words() {
        let table = "way,p50_us\n\"Calot, CPU\",13.5\nmesh vertices,nan\n";
        let wanted = "[{\"way\": \"Calot, CPU\", \"p50_us\": 13.5},\n\
                      {\"way\": \"mesh vertices\", \"p50_us\": \"nan\"}]";
        assert_eq!(rows(table), wanted);
    }
}
