//! Words of a debrief that the package `assess` writes.

use assess::report::Words as Spoken;
use assess::{Reason, Step};

use super::Words;

impl Spoken for Words {
    fn code(&self) -> &str {
        self.language().code()
    }

    fn say_with(&self, id: &str, values: &[(&str, &str)]) -> String {
        let values: Vec<_> = values
            .iter()
            .map(|(name, value)| (*name, (*value).into()))
            .collect();
        Self::say_with(self, id, &values)
    }

    fn has(&self, id: &str) -> bool {
        self.bundle.get_message(id).is_some()
    }

    fn metric(&self, name: &str) -> String {
        Self::metric(self, name)
    }

    fn organ(&self, name: &str) -> String {
        Self::organ(self, name)
    }

    fn step(&self, step: &Step) -> String {
        Self::step(self, step)
    }

    fn place(&self, step: &Step) -> String {
        Self::place(self, step)
    }

    fn reason(&self, reason: &Reason) -> String {
        Self::reason(self, reason)
    }

    fn number(&self, value: f64, digits: usize) -> String {
        Self::number(self, value, digits)
    }
}

#[cfg(test)]
mod tests {
    use assess::report::{Case, Chapter, Outlines, Past, Spread, Ticks, html, learning_curve};
    use assess::{
        Alarm, AlarmKind, Anatomy, Assessment, Cause, Difficulty, Injury, InjuryKind, Metric,
        Moment, Rules, Severity, Task,
    };

    use super::super::Language;
    use super::*;

    const KINDS: [AlarmKind; 12] = [
        AlarmKind::Touched,
        AlarmKind::Burnt,
        AlarmKind::Cut,
        AlarmKind::Torn,
        AlarmKind::Perforated,
        AlarmKind::Crushed,
        AlarmKind::ClipLost,
        AlarmKind::ClipMisplaced,
        AlarmKind::ClipOpen,
        AlarmKind::TooEarly,
        AlarmKind::Unseen,
        AlarmKind::Unclamped,
    ];

    fn case(course: &str, wall: &str) -> Case {
        Case {
            name: "ada".to_owned(),
            bmi: 20.0,
            course: course.to_owned(),
            wall: wall.to_owned(),
            stones: 1,
            stone_mm: 12.0,
        }
    }

    /// A session with everything that a page can show.
    fn chapter(task: Task) -> Chapter {
        let rules = Rules::default();
        let anatomy = Anatomy::default();
        let assessment = Assessment::new(task, Difficulty::Beginner, rules.clone(), anatomy);
        let mut assessed = assessment.end();
        let organ = || Some("bile duct".to_owned());
        assessed.alarms.extend(KINDS.map(|kind| Alarm {
            at_s: 75.0,
            session_s: 80.0,
            kind,
            organ: organ(),
            at_m: [0.0; 3],
        }));
        assessed
            .moments
            .extend(assess::report::LANES.map(|what| Moment {
                at_s: 7.0,
                what: what.to_owned(),
                organ: organ(),
                value: 0.1,
            }));
        let kinds = [
            (InjuryKind::Divided, Cause::Cut, Severity::Grave),
            (InjuryKind::Perforated, Cause::Torn, Severity::Serious),
            (InjuryKind::Burnt, Cause::Burnt, Severity::Minor),
            (InjuryKind::Torn, Cause::Torn, Severity::Serious),
            (InjuryKind::Clipped, Cause::Clipped, Severity::Serious),
        ];
        assessed
            .injuries
            .extend(kinds.map(|(kind, cause, severity)| Injury {
                heat_j: None,
                depth_mm: None,
                at_s: 3.0,
                kind,
                cause,
                severity,
                organ: "bile duct".to_owned(),
                ends_task: false,
                source: String::new(),
            }));
        assessed.force_histogram_s = vec![1.0, 2.0];
        let spread = Spread {
            count: 9,
            p50: 1,
            p99: 2,
            max: 3,
        };
        let past = |score| Past {
            when: String::new(),
            outcome: "failed".to_owned(),
            score,
            metrics: [("time_s".to_owned(), 12.0)].into(),
        };
        Chapter {
            name: "out/session.mcap".to_owned(),
            scene: "patient:ada".to_owned(),
            case: Some(case("usual", "normal")),
            build: "a test".to_owned(),
            when: "2026-11-22 01:00".to_owned(),
            assessed,
            rules,
            outlines: Outlines::default(),
            pictures: vec![("frame".to_owned(), vec![1])],
            ticks: Some(Ticks {
                tick_ns: spread,
                stage_ns: std::collections::BTreeMap::new(),
                missed_periods: 1,
                late_ticks: 1,
                realtime: true,
                pictures_per_second: Some(3.25),
                fluids: None,
            }),
            is_scripted: true,
            cut_short: Some("x".to_owned()),
            trainee: Some("Ada".to_owned()),
            technical: Some("report.html".to_owned()),
            past: vec![past(40.0), past(50.0)],
            sheet: vec![("x".to_owned(), 4)],
        }
    }

    #[test]
    fn a_page_is_in_the_language_and_shows_no_key() {
        let parts = [
            "page-",
            "case-",
            "advice-",
            "lane-",
            "alarm-",
            "task-",
            "outcome-",
            "cause-",
            "metric-",
            "organ-",
            "injury-",
            "step-",
            "reason-",
            "difficulty-",
            "scene-",
            "launcher-",
        ];
        let pages = Language::ALL.map(|language| {
            let words = Words::new(language);
            let chapters: Vec<_> = Task::ALL.map(chapter).into();
            let page = html(&chapters, &words);
            let code = format!("<html lang=\"{}\">", language.code());
            assert!(page.contains(&code));
            for part in parts {
                // A missing message is shown as its id.
                let text = page.match_indices(part).map(|(at, _)| &page[at..]);
                let ids: Vec<_> = text
                    .map(|it| it.chars().take(30).collect::<String>())
                    .collect();
                assert!(ids.is_empty(), "{language:?}: {ids:?}");
            }
            for metric in Metric::ALL {
                assert!(
                    !page.contains(&format!("<td>{}<", metric.name())) || metric.name().len() < 8
                );
            }
            page
        });
        for english in ["What to learn from it", "Next time:", "of 100", "Pass"] {
            assert!(!pages[1].contains(english), "{english}");
        }
        for german in [
            "Was daraus zu lernen ist",
            "Nächstes Mal:",
            "Ductus choledochus",
        ] {
            assert!(pages[1].contains(german), "{german}");
        }
    }

    #[test]
    fn a_case_is_one_line_in_either_language() {
        let [english, german] = Language::ALL.map(Words::new);
        let ada = case("usual", "normal");
        let line = "Patient Ada, BMI 20: usual course of duct and artery; gallbladder wall normal; \
                    one stone of 12 mm";
        assert_eq!(ada.line(&english), line);
        let edith = Case {
            stones: 8,
            ..case("accessory-artery", "scarred")
        };
        assert!(edith.line(&german).contains("8 Steine von 12 mm"));
        for words in [english, german] {
            for course in [
                "usual",
                "variant",
                "short-duct",
                "low-union",
                "artery-in-front",
                "accessory-artery",
                "humped-artery",
            ] {
                assert!(words.has(&format!("case-course-{course}")), "{course}");
            }
            for wall in ["normal", "acute", "scarred"] {
                assert!(words.has(&format!("case-wall-{wall}")), "{wall}");
            }
        }
    }

    #[test]
    fn every_metric_is_defined_in_german() {
        let german = Words::new(Language::German);
        for metric in assess::Metric::ALL {
            let id = format!("definition-{}", metric.name().replace('_', "-"));
            assert!(german.has(&id), "{id}");
        }
        let page = html(&[chapter(Task::Clamp)], &german);
        assert!(page.contains("Zeit der Aufgabe. Pausen"));
        assert!(!page.contains("(englisch)") && !page.contains("of operations"));
    }

    #[test]
    fn points_lost_without_an_alarm_have_advice() {
        for language in Language::ALL {
            let words = Words::new(language);
            for metric in [
                "cautery-air-s",
                "blood-ml",
                "bile-ml",
                "out-of-view-s",
                "cautery-safe",
                "clip-room-mm",
                "views-held",
            ] {
                assert!(words.has(&format!("advice-metric-{metric}")), "{metric}");
            }
            assert!(!words.has("advice-metric-touches-wrong"), "an alarm has it");
        }
    }

    #[test]
    fn a_curve_has_the_words_of_its_language() {
        let german = Words::new(Language::German);
        let curve = learning_curve(&[1.0, 2.0], Some(70.0), "score", &german);
        let curve = curve.unwrap();
        assert!(curve.contains("zum Bestehen") && curve.contains("Punkte, Sitzung für Sitzung"));
    }
}
