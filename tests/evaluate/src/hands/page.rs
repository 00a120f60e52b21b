//! The charts and sections of hands.html, for readers who know neither the program nor the test.

use figures::html::escape;
use figures::panels::{self, Cell, Panel, Scale, Series};
use statistics::{Compared, median};

use super::course::{Condition, Measure};
use super::trial::Group;
use super::{Measured, Of, Row, groups, tasks};
use crate::page::{Section, number, strings, table};

/// Probability below which a measure counts as separating the groups.
const SIGNIFICANT: f64 = 0.05;
/// A measure depends on rate or noise if, under a condition, the median [`change`] exceeds this.
const STEADY: f64 = 0.05;

/// The page's sections.
///
/// # Errors
/// The drawing library's message.
pub(super) fn sections(measured: &Measured) -> Result<Vec<Section>, String> {
    Ok(vec![
        verdict(measured),
        persons(measured)?,
        conditions(measured)?,
        rates(measured)?,
        about(measured),
    ])
}

fn at_session<'a>(measured: &'a Measured, task: &str, measure: Measure, of: Of) -> Option<&'a Row> {
    let session = Condition::ALL.get(Condition::SESSION);
    let mut rows = measured.rows.iter();
    rows.find(|row| {
        row.task == task
            && row.measure == measure
            && row.of == of
            && Some(&row.condition) == session
    })
}

fn verdict(measured: &Measured) -> Section {
    let tasks = tasks(&measured.trials);
    let mut rows = vec![strings(["measure", "meaning"])];
    for task in &tasks {
        for column in ["experts", "novices", "Cliff’s δ", "p", "p by trials"] {
            rows[0].push(format!("{task}: {column}"));
        }
    }
    let mut found = String::new();
    for measure in Measure::ALL {
        let mut row = strings([measure.name(), measure.meaning()]);
        let mut apart = Vec::new();
        for task in &tasks {
            let find = |of| at_session(measured, task, measure, of).map(|row| row.found);
            let Some((by, trials)) = find(Of::Persons).zip(find(Of::Trials)) else {
                continue;
            };
            let Compared { medians, .. } = by;
            row.extend(medians.map(|it| number(it, 2)));
            row.push(format!("{:+.2}", by.delta));
            row.extend([by.p, trials.p].map(chance));
            if by.p < SIGNIFICANT {
                apart.push(task.as_str());
            }
        }
        let apart = match apart.is_empty() {
            true => "no task".to_owned(),
            false => apart.join(" and "),
        };
        found += &format!("<li><b>{}</b>: in {}", measure.name(), escape(&apart));
        rows.push(row);
    }
    Section {
        title: "What tells experts from novices".to_owned(),
        body: format!(
            "<p>Real surgeons and novices worked at a trainer with two hands. Calot measured their hands with the \
functions that score its own sessions. A person counts once, by the median of the person’s trials, because trials of \
one person are not independent. Here the course is sampled at 100 Hz as in a session, and no noise is added.</p>\
<p>Told apart (p &lt; {SIGNIFICANT} by persons):</p><ul>{found}</ul><p>With so few persons, a difference that is \
not found may still exist, and of {} comparisons some are below {SIGNIFICANT} by chance. Cliff’s δ is the share of \
pairs in which the expert has more, minus the share in which the novice has: +1 and −1 are groups that do not \
overlap. p is the exact two-sided test of Mann and Whitney. The last column takes each trial as independent. It is \
shown to compare with others, and too small.</p>{}",
            Measure::ALL.len() * tasks.len(),
            table(&rows)
        ),
    }
}

/// A probability, as text.
fn chance(p: f64) -> String {
    match p < 0.001 {
        true => "<0.001".to_owned(),
        false => number(p, 3),
    }
}

/// One panel for each task and measure, with a dot for each person.
fn persons(measured: &Measured) -> Result<Section, String> {
    let mut all = Vec::new();
    for task in tasks(&measured.trials) {
        for (m, measure) in Measure::ALL.into_iter().enumerate() {
            let value = |values: &[Vec<f64>]| values[Condition::SESSION][m];
            let [experts, novices] = groups(&measured.trials, &task, Of::Persons, value);
            let mut series = Vec::new();
            let first = experts.len() + 2;
            for (name, values, first) in [("novices", &novices, first), ("experts", &experts, 1)] {
                let last = first + values.len().saturating_sub(1);
                let middle = median(values);
                series.push(Series {
                    name: format!("median of the {name}"),
                    points: [first, last].map(|x| [x as f64, middle]).to_vec(),
                    is_thin: true,
                });
            }
            for (name, values, first) in [("novices", &novices, first), ("experts", &experts, 1)] {
                let dots = values.iter().enumerate().map(|(index, value)| Series {
                    name: name.to_owned(),
                    points: vec![[(first + index) as f64, *value]],
                    is_thin: false,
                });
                series.extend(dots);
            }
            all.push(Panel {
                title: format!("{task}: {}", measure.name()),
                axes: [
                    "experts, then novices".to_owned(),
                    measure.meaning().to_owned(),
                ],
                scales: [Scale::Linear; 2],
                series,
            });
        }
    }
    Ok(Section {
        title: "Each person".to_owned(),
        body: format!(
            "<p>A dot is the median of a person’s trials. The experts are on the left.</p>{}",
            panels::panels(&all, 3)?
        ),
    })
}

/// Cliff's delta and p under each condition.
fn conditions(measured: &Measured) -> Result<Section, String> {
    let columns: Vec<String> = Condition::ALL
        .iter()
        .map(|it| format!("{} Hz, {} mm noise", it.rate_hz(), it.noise_mm))
        .collect();
    let (mut names, mut cells) = (Vec::new(), Vec::new());
    for task in tasks(&measured.trials) {
        for measure in Measure::ALL {
            let rows = measured
                .rows
                .iter()
                .filter(|row| row.task == task && row.measure == measure && row.of == Of::Persons);
            names.push(format!("{task}: {}", measure.name()));
            let cell = |row: &Row| Cell {
                text: format!("{:+.2}, p {:.3}", row.found.delta, row.found.p),
                good: Some(row.found.delta.abs()),
            };
            cells.push(rows.map(cell).collect());
        }
    }
    Ok(Section {
        title: "Rates and noise: is it still found?".to_owned(),
        body: format!(
            "<p>Cliff’s δ and p by persons. Blue: the groups hardly overlap. 10 Hz are the rows as they were recorded; \
other rates are curves through them. A measure that may be believed has one colour along its row.</p>{}",
            panels::heat_map(&columns, &names, &cells)?
        ),
    })
}

/// Median over the trials of a value's relative change from its value at 100 Hz without noise.
fn change(measured: &Measured, condition: usize, measure: usize) -> f64 {
    let ratios = measured.trials.iter().map(|(_, values)| {
        let reference = values[Condition::SESSION][measure];
        ((values[condition][measure] - reference) / reference).abs()
    });
    median(&ratios.collect::<Vec<f64>>())
}

fn rates(measured: &Measured) -> Result<Section, String> {
    let mut all = Vec::new();
    let mut unsteady = String::new();
    for (m, measure) in Measure::ALL.into_iter().enumerate() {
        let mut series: Vec<Series> = Vec::new();
        let mut worst: f64 = 0.0;
        for (c, condition) in Condition::ALL.iter().enumerate() {
            let off = change(measured, c, m);
            worst = worst.max(off);
            let name = format!("noise of {} mm", condition.noise_mm);
            let point = [condition.rate_hz(), 100.0 * off];
            match series.iter_mut().find(|it| it.name == name) {
                Some(series) => series.points.push(point),
                None => series.push(Series {
                    name,
                    points: vec![point],
                    is_thin: false,
                }),
            }
        }
        if worst > STEADY {
            unsteady += &format!(
                "<li><b>{}</b>: up to {:.0} %",
                measure.name(),
                100.0 * worst
            );
        }
        all.push(Panel {
            title: measure.name().to_owned(),
            axes: [
                "samples a second".to_owned(),
                "change of a trial, %".to_owned(),
            ],
            scales: [Scale::Log, Scale::Linear],
            series,
        });
    }
    let unsteady = match unsteady.is_empty() {
        true => "<p>No measure changes by more than 5 %.</p>".to_owned(),
        false => format!("<p>These change by more than 5 % somewhere:</p><ul>{unsteady}</ul>"),
    };
    Ok(Section {
        title: "Rates and noise: is it the same number?".to_owned(),
        body: format!(
            "<p>How far a trial’s value is from its value at 100 Hz without noise, as the median of all trials, \
regardless of sign.</p>{unsteady}{}",
            panels::panels(&all, 3)?
        ),
    })
}

fn about(measured: &Measured) -> Section {
    let count = |group: Group| {
        let own = measured.trials.iter().filter(|(it, _)| it.group == group);
        let mut persons: Vec<&str> = own.map(|(it, _)| it.person.as_str()).collect();
        persons.sort_unstable();
        persons.dedup();
        persons.len()
    };
    let left_out = match measured.left_out.is_empty() {
        true => "none".to_owned(),
        false => escape(&measured.left_out.join(", ")),
    };
    Section {
        title: "Data and method".to_owned(),
        body: format!(
            "<p>{} trials of {} experts and {} novices. Left out: {left_out}.</p><p>One unit of the files’ lengths is \
taken as {} mm, because the files tell none. With it, the most frequent step of a hand that hardly moves is {:.3} mm; the \
Touch devices of the data set High-Fidelity-MRSS resolve 0.055 mm (3D Systems). Lengths, the thresholds of movements \
(20 and 5 mm/s) and the added noise depend on the unit.</p><p>Curves between the rows are cubic. Noise is normal, \
independent in each sample and axis; its standard deviation is given. The recorded rows have about 10 Hz, so what a hand \
does faster than 5 Hz is in none of these figures.</p>",
            measured.trials.len(),
            count(Group::Expert),
            count(Group::Novice),
            measured.unit_mm,
            frequent_step_mm(measured),
        ),
    }
}

/// The most frequent step length between two rows, among steps up to 0.03 units, mm. It is
/// presumably one count of a device's encoders.
fn frequent_step_mm(measured: &Measured) -> f64 {
    let bin_mm = 0.0005 * measured.unit_mm;
    let mut counts = [0u32; 60];
    for hand in measured.trials.iter().flat_map(|(it, _)| &it.hands) {
        for (from, to) in hand.iter().zip(hand.iter().skip(1)) {
            let square: f64 = from.iter().zip(to).map(|(a, b)| (a - b) * (a - b)).sum();
            let bin = (1e3 * square.sqrt() / bin_mm) as usize;
            // The first bin is rest.
            if let Some(count) = counts.get_mut(bin).filter(|_| bin > 0) {
                *count += 1;
            }
        }
    }
    let most = counts.iter().enumerate().max_by_key(|(_, count)| **count);
    most.map_or(f64::NAN, |(bin, _)| (bin as f64 + 0.5) * bin_mm)
}

#[cfg(test)]
mod tests {
    use super::super::trial::Trial;
    use super::*;

    #[test]
    fn a_page_tells_what_separates_and_what_depends_on_the_rate() {
        let mut trials = Vec::new();
        for (person, group, path) in (0..3)
            .map(|it| (format!("E{it}"), Group::Expert, 1.0 + f64::from(it)))
            .chain((0..8).map(|it| (format!("N{it}"), Group::Novice, 10.0 + f64::from(it))))
        {
            let values = Condition::ALL.map(|condition| {
                let mut values = vec![1.0; Measure::ALL.len()];
                values[1] = path;
                values[5] = condition.rate_hz();
                values
            });
            let trial = Trial {
                name: format!("A & B/{person}/1"),
                task: "A & B".to_owned(),
                person,
                group,
                times_s: Vec::new(),
                hands: [vec![[0.0; 3], [0.0; 3], [52e-6, 0.0, 0.0]], Vec::new()],
            };
            trials.push((trial, values.to_vec()));
        }
        let measured = Measured {
            rows: super::super::rows(&trials),
            trials,
            left_out: vec!["<x>".to_owned()],
            unit_mm: 10.0,
        };
        let html: Vec<String> = sections(&measured)
            .unwrap()
            .into_iter()
            .map(|it| it.body)
            .collect();
        assert!(
            html[0].contains("<b>path_m</b>: in A &amp; B"),
            "{}",
            html[0]
        );
        assert!(
            html[0].contains("<b>movements</b>: in no task"),
            "{}",
            html[0]
        );
        assert!(html[0].contains("0.012"));
        assert!(
            html[3].contains("<b>idle_s</b>: up to 900 %"),
            "{}",
            html[3]
        );
        assert!(!html[3].contains("<b>path_m</b>"));
        assert!(html[4].contains("3 experts and 8 novices. Left out: &lt;x&gt;"));
        assert_eq!(
            (chance(0.0004), chance(0.048)),
            ("<0.001".into(), "0.048".into())
        );
        assert!((frequent_step_mm(&measured) - 0.052).abs() < 0.003);
    }
}
