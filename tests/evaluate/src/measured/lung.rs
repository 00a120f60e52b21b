//! Porcine lung in a testing machine: pressed, and cut. Only the shapes of the curves are compared,
//! because the publication states neither the size of the samples nor the blade.

use std::path::Path;

use super::plates::{Ends, Setting, press};
use super::silicone::SPECIMEN;
use super::{Bar, Row};
use crate::body::Tissue;
use crate::csv::Csv;

/// Publication that the files belong to.
const SOURCE: &str = "Gao 2026, High-Fidelity-MRSS data set";
const PRESSING: &str = "lung_pressing_01.csv";
const CUTTING: &str = "lung_cutting_01.csv";
/// Depths at which the force is compared with that at twice the depth: in mm for the lung, in per
/// cent of the height for Calot's specimen.
const DOUBLED: [f64; 3] = [5.0, 10.0, 20.0];
/// A fall of the force counts as a drop if it is larger than this share of the previous force.
const DROP: f64 = 0.05;
/// Largest movement that counts as rest at one place, mm.
const STILL_MM: f64 = 0.005;

/// A trial: depth in mm and force in N, in the order of the depths.
#[derive(Debug, Clone, Default)]
pub(super) struct Trial {
    pub(super) course: Vec<[f64; 2]>,
    /// Times, s, in the same order.
    times_s: Vec<f64>,
}

impl Trial {
    /// Force at a depth, N, interpolated between the nearest two; `None` if the trial did not reach
    /// this depth.
    fn force_n(&self, depth_mm: f64) -> Option<f64> {
        let at = self.course.partition_point(|it| it[0] < depth_mm);
        let [low, high] = [self.course.get(at.checked_sub(1)?)?, self.course.get(at)?];
        let share = (depth_mm - low[0]) / (high[0] - low[0]).max(f64::MIN_POSITIVE);
        Some(low[1] + (high[1] - low[1]) * share)
    }

    /// Force at twice the depth divided by the force at the depth.
    fn doubled(&self, depth_mm: f64) -> Option<f64> {
        Some(self.force_n(2.0 * depth_mm)? / self.force_n(depth_mm)?)
    }

    /// Median speed, mm/s.
    fn speed_mm_s(&self) -> f64 {
        let pairs = self.course.windows(2).zip(self.times_s.windows(2));
        let speeds = pairs.map(|(x, t)| (x[1][0] - x[0][0]) / (t[1] - t[0]));
        statistics::median(&speeds.collect::<Vec<_>>())
    }

    /// Longest time at one place, s.
    fn rest_s(&self) -> f64 {
        let (mut longest, mut since) = (0.0_f64, 0);
        for i in 1..self.course.len() {
            if self.course[i][0] - self.course[since][0] > STILL_MM {
                since = i;
            }
            longest = longest.max(self.times_s[i] - self.times_s[since]);
        }
        longest
    }

    /// Drops of the force from a peak to the next minimum, as shares of the peak.
    fn drops(&self) -> Vec<f64> {
        let mut found = Vec::new();
        let (mut peak, mut low) = (f64::MIN, f64::MAX);
        for [_, force] in &self.course {
            if *force > peak || *force > low * (1.0 + DROP) {
                if peak - low > DROP * peak && peak > 0.0 {
                    found.push(1.0 - low / peak);
                }
                (peak, low) = (*force, *force);
            }
            low = low.min(*force);
        }
        found
    }
}

/// The trials and their rows.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) rows: Vec<Row>,
    pub(super) pressing: Vec<Trial>,
    pub(super) cutting: Vec<Trial>,
    /// Calot's curve: strain, per cent, and force, N.
    pub(super) calot: Vec<[f64; 2]>,
    /// Slowest and fastest motion of the machine, mm/s.
    pub(super) speeds_mm_s: [f64; 2],
    /// Longest rest at one place in any trial, s.
    pub(super) rest_s: f64,
}

/// Reads the files of a folder and compares the shapes of their curves with Calot's.
///
/// # Errors
/// A file that cannot be read, with the remedy; or Calot's message if it refuses the specimen.
pub(super) fn run(folder: &Path, quick: bool) -> Result<Found, String> {
    let pressing = read(&folder.join(PRESSING))?;
    let cutting = read(&folder.join(CUTTING))?;
    let tissue = Tissue::LIVER;
    let body = SPECIMEN.body(if quick { 250 } else { 581 }, tissue)?;
    let strains: Vec<f64> = [0.01, 0.025, 0.05, 0.10, 0.20, 0.30, 0.40].to_vec();
    let depths_m: Vec<f64> = strains.iter().map(|it| it * SPECIMEN.height_m).collect();
    let pressed = press(&body, tissue, Ends::Free, Setting::SHIPPED, &depths_m)?;
    let both = strains.iter().zip(&pressed);
    let calot: Vec<[f64; 2]> = both.map(|(it, p)| [it * 100.0, p.force_n]).collect();
    let mut rows = Vec::new();
    rows.extend(doublings(&pressing, "pressed", &calot));
    rows.extend(doublings(&cutting, "before the blade enters", &calot));
    rows.extend(drops(&cutting));
    let all = || pressing.iter().chain(&cutting);
    let speeds = || all().map(Trial::speed_mm_s);
    let speeds_mm_s = [
        speeds().fold(f64::INFINITY, f64::min),
        speeds().fold(0.0, f64::max),
    ];
    let rest_s = all().map(Trial::rest_s).fold(0.0, f64::max);
    Ok(Found {
        rows,
        pressing,
        cutting,
        calot,
        speeds_mm_s,
        rest_s,
    })
}

/// Trials of a file. The rows are out of order. The rows of one trial have the same offset between
/// the machine's position and the depth.
fn read(path: &Path) -> Result<Vec<Trial>, String> {
    let told = |what: &str| format!("{}: {what}", path.display());
    let csv = Csv::read(path)?;
    let mut trials: Vec<(f64, Vec<[f64; 3]>)> = Vec::new();
    for (line, row) in csv.rows().enumerate() {
        let names = ["time_s", "position_mm", "length_mm", "force_n"];
        let [time_s, place_mm, depth_mm, force_n] = names.map(|name| row.number(name));
        if ![time_s, place_mm, depth_mm, force_n]
            .iter()
            .all(|it| it.is_finite())
        {
            return Err(told(&format!(
                "line {} needs a number in each of {}",
                line + 2,
                names.join(", ")
            )));
        }
        let offset_mm = place_mm - depth_mm;
        let own = trials.iter_mut().find(|it| (it.0 - offset_mm).abs() < 0.1);
        let point = [depth_mm, force_n, time_s];
        match own {
            Some((_, points)) => points.push(point),
            None => trials.push((offset_mm, vec![point])),
        }
    }
    let trial = |(_, mut points): (f64, Vec<[f64; 3]>)| {
        points.sort_by(|a, b| a[2].total_cmp(&b[2]));
        Trial {
            course: points.iter().map(|it| [it[0], it[1]]).collect(),
            times_s: points.iter().map(|it| it[2]).collect(),
        }
    };
    let trials: Vec<Trial> = trials.into_iter().map(trial).collect();
    match trials.iter().all(|it| it.course.len() > 10) && !trials.is_empty() {
        true => Ok(trials),
        false => Err(told("a trial needs more than 10 rows")),
    }
}

fn doublings(trials: &[Trial], of: &str, calot: &[[f64; 2]]) -> Vec<Row> {
    let mut rows = Vec::new();
    for depth in DOUBLED {
        let found: Vec<f64> = trials.iter().filter_map(|it| it.doubled(depth)).collect();
        let at = |pct: f64| calot.iter().find(|it| (it[0] - pct).abs() < 1e-6);
        let (Some(once), Some(twice)) = (at(depth), at(2.0 * depth)) else {
            continue;
        };
        if found.is_empty() {
            continue;
        }
        rows.push(Row {
            source: SOURCE.to_owned(),
            quantity: "force at twice the depth over force at the depth".to_owned(),
            condition: format!(
                "porcine lung, {of}, {depth} mm, trials: {}; Calot: liver between plates, {depth} % \
                 strain",
                found.len()
            ),
            published: mean(&found),
            published_sd: deviation(&found),
            calot: Some(twice[1] / once[1]),
            bar: Bar::Percent,
        });
    }
    rows
}

fn drops(trials: &[Trial]) -> Vec<Row> {
    let drops: Vec<Vec<f64>> = trials.iter().map(Trial::drops).collect();
    let counts: Vec<f64> = drops.iter().map(|it| it.len() as f64).collect();
    let largest: Vec<f64> = (drops.iter())
        .map(|it| 100.0 * it.iter().copied().fold(0.0, f64::max))
        .collect();
    let row = |quantity: &str, values: &[f64]| Row {
        source: SOURCE.to_owned(),
        quantity: quantity.to_owned(),
        condition: format!(
            "porcine lung under a blade, trials: {}; Calot's blades return no force",
            trials.len()
        ),
        published: mean(values),
        published_sd: deviation(values),
        calot: None,
        bar: Bar::Percent,
    };
    vec![
        row("drops of the force by 5 % or more in a cut", &counts),
        row("largest drop of the force in a cut, %", &largest),
    ]
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Standard deviation; `None` for fewer than two values.
fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|it| (it - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(forces: &[f64]) -> Trial {
        let course = (0..).zip(forces).map(|(i, f)| [f64::from(i), *f]);
        Trial {
            course: course.collect(),
            times_s: (0..forces.len()).map(|i| i as f64).collect(),
        }
    }

    #[test]
    fn drops_and_doublings_are_read() {
        let cut = trial(&[0.0, 1.0, 2.0, 1.5, 3.0, 2.97, 4.0, 1.0, 2.0]);
        let drops = cut.drops();
        assert_eq!(drops.len(), 2, "{drops:?}");
        assert!((drops[0] - 0.25).abs() < 1e-12 && (drops[1] - 0.75).abs() < 1e-12);
        let square = trial(&[0.0, 1.0, 4.0, 9.0, 16.0, 25.0]);
        assert!((square.doubled(2.0).unwrap() - 4.0).abs() < 1e-12);
        assert_eq!(square.doubled(4.0), None);
        assert!((square.speed_mm_s() - 1.0).abs() < 1e-12 && square.rest_s() < 1e-9);
    }

    #[test]
    fn rows_out_of_order_become_trials() {
        let folder = std::env::temp_dir().join(format!("calot-lung-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut text = "time_s,position_mm,length_mm,force_n,step\n".to_owned();
        for offset in [3.0, 7.0] {
            for i in (0..20).rev() {
                let x = f64::from(i);
                text += &format!("{x},{},{x},{},0\n", x + offset, x * offset);
            }
        }
        let path = folder.join(PRESSING);
        std::fs::write(&path, &text).unwrap();
        let trials = read(&path).unwrap();
        assert_eq!(trials.len(), 2);
        assert!((trials[1].force_n(2.5).unwrap() - 17.5).abs() < 1e-12);
        std::fs::write(
            &path,
            text.replacen("0\n", "x\n", 1).replacen("19,", "y,", 1),
        )
        .unwrap();
        assert!(read(&path).unwrap_err().contains("line 2 needs a number"));
        std::fs::write(&path, "time_s,position_mm,length_mm,force_n\n1,1,1,1\n").unwrap();
        assert!(read(&path).unwrap_err().contains("more than 10 rows"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
