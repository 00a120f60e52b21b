//! Scripted hands work tasks through the real processes: each injury, each level of skill, each
//! kind of clumsiness. Outcome, alarms, injuries, score, store and debrief are checked.
//!
//! In CI some of them work a short task. The whole table takes an hour and a half, because the
//! processes run in real time: `cargo xtask hands` works it, or the hands and tasks that are named,
//! and keeps their results in `tests/results/hands.csv`. The sessions stay in `target/hands`. They
//! can be looked at there, and judged again after a change of the rules.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use system_tests::{calot, compiled, finish, root, said, station_name, summary, turn};

use crate::silenced::silence_devices;

/// Largest number of attempts of a hand in CI. Tissue lies differently each time, and the machine
/// may be busy.
const TRIES: usize = 3;

/// Tasks, and the time for a hand that works them to the end, s.
const TASKS: [(&str, &str); 7] = [
    ("basics", "120"),
    ("scope", "120"),
    ("identify", "600"),
    ("clamp", "120"),
    ("cut", "150"),
    ("disconnect", "300"),
    ("full", "1200"),
];
/// Time for a hand that makes one error, s.
const ERROR_S: &str = "45";

/// Hands that injure a structure: the structures of which one must be injured, the alarms of which
/// one must sound, and whether the injury ends the task. Tissue that the hook burns half through
/// may tear at its end. Whoever tears the bile duct away tears the hepatic artery with it, within
/// 0.2 s, and the first one ends the task.
const INJURIES: [(&str, &[&str], &[&str], bool); 11] = [
    ("duct-cutter", &["bile duct"], &["cut"], true),
    (
        "duct-tearer",
        &["bile duct", "hepatic artery"],
        &["torn"],
        true,
    ),
    (
        "duct-scorcher",
        &["bile duct"],
        &["perforated", "torn"],
        true,
    ),
    (
        "duct-coagulator",
        &["bile duct"],
        &["perforated", "torn"],
        true,
    ),
    ("duct-puller", &["bile duct"], &["torn"], true),
    ("artery-puller", &["bile duct"], &["torn"], true),
    ("artery-cutter", &["hepatic artery"], &["cut"], true),
    (
        "artery-scorcher",
        &["hepatic artery"],
        &["perforated", "torn"],
        true,
    ),
    ("burner", &["bile duct"], &["burnt"], false),
    ("bowel-burner", &["duodenum"], &["burnt"], false),
    ("bag-burner", &["gallbladder"], &["perforated"], false),
];
/// Hands that work a task to its end. `losing` is the careful one, whose devices fall silent for
/// three seconds.
const WORKERS: [&str; 8] = [
    "careful",
    "learner",
    "novice",
    "hurried",
    "trembling",
    "wandering",
    "pausing",
    LOSING,
];
const LOSING: &str = "losing";

/// The table: tasks, and the hands that work each. Hands that err once do so where their structure
/// is within reach.
const TABLE: [(&str, &str); 8] = [
    ("basics", "careful"),
    (
        "scope",
        "careful learner novice hurried trembling wandering",
    ),
    (
        "clamp",
        "careful learner novice hurried trembling wandering pausing losing dropper duct-puller \
         artery-puller",
    ),
    ("cut", "careful hurried unclamped"),
    ("disconnect", "careful learner novice hurried"),
    (
        "identify",
        "duct-cutter duct-tearer duct-scorcher duct-coagulator artery-cutter artery-scorcher burner \
         bowel-burner bag-burner",
    ),
    (
        "identify",
        "careful learner novice hurried trembling wandering",
    ),
    ("full", "careful learner novice hurried"),
];

/// Result of a hand at a task.
struct Worked {
    summary: Value,
    /// Text of the debrief.
    page: String,
    /// Line of the store about the session.
    listed: String,
}

impl Worked {
    fn outcome(&self) -> &str {
        self.summary["outcome"].as_str().expect("an outcome")
    }

    fn score(&self) -> f64 {
        self.summary["score"].as_f64().expect("a score")
    }

    fn metric(&self, name: &str) -> f64 {
        self.summary["metrics"][name].as_f64().unwrap_or(f64::NAN)
    }

    fn alarms(&self) -> Vec<&str> {
        let alarms = self.summary["alarms"].as_array().expect("alarms");
        alarms.iter().filter_map(|it| it["kind"].as_str()).collect()
    }
}

/// Works a task on Calot's triangle in a folder that is removed afterwards.
fn work(hand: &str, task: &str) -> Worked {
    let folder = tempfile::tempdir().expect("a folder");
    work_in(folder.path(), hand, task)
}

/// Works a task on Calot's triangle. The store and the report from the recording must agree with
/// the summary, and the debrief must tell that a script worked.
fn work_in(folder: &Path, hand: &str, task: &str) -> Worked {
    let _turn = turn();
    let (out, store) = (folder.join("out"), folder.join("kept.sqlite"));
    let station = station_name("hand");
    let is_worker = WORKERS.contains(&hand);
    let whole = TASKS.iter().find(|it| it.0 == task).expect("a task").1;
    let seconds = if is_worker { whole } else { ERROR_S };
    let script = if hand == LOSING { "careful" } else { hand };
    let mut command = calot();
    command
        .args(["run", "--headless", "--frames", "0", "--station", &station])
        .args(["--scene", &compiled("triangle", None), "--task", task])
        .args(["--hand", script, "--seconds", seconds, "--trainee", "Ada"])
        .args(["--new-trainee", "--store"])
        .arg(&store)
        .arg("--out")
        .arg(&out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let run = command.spawn().expect("it starts");
    if hand == LOSING {
        silence_devices(&station, run.id());
    }
    // The longest task takes longer than other tests wait.
    let output = run.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", said(&output));
    let summary = summary(&out);
    let again = asked(calot().arg("report").arg(&out).arg("--json"));
    let again: Value = serde_json::from_str(&again).expect("JSON");
    for key in ["outcome", "score", "metrics", "injuries", "reasons"] {
        assert_eq!(summary[key], again[0][key], "{hand} {task} {key}");
    }
    let mut list = calot();
    let listed = asked(
        list.args(["store", "--store"])
            .arg(&store)
            .args(["list", "Ada"]),
    );
    let page = std::fs::read_to_string(out.join("debrief.html")).expect("a debrief");
    let worked = Worked {
        summary,
        page,
        listed,
    };
    agree(&worked, hand, task);
    worked
}

/// Output of a command that succeeds.
fn asked(command: &mut Command) -> String {
    let output = finish(command);
    assert!(output.status.success(), "{}", said(&output));
    String::from_utf8(output.stdout).expect("text")
}

/// Judges a kept session again, by the present metrics and built-in rules.
fn judge_again(folder: &Path) -> Worked {
    let out = folder.join("out");
    let (rules, page) = (folder.join("rules.toml"), folder.join("again.html"));
    std::fs::write(&rules, asked(calot().args(["report", "--rules-file"]))).expect("it is written");
    let judged = |more: &[&str]| {
        let mut command = calot();
        command.arg("report").arg(&out).arg("--rules").arg(&rules);
        asked(command.args(more))
    };
    let found: Value = serde_json::from_str(&judged(&["--json"])).expect("JSON");
    let page_name = page.to_str().expect("a path in UTF-8");
    judged(&["--overwrite", "--language", "en", "--out", page_name]);
    Worked {
        summary: found[0].clone(),
        page: std::fs::read_to_string(&page).expect("a debrief"),
        listed: String::new(),
    }
}

/// Summary, store and debrief tell the same.
fn agree(it: &Worked, hand: &str, task: &str) {
    let what = format!("{hand} {task}: {:#}", it.summary);
    assert_eq!(it.summary["hand"], "scripted", "{what}");
    let session = it.summary["session"].as_str().expect("a name");
    assert!(it.listed.contains(session), "{what} {}", it.listed);
    assert!(it.listed.contains("by a scripted hand"), "{}", it.listed);
    let outcome = match it.outcome() {
        "passed" => "Passed",
        "failed" => "Failed",
        _ => "Not completed",
    };
    for told in [outcome, "A scripted hand worked this session"] {
        assert!(it.page.contains(told), "{told}: {what}");
    }
    let lost = it.summary["lost"].as_array().expect("lost points");
    let points: f64 = lost.iter().filter_map(|it| it["points"].as_f64()).sum();
    let expected = match it.outcome() {
        // A task that is not completed has no score.
        "aborted" => 0.0,
        _ => (100.0 - points).max(0.0),
    };
    assert!((it.score() - expected).abs() < 1e-6, "{what}");
    if it.outcome() == "passed" {
        assert!(it.score() >= 70.0, "{what}");
    }
}

/// True if the scripted hand caused its injury, made its error or did its task.
fn did(it: &Worked, hand: &str, task: &str) -> bool {
    if let Some((_, organs, alarms, ends_task)) = INJURIES.iter().find(|it| it.0 == hand) {
        let injuries = it.summary["injuries"].as_array().expect("injuries");
        let is_told = |organ: &str| {
            let mut injuries = injuries.iter();
            injuries.any(|it| it["organ"] == organ && it["ends_task"] == *ends_task)
                && it.page.contains(organ)
        };
        return organs.iter().any(|organ| is_told(organ))
            && it.alarms().iter().any(|alarm| alarms.contains(alarm))
            && match ends_task {
                true => it.outcome() == "failed" && it.score() <= 60.0,
                false => it.outcome() != "passed",
            };
    }
    match hand {
        "careful" => it.outcome() == "passed" && it.score() >= 80.0,
        LOSING => {
            it.outcome() == "passed"
                && it.metric("device_lost_s") > 2.0
                && it.page.contains("A device was missing")
        }
        "dropper" => it.alarms().contains(&"clip_lost") && it.outcome() != "passed",
        "unclamped" => {
            // Where duct and artery are divided already, nothing is left to cut.
            let cuts = task != "disconnect";
            it.outcome() != "passed" && (!cuts || it.alarms().contains(&"unclamped"))
        }
        // A device that is late while the hand rests takes that time away.
        "pausing" => it.metric("idle_s") + it.metric("device_lost_s") > 10.0,
        // Its endoscope wanders off, so that it clips, cuts and burns unseen.
        "novice" => task == "scope" || it.outcome() != "passed",
        "hurried" => task != "clamp" || it.outcome() == "failed",
        // Levels and other flaws show in comparison with the careful hand.
        _ => true,
    }
}

/// Works until [`did`] is true, [`TRIES`] times at most.
fn works(hand: &str, task: &str) -> Worked {
    for _ in 0..TRIES {
        let worked = work(hand, task);
        if did(&worked, hand, task) {
            return worked;
        }
        println!("{hand} {task}, again: {:#}", worked.summary);
    }
    panic!("{hand} did not do what it is there for in {TRIES} tries at {task}");
}

#[test]
fn hands_that_tear_or_burn_a_structure_never_pass() {
    for hand in ["duct-tearer", "artery-scorcher", "bowel-burner"] {
        works(hand, "identify");
    }
}

#[test]
fn hands_of_three_levels_score_by_level() {
    let [careful, learner, hurried] =
        ["careful", "learner", "hurried"].map(|it| works(it, "clamp"));
    assert!(careful.score() > learner.score() + 5.0);
    assert!(learner.score() > hurried.score() + 5.0);
    assert_ne!(hurried.outcome(), "passed");
}

/// Columns of the results besides hand and task: metrics of the summary.
const METRICS: [&str; 12] = [
    "time_s",
    "views_held",
    "touches",
    "touches_wrong",
    "press_wrong_max_n",
    "burns_wrong",
    "burn_wrong_j",
    "out_of_view_s",
    "acts_blind",
    "cautery_safe",
    "smoothness",
    "idle_s",
];

/// A row of the results.
fn row(hand: &str, task: &str, it: &Worked) -> String {
    let mut alarms: BTreeMap<&str, usize> = BTreeMap::new();
    for alarm in it.alarms() {
        *alarms.entry(alarm).or_default() += 1;
    }
    let alarms: Vec<String> = alarms
        .iter()
        .map(|(kind, n)| format!("{n} {kind}"))
        .collect();
    let injuries = it.summary["injuries"].as_array().expect("injuries").iter();
    let injuries = injuries.map(|it| {
        let word = |key: &str| it[key].as_str().unwrap_or_default().to_owned();
        format!("{} {}", word("organ"), word("kind"))
    });
    let injuries: Vec<String> = injuries.collect();
    let metrics = METRICS.map(|name| match it.metric(name) {
        value if value.is_finite() => format!("{value:.2}"),
        _ => String::new(),
    });
    format!(
        "{hand},{task},{},{:.1},{},{},{},{}",
        it.outcome(),
        it.score(),
        did(it, hand, task),
        alarms.join("; "),
        injuries.join("; "),
        metrics.join(",")
    )
}

/// Puts a row into the file of results, in the place of an older one of the same hand and task.
fn keep(file: &Path, row: &str) {
    let head = format!(
        "hand,task,outcome,score,as_expected,alarms,injuries,{}",
        METRICS.join(",")
    );
    let before = std::fs::read_to_string(file).unwrap_or_default();
    let key = |row: &str| {
        row.splitn(3, ',')
            .take(2)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let mut rows: Vec<&str> = before
        .lines()
        .skip(1)
        .filter(|it| key(it) != key(row))
        .collect();
    rows.push(row);
    rows.sort_unstable();
    std::fs::write(file, format!("{head}\n{}\n", rows.join("\n"))).expect("it can be written");
}

/// Hands and tasks of the table, or those that are named: `HAND` or `HAND:TASK`, with spaces
/// between them.
fn cells(wanted: &str) -> Vec<(String, String)> {
    let wanted: Vec<&str> = wanted.split_whitespace().collect();
    let of_table = TABLE.iter().flat_map(|(task, hands)| {
        let hands = hands.split_whitespace();
        hands.map(|hand| (hand.to_owned(), (*task).to_owned()))
    });
    let is_wanted =
        |(hand, _): &(String, String)| wanted.is_empty() || wanted.iter().any(|it| it == hand);
    let mut cells: Vec<_> = of_table.filter(is_wanted).collect();
    // A pair need not be in the table.
    cells.extend(wanted.iter().filter_map(|it| {
        let (hand, task) = it.split_once(':')?;
        Some((hand.to_owned(), task.to_owned()))
    }));
    cells
}

/// Folder in which the session of a hand at a task is kept.
fn kept(hand: &str, task: &str) -> PathBuf {
    root().join("target/hands").join(format!("{hand}-{task}"))
}

/// Works the hands and tasks that `CALOT_HANDS` names, or the table. With `CALOT_HANDS_AGAIN`, kept
/// sessions are judged again instead, and cells without one are left out.
#[test]
#[ignore = "an hour and a half of real time for the table: `cargo xtask hands`"]
fn every_hand_works_every_task() {
    let cells = cells(&std::env::var("CALOT_HANDS").unwrap_or_default());
    let again = std::env::var_os("CALOT_HANDS_AGAIN").is_some();
    let file = root().join("tests/results/hands.csv");
    let (mut worked, mut unexpected) = (0, Vec::new());
    for (hand, task) in &cells {
        let folder = kept(hand, task);
        let it = match again {
            true if !folder.exists() => continue,
            true => judge_again(&folder),
            false => {
                // The session of an earlier run makes room.
                let _ = std::fs::remove_dir_all(&folder);
                std::fs::create_dir_all(&folder).expect("a folder in target");
                work_in(&folder, hand, task)
            }
        };
        let row = row(hand, task, &it);
        println!("{row}");
        keep(&file, &row);
        worked += 1;
        if !did(&it, hand, task) {
            unexpected.push(row);
        }
    }
    assert!(worked > 0, "no hand and task of these names: {cells:?}");
    assert!(unexpected.is_empty(), "{unexpected:#?}");
}

#[test]
fn the_table_names_hands_and_tasks_that_there_are() {
    let table = cells("");
    assert!(table.len() > 40, "{}", table.len());
    for (hand, task) in &table {
        assert!(TASKS.iter().any(|it| it.0 == task), "{task}");
        let known = WORKERS.contains(&hand.as_str()) || INJURIES.iter().any(|it| it.0 == hand);
        assert!(
            known || ["dropper", "unclamped"].contains(&hand.as_str()),
            "{hand}"
        );
    }
    for (hand, ..) in INJURIES {
        assert_eq!(cells(hand).len(), 1, "{hand}");
    }
    assert_eq!(
        cells("burner:clamp"),
        [("burner".to_owned(), "clamp".to_owned())]
    );
    assert_eq!(cells("nobody"), []);
}
