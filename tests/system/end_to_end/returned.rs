//! A device in use is refused to another program. The device vanishes, and another device or itself
//! returns.

use std::fs::{self, File};
use std::path::Path;
use std::process::Stdio;

use bytemuck::Zeroable as _;
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::service::{Host, Station};
use system_tests::{calot, compiled, finish, station_name, wait_until};

use crate::devices::Emulated;

/// True if the process has `line` open, even if the line no longer exists.
fn has_open(process: u32, line: &Path) -> bool {
    let files = fs::read_dir(format!("/proc/{process}/fd")).expect("it runs");
    files.flatten().any(|file| {
        let file = fs::read_link(file.path()).unwrap_or_default();
        let file = file.to_string_lossy().replace(" (deleted)", "");
        Path::new(&file) == line
    })
}

#[test]
fn a_lost_line_is_closed_and_another_device_in_its_place_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let emulated = Emulated::start(folder);
    let (haptic, stderr) = (folder.join("haptic"), folder.join("said"));
    let name = station_name("returned");
    let rt = calot()
        .args(["rt", "--no-realtime", "--station", &name, "--scene"])
        .arg(compiled("built-in", None))
        .arg("--haptic")
        .arg(&haptic)
        .stdout(Stdio::null())
        .stderr(File::create(&stderr).expect("a file"))
        .spawn();
    let rt = Emulated(rt.expect("it starts"));
    let process = rt.0.id();
    let tells = |what: &str| fs::read_to_string(&stderr).is_ok_and(|it| it.contains(what));

    wait_until("the lines are open", || {
        let line = haptic.canonicalize();
        line.is_ok_and(|line| has_open(process, &line))
    });
    let host = Station::new(&name).and_then(|it| Host::open(&it));
    let host = host.expect("a host");
    let mut tools = ToolFrame::zeroed();
    let mut becomes = |status| {
        wait_until("the device's health", || {
            host.newest_tools(&mut tools) && tools.health[0].status == status
        });
    };
    becomes(DeviceHealth::LIVE);
    let line = haptic.canonicalize().expect("a line");
    let second = finish(calot().args(["devices", "conformance"]).arg(&haptic));
    let second = String::from_utf8_lossy(&second.stdout);
    assert!(
        second.contains(&format!("calot (process {process})")),
        "{second}"
    );

    drop(emulated);
    wait_until("it is told", || tells("lost: haptic device"));
    wait_until("the dead line is closed", || !has_open(process, &line));
    becomes(DeviceHealth::LOST);

    let other = Emulated::led(folder, &["--mistake", "delay-undeclared"]);
    wait_until("it is refused", || {
        tells("is another device now (its limits differ)")
    });
    becomes(DeviceHealth::LOST);
    drop(other);

    let emulated = Emulated::start(folder);
    wait_until("it is used again", || tells("back: haptic device"));
    becomes(DeviceHealth::LIVE);
    drop((rt, emulated));
}
