//! Tables `metrics`, `events` and `columns`.

use assess::{Assessed, Metric};
use session::Entry;
use session::EntryContent;
use shared_mem::message::Event;

use super::counted;
use super::table::{Cell, Column, Kind};

/// Columns of the table `events`.
pub(crate) fn events() -> Vec<Column> {
    vec![
        Column::new("tick", Kind::Whole, "number of the tick"),
        Column::new("time_s", Kind::Double, "time since the first tick, s"),
        Column::new("time_unix_ns", Kind::Whole, "time since 1970 UTC, ns"),
        Column::new("debrief_s", Kind::Double, counted::MEANING),
        Column::new("kind", Kind::Text, "kind of the event"),
        Column::new("organ", Kind::Text, "organ; empty: none"),
        Column::new(
            "x_m",
            Kind::Single,
            "place, to the patient's left, m; empty: none",
        ),
        Column::new("y_m", Kind::Single, "place, to the head, m; empty: none"),
        Column::new("z_m", Kind::Single, "place, to the front, m; empty: none"),
        Column::new(
            "value",
            Kind::Single,
            "by kind: force in N, energy in J, number of spheres, … (proto/calot.proto lists all)",
        ),
        Column::new(
            "fault",
            Kind::Text,
            "name of the fault, if the kind is fault",
        ),
    ]
}

/// Row of an entry, if it is an event. `counted` is the debrief's time, and `first_ns` the host
/// time of the first tick.
pub(crate) fn event(
    (entry, counted): (&Entry, Cell),
    organs: &[String],
    first_ns: u64,
    wall_from_host_ns: i64,
) -> Option<Vec<Cell>> {
    let EntryContent::Event(event) = entry.what else {
        return None;
    };
    let fault = match event.decode() {
        Ok(Event::Fault(fault)) => fault.name(),
        _ => "",
    };
    let organ = organs.get(event.organ as usize).map_or("", String::as_str);
    // An event without a place has zeros. No event occurs exactly at the origin.
    let has_place = event.at_m.iter().any(|it| it.to_bits() != 0);
    let place = |it: f32| Cell::finite(if has_place { it } else { f32::NAN });
    let [x, y, z] = event.at_m.map(place);
    Some(vec![
        Cell::Whole(event.tick),
        Cell::Double(seconds(first_ns, entry.at_ns)),
        Cell::Whole(entry.at_ns.saturating_add_signed(wall_from_host_ns)),
        counted,
        event.name().into(),
        organ.into(),
        x,
        y,
        z,
        Cell::Single(event.value),
        fault.into(),
    ])
}

/// Time from one host time to another, s; negative if the second is earlier.
pub(super) fn seconds(first_ns: u64, at_ns: u64) -> f64 {
    let passed = i128::from(at_ns) - i128::from(first_ns);
    passed as f64 / 1e9
}

/// Columns of the table `metrics`.
pub(crate) fn metrics() -> Vec<Column> {
    vec![
        Column::new("name", Kind::Text, "name of the metric"),
        Column::new("value", Kind::Double, "value; empty: the session has none"),
        Column::new("unit", Kind::Text, "unit; empty: a count or a share"),
        Column::new("definition", Kind::Text, "definition"),
        Column::new("source", Kind::Text, "publication that uses it"),
    ]
}

/// Rows of the table `metrics`: the score, then each metric.
pub(crate) fn metric_rows(assessed: &Assessed) -> Vec<Vec<Cell>> {
    let number = |value: f64| match value.is_finite() {
        true => Cell::Double(value),
        false => Cell::Absent,
    };
    let score = vec![
        "score".into(),
        number(assessed.score),
        Cell::Absent,
        "score of the session, 0 to 100".into(),
        Cell::Absent,
    ];
    let metrics = Metric::ALL.into_iter().map(|metric| {
        vec![
            metric.name().into(),
            number(assessed.metrics.get(metric)),
            metric.unit().into(),
            metric.definition().into(),
            metric.source().into(),
        ]
    });
    [score].into_iter().chain(metrics).collect()
}

/// Columns of the table `columns`.
pub(crate) fn columns() -> Vec<Column> {
    vec![
        Column::new("table", Kind::Text, "name of the table"),
        Column::new("column", Kind::Text, "name of the column"),
        Column::new("type", Kind::Text, "type of its values"),
        Column::new("meaning", Kind::Text, "meaning, with the unit"),
    ]
}

/// Rows of the table `columns` about the columns of one table.
pub(crate) fn column_rows(table: &str, columns: &[Column]) -> Vec<Vec<Cell>> {
    let row = |it: &Column| {
        vec![
            table.into(),
            it.name.as_str().into(),
            it.kind.name().into(),
            it.meaning.into(),
        ]
    };
    columns.iter().map(row).collect()
}
