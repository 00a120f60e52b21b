//! Makes the tables of published measurements.

use super::Table;
use crate::csv::{Csv, Row};

/// Quantity of the silicones' rows.
const SILICONE: &str = "force between plates, N";
/// Range of strains in which the target applies, per cent.
const TARGET: [f64; 2] = [5.0, 40.0];

/// The silicones: errors by material, ends and spheres.
pub(super) fn silicones(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "silicone",
        "ends",
        "spheres",
        "largest error from 5 to 40 %, %",
        "at 40 %, %",
        "at 50 %, %",
        "at 60 %, %",
    ]);
    let all = || csv.rows().filter(|row| row.text("quantity") == SILICONE);
    let mut done: Vec<[&str; 3]> = Vec::new();
    for row in all() {
        let (of, _) = condition(&row);
        if done.contains(&of) {
            continue;
        }
        done.push(of);
        let errors = || all().map(|row| (condition(&row), row.number("error_pct")));
        let own = || errors().filter(|((it, _), _)| *it == of);
        let worst = own()
            .filter(|((_, pct), _)| (TARGET[0]..=TARGET[1]).contains(pct))
            .map(|(_, error)| error)
            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let at = |wanted: f64| {
            let mut own = own();
            let found = own.find(|((_, pct), _)| (pct - wanted).abs() < 0.1);
            found.map(|(_, error)| error)
        };
        let errors = [worst, at(40.0), at(50.0), at(60.0)];
        let cell = |error: Option<f64>| error.map_or_else(String::new, |it| format!("{it:+.1}"));
        table.row(of.map(str::to_owned).into_iter().chain(errors.map(cell)));
    }
    table
}

/// Silicone, ends and spheres, and the strain in per cent, from the text of a condition.
fn condition<'a>(row: &Row<'a>) -> ([&'a str; 3], f64) {
    let mut parts = row.text("condition").split(", ");
    let mut next = || parts.next().unwrap_or_default();
    let (name, strain) = (next(), next());
    let ends = next().trim_start_matches("ends ");
    let spheres = next().trim_end_matches(" spheres");
    let pct = strain.trim_end_matches(" % strain").parse();
    ([name, ends, spheres], pct.unwrap_or(f64::NAN))
}

/// All other rows. Of the beam, only those with 581 spheres.
pub(super) fn others(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "quantity",
        "condition",
        "published",
        "± SD",
        "Calot",
        "error, %",
        "within",
        "source",
    ]);
    let is_listed = |row: &Row<'_>| {
        let of_size = |count: &str| row.text("condition").contains(count);
        row.text("quantity") != SILICONE && !of_size(", 250 spheres") && !of_size(", 2500 spheres")
    };
    for row in csv.rows().filter(is_listed) {
        let short = |name: &str| match row.number(name) {
            it if it.is_nan() => String::new(),
            it => format!(
                "{:.digits$}",
                it,
                digits = if it.abs() < 1.0 { 3 } else { 2 }
            ),
        };
        let calot = match row.text("calot") {
            "" => "not modelled".to_owned(),
            _ => short("calot"),
        };
        table.row([
            row.text("quantity").to_owned(),
            row.text("condition").to_owned(),
            short("published"),
            short("published_sd"),
            calot,
            row.text("error_pct").to_owned(),
            if row.text("within") == "true" {
                "yes"
            } else {
                "no"
            }
            .to_owned(),
            row.text("source").to_owned(),
        ]);
    }
    table
}
