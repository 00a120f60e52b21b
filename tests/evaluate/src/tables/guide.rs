//! Makes two tables: the one in the guide for latency testers, and the one of walls by the time
//! that a sample waits for the tick.

use super::Table;
use crate::csv::{Csv, Row};

/// Measurements with and without an option of `calot jitter`, from `cargo xtask jitter guide`.
pub(super) fn options(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "figure",
        "without options",
        "`--why`",
        "÷ without",
        "`--follow-device`",
        "÷ without",
        "small scene, `--follow-device`",
    ]);
    for r in csv.rows() {
        let value = |column: &str| format!("{:.1}", r.number(column));
        let ratio = |column: &str| format!("{:.2}", r.number(column));
        table.row([
            r.text("figure").to_owned(),
            value("without"),
            value("why"),
            ratio("why_ratio"),
            value("follow"),
            ratio("follow_ratio"),
            value("small"),
        ]);
    }
    table
}

/// The stiffest stable wall by the time that a sample waits for the tick.
pub(super) fn waits(csv: &Csv) -> Table {
    let waits = csv.distinct("wait_ms");
    let mut columns = vec!["law".to_owned(), "device, delay".into(), "hand".into()];
    columns.extend(waits.iter().map(|ms| format!("{ms} ms: stable up to, N/m")));
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new(&columns);
    let setting = |r: &Row<'_>| {
        [
            r.text("law").to_owned(),
            format!("{}, {} ms", r.text("device"), r.text("delay_ms")),
            r.text("hand").to_owned(),
        ]
    };
    let mut told: Vec<[String; 3]> = Vec::new();
    for r in csv.rows() {
        let own = setting(&r);
        if told.contains(&own) {
            continue;
        }
        let mut cells = own.to_vec();
        for wait in &waits {
            let mut rows = csv.rows();
            let found = rows.find(|it| setting(it) == own && it.text("wait_ms") == wait);
            cells.push(found.map_or_else(String::new, |it| {
                format!("{:.0}", it.number("stable_up_to_n_m"))
            }));
        }
        told.push(own);
        table.row(cells);
    }
    table
}
