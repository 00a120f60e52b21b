//! `calot store rescore`: scores many recordings again, several at once.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use assess::{Metric, Rules};
use store::{SessionRecord, Store, csv_field};

use super::args::RescoreArgs;
use crate::args::StoreFile;
use crate::problem::Problem;
use crate::report::{self, Found};
use crate::say;

/// Sessions of the store by id, each with the name of its trainee.
type Known = BTreeMap<String, (String, SessionRecord)>;

/// Columns before those of the metrics.
const BEFORE: [&str; 10] = [
    "trainee",
    "session",
    "began_unix_s",
    "task",
    "difficulty",
    "hand",
    "outcome_before",
    "score_before",
    "outcome",
    "score",
];
/// Columns after those of the metrics.
const AFTER: [&str; 3] = ["metrics_version", "file", "problem"];

/// A recording, or a folder that cannot be searched for recordings.
#[derive(Debug, PartialEq)]
struct Piece {
    path: PathBuf,
    /// Reason why it cannot be read, if it cannot.
    unread: Option<String>,
}

/// Row of a recording, and the differences from the store.
struct Row {
    fields: Vec<String>,
    is_changed: bool,
    is_unread: bool,
}

pub(super) fn run(file: &StoreFile, args: &RescoreArgs) -> Result<ExitCode, Problem> {
    let rules = args.rules.as_deref().map(Rules::read).transpose()?;
    let known = file.read_if_any()?.map(|it| known(&it)).transpose()?;
    let known = known.unwrap_or_default();
    let mut recordings = Vec::new();
    for it in &args.recordings {
        // Each named file or folder must exist.
        std::fs::metadata(it).map_err(|error| format!("{}: {error}", it.display()))?;
        search(it, &mut recordings);
    }
    if recordings.is_empty() {
        return Err("there is no recording (.mcap) in these folders".into());
    }
    let jobs = args
        .jobs
        .or_else(|| std::thread::available_parallelism().ok());
    let jobs = jobs.map_or(1, NonZeroUsize::get).min(recordings.len());
    let start = Instant::now();
    let metrics = Metric::ALL.iter().map(|it| it.name());
    let head: Vec<&str> = BEFORE.into_iter().chain(metrics).chain(AFTER).collect();
    say::answer(head.join(","));
    let (mut changed, mut unread) = (0, 0);
    in_order(
        jobs,
        recordings.len(),
        |at| row(&recordings[at], rules.as_ref(), &known),
        |row| {
            let fields: Vec<String> = row.fields.iter().map(|it| csv_field(it)).collect();
            say::answer(fields.join(","));
            changed += usize::from(row.is_changed);
            unread += usize::from(row.is_unread);
        },
    );
    let took_s = start.elapsed().as_secs_f64();
    say::note(format_args!(
        "{} recordings in {took_s:.1} s on {jobs} threads, {:.1} a second; {changed} outcomes differ from the store, \
         {unread} recordings cannot be read",
        recordings.len(),
        recordings.len() as f64 / took_s
    ));
    Ok(match unread {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

fn known(store: &Store) -> Result<Known, Problem> {
    let mut known = Known::new();
    for person in store.trainees()? {
        for session in store.sessions(&person.name, None)? {
            known.insert(session.id.clone(), (person.name.clone(), session));
        }
    }
    Ok(known)
}

/// Adds a recording, or all recordings in a folder and below it, sorted by name. Links to folders
/// are not followed, because they may lead in circles. A folder that cannot be read is added with
/// the reason.
fn search(path: &Path, found: &mut Vec<Piece>) {
    let mut add = |unread| {
        found.push(Piece {
            path: path.to_owned(),
            unread,
        });
    };
    if !path.is_dir() {
        return add(None);
    }
    let entries = std::fs::read_dir(path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
    let mut entries: Vec<PathBuf> = match entries {
        Ok(entries) => entries.iter().map(|it| it.path()).collect(),
        Err(error) => return add(Some(error.to_string())),
    };
    entries.sort();
    for it in entries {
        let is_recording = it.extension().is_some_and(|it| it == "mcap") && !it.is_dir();
        let is_folder = std::fs::symlink_metadata(&it).is_ok_and(|it| it.is_dir());
        if is_recording || is_folder {
            search(&it, found);
        }
    }
}

/// Does `count` pieces of work on `jobs` threads. `take` gets the results in the order of the
/// pieces.
fn in_order<T: Send>(
    jobs: usize,
    count: usize,
    work: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(T),
) {
    let next = AtomicUsize::new(0);
    let (done, results) = mpsc::channel();
    std::thread::scope(|threads| {
        for _ in 0..jobs {
            let (done, next, work) = (done.clone(), &next, &work);
            threads.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    if at >= count || done.send((at, work(at))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        let (mut next_result, mut early) = (0, BTreeMap::new());
        for (at, result) in results {
            early.insert(at, result);
            while let Some(result) = early.remove(&next_result) {
                take(result);
                next_result += 1;
            }
        }
    });
}

/// Scores a recording.
fn row(piece: &Piece, rules: Option<&Rules>, known: &Known) -> Row {
    let file = &piece.path;
    let scored = match &piece.unread {
        None => report::chapter(file, rules, None),
        Some(reason) => Err(reason.as_str().into()),
    };
    let told = match &scored {
        Ok(found) => found.left_out.in_words().join("; "),
        Err(error) => error.to_string(),
    };
    let is_unread = match &scored {
        Ok(found) => found.left_out.damaged().is_some(),
        Err(_) => true,
    };
    let last = [file.display().to_string(), told];
    let Ok(found) = scored else {
        let empty = BEFORE.len() + Metric::ALL.len() + 1;
        return Row {
            fields: std::iter::repeat_n(String::new(), empty)
                .chain(last)
                .collect(),
            is_changed: false,
            is_unread,
        };
    };
    let id = found.assignment.as_ref().map_or("", |it| it.id.as_str());
    let before = known.get(id);
    let assessed = &found.chapter.assessed;
    let outcome = assessed.outcome.name();
    let is_changed = before.is_some_and(|(_, it)| it.outcome != outcome);
    let mut fields = about(&found, id, before);
    fields.extend([outcome.to_owned(), assessed.score.to_string()]);
    let value = |metric| assessed.metrics.get(metric);
    fields.extend(Metric::ALL.map(value).map(|it| match it.is_finite() {
        true => it.to_string(),
        false => String::new(),
    }));
    fields.push(assessed.version.to_string());
    fields.extend(last);
    Row {
        fields,
        is_changed,
        is_unread,
    }
}

/// Fields of a session that its scoring does not change.
fn about(found: &Found, id: &str, before: Option<&(String, SessionRecord)>) -> Vec<String> {
    let assessed = &found.chapter.assessed;
    let stored =
        |text: fn(&SessionRecord) -> String| before.map_or_else(String::new, |it| text(&it.1));
    vec![
        before.map_or_else(String::new, |it| it.0.clone()),
        id.to_owned(),
        found.began_unix_s.to_string(),
        assessed.task.name().to_owned(),
        assessed.difficulty.name().to_owned(),
        report::hand(found.chapter.is_scripted).name().to_owned(),
        stored(|it| it.outcome.clone()),
        stored(|it| it.score.to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_from_any_number_of_threads() {
        for jobs in [1, 2, 7] {
            let mut taken = Vec::new();
            let slow_first = |at: usize| {
                std::thread::sleep(std::time::Duration::from_millis(20 - at as u64));
                at * at
            };
            in_order(jobs, 20, slow_first, |it| taken.push(it));
            let expected: Vec<usize> = (0..20).map(|it| it * it).collect();
            assert_eq!(taken, expected, "{jobs}");
        }
    }

    #[test]
    fn folders_are_searched_for_recordings_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(path("b/c")).unwrap();
        for name in ["b/c/2.mcap", "b/1.mcap", "a.mcap", "b/summary.json"] {
            std::fs::write(path(name), "").unwrap();
        }
        std::os::unix::fs::symlink(path("b"), path("b/round")).unwrap();
        std::os::unix::fs::symlink(path("b"), path("round.mcap")).unwrap();
        let mut found = Vec::new();
        search(folder.path(), &mut found);
        let expected = ["a.mcap", "b/1.mcap", "b/c/2.mcap"].map(|name| Piece {
            path: path(name),
            unread: None,
        });
        assert_eq!(found, expected);
        let args = RescoreArgs {
            recordings: vec![path("none")],
            rules: None,
            jobs: None,
        };
        let none = run(&StoreFile { store: None }, &args).unwrap_err();
        assert!(none.to_string().contains("none: No such file"), "{none}");
    }

    #[test]
    fn an_unreadable_recording_is_a_row_with_the_reason_and_others_follow() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, path(name)).unwrap();
        link("/nowhere", "dangling.mcap");
        link("two.mcap", "one.mcap");
        link("one.mcap", "two.mcap");
        link(".", "loop.mcap");
        std::fs::write(path("session.mcap"), "no recording").unwrap();
        std::fs::create_dir(path("locked")).unwrap();
        let mode = |mode| {
            let mode = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(path("locked"), mode).unwrap();
        };
        mode(0o000);
        // Root reads every folder.
        let is_locked = std::fs::read_dir(path("locked")).is_err();
        let mut found = Vec::new();
        search(folder.path(), &mut found);
        mode(0o700);
        let mut expected = vec![
            ("dangling.mcap", "No such file"),
            ("locked", "Permission denied"),
            ("one.mcap", "symbolic links"),
            ("session.mcap", "session.mcap"),
            ("two.mcap", "symbolic links"),
        ];
        expected.retain(|it| is_locked || it.0 != "locked");
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (piece, (name, reason)) in found.iter().zip(expected) {
            assert_eq!(piece.path, path(name));
            check_unread(&row(piece, None, &Known::new()), reason);
        }
        let locked = Piece {
            path: path("locked"),
            unread: Some("Permission denied".to_owned()),
        };
        check_unread(&row(&locked, None, &Known::new()), "Permission denied");
    }

    fn check_unread(row: &Row, reason: &str) {
        let columns = BEFORE.len() + Metric::ALL.len() + AFTER.len();
        assert_eq!(row.fields.len(), columns);
        let told = &row.fields[columns - 1];
        assert!(row.is_unread && told.contains(reason), "{told}");
    }
}
