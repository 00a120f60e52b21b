//! The debrief: one page that needs neither network nor other files.

mod drawing;
mod outline;
mod page;
mod paths;

pub use drawing::learning_curve;
pub use outline::Outlines;
pub use page::{Names, html};

use crate::assessment::Assessed;
use crate::rules::Rules;

/// One session in a report.
#[derive(Debug)]
pub struct Chapter {
    /// Name: the session's path.
    pub name: String,
    /// The scene's name.
    pub scene: String,
    /// Version of the program that recorded the session.
    pub build: String,
    /// Start, UTC, as text.
    pub when: String,
    /// Result of the assessment.
    pub assessed: Assessed,
    /// Rules of the assessment.
    pub rules: Rules,
    /// The organs, behind the paths.
    pub outlines: Outlines,
    /// Captions and pictures (PNG).
    pub pictures: Vec<(String, Vec<u8>)>,
    /// Durations of the simulation's ticks, if they are stored next to the session.
    pub ticks: Option<Ticks>,
    /// True if a scripted hand worked the session.
    pub is_scripted: bool,
    /// Reason why the recording ends early, if it does.
    pub cut_short: Option<String>,
    /// The trainee's earlier sessions of the same task, oldest first.
    pub past: Vec<Past>,
    /// The instructor's rating sheet: each item with 1 to 5 points.
    pub sheet: Vec<(String, u8)>,
}

/// Durations of ticks, as in a run's `summary.json`.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct Ticks {
    /// Duration of the whole tick, ns.
    pub tick_ns: Spread,
    /// Durations of the tick's stages, ns.
    pub stage_ns: std::collections::BTreeMap<String, Spread>,
    /// Periods skipped because the tick before them, or the machine, was late.
    #[serde(rename = "deadline_misses")]
    pub missed_periods: u64,
    /// Ticks that ended after their deadline.
    #[serde(rename = "overruns")]
    pub late_ticks: u64,
    /// True if the controller had realtime privileges.
    pub realtime: bool,
}

/// Quantiles of many durations, ns.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub struct Spread {
    /// Number of durations.
    pub count: u64,
    /// Median.
    pub p50: u64,
    /// 99th percentile.
    pub p99: u64,
    /// The longest.
    pub max: u64,
}

/// An earlier session.
#[derive(Debug, Clone, PartialEq)]
pub struct Past {
    /// Start, UTC, as text.
    pub when: String,
    /// Outcome of the session.
    pub outcome: String,
    /// Score.
    pub score: f64,
    /// Metrics of the session by name, without those that had no value.
    pub metrics: std::collections::BTreeMap<String, f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assessment::Moment;
    use crate::injury::{Cause, Injury, InjuryKind, Severity};
    use crate::metrics::Metric;
    use crate::{Anatomy, Assessment, Difficulty, Task};

    const SPREAD: Spread = Spread {
        count: 1000,
        p50: 210_000,
        p99: 480_000,
        max: 912_300,
    };

    fn chapter(name: &str) -> Chapter {
        let rules = Rules::default();
        let assessment = Assessment::new(
            Task::Cut,
            Difficulty::Exam,
            rules.clone(),
            Anatomy::default(),
        );
        let mut assessed = assessment.end();
        assessed.force_histogram_s = vec![0.0, 1.5, 0.25];
        assessed.paths[0] = vec![[0.0; 4], [0.1, 0.2, 0.3, 1.0]];
        Chapter {
            name: name.to_owned(),
            scene: "triangle".to_owned(),
            build: "a test".to_owned(),
            when: "2026-11-22 01:00".to_owned(),
            assessed,
            rules,
            outlines: Outlines::default(),
            pictures: vec![("frame".to_owned(), vec![1, 2, 3])],
            ticks: Some(Ticks {
                tick_ns: SPREAD,
                stage_ns: [("solve".to_owned(), SPREAD)].into(),
                missed_periods: 3,
                late_ticks: 5,
                realtime: false,
            }),
            is_scripted: false,
            cut_short: None,
            past: vec![Past {
                when: String::new(),
                outcome: "failed".to_owned(),
                score: 40.0,
                metrics: [("time_s".to_owned(), 12.0)].into(),
            }],
            sheet: vec![("Depth perception".to_owned(), 4)],
        }
    }

    #[test]
    fn a_page_stands_alone_and_takes_no_markup_from_a_file() {
        let evil = "<script src=\"http://x\">";
        let page = html(&[chapter(evil), chapter("b")], &str::to_owned);
        assert!(!page.contains("<script") && page.contains("&lt;script"));
        assert!(!page.contains("href=") && !page.contains("src=\"http"));
        assert!(page.contains("data:image/png;base64,AQID"));
        for expected in [
            "Pass rule",
            "Paths",
            "Force",
            "earlier sessions",
            "<td>whole tick<td>210.0<td>480.0<td>912.3",
            "3 periods were missed",
            "sum<td>4 of 5",
            "aborted",
        ] {
            assert!(page.contains(expected), "{expected}");
        }
        for metric in crate::Metric::ALL {
            assert!(
                page.contains(&figures::html::escape(metric.definition())),
                "{}",
                metric.name()
            );
        }
    }

    #[test]
    fn an_organ_that_fell_or_shook_is_told_in_a_sentence() {
        let mut told = chapter("a");
        for (what, value) in [("fall", 0.25), ("shake", 0.058), ("grasp", 3.0)] {
            told.assessed.moments.push(Moment {
                at_s: 7.0,
                what: what.to_owned(),
                organ: Some("liver".to_owned()),
                value,
            });
        }
        let page = html(&[told], &str::to_owned);
        for sentence in [
            "At 7 s the liver fell 250 mm off its place, and nobody had freed it: the scene is at fault",
            "At 7 s the liver shook at up to 58 mm/s without being moved: the scene is at fault",
        ] {
            assert!(page.contains(sentence), "{sentence}");
        }
        assert_eq!(page.matches("the scene is at fault").count(), 2);
    }

    #[test]
    fn a_page_says_what_is_not_the_trainees_and_what_noise_adds() {
        let with = |values: &[(Metric, f64)]| {
            let mut chapter = chapter("a");
            for (metric, value) in values {
                chapter.assessed.metrics.set(*metric, *value);
            }
            html(&[chapter], &str::to_owned)
        };
        let page = with(&[
            (Metric::Paused, 60.0),
            (Metric::DeviceLost, 9.0),
            (Metric::Gaps, 0.05),
            (Metric::Noise, 0.3),
        ]);
        let sentences =
            "The task was paused for 60.0 s. A device was missing for 9.0 s. The trainee's";
        assert!(page.contains(sentences), "no word of a gap of 0.05 s");
        assert!(page.contains("noise at rest is 0.30 mm. Movements of the tip within 1.6 mm"));
        assert!(with(&[(Metric::Noise, 1.0)]).contains("does not remove so much noise"));
        assert!(!with(&[]).contains("do not count that"));
    }

    #[test]
    fn injuries_rules_and_published_values_stand_with_their_source() {
        let mut injured = chapter("a");
        injured.assessed.injuries.push(Injury {
            at_s: 3.0,
            kind: InjuryKind::Perforated,
            cause: Cause::Torn,
            severity: Severity::Grave,
            organ: "bile duct".to_owned(),
            ends_task: true,
            source: "<a book>".to_owned(),
        });
        let page = html(&[injured], &str::to_owned);
        for expected in [
            "<td>3.0 s<td class=\"l\">bile duct<td class=\"l\">perforated<td class=\"l\">traction<td \
             class=\"l\">ends the task<td class=\"l\">&lt;a book&gt;",
            "at least 70<td>✗ no<td class=\"l\">no source",
            "Published values",
            "18 996 runs at LAP Mentor",
        ] {
            assert!(page.contains(expected), "{expected}");
        }
    }

    #[test]
    fn a_scripted_session_is_marked_and_in_no_curve() {
        let of = |scripted: [bool; 2]| {
            let both = scripted.map(|is_scripted| Chapter {
                is_scripted,
                past: Vec::new(),
                ..chapter("a")
            });
            html(&both, &str::to_owned)
        };
        let [persons, one] = [of([false; 2]), of([false, true])];
        for told in [
            "A scripted hand worked this session",
            "aborted, scripted hand",
        ] {
            assert_eq!(persons.matches(told).count(), 0);
            assert_eq!(one.matches(told).count(), 1);
        }
        // One session is no curve.
        let curves = |page: &str| page.matches("<figure>").count();
        assert_eq!(curves(&persons) - curves(&one), 1);
    }

    #[test]
    fn steps_of_an_axis_are_round() {
        for (length, expected) in [(10.0, 2.0), (0.037, 0.005), (1000.0, 200.0)] {
            let step = drawing::step(length, 8.0);
            assert!((step - expected).abs() < 1e-9, "{length}: {step}");
        }
    }

    #[test]
    fn a_curve_needs_two_sessions() {
        assert!(learning_curve(&[1.0], None, "score").is_none());
        let curve = learning_curve(&[1.0, 2.0], Some(70.0), "score");
        assert!(curve.is_some_and(|curve| curve.contains("pass rule")));
    }
}
