//! Makes the tables of changed tuned values.

use crate::csv::{Csv, Row};

use super::Table;

/// Change of a criterion that counts as an effect, as a share of the usual value.
const EFFECT: f64 = 0.1;
/// Usual values below this are compared as if they were this large.
const LEAST: f64 = 0.1;

/// True if the change makes the criterion differ at all. A run that failed differs.
fn differs(row: &Row<'_>) -> bool {
    row.text("before") != row.text("after")
}

/// Change of the criterion, as a share of the usual value; infinite for a run that failed.
fn effect(row: &Row<'_>) -> f64 {
    let [before, after] = ["before", "after"].map(|it| row.number(it));
    let share = (after - before).abs() / before.abs().max(LEAST);
    match share.is_nan() {
        true => f64::INFINITY,
        false => share,
    }
}

fn is_off(row: &Row<'_>) -> bool {
    row.text("change") == "off"
}

/// One row for each criterion: its usual value, and the tuned values on which it depends.
pub(super) fn by_criterion(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "criterion",
        "usual",
        "values that change it by 10 %: off",
        "30 % less or more",
        "most sensitive to 30 %",
    ]);
    for criterion in csv.distinct("criterion") {
        let rows = || csv.rows().filter(|row| row.text("criterion") == criterion);
        let Some(usual) = rows().next().filter(|it| !it.text("before").is_empty()) else {
            continue;
        };
        let small = || rows().filter(|row| !is_off(row) && effect(row) >= EFFECT);
        let off = rows().filter(|row| is_off(row) && effect(row) >= EFFECT);
        let most = small().max_by(|a, b| effect(a).total_cmp(&effect(b)));
        let most = most.map_or_else(String::new, |it| {
            format!(
                "{} {}: {}",
                it.text("parameter"),
                it.text("change"),
                it.text("after")
            )
        });
        table.row([
            criterion.clone(),
            usual.text("before").to_owned(),
            off.count().to_string(),
            distinct(small()).len().to_string(),
            most,
        ]);
    }
    table
}

/// Names of the tuned values in these rows.
fn distinct<'a>(rows: impl Iterator<Item = Row<'a>>) -> Vec<&'a str> {
    let mut names: Vec<&str> = rows.map(|row| row.text("parameter")).collect();
    names.dedup();
    names
}

/// One row for each room of the core: how much its tuned values matter, and those without effect.
pub(super) fn by_room(csv: &Csv) -> Table {
    let mut table = Table::new(&[
        "room",
        "values",
        "30 % change a criterion by 10 %",
        "only off does",
        "less effect",
        "not read",
        "no effect, even off",
    ]);
    let parameters = csv.distinct("parameter");
    let mut rooms: Vec<&str> = parameters.iter().map(|it| room(it)).collect();
    rooms.dedup();
    for name in rooms {
        let mut counts = [0; 4];
        let mut without = Vec::new();
        let mine: Vec<_> = parameters.iter().filter(|it| room(it) == name).collect();
        for parameter in &mine {
            let rows = || {
                csv.rows()
                    .filter(|row| row.text("parameter") == **parameter)
            };
            let has = |is: &dyn Fn(&Row<'_>) -> bool| rows().any(|row| is(&row));
            let at = if has(&|row| row.text("criterion") == "not read") {
                3
            } else if has(&|row| !is_off(row) && effect(row) >= EFFECT) {
                0
            } else if has(&|row| effect(row) >= EFFECT) {
                1
            } else if has(&differs) {
                2
            } else {
                without.push(parameter.trim_start_matches(name).trim_start_matches(':'));
                continue;
            };
            counts[at] += 1;
        }
        let mut cells = vec![name.to_owned(), mine.len().to_string()];
        cells.extend(counts.map(|it| it.to_string()));
        cells.push(without.join(", "));
        table.row(cells);
    }
    table
}

/// The room in which a tuned value stands.
fn room(parameter: &str) -> &str {
    parameter.split("::").next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_tell_values_that_matter_from_values_that_do_not() {
        let text = "parameter,value,change,criterion,before,after\n\
                    a::x::ONE,\"1\",off,\"force, N\",1.0,0.5\n\
                    a::x::ONE,\"1\",+30 %,\"force, N\",1.0,1.3\n\
                    a::x::TWO,\"1\",off,\"force, N\",1.0,NaN\n\
                    a::x::TWO,\"1\",+30 %,\"force, N\",1.0,1.01\n\
                    a::y::SIX,\"1\",off,\"force, N\",1.0,1.0\n\
                    b::TEN,\"1\",any,\"not read\",,\n";
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("ablation.csv");
        std::fs::write(&path, text).expect("written");
        let csv = Csv::read(&path).expect("read");
        let rooms = by_room(&csv).0;
        assert_eq!(rooms[1], ["a", "3", "1", "1", "0", "0", "y::SIX"]);
        assert_eq!(rooms[2], ["b", "1", "0", "0", "0", "1", ""]);
        let criteria = by_criterion(&csv).0;
        assert_eq!(
            criteria[1],
            ["force, N", "1.0", "2", "1", "a::x::ONE +30 %: 1.3"]
        );
        assert_eq!(criteria.len(), 2);
    }
}
