//! A whole task in the window: begun with the keyboard, worked with the mouse, and debriefed.

use std::time::{Duration, Instant};

use assess::{Hold, Lack, Step};
use bytemuck::Zeroable as _;
use display_host::ui::Bulletin;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use shared_mem::message::ToolFrame;
use shared_mem::scene::{SceneFile, str_from_name};
use shared_mem::service::{HandReceiver, Host, Station, TaskReceiver};
use shared_mem::task::TaskMsg;
use system_tests::screen::VirtualScreen;
use system_tests::{compiled, said, station_name, summary, turn, wait_until};

use crate::launcher::{only_folder, screen, start};

/// Rotation of the endoscope per mouse count, rad.
const RAD_COUNT: f64 = 1.0e-3;
/// Share of the remaining angle to correct at once. It is small because the picture lags behind the
/// mouse.
const SHARE: f64 = 0.04;
const COUNTS_MAX: f64 = 20.0;
/// The endoscope is drawn back from a place that is nearer than this, m.
const NEAR_M: f64 = 0.05;
/// The endoscope is moved towards a place that is farther than this, m.
const FAR_M: f64 = 0.2;
/// Time after which the mouse button that moves the endoscope is pressed again.
const HELD_ANEW: Duration = Duration::from_secs(10);

/// Returns direction and distance of a place in the endoscope's picture: right and up, rad, and m.
fn seen_from(tools: &ToolFrame, place_m: Vector3<f64>) -> ([f64; 2], f64) {
    let camera = &tools.world_from_camera;
    let [x, y, z, w] = camera.orientation.map(f64::from);
    let turned = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let to = turned.inverse() * (place_m - Vector3::from(camera.position_m.map(f64::from)));
    let off = [to.x, to.y].map(|aside| aside.atan2(-to.z));
    (off, to.norm())
}

/// Middle of the organ of this name, m.
fn middle(scene: &SceneFile, name: &str) -> Vector3<f64> {
    let mut organs = scene.organs().iter();
    let organ = organs.find(|organ| str_from_name(&organ.name) == Some(name));
    let organ = organ.expect("an organ of that name");
    let [first, count] = organ.spheres.map(|number| number as usize);
    let own = scene.spheres().iter().skip(first).take(count);
    let sum: Vector3<f64> = own
        .map(|it| Vector3::from(it.center_m.map(f64::from)))
        .sum();
    sum / count as f64
}

/// Moves the mouse a little, to bring this place towards the middle of the picture.
fn lead(screen: &VirtualScreen, tools: &ToolFrame, place_m: Vector3<f64>) {
    let ([right, up], distance_m) = seen_from(tools, place_m);
    let counts = [right, -up].map(|off| {
        let counts = SHARE * off / RAD_COUNT;
        counts.clamp(-COUNTS_MAX, COUNTS_MAX).round() as i32
    });
    screen.move_mouse(counts);
    match distance_m {
        far if far > FAR_M => screen.turn_wheel(true),
        far if far < NEAR_M => screen.turn_wheel(false),
        _ => {}
    }
}

#[test]
fn the_endoscope_is_led_from_organ_to_organ_by_the_mouse() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let scene = SceneFile::open(compiled("built-in", None).as_ref()).expect("a scene");
    let name = station_name("drill");
    let station = Station::new(&name).expect("a name");
    let (mut launcher, _, sessions) = start(&screen, &name, folder.path());
    let desk = &screen.window("Calot: Start");
    screen.press_and_see(desk, "2");
    screen.press_and_see(desk, "n");
    for letter in ["e", "v", "e"] {
        screen.press_and_see(desk, letter);
    }
    screen.press_and_see(desk, "Return");
    let own = || screen.windows().into_iter().find(|it| it.0 != *desk);
    wait_until("the operation's window", || {
        if screen.windows().iter().any(|it| it.1 == "Calot: Start") {
            screen.press(desk, "Return");
        }
        own().is_some()
    });
    let window = own().expect("it is there").0;

    let host = Host::open(&station).expect("a host");
    let bulletins = TaskReceiver::open(&station).expect("a receiver");
    let hand = HandReceiver::open(&station).expect("a receiver");
    let mut tools = Box::new(ToolFrame::zeroed());
    wait_until("a picture", || host.newest_tools(&mut tools));
    screen.point_at(&window);
    screen.press(&window, "m");
    wait_until("the mouse leads", || hand.newest().is_some());
    // The middle button moves the endoscope instead of the instrument.
    screen.hold_button(2, true);
    let mut told = bytemuck::zeroed_box::<TaskMsg>();
    let mut end = None;
    let mut held = Instant::now();
    wait_until("the end of the drill", || {
        // A busy screen may lose a press.
        if held.elapsed() > HELD_ANEW {
            screen.hold_button(2, false);
            screen.hold_button(2, true);
            held = Instant::now();
        }
        host.newest_tools(&mut tools);
        bulletins.newest(&mut told);
        let bulletin = told.text().and_then(Bulletin::parse);
        let Some(task) = bulletin.map(|it| it.task) else {
            return false;
        };
        // The ring fills while the picture lacks nothing but rest.
        let rests = |hold: Hold| matches!(hold.lack, None | Some(Lack::Sway));
        if let Some((Step::Show { organ }, _)) = task.steps.iter().find(|(_, done)| !done)
            && !task.hold.is_some_and(rests)
        {
            lead(&screen, &tools, middle(&scene, organ));
        }
        end = task.end;
        end.is_some()
    });
    screen.hold_button(2, false);
    let end = end.expect("it ended");
    assert!(end.passed, "{end:?}");

    let is_debriefed = || screen.windows().iter().any(|it| it.1 == "Calot: Debrief");
    wait_until("the debrief", || {
        if let Some((window, _)) = own() {
            screen.press(&window, "Escape");
        }
        is_debriefed()
    });
    let came_to = summary(&only_folder(&sessions).expect("the session's folder"));
    assert_eq!(
        (&came_to["task"], &came_to["outcome"]),
        (&"scope".into(), &"passed".into()),
        "{came_to:#}"
    );
    screen.leave_launcher(desk, &mut launcher);
    let output = launcher.finish();
    assert!(output.status.success(), "{}", said(&output));
}

/// The expert works in the trainee's window, at a hand that rests until then. Nobody gets the
/// points.
#[test]
fn the_expert_shows_the_drill_and_counts_as_no_person() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(screen) = screen(folder.path()) else {
        return;
    };
    let station = station_name("expert");
    let (mut launcher, _, sessions) = start(&screen, &station, folder.path());
    let desk = &screen.window("Calot: Start");
    screen.press_and_see(desk, "2");
    let own = || screen.windows().into_iter().find(|it| it.0 != *desk);
    wait_until("the operation's window", || {
        if screen.windows().iter().any(|it| it.1 == "Calot: Start") {
            screen.press(desk, "w");
        }
        own().is_some()
    });
    let bulletins = TaskReceiver::open(&Station::new(&station).expect("a name"));
    let bulletins = bulletins.expect("a receiver");
    let mut told = bytemuck::zeroed_box::<TaskMsg>();
    let mut passed = None;
    wait_until("the end of the drill", || {
        bulletins.newest(&mut told);
        let end = (told.text().and_then(Bulletin::parse)).and_then(|it| it.task.end);
        passed = end.map(|end| end.passed);
        passed.is_some()
    });
    assert_eq!(passed, Some(true));
    wait_until("the debrief", || {
        if let Some((window, _)) = own() {
            screen.press(&window, "Escape");
        }
        screen.windows().iter().any(|it| it.1 == "Calot: Debrief")
    });
    let came_to = summary(&only_folder(&sessions).expect("the session's folder"));
    assert_eq!(
        (&came_to["hand"], &came_to["outcome"]),
        (&"scripted".into(), &"passed".into()),
        "{came_to:#}"
    );
    screen.leave_launcher(desk, &mut launcher);
    let output = launcher.finish();
    assert!(output.status.success(), "{}", said(&output));
}
