//! Devices fall silent in the middle of a task and come back: outcome, alarms, score, store and
//! debrief.

use std::time::Duration;

use bytemuck::Zeroable as _;
use rustix::process::Signal;
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::service::{Host, Station};
use system_tests::{
    Program, calot, compiled, finish, processes, said, signal, station_name, summary, turn,
    wait_until,
};

/// Time for which the devices are silent.
const SILENT: Duration = Duration::from_secs(3);

/// Stops the emulated devices of a run for a while, from its seventh second on. Returns once they
/// are live again.
pub(super) fn silence_devices(station: &str, run: u32) {
    let host = Station::new(station).and_then(|it| Host::open(&it));
    let host = host.expect("a host");
    let mut tools = ToolFrame::zeroed();
    let mut becomes = |is_live: bool| {
        wait_until("the health of the haptic device", || {
            host.newest_tools(&mut tools)
                && tools.tick > 6000
                && (tools.health[0].status == DeviceHealth::LIVE) == is_live
        });
    };
    becomes(true);
    let emulate = processes(&["emulate", "--with-parent", &run.to_string()]);
    let emulate = *emulate.first().expect("the devices are emulated");
    signal(emulate, Signal::STOP);
    becomes(false);
    std::thread::sleep(SILENT);
    signal(emulate, Signal::CONT);
    becomes(true);
}

/// A careful surgeon loses haptic device, tracker and pedal for three seconds. The result states
/// this time, and does not count it as the trainee's. It causes no alarm or injury, and the session
/// is kept as scripted.
#[test]
fn a_surgeon_who_loses_the_devices_is_told_so_and_loses_no_points_for_it() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let (out, store) = (folder.path().join("out"), folder.path().join("kept.sqlite"));
    let name = station_name("silenced");
    let mut command = calot();
    command
        .args(["run", "--headless", "--frames", "0", "--station", &name])
        .args(["--scene", &compiled("triangle", None)])
        .args(["--task", "clamp", "--hand", "careful", "--seconds", "16"])
        .args(["--trainee", "Ada", "--new-trainee", "--store"])
        .arg(&store)
        .arg("--out")
        .arg(&out);
    let run = Program::start(&mut command);
    silence_devices(&name, run.id());
    let output = run.finish();
    assert!(output.status.success(), "{}", said(&output));
    let summary = summary(&out);
    let of = |metric: &str| summary["metrics"][metric].as_f64();
    let lost_s = of("device_lost_s").expect("it is measured");
    // The connection takes its time to come back.
    assert!((2.0..9.0).contains(&lost_s), "{summary:#}");
    // On a busy machine, the session runs longer than it was told to.
    let ran_s = summary["ticks"].as_f64().expect("ticks") / 1000.0;
    assert!(of("time_s") < Some(ran_s - lost_s + 0.5), "{summary:#}");
    assert_eq!(summary["outcome"], "aborted", "{summary:#}");
    for of_tissue in ["injuries", "alarms"] {
        let told = summary[of_tissue].as_array().map(Vec::len);
        assert_eq!(told, Some(0), "{of_tissue}: {summary:#}");
    }
    assert_eq!(summary["hand"], "scripted");
    let page = std::fs::read_to_string(out.join("debrief.html")).expect("a debrief");
    assert!(page.contains("A device was missing"), "it is told");
    let list = finish(
        calot()
            .args(["store", "--store"])
            .arg(&store)
            .args(["list", "Ada"]),
    );
    let listed = String::from_utf8_lossy(&list.stdout).into_owned();
    let session = summary["session"].as_str().expect("a name");
    assert!(listed.contains(session), "{listed}");
    let report = finish(calot().arg("report").arg(&out).arg("--json"));
    let again: serde_json::Value = serde_json::from_slice(&report.stdout).expect("JSON");
    for key in ["outcome", "score", "metrics"] {
        assert_eq!(summary[key], again[0][key], "{key}");
    }
}
