//! A trainee's progress in a curriculum, and the task that comes next.

use assess::{Difficulty, Metric, Outcome};
use display_host::ui::launcher::{LevelView, ProgressView, TaskProgress};
use display_host::words::{Language, Words};
use store::{Hand, SessionRecord};

use super::{Aim, Curriculum, certificate};

/// Progress of a trainee, as JSON.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(crate) struct Progress {
    trainee: String,
    /// Number of tasks in which the trainee is proficient.
    proficient: usize,
    /// Number of tasks of the curriculum.
    of: usize,
    levels: Vec<LevelProgress>,
    /// First task in which the trainee is not proficient. `None`: the curriculum is complete.
    next: Option<Next>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
struct LevelProgress {
    title: String,
    tasks: Vec<AimProgress>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
struct AimProgress {
    task: &'static str,
    difficulty: &'static str,
    /// Least score of a pass that counts.
    benchmark: f64,
    /// Number of sessions that count for the task.
    sessions: usize,
    /// Best score of these sessions.
    best: Option<f64>,
    /// Number of passes at the benchmark since the last session that was none. It stays at `needed`
    /// once it has reached it.
    in_a_row: usize,
    /// Number of passes in a row that make the trainee proficient.
    needed: usize,
    proficient: bool,
    /// Beginning of the session that made the trainee proficient, Unix s.
    #[serde(skip)]
    since_unix_s: Option<i64>,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
struct Next {
    task: &'static str,
    difficulty: &'static str,
}

/// Difference of a pass and proficiency.
const MEANING: &str = "A pass keeps the limits of the task once. Proficient is who passes as often in a row, with as many \
                       points, as the line of a goal says. A pass after a restart is none of these.";

impl Curriculum {
    /// Progress of a trainee with these sessions, oldest first.
    pub(crate) fn progress(
        &self,
        trainee: &str,
        sessions: &[SessionRecord],
        language: Language,
    ) -> Progress {
        let level = |level: &super::Level| LevelProgress {
            title: level.title(language).to_owned(),
            tasks: level
                .tasks
                .iter()
                .map(|aim| aim.progress(sessions))
                .collect(),
        };
        let levels: Vec<LevelProgress> = self.levels.iter().map(level).collect();
        let all = || levels.iter().flat_map(|it| &it.tasks);
        let next = all().find(|it| !it.proficient).map(|it| Next {
            task: it.task,
            difficulty: it.difficulty,
        });
        Progress {
            trainee: trainee.to_owned(),
            proficient: all().filter(|it| it.proficient).count(),
            of: all().count(),
            next,
            levels,
        }
    }
}

impl Aim {
    fn progress(&self, sessions: &[SessionRecord]) -> AimProgress {
        let mut found = AimProgress {
            task: self.task.name(),
            difficulty: self.difficulty.name(),
            benchmark: self.score,
            sessions: 0,
            best: None,
            in_a_row: 0,
            needed: self.passes,
            proficient: false,
            since_unix_s: None,
        };
        for session in sessions.iter().filter(|it| self.takes(it)) {
            found.sessions += 1;
            found.best = Some(found.best.map_or(session.score, |it| it.max(session.score)));
            let is_pass = session.outcome == Outcome::Passed.name()
                && session.score >= self.score
                && !has_restarted(session);
            match (found.proficient, is_pass) {
                // A proficient trainee stays proficient.
                (true, _) => {}
                (false, true) => found.in_a_row += 1,
                (false, false) => found.in_a_row = 0,
            }
            if !found.proficient && found.in_a_row >= self.passes {
                found.proficient = true;
                found.since_unix_s = Some(session.began_unix_s);
            }
        }
        found
    }

    /// True for a person's session of this task with this difficulty or a harder one. A recording
    /// that broke off counts in an exam only, so that nobody ends one that goes badly by its plug.
    fn takes(&self, session: &SessionRecord) -> bool {
        let rank = |of: Difficulty| Difficulty::ALL.iter().position(|it| *it == of);
        let given = Difficulty::from_name(&session.difficulty);
        let outcomes = [Outcome::Passed, Outcome::Failed, Outcome::Aborted];
        session.hand == Hand::Person
            && session.task == self.task.name()
            && given.is_some_and(|it| rank(it) >= rank(self.difficulty))
            && (given == Some(Difficulty::Exam)
                || outcomes.iter().any(|it| it.name() == session.outcome))
    }
}

/// True if the trainee began anew within the session: what went wrong before is not in its result.
fn has_restarted(session: &SessionRecord) -> bool {
    let restarts = session.metrics.get(Metric::Restarts.name());
    restarts.is_some_and(|count| *count > 0.0)
}

impl AimProgress {
    fn row(&self) -> certificate::Row {
        certificate::Row {
            task: self.task,
            difficulty: self.difficulty,
            benchmark: self.benchmark,
            passes: self.needed,
            since_unix_s: self.since_unix_s.unwrap_or_default(),
        }
    }
}

impl Progress {
    /// The progress as the launcher shows it.
    pub(crate) fn view(&self) -> ProgressView {
        let task = |it: &AimProgress| TaskProgress {
            task: it.task.to_owned(),
            difficulty: it.difficulty.to_owned(),
            passes: [it.in_a_row, it.needed],
            is_proficient: it.proficient,
        };
        let level = |it: &LevelProgress| LevelView {
            title: it.title.clone(),
            tasks: it.tasks.iter().map(task).collect(),
        };
        let next = self.next.as_ref();
        ProgressView {
            done: [self.proficient, self.of],
            levels: self.levels.iter().map(level).collect(),
            next: next.map(|it| (it.task.to_owned(), it.difficulty.to_owned())),
            has_certificate: self.whole().next().is_some(),
        }
    }

    /// Levels in all tasks of which the trainee is proficient.
    fn whole(&self) -> impl Iterator<Item = &LevelProgress> {
        let is_whole = |it: &&LevelProgress| it.tasks.iter().all(|task| task.proficient);
        self.levels
            .iter()
            .filter(|it| !it.tasks.is_empty())
            .filter(is_whole)
    }

    /// The certificate of the levels that the trainee has completed, as a page. `None`: there is
    /// no such level yet.
    pub(crate) fn certificate(&self, words: &Words) -> Option<String> {
        self.whole().next()?;
        let levels = self.whole().map(|level| certificate::Level {
            title: &level.title,
            rows: level.tasks.iter().map(AimProgress::row).collect(),
        });
        let is_all = self.next.is_none();
        Some(certificate::page(
            &self.trainee,
            is_all,
            &levels.collect::<Vec<_>>(),
            words,
        ))
    }

    /// Command that works the next task.
    fn next_command(&self, next: &Next) -> String {
        let trainee = assess::report::in_shell(&self.trainee);
        format!(
            "next: calot run --task {} --difficulty {} --trainee {trainee}",
            next.task, next.difficulty
        )
    }

    /// Lines for a terminal.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "{}: proficient in {} of {} goals; a goal is a task with one kind of help",
            self.trainee, self.proficient, self.of
        )];
        lines.push(MEANING.to_owned());
        for level in &self.levels {
            lines.push(level.title.clone());
            for it in &level.tasks {
                let mark = if it.proficient { "done" } else { "    " };
                let best = it
                    .best
                    .map_or_else(|| "–".to_owned(), |it| format!("{it:.0}"));
                lines.push(format!(
                    "  {mark}  {:<10} {:<8}  {} of {} passes in a row at {:.0}; {} sessions, best {best}",
                    it.task, it.difficulty, it.in_a_row, it.needed, it.benchmark, it.sessions
                ));
            }
        }
        lines.push(self.next.as_ref().map_or_else(
            || "the curriculum is complete".to_owned(),
            |it| self.next_command(it),
        ));
        lines
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use store::Circumstances;

    use super::*;

    fn session(task: &str, difficulty: &str, outcome: &str, score: f64) -> SessionRecord {
        SessionRecord {
            id: String::new(),
            began_unix_s: 0,
            task: task.to_owned(),
            difficulty: difficulty.to_owned(),
            outcome: outcome.to_owned(),
            score,
            alarms: 0,
            metrics_version: 1,
            metrics: BTreeMap::new(),
            scene: String::new(),
            program: String::new(),
            file: None,
            hand: Hand::Person,
            circumstances: Circumstances::default(),
        }
    }

    fn progress(sessions: &[SessionRecord]) -> Progress {
        let curriculum = Curriculum::read(None).unwrap();
        curriculum.progress("Ada", sessions, Language::English)
    }

    fn of(progress: &Progress, task: &str, difficulty: &str) -> (usize, bool) {
        let mut all = progress.levels.iter().flat_map(|it| &it.tasks);
        let found = all.find(|it| (it.task, it.difficulty) == (task, difficulty));
        found.map(|it| (it.in_a_row, it.proficient)).unwrap()
    }

    #[test]
    fn a_new_trainee_begins_with_the_first_steps() {
        let next = progress(&[]).next.unwrap();
        assert_eq!((next.task, next.difficulty), ("basics", "beginner"));
    }

    #[test]
    fn two_passes_in_a_row_at_the_benchmark_make_proficient() {
        let pass = |score| session("scope", "beginner", "passed", score);
        let failed = session("scope", "beginner", "failed", 90.0);
        let scope = |sessions: &[SessionRecord]| of(&progress(sessions), "scope", "beginner");
        assert_eq!(scope(&[pass(80.0)]), (1, false));
        assert_eq!(scope(&[pass(80.0), pass(79.9)]), (0, false), "below it");
        assert_eq!(scope(&[pass(80.0), failed.clone(), pass(95.0)]), (1, false));
        assert_eq!(
            scope(&[pass(80.0), pass(80.0), failed]),
            (2, true),
            "it stays"
        );
        let aborted = session("scope", "beginner", "aborted", 0.0);
        assert_eq!(scope(&[pass(80.0), aborted, pass(80.0)]), (1, false));
        let cut_short = session("scope", "beginner", "cut-short", 0.0);
        assert_eq!(scope(&[pass(80.0), cut_short, pass(80.0)]), (2, true));
    }

    #[test]
    fn a_pass_after_a_restart_and_an_exam_that_broke_off_end_the_row() {
        let pass = || session("full", "exam", "passed", 90.0);
        let full = |sessions: &[SessionRecord]| of(&progress(sessions), "full", "exam").0;
        assert_eq!(full(&[pass()]), 1);
        let metrics = BTreeMap::from([("restarts".to_owned(), 1.0)]);
        let again = SessionRecord { metrics, ..pass() };
        assert_eq!(full(&[pass(), again]), 0);
        let cut_short = session("full", "exam", "cut-short", 0.0);
        assert_eq!(full(&[pass(), cut_short]), 0);
    }

    #[test]
    fn a_pass_with_less_help_counts_for_more_help_and_one_by_a_script_for_nobody() {
        let alone = session("clamp", "trainee", "passed", 85.0);
        let all = progress(&[alone.clone(), alone.clone()]);
        assert_eq!(of(&all, "clamp", "beginner"), (2, true));
        assert_eq!(of(&all, "clamp", "trainee"), (2, true));
        let helped = session("clamp", "beginner", "passed", 85.0);
        let all = progress(&[helped.clone(), helped]);
        assert_eq!(of(&all, "clamp", "trainee"), (0, false));
        let scripted = SessionRecord {
            hand: Hand::Scripted,
            ..alone
        };
        let all = progress(&[scripted.clone(), scripted]);
        assert_eq!(of(&all, "clamp", "beginner"), (0, false));
    }

    #[test]
    fn a_certificate_lists_the_levels_that_are_complete() {
        let pass = |task: &str, began_unix_s| SessionRecord {
            began_unix_s,
            ..session(task, "beginner", "passed", 90.0)
        };
        let english = Words::new(Language::English);
        let some = progress(&[pass("basics", 1), pass("scope", 2)]);
        assert!(some.certificate(&english).is_none() && !some.view().has_certificate);
        let level = curriculum_first_level();
        let mut sessions = Vec::new();
        for (number, task) in level.iter().enumerate() {
            let began = 1_790_000_000 + 86_400 * number as i64;
            sessions.extend([pass(task, began), pass(task, began + 60)]);
        }
        let whole = progress(&sessions);
        assert!(whole.view().has_certificate);
        let page = whole.certificate(&english).unwrap();
        for part in ["Ada", "First steps", "2026-09-21", "<html lang=\"en\">"] {
            assert!(page.contains(part), "{part}: {page}");
        }
        assert!(!page.contains("The whole operation"), "{page}");
        let german = whole.certificate(&Words::new(Language::German)).unwrap();
        assert!(german.contains("Zertifikat") && !german.contains("certificate-"));
        let evil = Progress {
            trainee: "<script>".to_owned(),
            ..whole
        };
        assert!(!evil.certificate(&english).unwrap().contains("<script>"));
    }

    fn curriculum_first_level() -> Vec<&'static str> {
        let curriculum = Curriculum::read(None).unwrap();
        let first = curriculum.levels.first().unwrap();
        first.tasks.iter().map(|it| it.task.name()).collect()
    }

    #[test]
    fn progress_is_shown_in_a_terminal_and_in_the_window() {
        let all = progress(&[session("basics", "beginner", "passed", 100.0)]);
        let lines = all.lines().join("\n");
        for part in [
            "Ada: proficient in 1 of 13 goals",
            MEANING,
            "done  basics",
            "0 of 2 passes in a row at 80; 0 sessions, best –",
            "next: calot run --task scope --difficulty beginner --trainee 'Ada'",
        ] {
            assert!(lines.contains(part), "{part}: {lines}");
        }
        let view = all.view();
        assert_eq!(view.done, [1, 13]);
        assert_eq!(view.next, Some(("scope".to_owned(), "beginner".to_owned())));
        assert!(view.levels[0].tasks[0].is_proficient);
        let whole = Progress { next: None, ..all };
        assert!(
            whole
                .lines()
                .join("")
                .contains("the curriculum is complete")
        );
    }
}
