//! Makes the table of faults of the drawn skin.

use crate::csv::Csv;

use super::Table;

/// One row for each scene and hand: the worst of all organs.
pub(super) fn by_hand(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "scene",
        "hand",
        "frames",
        "edges stretched",
        "triangles folded",
        "in the tool, mm",
        "off the tool, mm",
        "ends loose, mm",
    ]);
    for scene in csv.distinct("scene") {
        for hand in csv.distinct("hand") {
            let rows = csv
                .rows()
                .filter(|row| row.text("scene") == scene && row.text("hand") == hand);
            let rows: Vec<_> = rows.collect();
            let most = |column: &str| {
                let values = rows.iter().map(|row| row.number(column));
                values.fold(0.0, f64::max)
            };
            if rows.is_empty() {
                continue;
            }
            table.row([
                scene.clone(),
                hand.clone(),
                format!("{:.0}", most("frames")),
                format!("{:.0}", most("edges_stretched")),
                format!("{:.0}", most("triangles_folded")),
                format!("{:.1}", most("in_tool_max_mm")),
                format!("{:.1}", most("off_tool_max_mm")),
                format!("{:.1}", most("ends_loose_mm")),
            ]);
        }
    }
    table
}
