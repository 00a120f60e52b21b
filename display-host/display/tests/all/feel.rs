//! Screens of the device test that a person does by hand, used by accessible name, pointer and
//! keyboard.

use display_host::ui::feel::{
    CheckLine, CheckResult, Ended, Live, Part, Progress, Screen, View, Way, Wish, feel,
};
use display_host::words::{Language, Words};
use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

/// Part of the test that a screen belongs to, and the screen's step in it.
const fn progress(screen: &Screen) -> Progress {
    let (part, step) = match screen {
        Screen::Waiting => (Part::Move, [0, 0]),
        Screen::Move { .. } => (Part::Move, [2, 3]),
        Screen::Hold | Screen::Push { .. } | Screen::AskPushed => (Part::Push, [2, 3]),
        Screen::Shut => (Part::Opening, [1, 4]),
        Screen::Open => (Part::Opening, [2, 4]),
        Screen::HoldFingers | Screen::PushFingers { .. } | Screen::AskFingers => {
            (Part::Opening, [3, 4])
        }
        Screen::AskScale | Screen::Scale | Screen::Press { .. } | Screen::AskPressed { .. } => {
            (Part::Scale, [1, 1])
        }
        Screen::HoldFirmly => (Part::Response, [2, 3]),
        Screen::HoldForSilence | Screen::AskLeft => (Part::Response, [3, 3]),
        Screen::Response | Screen::Ended(_) => (Part::Response, [1, 3]),
    };
    Progress { part, step }
}

fn view(screen: Screen) -> View {
    let progress = progress(&screen);
    View {
        words: Words::new(Language::English),
        progress,
        screen,
        live: Live {
            at_m: Some([0.0512, 0.0304, -0.0207]),
            velocity_m_s: Some([0.012, -0.003, 0.0]),
            force_n: [0.0, -0.3, 0.0],
            opening: Some(0.42),
            opening_n: -0.75,
        },
        radius_m: 0.08,
        opens: matches!(progress.part, Part::Opening),
    }
}

fn ended() -> Ended {
    let line = |name: &str, result, detail: &str| CheckLine {
        name: name.into(),
        result,
        detail: detail.into(),
    };
    Ended {
        device: "haptic device \"emulated rig\", serial 7".into(),
        passed: false,
        checks: vec![
            line(
                "move right",
                CheckResult::Pass,
                "it says (49.20, 0.31, -0.80) mm for 50 mm to the right",
            ),
            line(
                "push up",
                CheckResult::Fail,
                "0.3 N up, felt down: the force has the wrong sign",
            ),
            line("scale", CheckResult::Skipped, "there is no scale"),
            line(
                "response",
                CheckResult::Open,
                "steps of ±0.5 N along x move the handle by 0.02 mm: too little. Hold it more \
                 loosely, or let go of it, and test again",
            ),
        ],
    }
}

/// Every screen with a name.
pub(crate) fn views() -> Vec<(&'static str, View)> {
    let grams = |grams: &str, wrong| Screen::AskPressed {
        grams: grams.into(),
        wrong,
    };
    let way = |way| Screen::Move { way, way_m: 0.05 };
    let mut all: Vec<_> = [
        ("feel-waiting", Screen::Waiting),
        ("feel-move", way(Way::Right)),
        ("feel-towards", way(Way::Towards)),
        ("feel-hold", Screen::Hold),
        ("feel-push", Screen::Push { force_n: 0.3 }),
        ("feel-pushed", Screen::AskPushed),
        ("feel-shut", Screen::Shut),
        ("feel-open", Screen::Open),
        ("feel-hold-fingers", Screen::HoldFingers),
        ("feel-push-fingers", Screen::PushFingers { force_n: 1.0 }),
        ("feel-fingers", Screen::AskFingers),
        ("feel-has-scale", Screen::AskScale),
        ("feel-scale", Screen::Scale),
        ("feel-press", Screen::Press { force_n: 0.5 }),
        ("feel-pressed", grams("51,5", false)),
        ("feel-pressed-wrong", grams("5l", true)),
        ("feel-response", Screen::Response),
        ("feel-hold-firmly", Screen::HoldFirmly),
        ("feel-hold-silence", Screen::HoldForSilence),
        ("feel-left", Screen::AskLeft),
        ("feel-ended", Screen::Ended(ended())),
    ]
    .map(|(name, screen)| (name, view(screen)))
    .into();
    let mut outside = view(way(Way::Up));
    outside.live.at_m = Some([0.4, 0.3, 0.1]);
    outside.live.velocity_m_s = None;
    all.push(("feel-outside", outside));
    let mut last = view(Screen::Hold);
    last.progress = Progress {
        part: Part::Response,
        step: [1, 3],
    };
    last.live = Live::default();
    all.push(("feel-hold-last", last));
    all
}

struct Seen {
    view: View,
    wishes: Vec<Wish>,
}

fn shown(screen: Screen) -> Harness<'static, Seen> {
    let seen = Seen {
        view: view(screen),
        wishes: Vec::new(),
    };
    let show = |area: &mut egui::Ui, seen: &mut Seen| {
        let wishes = feel(area, &seen.view);
        for wish in &wishes {
            if let (Wish::Grams(text), Screen::AskPressed { grams, .. }) =
                (wish, &mut seen.view.screen)
            {
                grams.clone_from(text);
            }
        }
        seen.wishes.extend(wishes);
    };
    let mut harness = Harness::builder()
        .with_size([1280.0, 720.0])
        .build_ui_state(show, seen);
    harness.run_steps(2);
    harness
}

fn wishes(screen: Screen, keys: &[Key]) -> Vec<Wish> {
    let mut desk = shown(screen);
    for &key in keys {
        desk.key_press(key);
        desk.run_steps(2);
    }
    desk.state().wishes.clone()
}

#[test]
fn escape_and_a_button_stop_the_test_on_every_screen() {
    for (name, view) in views() {
        if matches!(view.screen, Screen::Ended(_)) {
            continue;
        }
        assert!(
            wishes(view.screen.clone(), &[Key::Escape]).contains(&Wish::Stop),
            "{name}"
        );
        let mut desk = shown(view.screen);
        let stop = desk.get_by_label("Stop: no force (Esc)");
        assert!(stop.rect().bottom() <= 720.0, "{name}: {:?}", stop.rect());
        stop.click();
        desk.run_steps(2);
        assert_eq!(desk.state().wishes, [Wish::Stop], "{name}");
    }
}

#[test]
fn enter_ends_a_step_and_answers_no_question() {
    for screen in [
        Screen::Hold,
        Screen::HoldFirmly,
        Screen::HoldForSilence,
        Screen::Shut,
        Screen::Open,
        Screen::HoldFingers,
        Screen::Scale,
        Screen::Press { force_n: 0.5 },
        Screen::Move {
            way: Way::Up,
            way_m: 0.05,
        },
    ] {
        assert_eq!(wishes(screen, &[Key::Enter]), [Wish::Done]);
    }
    for screen in [
        Screen::Waiting,
        Screen::Push { force_n: 0.3 },
        Screen::AskPushed,
        Screen::PushFingers { force_n: 1.0 },
        Screen::AskFingers,
        Screen::AskScale,
        Screen::AskLeft,
        Screen::Response,
    ] {
        assert_eq!(wishes(screen.clone(), &[Key::Enter]), [], "{screen:?}");
    }
}

#[test]
fn directions_are_answered_by_letters_and_by_buttons() {
    let ways = [
        (Key::R, "Right (R)", Some(Way::Right)),
        (Key::L, "Left (L)", Some(Way::Left)),
        (Key::U, "Up (U)", Some(Way::Up)),
        (Key::D, "Down (D)", Some(Way::Down)),
        (Key::T, "Towards you (T)", Some(Way::Towards)),
        (Key::A, "Away (A)", Some(Way::Away)),
        (Key::N, "Nothing felt (N)", None),
    ];
    for (key, button, way) in ways {
        assert_eq!(wishes(Screen::AskPushed, &[key]), [Wish::Felt(way)]);
        let mut desk = shown(Screen::AskPushed);
        desk.get_by_label(button).click();
        desk.run_steps(2);
        assert_eq!(desk.state().wishes, [Wish::Felt(way)]);
    }
    for (key, button, open) in [
        (Key::O, "Open (O)", Some(true)),
        (Key::S, "Shut (S)", Some(false)),
        (Key::N, "Nothing felt (N)", None),
    ] {
        assert_eq!(
            wishes(Screen::AskFingers, &[key]),
            [Wish::FeltFingers(open)]
        );
        let mut desk = shown(Screen::AskFingers);
        desk.get_by_label(button).click();
        desk.run_steps(2);
        assert_eq!(desk.state().wishes, [Wish::FeltFingers(open)]);
    }
    for (key, has) in [(Key::Y, true), (Key::J, true), (Key::N, false)] {
        assert_eq!(wishes(Screen::AskScale, &[key]), [Wish::HasScale(has)]);
        assert_eq!(wishes(Screen::AskLeft, &[key]), [Wish::Left(has)]);
    }
}

#[test]
fn a_weight_is_typed_and_taken_with_enter() {
    let mut desk = shown(Screen::AskPressed {
        grams: String::new(),
        wrong: false,
    });
    desk.event(egui::Event::Text("51,5".into()));
    desk.run_steps(2);
    desk.key_press(Key::Enter);
    desk.run_steps(2);
    let wanted = [Wish::Grams("51,5".into()), Wish::TakeGrams];
    assert_eq!(desk.state().wishes, wanted);
    assert!(desk.query_by_label_contains("no weight").is_none());
    let wrong = shown(Screen::AskPressed {
        grams: "5l".into(),
        wrong: true,
    });
    wrong.get_by_label_contains("no weight");
}

#[test]
fn the_answer_is_hidden_while_the_handle_pushes() {
    for screen in [Screen::Push { force_n: 0.3 }, Screen::AskPushed] {
        let desk = shown(screen);
        assert_eq!(desk.query_all_by_label("hidden").count(), 3);
        assert!(desk.query_by_label("-0.30").is_none());
    }
    shown(Screen::Hold).get_by_label("-0.30");
    for screen in [Screen::PushFingers { force_n: 1.0 }, Screen::AskFingers] {
        let desk = shown(screen);
        assert_eq!(desk.query_all_by_label("hidden").count(), 5);
        assert!(desk.query_by_label("-0.75").is_none());
    }
    shown(Screen::Open).get_by_label("-0.75");
}

#[test]
fn the_outcome_has_every_check_and_closes() {
    let desk = shown(Screen::Ended(ended()));
    for told in [
        "The device did not pass",
        "move right: ok",
        "push up: failed",
        "scale: left out",
        "response: not judged",
        "0.3 N up, felt down: the force has the wrong sign",
    ] {
        desk.get_by_label(told);
    }
    for key in [Key::Enter, Key::Escape] {
        let wishes = wishes(Screen::Ended(ended()), &[key]);
        assert_eq!(wishes, [Wish::Close]);
    }
    let passed = Ended {
        passed: true,
        ..ended()
    };
    shown(Screen::Ended(passed)).get_by_label("The device passed");
}

#[test]
fn the_title_of_the_window_says_the_step_in_every_language() {
    for language in Language::ALL {
        for (name, mut view) in views() {
            view.words = Words::new(language);
            let title = view.title();
            assert!(title.starts_with("Calot: "), "{name}: {title}");
            assert!(!title.contains("feel-"), "{name}: {title}");
        }
    }
}
