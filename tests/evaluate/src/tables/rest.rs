//! Makes the table of tissue that should rest.

use crate::csv::{Csv, Row};

use super::Table;

/// States of `rest.csv`, in the order of a trial.
const STATES: [&str; 5] = ["load", "press", "release", "pull", "drop"];

/// One row for each sweep: how many cases rest, how many are refused, which cases move, and the
/// largest speeds.
pub(super) fn by_sweep(csv: &Csv) -> Table {
    let mut columns = vec!["swept value", "cases", "rest", "refused", "that move"];
    let speeds = STATES.map(|state| format!("{state}, mm/s"));
    columns.extend(speeds.iter().map(String::as_str));
    let mut table = Table::new(&columns);
    for sweep in csv.distinct("sweep") {
        let rows: Vec<Row<'_>> = csv
            .rows()
            .filter(|row| row.text("sweep") == sweep)
            .collect();
        let count = |verdict: &str| {
            let rows = rows.iter().filter(|row| row.text("rests") == verdict);
            rows.count().to_string()
        };
        let moves = rows.iter().filter(|row| row.text("rests") == "false");
        let moves: Vec<String> = moves.map(|row| row.text("value").to_owned()).collect();
        let most = |state: &str| {
            let column = format!("{state}_mm_s");
            let speeds = rows.iter().filter(|row| row.text("rests") != "refused");
            let most = speeds.map(|row| row.number(&column)).fold(0.0, f64::max);
            format!("{most:.3}")
        };
        let told = [
            sweep.clone(),
            rows.len().to_string(),
            count("true"),
            count("refused"),
            moves.join(", "),
        ];
        table.row(told.into_iter().chain(STATES.map(most)));
    }
    table
}
