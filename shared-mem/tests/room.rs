//! Tests shared memory that is too small, belongs to another user, is removed while in use, or was
//! left by a crash.
//!
//! Each process of a test is this test program, which the test starts again with a role.
#![allow(clippy::unwrap_used)]

use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use shared_mem::service::{Controller, HandReceiver, Host, ServiceError, Station, Tap};

/// Environment variable that gives a test's process its role.
const ROLE: &str = "CALOT_TEST_ROLE";
/// Environment variable that gives a test's process the name of its station.
const STATION: &str = "CALOT_TEST_STATION";

fn name(test: &str) -> String {
    format!("r{}-{test}", std::process::id())
}

/// The main function of a test's process; it is not a test itself. It prints the result of its
/// role. If it opened ends, it then waits until its standard input is closed.
#[test]
fn role() {
    let Ok(role) = std::env::var(ROLE) else {
        return;
    };
    let hold = |ends: Result<Box<dyn std::any::Any>, ServiceError>| match ends {
        Ok(ends) => {
            println!("\nSAID open");
            let _ = std::io::stdin().read_line(&mut String::new());
            drop(ends);
        }
        Err(error) => println!("\nSAID {error}"),
    };
    let station = match Station::new(&std::env::var(STATION).unwrap()) {
        Ok(station) => station,
        Err(error) => return println!("\nSAID {error}"),
    };
    match role.as_str() {
        "controller" => hold(Controller::open(&station).map(|it| Box::new(it) as _)),
        "host" => hold(Host::open(&station).map(|it| Box::new(it) as _)),
        "all" => hold((|| {
            let tap = Tap::open(&station)?;
            let hand = HandReceiver::open(&station)?;
            let controller = Controller::open(&station)?;
            let host = Host::open(&station)?;
            Ok(Box::new((tap, hand, controller, host)) as _)
        })()),
        "claim" => {
            let who = |inode| format!("the socket {inode:?}");
            hold(station.claim(who).map(|it| Box::new(it) as _));
        }
        other => panic!("no role {other}"),
    }
}

/// A process with a role, and the result that it printed.
struct TestProcess {
    child: Child,
    result: String,
}

impl TestProcess {
    fn start(role: &str, station: &str, tmp: &Path) -> Self {
        Self::start_in(&[], role, station, tmp)
    }

    /// Starts the process through another program. `wrapper` is that program's command line.
    fn start_in(wrapper: &[&str], role: &str, station: &str, tmp: &Path) -> Self {
        let mut child = Self::spawn(wrapper, role, station, tmp);
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let result = lines.find_map(|line| line.unwrap().strip_prefix("SAID ").map(str::to_owned));
        // The pipe must be read to its end, because the test harness also writes to it.
        std::thread::spawn(move || lines.for_each(drop));
        let result = result.unwrap_or_else(|| format!("died: {:?}", child.wait()));
        Self { child, result }
    }

    fn spawn(wrapper: &[&str], role: &str, station: &str, tmp: &Path) -> Child {
        let own = std::env::current_exe().unwrap();
        let own = own.to_str().unwrap();
        let mut words = wrapper.to_vec();
        words.extend([own, "role", "--exact", "--nocapture", "--test-threads=1"]);
        Command::new(words[0])
            .args(&words[1..])
            .env(ROLE, role)
            .env(STATION, station)
            .env("TMPDIR", tmp)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// Inode of the only socket that the process has open.
    fn socket(&self) -> u64 {
        let files = std::fs::read_dir(format!("/proc/{}/fd", self.child.id())).unwrap();
        let links = files.flatten().filter_map(|it| it.path().read_link().ok());
        let mut sockets = links.filter_map(|it| {
            let link = it.to_str()?.strip_prefix("socket:[")?.to_owned();
            link.strip_suffix(']')?.parse().ok()
        });
        let own = sockets.next().unwrap();
        assert!(sockets.next().is_none());
        own
    }

    fn end(mut self) {
        drop(self.child.stdin.take());
        assert!(self.child.wait().unwrap().success());
    }

    fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// Names of files in shared memory that begin with `prefix`.
fn files_with_prefix(prefix: &str) -> Vec<String> {
    let all = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let names = all.map(|it| it.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(prefix)).collect()
}

/// Names of the iceoryx2 files of this user's station.
fn station_files(station: &str) -> Vec<String> {
    let user = rustix::process::geteuid().as_raw();
    files_with_prefix(&format!("calot_{user}_{station}."))
}

/// Names of the files that show the presence of the station's members.
fn presence_files(station: &str) -> Vec<String> {
    let user = rustix::process::geteuid().as_raw();
    files_with_prefix(&format!("calot-{user}-{station}."))
}

/// True if `wrapper` can start a program. If not, prints the reason.
fn is_possible(wrapper: &[&str]) -> bool {
    let tried = Command::new(wrapper[0])
        .args(&wrapper[1..])
        .arg("true")
        .output();
    let is_possible = tried.as_ref().is_ok_and(|it| it.status.success());
    if !is_possible {
        println!("skipped: {wrapper:?} is not possible here: {tried:?}");
    }
    is_possible
}

#[test]
fn nothing_of_a_station_is_left_after_a_clean_end() {
    let tmp = tempfile::tempdir().unwrap();
    let station = name("clean");
    let all = TestProcess::start("all", &station, tmp.path());
    assert_eq!(all.result, "open");
    assert!(station_files(&station).len() > 6);
    assert!(presence_files(&station).len() >= 4);
    all.end();
    assert_eq!(station_files(&station), [""; 0]);
    assert_eq!(presence_files(&station), [""; 0]);
}

/// A program in another network namespace, as in a container that shares /dev/shm, does not see the
/// station's abstract sockets.
#[test]
fn a_station_of_another_network_is_not_removed() {
    const NETWORK: [&str; 2] = ["unshare", "--net"];
    if !is_possible(&NETWORK) {
        return;
    }
    let tmp = tempfile::tempdir().unwrap();
    let station = name("net");
    let start = |role: &str| TestProcess::start_in(&NETWORK, role, &station, tmp.path());
    let controller = start("controller");
    assert_eq!(controller.result, "open");
    let before = station_files(&station);
    for wrapped in [true, false] {
        let host = match wrapped {
            true => start("host"),
            false => TestProcess::start("host", &station, tmp.path()),
        };
        assert_eq!(host.result, "open");
        host.end();
        let now = station_files(&station);
        assert!(
            before.iter().all(|it| now.contains(it)),
            "{before:?} {now:?}"
        );
    }
    controller.end();
    assert_eq!(station_files(&station), [""; 0]);
}

#[test]
fn a_station_starts_after_a_hundred_kills_at_random_moments() {
    let tmp = tempfile::tempdir().unwrap();
    let station = name("kills");
    let mut random = 7u64;
    let mut kept: Vec<Child> = Vec::new();
    for kill in 0..100 {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let role = ["controller", "host", "all"][(random >> 33) as usize % 3];
        kept.push(TestProcess::spawn(&[], role, &station, tmp.path()));
        std::thread::sleep(Duration::from_micros((random >> 40) % 60_000));
        // Up to three processes live at once, so that some die while others join.
        if kept.len() == 3 || kill == 99 {
            let mut victim = kept.swap_remove((random >> 20) as usize % kept.len());
            victim.kill().unwrap();
            victim.wait().unwrap();
        }
        if kill % 20 == 19 {
            for mut left in kept.drain(..) {
                left.kill().unwrap();
                left.wait().unwrap();
            }
            let whole = TestProcess::start("all", &station, tmp.path());
            assert_eq!(whole.result, "open", "after {kill} kills");
            whole.end();
            assert_eq!(station_files(&station), [""; 0]);
            assert_eq!(presence_files(&station), [""; 0]);
        }
    }
}

#[test]
fn a_station_starts_on_any_leftovers_of_a_crash() {
    let tmp = tempfile::tempdir().unwrap();
    let station = name("crash");
    let user = rustix::process::geteuid().as_raw();
    let of_root = |folder: &str| tmp.path().join(format!("calot-{user}/{folder}"));
    for case in 0..6 {
        let all = TestProcess::start("all", &station, tmp.path());
        assert_eq!(all.result, "open", "after case {case}");
        all.kill();
        assert!(!station_files(&station).is_empty());
        match case {
            0 => {}
            1 => std::fs::remove_dir_all(of_root("nodes")).unwrap(),
            2 => std::fs::remove_dir_all(of_root("services")).unwrap(),
            3 => {
                std::fs::remove_dir_all(of_root("nodes")).unwrap();
                let dynamic = station_files(&station);
                let dynamic = dynamic.iter().find(|it| it.ends_with(".dynamic")).unwrap();
                std::fs::remove_file(Path::new("/dev/shm").join(dynamic)).unwrap();
            }
            4 => std::fs::remove_dir_all(of_root("")).unwrap(),
            _ => station_files(&station).iter().for_each(|it| {
                std::fs::remove_file(Path::new("/dev/shm").join(it)).unwrap();
            }),
        }
    }
    let last = TestProcess::start("all", &station, tmp.path());
    assert_eq!(last.result, "open");
    last.end();
    assert_eq!(station_files(&station), [""; 0]);
}

#[test]
fn a_station_whose_name_begins_with_anothers_keeps_its_files() {
    let tmp = tempfile::tempdir().unwrap();
    let station = name("a");
    let longer = TestProcess::start("controller", &format!("{station}_b"), tmp.path());
    assert_eq!(longer.result, "open");
    let before = station_files(&format!("{station}_b"));
    TestProcess::start("all", &station, tmp.path()).end();
    assert_eq!(station_files(&format!("{station}_b")), before);
    longer.end();
}

#[test]
fn later_programs_report_that_shared_memory_was_removed() {
    let tmp = tempfile::tempdir().unwrap();
    let station = name("ipc");
    let controller = TestProcess::start("controller", &station, tmp.path());
    for file in station_files(&station) {
        std::fs::remove_file(Path::new("/dev/shm").join(file)).unwrap();
    }
    let host = TestProcess::start("host", &station, tmp.path());
    assert!(host.result.contains("RemoveIPC"), "{}", host.result);
    let words = "), but its files are gone from /dev/shm: ";
    assert!(host.result.contains(words), "{}", host.result);
    assert!(
        host.result.contains("restart the station"),
        "{}",
        host.result
    );
    host.end();
    controller.end();
    let again = TestProcess::start("all", &station, tmp.path());
    assert_eq!(again.result, "open");
    again.end();
}

#[test]
fn later_programs_with_another_temporary_folder_report_the_right_one() {
    let (tmp, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let station = name("tmp");
    let controller = TestProcess::start("controller", &station, tmp.path());
    let host = TestProcess::start("host", &station, other.path());
    assert!(host.result.contains("TMPDIR"), "{}", host.result);
    let place = other.path().to_str().unwrap();
    assert!(host.result.contains(place), "{}", host.result);
    host.end();
    let nowhere = TestProcess::start("host", &station, Path::new("/none"));
    assert!(nowhere.result.contains("/none"), "{}", nowhere.result);
    assert!(nowhere.result.contains("TMPDIR"), "{}", nowhere.result);
    nowhere.end();
    controller.end();
}

#[test]
fn a_name_is_held_only_once_wherever_the_folders_are() {
    let (tmp, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let station = name("claim");
    let first = TestProcess::start("claim", &station, tmp.path());
    assert_eq!(first.result, "open");
    let second = TestProcess::start("claim", &station, other.path());
    let whole = format!(
        "station '{station}' runs already, held by the socket {:?}; show it with `calot run \
         --attach`, or choose another name with --station",
        Some(first.socket())
    );
    assert_eq!(second.result, whole);
    second.end();
    first.kill();
    let third = TestProcess::start("claim", &station, other.path());
    assert_eq!(third.result, "open");
    third.end();
}

#[test]
fn two_accounts_have_stations_of_one_name() {
    const OTHER: [&str; 4] = ["setpriv", "--reuid", "65534", "--clear-groups"];
    if !is_possible(&OTHER) {
        return;
    }
    let tmp = tempfile::tempdir().unwrap();
    let open: std::fs::Permissions = std::os::unix::fs::PermissionsExt::from_mode(0o1777);
    std::fs::set_permissions(tmp.path(), open).unwrap();
    // The other user must be able to read and run this program.
    let copy = tmp.path().join("room");
    std::fs::copy(std::env::current_exe().unwrap(), &copy).unwrap();
    let copy = copy.to_str().unwrap();
    let other = |station: &str| {
        let words = ["sh", "-c", "exec \"$0\" role --exact --nocapture", copy];
        TestProcess::start_in(&[&OTHER[..], &words].concat(), "all", station, tmp.path())
    };
    let own = |station: &str| TestProcess::start("all", station, tmp.path());
    for kill in [false, true] {
        let end = |actor: TestProcess| {
            assert_eq!(actor.result, "open");
            if kill { actor.kill() } else { actor.end() }
        };
        let station = name(if kill { "two-k" } else { "two-e" });
        // The stations run one after the other, then at the same time.
        end(own(&station));
        end(other(&station));
        end(own(&station));
        let (left, right) = (own(&station), other(&station));
        end(left);
        end(right);
    }
    for station in ["two-k", "two-e"] {
        own(&name(station)).end();
        other(&name(station)).end();
    }
}

/// Runs with sizes of /dev/shm from far too small to large enough. Then runs with a full, a
/// read-only and a missing /dev/shm.
#[test]
fn shared_memory_that_is_too_small_is_named_before_it_is_used() {
    if !is_possible(&["unshare", "-m"]) {
        return;
    }
    let tmp = tempfile::tempdir().unwrap();
    let run = |prepare: &str, role: &str| {
        let script = format!("{prepare}; exec \"$0\" \"$@\"");
        let wrapper = ["unshare", "-m", "sh", "-c", &script];
        TestProcess::start_in(&wrapper, role, &name("small"), tmp.path())
    };
    let sized = |size: &str| format!("mount -t tmpfs -o size={size} none /dev/shm");
    for size in ["64k", "1m", "8m", "16m"] {
        let all = run(&sized(size), "all");
        assert!(all.result.contains("--shm-size"), "{size}: {}", all.result);
        all.end();
    }
    let fits = run(&sized("64m"), "all");
    assert_eq!(fits.result, "open");
    fits.end();
    let fill = format!(
        "{}; dd if=/dev/zero of=/dev/shm/fill bs=1M 2>/dev/null",
        sized("4m")
    );
    for role in ["host", "controller"] {
        let full = run(&fill, role);
        assert!(full.result.contains("0 kB free"), "{}", full.result);
        full.end();
    }
    for (prepare, word) in [
        ("mount -t tmpfs -o ro none /dev/shm", "read-only"),
        (
            "mount -t tmpfs none /dev && mkdir /dev/none",
            "no such folder",
        ),
    ] {
        let refused = run(prepare, "host");
        assert!(refused.result.contains(word), "{}", refused.result);
        refused.end();
    }
}

/// `prlimit` sets the same limit as `ulimit -f`. The station checks the limit before it writes any
/// file, so the kernel never sends SIGXFSZ.
#[test]
fn a_limit_of_file_sizes_is_named() {
    if !is_possible(&["prlimit", "--fsize=2000000"]) {
        return;
    }
    let tmp = tempfile::tempdir().unwrap();
    let limited = ["prlimit", "--fsize=2000000"];
    let all = TestProcess::start_in(&limited, "controller", &name("limit"), tmp.path());
    assert!(all.result.contains("ulimit -f"), "{}", all.result);
    all.end();
}

/// The memory that a station requires is at least as large as its files, and not much larger.
#[test]
fn a_station_reserves_the_memory_that_it_uses() {
    let station = Station::new(&name("measure")).unwrap();
    let need = Station::room_needed();
    let ends = (
        Controller::open(&station).unwrap(),
        Tap::open(&station).unwrap(),
        Host::open(&station).unwrap(),
    );
    let prefix = station.file_prefix();
    let files = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let own = files.filter(|it| it.file_name().to_string_lossy().starts_with(prefix));
    let mut taken = 0;
    for file in own {
        let meta = file.metadata().unwrap();
        println!(
            "{:9} {:9} {:?}",
            meta.len(),
            meta.blocks() * 512,
            file.file_name()
        );
        assert!(
            meta.blocks() * 512 >= meta.len(),
            "a page of {:?} is not taken",
            file.path()
        );
        taken += meta.blocks() * 512;
    }
    println!("needs {need}, takes {taken}");
    assert!(need >= taken, "needs {need}, takes {taken}");
    assert!(
        need <= taken + taken / 4 + 2_000_000,
        "needs {need}, takes {taken}"
    );
    drop(ends);
}
