//! Competitors beside Calot: each one's best point in each scene.

use super::Table;
use crate::accuracy::BESIDE;
use crate::csv::{Csv, Row};
use crate::methods::Way;

/// One row for each scene and competitor. A competitor's best point is the one at which it comes
/// nearest to Calot's time at the same error or a smaller one.
pub(super) fn best(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "scene",
        "competitor",
        "nodes",
        "µs",
        "rms mm",
        "Calot, spheres",
        "Calot, µs",
        "Calot, rms mm",
        "times Calot's µs",
    ]);
    for scene in csv.distinct("scene") {
        let ours: Vec<_> = csv
            .rows()
            .filter(|r| r.text("scene") == scene && r.text("method") == BESIDE)
            .collect();
        for method in csv.distinct("method") {
            if method == BESIDE || Way::is_named(&method) {
                continue;
            }
            let points = csv
                .rows()
                .filter(|r| r.text("scene") == scene && r.text("method") == method)
                .map(|r| (r, beside(&ours, r)))
                .min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
            if let Some(point) = points {
                table.row(cells(&scene, &method, &point));
            }
        }
    }
    table
}

type Point<'a> = (Row<'a>, Option<Row<'a>>);

/// Calot's fastest point with the same error or a smaller one.
fn beside<'a>(ours: &[Row<'a>], theirs: Row<'a>) -> Option<Row<'a>> {
    let as_good = |r: &&Row<'_>| r.number("rms_mm") <= theirs.number("rms_mm");
    ours.iter()
        .filter(as_good)
        .min_by(|a, b| a.number("us_per_tick").total_cmp(&b.number("us_per_tick")))
        .copied()
}

/// Time of the competitor over Calot's; 0 if no point of Calot is as accurate.
fn ratio((theirs, ours): &Point<'_>) -> f64 {
    if !theirs.number("rms_mm").is_finite() {
        return f64::INFINITY;
    }
    ours.map_or(0.0, |ours| {
        theirs.number("us_per_tick") / ours.number("us_per_tick")
    })
}

fn cells(scene: &str, method: &str, point: &Point<'_>) -> Vec<String> {
    let (theirs, ours) = point;
    let mut cells = vec![
        scene.to_owned(),
        method.to_owned(),
        theirs.text("spheres").to_owned(),
        format!("{:.1}", theirs.number("us_per_tick")),
    ];
    if !theirs.number("rms_mm").is_finite() {
        cells.push("blew up".to_owned());
        cells.resize(9, String::new());
        return cells;
    }
    cells.push(format!("{:.2}", theirs.number("rms_mm")));
    match ours {
        Some(ours) => cells.extend([
            ours.text("spheres").to_owned(),
            format!("{:.1}", ours.number("us_per_tick")),
            format!("{:.2}", ours.number("rms_mm")),
            format!("{:.2}", ratio(point)),
        ]),
        None => {
            cells.push("none as accurate".to_owned());
            cells.resize(9, String::new());
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A competitor that is faster at the same error has a ratio below 1. The table names a
    /// competitor that is more accurate than every point of Calot, and one that blew up.
    #[test]
    fn a_competitor_that_is_better_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("accuracy.csv");
        let text = "scene,method,spheres,us_per_tick,rms_mm\n\
s,Calot,581,1.0,0.1\n\
s,\"Calot, beside competitors\",100,10.0,2.0\ns,\"Calot, beside competitors\",581,40.0,0.5\n\
s,Fast 1,12,5.0,2.1\ns,Fast 1,48,90.0,1.0\n\
s,Exact 2,581,900.0,0.4\ns,Lost 3,581,5.0,inf\n";
        std::fs::write(&file, text).expect("a file");
        let made = best(&Csv::read(&file).expect("read")).markdown();
        let lines: Vec<&str> = made.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| s | Fast 1 | 12 | 5.0 | 2.10 | 100 | 10.0 | 2.00 | 0.50 |",
                "| s | Exact 2 | 581 | 900.0 | 0.40 | none as accurate |  |  |  |",
                "| s | Lost 3 | 581 | 5.0 | blew up |  |  |  |  |",
            ]
        );
    }
}
