//! `calot store study`: groups of trainees compared, their learning, the agreement of raters.
//!
//! ```text
//! sample   which sessions of whom count, and how many do not
//! figures  persons' medians, groups compared, learning, agreement
//! page     study.html
//! ```

mod args;
mod figures;
mod page;
mod sample;

use assess::Metric;
use store::Store;

pub(crate) use self::args::StudyArgs;
use self::sample::Sample;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::say;

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

/// A row for each person and task: medians of the person's sessions.
fn csv(sample: &Sample) -> String {
    let metrics = Metric::ALL.map(Metric::name).join(",");
    let mut text = format!("{COLUMNS},{metrics}\n");
    for task in &sample.tasks {
        for person in &task.people {
            let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
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
                quoted(&person.group),
                quoted(&person.label),
                person.sessions.len().to_string(),
            ];
            text += &row.into_iter().chain(values).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
    }
    text
}
