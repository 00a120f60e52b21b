//! Sessions recorded by real processes are replayed, and an altered session is recognised.

use std::path::Path;

use rustix::process::Signal;
use shared_mem::message::{CommandMsg, ReplyMsg, StateFrame};
use shared_mem::service::{Host, Station};
use system_tests::{
    PATIENCE, calot, compiled, finish, said, signal, station_name, summary, wait_until,
};

/// Runs the station headless, without pictures, until a session in `out` misses no tick. If the
/// machine keeps a thread waiting for a second, the recorder may lose ticks, and reports that.
fn operate(out: &Path, seconds: &str) -> serde_json::Value {
    for _ in 0..5 {
        let output = finish(
            calot()
                .args(["run", "--headless", "--frames", "0", "--seconds", seconds])
                .args([
                    "--station",
                    &station_name("session"),
                    "--overwrite",
                    "--out",
                ])
                .arg(out),
        );
        assert!(output.status.success(), "{}", said(&output));
        let summary = summary(out);
        let missing = summary["recording"]["missing"].as_u64();
        if missing.expect("a recording") == 0 {
            return summary;
        }
        assert!(said(&output).contains("misses"), "{summary:#}");
    }
    panic!("five runs, and each recording misses ticks");
}

/// Replays a session. Returns exit code, answer and standard error.
fn replay(session: &Path, more: &[&str]) -> (Option<i32>, serde_json::Value, String) {
    let output = finish(calot().args(["replay", "--json"]).arg(session).args(more));
    let answer = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code(), answer, said(&output))
}

#[test]
fn a_session_comes_out_the_same_and_an_altered_one_names_its_tick() {
    let folder = tempfile::tempdir().expect("a folder");
    let summary = operate(folder.path(), "6");
    let session = folder.path().join("session.mcap");
    let recording = &summary["recording"];
    assert_eq!(recording["problem"], serde_json::Value::Null, "{summary:#}");
    let ticks = recording["ticks"].as_u64().expect("ticks");
    let size = std::fs::metadata(&session).expect("a session").len();
    assert_eq!(recording["bytes"], size);

    let tables = folder.path().join("tables");
    let export = |more: &[&str]| {
        let mut command = calot();
        command.args(["export", "--json"]).arg(&session);
        finish(command.arg("--csv").arg(&tables).args(more))
    };
    let exported = export(&[]);
    assert!(exported.status.success(), "{}", self::said(&exported));
    let answer: serde_json::Value = serde_json::from_slice(&exported.stdout).expect("JSON");
    assert_eq!(
        (&answer["same"], &answer["ticks"]),
        (&true.into(), &ticks.into())
    );
    let text = std::fs::read_to_string(tables.join("ticks.csv")).expect("a table");
    let columns = |line: &str| line.split(',').count();
    let head = text.lines().next().expect("a head");
    assert!(head.starts_with("tick,time_s,time_unix_ns,"), "{head}");
    assert_eq!(text.lines().count() as u64, ticks + 1);
    assert!(text.lines().all(|line| columns(line) == columns(head)));
    let meant = std::fs::read_to_string(tables.join("columns.csv")).expect("a table");
    let of_ticks = meant.lines().filter(|line| line.starts_with("ticks,"));
    assert_eq!(of_ticks.count(), columns(head), "each column has a meaning");
    // Tables are replaced only on request.
    assert!(self::said(&export(&[])).contains("--overwrite"));
    assert!(export(&["--overwrite"]).status.success());
    let (code, answer, said) = replay(&session, &[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(answer["same"], true, "{answer:#}");
    assert_eq!(answer["ticks"], ticks);
    assert_eq!(answer["broken_off"], serde_json::Value::Null);
    assert_eq!(answer["controller_ended"], true, "{answer:#}");
    assert_eq!(answer["missing"], 0, "{answer:#}");

    // A session damaged in its middle does not count as equal, and a what-if of it warns.
    let damaged = folder.path().join("damaged.mcap");
    let mut bytes = std::fs::read(&session).expect("a session");
    let middle = bytes.len() - 100_000;
    bytes[middle] ^= 1;
    std::fs::write(&damaged, bytes).expect("written");
    let (code, answer, said) = replay(&damaged, &[]);
    assert_eq!(code, Some(1), "{said}");
    assert_eq!(answer["same"], false, "{answer:#}");
    assert!(answer["damaged"].is_string(), "{answer:#}");
    let compared = answer["ticks"].as_u64().expect("ticks");
    assert!(0 < compared && compared < ticks, "{answer:#}");
    assert!(said.contains("damaged at byte"), "{said}");
    let out = folder.path().join("damaged").display().to_string();
    let (code, answer, said) = replay(&damaged, &["--what-if-iterations", "10", "--out", &out]);
    assert_eq!(code, Some(0), "{said}");
    assert!(answer["damaged"].is_string(), "{answer:#}");
    assert!(said.contains("warning: the session is damaged"), "{said}");

    // After the end of the session there is nothing to show.
    let name = station_name("late");
    let (code, _, said) = replay(
        &session,
        &[
            "--frames",
            "1",
            "--from",
            "1000",
            "--station",
            &name,
            "--overwrite",
            "--out",
            &out,
        ],
    );
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("s long"), "{said}");

    let altered = folder.path().join("altered.mcap");
    let tick = alter(&session, &altered);
    let (code, answer, said) = replay(&altered, &[]);
    assert_eq!(code, Some(1), "{said}");
    assert_eq!(answer["same"], false, "{answer:#}");
    assert_eq!(answer["first_difference"]["tick"], tick, "{answer:#}");
    assert!(said.contains(&format!("tick {tick} ")), "{said}");

    // The same motion of the hands on the paper's solver gives another force, which is charted.
    let out = folder.path().join("what-if");
    let (code, answer, said) = replay(
        &session,
        &[
            "--what-if-iterations",
            "10",
            "--out",
            &out.display().to_string(),
        ],
    );
    assert_eq!(code, Some(0), "{said}");
    let [was, would] = [0, 1].map(|i| answer["force_max_n"][i].as_f64().expect("a force"));
    // On a slow machine the emulated press is weaker, so the test compares one solver with the
    // other.
    assert!((was - would).abs() > 0.1 * was.max(would), "{answer:#}");
    let page = std::fs::read_to_string(out.join("what_if.html")).expect("a page");
    assert_eq!(page.matches("<svg").count(), 4);
    let table = std::fs::read_to_string(out.join("what_if.csv")).expect("a table");
    assert_eq!(table.lines().count() as u64, 1 + ticks.div_ceil(10));

    // Show it on the display, faster and from the first second on.
    let out = folder.path().join("pictures");
    let (code, _, said) = replay(
        &session,
        &[
            "--frames",
            "2",
            "--seconds",
            "2",
            "--from",
            "1",
            "--speed",
            "2",
            "--station",
        ]
        .into_iter()
        .chain([
            station_name("shown").as_str(),
            "--out",
            &out.display().to_string(),
        ])
        .collect::<Vec<_>>(),
    );
    assert_eq!(code, Some(0), "{said}");
    assert!(out.join("frame_0000.png").exists(), "{said}");

    // Another scene is refused, and the error names both.
    let other = compiled("built-in", Some(300));
    let (code, _, said) = replay(&session, &["--scene", &other]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("the session ran on scene"), "{said}");
}

/// Copies a session, moves the handle a little in one tick in its middle, and returns that tick's
/// number. Omits the chunk's checksum, as MCAP allows.
fn alter(session: &Path, to: &Path) -> u64 {
    let mut bytes = std::fs::read(session).expect("a session");
    let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
    // Pairs of a chunk and a message of /inputs (channel 2) whose first tick has a device sample.
    let mut found = Vec::new();
    let mut at = 8;
    while at + 9 < bytes.len() {
        let (opcode, chunk) = (bytes[at], at + 9);
        at = chunk + u64_at(at + 1) as usize;
        if opcode != 6 {
            continue;
        }
        let mut inner = chunk + 28 + 4 + 8; // no compression's name
        while inner < at {
            let (opcode, message) = (bytes[inner], inner + 9);
            inner = message + u64_at(inner + 1) as usize;
            let data = message + 22;
            if opcode == 5 && bytes[message..message + 2] == [2, 0] && bytes[data + 18] & 1 != 0 {
                found.push((chunk, data));
            }
        }
    }
    let (chunk, data) = found[found.len() / 2];
    let first_tick = u64_at(data + 2);
    // A record holds bits, time, two hashes, the hashes of the organs if present, age, and then the
    // handle position.
    let organs = if bytes[data + 21] & 0x20 != 0 { 16 } else { 0 };
    bytes[chunk + 24..chunk + 28].fill(0);
    // The largest of the three coordinates: a small one could change by less than its sum with the
    // handle's origin can hold.
    let x = data + 18 + 16 + organs + 4;
    let coordinate = |at: &usize| f32::from_le_bytes(bytes[*at..at + 4].try_into().expect("four"));
    let magnitude = |at: &usize| coordinate(at).abs();
    let largest = [x, x + 4, x + 8].into_iter();
    let largest = largest.max_by(|a, b| magnitude(a).total_cmp(&magnitude(b)));
    bytes[largest.expect("three coordinates") + 1] ^= 0x10;
    std::fs::write(to, bytes).expect("written");
    first_tick
}

#[test]
fn a_killed_recorder_loses_no_more_than_its_last_seconds() {
    // If the machine keeps a thread waiting for a second, the recording gets a gap. Then try again.
    let whole = (0..5).any(|_| {
        let folder = tempfile::tempdir().expect("a folder");
        let session = folder.path().join("killed.mcap");
        let name = station_name("killed");
        let mut child = calot()
            .args(["run", "--headless", "--frames", "0", "--seconds", "3600"])
            .args(["--station", &name, "--record"])
            .arg(&session)
            .arg("--out")
            .arg(folder.path())
            .spawn()
            .expect("it starts");
        // A growing session can be replayed.
        wait_until("seconds are in the session", || {
            let answer = replay(&session, &[]).1;
            answer["ticks"].as_u64() > Some(2000) || answer["gap_at_tick"].is_number()
        });
        signal(child.id(), Signal::KILL);
        child.wait().expect("it was killed");
        let (code, answer, said) = replay(&session, &[]);
        if answer["gap_at_tick"].is_number() {
            return false;
        }
        assert_eq!(code, Some(0), "{said}");
        assert_eq!(answer["same"], true);
        assert!(answer["ticks"].as_u64() > Some(2000), "{answer:#}");
        assert!(answer["broken_off"].is_string(), "{answer:#}");
        true
    });
    assert!(whole, "five runs, and each recording has a gap");
}

/// Nothing is lost by a command that is given twice, or that names a wrong file.
#[test]
fn a_recording_stays_unless_overwriting_is_asked_for_and_any_other_file_always() {
    let folder = tempfile::tempdir().expect("a folder");
    let [out, session, notes] =
        ["out", "out/session.mcap", "notes.txt"].map(|name| folder.path().join(name));
    let run = |words: &[&str]| {
        let name = station_name("twice");
        let brief = ["run", "--headless", "--frames", "0", "--seconds", "1"];
        let mut calot = calot();
        calot.args(brief).args(["--station", &name]).args(words);
        let output = finish(calot.current_dir(folder.path()));
        (output.status.success(), said(&output))
    };
    assert!(run(&[]).0);
    let first = std::fs::read(&session).expect("recorded");
    std::fs::write(&notes, "notes of a surgeon").expect("written");

    let out = out.display().to_string();
    let (done, why) = run(&["--out", &out]);
    assert!(!done && why.contains("--overwrite"), "{why}");
    for words in [
        &["--record", "notes.txt", "--overwrite"][..],
        &["--record", "notes.txt"],
    ] {
        let (done, why) = run(words);
        assert!(!done && why.contains("never replaced"), "{why}");
    }
    assert!(run(&[]).0, "a name that nobody gave is numbered");
    assert_eq!(std::fs::read(&session).expect("still there"), first);
    assert!(folder.path().join("out-2/session.mcap").exists());
    let kept = std::fs::read_to_string(&notes).expect("still there");
    assert_eq!(kept, "notes of a surgeon");

    assert!(run(&["--out", &out, "--overwrite"]).0);
    assert_ne!(std::fs::read(&session).expect("recorded anew"), first);
}

#[test]
fn file_that_is_no_session_is_refused_with_the_next_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("not.mcap");
    std::fs::write(&path, b"no session at all").expect("written");
    for path in [path, folder.path().join("missing.mcap")] {
        let (code, _, said) = replay(&path, &[]);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("--record"), "{said}");
    }
}

/// State that the replay shows at a time: the tick, and every sphere's bytes.
fn shown_at(host: &Host, at_ms: u32) -> (u64, Vec<u8>) {
    let ask = |kind, argument| {
        let reply = host.command(CommandMsg { kind, argument }, PATIENCE);
        assert_eq!(reply.expect("an answer").outcome, ReplyMsg::DONE);
    };
    ask(CommandMsg::PAUSE, 1);
    let from = standing(host, |_| true).tick;
    ask(CommandMsg::SEEK, at_ms);
    // The tick number depends on the number of missed ticks: on a busy machine a tick is not a
    // millisecond.
    let state = standing(host, |tick| tick != from);
    let spheres = state.spheres().expect("sane");
    (state.tick, bytemuck::cast_slice(spheres).to_vec())
}

/// Waits for a repeated frame of a tick that satisfies `is_it`. While the replay moves to another
/// tick, it shows the frame of the old one.
fn standing(host: &Host, is_it: impl Fn(u64) -> bool) -> Box<StateFrame> {
    let mut state: Box<StateFrame> = bytemuck::zeroed_box();
    let (mut stood, mut before) = (0, None);
    wait_until("it stands", || {
        if host.newest_state(&mut state) {
            stood = match is_it(state.tick) && before == Some(state.tick) {
                true => stood + 1,
                false => 0,
            };
            before = Some(state.tick);
        }
        stood > 3
    });
    state
}

#[test]
fn a_show_goes_to_any_moment_and_finds_it_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    operate(folder.path(), "6");
    let session = folder.path().join("session.mcap");
    let name = station_name("scrubbed");
    let mut child = calot()
        .args([
            "replay",
            "--frames",
            "0",
            "--seconds",
            "3600",
            "--station",
            &name,
        ])
        .arg(&session)
        .arg("--out")
        .arg(folder.path().join("shown"))
        .spawn()
        .expect("it starts");
    let host = Host::open(&Station::new(&name).expect("a name")).expect("a host");
    // First seek ahead, where nothing has run yet; then back and forth among the states kept on the
    // way.
    let straight: Vec<_> = [1500, 3000, 4700].map(|at| shown_at(&host, at)).into();
    for (at_ms, which) in [(1500, 0), (4700, 2), (3000, 1), (1500, 0)] {
        let again = shown_at(&host, at_ms);
        assert_eq!(again.0, straight[which].0, "at {at_ms} ms");
        assert!(
            again == straight[which],
            "at {at_ms} ms the tissue is another"
        );
    }
    assert!(straight[0].1 != straight[2].1, "something moved");
    // A seek beyond the end stops at the end, and an impossible speed is refused.
    let seek = CommandMsg {
        kind: CommandMsg::SEEK,
        argument: u32::MAX,
    };
    let reply = host.command(seek, PATIENCE).expect("an answer");
    assert_eq!(reply.outcome, ReplyMsg::DONE);
    let mut state: Box<StateFrame> = bytemuck::zeroed_box();
    wait_until("its end is shown", || {
        host.newest_state(&mut state) && state.tick > 4900
    });
    let speed = CommandMsg {
        kind: CommandMsg::SPEED,
        argument: 0,
    };
    let reply = host.command(speed, PATIENCE).expect("an answer");
    assert_eq!(reply.outcome, ReplyMsg::OUT_OF_RANGE);
    signal(child.id(), Signal::TERM);
    child.wait().expect("it ends");
}
