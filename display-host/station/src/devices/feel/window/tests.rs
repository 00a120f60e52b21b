//! Tests of page and guide with a person's answers. No window opens.

use std::sync::Mutex;
use std::thread::JoinHandle;
use std::time::Duration;

use display_host::ui::feel::{Ended, Screen, Way, Wish};
use display_host::window::Page as _;
use hardware::feel::{Answer, Direction, Left, Question, Squeezed, Step};
use rt_core::math::Pose;
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, LineCounters, Polled};

use super::*;

/// A device that stands still and keeps the newest force.
struct Still {
    newest: Arc<Mutex<ForceCommand>>,
}

impl HapticDevice for Still {
    fn capabilities(&self) -> DeviceCapabilities {
        DeviceCapabilities::TOUCH
    }

    fn poll(&mut self, now_ns: u64) -> Polled<DeviceSample> {
        Polled::Fresh(DeviceSample {
            device_from_handle: Pose::identity(),
            velocity_m_s: None,
            buttons: Buttons::default(),
            opening: None,
            sequence: 0,
            at_ns: now_ns,
        })
    }

    fn send(&mut self, command: ForceCommand, _: u64) {
        *self.newest.lock().unwrap() = command;
    }

    fn counters(&self) -> LineCounters {
        LineCounters::default()
    }
}

fn led() -> (Desk, Windowed, Arc<Signs>) {
    let signs = Arc::new(Signs::default());
    let (desk, guide) = Desk::new(
        Words::default(),
        &DeviceCapabilities::TOUCH,
        &signs,
        &Arc::default(),
    );
    (desk, guide, signs)
}

/// Starts a test by hand, and leads it until the handle pushes.
fn pushing() -> (Desk, Arc<Mutex<ForceCommand>>, JoinHandle<String>) {
    let (mut desk, mut guide, _) = led();
    let newest = Arc::new(Mutex::new(ForceCommand::default()));
    let mut device = Still {
        newest: Arc::clone(&newest),
    };
    let test = std::thread::spawn(move || {
        let felt = feel(&mut device, &mut guide, 1);
        guide.end(&felt.report);
        felt.report.to_string()
    });
    while newest.lock().unwrap().force_n.norm() < 0.1 {
        desk.look_about();
        if matches!(desk.view.screen, Screen::Move { .. } | Screen::Hold) {
            desk.take(Wish::Done);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    (desk, newest, test)
}

#[test]
fn escape_ends_the_force_and_shows_the_outcome() {
    let (mut desk, newest, test) = pushing();
    desk.escape();
    let report = test.join().unwrap();
    assert_eq!(*newest.lock().unwrap(), ForceCommand::default());
    assert!(report.contains("was stopped"), "{report}");
    assert!(desk.look_about());
    let Screen::Ended(Ended { passed, checks, .. }) = &desk.view.screen else {
        panic!("{:?}", desk.view.screen);
    };
    assert!(!passed && checks.iter().any(|it| it.name == "end"));
    assert!(!desk.is_over(), "the outcome stays");
    desk.look_about();
    assert!(!desk.is_over());
    desk.take(Wish::Close);
    assert!(desk.is_over());
}

#[test]
fn the_button_that_stops_ends_the_force() {
    let (mut desk, newest, test) = pushing();
    desk.take(Wish::Stop);
    test.join().unwrap();
    assert_eq!(*newest.lock().unwrap(), ForceCommand::default());
}

#[test]
fn a_window_that_is_gone_ends_the_force() {
    let (desk, newest, test) = pushing();
    drop(desk);
    let report = test.join().unwrap();
    assert_eq!(*newest.lock().unwrap(), ForceCommand::default());
    assert!(report.contains("was stopped"), "{report}");
}

#[test]
fn a_bench_that_is_gone_closes_the_window() {
    let (mut desk, guide, _) = led();
    assert!(!desk.look_about() && !desk.is_over());
    drop(guide);
    desk.look_about();
    assert!(desk.is_over());
}

#[test]
fn until_the_window_is_seen_the_device_is_read_without_force() {
    let (desk, mut guide, signs) = led();
    let newest = Arc::new(Mutex::new(ForceCommand {
        opening_n: 1.0,
        ..ForceCommand::default()
    }));
    let mut device = Still {
        newest: Arc::clone(&newest),
    };
    let waits = std::thread::spawn(move || keep_quiet(&mut device, &mut guide));
    while *newest.lock().unwrap() != ForceCommand::default() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!waits.is_finished());
    signs.see();
    waits.join().unwrap();
    drop(desk);
}

#[test]
fn an_answer_to_an_earlier_screen_counts_no_more() {
    let (mut desk, mut guide, _) = led();
    guide.tell(&Step::Hold);
    assert!(desk.look_about());
    assert!(!guide.is_done());
    desk.take(Wish::Done);
    desk.take(Wish::Done);
    assert!(guide.is_done());
    guide.tell(&Step::Scale);
    assert!(!guide.is_done());
    desk.take(Wish::Done);
    assert!(!guide.is_done(), "the scale is not shown yet");
    desk.look_about();
    desk.take(Wish::Done);
    assert!(guide.is_done());
}

#[test]
fn questions_are_answered_without_waiting() {
    let (mut desk, mut guide, _) = led();
    guide.ask(Question::Pushed);
    assert!(!guide.has_answer());
    desk.look_about();
    desk.take(Wish::Felt(Some(Way::Towards)));
    assert!(guide.has_answer());
    assert_eq!(guide.pushed(), Answer::Felt(Direction::Towards));

    guide.ask(Question::Squeezed);
    desk.look_about();
    desk.take(Wish::FeltFingers(Some(false)));
    assert!(guide.has_answer());
    assert_eq!(guide.squeezed(), Squeezed::Shut);

    guide.ask(Question::Left);
    desk.look_about();
    desk.take(Wish::Left(false));
    assert!(guide.has_answer());
    assert_eq!(guide.left(), Some(Left::Nothing));

    guide.ask(Question::HasScale);
    desk.look_about();
    desk.take(Wish::HasScale(true));
    assert!(guide.has_answer() && guide.has_scale());

    guide.ask(Question::Pressed);
    desk.look_about();
    desk.take(Wish::Grams("5l".into()));
    desk.take(Wish::TakeGrams);
    assert!(!guide.has_answer());
    let wrong = Screen::AskPressed {
        grams: "5l".into(),
        wrong: true,
    };
    assert_eq!(desk.view.screen, wrong);
    desk.take(Wish::Grams("51,5".into()));
    desk.take(Wish::TakeGrams);
    assert!(guide.has_answer());
    assert!(
        guide
            .pressed_n()
            .is_some_and(|it| (it - 0.505).abs() < 1e-3)
    );

    guide.ask(Question::Pressed);
    desk.look_about();
    desk.take(Wish::TakeGrams);
    assert!(guide.has_answer());
    assert_eq!(guide.pressed_n(), None);
}

#[test]
fn without_a_screen_the_error_names_the_terminal() {
    let detail = "DISPLAY names no screen".to_owned();
    let error = without_window(DisplayError::NoWindow { detail }).to_string();
    assert!(error.contains("DISPLAY names no screen"), "{error}");
    assert!(error.contains("Leave `--window` out"), "{error}");
    let detail = "the X server ended".to_owned();
    let error = without_window(DisplayError::WindowLost { detail }).to_string();
    assert!(error.contains("was lost"), "{error}");
}
