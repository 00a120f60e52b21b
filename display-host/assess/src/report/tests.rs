//! Tests of the debrief. Their words are the ids of messages, with their values.

use super::words::tests::Ids;
use super::*;
use crate::alarm::{Alarm, AlarmKind};
use crate::assessment::Moment;
use crate::injury::{Cause, Injury, InjuryKind, Severity};
use crate::metrics::Metric;
use crate::rules::Lost;
use crate::step::Reason;
use crate::{Anatomy, Assessment, Difficulty, Task};
use shared_mem::scene::OrganKind;

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
        trainee: None,
        scene: "triangle".to_owned(),
        case: None,
        build: "a test".to_owned(),
        when: "2026-11-22 01:00".to_owned(),
        assessed,
        rules,
        outlines: Outlines::default(),
        pictures: vec![("frame 0003".to_owned(), vec![1, 2, 3])],
        ticks: Some(Ticks {
            tick_ns: SPREAD,
            stage_ns: [("solve".to_owned(), SPREAD)].into(),
            missed_periods: 3,
            late_ticks: 5,
            realtime: false,
            pictures_per_second: Some(3.25),
            fluids: None,
        }),
        is_scripted: false,
        cut_short: None,
        technical: None,
        past: vec![Past {
            when: String::new(),
            outcome: "failed".to_owned(),
            score: 40.0,
            metrics: [("time_s".to_owned(), 12.0)].into(),
        }],
        sheet: vec![("Depth perception".to_owned(), 4)],
    }
}

fn burnt() -> Alarm {
    Alarm {
        at_s: 75.5,
        session_s: 80.25,
        kind: AlarmKind::Burnt,
        organ: Some("bile duct".to_owned()),
        at_m: [0.0; 3],
    }
}

#[test]
fn an_error_has_advice_a_close_picture_and_its_replay() {
    let mut taught = chapter("out/session.mcap");
    taught.assessed.alarms = vec![burnt(), burnt()];
    let corners = [[-0.02, -0.02, 0.0], [0.02, -0.02, 0.0], [0.0, 0.02, 0.0]];
    taught.outlines = Outlines::test(OrganKind::BileDuct, vec![corners]);
    let lost = |metric| Lost {
        metric,
        value: 9.0,
        points: 4.5,
    };
    taught.assessed.lost = vec![lost("cautery_air_s")];
    let page = html(&[taught], &Ids);
    for expected in [
        "<h4>Alarm-burnt organ=bile duct <small>page-times count=2</small></h4>",
        "<b>page-next-time</b> advice-burnt",
        "<h4>cautery_air_s: 9.0 s <small>page-cost points=4.5</small></h4>",
        "page-happened-at times=1:15, 1:15",
        "<details><summary>page-replays",
        "<td>1:15 alarm-burnt organ=bile duct<td class=\"l\" lang=\"en\"><code>calot replay \
         &#39;out/session.mcap&#39; --at 77.2</code>",
        "alt=\"alarm-burnt organ=bile duct\" src=\"data:image/png",
        "advice-metric-cautery-air-s",
        "page-cost points=4.5",
    ] {
        assert!(page.contains(expected), "{expected}");
    }
    // Where a clip was lost there is no organ to be shown.
    let mut lost = chapter("a");
    lost.outlines = Outlines::test(OrganKind::BileDuct, vec![corners]);
    lost.assessed.alarms = vec![Alarm {
        kind: AlarmKind::ClipLost,
        organ: None,
        ..burnt()
    }];
    let page = html(&[lost], &Ids);
    assert!(
        page.contains("advice-clip-lost") && !page.contains("<figure><img alt=\"alarm-clip-lost")
    );
    // The session ended before a step was done.
    let page = html(&[chapter("a")], &Ids);
    assert!(page.contains("<b>page-next-time</b> place of: Divide the cystic duct"));
    let mut flawless = chapter("a");
    flawless.assessed.reasons.clear();
    assert!(html(&[flawless], &Ids).contains("page-no-alarm"));
}

/// "No error was seen" under a failed task would be a lie.
#[test]
fn a_pass_rule_that_is_not_met_and_costs_nothing_has_advice() {
    let mut narrow = chapter("a");
    narrow.assessed.reasons = vec![Reason::TooLittle {
        metric: Some(Metric::ClipRoom),
        value: 1.0,
        limit: 3.0,
    }];
    let page = html(&[narrow], &Ids);
    assert!(page.contains("advice-metric-clip-room-mm"));
    assert!(!page.contains("page-no-alarm"));
}

#[test]
fn a_page_tells_how_often_the_trainee_started_over() {
    let told = |count| {
        let mut again = chapter("a");
        again.assessed.metrics.set(Metric::Restarts, count);
        html(&[again], &Ids).contains("<p class=\"open\">page-restarted count=3</p>")
    };
    assert!(told(3.0) && !told(0.0));
}

#[test]
fn a_page_says_that_a_slow_computer_is_too_slow_to_train_with() {
    let shown = |rate: Option<f64>| {
        let mut slow = chapter("a");
        if let Some(ticks) = &mut slow.ticks {
            ticks.pictures_per_second = rate;
        }
        html(&[slow], &Ids).contains("<p class=\"open\">page-slow-computer rate=3.2</p>")
    };
    assert!(shown(Some(3.25)));
    assert!(!shown(Some(10.5)) && !shown(None));
}

/// On such a computer the careful scripted surgeon burnt the bile duct.
#[test]
fn a_page_says_that_the_computer_stood_still_and_that_heat_came_from_beside() {
    let mut stalled = chapter("a");
    stalled.assessed.metrics.set(Metric::Gaps, 127.2);
    stalled.assessed.injuries = vec![Injury {
        at_s: 144.5,
        kind: InjuryKind::Burnt,
        cause: Cause::Burnt,
        severity: Severity::Serious,
        organ: "bile duct".to_owned(),
        ends_task: false,
        heat_j: None,
        depth_mm: None,
        source: String::new(),
    }];
    let page = html(&[stalled], &Ids);
    assert!(page.contains("page-stood-still seconds=127") && page.contains("injury-seared"));
    let mut calm = chapter("a");
    calm.assessed.metrics.set(Metric::Gaps, 4.0);
    assert!(!html(&[calm], &Ids).contains("page-stood-still"));
}

#[test]
fn a_page_tells_the_volumes_in_the_suction_s_jar() {
    let volumes = |jar_ml| Whereabouts {
        on_tissue_ml: 0.5,
        jar_ml,
    };
    let page = |jar_ml| {
        let mut sucked = chapter("a");
        if let Some(ticks) = &mut sucked.ticks {
            ticks.fluids = Some(Fluids {
                blood: volumes(jar_ml),
                bile: volumes(0.0),
                water: volumes(2.0 * jar_ml),
            });
        }
        html(&[sucked], &Ids)
    };
    assert!(page(12.0).contains("page-jar blood=12.0 bile=0.0 water=24.0 left=1.5"));
    assert!(!page(0.0).contains("page-jar"));
}

#[test]
fn a_page_tells_the_stones_that_spilled_and_warns_of_those_left_behind() {
    let page = |spilled, out| {
        let mut operated = chapter("a");
        let metrics = &mut operated.assessed.metrics;
        metrics.set(Metric::StonesSpilled, spilled);
        metrics.set(Metric::StonesRetrieved, out);
        metrics.set(Metric::StonesLeft, spilled - out);
        html(&[operated], &Ids)
    };
    let some = page(5.0, 3.0);
    assert!(
        some.contains("page-stones spilled=5 out=3 left=2") && some.contains("page-stones-left")
    );
    let all = page(5.0, 5.0);
    assert!(all.contains("page-stones spilled=5") && !all.contains("page-stones-left"));
    assert!(!page(0.0, 0.0).contains("page-stones"));
}

#[test]
fn a_page_stands_alone_and_takes_no_markup_from_a_file() {
    let evil = "<script src=\"http://x\">";
    let mut hostile = chapter(evil);
    hostile.assessed.alarms = vec![burnt()];
    let page = html(&[hostile, chapter("b")], &Ids);
    assert!(!page.contains("<script") && page.contains("&lt;script"));
    assert!(!page.contains("href=") && !page.contains("src=\"http"));
    assert!(page.contains("data:image/png;base64,AQID"));
    for expected in [
        "page-pass-rules",
        "<figcaption>page-frame number=4<",
        "page-paths",
        "page-force",
        "page-past",
        "<td>whole tick<td>210.0<td>480.0<td>912.3",
        "page-timing-otherwise count=1000 late=5 missed=3",
        "page-sum<td>points-number number=4 of=5",
        "outcome-aborted",
    ] {
        assert!(page.contains(expected), "{expected}");
    }
    for metric in crate::Metric::ALL {
        assert!(
            page.contains(&format!("definition-{}<", metric.name().replace('_', "-"))),
            "{}",
            metric.name()
        );
    }
}

#[test]
fn an_organ_that_fell_shook_or_held_the_instrument_is_told_in_a_sentence() {
    let mut told = chapter("a");
    for (what, value) in [
        ("fall", 0.25),
        ("shake", 0.058),
        ("buried", 0.012),
        ("grasp", 3.0),
    ] {
        told.assessed.moments.push(Moment {
            at_s: 7.0,
            what: what.to_owned(),
            organ: Some("liver".to_owned()),
            value,
        });
    }
    let page = html(&[told], &Ids);
    for sentence in [
        "page-fell at=7 organ=liver by=250",
        "page-shook at=7 organ=liver by=58",
        "page-buried at=7 organ=liver by=12",
        "lane-buried",
    ] {
        assert!(page.contains(sentence), "{sentence}");
    }
    // They stand among the notes for engineers, and not as errors.
    assert!(page.contains("<details><summary>debrief-machine</summary><p>page-fell"));
    assert!(!page.contains("<p class=\"bad\">page-"));
}

#[test]
fn a_page_says_what_is_not_the_trainees_and_what_noise_adds() {
    let with = |values: &[(Metric, f64)]| {
        let mut chapter = chapter("a");
        for (metric, value) in values {
            chapter.assessed.metrics.set(*metric, *value);
        }
        html(&[chapter], &Ids)
    };
    let page = with(&[
        (Metric::Paused, 60.0),
        (Metric::DeviceLost, 9.0),
        (Metric::Gaps, 0.05),
        (Metric::Noise, 0.3),
    ]);
    let sentences = "page-was-paused seconds=60.0 page-lost-device seconds=9.0 page-not-counted";
    assert!(page.contains(sentences), "no word of a gap of 0.05 s");
    assert!(page.contains("page-noise-small noise=0.30"));
    assert!(with(&[(Metric::Noise, 1.0)]).contains("page-noise-large"));
    assert!(!with(&[]).contains("page-not-counted"));
}

/// The chapter of a task whose steps are all done.
fn completed() -> Chapter {
    let mut chapter = chapter("a");
    for (_, done) in &mut chapter.assessed.steps {
        *done = true;
    }
    chapter
}

/// A time of 8 s, at which the bile duct was cut, is no better than the published 68 s.
#[test]
fn published_values_stand_beside_completed_tasks_only() {
    assert!(!html(&[chapter("a")], &Ids).contains("page-published"));
    assert!(html(&[completed()], &Ids).contains("page-published"));
}

#[test]
fn a_rule_about_a_metric_without_a_value_is_neither_met_nor_missed() {
    let mut unused = chapter("a");
    unused.assessed.task = Task::Identify;
    let page = html(&[unused], &Ids);
    let row = "<td>cautery_safe<td>–<td>page-at-least limit=95 %<td>–</tr>";
    assert!(page.contains(row) && !page.contains("NaN"), "{page}");
}

#[test]
fn the_critical_view_is_told_where_a_task_asks_for_it() {
    let told = |task| {
        let shares = crate::view::Criterion {
            achieved: 1.0,
            visible: Some(0.5),
        };
        let mut chapter = chapter("a");
        chapter.assessed.task = task;
        chapter.assessed.cvs = Some(crate::Cvs {
            triangle: shares,
            lower_bed: shares,
            two: shares,
            front: None,
            behind: None,
        });
        html(&[chapter], &Ids).contains("page-view-not-shown-front")
    };
    assert!(told(Task::Identify) && told(Task::Full));
    assert!(!told(Task::Clamp) && !told(Task::Disconnect));
}

#[test]
fn injuries_rules_and_published_values_stand_with_their_source() {
    let mut injured = completed();
    injured.assessed.injuries.push(Injury {
        heat_j: Some(1.25),
        depth_mm: Some(0.5),
        at_s: 3.0,
        kind: InjuryKind::Perforated,
        cause: Cause::Torn,
        severity: Severity::Grave,
        organ: "bile duct".to_owned(),
        ends_task: true,
        source: "<a book>".to_owned(),
    });
    let page = html(&[injured], &Ids);
    for expected in [
        "<td>3.0 s<td class=\"l\">bile duct<td class=\"l\">injury-perforated, 1.2 J, 0.5 mm<td \
         class=\"l\">cause-torn<td class=\"l\">page-ends-task</tr>",
        "<td>bile duct: injury-perforated, 1.2 J, 0.5 mm<td class=\"l\">&lt;a book&gt;</tr>",
        "page-at-least limit=70<td>✗ page-no</tr>",
        "<td>score: page-at-least limit=70<td class=\"l\">page-no-source</tr>",
        "page-pass-and-proficiency",
        "page-injury-note",
        "page-published",
        "18 996 runs at LAP Mentor",
    ] {
        assert!(page.contains(expected), "{expected}");
    }
}

/// A session ended before its end has 0 points, although its table lists fewer lost ones.
#[test]
fn an_unfinished_task_says_why_it_has_no_points_and_names_each_step_once() {
    let open = chapter("a");
    let last = open.assessed.steps.last().unwrap().0.to_string();
    let page = html(&[open], &Ids);
    assert!(page.contains("page-unfinished score=100"), "{page}");
    // The advice about the first open step names it, too.
    assert_eq!(page.matches(&format!("<td>{last}<td>")).count(), 1);
    assert_eq!(page.matches(&format!("<br>{last}")).count(), 0);
    assert!(!page.contains("<br>not done"), "{page}");
    let mut done = completed();
    done.assessed.outcome = crate::Outcome::Passed;
    assert!(!html(&[done], &Ids).contains("page-unfinished"));
}

#[test]
fn a_debrief_names_its_trainee_and_the_page_for_technicians() {
    let of = |name: Option<&str>| {
        let mut chapter = chapter("a");
        chapter.trainee = name.map(str::to_owned);
        chapter.technical = name.map(|_| "report.html".to_owned());
        html(&[chapter], &Ids)
    };
    let named = of(Some("<Lea>"));
    assert!(named.contains("<p class=\"lead\">&lt;Lea&gt; – 2026-11-22"));
    assert!(named.contains("page-technical <a href=\"report.html\">"));
    let nobody = of(None);
    assert!(!nobody.contains("Lea&gt;") && !nobody.contains("page-technical"));
}

#[test]
fn forces_that_the_hand_did_not_feel_are_told() {
    let told = |felt_n, pressed_n| {
        let mut chapter = chapter("a");
        chapter.assessed.metrics.set(Metric::ForceMax, felt_n);
        chapter
            .assessed
            .metrics
            .set(Metric::PressWrongMax, pressed_n);
        html(&[chapter], &Ids).contains("page-unfelt felt=0.0 pressed=2.9")
    };
    assert!(told(0.0, 2.9));
    assert!(!told(2.0, 2.9) && !told(0.0, 0.0));
}

#[test]
fn a_short_path_is_not_shown_as_none() {
    let mut still = chapter("a");
    still.assessed.metrics.set(Metric::Path, 0.003);
    let page = html(&[still], &Ids);
    assert!(page.contains("<td>path_m, m<td>0.003"), "{page}");
}

#[test]
fn a_scripted_session_is_marked_and_in_no_curve() {
    let of = |scripted: [bool; 2]| {
        let both = scripted.map(|is_scripted| Chapter {
            is_scripted,
            past: Vec::new(),
            ..chapter("a")
        });
        html(&both, &Ids)
    };
    let [persons, one] = [of([false; 2]), of([false, true])];
    for told in ["page-scripted-note", "outcome-aborted, page-scripted<"] {
        assert_eq!(persons.matches(told).count(), 0);
        assert_eq!(one.matches(told).count(), 1);
    }
    // A single session has no curve.
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
    assert!(learning_curve(&[1.0], None, "score", &Ids).is_none());
    let curve = learning_curve(&[1.0, 2.0], Some(70.0), "score", &Ids);
    assert!(curve.is_some_and(|curve| curve.contains("page-pass-rule")));
}
