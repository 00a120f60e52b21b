//! Measures hands of surgeons and novices with the functions that score sessions.
//!
//! ```text
//! DIR/TASK/PERSON/TRIAL.csv → Trial → at a rate, with noise → assess::Assessment → metrics
//!                                                     persons' medians → experts beside novices
//! ```
//!
//! [`assess::Assessment`] assesses a trial as it assesses a session, so no metric is implemented
//! twice. It does so two times: once with the first instrument as the tip and the second as the
//! lens, once with the hands exchanged.

mod course;
mod page;
mod trial;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use statistics::{Compared, compare, median};

use self::course::{Condition, Measure};
use self::trial::{Group, Trial};
use crate::page::Section;

/// Options of `evaluate hands`.
#[derive(Args)]
pub(crate) struct HandsArgs {
    /// Folder with TASK/PERSON/TRIAL.csv. Persons are E… (experts) or N… (novices). Columns,
    /// counted from 0: 0–2 position of the first instrument, 4–6 of the second, 8–10 and 12–14
    /// their angles, 16 time in s.
    dir: PathBuf,
    /// Folder for hands.csv and hands.html.
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Leaves out a trial that cannot be used, such as Lung/N4/05. The page names it. May be
    /// repeated.
    #[arg(long, value_name = "TASK/PERSON/TRIAL")]
    leave_out: Vec<String>,
    /// Length of the files' unit, mm.
    #[arg(long, value_name = "MM", default_value_t = 10.0, value_parser = unit)]
    unit_mm: f64,
}

fn unit(text: &str) -> Result<f64, String> {
    let told = |what: String| format!("{what}; allowed is 0.1 to 1000 mm, such as 10");
    let value: f64 = text.parse().map_err(|_| told("not a number".to_owned()))?;
    match (0.1..=1000.0).contains(&value) {
        true => Ok(value),
        false => Err(told(format!("it is {value}"))),
    }
}

/// Units of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    /// The median of each person's trials.
    Persons,
    /// Each trial, as if the trials of a person were independent.
    Trials,
}

/// A row of the CSV file.
#[derive(Debug, Clone)]
struct Row {
    task: String,
    measure: Measure,
    condition: Condition,
    of: Of,
    found: Compared,
}

/// All results.
pub(crate) struct Measured {
    rows: Vec<Row>,
    /// The trials, and each one's values by condition and measure.
    trials: Vec<(Trial, Vec<Vec<f64>>)>,
    left_out: Vec<String>,
    unit_mm: f64,
}

/// Reads the trials and measures them under each condition.
///
/// # Errors
/// The first fault of a file, with its line and the remedy.
pub(crate) fn run(asked: &HandsArgs) -> Result<Measured, String> {
    let trials = trial::read_all(&asked.dir, &asked.leave_out, asked.unit_mm * 1e-3)?;
    let values = measure_all(&trials);
    let trials: Vec<_> = trials.into_iter().zip(values).collect();
    Ok(Measured {
        rows: rows(&trials),
        trials,
        left_out: asked.leave_out.clone(),
        unit_mm: asked.unit_mm,
    })
}

/// Values of each trial by condition and measure. Each thread takes the next open trial.
fn measure_all(trials: &[Trial]) -> Vec<Vec<Vec<f64>>> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let work = || {
        let mut found = Vec::new();
        while let Some((index, trial)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            trials.get(index).map(|trial| (index, trial))
        } {
            let all = Condition::ALL;
            found.push((index, all.map(|it| course::measure(trial, it)).to_vec()));
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            eprint!("\r{done} of {} trials", trials.len());
        }
        found
    };
    let mut found: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let joined = workers.into_iter().filter_map(|it| it.join().ok());
        joined.flatten().collect()
    });
    eprintln!();
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, values)| values).collect()
}

fn rows(trials: &[(Trial, Vec<Vec<f64>>)]) -> Vec<Row> {
    let mut rows = Vec::new();
    for task in tasks(trials) {
        for (m, measure) in Measure::ALL.into_iter().enumerate() {
            for (c, condition) in Condition::ALL.into_iter().enumerate() {
                for of in [Of::Persons, Of::Trials] {
                    let value = |values: &[Vec<f64>]| values[c][m];
                    rows.push(Row {
                        task: task.clone(),
                        measure,
                        condition,
                        of,
                        found: compare(&groups(trials, &task, of, value)),
                    });
                }
            }
        }
    }
    rows
}

fn tasks(trials: &[(Trial, Vec<Vec<f64>>)]) -> Vec<String> {
    let mut tasks: Vec<String> = trials.iter().map(|(it, _)| it.task.clone()).collect();
    tasks.dedup();
    tasks
}

/// Values of experts and novices in a task.
fn groups(
    trials: &[(Trial, Vec<Vec<f64>>)],
    task: &str,
    of: Of,
    value: impl Fn(&[Vec<f64>]) -> f64,
) -> [Vec<f64>; 2] {
    [Group::Expert, Group::Novice].map(|group| {
        let mut units: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        let own = trials
            .iter()
            .filter(|(it, _)| it.task == task && it.group == group);
        for (trial, values) in own {
            let unit = match of {
                Of::Persons => &trial.person,
                Of::Trials => &trial.name,
            };
            units.entry(unit).or_default().push(value(values));
        }
        units.values().map(|it| median(it)).collect()
    })
}

/// The CSV file.
pub(crate) fn csv(measured: &Measured) -> String {
    let mut text = "task,metric,sample_rate_hz,noise_mm,of,experts_n,experts_median,novices_n,\
                    novices_median,cliffs_delta,p_two_sided\n"
        .to_owned();
    for row in &measured.rows {
        let of = match row.of {
            Of::Persons => "persons",
            Of::Trials => "trials",
        };
        let Compared { n, medians, .. } = row.found;
        text += &format!(
            "{},{},{},{},{of},{},{:.4},{},{:.4},{:.3},{:.5}\n",
            row.task,
            row.measure.name(),
            row.condition.rate_hz(),
            row.condition.noise_mm,
            n[0],
            medians[0],
            n[1],
            medians[1],
            row.found.delta,
            row.found.p
        );
    }
    text
}

/// The sections of the page.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn sections(measured: &Measured) -> Result<Vec<Section>, String> {
    page::sections(measured)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_a_length_in_range() {
        assert!((unit("10").unwrap() - 10.0).abs() < 1e-12);
        assert!(unit("x").unwrap_err().contains("not a number; allowed"));
        assert!(unit("0").unwrap_err().contains("it is 0; allowed"));
        assert!(unit("nan").is_err());
    }

    #[test]
    fn trials_of_a_person_count_once_and_their_comparison_is_told_apart() {
        let trial = |person: &str, number: u32| Trial {
            name: format!("Peg/{person}/{number}"),
            task: "Peg".to_owned(),
            person: person.to_owned(),
            group: Group::of(person).unwrap(),
            times_s: Vec::new(),
            hands: [Vec::new(), Vec::new()],
        };
        let value = |value: f64| vec![vec![value; Measure::ALL.len()]; Condition::ALL.len()];
        let trials = [
            (trial("E1", 1), value(1.0)),
            (trial("E1", 2), value(2.0)),
            (trial("E1", 3), value(9.0)),
            (trial("N1", 1), value(5.0)),
            (trial("N2", 1), value(f64::NAN)),
        ];
        let rows = rows(&trials);
        let of = |of: Of| rows.iter().find(|row| row.of == of).unwrap().found;
        assert_eq!((of(Of::Persons).n, of(Of::Trials).n), ([1, 1], [3, 1]));
        assert!((of(Of::Persons).medians[0] - 2.0).abs() < 1e-12);
        let measured = Measured {
            rows,
            trials: Vec::new(),
            left_out: Vec::new(),
            unit_mm: 10.0,
        };
        let text = csv(&measured);
        let columns = |line: &str| line.split(',').count();
        assert!(text.lines().all(|line| columns(line) == 11));
        assert!(text.contains("Peg,path_m,1000,0.3,persons,1,2.0000,1,5.0000,-1.000,1.00000"));
    }
}
