//! Rows of an earlier `accuracy.csv`, for what a run does not measure.

use std::path::Path;

use super::Row;
use crate::csv::Csv;
use crate::methods::Way;

/// Merges `rows` into this `accuracy.csv`: they replace its rows of the same scenes. The methods of
/// this program and the competitors run in sessions of their own, so each of the two groups
/// replaces only itself. Rows that were not measured again stay.
///
/// # Errors
/// The reason in words.
pub(crate) fn with_kept(rows: &[Row], file: &Path) -> Result<Vec<Row>, String> {
    let kept: Vec<Row> = Csv::read(file)?
        .rows()
        .map(|r| Row {
            scene: r.text("scene").to_owned(),
            method: r.text("method").to_owned(),
            setting: r.text("setting").to_owned(),
            spheres: r.number("spheres") as usize,
            us_per_tick: r.number("us_per_tick"),
            rms_mm: r.number("rms_mm"),
            max_mm: r.number("max_mm"),
            force_error_pct: r.number("force_error_pct"),
            volume_error_pct: r.number("volume_error_pct"),
        })
        .collect();
    let mut scenes: Vec<&str> = Vec::new();
    for row in kept.iter().chain(rows) {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let mut all = Vec::new();
    for scene in scenes {
        for is_own in [true, false] {
            let group = |row: &&Row| row.scene == scene && Way::is_named(&row.method) == is_own;
            let is_new = rows.iter().any(|row| group(&row));
            let from = if is_new { rows } else { &kept };
            all.extend(from.iter().filter(group).cloned());
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
scene,method,spheres,us_per_tick,rms_mm,max_mm,force_error_pct,volume_error_pct,setting
\"liver: sag\",\"Calot\",581,30.1,0.763,2.5,-1.25,0.125,\"\"
\"liver: sag\",\"mass-spring, explicit Euler (paper's)\",581,29.8,inf,inf,inf,inf,\"\"
\"liver: sag\",\"MuJoCo 3.9.0 flex\",581,999.0,0.900,1.500,,0.000,\"\"
\"liver: pull 30 mm\",\"Calot\",581,31.5,0.640,2.0,0.50,0.250,\"k = 0.5, 1 iterations\"
";

    fn row(method: &str, us_per_tick: f64, force_error_pct: f64) -> Row {
        Row {
            scene: "liver: sag".to_owned(),
            method: method.to_owned(),
            setting: "E × 0.965".to_owned(),
            spheres: 581,
            us_per_tick,
            rms_mm: 0.52,
            max_mm: 1.5,
            force_error_pct,
            volume_error_pct: 0.0,
        }
    }

    /// A new version of a competitor replaces the old one. The rows of this program's methods and
    /// of the other scene stay as they are in the file, to the letter.
    #[test]
    fn competitors_are_replaced_and_other_rows_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("accuracy.csv");
        std::fs::write(&file, FILE).expect("a file");
        let beside = row(super::super::BESIDE, 25.0, 1.0);
        let peer = row("MuJoCo 4.0.0 flex, cells", 1481.0, f64::NAN);
        let all = with_kept(&[beside, peer], &file).expect("merged");
        let text = crate::accuracy::csv(&all);
        let lines: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(
            lines,
            [
                "\"liver: sag\",\"Calot\",581,30.1,0.763,2.500,-1.25,0.125,\"\"",
                "\"liver: sag\",\"mass-spring, explicit Euler (paper's)\",581,29.8,inf,inf,inf,inf,\"\"",
                "\"liver: sag\",\"Calot, beside competitors\",581,25.0,0.520,1.500,1.00,0.000,\"E × 0.965\"",
                "\"liver: sag\",\"MuJoCo 4.0.0 flex, cells\",581,1481.0,0.520,1.500,,0.000,\"E × 0.965\"",
                "\"liver: pull 30 mm\",\"Calot\",581,31.5,0.640,2.000,0.50,0.250,\"k = 0.5, 1 iterations\"",
            ]
        );
    }

    /// A run of this program's methods keeps the competitors.
    #[test]
    fn competitors_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("accuracy.csv");
        std::fs::write(&file, FILE).expect("a file");
        let all = with_kept(&[row("Calot", 20.0, 1.0)], &file).expect("merged");
        let times: Vec<f64> = all.iter().map(|row| row.us_per_tick).collect();
        assert_eq!(times, [20.0, 999.0, 31.5]);
        let none = with_kept(&[], &file).expect("merged");
        assert_eq!(none.len(), 4);
        assert!(with_kept(&[], &folder.path().join("missing.csv")).is_err());
    }
}
