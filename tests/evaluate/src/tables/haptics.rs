//! Tables of contact under a hand.

use super::{Table, largest, sorted};
use crate::csv::{Csv, Row};

/// Stable settings of each law.
pub(super) fn by_law(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "test",
        "law",
        "hand",
        "settings",
        "all stable at 20 kN/m",
        "weakest limit, N/m",
        "largest step, mN a tick",
    ]);
    for test in ["wall", "tissue"] {
        for law in csv.distinct("law") {
            for hand in ["none", "relaxed", "firm"] {
                let rows: Vec<_> = csv
                    .rows()
                    .filter(|r| r.text("test") == test)
                    .filter(|r| r.text("law") == law && r.text("hand") == hand)
                    .collect();
                if rows.is_empty() {
                    continue;
                }
                let steps = sorted(rows.iter().map(|r| r.number("step_mn")));
                let wall = test == "wall";
                let limits = sorted(rows.iter().map(|r| r.number("of")));
                let still = |r: &&Row<'_>| {
                    if wall {
                        r.number("of") >= 20_000.0
                    } else {
                        r.text("stable") == "1"
                    }
                };
                table.row([
                    test.to_owned(),
                    law.clone(),
                    hand.to_owned(),
                    rows.len().to_string(),
                    rows.iter().filter(still).count().to_string(),
                    if wall {
                        format!("{:.0}", limits.first().copied().unwrap_or(0.0))
                    } else {
                        String::new()
                    },
                    format!("{:.1}", largest(&steps)),
                ]);
            }
        }
    }
    table
}

/// Measures of OmniSurg's haptic bench: the median of each law and hand.
pub(super) fn felt(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "law",
        "hand",
        "settings",
        "20–300 Hz: peak, mN",
        "largest, mN",
        "rms, mN",
        "injected, mJ",
        "rise, ms",
        "drag in air, mN",
        "jerk, m/s³",
        "depth, mm",
    ]);
    let columns = [
        ("osc_peak_mn", 1),
        ("osc_rms_mn", 2),
        ("injected_mj", 2),
        ("rise_ms", 0),
        ("drag_mn", 2),
        ("jerk_m_s3", 0),
        ("deepest_mm", 2),
    ];
    for hand in ["relaxed", "firm"] {
        for law in csv.distinct("law") {
            let own = || {
                let strokes = csv.rows().filter(|r| r.text("test") == "felt");
                strokes.filter(|r| r.text("law") == law && r.text("hand") == hand)
            };
            if own().count() == 0 {
                continue;
            }
            let median = |(column, digits): (&str, usize)| {
                let all: Vec<f64> = own().map(|r| r.number(column)).collect();
                format!("{:.digits$}", statistics::median(&all))
            };
            let first = [law.clone(), hand.to_owned(), own().count().to_string()];
            let worst = largest(&sorted(own().map(|r| r.number("osc_peak_mn"))));
            let mut cells = Vec::from(columns.map(median));
            cells.insert(1, format!("{worst:.1}"));
            table.row(first.into_iter().chain(cells));
        }
    }
    table
}
