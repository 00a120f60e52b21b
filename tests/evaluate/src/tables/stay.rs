//! Makes the table of organs that stay where they belong.

use crate::csv::{Csv, Row};

use super::Table;

/// One row for each organ on which the hand worked, over all scenes, works and places.
pub(super) fn by_organ(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "organ at work",
        "cases",
        "tool caught",
        "stay",
        "still move",
        "speed, mm/s",
        "inside, mm",
        "loose, mm",
        "moved, mm",
    ]);
    for organ in csv.distinct("organ") {
        let all: Vec<Row<'_>> = csv
            .rows()
            .filter(|row| row.text("organ") == organ)
            .collect();
        let free: Vec<&Row<'_>> = all
            .iter()
            .filter(|row| row.text("touched") == "false")
            .collect();
        let stay = free.iter().filter(|row| row.text("stays") == "true");
        let moving = free.iter().filter(|row| row.number("speed_mm_s") > 0.1);
        let most = |column: &str| {
            let values = free.iter().map(|row| row.number(column));
            format!("{:.2}", values.fold(0.0, f64::max))
        };
        table.row([
            organ.clone(),
            all.len().to_string(),
            (all.len() - free.len()).to_string(),
            stay.count().to_string(),
            moving.count().to_string(),
            most("speed_mm_s"),
            most("inside_mm"),
            most("loose_mm"),
            most("moved_mm"),
        ]);
    }
    table
}
