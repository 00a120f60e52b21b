//! Runs a scripted surgeon on a task in the simulation alone, faster than real time. If the file
//! SCENE.calot does not exist, the scene of Calot's triangle is compiled into it. `patient:NAME`
//! and `patient:SEED` stand for a patient, and `phantom` for the phantom, prepared anew. LATE_MS
//! delays what the surgeon sees, as a display would. KEPT.inputs receives the simulation's inputs.
//! In `hang+full`, the surgeon first places the sutures, then performs `full`. In
//! `cleared+identify`, triangle and lower bed are cleared from the start, and the views remain to
//! be shown.
//!
//! ```text
//! cargo run --release -p surgeon --example rehearse -- \
//!     SCENE.calot careful identify 600 [LATE_MS [KEPT.inputs]]
//! ```
#![allow(clippy::print_stdout)] // what it prints is its result

#[path = "../tests/theatre/mod.rs"]
mod theatre;

use std::path::Path;
use std::time::Instant;

use assess::{Metric, Task};
use clap::ValueEnum as _;
use scene_prepare::patient::PREFIX;
use shared_mem::scene::SceneFile;
use shared_mem::words::EventKind;
use surgeon::Surgeon;

/// Prefix of a task's name that makes the surgeon place the sutures first.
const HANGS: &str = "hang+";
/// Prefix of a task's name that begins with triangle and lower bed cleared.
const CLEARED: &str = "cleared+";
/// Period of the progress lines, s.
const SAY_EVERY_S: f64 = 10.0;

/// The scene in this file, or of this patient.
fn scene_of(word: &str) -> SceneFile {
    if let Some(patient) = word.strip_prefix(PREFIX) {
        return theatre::patient(patient);
    }
    if word == "phantom" {
        return theatre::phantom();
    }
    let file = Path::new(word);
    if !file.exists() {
        std::fs::write(file, theatre::triangle_bytes()).expect("it can be written");
    }
    SceneFile::open(file).expect("a compiled scene")
}

/// The best view from a side, in words.
fn view(shown: Option<&assess::Shown>) -> String {
    shown.map_or("none".to_owned(), |it| {
        format!(
            "{:.1}° triangle {:.3} bed {:.3} two {:.3} held {}",
            it.side_deg, it.seen.triangle, it.seen.lower_bed, it.seen.two, it.held
        )
    })
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, surgeon, task, seconds, others @ ..] = words.as_slice() else {
        println!("rehearse SCENE.calot SURGEON TASK SECONDS [LATE_MS [KEPT.inputs]]");
        return;
    };
    let scene = scene_of(scene);
    let surgeon = Surgeon::from_str(surgeon, true).expect("a surgeon");
    let (to_hang, cleared) = (task.strip_prefix(HANGS), task.strip_prefix(CLEARED));
    let task = Task::from_name(to_hang.or(cleared).unwrap_or(task)).expect("a task");
    let start = match (to_hang, cleared) {
        (Some(_), _) => Some(0),
        (_, Some(_)) => theatre::start(Task::Clamp),
        _ => theatre::start(task),
    };
    let seconds: f64 = seconds.parse().expect("seconds");
    let late_ms: f64 = (others.first()).map_or(0.0, |late| late.parse().expect("milliseconds"));
    let times_s = [seconds, late_ms * 1e-3];
    let began = Instant::now();
    let mut said_s = 0.0;
    let result = theatre::work(
        start,
        surgeon,
        task,
        &scene,
        times_s,
        &mut |seen, assessment| {
            for event in &seen.events {
                let is_told = !matches!(
                    EventKind::try_from(event.kind),
                    Ok(EventKind::Removed
                        | EventKind::Burn
                        | EventKind::Electro
                        | EventKind::Contact
                        | EventKind::Release)
                );
                if is_told {
                    println!(
                        "{:8.3} {} organ {} {} by {} at {:.1?} mm",
                        seen.at_s,
                        event.name(),
                        event.organ as i32,
                        event.value,
                        seen.tools.instrument,
                        event.at_m.map(|it| it * 1e3),
                    );
                }
            }
            if seen.at_s - said_s >= SAY_EVERY_S {
                said_s = seen.at_s;
                let status = assessment.status();
                let metrics = assessment.clone().end().metrics;
                let of = |metric| metrics.get(metric);
                let cvs = assessment.clone().end().cvs;
                if let Some(hold) = status.hold {
                    println!("         held {:.2}, {:?}", hold.share, hold.lack);
                }
                if let Some(cvs) = cvs {
                    println!(
                        "         seen at most: triangle {:.3?} bed {:.3?} two {:.3?}; front {}; behind {}",
                        cvs.triangle.visible,
                        cvs.lower_bed.visible,
                        cvs.two.visible,
                        view(cvs.front.as_ref()),
                        view(cvs.behind.as_ref()),
                    );
                }
                println!(
                    "{said_s:6.1} s ({:.0} s) score {:.1} alarms {} triangle {:.3} lower {:.3} bed {:.3} burns {} of {:.1} J, on {:.0} s, in air {:.1} s, force {:.2?}",
                    began.elapsed().as_secs_f64(),
                    status.score,
                    status.alarms,
                    of(Metric::CvsTriangle),
                    of(Metric::CvsBed),
                    of(Metric::Bed),
                    of(Metric::BurnsWrong),
                    of(Metric::BurnWrong),
                    of(Metric::CauteryOn),
                    of(Metric::CauteryAir),
                    seen.tools.force_n,
                );
            }
        },
    );
    if result.shakes > 0 {
        println!("an organ shook: {} reports", result.shakes);
    }
    for line in &result.said {
        println!("said: {line}");
    }
    let assessed = &result.assessed;
    println!(
        "{:?} {:.1} {:?}\n{:?}",
        assessed.outcome, assessed.score, assessed.reasons, assessed.steps
    );
    for lost in &assessed.lost {
        println!("lost {lost:?}");
    }
    for metric in Metric::ALL {
        let value = assessed.metrics.get(metric);
        if value.is_finite() && value != 0.0 {
            println!("{} {value:.3}", metric.name());
        }
    }
    for injury in &assessed.injuries {
        println!("injury {injury:?}");
    }
    println!("{:?}", assessed.cvs);
    for alarm in &assessed.alarms {
        println!("{:8.2} {} {:?}", alarm.at_s, alarm.kind.name(), alarm.organ);
    }
    if let Some(kept) = others.get(1) {
        let (setup, records) = &result.recorded;
        session::inputs_file::write(Path::new(kept), setup, records).expect("it can be written");
        let (_, again) = session::inputs_file::read(Path::new(kept)).expect("it can be read again");
        println!("{} ticks kept in {kept}", again.len());
    }
    println!(
        "{:.1} s simulated in {:.1} s, hash {:016x}",
        result.ticks as f64 * 1e-3,
        began.elapsed().as_secs_f64(),
        result.hash
    );
}
