//! `calot jitter` and `calot check` as a latency tester runs them: through the real program.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use system_tests::{calot, finish, said, station_name, turn, wait_until};

/// Measures briefly into `out` and returns the printed JSON. On a busy machine an emulated device
/// may not answer in time, or the whole machine stands still; then it measures once more.
fn measure(out: &Path, more: &[&str]) -> Value {
    let _turn = turn();
    let run = || {
        finish(
            calot()
                .args(["jitter", "--seconds", "2", "--json", "--station"])
                .arg(station_name("jitter"))
                .arg("--out")
                .arg(out)
                .args(more),
        )
    };
    let mut output = run();
    if !output.status.success() {
        println!("once more: {}", said(&output));
        output = run();
    }
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).expect("--json prints JSON")
}

fn read(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).expect("it was written");
    serde_json::from_str(&text).expect("it is JSON")
}

/// Asserts that the quantiles rise and that there is at least one count.
fn assert_distribution(times: &Value, name: &str) {
    let of = |key: &str| {
        times[key]
            .as_u64()
            .unwrap_or_else(|| panic!("{name} has no {key}"))
    };
    let rising = ["p50", "p90", "p99", "p999", "p9999", "max"].map(of);
    assert!(rising.is_sorted(), "{name}: {rising:?}");
    assert!(of("count") > 0, "{name} is empty");
}

#[test]
fn figures_are_named_as_in_summary_json_and_runs_add_up_and_compare() {
    let folder = tempfile::tempdir().expect("a folder");
    let [first, second, sum] = ["first", "second", "sum"].map(|name| folder.path().join(name));
    let printed = measure(&first, &["--compare", "sleep,burn", "--rounds", "1"]);
    let json = read(&first.join("jitter.json"));
    assert_eq!(json, printed);
    assert_eq!(json["complete"], true);
    assert!(
        json["seconds"].as_f64().is_some_and(|s| s >= 1.9),
        "{}",
        json["seconds"]
    );
    for name in [
        "wake_latency_ns",
        "period_ns",
        "tick_ns",
        "motion_to_force_ns",
        "force_to_publish_ns",
        "publish_to_display_ns",
    ] {
        assert_distribution(&json[name], name);
    }
    for stage in [
        "sample",
        "tool",
        "contact",
        "solve",
        "force",
        "procedure",
        "publish",
    ] {
        assert_distribution(&json["stage_ns"][stage], stage);
    }
    assert_distribution(&json["sleep"]["wake_latency_ns"], "sleep");
    // The comparison loop `burn` worked as long as the station's ticks. The report separates the
    // misses of both by cause.
    assert_distribution(&json["burn"]["tick_ns"], "burn");
    for kind in ["periods", "woken_late", "at_work", "occasions", "overruns"] {
        for key in ["station", "burn", "difference_low", "difference_high"] {
            let figure = &json["misses_to_burn"][kind][key];
            assert!(figure.is_number(), "{kind} {key}: {figure}");
        }
    }
    let (ticks, misses) = (json["ticks"].as_u64(), json["deadline_misses"].as_u64());
    assert!(
        ticks.zip(misses).is_some_and(|(t, m)| t + m >= 1900),
        "{ticks:?} {misses:?}"
    );
    assert_eq!(json["allocations_after_start"], 0);
    assert!(json["misses_per_million"].is_number() && json["realtime"].is_boolean());
    assert!(json["machine"]["kernel"].is_string());
    // The solver's time is part of the tick's.
    assert!(json["stage_ns"]["solve"]["p50"].as_u64() < json["tick_ns"]["p50"].as_u64());

    let csv = std::fs::read_to_string(first.join("jitter.csv")).expect("a table");
    assert!(
        csv.starts_with("name,count,p50,p90,p99,p999,p9999,max\nwake_latency_ns,"),
        "{csv}"
    );
    let page = std::fs::read_to_string(first.join("jitter.html")).expect("a page");
    assert!(page.contains("<svg") && page.ends_with("</html>\n"));
    let trace = read(&first.join("jitter.trace.json"));
    let slices = trace["traceEvents"].as_array().expect("events");
    assert!(slices.iter().any(|event| event["name"] == "solve"));

    measure(&second, &["--no-realtime", "--load", "cpu"]);
    let json = read(&second.join("jitter.json"));
    assert_eq!(
        json["realtime"], false,
        "not realtime is said in every report"
    );
    assert_eq!(json["load"], serde_json::json!(["cpu"]));
    let page = std::fs::read_to_string(second.join("jitter.html")).expect("a page");
    assert!(page.contains("Not realtime"));

    let merged = finish(
        calot()
            .arg("jitter")
            .arg("--merge")
            .args([&first, &second])
            .arg("--out")
            .arg(&sum),
    );
    assert!(merged.status.success(), "{}", said(&merged));
    assert!(String::from_utf8_lossy(&merged.stdout).contains("NOT REALTIME"));
    let count = |path: &Path| read(&path.join("jitter.json"))["wake_latency_ns"]["count"].as_u64();
    assert_eq!(
        count(&sum),
        count(&first).zip(count(&second)).map(|(a, b)| a + b)
    );

    let compared = finish(
        calot()
            .args(["jitter", "--json", "--diff"])
            .args([&first, &second]),
    );
    assert!(compared.status.success(), "{}", said(&compared));
    let difference: Value = serde_json::from_slice(&compared.stdout).expect("JSON");
    assert!(
        difference["wake_latency_ns"]["ratio"]["p50"]
            .as_f64()
            .is_some_and(|r| r > 0.0)
    );
    let same = finish(
        calot()
            .args(["jitter", "--json", "--diff"])
            .args([&first, &first]),
    );
    let same: Value = serde_json::from_slice(&same.stdout).expect("JSON");
    assert_eq!(same["tick_ns"]["ratio"]["p999"], 1.0);
}

#[test]
fn a_killed_run_leaves_what_it_had() {
    for (signal, name) in [("-KILL", "killed"), ("-TERM", "ended")] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut running = calot()
            .args(["jitter", "--seconds", "600", "--station"])
            .arg(station_name(name))
            .arg("--out")
            .arg(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let file = folder.path().join("jitter.json");
        wait_until("results are written", || {
            file.exists() && read(&file)["wake_latency_ns"]["count"] != 0
        });
        let pid = running.id().to_string();
        let sent = Command::new("kill").args([signal, &pid]).status();
        assert!(sent.expect("there is a kill").success());
        running.wait().expect("it can be waited for");
        let json = read(&file);
        assert_eq!(json["complete"], false, "{signal}");
        assert_distribution(&json["wake_latency_ns"], "wake_latency_ns");
        assert!(folder.path().join("jitter.html").exists());
        let again = finish(
            calot()
                .args(["jitter", "--diff"])
                .args([folder.path(), folder.path()]),
        );
        let said = said(&again);
        assert!(again.status.success(), "{signal}: cannot be read: {said}");
    }
}

#[test]
fn options_that_cannot_be_measured_are_refused_by_name() {
    let refused = |args: &[&str], code: i32, words: &[&str]| {
        let output = finish(calot().args(args));
        let said = said(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
        for word in words {
            assert!(
                said.contains(word),
                "{args:?}: expected '{word}' in: {said}"
            );
        }
    };
    refused(&["jitter", "--load", "coffee"], 2, &["coffee", "cpu"]);
    refused(
        &["jitter", "--compare", "x"],
        2,
        &["cyclictest", "embassy-std"],
    );
    refused(&["jitter", "--diff", "one"], 2, &["--diff"]);
    refused(
        &["jitter", "--diff", "/nowhere/a", "/nowhere/b"],
        1,
        &["/nowhere/a", "calot jitter --out"],
    );
    refused(&["jitter", "--seconds", "0"], 2, &["0.1 to 86400"]);
    refused(
        &["rt", "--scene", "x", "--scope-line", "rts"],
        2,
        &["--scope-tty"],
    );
    let (folder, station) = (
        tempfile::tempdir().expect("a folder"),
        station_name("scope"),
    );
    let out = folder.path().to_str().expect("a plain path");
    let no_line = [
        "--scope-line",
        "dtr",
        "--scope-tty",
        "/dev/null",
        "--out",
        out,
        "--station",
        &station,
    ];
    refused(
        &[&["jitter"], &no_line[..]].concat(),
        1,
        &["/dev/null", "UART"],
    );
}

#[test]
fn check_tells_what_is_and_mends_and_its_exit_code_is_its_verdict() {
    let output = finish(calot().args(["check", "--json"]));
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let fit = json["fit"].as_bool().expect("a verdict");
    assert_eq!(output.status.code(), Some(i32::from(!fit)));
    let findings = json["findings"].as_array().expect("findings");
    assert_eq!(findings.len(), 17);
    for finding in findings {
        for key in ["name", "is", "should"] {
            assert!(
                finding[key].as_str().is_some_and(|s| !s.is_empty()),
                "{finding}"
            );
        }
    }
    let bad = findings.iter().any(|finding| finding["verdict"] == "bad");
    assert_eq!(bad, !fit);
    let words = finish(calot().arg("check"));
    assert_eq!(words.status.code(), output.status.code());
    let install = finish(calot().args(["check", "--install"]));
    assert!(install.status.success());
    let script = String::from_utf8_lossy(&install.stdout).into_owned();
    assert!(script.contains("LimitRTPRIO") && script.contains("latency_timer"));
}
