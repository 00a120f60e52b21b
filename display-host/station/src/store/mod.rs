//! `calot store`: trainees, their sessions, their answers.

pub(crate) mod args;
mod left_out;
mod list;
mod name;
mod push;
mod questions;
mod record;
mod rescore;
mod sheets;
mod study;

use std::path::Path;
use std::process::ExitCode;

use assess::report::{Past, learning_curve};
use assess::{Difficulty, Metric, Outcome, Rules, Task};
use display_host::words::{Language, Words};
use store::{Consent, OtherOwner, SessionRecord, Sheet, Store, StoreError};

use self::args::{StoreArgs, StoreCommand, Table, joined};
use self::left_out::LeftOut;
use self::record::circumstances_beside;
pub(crate) use self::record::{Made, circumstances_of, record};
use crate::args::{LanguageName, NewTrainee, StoreFile};
use crate::clock::now_unix_s;
use crate::curriculum::{self, Curriculum};
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::report::{self, utc};
use crate::say;
use crate::sessions;

/// Outcome of a session whose recording breaks off before its task was decided.
const CUT_SHORT: &str = "cut-short";

pub(crate) fn run(args: &StoreArgs) -> Result<ExitCode, Problem> {
    let file = &args.file;
    match &args.command {
        StoreCommand::List { name, json } => list::run(file, joined(name).as_deref(), *json)?,
        StoreCommand::Progress {
            name,
            curriculum,
            json,
        } => {
            let curriculum = Curriculum::read(curriculum.as_deref())?;
            progress(&file.read()?, &name.read()?, &curriculum, *json)?;
        }
        StoreCommand::Certificate {
            name,
            curriculum,
            out,
            overwrite,
        } => {
            let curriculum = Curriculum::read(curriculum.as_deref())?;
            let out = output::file(out.as_deref(), "certificate.html", Format::Page, *overwrite)?;
            certificate(&file.read()?, &name.read()?, &curriculum, &out)?;
        }
        StoreCommand::Curriculum => say::answer(curriculum::BUILT_IN.trim_end()),
        StoreCommand::Add {
            name,
            sessions,
            new,
            json,
        } => {
            let mut store = file.open()?;
            new.confirm(&store, name)?;
            for session in sessions {
                let session = &sessions::find(session)?;
                let added = add(&mut store, name, session)?;
                if let (true, Some(added)) = (*json, added) {
                    document::SESSION.line(&added)?;
                }
            }
        }
        StoreCommand::Export { name, csv } => export(&file.read()?, name.as_deref(), *csv)?,
        StoreCommand::Trainee {
            name,
            cohort,
            consent,
            new,
        } => trainee(file, &name.read()?, cohort.as_deref(), *consent, *new)?,
        StoreCommand::Site { name: Some(name) } => file.open()?.set_site(name)?,
        StoreCommand::Site { name: None } => say::answer(file.read()?.site()?),
        StoreCommand::Merge { others, json } => {
            let into = file.path()?;
            // Refuse a store that cannot be read before a missing store is made.
            for other in others {
                Store::can_merge(&into, other)?;
            }
            let mut store = file.open()?;
            for other in others {
                merge(&mut store, other, *json)?;
            }
        }
        StoreCommand::Push(args) => return push::run(file, args),
        StoreCommand::Rescore(args) => return rescore::run(file, args),
        StoreCommand::Forget { name } => {
            // Fail if there is no store, instead of making one.
            drop(file.read()?);
            forget(&mut file.open()?, &name.read()?)?;
        }
        StoreCommand::Curve {
            name,
            task,
            difficulty,
            metric,
            out,
            overwrite,
        } => {
            let named = out.as_deref();
            let out = output::file(named, "curve.svg", Format::Drawing, *overwrite)?;
            curve(
                &file.read()?,
                &name.read()?,
                *task,
                *difficulty,
                metric,
                &out,
            )?;
        }
        StoreCommand::Sheet {
            session,
            points,
            sheet,
            rater,
            new,
            blinded,
            replace,
            json,
        } => match session {
            None => sheets::forms(*json)?,
            Some(session) if *json => sheets::show(&file.read()?, session)?,
            Some(session) => {
                let form = Sheet::named(sheet)?;
                let filled = sheets::Filled {
                    session,
                    form: &form,
                    rater: (rater, *blinded),
                    points,
                };
                filled.store(file, *new, *replace)?;
            }
        },
        StoreCommand::Study(args) => study::run(&file.read()?, args)?,
        StoreCommand::Ask {
            name,
            questionnaire,
            answers,
            new,
        } => questions::take(file, *new, name, questionnaire.as_deref(), answers)?,
        StoreCommand::Answers {
            questionnaire,
            json,
        } => questions::summarise(&file.read()?, questionnaire.as_deref(), *json)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Adds the contents of another station's store.
fn merge(store: &mut Store, other: &Path, json: bool) -> Result<(), Problem> {
    let merged = store.merge(other)?;
    if json {
        document::MERGED.line(&merged)?;
        return Ok(());
    }
    say::note(format_args!(
        "{}: {} sessions of {} new trainees added, {} were there already",
        other.display(),
        merged.sessions,
        merged.trainees,
        merged.known
    ));
    if merged.left_out_sessions + merged.left_out_answers + merged.left_out_trainees > 0 {
        say::note(format_args!(
            "{} sessions and {} answers are left out, because their {} trainees were forgotten",
            merged.left_out_sessions, merged.left_out_answers, merged.left_out_trainees
        ));
    }
    for name in &merged.forgotten_there {
        say::note(format_args!(
            "'{name}' was forgotten in that store and is still in this one; `calot store forget` forgets here, too"
        ));
    }
    for [known, new] in &merged.alike {
        say::note(format_args!(
            "the new trainee '{new}' looks like '{known}': if they are one person, choose one name"
        ));
    }
    for it in &merged.other_owners {
        let OtherOwner {
            session,
            here,
            there,
        } = it;
        say::note(format_args!(
            "session '{session}' belongs to '{here}' here and to '{there}' there: it stays with '{here}', and its \
             sheets from there are left out. Find out whose it is, and correct the store that is wrong"
        ));
    }
    if merged.differing > 0 {
        say::note(format_args!(
            "{} of these differ in that store; this store keeps its own versions",
            merged.differing
        ));
    }
    Ok(())
}

/// Prints a trainee's progress.
fn progress(store: &Store, name: &str, curriculum: &Curriculum, json: bool) -> Result<(), Problem> {
    let sessions = store.sessions(name, None)?;
    // Every line in a terminal is in English, so the titles of the levels are, too.
    let language = match json {
        true => LanguageName::or_users(None),
        false => Language::English,
    };
    let progress = curriculum.progress(name, &sessions, language);
    if json {
        return document::PROGRESS.answer(&progress);
    }
    progress.lines().into_iter().for_each(say::answer);
    Ok(())
}

/// Writes the certificate of the levels that a trainee has completed.
fn certificate(
    store: &Store,
    name: &str,
    curriculum: &Curriculum,
    out: &Path,
) -> Result<(), Problem> {
    let sessions = store.sessions(name, None)?;
    let words = Words::new(LanguageName::or_users(None));
    let progress = curriculum.progress(name, &sessions, words.language());
    let page = progress.certificate(&words).ok_or_else(|| {
        format!(
            "{name} has completed no level of the curriculum yet, so there is no certificate; \
             `calot store progress {name}` shows what comes next"
        )
    })?;
    output::write(out, &page).map_err(|error| format!("{}: {error}", out.display()))?;
    say::note(format_args!("wrote {}", out.display()));
    Ok(())
}

fn forget(store: &mut Store, name: &str) -> Result<(), Problem> {
    let gone = store.forget(name, now_unix_s())?;
    say::note(format_args!("forgot {name}"));
    if let Some(problem) = &gone.loose {
        say::note(format_args!(
            "the file was not compacted and keeps its size ({problem}); what was deleted is overwritten"
        ));
    }
    for centre in store.owed()? {
        say::note(format_args!(
            "{centre} still has to forget; `calot store push` tells it"
        ));
    }
    if !gone.files.is_empty() {
        say::note("recordings remain; a debrief.html beside one has the name. They lie at:");
        gone.files
            .iter()
            .for_each(|file| say::note(format_args!("  {file}")));
    }
    Ok(())
}

fn export(store: &Store, name: Option<&str>, csv: Option<Table>) -> Result<(), Problem> {
    let text = match csv {
        None => {
            let all = document::STORE.of(store.export_json(name)?);
            serde_json::to_string_pretty(&all)?
        }
        Some(Table::Sessions) => store.export_csv(name, &Metric::ALL.map(Metric::name))?,
        Some(Table::Answers) => store.export_answers_csv(name)?,
        Some(Table::Sheets) => store.export_sheets_csv(name)?,
    };
    say::answer(text.trim_end());
    Ok(())
}

/// Sets a trainee's cohort and consent, or prints them.
fn trainee(
    file: &StoreFile,
    name: &str,
    cohort: Option<&str>,
    consent: Option<Consent>,
    new: NewTrainee,
) -> Result<(), Problem> {
    if cohort.is_some() || consent.is_some() || new.new_trainee {
        let mut store = file.open()?;
        new.confirm(&store, name)?;
        store.enrol(name, cohort, consent, now_unix_s())?;
    }
    let people = file.read()?.trainees()?;
    let found = people.into_iter().find(|it| it.name == name);
    let found = found.ok_or_else(|| StoreError::NoTrainee(name.to_owned()))?;
    document::TRAINEE.line(&found)?;
    Ok(())
}

/// Adds a session from its recording. Returns `None` if it is in the store already.
fn add(store: &mut Store, name: &str, session: &Path) -> Result<Option<SessionRecord>, Problem> {
    let file = report::recording(session);
    let refused = |why: &str| Problem::from(format!("{}: {why}", file.display()));
    if session::is_being_recorded(&file) {
        return Err(refused(
            "it is still being recorded; add it once its run is over, which may keep it by itself",
        ));
    }
    let found = report::chapter(session, None, None)?;
    if let Some(why) = found.left_out.damaged() {
        return Err(refused(&format!("it is damaged {why}; it is not added")));
    }
    let is_task = |it: &session::Assignment| Task::from_name(&it.task).is_some();
    let assignment = found.assignment.filter(is_task).ok_or_else(|| {
        refused("it was recorded without a task (`calot run --task`) and has no result to store")
    })?;
    for warning in found.left_out.in_words() {
        say::note(format_args!("warning: {}: {warning}", file.display()));
    }
    let began_unix_s = i64::try_from(found.began_unix_s).unwrap_or(0);
    let (assessed, chapter) = (&found.chapter.assessed, &found.chapter);
    let id = &assignment.id;
    let made = Made {
        id,
        began_unix_s,
        scene: &chapter.scene,
        program: &chapter.build,
        file: Some(&file),
        hand: report::hand(chapter.is_scripted),
        circumstances: circumstances_beside(&file, id),
    };
    let mut record = record(assessed, made);
    // A decision before the break stays valid.
    let is_open = matches!(assessed.outcome, Outcome::Aborted | Outcome::Practised);
    if is_open && found.left_out.cut_short().is_some() {
        CUT_SHORT.clone_into(&mut record.outcome);
    }
    if !store.add_recorded(name, &record)? {
        say::note(format_args!(
            "session {id} is there already; it stays as it is"
        ));
        return Ok(None);
    }
    say::note(format_args!(
        "kept as {name}'s session {id}: {}",
        record.outcome
    ));
    Ok(Some(record))
}

/// Draws the learning curve of comparable sessions: completed, of one difficulty, assessed by one
/// version of the metrics.
fn curve(
    store: &Store,
    name: &str,
    task: Task,
    difficulty: Option<Difficulty>,
    metric: &str,
    out: &Path,
) -> Result<(), Problem> {
    let (sessions, left_out) = comparable(store.sessions(name, Some(task.name()))?, difficulty);
    if let Some(words) = left_out.in_words() {
        say::note(words);
    }
    let value = |it: &SessionRecord| match metric {
        "score" => Some(it.score),
        metric => it.metrics.get(metric).copied(),
    };
    let values: Vec<f64> = sessions.iter().filter_map(value).collect();
    let rules = Rules::default();
    let pass = rules
        .pass(task, Difficulty::default())
        .into_iter()
        .find(|it| it.name == metric);
    let rule = pass.map(|it| match it.at_least.is_finite() {
        true => it.at_least,
        false => it.at_most,
    });
    let words = Words::new(LanguageName::or_users(None));
    let drawn = learning_curve(&values, rule, metric, &words).ok_or_else(|| {
        format!(
            "{} session of task '{}' with {metric}: a curve needs at least two",
            values.len(),
            task.name()
        )
    })?;
    output::write(out, &drawn).map_err(|error| format!("{}: {error}", out.display()))?;
    say::note(format_args!(
        "wrote {}: {} sessions",
        out.display(),
        values.len()
    ));
    Ok(())
}

/// Completed sessions that are comparable with the newest one (of `difficulty`, if given), and the
/// numbers of the other sessions by reason.
fn comparable(
    sessions: Vec<SessionRecord>,
    difficulty: Option<Difficulty>,
) -> (Vec<SessionRecord>, LeftOut) {
    let asked = |it: &SessionRecord| difficulty.is_none_or(|of| of.name() == it.difficulty);
    let newest = sessions.iter().rfind(|it| counts(it) && asked(it));
    let newest = newest.map(|it| (it.difficulty.clone(), it.metrics_version));
    let mut left_out = LeftOut::default();
    let is_kept = |it: &SessionRecord| match left_out::reason(it, difficulty, newest.as_ref()) {
        None => true,
        Some(why) => {
            left_out.add(why);
            false
        }
    };
    let kept = sessions.into_iter().filter(is_kept).collect();
    (kept, left_out)
}

/// Data that the store adds to a debrief.
pub(crate) struct Before {
    pub(crate) past: Vec<Past>,
    pub(crate) sheet: Vec<(String, u8)>,
}

/// True if a person completed a session. An aborted session and practice take less time and incur
/// fewer penalties than a completed one. A scripted hand learns nothing. A complication by an
/// instructor makes a session harder than the others.
fn counts(session: &SessionRecord) -> bool {
    left_out::incomplete(session).is_none()
}

/// Criteria that make sessions comparable.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SessionCriteria<'a> {
    pub(crate) task: &'a str,
    pub(crate) difficulty: &'a str,
    /// Version of the metrics' definitions.
    pub(crate) version: u32,
}

impl SessionCriteria<'_> {
    fn holds(&self, session: &SessionRecord) -> bool {
        session.metrics_version == self.version && session.difficulty == self.difficulty
    }
}

/// A trainee's earlier completed sessions of a task at a difficulty, assessed by one version of the
/// metrics; and the sheet of this session.
pub(crate) fn past(
    store: &Store,
    name: &str,
    criteria: SessionCriteria<'_>,
    before: &str,
) -> Result<Before, StoreError> {
    let sessions = store.sessions(name, Some(criteria.task))?;
    let earlier = sessions.into_iter().take_while(|it| it.id != before);
    let comparable = earlier.filter(|it| counts(it) && criteria.holds(it));
    let past = comparable.map(|it| Past {
        when: utc(u64::try_from(it.began_unix_s).unwrap_or(0)),
        outcome: it.outcome,
        score: it.score,
        metrics: it.metrics,
    });
    Ok(Before {
        past: past.collect(),
        sheet: store.sheet(before)?,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use assess::{Anatomy, Assessment};
    use store::{Circumstances, Hand};

    use super::*;

    pub(crate) fn session(number: i64, difficulty: Difficulty, outcome: Outcome) -> SessionRecord {
        let rules = Rules::default();
        let assessed = Assessment::new(Task::Cut, difficulty, rules, Anatomy::default()).end();
        let id = number.to_string();
        let made = Made {
            id: &id,
            began_unix_s: number,
            scene: "triangle",
            program: "a test",
            file: None,
            hand: Hand::Person,
            circumstances: Circumstances::default(),
        };
        let mut record = record(&assessed, made);
        record.outcome = outcome.name().to_owned();
        record
    }

    fn sessions() -> Vec<SessionRecord> {
        vec![
            session(1, Difficulty::Exam, Outcome::Passed),
            session(2, Difficulty::Exam, Outcome::Aborted),
            session(3, Difficulty::Beginner, Outcome::Passed),
            session(4, Difficulty::Exam, Outcome::Practised),
            session(5, Difficulty::Exam, Outcome::Failed),
            SessionRecord {
                hand: Hand::Scripted,
                ..session(6, Difficulty::Exam, Outcome::Passed)
            },
            SessionRecord {
                metrics: [(Metric::Complications.name().to_owned(), 1.0)].into(),
                ..session(7, Difficulty::Exam, Outcome::Passed)
            },
        ]
    }

    #[test]
    fn a_command_that_fails_makes_no_store() {
        let folder = tempfile::tempdir().unwrap();
        let store = Some(folder.path().join("new/store.sqlite"));
        let commands = [
            StoreCommand::Forget { name: "Ada".into() },
            StoreCommand::Merge {
                others: vec![folder.path().join("none.sqlite")],
                json: false,
            },
        ];
        for command in commands {
            let file = StoreFile {
                store: store.clone(),
            };
            assert!(run(&StoreArgs { file, command }).is_err());
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        }
    }

    #[test]
    fn a_rater_fills_a_sheet_once_and_under_one_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("store.sqlite");
        let mut store = Store::open(&path).unwrap();
        let it = session(1, Difficulty::Exam, Outcome::Passed);
        store.add_session("Ada", &it).unwrap();
        drop(store);
        let fill = |rater, is_new, replaces| {
            let filled = sheets::Filled {
                session: &it.id,
                form: &Sheet::named("goals").unwrap(),
                rater: (rater, true),
                points: &[3; 5],
            };
            let file = StoreFile {
                store: Some(path.clone()),
            };
            let new = crate::args::NewRater { new_rater: is_new };
            filled.store(&file, new, replaces)
        };
        fill("Bo", false, false).unwrap();
        assert!(fill("Bo", false, false).is_err());
        fill("Bo", false, true).unwrap();
        fill("bo", true, false).unwrap();
        assert_eq!(
            Store::read(&path).unwrap().ratings(&it.id).unwrap().len(),
            2
        );
    }

    #[test]
    fn a_curve_has_sessions_that_compare() {
        let ids = |difficulty| {
            let (kept, left_out) = comparable(sessions(), difficulty);
            let ids: Vec<_> = kept.into_iter().map(|it| it.id).collect();
            (ids.join(" "), left_out.count())
        };
        assert_eq!(ids(None), ("1 5".to_owned(), 5));
        assert_eq!(ids(Some(Difficulty::Beginner)), ("3".to_owned(), 6));
        assert_eq!(ids(Some(Difficulty::Trainee)), (String::new(), 7));
        let words = comparable(sessions(), None).1.in_words().unwrap();
        assert_eq!(
            words,
            "5 sessions are left out: 1 aborted, 1 of practice, 1 by a scripted hand, 1 with complications by an \
             instructor, 1 of another difficulty (--difficulty)"
        );
    }

    #[test]
    fn debrief_compares_only_sessions_worked_to_their_end() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("store.sqlite")).unwrap();
        for it in sessions() {
            store.add_session("Ada", &it).unwrap();
        }
        let exam = SessionCriteria {
            task: "cut",
            difficulty: "exam",
            version: assess::VERSION,
        };
        for (session, expected) in [("5", &["passed"][..]), ("none", &["passed", "failed"])] {
            let before = past(&store, "Ada", exam, session).unwrap();
            let outcomes: Vec<_> = before.past.iter().map(|it| it.outcome.as_str()).collect();
            assert_eq!(outcomes, expected, "6 is a scripted hand's");
        }
    }
}
