//! `calot store study`: compares groups of trainees, their learning, and the agreement of raters.
//!
//! ```text
//! sample   sessions and people that count, and the number of those that do not
//! figures  medians of each person, comparison of groups, learning, agreement of raters
//! page     study.html
//! ```

mod args;
mod figures;
mod page;
mod sample;

use assess::Metric;
use store::{Store, csv_field};

pub(crate) use self::args::StudyArgs;
use self::sample::Sample;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;

/// Writes study.csv and study.html.
pub(super) fn run(store: &Store, args: &StudyArgs) -> Result<(), Problem> {
    let place = |name: &str| args.out.join(name);
    let table = output::file(Some(&place("study.csv")), "", Format::Table, args.overwrite)?;
    let page = output::file(Some(&place("study.html")), "", Format::Page, args.overwrite)?;
    let sample = Sample::of(store, args)?;
    if sample.tasks.is_empty() {
        return Err(format!(
            "no session is left to compare: {}",
            sample.left_out.in_words().join("; ")
        )
        .into());
    }
    std::fs::create_dir_all(&args.out)
        .map_err(|error| format!("{}: {error}", args.out.display()))?;
    let text = page::html(&sample, &figures::agreements(store, &sample)?);
    for (path, text) in [(&table, csv(&sample)), (&page, text)] {
        output::write(path, &text).map_err(|error| format!("{}: {error}", path.display()))?;
        say::note(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// Columns of study.csv before those of the metrics.
const COLUMNS: &str = "task,difficulty,metrics_version,group,person,sessions,score";

/// Text of study.csv: a row for each person and task, with medians of the person's sessions.
fn csv(sample: &Sample) -> String {
    let metrics = Metric::ALL.map(Metric::name).join(",");
    let mut text = format!("{COLUMNS},{metrics}\n");
    for task in &sample.tasks {
        for person in &task.people {
            let values = Metric::ALL.map(|it| person.median(it.name()));
            let values = [person.median("score")].into_iter().chain(values);
            let values = values.map(|it| match it.is_finite() {
                true => it.to_string(),
                false => String::new(),
            });
            let row = [
                task.task.clone(),
                task.difficulty.clone(),
                task.version.to_string(),
                person.group.clone(),
                person.label.clone(),
                person.sessions.len().to_string(),
            ];
            let fields = row.into_iter().chain(values).map(|it| csv_field(&it));
            text += &fields.collect::<Vec<_>>().join(",");
            text.push('\n');
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use store::{Hand, SessionRecord};

    use super::args::By;
    use super::sample::{LeftOut, Person, TaskSample};
    use super::*;

    #[test]
    fn no_cell_of_the_table_is_a_formula() {
        let session = SessionRecord {
            id: "s".to_owned(),
            score: -5.0,
            began_unix_s: 1,
            task: "cut".to_owned(),
            difficulty: "exam".to_owned(),
            outcome: "passed".to_owned(),
            alarms: 0,
            metrics_version: 1,
            metrics: std::collections::BTreeMap::new(),
            scene: String::new(),
            program: String::new(),
            file: None,
            hand: Hand::Person,
            circumstances: store::Circumstances::default(),
        };
        let person = |label: &str, group: &str| Person {
            label: label.to_owned(),
            group: group.to_owned(),
            sessions: vec![session.clone()],
        };
        let people = vec![
            person("@Ada", "=1+1"),
            person("-Bo", "+a,b"),
            person("Cy", "c"),
        ];
        let sample = Sample {
            by: By::Cohort,
            tasks: vec![TaskSample {
                task: "cut".to_owned(),
                difficulty: "exam".to_owned(),
                version: 1,
                people,
            }],
            left_out: LeftOut::default(),
            has_scripted: false,
        };
        let table = csv(&sample);
        let starts: Vec<String> = { table.lines().skip(1) }
            .map(|row| row.trim_end_matches(',').to_owned())
            .collect();
        let wanted = [
            "cut,exam,1,'=1+1,'@Ada,1,-5",
            "cut,exam,1,\"'+a,b\",'-Bo,1,-5",
            "cut,exam,1,c,Cy,1,-5",
        ];
        assert_eq!(starts, wanted);
    }
}
