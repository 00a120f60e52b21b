//! A study of scripted surgeons of two levels of skill, compared by the real command: their
//! sessions come from the simulation alone. A third hand gets to no end.

use assess::{Assessed, Metric, Outcome, Task};
use shared_mem::scene::SceneFile;
use statistics::compare;
use store::{Circumstances, Hand, SessionRecord, Store};
use surgeon::Surgeon;
use system_tests::{calot, compiled, finish, said};

#[expect(
    dead_code,
    reason = "other tests ask more of a theatre than the result"
)]
#[path = "../../../display-host/surgeon/tests/theatre/mod.rs"]
mod theatre;

/// Levels of skill in the endoscope drill, the best first: the hand, and the cohort's name.
const LEVELS: [(Surgeon, &str); 2] = [
    (Surgeon::Careful, "expert"),
    (Surgeon::Trembling, "trained"),
];
/// Delay with which each person of a level sees the picture, s: no two work alike. With four
/// persons in each group, groups that do not overlap have p = 0.029.
const LATE_S: [f64; 4] = [0.0, 0.003, 0.008, 0.009];
/// Time that everybody gets, s. A novice's picture wanders off before an organ has been held, so no
/// novice comes to the end.
const TIME_S: f64 = 75.0;

/// Room for the state of a simulation, which is larger than a test's usual stack.
const STACK_BYTES: usize = 64 << 20;

fn drill(surgeon: Surgeon, scene: &SceneFile, times_s: [f64; 2]) -> Assessed {
    std::thread::scope(|threads| {
        let work = || {
            let watch = &mut |_: &_, _: &_| {};
            theatre::work(None, surgeon, Task::Scope, scene, times_s, watch).assessed
        };
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        let thread = thread.spawn_scoped(threads, work).expect("a thread");
        thread.join().expect("it works")
    })
}

fn record(assessed: &Assessed) -> SessionRecord {
    let metrics = Metric::ALL.into_iter().filter_map(|metric| {
        let value = assessed.metrics.get(metric);
        value.is_finite().then(|| (metric.name().to_owned(), value))
    });
    SessionRecord {
        id: store::new_id(),
        began_unix_s: 1_790_000_000,
        task: assessed.task.name().to_owned(),
        difficulty: assessed.difficulty.name().to_owned(),
        outcome: assessed.outcome.name().to_owned(),
        score: assessed.score,
        alarms: assessed.alarms.len() as i64,
        metrics_version: assessed.version,
        metrics: metrics.collect(),
        scene: "triangle".to_owned(),
        program: "a test".to_owned(),
        file: None,
        hand: Hand::Scripted,
        circumstances: Circumstances::default(),
    }
}

/// Scores of each cohort, from the study's table.
fn scores(table: &str) -> [Vec<f64>; 2] {
    LEVELS.map(|(_, cohort)| {
        let rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
        let own = rows.filter(|row| row.get(3) == Some(&cohort));
        own.filter_map(|row| row.get(6)?.parse().ok()).collect()
    })
}

#[test]
fn a_study_separates_levels_of_skill() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("store.sqlite");
    let scene = SceneFile::open(compiled("triangle", None).as_ref()).expect("a scene");
    let mut store = Store::open(&file).expect("a store");
    for (surgeon, cohort) in LEVELS {
        for (number, late_s) in LATE_S.into_iter().enumerate() {
            let times_s = [TIME_S, late_s];
            let assessed = &drill(surgeon, &scene, times_s);
            println!(
                "{cohort} {number}: {:?} {:.1} {:?}",
                assessed.outcome, assessed.score, assessed.lost
            );
            assert_ne!(assessed.outcome, Outcome::Aborted, "{:?}", assessed.reasons);
            let name = format!("{cohort} {number}");
            store
                .enrol(&name, Some(cohort), None, 0)
                .expect("a new trainee");
            store
                .add_session(&name, &record(assessed))
                .expect("a new session");
        }
    }
    drop(store);
    let novice = drill(Surgeon::Wandering, &scene, [TIME_S, 0.0]);
    assert_eq!(novice.outcome, Outcome::Aborted, "it wanders off");
    let out = folder.path().join("study");
    let mut study = calot();
    study
        .args(["store", "study", "--by", "cohort", "--scripted", "--store"])
        .arg(&file)
        .arg("--out")
        .arg(&out);
    let output = finish(&mut study);
    assert!(output.status.success(), "{}", said(&output));
    let table = std::fs::read_to_string(out.join("study.csv")).expect("a table");
    let found = compare(&scores(&table));
    assert_eq!(found.n, [LATE_S.len(); 2], "{table}");
    assert!(found.p < 0.05 && found.delta > 0.99, "{found:?}\n{table}");
    let page = std::fs::read_to_string(out.join("study.html")).expect("a page");
    assert!(page.contains("Scripted hands are among these sessions"));
    for (_, cohort) in LEVELS {
        assert!(
            page.contains(&format!("<td>{cohort}<td>4<td>4")),
            "{cohort}"
        );
    }
}
