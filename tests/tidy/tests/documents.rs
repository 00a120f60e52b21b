//! Documents keep to their lengths, their links and paths exist, their commands parse, and the
//! README's headline figures are those of the tables.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use tidy::{Tracked, report, root, tracked};

/// Largest number of lines that a document may have.
const LINES_MAX: [(&str, usize); 2] = [("README.md", 120), ("ARCHITECTURE.md", 200)];
/// Largest number of words that a paragraph of the README may have.
const WORDS_MAX: usize = 60;

#[test]
fn documents_keep_to_their_lengths() {
    let mut findings = Vec::new();
    for (path, most) in LINES_MAX {
        let lines = read(path).lines().count();
        if lines > most {
            findings.push(format!(
                "{path}:{lines}: has more than {most} lines; move text into the guide of its reader"
            ));
        }
    }
    for (line, paragraph) in paragraphs(&read("README.md")) {
        let words = paragraph.split_whitespace().count();
        if words > WORDS_MAX {
            findings.push(format!(
                "README.md:{line}: a paragraph of {words} words; {WORDS_MAX} at most"
            ));
        }
    }
    report(&findings);
}

#[test]
fn entries_of_the_changelog_are_one_line_under_added_changed_or_fixed() {
    let mut findings = Vec::new();
    for (at, line) in read("CHANGELOG.md").lines().enumerate() {
        let known = [
            "Added",
            "Changed",
            "Deprecated",
            "Removed",
            "Fixed",
            "Security",
        ];
        let heading = line.strip_prefix("### ");
        if heading.is_some_and(|heading| !known.contains(&heading)) {
            findings.push(format!(
                "CHANGELOG.md:{}: not one of the headings {}",
                at + 1,
                known.join(", ")
            ));
        }
        if line.starts_with(' ') {
            findings.push(format!("CHANGELOG.md:{}: an entry is one line", at + 1));
        }
    }
    report(&findings);
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut findings = Vec::new();
    for document in tracked(".md") {
        let folder = Path::new(&document.path).parent().unwrap_or(Path::new(""));
        for (line, target) in links(&document.text) {
            if target.contains("://") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() {
                PathBuf::from(&document.path)
            } else {
                plain(&folder.join(file))
            };
            let target_path = root().join(&path);
            if !target_path.exists() {
                findings.push(format!("{}:{line}: {target} does not exist", document.path));
            } else if !anchor.is_empty() {
                let text = std::fs::read_to_string(&target_path).unwrap_or_default();
                if !anchors(&text).iter().any(|a| a == anchor) {
                    findings.push(format!("{}:{line}: no heading for {target}", document.path));
                }
            }
        }
    }
    report(&findings);
}

#[test]
fn files_that_documents_name_exist() {
    let ends = [".rs", ".md", ".toml", ".csv", ".svg", ".sh", ".wgsl"];
    let mut findings = Vec::new();
    for document in tracked(".md") {
        let folder = Path::new(&document.path).parent().unwrap_or(Path::new(""));
        for (line, text) in prose(&document.text) {
            for code in text.split('`').skip(1).step_by(2) {
                let is_path = code.contains('/') && ends.iter().any(|end| code.ends_with(end));
                if !is_path || code.contains([' ', '*', '$']) {
                    continue;
                }
                let exists = root().join(folder).join(code).exists() || root().join(code).exists();
                if !exists {
                    findings.push(format!("{}:{line}: {code} does not exist", document.path));
                }
            }
        }
    }
    report(&findings);
}

#[test]
fn commands_of_documents_parse() {
    let mut findings = Vec::new();
    let mut known = Known::default();
    for document in tracked(".md") {
        for (line, command) in commands(&document) {
            if let Err(problem) = known.parse(&command) {
                findings.push(format!(
                    "{}:{line}: `{}`: {problem}",
                    document.path, command.text
                ));
            }
        }
    }
    report(&findings);
}

#[test]
fn headline_figures_are_those_of_the_tables() {
    let readme = read("README.md");
    let tables = Tables::read();
    let accuracy = |scene: &str, method: &str| {
        let row = [("scene", scene)];
        format!(
            "{} mm off, {} µs",
            tables.cell("accuracy", &row, &format!("{method}, rms mm")),
            tables.cell("accuracy", &row, &format!("{method}, µs")),
        )
    };
    let mut expected = Vec::new();
    for (name, scene) in [
        ("sags by 39 mm", "liver: sag"),
        ("is pulled by 30 mm", "liver: pull 30 mm"),
        ("is turned by 90°", "liver: twist 90°"),
    ] {
        let (ours, paper) = (accuracy(scene, "Calot"), accuracy(scene, "paper's"));
        expected.push(format!("| {name} | {ours} | {paper} |"));
    }
    let times = |competitor| {
        let row = [("scene", "liver: pull 30 mm"), ("competitor", competitor)];
        tables.cell("competitors", &row, "times Calot's µs")
    };
    expected.push(format!(
        "MuJoCo 4.0.0 needs {} times Calot's time at Calot's error with another material, and {} times with the \
         same one; Newton 1.8.0 needs {} times.",
        times("MuJoCo 4.0.0 flex, StVK"),
        times("MuJoCo 4.0.0 flex, neo-Hookean"),
        times("Newton 1.8.0 VBD"),
    ));
    let survived = |method| tables.cell("stability", &[("method", method)], "cases survived");
    expected.push(format!(
        "Calot survives {} of 16 cases that break solvers, the paper's method {}.",
        survived("Calot"),
        survived("inner spheres (paper's), k fitted"),
    ));
    let force = |column: &str| -> u32 {
        ["not used for tuning", "used for tuning"]
            .iter()
            .map(|places| {
                let row = [("contact law", "Calot"), ("places", places)];
                tables
                    .cell("force", &row, column)
                    .parse::<u32>()
                    .expect("a count")
            })
            .sum()
    };
    expected.push(format!(
        "{} of {} presses",
        force("within 7 %"),
        force("rows")
    ));
    let counted = |run, column: &str| tables.cell("jitter counts", &[("run", run)], column);
    expected.push(format!(
        "{} allocations and {} page faults in {} ticks",
        counted("soak", "allocations"),
        counted("soak", "page faults"),
        counted("soak", "ticks"),
    ));
    expected.push(format!(
        "{} in a million",
        counted("misses", "missed in a million periods")
    ));
    expected.push(format!(
        "missed {} there",
        counted("misses", "bare loop with as much work: missed")
    ));
    // Join the lines of each paragraph.
    let one_line = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    let findings: Vec<String> = expected
        .into_iter()
        .filter(|figure| !one_line.contains(figure))
        .map(|figure| format!("README.md: should say '{figure}', as tests/results/README.md does"))
        .collect();
    report(&findings);
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).expect("a document of the checkout")
}

/// Paragraphs of running text, list items and quotations, with the line on which each begins.
fn paragraphs(text: &str) -> Vec<(usize, String)> {
    // `open`: the next line may continue the last paragraph. `code`: inside a block of code.
    let (mut found, mut open, mut code): (Vec<(usize, String)>, _, _) = (Vec::new(), false, false);
    for (at, line) in text.lines().enumerate() {
        let line = line.trim_start_matches(['>', ' ']);
        if line.starts_with("```") {
            code = !code;
        }
        let is_no_prose = code || line.is_empty() || line.starts_with(['#', '|', '`', '!', '<']);
        let item = line.starts_with("- ");
        if is_no_prose {
            open = false;
        } else if let (Some((_, last)), true, false) = (found.last_mut(), open, item) {
            *last += " ";
            *last += line;
        } else {
            found.push((at + 1, line.to_owned()));
            open = true;
        }
    }
    found
}

/// Lines outside of code blocks.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut code = false;
    text.lines().enumerate().filter_map(move |(at, line)| {
        if line.trim_start().starts_with("```") {
            code = !code;
            return None;
        }
        (!code).then_some((at + 1, line))
    })
}

/// Targets of the links, with their lines.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (line, text) in prose(text) {
        for part in text.split("](").skip(1) {
            if let Some((target, _)) = part.split_once(')') {
                found.push((line, target.to_owned()));
            }
        }
    }
    found
}

/// Anchors of the headings.
fn anchors(text: &str) -> Vec<String> {
    prose(text)
        .filter(|(_, line)| line.starts_with('#'))
        .map(|(_, line)| line.trim_start_matches('#').trim())
        .map(|heading| {
            heading
                .to_lowercase()
                .chars()
                .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
                .map(|c| if c == ' ' { '-' } else { c })
                .collect()
        })
        .collect()
}

/// The path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    out
}

/// A command that a document shows.
struct Shown {
    text: String,
    /// True in a block of code, whose values are real. In running text, values may be placeholders.
    block: bool,
}

/// Commands that a document shows in blocks of `sh` and in running text, with their lines.
fn commands(document: &Tracked) -> Vec<(usize, Shown)> {
    let mut found = Vec::new();
    let mut shell = false;
    for (at, line) in document.text.lines().enumerate() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            shell = language == "sh";
        } else if shell {
            let line = line.split(" #").next().unwrap_or_default();
            for part in line.split(['|', ';']).flat_map(|part| part.split("&&")) {
                push_if_command(&mut found, at, part, true);
            }
        }
    }
    for (line, text) in prose(&document.text) {
        for code in text.split('`').skip(1).step_by(2) {
            push_if_command(&mut found, line - 1, code, false);
        }
    }
    found
}

/// Adds the text if it is a command of `calot` or `cargo`.
fn push_if_command(found: &mut Vec<(usize, Shown)>, at: usize, text: &str, block: bool) {
    let text = text.trim();
    if text.starts_with("calot ") || text.starts_with("cargo ") {
        let text = text.to_owned();
        found.push((at + 1, Shown { text, block }));
    }
}

/// Answers of `calot` to `--help`. Each command is asked once.
#[derive(Default)]
struct Known {
    asked: BTreeMap<Vec<String>, Result<String, String>>,
}

impl Known {
    fn parse(&mut self, command: &Shown) -> Result<(), String> {
        let words = words(&command.text);
        match words.split_first() {
            Some((program, rest)) if program == "calot" => self.calot(rest, command.block),
            Some((_, rest)) => self.cargo(rest, command.block),
            None => Ok(()),
        }
    }

    /// In a block, `calot` parses the words with `--help` added, so that the command does nothing.
    /// In running text, commands and flags are looked up in the help.
    fn calot(&mut self, words: &[String], block: bool) -> Result<(), String> {
        if block {
            let end = words.iter().position(|w| w == "--").unwrap_or(words.len());
            let mut asked = words[..end].to_vec();
            asked.push("--help".to_owned());
            asked.extend_from_slice(&words[end..]);
            return self.help(asked).map(drop);
        }
        let mut path: Vec<String> = Vec::new();
        let mut help = self.help(vec!["--help".to_owned()])?;
        for word in words {
            if let Some(flag) = word.strip_prefix("--") {
                let flag = flag.split('=').next().unwrap_or(flag);
                if !flag.is_empty() && flag != "help" && !mentions(&help, flag) {
                    return Err(format!("no --{flag}"));
                }
            } else if is_subcommand(&help, word) {
                path.push(word.clone());
                let mut asked = path.clone();
                asked.push("--help".to_owned());
                help = self.help(asked)?;
            } else if path.is_empty() {
                return Err(format!("no command {word}"));
            }
        }
        Ok(())
    }

    fn help(&mut self, words: Vec<String>) -> Result<String, String> {
        let ask = |words: &Vec<String>| {
            let output = Command::new(calot())
                .args(words)
                .current_dir(root())
                .output()
                .map_err(|e| format!("{}: {e}; cargo build -p calot", calot().display()))?;
            if output.status.success() {
                Ok(String::from_utf8_lossy(&output.stdout).into_owned())
            } else {
                let said = String::from_utf8_lossy(&output.stderr);
                Err(said.lines().next().unwrap_or("refused").to_owned())
            }
        };
        self.asked.entry(words).or_insert_with_key(ask).clone()
    }

    fn cargo(&mut self, words: &[String], block: bool) -> Result<(), String> {
        let after = |flag: &[&str]| {
            let at = words.iter().position(|w| flag.contains(&w.as_str()))?;
            words.get(at + 1)
        };
        let end = words.iter().position(|w| w == "--").unwrap_or(words.len());
        let after_dashes = words.get(end + 1..).unwrap_or_default();
        let folder = match after(&["-p", "--package"]) {
            Some(name) => Some((name, folder(name)?)),
            None => None,
        };
        for (flag, kind) in [("--example", "examples"), ("--test", "tests")] {
            if let Some(name) = after(&[flag]) {
                let (_, folder) = folder.as_ref().ok_or("no package is named")?;
                let place = folder.join(kind);
                if !place.join(format!("{name}.rs")).exists() && !place.join(name).exists() {
                    return Err(format!("{} has no {name}", place.display()));
                }
            }
        }
        match words.first().map(String::as_str) {
            Some("xtask") => match words.get(1) {
                Some(command) if xtask(command) => Ok(()),
                _ => Err("xtask has no such command".to_owned()),
            },
            Some("run") if folder.is_none() => self.calot(after_dashes, block),
            Some("run") if folder.as_ref().is_some_and(|(name, _)| *name == "evaluate") => {
                evaluate(after_dashes)
            }
            Some("run" | "test" | "build" | "clippy" | "doc" | "install" | "fmt") => Ok(()),
            Some(other) => Err(format!("cargo {other} is not known here")),
            None => Ok(()),
        }
    }
}

/// Path of the `calot` that was built in the same profile as this test.
fn calot() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows its own path");
    let folder = test.ancestors().nth(2).expect("target/PROFILE/deps/test");
    folder.join("calot")
}

/// True if `cargo xtask` has this command.
fn xtask(command: &str) -> bool {
    read("tests/xtask/src/main.rs").contains(&format!("(\"{command}\", "))
}

/// Checks a command and its flags against the source of `evaluate`.
fn evaluate(words: &[String]) -> Result<(), String> {
    let source = read("tests/evaluate/src/main.rs");
    let (command, flags) = words.split_first().ok_or("evaluate needs a command")?;
    let words = command.split('-').filter(|word| !word.is_empty());
    let variant: String = words
        .map(|word| word[..1].to_uppercase() + &word[1..])
        .collect();
    if !source.contains(&format!("\n    {variant}("))
        && !source.contains(&format!("\n    {variant} {{"))
    {
        return Err(format!("evaluate has no {command}"));
    }
    // The options of `evaluate measured` are declared in its module.
    let options = source + &read("tests/evaluate/src/measured/mod.rs");
    match flags
        .iter()
        .filter_map(|flag| flag.strip_prefix("--"))
        .find(|flag| !options.contains(&format!(" {flag}: ")))
    {
        Some(flag) => Err(format!("evaluate has no --{flag}")),
        None => Ok(()),
    }
}

/// Folder of a package of this workspace.
fn folder(package: &str) -> Result<PathBuf, String> {
    tracked("Cargo.toml")
        .iter()
        .find(|manifest| {
            manifest.text.parse::<toml::Table>().is_ok_and(|table| {
                table.get("package").and_then(|p| p.get("name")?.as_str()) == Some(package)
            })
        })
        .map(|manifest| root().join(&manifest.path).with_file_name(""))
        .ok_or_else(|| format!("no package {package}"))
}

/// True if a help text mentions this flag.
fn mentions(help: &str, flag: &str) -> bool {
    let flag = format!("--{flag}");
    help.split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']' | '`' | '='))
        .any(|word| word == flag)
}

/// True if a help text lists this word as a command.
fn is_subcommand(help: &str, word: &str) -> bool {
    let Some((_, commands)) = help.split_once("Commands:\n") else {
        return false;
    };
    commands
        .lines()
        .take_while(|line| !line.is_empty())
        .any(|line| line.split_whitespace().next() == Some(word))
}

/// Words as a shell splits them, without the first `>` and the file after it.
fn words(text: &str) -> Vec<String> {
    let (mut found, mut quoted, mut word) = (Vec::new(), false, String::new());
    for c in text.chars() {
        match c {
            '\'' | '"' => quoted = !quoted,
            c if c.is_whitespace() && !quoted => found.push(std::mem::take(&mut word)),
            c => word.push(c),
        }
    }
    found.push(word);
    found.retain(|word| !word.is_empty());
    while let Some(at) = found.iter().position(|word| word == ">" || word == "<") {
        found.drain(at..(at + 2).min(found.len()));
    }
    found
}

/// Tables of tests/results/README.md.
struct Tables(BTreeMap<String, Vec<Vec<String>>>);

impl Tables {
    fn read() -> Self {
        let text = read("tests/results/README.md");
        let mut tables = BTreeMap::new();
        for part in text.split("<!-- table: ").skip(1) {
            let Some((name, rest)) = part.split_once(" -->") else {
                continue;
            };
            let rows = rest
                .lines()
                .take_while(|line| *line != "<!-- end -->")
                .filter(|line| line.starts_with("| "))
                .map(|line| {
                    let cells = line.trim_matches('|').split(" | ");
                    cells.map(|cell| cell.trim().to_owned()).collect()
                })
                .collect();
            tables.insert(name.to_owned(), rows);
        }
        Self(tables)
    }

    /// The cell of the first row that has these values.
    fn cell(&self, table: &str, row: &[(&str, &str)], column: &str) -> String {
        let rows = self
            .0
            .get(table)
            .unwrap_or_else(|| panic!("no table {table}"));
        let (header, rows) = rows.split_first().expect("a table has columns");
        let at = |column: &str| {
            let at = header.iter().position(|name| name == column);
            at.unwrap_or_else(|| panic!("table {table} has no column {column}"))
        };
        rows.iter()
            .find(|cells| row.iter().all(|(name, value)| cells[at(name)] == *value))
            .unwrap_or_else(|| panic!("table {table} has no row {row:?}"))[at(column)]
        .clone()
    }
}
