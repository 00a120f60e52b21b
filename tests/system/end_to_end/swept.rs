//! Runtime files that are swept away while a station runs, and shared memory that is too small.

use std::path::Path;
use std::process::Command;

use rustix::process::Signal;
use system_tests::{Program, calot, finish, said, signal, station_name, summary, wait_until};

fn run(name: &str, tmp: &Path, out: &Path) -> Command {
    let mut calot = calot();
    calot
        .args(["run", "--headless", "--seconds", "3600", "--frames", "0"])
        .args(["--station", name])
        .arg("--out")
        .arg(out)
        .env("TMPDIR", tmp);
    calot
}

#[test]
fn a_station_whose_folder_is_removed_reports_and_keeps_its_name() {
    let [tmp, out, beside] = [(); 3].map(|()| tempfile::tempdir().expect("a folder"));
    let name = station_name("swept");
    let first = Program::start(&mut run(&name, tmp.path(), out.path()));
    let user = rustix::process::geteuid().as_raw();
    let folder = tmp.path().join(format!("calot-{user}"));
    // The recording begins once the scene is chosen. It grows once all ends of the services are
    // open.
    let session = out.path().join("session.mcap");
    let length = || std::fs::metadata(&session).map_or(0, |it| it.len());
    wait_until("the station records", || length() > 4096);
    let begun = length();
    wait_until("the recording grows", || length() > begun + 200_000);
    // On a busy machine an end of a service may open late and make the folder again.
    wait_until("the folder stays away", || {
        let _ = std::fs::remove_dir_all(&folder);
        std::thread::sleep(std::time::Duration::from_millis(500));
        !folder.exists()
    });

    let second = finish(&mut run(&name, tmp.path(), beside.path()));
    assert!(!second.status.success());
    assert!(said(&second).contains("runs already"), "{}", said(&second));
    let igtlink = ["igtlink", "--seconds", "1", "--station", &name];
    let told = finish(calot().args(igtlink).env("TMPDIR", tmp.path()));
    assert!(!told.status.success());
    assert!(said(&told).contains("TMPDIR"), "{}", said(&told));

    signal(first.id(), Signal::INT);
    let first = first.finish();
    assert!(first.status.success(), "{}", said(&first));
    assert!(summary(out.path())["ticks"].as_u64() > Some(0));
    assert!(out.path().join("report.html").exists());
}

#[test]
fn a_temporary_folder_that_is_not_there_is_blamed_itself() {
    let out = tempfile::tempdir().expect("a folder");
    let refused = finish(&mut run(
        &station_name("none"),
        Path::new("/none"),
        out.path(),
    ));
    let said = said(&refused);
    assert!(
        said.contains("TMPDIR") && !said.contains("--station"),
        "{said}"
    );
}

/// The station runs in a mount namespace with a small shared memory of its own.
#[test]
fn a_station_without_room_in_shared_memory_says_so_at_once() {
    let tried = Command::new("unshare").args(["-m", "true"]).output();
    if !tried.is_ok_and(|it| it.status.success()) {
        println!("skipped: no mount namespace here");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for size in ["1m", "8m"] {
        let inner = run(&station_name("small"), folder.path(), folder.path());
        let mount = format!("mount -t tmpfs -o size={size} none /dev/shm; exec \"$0\" \"$@\"");
        let mut outer = Command::new("unshare");
        outer
            .args(["-m", "sh", "-c", &mount])
            .arg(inner.get_program());
        outer.args(inner.get_args()).env("TMPDIR", folder.path());
        let refused = finish(&mut outer);
        assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
        assert!(said(&refused).contains("--shm-size"), "{}", said(&refused));
    }
}
