//! Sample of a study: its people, and their sessions that count.

use std::collections::{BTreeMap, BTreeSet};

use store::{Consent, Hand, SessionRecord, Store};

use super::args::{By, StudyArgs};
use crate::problem::Problem;

/// Name of the group of people whose group is not known.
const GROUP_NOT_KNOWN: &str = "not told";

/// A person in one task.
#[derive(Debug)]
pub(super) struct Person {
    /// A number, or the name.
    pub(super) label: String,
    pub(super) group: String,
    /// Oldest first.
    pub(super) sessions: Vec<SessionRecord>,
}

impl Person {
    /// Values of `score` or a metric, oldest session first.
    pub(super) fn values(&self, metric: &str) -> Vec<f64> {
        let value = |it: &SessionRecord| match metric {
            "score" => Some(it.score),
            metric => it.metrics.get(metric).copied(),
        };
        self.sessions.iter().filter_map(value).collect()
    }

    /// Median of the person's sessions; NaN without a value.
    pub(super) fn median(&self, metric: &str) -> f64 {
        statistics::median(&self.values(metric))
    }
}

/// Comparable sessions of one task.
#[derive(Debug)]
pub(super) struct TaskSample {
    pub(super) task: String,
    pub(super) difficulty: String,
    pub(super) version: u32,
    pub(super) people: Vec<Person>,
}

impl TaskSample {
    /// Names of the groups in order.
    pub(super) fn groups(&self) -> Vec<String> {
        let names: BTreeSet<_> = self.people.iter().map(|it| it.group.clone()).collect();
        names.into_iter().collect()
    }

    /// Persons' medians in a group, without persons that have no value.
    pub(super) fn medians(&self, group: &str, metric: &str) -> Vec<f64> {
        let people = self.people.iter().filter(|it| it.group == group);
        let medians = people.map(|it| it.median(metric));
        medians.filter(|it| it.is_finite()).collect()
    }
}

/// Numbers of sessions that are left out, by reason, and of included sessions about which something
/// is not known.
#[derive(Debug, Default)]
pub(super) struct LeftOut {
    refused: usize,
    not_asked: usize,
    scripted: usize,
    not_realtime: usize,
    unfinished: usize,
    other: usize,
    /// Included sessions of which it is not known if they were realtime.
    pub(super) unknown_realtime: usize,
    /// Included sessions of trainees whom nobody asked for consent.
    pub(super) unknown_consent: usize,
}

impl LeftOut {
    /// A phrase for each reason that left out a session.
    pub(super) fn in_words(&self) -> Vec<String> {
        let reasons = [
            (self.refused, "of trainees who refused consent"),
            (self.not_asked, "of trainees of whom no consent is known"),
            (
                self.scripted,
                "of scripted hands (--scripted takes them in)",
            ),
            (
                self.not_realtime,
                "that were not realtime (--not-realtime takes them in)",
            ),
            (self.unfinished, "that were aborted, cut short, or practice"),
            (
                self.other,
                "of another difficulty or version of the metrics",
            ),
        ];
        let told = reasons.iter().filter(|(count, _)| *count > 0);
        let told: Vec<String> = told.map(|(count, why)| format!("{count} {why}")).collect();
        match told.is_empty() {
            true => vec!["none".to_owned()],
            false => told,
        }
    }
}

/// The sessions of a study.
#[derive(Debug)]
pub(super) struct Sample {
    pub(super) by: By,
    pub(super) tasks: Vec<TaskSample>,
    pub(super) left_out: LeftOut,
    pub(super) has_scripted: bool,
}

type Found = (String, String, SessionRecord);

impl Sample {
    pub(super) fn of(store: &Store, args: &StudyArgs) -> Result<Self, Problem> {
        let mut left_out = LeftOut::default();
        let mut found: BTreeMap<String, Vec<Found>> = BTreeMap::new();
        for (number, person) in store.trainees()?.into_iter().enumerate() {
            let label = match args.names {
                true => person.name.clone(),
                false => format!("P{:02}", number + 1),
            };
            let task = args.task.map(assess::Task::name);
            for session in store.sessions(&person.name, task)? {
                if !counts(&session, person.consent, args, &mut left_out) {
                    continue;
                }
                let made = &session.circumstances;
                let group = match args.by {
                    By::Cohort => &person.cohort,
                    By::Site => &made.site,
                    By::Driver => &made.driver,
                };
                let group = match group.as_str() {
                    "" => GROUP_NOT_KNOWN.to_owned(),
                    group => group.to_owned(),
                };
                let of_task = found.entry(session.task.clone()).or_default();
                of_task.push((label.clone(), group, session));
            }
        }
        let difficulty = args.difficulty.map(assess::Difficulty::name);
        let mut tasks = Vec::new();
        for (task, all) in found {
            tasks.extend(comparable(task, all, difficulty, &mut left_out));
        }
        let mut sessions = { tasks.iter() }
            .flat_map(|it| &it.people)
            .flat_map(|it| &it.sessions);
        let has_scripted = sessions.any(|it| it.hand == Hand::Scripted);
        Ok(Self {
            by: args.by,
            tasks,
            left_out,
            has_scripted,
        })
    }
}

/// Decides if a session counts. If not, counts it in `out` under the reason.
fn counts(it: &SessionRecord, consent: Consent, args: &StudyArgs, out: &mut LeftOut) -> bool {
    let is_scripted = it.hand == Hand::Scripted;
    let realtime = it.circumstances.realtime;
    let reason = if consent == Consent::No {
        &mut out.refused
    } else if args.consented && consent == Consent::Unknown {
        &mut out.not_asked
    } else if is_scripted && !args.scripted {
        &mut out.scripted
    } else if !is_scripted && realtime == Some(false) && !args.not_realtime {
        &mut out.not_realtime
    } else if !matches!(it.outcome.as_str(), "passed" | "failed") {
        &mut out.unfinished
    } else {
        out.unknown_realtime += usize::from(realtime.is_none() && !is_scripted);
        out.unknown_consent += usize::from(consent == Consent::Unknown && !is_scripted);
        return true;
    };
    *reason += 1;
    false
}

/// Sessions of one difficulty and one version of the metrics: the most frequent, of the difficulty
/// that is asked for.
fn comparable(
    task: String,
    all: Vec<Found>,
    difficulty: Option<&str>,
    left_out: &mut LeftOut,
) -> Option<TaskSample> {
    let mut kinds: BTreeMap<(u32, String), usize> = BTreeMap::new();
    let kind = |it: &SessionRecord| (it.metrics_version, it.difficulty.clone());
    let asked = |it: &&Found| difficulty.is_none_or(|name| it.2.difficulty == name);
    for (_, _, session) in all.iter().filter(asked) {
        *kinds.entry(kind(session)).or_default() += 1;
    }
    let chosen = kinds.into_iter().max_by_key(|(_, count)| *count);
    let chosen = chosen.map(|(kind, _)| kind);
    let mut people: BTreeMap<(String, String), Vec<SessionRecord>> = BTreeMap::new();
    for (label, group, session) in all {
        match Some(kind(&session)) == chosen {
            true => people.entry((group, label)).or_default().push(session),
            false => left_out.other += 1,
        }
    }
    let (version, difficulty) = chosen?;
    let people = people.into_iter().map(|((group, label), sessions)| Person {
        label,
        group,
        sessions,
    });
    Some(TaskSample {
        task,
        difficulty,
        version,
        people: people.collect(),
    })
}
