//! Processes that die, are stopped, or meet another process of their kind: each ends or continues
//! in a defined way.

use std::path::Path;
use std::process::Stdio;

use rustix::process::Signal;
use shared_mem::message::StateFrame;
use shared_mem::service::{Host, Station};
use system_tests::{
    Program, calot, compiled, finish, processes, said, signal, station_name, summary, wait_until,
};

/// A station that runs in the background without pictures.
struct Running {
    name: String,
    run: Program,
    folder: tempfile::TempDir,
}

impl Running {
    fn start(test: &str) -> Self {
        Self::named(station_name(test))
    }

    fn named(name: String) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let mut calot = calot();
        calot
            .args([
                "run",
                "--headless",
                "--seconds",
                "3600",
                "--frames",
                "0",
                "--station",
                &name,
            ])
            .arg("--out")
            .arg(folder.path());
        let run = Program::start(&mut calot);
        wait_for_ticks(&name);
        Self { name, run, folder }
    }

    /// Process id of the station's child that runs `command`.
    fn process(&self, command: &str) -> u32 {
        let parent = self.run.id();
        let mine = processes(&[command, "--with-parent"]);
        *mine
            .iter()
            .find(|pid| parent_of(**pid) == Some(parent))
            .expect("the child runs")
    }

    /// Waits for the end. Returns whether the run succeeded, its standard error and its summary.
    fn end(self) -> (bool, String, serde_json::Value) {
        let parent = self.run.id();
        let output = self.run.finish();
        let left: Vec<u32> = processes(&["--with-parent"])
            .into_iter()
            .filter(|pid| parent_of(*pid) == Some(parent))
            .collect();
        assert!(left.is_empty(), "children left behind: {left:?}");
        (
            output.status.success(),
            said(&output),
            summary(self.folder.path()),
        )
    }
}

fn parent_of(pid: u32) -> Option<u32> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    status
        .lines()
        .find_map(|line| line.strip_prefix("PPid:")?.trim().parse().ok())
}

/// Waits until the controller has published for a second. By then the station reacts to signals.
fn wait_for_ticks(name: &str) {
    let host = Station::new(name)
        .and_then(|s| Host::open(&s))
        .expect("a station");
    let mut frame: Box<StateFrame> = bytemuck::zeroed_box();
    wait_until("the controller ticks", || {
        host.newest_state(&mut frame) && frame.tick > 1000
    });
}

#[test]
fn ctrl_c_ends_the_run_cleanly_with_its_report() {
    let running = Running::start("ctrl-c");
    // A terminal signals the whole process group. The station leads a group of its own.
    signal(running.run.id(), Signal::INT);
    let (ok, said, summary) = running.end();
    assert!(ok, "{said}");
    assert!(
        said.contains("ticks,"),
        "the controller ended in order: {said}"
    );
    assert_eq!(summary["ended"], "stopped");
    assert!(summary["ticks"].as_u64() > Some(0), "{summary:#}");
}

#[test]
fn killed_controller_ends_the_run_with_its_report_and_it_starts_again() {
    let running = Running::start("kill-rt");
    let name = running.name.clone();
    signal(running.process("rt"), Signal::KILL);
    let (ok, said, summary) = running.end();
    assert!(!ok);
    assert!(said.contains("the rt process died"), "{said}");
    assert_eq!(summary["ended"], "process_died");
    assert!(summary["ticks"].as_u64() > Some(0), "{summary:#}");

    let again = Running::named(name);
    signal(again.run.id(), Signal::TERM);
    let (ok, said, _) = again.end();
    assert!(ok, "{said}");
}

#[test]
fn killed_devices_end_the_run_with_its_report() {
    let running = Running::start("kill-devices");
    signal(running.process("emulate"), Signal::KILL);
    let (ok, said, summary) = running.end();
    assert!(!ok);
    assert!(said.contains("the emulate process died"), "{said}");
    assert!(summary["ticks"].as_u64() > Some(0), "{summary:#}");
}

#[test]
fn a_second_station_and_a_second_controller_are_refused() {
    let running = Running::start("second");
    let run = finish(calot().args(["run", "--headless", "--station", &running.name]));
    assert!(!run.status.success());
    let holder = format!(
        "runs already, held by calot (process {}) of user ",
        running.run.id()
    );
    assert!(said(&run).contains(&holder), "{}", said(&run));

    let scene = compiled("built-in", None);
    let rt = finish(calot().args(["rt", "--station", &running.name, "--scene", &scene]));
    assert!(!rt.status.success());
    assert!(
        said(&rt).contains("already has a controller"),
        "{}",
        said(&rt)
    );

    signal(running.run.id(), Signal::INT);
    let (ok, said, _) = running.end();
    assert!(ok, "the first goes on: {said}");
}

#[test]
fn a_station_that_is_killed_takes_its_children_along() {
    let running = Running::start("orphans");
    let (rt, emulate) = (running.process("rt"), running.process("emulate"));
    signal(running.run.id(), Signal::KILL);
    let _ = running.run.finish();
    let gone = |pid: u32| !Path::new(&format!("/proc/{pid}")).exists();
    wait_until("the children end", || gone(rt) && gone(emulate));
}

#[test]
fn a_display_dies_and_another_comes_while_the_controller_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let scene = compiled("built-in", None);
    let name = station_name("display");
    let mut rt = calot()
        .args(["rt", "--station", &name, "--scene", &scene])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    wait_for_ticks(&name);
    let attach = |seconds: &str, out: &Path| {
        let mut command = calot();
        command
            .args([
                "run",
                "--attach",
                "--headless",
                "--frames",
                "0",
                "--seconds",
                seconds,
            ])
            .args(["--station", &name, "--scene", &scene, "--out"])
            .arg(out);
        command
    };
    let mut first = attach("3600", &folder.path().join("first"))
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(500));
    first.kill().unwrap();
    first.wait().unwrap();

    let out = folder.path().join("second");
    let second = finish(&mut attach("2", &out));
    assert!(second.status.success(), "{}", said(&second));
    let summary = summary(&out);
    assert!(
        summary["timing_records"].as_u64() > Some(100),
        "{summary:#}"
    );
    assert!(rt.try_wait().unwrap().is_none(), "the controller goes on");

    // A display of another scene is refused; the error names the scene that runs.
    let tiny = folder.path().join("ball.obj");
    std::fs::write(&tiny, ball()).unwrap();
    let other =
        finish(attach("2", &folder.path().join("other")).args(["--scene", tiny.to_str().unwrap()]));
    assert!(!other.status.success());
    assert!(said(&other).contains("scene"), "{}", said(&other));

    signal(rt.id(), Signal::TERM);
    assert!(rt.wait().unwrap().success());
}

/// A ball of 3 cm radius as OBJ text: an octahedron whose triangles are divided three times.
fn ball() -> String {
    let mut triangles: Vec<[[f64; 3]; 3]> = Vec::new();
    for (sx, sy, sz) in (0..8).map(|i| (i & 1, i >> 1 & 1, i >> 2 & 1)) {
        let s = |bit: i32| f64::from(1 - 2 * bit);
        let (x, y, z) = ([s(sx), 0.0, 0.0], [0.0, s(sy), 0.0], [0.0, 0.0, s(sz)]);
        triangles.push(if (sx + sy + sz) % 2 == 0 {
            [x, y, z]
        } else {
            [x, z, y]
        });
    }
    for _ in 0..3 {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let mid = |p: [f64; 3], q: [f64; 3]| {
                    let m: [f64; 3] = std::array::from_fn(|i| p[i] + q[i]);
                    let length = m.iter().map(|x| x * x).sum::<f64>().sqrt();
                    m.map(|x| x / length)
                };
                let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let mut text = String::new();
    for p in triangles.iter().flatten() {
        let [x, y, z] = p.map(|v| v * 0.03);
        text += &format!("v {x} {y} {z}\n");
    }
    for i in 0..triangles.len() {
        text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    text
}

/// `CALOT_KILLS` sets the number of kills; a hundred kills take about five minutes.
#[test]
fn after_many_kills_of_any_process_at_any_moment_the_station_starts() {
    let kills = std::env::var("CALOT_KILLS").map_or(8, |it| it.parse().expect("a number"));
    let name = station_name("kills");
    let mut random = 11u64;
    for kill in 0..kills {
        let out = tempfile::tempdir().expect("a folder");
        let mut run = calot();
        run.args(["run", "--headless", "--seconds", "3600", "--frames", "0"])
            .args(["--station", &name])
            .arg("--out")
            .arg(out.path());
        let run = Program::start(&mut run);
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let moment = std::time::Duration::from_millis((random >> 40) % 2500);
        std::thread::sleep(moment);
        let children = processes(&["--with-parent"]);
        let mine = children.into_iter();
        let mine = mine.filter(|pid| parent_of(*pid) == Some(run.id()));
        let all: Vec<u32> = mine.chain([run.id()]).collect();
        let victim = all[(random >> 33) as usize % all.len()];
        signal(victim, Signal::KILL);
        let output = run.finish();
        assert!(!output.status.success(), "kill {kill}: {}", said(&output));
        // The other processes of the station end with the killed one. The station's name is free
        // when all have ended.
        let gone = |pid: &u32| !Path::new(&format!("/proc/{pid}")).exists();
        wait_until("the others end", || all.iter().all(gone));
    }
    let running = Running::named(name.clone());
    signal(running.run.id(), Signal::INT);
    let (ok, said, _) = running.end();
    assert!(ok, "{said}");
    let left = std::fs::read_dir("/dev/shm").expect("shared memory");
    let left = left
        .flatten()
        .map(|it| it.file_name().to_string_lossy().into_owned());
    let left: Vec<String> = left.filter(|it| it.contains(&format!("{name}."))).collect();
    assert!(left.is_empty(), "{left:?}");
}
