//! The first hour: from the first start to the certificate of the first level, in the window, by
//! mouse and keyboard alone. The scripted expert decides, and mouse and keyboard do as it asks.

use std::path::Path;
use std::time::{Duration, Instant};

use assess::Task;
use bytemuck::Zeroable as _;
use display_host::ui::Bulletin;
use shared_mem::message::{CommandMsg, HandMsg};
use shared_mem::scene::SceneFile;
use shared_mem::service::{HandReceiver, Host, Station, TaskReceiver};
use shared_mem::task::TaskMsg;
use shared_mem::words::{Buttons, Switches};
use surgeon::{Seen, Surgeon, Theatre, operate};
use system_tests::screen::VirtualScreen;
use system_tests::{Program, calot, finish, processes, said, station_name, turn, wait_until};

use crate::launcher::{screen, text};

/// Sensitivity of the mouse, per cent: the wheel then moves the tip finely enough to touch.
const SENSITIVITY_PERCENT: &str = "50";
/// Motions of the hand per count of the mouse and per notch of the wheel at this sensitivity: of
/// the tip, m, of the endoscope, rad and m.
const TIP_M: [f64; 2] = [0.04e-3, 1.5e-3];
const SCOPE: [f64; 2] = [0.5e-3, 1.0e-3];
/// Most counts and notches at one look.
const COUNTS_MAX: f64 = 60.0;
const NOTCHES_MAX: f64 = 4.0;
/// Turn about the shaft that is left as it is, and from which the key is held without Shift, rad.
const ROLL_RAD: [f64; 2] = [0.03, 0.3];
/// Longest wait until the window has passed on what the mouse did.
const CATCH_UP: Duration = Duration::from_secs(2);
/// Longest wait until the window has taken the instrument, before the key is pressed again. A key
/// pressed too early would let go of it.
const TAKE: Duration = Duration::from_secs(30);

/// A person at the window of an operation.
struct Person<'a> {
    screen: &'a VirtualScreen,
    window: String,
    host: Host,
    hand: HandReceiver,
    task: TaskReceiver,
    told: Box<TaskMsg>,
    /// The window's latest message to the hand.
    led: HandMsg,
    /// True if the task was passed, once it has ended.
    passed: Option<bool>,
}

/// Number of steps of this size from `is` to `asked`, at most this many.
fn steps(asked: f64, is: f64, step: f64, most: f64) -> i32 {
    ((asked - is) / step).round().clamp(-most, most) as i32
}

impl<'a> Person<'a> {
    /// Takes the instrument with mouse and keyboard.
    fn at(screen: &'a VirtualScreen, window: String, station: &Station) -> Self {
        let host = Host::open(station).expect("a host");
        let hand = HandReceiver::open(station).expect("a receiver");
        let task = TaskReceiver::open(station).expect("a receiver");
        let mut tools = bytemuck::zeroed_box();
        wait_until("a picture", || host.newest_tools(&mut tools));
        screen.point_at(&window);
        let mut first = None;
        wait_until("the mouse leads", || {
            // The key also lets go, so it is pressed again only if nothing came.
            screen.press(&window, "m");
            let pressed = Instant::now();
            while first.is_none() && pressed.elapsed() < TAKE {
                first = hand.newest();
                std::thread::sleep(Duration::from_millis(5));
            }
            first.is_some()
        });
        Self {
            screen,
            window,
            host,
            hand,
            task,
            told: bytemuck::zeroed_box(),
            led: first.unwrap_or_else(HandMsg::zeroed),
            passed: None,
        }
    }

    /// Waits until the window's message says so.
    fn catch_up(&mut self, says: impl Fn(&HandMsg) -> bool) {
        let start = Instant::now();
        loop {
            self.led = self.hand.newest().unwrap_or(self.led);
            if says(&self.led) || start.elapsed() > CATCH_UP {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Moves the tip with mouse and wheel.
    fn move_tip(&mut self, asked: &HandMsg) {
        let is = self.led.moved_m;
        let want = asked.moved_m;
        let side = [0, 1].map(|i| steps(want[i], is[i], TIP_M[0], COUNTS_MAX));
        let notches = steps(want[2], is[2], TIP_M[1], NOTCHES_MAX);
        self.turn_mouse([side[0], -side[1]], -notches);
        let goal = [
            is[0] + f64::from(side[0]) * TIP_M[0],
            is[1] + f64::from(side[1]) * TIP_M[0],
            is[2] + f64::from(notches) * TIP_M[1],
        ];
        self.catch_up(|it| (0..3).all(|i| (it.moved_m[i] - goal[i]).abs() < 0.5 * TIP_M[0]));
    }

    /// Turns and advances the endoscope with the middle button, mouse and wheel.
    fn move_scope(&mut self, asked: &HandMsg) {
        let [is, want] = [&self.led, asked].map(|it| it.scope_turned_rad);
        let turn = [0, 1].map(|i| steps(want[i], is[i], SCOPE[0], COUNTS_MAX));
        let advance = steps(
            asked.scope_advanced_m,
            self.led.scope_advanced_m,
            SCOPE[1],
            NOTCHES_MAX,
        );
        if turn == [0; 2] && advance == 0 {
            return;
        }
        self.screen.hold_button(2, true);
        self.turn_mouse([-turn[0], -turn[1]], advance);
        self.screen.hold_button(2, false);
        let goal = [0, 1].map(|i| is[i] + f64::from(turn[i]) * SCOPE[0]);
        let advanced = self.led.scope_advanced_m + f64::from(advance) * SCOPE[1];
        self.catch_up(|it| {
            (0..2).all(|i| (it.scope_turned_rad[i] - goal[i]).abs() < 0.5 * SCOPE[0])
                && (it.scope_advanced_m - advanced).abs() < 0.5 * SCOPE[1]
        });
    }

    /// Moves the mouse by these counts to the right and down, and turns the wheel away by these
    /// notches.
    fn turn_mouse(&self, counts: [i32; 2], notches: i32) {
        if counts != [0; 2] {
            self.screen.move_mouse(counts);
        }
        for _ in 0..notches.abs() {
            self.screen.turn_wheel(notches > 0);
        }
    }

    /// Turns the instrument about its shaft with a key.
    fn roll(&mut self, asked: &HandMsg) {
        let off = |led: &HandMsg| asked.rolled_rad - led.rolled_rad;
        let first = off(&self.led);
        if first.abs() < ROLL_RAD[0] {
            return;
        }
        let key = if first > 0.0 { "comma" } else { "period" };
        let is_slow = first.abs() < ROLL_RAD[1];
        let stop_rad = if is_slow { 0.0 } else { 0.5 * ROLL_RAD[1] };
        if is_slow {
            self.screen.hold_key("Shift_L", true);
        }
        self.screen.hold_key(key, true);
        self.catch_up(|it| off(it) * first.signum() <= stop_rad);
        self.screen.hold_key(key, false);
        if is_slow {
            self.screen.hold_key("Shift_L", false);
        }
    }

    /// Presses and releases what closes the jaws and gives current.
    fn press(&mut self, asked: &HandMsg) {
        let buttons = |it: &HandMsg| it.buttons & Buttons::GRASP.bits() != 0;
        let pedal = |it: &HandMsg, which: Switches| it.switches & which.bits() != 0;
        let grasps = buttons(asked);
        if grasps != buttons(&self.led) {
            self.screen.hold_button(1, grasps);
        }
        let coagulates = pedal(asked, Switches::COAGULATE);
        if coagulates != pedal(&self.led, Switches::COAGULATE) {
            self.screen.hold_button(3, coagulates);
        }
        let cuts = pedal(asked, Switches::CUT);
        if cuts != pedal(&self.led, Switches::CUT) {
            self.screen.hold_key("c", cuts);
        }
        self.catch_up(|it| {
            buttons(it) == grasps
                && pedal(it, Switches::COAGULATE) == coagulates
                && pedal(it, Switches::CUT) == cuts
        });
    }
}

impl Theatre for Person<'_> {
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool {
        self.press(asked);
        self.move_scope(asked);
        self.roll(asked);
        self.move_tip(asked);
        std::thread::sleep(Duration::from_millis(5));
        let before = seen.tools.tick;
        self.host.newest_state(&mut seen.state);
        self.host.newest_tools(&mut seen.tools);
        seen.at_s += match before {
            0 => 0.005,
            before => seen.tools.tick.saturating_sub(before) as f64 * 1e-3,
        };
        let events = &mut seen.events;
        self.host.drain_events(|event| events.push(*event));
        self.task.newest(&mut self.told);
        let bulletin = self.told.text().and_then(Bulletin::parse);
        let end = bulletin.and_then(|it| it.task.end);
        self.passed = end.map(|it| it.passed);
        self.passed.is_none()
    }

    /// The expert only exchanges instruments, which the keys 1 to 5 do.
    fn command(&mut self, command: CommandMsg) -> Result<(), String> {
        assert_eq!(command.kind, CommandMsg::INSTRUMENT);
        let key = (command.argument + 1).to_string();
        self.screen.press(&self.window, &key);
        Ok(())
    }

    fn tell(&mut self, what: &str) {
        println!("the expert: {what}");
    }
}

/// The word after `option` in the command line of a station's process.
fn word_of(process: &str, station: &str, option: &str) -> String {
    let mut word = None;
    wait_until(option, || {
        let pid = processes(&[process, "--station", station]).pop();
        let line = pid.and_then(|it| std::fs::read_to_string(format!("/proc/{it}/cmdline")).ok());
        let line = line.unwrap_or_default();
        let mut words = line.split('\0').skip_while(|it| *it != option);
        word = words.nth(1).map(str::to_owned);
        word.is_some()
    });
    word.unwrap_or_default()
}

/// Works the task that is open, and waits for its debrief. Returns the task. `desk` is the
/// launcher's window.
fn work(screen: &VirtualScreen, desk: &str, station: &str) -> Task {
    let mut own = None;
    wait_until("the operation's window", || {
        own = screen.windows().into_iter().find(|it| it.0 != desk);
        own.is_some()
    });
    let window = own.map(|it| it.0).unwrap_or_default();
    let task = word_of("run", station, "--task");
    let task = Task::from_name(&task).expect("a task");
    let place = Station::new(station).expect("a name");
    let mut person = Person::at(screen, window.clone(), &place);
    let scene = SceneFile::open(Path::new(&word_of("rt", station, "--scene"))).expect("a scene");
    operate(Surgeon::Careful, task, scene, &mut person).expect("a controller");
    assert_eq!(person.passed, Some(true), "{task:?}");
    wait_until("the debrief", || {
        screen.press(&window, "Escape");
        screen.windows().iter().any(|it| it.1 == "Calot: Debrief")
    });
    task
}

#[test]
fn the_first_hour_leads_from_the_first_start_to_a_certificate() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let (store, sessions) = (
        folder.path().join("store.sqlite"),
        folder.path().join("sessions"),
    );
    let station = station_name("hour");
    let mut launcher = calot();
    launcher
        .args(["start", "--station", &station, "--language", "en"])
        .args(["--store", text(&store), "--sessions", text(&sessions)])
        .args(["--", "--no-realtime", "--mute", "--size", "640x480"])
        .args(["--sensitivity", SENSITIVITY_PERCENT])
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY");
    let mut launcher = Program::start(&mut launcher);
    let desk = &screen.window("Calot: Start");
    for key in ["n", "e", "v", "e", "Return"] {
        screen.press_and_see(desk, key);
    }
    let begin = |key: &str| {
        wait_until("the operation", || {
            let is_open = |title| screen.windows().iter().any(|it| it.1 == title);
            if ["Calot: Start", "Calot: Debrief"].into_iter().any(is_open) {
                screen.press(desk, key);
            }
            std::thread::sleep(Duration::from_millis(500));
            is_open("Calot: Operation")
        });
    };
    // The guided first steps, then whatever the curriculum offers next.
    begin("g");
    let mut worked = vec![work(&screen, desk, &station)];
    for _ in 0..4 {
        begin("n");
        worked.push(work(&screen, desk, &station));
    }
    let expected = [
        Task::Basics,
        Task::Scope,
        Task::Scope,
        Task::Phantom,
        Task::Phantom,
    ];
    assert_eq!(worked, expected);
    let certificate = sessions.join("certificates").join("eve.html");
    wait_until("the certificate", || {
        screen.press(desk, "c");
        certificate.exists()
    });
    let page = std::fs::read_to_string(&certificate).expect("a page");
    assert!(
        page.contains("eve") && page.contains("First steps"),
        "{page}"
    );
    screen.leave(desk, &mut launcher);
    let output = launcher.finish();
    assert!(output.status.success(), "{}", said(&output));
    let listed = finish(calot().args(["store", "--store", text(&store), "list", "--json"]));
    assert!(listed.status.success(), "{}", said(&listed));
}
