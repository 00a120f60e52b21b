//! Two stations and an instructor, each in a network of its own, connected by a bad line.

mod bad_line;
mod networks;
mod process;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use bad_line::bad_line;
use bytemuck::Zeroable as _;
use networks::{Networks, address};
use process::Process;
use rustix::process::Signal;
use serde_json::Value;
use shared_mem::message::{StateFrame, TimingBatch, ToolFrame};
use shared_mem::service::{Host, Station, TaskReceiver};
use shared_mem::task::TaskMsg;
use system_tests::{
    calot, compiled, finish, may_be_realtime, said, signal, station_name, wait_until,
};

fn make_keys(folder: &Path, words: &[&str]) {
    let script = folder.join("make_keys.sh");
    if !script.exists() {
        let printed = finish(calot().args(["link", "keys"]));
        std::fs::write(&script, printed.stdout).expect("written");
    }
    let mut command = Command::new("sh");
    let made = finish(command.arg(&script).args(words).current_dir(folder));
    assert!(made.status.success(), "{words:?}: {}", said(&made));
}

/// Options `--cert`, `--key` and `--ca` for `name`.
fn keys(folder: &Path, name: &str) -> [String; 6] {
    let file = |it: String| folder.join(it).display().to_string();
    [
        "--cert".into(),
        file(format!("{name}.pem")),
        "--key".into(),
        file(format!("{name}.key")),
        "--ca".into(),
        file("ca.pem".into()),
    ]
}

fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// The instructor's display.
struct Display {
    host: Host,
    state: Box<StateFrame>,
    tools: ToolFrame,
    events: Vec<u64>,
    timing: Option<Box<TimingBatch>>,
    tasks: TaskReceiver,
    task: Box<TaskMsg>,
}

impl Display {
    fn of(station: &str) -> Self {
        Self {
            host: Host::open(&Station::new(station).expect("a name")).expect("a host"),
            state: bytemuck::zeroed_box(),
            tools: ToolFrame::zeroed(),
            events: Vec::new(),
            timing: None,
            tasks: TaskReceiver::open(&Station::new(station).expect("a name")).expect("a host"),
            task: bytemuck::zeroed_box(),
        }
    }

    fn look(&mut self) {
        self.host.newest_state(&mut self.state);
        self.host.newest_tools(&mut self.tools);
        self.tasks.newest(&mut self.task);
        let (events, timing) = (&mut self.events, &mut self.timing);
        self.host.drain_events(|it| events.push(it.sequence));
        self.host.drain_timing(|it| *timing = Some(Box::new(*it)));
    }

    fn sees_after(&mut self, tick: u64) {
        wait_until("a newer state comes", || {
            self.look();
            self.state.tick > tick && self.tools.tick > tick
        });
        assert!(self.state.spheres().is_some_and(|it| !it.is_empty()));
    }
}

#[test]
fn an_instructor_sees_two_stations_over_a_bad_line_and_nobody_else_does() {
    if !may_be_realtime() {
        eprintln!("SKIPPED: networks of their own need root");
        return;
    }
    let Some(networks) = Networks::of(3) else {
        eprintln!("SKIPPED: this system makes no networks (`ip netns`, package iproute2)");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let foreign = tempfile::tempdir().expect("a folder");
    let line = address(2, 1);
    for folder in [folder.path(), foreign.path()] {
        make_keys(folder, &["authority"]);
        make_keys(folder, &["station", "theatre", &format!("IP:{line}")]);
        make_keys(folder, &["watcher", "desk"]);
    }
    let scene = compiled("built-in", Some(300));

    let lost = Arc::new(AtomicU64::new(0));
    let mut running = Vec::new();
    let mut seen = Vec::new();
    for number in 0..2u8 {
        let there = station_name("theatre");
        let here = station_name("seen");
        let network = usize::from(number);
        running.push(networks.calot(
            network,
            &[
                "run",
                "--headless",
                "--frames",
                "0",
                "--seconds",
                "3600",
                "--no-realtime",
                "--station",
                &there,
                "--scene",
                &scene,
                "--task",
                "free",
                "--out",
                &folder.path().join(&there).display().to_string(),
            ],
        ));
        let mut beside = Display::of(&there);
        beside.sees_after(100);
        assert!(!networks.listens(network), "nothing listens unless asked");
        let mine = keys(folder.path(), "theatre");
        let mine: Vec<&str> = mine.iter().map(String::as_str).collect();
        let serve = [
            "link",
            "serve",
            "--json",
            "--station",
            &there,
            "--scene",
            &scene,
            "--listen",
            "0.0.0.0:7447",
        ];
        let serve = networks.calot(network, &[&serve[..], &mine].concat());
        serve.says("it listens", |it| it["listening"].is_string());
        running.push(serve);
        let port = 7500 + u16::from(number);
        bad_line(
            &format!("{line}:{port}"),
            format!("{}:7447", address(number, 2)),
            lost.clone(),
        );
        let watch = watch(&networks, folder.path(), &format!("{line}:{port}"), &here);
        let came = watch.says("its scene comes", |it| it["what"] == "scene");
        seen.push((
            watch,
            here,
            PathBuf::from(came["detail"].as_str().expect("a path")),
            beside,
        ));
    }

    // Everything that a display needs arrives from both stations, with times by this computer's
    // clock.
    for (_, here, _, beside) in &mut seen {
        let mut display = Display::of(here);
        display.sees_after(0);
        let tick = display.state.tick;
        wait_until("events and timing come", || {
            display.look();
            let timing = display.timing.as_ref();
            display.events.len() >= 3 && timing.is_some_and(|it| it.ticks > 0)
        });
        wait_until("how the task stands comes", || {
            display.look();
            display.task.text().is_some_and(|it| it.contains("free"))
        });
        display.sees_after(tick + 1000);
        let old_ns = now_ns().abs_diff(display.state.at_ns);
        assert!(old_ns < 10_000_000_000, "{old_ns} ns");
        assert!(
            display.events.windows(2).all(|it| it[1] == it[0] + 1),
            "{:?}",
            display.events
        );
        beside.look();
        assert_eq!(display.state.scene_id, beside.state.scene_id);
        assert_eq!(display.state.sphere_count, beside.state.sphere_count);
        let behind = beside.state.tick.saturating_sub(display.state.tick);
        println!("{behind} ticks behind, {} events", display.events.len());
    }

    // Draw the picture at the instructor's place.
    let (_, here, scene, _) = &seen[0];
    let out = folder.path().join("pictures");
    let drawn = finish(
        calot()
            .args([
                "run",
                "--attach",
                "--headless",
                "--seconds",
                "4",
                "--frames",
                "1",
                "--station",
                here,
            ])
            .arg("--scene")
            .arg(scene)
            .arg("--out")
            .arg(&out),
    );
    assert!(drawn.status.success(), "{}", said(&drawn));
    assert!(out.join("frame_0000.png").exists(), "{}", said(&drawn));

    // A client signed by another authority sees nothing.
    let name = station_name("intruder");
    let intruder = watch(&networks, foreign.path(), &format!("{line}:7500"), &name);
    intruder.says("it is refused", |it| it["what"] == "lost");
    let words = intruder.end();
    assert_eq!(words["states"], 0, "{words}");

    // A stopped watcher delays nobody, and continues when it is resumed.
    let [(first, first_name, _, beside), (second, second_name, ..)] = &mut seen[..] else {
        unreachable!("there are two");
    };
    // The third watcher asks the same station as the first.
    let third_name = station_name("third");
    let third = watch(
        &networks,
        folder.path(),
        &format!("{line}:7500"),
        &third_name,
    );
    third.says("it is connected", |it| it["what"] == "connected");
    signal(first.child.id(), Signal::STOP);
    for name in [&third_name, &*second_name] {
        let mut display = Display::of(name);
        display.sees_after(0);
        let tick = display.state.tick;
        display.sees_after(tick + 3000);
    }
    beside.look();
    let before = beside.state.tick;
    beside.sees_after(before + 1000);
    let words = third.end();
    assert_eq!(words["malformed"], 0, "{words}");
    signal(first.child.id(), Signal::CONT);
    let mut display = Display::of(first_name);
    display.look();
    let tick = display.state.tick;
    display.sees_after(tick + 500);
    let words = last_words(second);
    assert_eq!(words["malformed"], 0, "{words}");
    assert_eq!(words["events_lost"], 0, "{words}");
    assert!(lost.load(Relaxed) > 3, "the line was bad");
}

/// Ends a watcher and returns its counts.
fn last_words(process: &mut Process) -> Value {
    signal(process.child.id(), Signal::TERM);
    process.says("what it saw", |it| it["states"].is_number())
}

fn watch(networks: &Networks, keys_in: &Path, address: &str, name: &str) -> Process {
    let mine = keys(keys_in, "desk");
    let mine: Vec<&str> = mine.iter().map(String::as_str).collect();
    let words = [
        "link",
        "watch",
        "--json",
        "--connect",
        address,
        "--as",
        name,
    ];
    networks.calot(2, &[&words[..], &mine].concat())
}

#[test]
fn link_without_certificates_is_refused_with_the_next_step() {
    for words in [
        &["link", "serve", "--listen", "0.0.0.0:7447"][..],
        &["link", "watch", "--connect", "10.0.0.7:7447", "--as", "x"],
    ] {
        let run = finish(calot().args(words));
        assert_eq!(run.status.code(), Some(1), "{}", said(&run));
        assert!(said(&run).contains("calot link keys"), "{}", said(&run));
        let run = finish(calot().args(words).arg("--insecure"));
        assert_eq!(run.status.code(), Some(1), "{}", said(&run));
        assert!(said(&run).contains("127.0.0.1"), "{}", said(&run));
    }
}

#[test]
fn a_watcher_that_never_connected_fails_and_says_why() {
    // A port that was free a moment ago: nobody listens there.
    let held = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = held.local_addr().expect("an address").port();
    drop(held);
    let watcher = station_name("unheard");
    let mut watch = calot();
    watch.args(["link", "watch", "--insecure", "--json", "--seconds", "2"]);
    watch.args(["--connect", &format!("127.0.0.1:{port}")]);
    let run = finish(watch.args(["--as", &watcher]));
    assert_eq!(run.status.code(), Some(1), "{}", said(&run));
    let said = said(&run);
    assert!(
        said.contains("never connected") && said.contains("refused"),
        "{said}"
    );
}

#[test]
fn a_station_says_that_its_own_certificate_is_of_no_use() {
    let folder = tempfile::tempdir().expect("a folder");
    make_keys(folder.path(), &["authority"]);
    make_keys(folder.path(), &["station", "theatre", "IP:127.0.0.1"]);
    make_keys(folder.path(), &["watcher", "desk"]);
    let serve = |name: &str, seconds: &str| {
        let station = station_name("certificate");
        let mut serve = calot();
        serve.args([
            "link",
            "serve",
            "--listen",
            "127.0.0.1:0",
            "--station",
            &station,
        ]);
        serve
            .args(["--seconds", seconds])
            .args(keys(folder.path(), name));
        said(&finish(&mut serve))
    };
    let good = serve("theatre", "0.5");
    assert!(
        good.contains("can be seen at") && !good.contains("30 days"),
        "{good}"
    );
    let of_a_watcher = serve("desk", "20");
    assert!(
        of_a_watcher.contains("is not a station's"),
        "{of_a_watcher}"
    );
    // A certificate that ends tomorrow, and one that ended yesterday.
    let sign = |name: &str, days: &str| {
        let mut sign = Command::new("openssl");
        sign.args([
            "x509",
            "-req",
            "-in",
            "request.csr",
            "-CA",
            "ca.pem",
            "-CAkey",
            "ca.key",
        ]);
        sign.args([
            "-extfile",
            "purpose",
            "-days",
            days,
            "-out",
            &format!("{name}.pem"),
        ]);
        let signed = finish(sign.current_dir(folder.path()));
        assert!(signed.status.success(), "{}", said(&signed));
        let key = folder.path().join(format!("{name}.key"));
        std::fs::copy(folder.path().join("theatre.key"), key).expect("copied");
    };
    std::fs::write(
        folder.path().join("purpose"),
        "extendedKeyUsage=serverAuth\n",
    )
    .expect("written");
    let mut request = Command::new("openssl");
    request.args([
        "req",
        "-new",
        "-batch",
        "-key",
        "theatre.key",
        "-subj",
        "/CN=theatre",
    ]);
    let made = finish(
        request
            .args(["-out", "request.csr"])
            .current_dir(folder.path()),
    );
    assert!(made.status.success(), "{}", said(&made));
    sign("soon", "1");
    let soon = serve("soon", "0.5");
    assert!(
        soon.contains("ends within 30 days") && soon.contains("can be seen at"),
        "{soon}"
    );
    sign("old", "-1");
    let old = serve("old", "20");
    assert!(
        old.contains("has expired") && !old.contains("can be seen at"),
        "{old}"
    );
    // Another authority's.
    make_keys(folder.path(), &["authority"]);
    let foreign = serve("theatre", "20");
    assert!(
        foreign.contains("is not of the authority in --ca"),
        "{foreign}"
    );
    // A second address as a word of its own would be lost.
    let mut second = Command::new("sh");
    second.args([
        "make_keys.sh",
        "station",
        "two",
        "IP:10.0.0.1",
        "IP:10.0.0.2",
    ]);
    let refused = finish(second.current_dir(folder.path()));
    assert_eq!(refused.status.code(), Some(2));
    assert!(!folder.path().join("two.pem").exists());
}
