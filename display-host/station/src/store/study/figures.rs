//! Figures of a study: comparisons of groups, agreement of raters, consistency of items.

use std::collections::{BTreeMap, BTreeSet};

use assess::Metric;
use statistics::{Agreement, Compared, compare, cronbach_alpha, holm, icc, quantile};
use store::{Rating, Store};

use super::sample::{Sample, TaskSample};
use crate::problem::Problem;

/// Least number of persons of a group for a comparison. With fewer, no order of the values is rare
/// enough to be significant.
const PERSONS_MIN: usize = 3;
/// Least number of sessions for the agreement of raters.
const SESSIONS_MIN: usize = 3;

/// Two groups compared in one metric.
#[derive(Debug)]
pub(super) struct Pair {
    pub(super) groups: [String; 2],
    pub(super) found: Compared,
    /// Probability after Holm's correction for all comparisons of the task.
    pub(super) raised: f64,
}

/// A metric of a task: quartiles of each group, and comparisons of pairs of groups. A group that is
/// too small is not compared.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) metric: String,
    pub(super) unit: &'static str,
    /// First quartile, median and third quartile of the persons of each group.
    pub(super) quartiles: Vec<[f64; 3]>,
    pub(super) pairs: Vec<Pair>,
}

/// Score and every metric whose values differ between sessions.
pub(super) fn rows(task: &TaskSample) -> Vec<Row> {
    let groups = task.groups();
    let mut rows = Vec::new();
    let metrics = Metric::ALL.map(|it| (it.name(), it.unit()));
    for (metric, unit) in [("score", "of 100")].into_iter().chain(metrics) {
        let values: Vec<Vec<f64>> = groups.iter().map(|it| task.medians(it, metric)).collect();
        let all = values.iter().flatten().copied();
        let (least, most) = all.fold((f64::MAX, f64::MIN), |(a, b), it| (a.min(it), b.max(it)));
        if least >= most {
            continue;
        }
        let quartiles = values
            .iter()
            .map(|it| [0.25, 0.5, 0.75].map(|at| quantile(it, at)));
        let mut pairs = Vec::new();
        let named: Vec<(&String, &Vec<f64>)> = groups.iter().zip(&values).collect();
        for (number, (first, a)) in named.iter().enumerate() {
            for (second, b) in named.iter().skip(number + 1) {
                if a.len() >= PERSONS_MIN && b.len() >= PERSONS_MIN {
                    pairs.push(Pair {
                        groups: [(*first).clone(), (*second).clone()],
                        found: compare(&[(*a).clone(), (*b).clone()]),
                        raised: f64::NAN,
                    });
                }
            }
        }
        rows.push(Row {
            metric: metric.to_owned(),
            unit,
            quartiles: quartiles.collect(),
            pairs,
        });
    }
    let all: Vec<f64> = rows
        .iter()
        .flat_map(|it| &it.pairs)
        .map(|it| it.found.p)
        .collect();
    let pairs = rows.iter_mut().flat_map(|it| &mut it.pairs);
    for (pair, raised) in pairs.zip(holm(&all)) {
        pair.raised = raised;
    }
    rows
}

/// Agreement on a sheet, or consistency of a questionnaire.
#[derive(Debug)]
pub(super) struct Reliability {
    pub(super) name: String,
    /// Number of filled forms.
    pub(super) filled: usize,
    /// Number of sessions that all these raters scored; only for a sheet.
    pub(super) sessions: usize,
    /// Number of raters whose agreement is computed; only for a sheet.
    pub(super) raters: usize,
    pub(super) agreement: Option<Agreement>,
    pub(super) alpha: Option<f64>,
}

/// Agreement on every sheet and consistency of every questionnaire, for the sessions and trainees
/// of the sample.
pub(super) fn agreements(store: &Store, sample: &Sample) -> Result<Vec<Reliability>, Problem> {
    let sessions = { sample.tasks.iter() }.flat_map(|it| &it.people);
    let sessions: BTreeSet<&String> = sessions
        .flat_map(|it| &it.sessions)
        .map(|it| &it.id)
        .collect();
    let mut sheets: BTreeMap<String, Vec<Rating>> = BTreeMap::new();
    let mut answers: BTreeMap<String, Vec<BTreeMap<String, f64>>> = BTreeMap::new();
    for person in store.trainees()? {
        for rating in store.ratings_of(&person.name)? {
            if sessions.contains(&rating.session) {
                sheets.entry(rating.sheet.clone()).or_default().push(rating);
            }
        }
        let mut own: BTreeMap<String, BTreeMap<String, f64>> = BTreeMap::new();
        if person.consent != store::Consent::No {
            for it in store.answers_of(&person.name)? {
                let of_form = own.entry(it.questionnaire).or_default();
                of_form.insert(it.item, it.value as f64);
            }
        }
        for (form, items) in own {
            answers.entry(form).or_default().push(items);
        }
    }
    let mut all: Vec<Reliability> = sheets.iter().map(|(name, it)| of_sheet(name, it)).collect();
    all.extend(answers.into_iter().map(|(name, forms)| Reliability {
        name: format!("{name} (questionnaire)"),
        filled: forms.len(),
        sessions: 0,
        raters: 0,
        agreement: None,
        alpha: consistency(&forms),
    }));
    Ok(all)
}

fn of_sheet(name: &str, ratings: &[Rating]) -> Reliability {
    let mut sums: BTreeMap<&str, BTreeMap<&str, f64>> = BTreeMap::new();
    for it in ratings {
        let of_rater = sums.entry(&it.rater).or_default();
        of_rater.insert(&it.session, f64::from(it.sum()));
    }
    // Leave out raters, those with the fewest sheets first, until all others have scored enough
    // sessions in common.
    let mut raters: Vec<_> = sums.into_values().collect();
    raters.sort_by_key(|it| std::cmp::Reverse(it.len()));
    let table = loop {
        let first = raters.first().into_iter().flat_map(|it| it.keys());
        let row = |session: &&str| -> Option<Vec<f64>> {
            raters.iter().map(|it| it.get(session).copied()).collect()
        };
        let table: Vec<Vec<f64>> = first.filter_map(row).collect();
        if table.len() >= SESSIONS_MIN || raters.len() <= 2 {
            break table;
        }
        raters.pop();
    };
    let forms = ratings.iter().map(|it| {
        let points = it.points.iter();
        points
            .map(|(item, value)| (item.clone(), f64::from(*value)))
            .collect()
    });
    Reliability {
        name: name.to_owned(),
        filled: ratings.len(),
        sessions: table.len(),
        raters: raters.len(),
        agreement: icc(&table),
        alpha: consistency(&forms.collect::<Vec<_>>()),
    }
}

/// Consistency of the forms in which every item is filled.
fn consistency(forms: &[BTreeMap<String, f64>]) -> Option<f64> {
    let items: BTreeSet<&String> = forms.iter().flat_map(BTreeMap::keys).collect();
    let whole = forms.iter().filter(|it| it.len() == items.len());
    let rows: Vec<Vec<f64>> = whole.map(|it| it.values().copied().collect()).collect();
    cronbach_alpha(&rows)
}
