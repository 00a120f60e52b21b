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

/// Asserts the forms that latency testers know, and those of the programs that they use.
fn assert_forms(folder: &Path, json: &Value) {
    let maxima = json["intervals_max_ns"].as_array().expect("maxima");
    assert_eq!(maxima.len(), 1, "a short run is one interval");
    assert!(maxima[0].as_u64().is_some_and(|ns| ns > 0));
    assert!(
        json["interval_s"]
            .as_f64()
            .is_some_and(|s| s > 1.0 && s < 300.0)
    );
    assert_eq!(json["ci95"]["turns"]["station"], 1);
    assert!(
        json["ci95"]["wake_latency_ns"]["station"]["p99"].is_null(),
        "one turn has no interval"
    );
    assert_eq!(json["causes"], serde_json::json!([]), "nobody asked why");
    let parts = json["budgets"].as_array().expect("budgets");
    assert_eq!(parts.len(), 8, "wake-up and seven stages");
    let solve = parts
        .iter()
        .find(|part| part["stage"] == "solve")
        .expect("the solver");
    assert!(
        solve["admitted_ns"].as_u64().is_some_and(|ns| ns > 0),
        "{solve}"
    );
    let histograms = folder.join("histograms");
    let text = |name: &str| std::fs::read_to_string(histograms.join(name)).expect("a histogram");
    let percentiles = text("wake_latency_ns.hgrm");
    let count = json["wake_latency_ns"]["count"].as_u64().expect("a count");
    assert!(percentiles.contains("Percentile TotalCount 1/(1-Percentile)"));
    assert!(
        percentiles.contains(&format!("Total count    = {count:12}]")),
        "{percentiles}"
    );
    let like_cyclictest = text("wake_latency_ns.txt");
    assert!(
        like_cyclictest.contains(&format!("# Total: {count:09}")),
        "{like_cyclictest}"
    );
}

#[test]
fn why_names_causes_and_a_scripted_surgeon_works() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("why");
    let more = [
        "--why", "--scene", "triangle", "--hand", "careful", "--load", "cpu",
    ];
    let json = measure(&out, &more);
    // What the kernel permits differs between machines. Each answer must be whole.
    let why = &json["why"];
    let is_coarse = why["is_coarse"].as_bool().expect("a source");
    let name = why["name"].as_str().expect("a name");
    assert_eq!(name == "counters", is_coarse, "{why}");
    assert!(["events", "switches", "counters"].contains(&name), "{why}");
    let missing = why["missing"].as_str().expect("what is missing");
    assert_eq!(missing.is_empty(), name == "events", "{missing}");
    assert_eq!(
        why["events"].as_u64().is_some_and(|n| n > 1000),
        !is_coarse,
        "{why}"
    );
    let causes = json["causes"].as_array().expect("causes");
    let late = why["late_ticks"].as_u64().expect("late ticks");
    assert_eq!(causes.is_empty(), late == 0, "{causes:?}");
    for cause in causes {
        assert!(
            cause["what"].is_string() && cause["name"].is_string(),
            "{cause}"
        );
        assert!(
            cause["ticks"].as_u64().is_some_and(|n| n > 0 && n <= late),
            "{cause}"
        );
        assert!(cause["lost_us"].is_u64(), "{cause}");
    }
    let notes = json["notes"].to_string();
    assert!(
        notes.contains("the scripted surgeon 'careful' worked the task 'full'"),
        "{notes}"
    );
    let page = std::fs::read_to_string(out.join("jitter.html")).expect("a page");
    assert!(page.contains("Why ticks were late") && page.contains("Coarse") == is_coarse);
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
        "motion_to_tick_ns",
        "hand_to_force_ns",
        "hand_to_force_more_ns",
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
    for told in [
        "kernel",
        "command_line",
        "microcode",
        "governor",
        "load_average",
    ] {
        assert!(json["machine"][told].is_string(), "{told}");
    }
    assert_forms(&first, &json);
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
    let parts = &read(&sum.join("jitter.json"))["parts"];
    let names: Vec<_> = parts.as_array().expect("a line for each").iter().collect();
    assert_eq!(names.len(), 2);
    assert_eq!(
        (&names[0]["name"], &names[1]["name"]),
        (&"first".into(), &"second".into())
    );
    assert_eq!(names[1]["load"], "cpu");
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
    refused(
        &["jitter", "--hand", "careful"],
        1,
        &[
            "has no duct, artery or tissue to dissect",
            "--scene triangle",
        ],
    );
    refused(&["jitter", "--task", "clamp"], 2, &["--hand"]);
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
    assert_eq!(findings.len(), 18);
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

#[test]
fn a_comparison_looks_for_rtla_in_the_path() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = tempfile::tempdir().expect("a folder");
    let rtla = folder.path().join("rtla");
    std::fs::write(&rtla, "#!/bin/sh\nprintf 'Index Usr-000\\n3 5\\n'\n").expect("a script");
    std::fs::set_permissions(&rtla, std::fs::Permissions::from_mode(0o755)).expect("a program");
    let own = std::env::var("PATH").expect("a path");
    let compared = |path: &str, out: &str| {
        let _turn = turn();
        let output = finish(
            calot()
                .args([
                    "jitter",
                    "--seconds",
                    "1",
                    "--compare",
                    "sleep",
                    "--rounds",
                    "1",
                ])
                .args(["--json", "--station", &station_name("rtla")])
                .arg("--out")
                .arg(folder.path().join(out))
                .env("PATH", path),
        );
        assert!(output.status.success(), "{}", said(&output));
        let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let took_part = json["rounds"]
            .as_array()
            .expect("rounds")
            .iter()
            .any(|round| round["program"] == "timerlat");
        (took_part, json["notes"].to_string())
    };
    let (took_part, notes) = compared(&own, "without");
    assert!(
        took_part || notes.contains("rtla timerlat did not take part"),
        "{notes}"
    );
    let (took_part, notes) = compared(&format!("{}:{own}", folder.path().display()), "with");
    // The program is there. It takes part only if the kernel has the tracer.
    let tracers = std::fs::read_to_string("/sys/kernel/tracing/available_tracers");
    let has_tracer = tracers.is_ok_and(|it| it.split_whitespace().any(|name| name == "timerlat"));
    assert_eq!(took_part, has_tracer, "{notes}");
    assert!(!notes.contains("sudo apt install rtla"), "{notes}");
    let of_kernel = ["has only these tracers", "tracers cannot be read"];
    let blames = of_kernel.iter().any(|words| notes.contains(words));
    assert_eq!(blames, !has_tracer, "{notes}");
}
