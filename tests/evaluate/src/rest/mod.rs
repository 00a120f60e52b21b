//! Tissue at rest. Each sweep varies one value of a recipe over its allowed range. Every organ must
//! be still 5 s after it was loaded, pressed, released, pulled and let go.
//!
//! All parts are the product's own: preparation, simulation, devices and hand.

mod body;
mod cases;
mod trial;

use std::fmt::Write as _;
use std::path::Path;

use crate::csv::split;
use crate::page::{Section, table};
use cases::Case;
use trial::{After, Found};

/// Speed below which tissue is at rest, m/s.
const STILL_M_S: f32 = 1e-4;

/// A line of `rest.csv`.
pub(crate) struct Row {
    sweep: &'static str,
    value: String,
    found: Found,
}

impl Row {
    /// True if nothing moved, or preparation refused the recipe.
    fn rests(&self) -> bool {
        match &self.found {
            Found::Refused(_) => true,
            Found::Moved(speeds) => speeds.after_m_s.iter().all(|it| *it <= STILL_M_S),
        }
    }
}

/// Runs every case whose name contains `only`. Surfaces are written to `out`/bodies.
///
/// # Errors
/// When a surface cannot be written or a scene cannot be run, in words.
pub(crate) fn run(out: &Path, quick: bool, only: &str) -> Result<Vec<Row>, String> {
    let folder = out.join("bodies");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut cases = cases::all(quick);
    cases.retain(|case| case.name().contains(only));
    let count = cases.len();
    let laid = |(i, case): (usize, Case)| {
        let found = trial::run(&case.recipe(&folder)?)?;
        let row = Row {
            sweep: case.sweep,
            value: case.value.clone(),
            found,
        };
        eprintln!("[{}/{count}] {}: {}", i + 1, case.name(), words(&row));
        Ok(row)
    };
    cases.into_iter().enumerate().map(laid).collect()
}

/// Result of a row in words.
fn words(row: &Row) -> String {
    match &row.found {
        Found::Refused(why) => format!("refused: {}", first_line(why)),
        Found::Moved(speeds) => {
            let mm_s = speeds.after_m_s.map(|it| format!("{:.3}", it * 1e3));
            let verdict = if row.rests() { "rests" } else { "MOVES" };
            let told = if speeds.told { ", told" } else { "" };
            let held = if speeds.held { "" } else { ", nothing held" };
            let hand_m_s = speeds.hand_m_s.iter().copied().fold(0.0, f32::max);
            let mm_s = mm_s.join(" ");
            format!(
                "{verdict}, {mm_s} mm/s, hand {:.3}{told}{held}",
                hand_m_s * 1e3
            )
        }
    }
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

/// The rows as `rest.csv`.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = "sweep,value,spheres,rests".to_owned();
    for after in After::ALL {
        let _ = write!(text, ",{}_mm_s", after.name());
    }
    text += ",hand_mm_s,held,told,preparation\n";
    for row in rows {
        let _ = write!(text, "\"{}\",\"{}\",", row.sweep, row.value);
        match &row.found {
            Found::Refused(why) => {
                let why = first_line(why).replace('"', "'");
                let _ = writeln!(text, ",refused,,,,,,,,,\"{why}\"");
            }
            Found::Moved(it) => {
                let _ = write!(text, "{},{}", it.spheres, row.rests());
                for speed_m_s in it.after_m_s {
                    let _ = write!(text, ",{:.3}", speed_m_s * 1e3);
                }
                let hand_m_s = it.hand_m_s.iter().copied().fold(0.0, f32::max);
                let _ = write!(text, ",{:.3}", hand_m_s * 1e3);
                let said = it.warnings.join(" ").replace(['"', '\n'], "'");
                let _ = writeln!(text, ",{},{},\"{said}\"", it.held, it.told);
            }
        }
    }
    text
}

/// The rows as a section of the page.
pub(crate) fn section(rows: &[Row]) -> Section {
    let text = csv(rows);
    let cells: Vec<_> = text.lines().map(split).collect();
    let resting = rows.iter().filter(|row| row.rests()).count();
    Section {
        title: "Tissue at rest".to_owned(),
        body: format!(
            "<p>One value of a recipe is swept over all that a recipe allows. Each row has the \
             largest speed of any sphere in the last 0.4 s of five rests of 5 s: after loading, \
             under a tool that presses 5 mm deep, after its release, under jaws that pulled 15 mm, \
             and after they let go. The aim is 0.1 mm/s. In {resting} of {} rows tissue rests, or \
             preparation refuses the recipe and says why. <em>told</em>: the product itself said \
             that an organ shakes.</p>{}",
            rows.len(),
            table(&cells)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests a few common cases; `evaluate rest` runs all.
    #[test]
    fn bodies_of_common_tissue_rest() {
        let folder = tempfile::tempdir().expect("a folder");
        for only in [
            "rest modulus, Pa: 3000",
            "rest hold, 50 kPa: top",
            "rest form, 1500 Pa: rod",
            "rest hold, 1500 Pa: side",
            "rest spheres: 581",
        ] {
            let rows = run(folder.path(), false, only).expect("a row");
            assert!(!rows.is_empty(), "{only}");
            for row in &rows {
                assert!(matches!(row.found, Found::Moved(_)), "{}", words(row));
                assert!(row.rests(), "{only}: {}", words(row));
            }
        }
    }
}
