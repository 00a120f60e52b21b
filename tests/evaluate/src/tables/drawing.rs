//! Tables of a graphics card's drawing times, from `cargo xtask gpu`.

use super::Table;
use crate::csv::{Csv, Row};

/// Number of the most expensive views that the table lists.
const DEAREST: usize = 6;

/// Drawing times by quality and size.
pub(super) fn by_tier(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "quality",
        "size",
        "drawn, ms",
        "99 %, ms",
        "frames a second",
        "skinning, ms",
        "shadow, ms",
        "scene, ms",
        "glare, ms",
        "lens, ms",
        "read back, ms",
    ]);
    for r in csv.rows().filter(|r| r.text("what").starts_with("tier ")) {
        table.row([
            r.text("what").replace("tier ", ""),
            format!("{}×{}", r.text("width"), r.text("height")),
            format!("{:.1}", r.number("drawn_ms")),
            format!("{:.1}", r.number("drawn_p99_ms")),
            format!("{:.0}", r.number("per_second")),
            format!("{:.3}", r.number("skinning_ms")),
            format!("{:.2}", r.number("shadow_ms")),
            format!("{:.2}", r.number("scene_ms")),
            format!("{:.2}", r.number("glare_ms")),
            format!("{:.2}", r.number("lens_ms")),
            format!("{:.1}", r.number("read_back_ms")),
        ]);
    }
    table
}

/// The gallery's most expensive views, the median and the cheapest view.
pub(super) fn by_view(csv: &Csv) -> Table {
    let mut table = Table::new(&["view", "drawn, ms", "frames a second"]);
    let views = csv.rows().filter(|r| !r.text("what").starts_with("tier "));
    let mut views: Vec<Row<'_>> = views.collect();
    views.sort_by(|a, b| b.number("drawn_ms").total_cmp(&a.number("drawn_ms")));
    let mut row = |name: String, r: &Row<'_>| {
        table.row([
            name,
            format!("{:.1}", r.number("drawn_ms")),
            format!("{:.0}", r.number("per_second")),
        ]);
    };
    for r in views.iter().take(DEAREST) {
        row(r.text("what").to_owned(), r);
    }
    if let (Some(middle), Some(last)) = (views.get(views.len() / 2), views.last()) {
        row(format!("median of {} views", views.len()), middle);
        row(format!("cheapest: {}", last.text("what")), last);
    }
    table
}
