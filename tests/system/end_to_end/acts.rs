//! An instructor acts at a running station: everything is recorded, assessed and replayed.

use std::time::Duration;

use rustix::process::Signal;
use shared_mem::message::{ActMsg, ActReply};
use shared_mem::service::{ActSender, Station};
use shared_mem::words::ActKind;
use system_tests::{
    Program, calot, compiled, finish, said, signal, station_name, summary, turn, wait_until,
};

/// Longest wait for an answer. The station may be busy with its start.
const ANSWER: Duration = Duration::from_secs(5);

/// Starts a headless station with this task and difficulty, and waits until it answers instructors.
fn station(task: &str, difficulty: &str, out: &std::path::Path) -> (Program, ActSender) {
    let name = station_name("acts");
    let mut command = calot();
    command
        .args(["run", "--headless", "--frames", "0", "--seconds", "600"])
        .args(["--scene", &compiled("triangle", None), "--task", task])
        .args(["--difficulty", difficulty, "--station", &name, "--out"])
        .arg(out);
    let program = Program::start(&mut command);
    let station = Station::new(&name).expect("a plain name");
    let sender = ActSender::open(&station).expect("room for an instructor");
    let remark = ActMsg::remark("The session begins").expect("a remark");
    wait_until("an instructor's desk", || {
        sender
            .ask(remark, ANSWER)
            .is_ok_and(|it| it == ActReply::DONE)
    });
    (program, sender)
}

#[test]
fn acts_are_done_recorded_assessed_and_replayed_bit_for_bit() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let (program, instructor) = station("cut", "trainee", &out);
    let ask = |act: ActMsg| instructor.ask(act, ANSWER).expect("an answer");
    let of = |kind| ask(ActMsg::of(kind));
    // The state in which the task begins has clips on duct and artery.
    wait_until("clips to slip off", || {
        of(ActKind::SlippedClip) == ActReply::DONE
    });
    for kind in [
        ActKind::Bleeding,
        ActKind::Fog,
        ActKind::Pause,
        ActKind::Resume,
    ] {
        assert_eq!(of(kind), ActReply::DONE, "{kind:?}");
    }
    assert_eq!(ask(ActMsg::point([0.01, 0.02, 0.03])), ActReply::DONE);
    let remark = ActMsg::remark("Näher heran – افتح الفكين").expect("a remark");
    assert_eq!(ask(remark), ActReply::DONE);
    // Twelve clips at most slip; then there is none left.
    let slips: Vec<u32> = (0..12).map(|_| of(ActKind::SlippedClip)).collect();
    assert_eq!(slips.last(), Some(&ActReply::NOTHING));
    assert_eq!(ask(ActMsg { kind: 77, ..remark }), ActReply::UNKNOWN);
    signal(program.id(), Signal::INT);
    let output = program.finish();
    assert!(output.status.success(), "{}", said(&output));

    let summary = summary(&out);
    let acts = summary["acts"].as_array().expect("acts");
    let kinds: Vec<&str> = acts.iter().filter_map(|it| it["kind"].as_str()).collect();
    for kind in ActKind::ALL {
        assert!(kinds.contains(&kind.name()), "{kind:?} of {kinds:?}");
    }
    let last_remark = acts
        .iter()
        .filter_map(|it| it["remark"].as_str())
        .next_back();
    assert_eq!(last_remark, Some("Näher heran – افتح الفكين"));
    // Blood from a clip that an instructor took off is no unclamped division.
    let alarms = summary["alarms"].as_array().expect("alarms");
    assert!(
        alarms.iter().all(|it| it["kind"] != "unclamped"),
        "{alarms:?}"
    );
    let page = std::fs::read_to_string(out.join("debrief.html")).expect("a debrief");
    assert!(page.contains("<q dir=\"auto\">Näher heran – افتح الفكين</q>"));
    let replayed = finish(calot().arg("replay").arg(&out));
    assert!(replayed.status.success(), "{}", said(&replayed));

    film(&out, folder.path());
}

/// Makes a film of two seconds. Without ffmpeg, the command names it.
fn film(session: &std::path::Path, folder: &std::path::Path) {
    let video = folder.join("film.mkv");
    let mut command = calot();
    command
        .arg("replay")
        .arg(session)
        .arg("--video")
        .arg(&video);
    let output = finish(command.args(["--size", "96x64", "--speed", "8"]));
    if !output.status.success() {
        let said = said(&output);
        assert!(
            said.contains("apt install ffmpeg") || said.contains("adapter"),
            "{said}"
        );
        println!("skipped: {said}");
        return;
    }
    let truth = std::fs::read_to_string(folder.join("film.truth.json")).expect("a side file");
    let truth: serde_json::Value = serde_json::from_str(&truth).expect("JSON");
    let pictures = truth["pictures"].as_u64().expect("a number");
    let acts = truth["acts"].as_array().expect("acts");
    assert!(acts.iter().any(|it| it["kind"] == "remark"), "{acts:?}");
    assert!(acts.iter().all(|it| it["remark"].is_null()), "{acts:?}");
    let moments = truth["moments"].as_array().expect("moments").len() as u64;
    assert!(
        pictures > 0 && moments == pictures.div_ceil(25),
        "{truth:#}"
    );
    let film = std::fs::read(&video).expect("a film");
    assert!(film.starts_with(&[0x1a, 0x45, 0xdf, 0xa3]), "Matroska");
    let beyond = folder.join("beyond.mkv");
    let mut command = calot();
    command
        .arg("replay")
        .arg(session)
        .arg("--video")
        .arg(&beyond);
    let output = finish(command.args(["--from", "3000", "--size", "96x64"]));
    assert_eq!(output.status.code(), Some(1));
    let told = said(&output);
    assert!(
        told.contains("--from 3000 s: the session is") && told.contains("begin earlier"),
        "{told}"
    );
    let files = std::fs::read_dir(folder).expect("a folder");
    let names = files.map(|it| it.expect("a file").file_name());
    let names: Vec<String> = names.map(|it| it.to_string_lossy().into_owned()).collect();
    assert!(
        !names.iter().any(|it| it.contains("beyond")),
        "nothing is left behind: {names:?}"
    );
    let again = finish(
        calot()
            .arg("replay")
            .arg(session)
            .arg("--video")
            .arg(&video),
    );
    assert_eq!(again.status.code(), Some(1));
    assert!(
        said(&again).contains("a film is never replaced"),
        "{}",
        said(&again)
    );
}

#[test]
fn an_exam_takes_remarks_and_refuses_the_rest() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let (program, instructor) = station("cut", "exam", &out);
    for kind in ActKind::ALL.into_iter().filter(|it| *it != ActKind::Remark) {
        let answer = instructor.ask(ActMsg::of(kind), ANSWER).expect("an answer");
        assert_eq!(answer, ActReply::EXAM, "{kind:?}");
    }
    signal(program.id(), Signal::INT);
    let output = program.finish();
    assert!(output.status.success(), "{}", said(&output));
    let summary = summary(&out);
    let acts = summary["acts"].as_array().expect("acts");
    assert!(acts.iter().all(|it| it["kind"] == "remark"), "{acts:?}");
}
