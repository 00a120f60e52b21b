//! Reads trials from untrusted files.

use std::path::Path;

/// Smallest number of columns of a row: all up to the time.
const COLUMNS: usize = 17;
/// Columns that must contain a number: positions and angles of both instruments, and the time. The
/// angles are checked but not used.
const READ: [usize; 13] = [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, TIME];
const TIME: usize = 16;
/// Largest accepted coordinate, angle or time, in the file's units.
const LARGEST: f64 = 1e5;
/// Fewest rows of a trial.
const ROWS_MIN: usize = 20;

/// Experience of a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Expert,
    Novice,
}

impl Group {
    /// Group of a person, from the first letter of the name.
    pub(super) fn of(person: &str) -> Option<Self> {
        match person.as_bytes().first() {
            Some(b'E') => Some(Self::Expert),
            Some(b'N') => Some(Self::Novice),
            _ => None,
        }
    }
}

/// A trial: the course of both hands.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// TASK/PERSON/TRIAL.
    pub(super) name: String,
    pub(super) task: String,
    pub(super) person: String,
    pub(super) group: Group,
    /// Times of the rows, s, strictly increasing.
    pub(super) times_s: Vec<f64>,
    /// Positions of the first and the second instrument at these times, m.
    pub(super) hands: [Vec<[f64; 3]>; 2],
}

/// Reads all trials below a folder except those in `leave_out`, sorted by name.
///
/// # Errors
/// The first wrong file or line, and the remedy.
pub(super) fn read_all(
    folder: &Path,
    leave_out: &[String],
    unit_m: f64,
) -> Result<Vec<Trial>, String> {
    let mut left: Vec<&String> = leave_out.iter().collect();
    let mut trials = Vec::new();
    for task in names(folder)? {
        let at = folder.join(&task);
        let before = trials.len();
        for person in names(&at)? {
            let at = at.join(&person);
            let group = Group::of(&person).ok_or_else(|| {
                let where_ = at.display();
                format!(
                    "{where_}: a person's folder is called E… (expert) or N… (novice); rename it"
                )
            })?;
            for file in names(&at)? {
                let path = at.join(&file);
                let number = file.strip_suffix(".csv").ok_or_else(|| {
                    format!(
                        "{}: a trial is a file called ….csv; move it away",
                        path.display()
                    )
                })?;
                let name = format!("{task}/{person}/{number}");
                if leave_out.contains(&name) {
                    left.retain(|it| **it != name);
                    continue;
                }
                let text = std::fs::read_to_string(&path)
                    .map_err(|problem| format!("{}: {problem}", path.display()))?;
                let (times_s, hands) = parse(&text, unit_m).map_err(|problem| {
                    let out = format!("mend it, or leave the trial out: --leave-out {name}");
                    format!("{}, {problem}; {out}", path.display())
                })?;
                trials.push(Trial {
                    name,
                    task: task.clone(),
                    person: person.clone(),
                    group,
                    times_s,
                    hands,
                });
            }
        }
        for (group, needed) in [(Group::Expert, "E…"), (Group::Novice, "N…")] {
            let mut own = trials.iter().skip(before);
            if !own.any(|it: &Trial| it.group == group) {
                let where_ = at.display();
                return Err(format!(
                    "{where_}: no trial of a person {needed}; add one, or remove the task"
                ));
            }
        }
    }
    match (left.first(), trials.is_empty()) {
        (Some(name), _) => Err(format!(
            "--leave-out {name}: there is no such trial; give TASK/PERSON/TRIAL, such as Lung/N4/05"
        )),
        (None, true) => Err(format!(
            "{}: no trials; name a folder with TASK/PERSON/TRIAL.csv",
            folder.display()
        )),
        (None, false) => Ok(trials),
    }
}

/// Names in a folder, sorted, without hidden ones.
fn names(folder: &Path) -> Result<Vec<String>, String> {
    let told = |problem: std::io::Error| {
        let where_ = folder.display();
        format!("{where_}: {problem}; expected are folders TASK/PERSON with files TRIAL.csv")
    };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(told)? {
        let name = entry.map_err(told)?.file_name();
        names.push(name.to_string_lossy().into_owned());
    }
    names.retain(|name| !name.starts_with('.'));
    names.sort();
    Ok(names)
}

/// Times, s, and positions of both instruments, m.
type Course = (Vec<f64>, [Vec<[f64; 3]>; 2]);

/// Reads a trial's text. An error begins with its line.
fn parse(text: &str, unit_m: f64) -> Result<Course, String> {
    let (mut times_s, mut hands): Course = Default::default();
    let mut columns = None;
    for (index, line) in text.lines().enumerate() {
        let told = |what: String| format!("line {}: {what}", index + 1);
        if line.trim().is_empty() {
            continue;
        }
        let cells: Vec<&str> = line.split(',').collect();
        let expected = *columns.get_or_insert(cells.len());
        if cells.len() < COLUMNS || cells.len() != expected {
            let least = expected.max(COLUMNS);
            return Err(told(format!(
                "{} columns, expected are {least}",
                cells.len()
            )));
        }
        let number = |column: usize| {
            let cell = cells.get(column).copied().unwrap_or_default().trim();
            let value: Option<f64> = cell.parse().ok();
            value.filter(|it| it.abs() <= LARGEST).ok_or_else(|| {
                let cell: String = cell.chars().take(20).collect();
                told(format!(
                    "column {column} is '{cell}'; allowed is a number up to {LARGEST}"
                ))
            })
        };
        READ.into_iter()
            .try_for_each(|column| number(column).map(drop))?;
        let at_s = number(TIME)?;
        if let Some(last_s) = times_s.last().filter(|last_s| at_s <= **last_s) {
            let how = if at_s < *last_s {
                "goes back from"
            } else {
                "stands at"
            };
            return Err(told(format!("the clock {how} {last_s} s")));
        }
        times_s.push(at_s);
        for (hand, first) in hands.iter_mut().zip([0, 4]) {
            hand.push([
                number(first)? * unit_m,
                number(first + 1)? * unit_m,
                number(first + 2)? * unit_m,
            ]);
        }
    }
    match times_s.len() {
        0..ROWS_MIN => Err(format!(
            "line {}: it ends after {} rows; a trial has {ROWS_MIN} or more",
            text.lines().count(),
            times_s.len()
        )),
        _ => Ok((times_s, hands)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(rows: usize) -> String {
        let row = |i: usize| format!("{i},1,2,,3,4,5,,0,0,0,,0,0,0,,{i}.5,,,\n");
        (0..rows).map(row).collect()
    }

    fn folder(files: &[(&str, &str)]) -> std::path::PathBuf {
        use std::sync::atomic::{AtomicU32, Ordering};
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!(
            "hands-{}-{}",
            std::process::id(),
            NEXT.fetch_add(1, Ordering::Relaxed)
        );
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        for (path, text) in files {
            let path = folder.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    fn refused(files: &[(&str, &str)], leave_out: &[&str]) -> String {
        let folder = folder(files);
        let leave_out: Vec<String> = leave_out.iter().map(|&it| it.to_owned()).collect();
        let found = read_all(&folder, &leave_out, 0.01);
        std::fs::remove_dir_all(&folder).unwrap();
        found.map(|it| it.len()).unwrap_err()
    }

    #[test]
    fn a_trial_has_both_hands_in_metres() {
        let whole = text(30);
        let folder = folder(&[("Peg/E1/01.csv", &whole), ("Peg/N1/02.csv", &whole)]);
        let trials = read_all(&folder, &[], 0.01).unwrap();
        assert_eq!(trials[0].name, "Peg/E1/01");
        assert_eq!(trials[1].group, Group::Novice);
        assert!((trials[0].hands[0][3][0] - 0.03).abs() < 1e-12);
        assert!((trials[0].hands[1][3][2] - 0.05).abs() < 1e-12);
        assert!((trials[0].times_s[29] - 29.5).abs() < 1e-12);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_wrong_line_is_named_with_its_file_and_what_to_do() {
        let whole = text(30);
        let wrong = |from: &str, to: &str| {
            let text = whole.replacen(from, to, 1);
            assert_ne!(text, whole);
            refused(&[("Peg/E1/01.csv", &text), ("Peg/N1/01.csv", &whole)], &[])
        };
        for (from, to, told) in [
            (
                "4,1,2,,3",
                "4,x,2,,3",
                "line 5: column 1 is 'x'; allowed is a number up to 100000",
            ),
            ("4,1,2,,3", "4,1,2,,inf", "line 5: column 4 is 'inf'"),
            (
                "4,1,2,,3,4,5,,0",
                "4,1,2,,3,4,5,,",
                "line 5: column 8 is ''",
            ),
            ("4,1,2,,3", "4,1,,3", "line 5: 19 columns, expected are 20"),
            (",9.5,", ",8.5,", "line 10: the clock stands at 8.5 s"),
            (",9.5,", ",8.0,", "line 10: the clock goes back from 8.5 s"),
        ] {
            let error = wrong(from, to);
            assert!(error.contains("01.csv") && error.contains(told), "{error}");
            assert!(error.ends_with("mend it, or leave the trial out: --leave-out Peg/E1/01"));
        }
        let short = text(3);
        let error = refused(&[("Peg/E1/01.csv", &short)], &[]);
        assert!(
            error.contains("line 3: it ends after 3 rows; a trial has 20"),
            "{error}"
        );
        let narrow = "1,2,3\n".repeat(30);
        let error = refused(&[("Peg/E1/01.csv", &narrow)], &[]);
        assert!(
            error.contains("line 1: 3 columns, expected are 17"),
            "{error}"
        );
    }

    #[test]
    fn a_folder_of_another_form_is_refused_with_the_expected_one() {
        let whole = text(30);
        let trial = |path: &'static str| (path, whole.as_str());
        let error = refused(&[trial("Peg/Bob/01.csv")], &[]);
        assert!(
            error.contains("Bob: a person's folder is called E"),
            "{error}"
        );
        let error = refused(&[trial("Peg/E1/01.txt")], &[]);
        assert!(
            error.contains("01.txt: a trial is a file called"),
            "{error}"
        );
        let error = refused(&[trial("Peg/E1/01.csv")], &[]);
        assert!(
            error.contains("Peg: no trial of a person N…; add one"),
            "{error}"
        );
        let both = [trial("Peg/E1/01.csv"), trial("Peg/N1/01.csv")];
        let error = refused(&both, &["Peg/N1/09"]);
        assert!(
            error.contains("--leave-out Peg/N1/09: there is no such trial"),
            "{error}"
        );
        let error = refused(&[], &[]);
        assert!(error.contains("no trials; name a folder"), "{error}");
        let error = refused(&[trial("01.csv")], &[]);
        assert!(
            error.contains("expected are folders TASK/PERSON"),
            "{error}"
        );
        let bytes = read_all(Path::new("/nowhere"), &[], 0.01).map(|it| it.len());
        assert!(bytes.unwrap_err().contains("/nowhere: "));
    }
}
