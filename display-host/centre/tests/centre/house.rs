//! A centre with its keys, and recordings that play stations.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use crate::page::Page;
use crate::support::{Centre, centre_program, make_keys};

/// Keys, a list and a running centre, in a folder that is removed with them.
pub(crate) struct House {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) centre: Centre,
}

impl House {
    pub(crate) fn open(members: &[&str], listed: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let members: Vec<String> = members.iter().map(|it| (*it).to_owned()).collect();
        make_keys(folder.path(), "centre", &members);
        let centre = Centre::start(folder.path(), listed);
        Self { folder, centre }
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn page(&self) -> Page {
        Page::open(&self.centre, &self.file("ca.pem"))
    }

    /// Plays a recording as these stations.
    pub(crate) fn rehearse(&self, recording: &Path, names: &[&str]) -> Command {
        self.rehearse_at(&self.centre.stations, recording, names)
    }

    /// Plays a recording as these stations, which connect to this address.
    pub(crate) fn rehearse_at(&self, address: &str, recording: &Path, names: &[&str]) -> Command {
        let mut command = centre_program();
        command
            .arg("rehearse")
            .arg(recording)
            .args(["--connect", address]);
        command.arg("--keys");
        names.iter().for_each(|it| {
            command.arg(self.file("keys").join(it));
        });
        command
    }
}

/// An alarm: station, operation, number.
pub(crate) type Sent = (String, u64, u64);

/// A frame as `calot tell` writes it.
fn frame(kind: u8, body: &[u8]) -> Vec<u8> {
    let length = u32::try_from(body.len()).expect("short");
    [&[kind], &length.to_le_bytes()[..], body].concat()
}

/// A recording of 8 s with an alarm in each of the first 5 s, and a picture with each state.
pub(crate) fn recording(file: &Path) {
    let picture = include_bytes!("picture.jpg");
    let mut bytes = Vec::new();
    for half in 0..16 {
        bytes.extend(frame(
            b's',
            state(half, (half / 2).min(5)).to_string().as_bytes(),
        ));
        bytes.extend(frame(b't', picture));
        bytes.extend(frame(b'v', picture));
    }
    std::fs::write(file, bytes).expect("written");
}

/// A recording of an hour with 30 alarms in its first minute, without pictures.
pub(crate) fn long_recording(file: &Path) {
    let states = (0..7200).flat_map(|half| {
        let state = state(half, (half / 4).min(30));
        frame(b's', state.to_string().as_bytes())
    });
    std::fs::write(file, states.collect::<Vec<u8>>()).expect("written");
}

/// State after this many half seconds, with this many alarms.
fn state(half: u64, alarms: u64) -> Value {
    let said = |text: &str| json!({"en": text, "de": text});
    let text = json!({"en": "burnt: liver", "de": "verbrannt: Leber"});
    let alarm = |number| json!({"number": number, "at_s": 1.0, "text": text});
    json!({
        "operation": 1, "trainee": null, "running": true, "paused": false, "realtime": true,
        "ticks": 1000 + half * 500, "missed": 0, "late": 0, "device": "live",
        "task": {
            "name": "clamp", "difficulty": "exam", "title": said("Clip"), "time_s": half as f64 / 2.0,
            "score": 90.0, "step": said("clip the artery"), "steps_done": 1, "steps": 4,
            "passed": null, "end": null,
        },
        "alarms": alarms, "newest_alarms": (1..=alarms).map(alarm).collect::<Vec<_>>(),
    })
}

/// Alarms that a rehearsal says it sent, as (station, operation, number), with their times, ms.
pub(crate) fn sent(output: &Path) -> BTreeMap<Sent, u64> {
    let text = std::fs::read_to_string(output).expect("its output");
    let lines = text
        .lines()
        .filter_map(|it| serde_json::from_str::<Value>(it).ok());
    lines
        .map(|it| (of(&it, &it), it["sent_unix_ms"].as_u64().expect("a time")))
        .collect()
}

/// Alarms in a centre's log, with the times of their arrival, ms. Each is there once.
pub(crate) fn heard(centre: &Centre) -> BTreeMap<Sent, u64> {
    let mut found = BTreeMap::new();
    for it in centre.logged("alarm") {
        let at = it["at_unix_ms"].as_u64().expect("a time");
        let known = found.insert(of(&it, &it["detail"]), at);
        assert_eq!(known, None, "it came twice: {it}");
    }
    found
}

fn of(station: &Value, alarm: &Value) -> Sent {
    let number = |name: &str| alarm[name].as_u64().expect("a number");
    let station = station["station"].as_str().expect("a station").to_owned();
    (station, number("operation"), number("number"))
}
