//! Screens of the launcher by accessible name, by pointer and by keyboard alone.

use display_host::ui::launcher::{
    Asking, Debrief, DeviceLine, DeviceState, Earlier, Failed, Launcher, LessonView, LevelView,
    MetricRow, Points, ProgressView, Running, Screen, Start, StartForm, TaskProgress, Wish,
    launcher,
};
use display_host::ui::{Look, TaskNote};
use display_host::words::{Language, Words};
use egui::Key;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

struct Seen {
    state: Launcher,
    wishes: Vec<Wish>,
}

fn harness_in(language: Language, screen: Screen) -> Harness<'static, Seen> {
    let seen = Seen {
        state: Launcher {
            words: Words::new(language),
            look: Look::default(),
            screen,
        },
        wishes: Vec::new(),
    };
    let show = |area: &mut egui::Ui, seen: &mut Seen| {
        let wishes = launcher(area, &seen.state);
        // Show a choice in the next frame, as the launcher does.
        for wish in &wishes {
            if let (Wish::Form(form), Screen::Start(start)) = (wish, &mut seen.state.screen) {
                start.form = form.clone();
            }
        }
        seen.wishes.extend(wishes);
    };
    // As in the product, a character without a font is a box.
    Harness::builder()
        .allow_missing_glyphs()
        .with_size([1280.0, 860.0])
        .build_ui_state(show, seen)
}

fn harness(screen: Screen) -> Harness<'static, Seen> {
    harness_in(Language::English, screen)
}

fn texts(all: &[&str]) -> Vec<String> {
    all.iter().map(|it| (*it).to_owned()).collect()
}

fn start() -> Start {
    Start {
        form: StartForm {
            task: "identify".into(),
            difficulty: "beginner".into(),
            scene: "triangle".into(),
            emulated: true,
            ..StartForm::default()
        },
        trainees: texts(&["Ada", "Bo"]),
        tasks: texts(&[
            "identify",
            "clamp",
            "cut",
            "disconnect",
            "full",
            "free",
            "scope",
        ]),
        hanging: texts(&["identify", "full", "free"]),
        shown: texts(&["identify", "scope"]),
        difficulties: texts(&["beginner", "trainee", "exam"]),
        scopes: vec![0, 30, 45],
        scenes: texts(&["triangle", "built-in", "/home/ada/liver.calot"]),
        devices: vec![
            DeviceLine {
                name: "device-haptic",
                state: DeviceState::There("/dev/ttyACM0".into()),
            },
            DeviceLine {
                name: "device-tracker",
                state: DeviceState::Missing("/dev/ttyUSB3".into()),
            },
            DeviceLine {
                name: "device-pedal",
                state: DeviceState::Emulated,
            },
        ],
        store: "/home/ada/store.sqlite".into(),
        ..Start::default()
    }
}

fn debrief() -> Debrief {
    Debrief {
        trainee: "Ada".into(),
        task: "clamp".into(),
        difficulty: "exam".into(),
        outcome: "failed".into(),
        reasons: vec![assess::Reason::TooLong { seconds: 600.0 }],
        score: 61.0,
        lessons: vec![LessonView {
            note: TaskNote {
                kind: "burnt".into(),
                organ: Some("liver".into()),
            },
            moments: vec![[75.5, 80.0], [90.0, 94.5]],
            close: None,
        }],
        lost: vec![("blood_ml".into(), 4.5)],
        can_replay: true,
        metrics: vec![
            MetricRow {
                name: "time_s".into(),
                unit: "s".into(),
                value: Some(700.0),
                passes: Some([f64::NEG_INFINITY, 600.0]),
                best: Some(512.5),
            },
            MetricRow {
                name: "economy".into(),
                unit: "1".into(),
                ..MetricRow::default()
            },
        ],
        earlier: vec![Earlier {
            when: "yesterday".into(),
            outcome: "passed".into(),
            score: 88.0,
        }],
        report: Some("/home/ada/debrief.html".into()),
        ..Debrief::default()
    }
}

fn points(at: usize) -> Points {
    Points {
        asking: Asking::Questions,
        trainee: "Ada".into(),
        items: vec![
            ("anatomy".into(), "?".into()),
            ("own".into(), "How warm is the room?".into()),
        ],
        given: vec![Some(4), None],
        at,
        rater: String::new(),
        problem: None,
    }
}

fn form(harness: &Harness<'_, Seen>) -> StartForm {
    match &harness.state().state.screen {
        Screen::Start(start) => start.form.clone(),
        _ => StartForm::default(),
    }
}

#[test]
fn choices_of_the_start_are_made_by_pointer() {
    let mut desk = harness(Screen::Start(start()));
    desk.run();
    for name in [
        "Bo",
        "Cut: divide both between the clips (3)",
        "Exam",
        "45°",
        "/home/ada/liver.calot",
        "Real, as a station file names them",
    ] {
        desk.get_by_label(name).click();
        desk.run();
    }
    let chosen = form(&desk);
    assert_eq!(
        (&*chosen.trainee, &*chosen.task, &*chosen.difficulty),
        ("Bo", "cut", "exam")
    );
    assert_eq!(
        (chosen.scope_degrees, &*chosen.scene, chosen.emulated),
        (45, "/home/ada/liver.calot", false)
    );
    desk.get_by_label("Begin (Enter)").click();
    desk.run();
    assert_eq!(desk.state().wishes.last(), Some(&Wish::Begin));
    desk.get_by_label("Deutsch").click();
    desk.run();
    assert_eq!(form(&desk).language, Language::German);
}

#[test]
fn the_sutures_are_the_trainees_where_nothing_is_done_before() {
    let own = "Place the stay sutures of the gallbladder myself";
    let mut desk = harness(Screen::Start(start()));
    desk.run();
    desk.get_by_label(own).click();
    desk.run();
    assert!(form(&desk).own_sutures);
    desk.key_press(Key::Num3);
    desk.run();
    assert!(
        desk.query_by_label(own).is_none(),
        "a task that begins with cutting has its sutures"
    );
}

#[test]
fn enter_begins_numbers_choose_the_task_and_n_writes_a_name() {
    let mut desk = harness(Screen::Start(start()));
    desk.run();
    desk.key_press(Key::Num6);
    desk.run();
    assert_eq!(form(&desk).task, "free");
    desk.key_press(Key::N);
    desk.run();
    desk.event(egui::Event::Text("Cy".into()));
    // In a name a digit selects no task.
    desk.key_press(Key::Num2);
    desk.run();
    assert_eq!((&*form(&desk).trainee, &*form(&desk).task), ("Cy", "free"));
    desk.key_press(Key::Enter);
    desk.run();
    assert!(!desk.state().wishes.contains(&Wish::Begin));
    desk.key_press(Key::Enter);
    desk.run();
    assert_eq!(desk.state().wishes.last(), Some(&Wish::Begin));
    quit_by_key(&mut desk);
}

/// The field is for another person than the one of the list who is chosen.
#[test]
fn a_new_name_does_not_continue_that_of_the_chosen_trainee() {
    let mut listed = start();
    listed.form.trainee = listed.trainees[0].clone();
    for by_key in [true, false] {
        let mut desk = harness(Screen::Start(listed.clone()));
        desk.run();
        if by_key {
            desk.key_press(Key::N);
        } else {
            let fields: Vec<_> = desk.get_all_by_role(Role::TextInput).collect();
            fields[0].click();
        }
        desk.run();
        desk.run();
        desk.event(egui::Event::Text("Cy".into()));
        desk.run();
        assert_eq!(form(&desk).trainee, "Cy", "by key: {by_key}");
    }
}

/// Esc does not quit the launcher, which has other screens that Esc leaves. Ctrl+Q does.
fn quit_by_key(desk: &mut Harness<'_, Seen>) {
    desk.key_press(Key::Escape);
    desk.run();
    assert!(!desk.state().wishes.contains(&Wish::Quit));
    desk.key_press_modifiers(egui::Modifiers::COMMAND, Key::Q);
    desk.run();
    assert_eq!(desk.state().wishes.last(), Some(&Wish::Quit));
}

#[test]
fn every_choice_is_reached_by_tab_alone() {
    let mut desk = harness(Screen::Start(start()));
    desk.run();
    let mut wanted = texts(&[
        "Ada",
        "Exam",
        "30°",
        "Real, as a station file names them",
        "Deutsch",
    ]);
    for _ in 0..80 {
        desk.key_press(Key::Tab);
        desk.run();
        wanted.retain(|name| !desk.get_by_label(name).is_focused());
    }
    assert!(wanted.is_empty(), "never reached: {wanted:?}");
}

#[test]
fn devices_are_told_with_what_happens_where_one_is_missing() {
    let told = |emulated| {
        let mut it = Start {
            problem: Some("the store is busy".into()),
            station_file_problem: Some("line 3: no such driver".into()),
            slow_per_second: Some(3.25),
            ..start()
        };
        it.form.emulated = emulated;
        harness(Screen::Start(it))
    };
    let mut desk = told(true);
    desk.run();
    let serial = desk.query_by_label_contains("serial");
    assert!(serial.is_none(), "it says nothing to who has no device");
    let mut desk = told(false);
    desk.run();
    for told in [
        "Haptic device: /dev/ttyACM0 connected",
        "Endoscope tracker: /dev/ttyUSB3 not found. Plug it in, or choose simulated devices",
        "Foot pedal: simulated",
        "the store is busy",
        "In the last operation this computer drew only 3.2 pictures a second: too few to train with. A graphics card helps.",
        "line 3: no such driver",
        "No serial device or pedal is connected.",
        "A guest's session lies in the folder of sessions, but counts for nobody: choose or enter a name to see your progress.",
    ] {
        desk.get_by_label(told);
    }
}

#[test]
fn the_expert_can_be_watched_in_the_tasks_that_it_shows_and_is_named() {
    for (task, is_shown) in [("scope", true), ("free", false)] {
        let mut shown = start();
        shown.form.task = task.into();
        let mut desk = harness(Screen::Start(shown));
        desk.run();
        let button = desk.query_all_by_label("Watch the expert (W)");
        assert_eq!(button.count(), usize::from(is_shown), "{task}");
        desk.key_press(Key::W);
        desk.run();
        let wished = desk.state().wishes.contains(&Wish::Watch);
        assert_eq!(wished, is_shown, "{task}");
    }
    let expert = "The expert (a scripted surgeon)";
    let mut desk = harness(Screen::Running(Running {
        watched: true,
        task: "clamp".into(),
        ..Running::default()
    }));
    desk.run();
    desk.get_by_label(expert);
    let mut desk = harness(Screen::Debrief(Debrief {
        watched: true,
        trainee: String::new(),
        ..debrief()
    }));
    desk.run();
    assert!(desk.query_all_by_label_contains(expert).count() >= 1);
    desk.get_by_label("Your turn (Enter)");
}

#[test]
fn an_operation_that_runs_can_be_stopped_and_one_that_hangs_too() {
    for (ending, overdue, title, wish) in [
        (false, false, "Preparing the operation", Some(Wish::Stop)),
        // A second S does not discard the report.
        (true, false, "Ending the operation", None),
        (true, true, "Ending the operation", Some(Wish::StopAtOnce)),
    ] {
        let mut desk = harness(Screen::Running(Running {
            trainee: "Ada".into(),
            watched: false,
            task: "free".into(),
            preparing: Some("preparing 40 %".into()),
            ending,
            overdue,
        }));
        desk.run();
        for told in [title, "Ada", "Free practice", "preparing 40 %"] {
            desk.get_by_label(told);
        }
        // The task's clock stands in the operation's own window.
        assert_eq!(desk.query_all_by_label_contains("Time").count(), 0);
        // A second Enter at the start does not end the operation.
        desk.key_press(Key::Enter);
        desk.run();
        desk.key_press(Key::S);
        desk.run();
        assert_eq!(desk.state().wishes.as_slice(), wish.as_slice());
    }
}

#[test]
fn a_key_that_is_held_asks_once_and_still_edits() {
    let mut desk = harness(Screen::Running(Running::default()));
    desk.run();
    for _ in 0..3 {
        desk.key_down(Key::S);
        desk.run();
    }
    assert_eq!(desk.state().wishes, [Wish::Stop]);

    let mut desk = harness(Screen::Debrief(debrief()));
    desk.run();
    for _ in 0..3 {
        desk.key_down(Key::Enter);
        desk.run();
    }
    assert_eq!(desk.state().wishes, [Wish::Again]);

    let mut desk = harness(Screen::Start(start()));
    desk.run();
    desk.key_press(Key::N);
    desk.run();
    desk.event(egui::Event::Text("Cyril".into()));
    desk.run();
    for _ in 0..3 {
        desk.key_down(Key::Backspace);
        desk.run();
    }
    assert_eq!(form(&desk).trainee, "Cy");
}

#[test]
fn escape_leaves_a_field_and_never_the_launcher() {
    let mut by_file = start();
    by_file.form.emulated = false;
    let mut desk = harness(Screen::Start(by_file));
    desk.run();
    for field in 0..2 {
        let fields: Vec<_> = desk.get_all_by_role(Role::TextInput).collect();
        fields[field].focus();
        desk.run();
        desk.key_press(Key::Escape);
        desk.run();
        assert!(!desk.state().wishes.contains(&Wish::Quit), "{field}");
    }
    quit_by_key(&mut desk);
}

#[test]
fn a_debrief_tells_outcome_errors_and_what_counts() {
    let mut desk = harness(Screen::Debrief(Debrief {
        sheet: Some(19),
        notice: Some("it is opened".into()),
        ..debrief()
    }));
    desk.run();
    for told in [
        "Failed",
        "Score: 61 of 100",
        "It took longer than 600 s",
        "Burnt: liver  2×",
        "Blood loss: −4.5 points",
        "yesterday  Passed, Score: 88 of 100",
        "700 s",
        "≤ 600 s",
        "512 s",
        "Straightness of movements",
        "Instructor's assessment: 19 of 25",
        "it is opened",
    ] {
        assert!(desk.query_all_by_label(told).count() > 0, "{told}");
    }
}

#[test]
fn a_trainee_reads_that_results_are_kept_and_no_path() {
    let mut named = start();
    named.form.trainee = "Ada".into();
    let mut desk = harness(Screen::Start(named));
    desk.run();
    desk.get_by_label("Your results are kept under this name.");
    assert!(desk.query_by_label_contains("store.sqlite").is_none());
}

fn progress() -> ProgressView {
    let task = |task: &str, passes: usize| TaskProgress {
        task: task.into(),
        difficulty: "beginner".into(),
        passes: [passes, 2],
        is_proficient: passes == 2,
    };
    ProgressView {
        done: [1, 12],
        levels: vec![LevelView {
            title: "First steps".into(),
            tasks: vec![task("basics", 2), task("scope", 1)],
        }],
        next: Some(("scope".into(), "beginner".into())),
        has_certificate: false,
    }
}

#[test]
fn whoever_is_new_is_offered_the_guided_first_steps() {
    for is_first in [true, false] {
        let mut desk = harness(Screen::Start(Start {
            is_first,
            ..start()
        }));
        desk.run();
        desk.key_press(Key::G);
        desk.run();
        assert_eq!(desk.state().wishes.contains(&Wish::Guided), is_first);
    }
    let mut desk = harness(Screen::Start(Start {
        is_first: true,
        ..start()
    }));
    desk.run();
    desk.get_by_label("Begin the first steps (G)").click();
    desk.run();
    assert_eq!(desk.state().wishes, [Wish::Guided]);
}

#[test]
fn progress_is_shown_and_leads_to_the_next_task() {
    let mut desk = harness(Screen::Start(Start {
        progress: Some(progress()),
        ..start()
    }));
    desk.run();
    desk.get_by_label("Proficient in 1 of 12 goals");
    desk.get_by_label("All levels").click();
    desk.run();
    desk.get_by_label("Endoscope, Beginner: 1 of 2 passes in a row");
    desk.get_by_label("Next: Endoscope, Beginner").click();
    desk.run();
    assert_eq!(
        (&*form(&desk).task, &*form(&desk).difficulty),
        ("scope", "beginner")
    );
    let after = || Debrief {
        progress: Some(progress()),
        ..debrief()
    };
    let mut desk = harness(Screen::Debrief(after()));
    desk.run();
    desk.get_by_label("Next: Endoscope, Beginner (N)").click();
    desk.run();
    desk.key_press(Key::N);
    desk.run();
    assert_eq!(desk.state().wishes, [Wish::Next, Wish::Next]);
    let mut desk = harness(Screen::Debrief(Debrief {
        progress: Some(ProgressView {
            next: None,
            ..progress()
        }),
        ..debrief()
    }));
    desk.run();
    desk.get_by_label("The curriculum is complete.");
    desk.key_press(Key::N);
    desk.run();
    assert!(desk.state().wishes.is_empty());
}

#[test]
fn a_completed_level_has_a_certificate() {
    for has_certificate in [false, true] {
        let view = || ProgressView {
            has_certificate,
            ..progress()
        };
        let screens = [
            Screen::Start(Start {
                progress: Some(view()),
                ..start()
            }),
            Screen::Debrief(Debrief {
                progress: Some(view()),
                ..debrief()
            }),
        ];
        for screen in screens {
            let mut desk = harness(screen);
            desk.run();
            desk.key_press(Key::C);
            desk.run();
            let wishes = usize::from(has_certificate);
            assert_eq!(desk.state().wishes, vec![Wish::Certificate; wishes]);
            let button = desk.query_by_label("Certificate (C)");
            assert_eq!(button.is_some(), has_certificate);
            if let Some(button) = button {
                button.click();
                desk.run();
                assert_eq!(desk.state().wishes, vec![Wish::Certificate; 2]);
            }
        }
    }
}

/// The built-in fonts stand for a computer without fonts of its own.
#[test]
fn a_name_without_a_font_is_told_and_kept() {
    let told = "This computer has no font for this name";
    for (name, lacks) in [("Ada \u{141}", false), ("\u{5F20}\u{4F1F}", true)] {
        let mut desk = harness(Screen::Start(Start {
            form: StartForm {
                trainee: name.into(),
                ..start().form
            },
            ..start()
        }));
        desk.run();
        let found = desk.query_all_by_label_contains(told).count();
        assert_eq!(found > 0, lacks, "{name}");
        assert_eq!(form(&desk).trainee, name);
    }
}

#[test]
fn an_error_is_replayed_where_it_was_recorded() {
    let mut desk = harness(Screen::Debrief(debrief()));
    desk.run();
    for told in [
        "See the whole bare tip of the hook",
        "Next time: Clip or coagulate",
    ] {
        assert!(desk.query_all_by_label_contains(told).count() > 0, "{told}");
    }
    desk.get_by_label("Replay 1:30").click();
    desk.run();
    assert_eq!(desk.state().wishes, [Wish::Replay(94.5)]);
    let mut desk = harness(Screen::Debrief(Debrief {
        can_replay: false,
        ..debrief()
    }));
    desk.run();
    assert_eq!(desk.query_all_by_label_contains("Replay").count(), 0);
    desk.get_by_label("1:30");
}

#[test]
fn a_debrief_leads_on_by_pointer_and_key() {
    for (name, key, wish) in [
        ("Again (Enter)", Key::Enter, Wish::Again),
        ("Another task (Esc)", Key::Escape, Wish::Another),
        ("Open the full report (R)", Key::R, Wish::OpenReport),
        ("Questionnaire (Q)", Key::Q, Wish::Ask(Asking::Questions)),
        (
            "Instructor's assessment (I)",
            Key::I,
            Wish::Ask(Asking::Sheet),
        ),
    ] {
        let mut desk = harness(Screen::Debrief(debrief()));
        desk.run();
        desk.get_by_label(name).click();
        desk.run();
        assert_eq!(desk.state().wishes, std::slice::from_ref(&wish), "{name}");
        let mut desk = harness(Screen::Debrief(debrief()));
        desk.run();
        desk.key_press(key);
        desk.run();
        assert_eq!(desk.state().wishes, [wish], "{key:?}");
    }
    // A guest's session without a report offers neither button nor key for these.
    let mut desk = harness(Screen::Debrief(Debrief {
        trainee: String::new(),
        report: None,
        ..debrief()
    }));
    desk.run();
    for key in [Key::R, Key::Q, Key::I] {
        desk.key_press(key);
        desk.run();
    }
    assert!(desk.state().wishes.is_empty());
}

/// On a slow machine several keys arrive in one frame. Of two task numbers the last one counts.
/// Each number answers an item, and Enter after the last answer saves the answers.
#[test]
fn keys_of_one_frame_are_taken_in_their_order() {
    let press = |desk: &mut Harness<'_, Seen>, keys: [Key; 2]| {
        let event = |key| egui::Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: egui::Modifiers::NONE,
        };
        desk.input_mut().events.extend(keys.map(event));
        desk.run();
    };
    let mut desk = harness(Screen::Start(start()));
    desk.run();
    press(&mut desk, [Key::Num7, Key::Num6]);
    assert_eq!(form(&desk).task, "free");

    let mut desk = harness(Screen::Points(points(0)));
    desk.run();
    press(&mut desk, [Key::Num5, Key::Num2]);
    assert_eq!(desk.state().wishes, [Wish::Answer(5), Wish::Answer(2)]);

    // Enter arrives before the picture that follows the last answer.
    let mut desk = harness(Screen::Points(points(1)));
    desk.run();
    press(&mut desk, [Key::Num5, Key::Enter]);
    assert_eq!(desk.state().wishes, [Wish::Answer(5), Wish::Keep]);
}

#[test]
fn questions_are_answered_by_pointer_and_key_and_taken_back() {
    let mut desk = harness(Screen::Points(points(0)));
    desk.run();
    desk.get_by_label("How realistic is the anatomy?");
    desk.get_by_label("1 of 2");
    desk.get_by_label("  3  ").click();
    desk.run();
    desk.key_press(Key::Num5);
    desk.run();
    assert_eq!(desk.state().wishes, [Wish::Answer(3), Wish::Answer(5)]);

    // What does not apply may be left out, except from an instructor's sheet.
    for (asking, wishes) in [
        (Asking::Questions, &[Wish::Answer(0), Wish::Answer(0)][..]),
        (Asking::Sheet, &[]),
    ] {
        let mut desk = harness(Screen::Points(Points {
            asking,
            ..points(0)
        }));
        desk.run();
        let skip = desk.query_by_label("Does not apply to me (0)");
        assert_eq!(skip.is_some(), !wishes.is_empty());
        if let Some(skip) = skip {
            skip.click();
            desk.run();
        }
        desk.key_press(Key::Num0);
        desk.run();
        assert_eq!(desk.state().wishes, wishes);
    }

    let mut desk = harness(Screen::Points(points(1)));
    desk.run();
    desk.get_by_label("How warm is the room?");
    assert!(desk.query_by_label_contains("GOALS").is_none());
    desk.key_press(Key::Backspace);
    desk.run();
    desk.key_press(Key::Escape);
    desk.run();
    assert_eq!(desk.state().wishes, [Wish::Previous, Wish::Back]);

    let mut all = points(2);
    all.problem = Some("the store is busy".into());
    let mut desk = harness(Screen::Points(all));
    desk.run();
    desk.get_by_label("4   How realistic is the anatomy?");
    desk.get_by_label("the store is busy");
    // After the last item a digit answers nothing.
    desk.key_press(Key::Num1);
    desk.run();
    desk.key_press(Key::Enter);
    desk.run();
    assert_eq!(desk.state().wishes, [Wish::Keep]);
}

#[test]
fn a_sheet_names_goals_and_asks_for_its_rater() {
    let sheet = |at| {
        Screen::Points(Points {
            asking: Asking::Sheet,
            rater: "B".into(),
            ..points(at)
        })
    };
    let mut desk = harness(sheet(0));
    desk.run();
    desk.get_by_label_contains("GOALS");
    let mut desk = harness(sheet(2));
    desk.run();
    desk.get_by_role(Role::TextInput).focus();
    desk.run();
    desk.get_by_role(Role::TextInput).type_text("o");
    desk.run();
    // In the field, Backspace takes a letter and no answer, and Esc leaves the field alone.
    desk.key_press(Key::Backspace);
    desk.run();
    desk.key_press(Key::Escape);
    desk.run();
    let wishes = &desk.state().wishes;
    let lengths: Vec<_> = (wishes.iter())
        .map(|it| match it {
            Wish::Rater(name) => name.len(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(lengths, [2, 0], "a letter more, then a letter less than B");
    desk.key_press(Key::Escape);
    desk.run();
    assert_eq!(desk.state().wishes.last(), Some(&Wish::Back));
}

#[test]
fn a_long_notice_leaves_all_buttons_in_the_window() {
    let mut desk = harness(Screen::Debrief(debrief()));
    desk.run();
    if let Screen::Debrief(it) = &mut desk.state_mut().state.screen {
        it.notice = Some("a path of many folders/".repeat(20));
    }
    desk.step();
    assert!(
        desk.ctx.has_requested_repaint(),
        "the height is of the frame before"
    );
    desk.step();
    let last = desk.get_by_label("Instructor's assessment (I)").rect();
    assert!(last.max.y <= 860.0, "{last:?}");
}

#[test]
fn an_unfinished_task_says_why_it_has_no_score_in_one_line_with_its_steps() {
    let open = |count| {
        let organ = "cystic duct".into();
        assess::Reason::NotDone {
            step: assess::Step::Clip { organ, count },
        }
    };
    let mut desk = harness(Screen::Debrief(Debrief {
        outcome: "aborted".into(),
        unfinished: Some(80.0),
        reasons: vec![open(2), open(1)],
        ..debrief()
    }));
    desk.run();
    for told in [
        "The task is not finished, so the score is 0. The work up to here would have had 80 points.",
        "Not done: Place 2 clips on the cystic duct; Place a clip on the cystic duct",
        "Not done: Place 2 clips on the cystic duct",
    ] {
        desk.get_by_label(told);
    }
    let mut desk = harness(Screen::Debrief(debrief()));
    desk.run();
    assert!(desk.query_by_label_contains("is not finished").is_none());
}

#[test]
fn an_operation_that_failed_says_why_and_leads_on() {
    let failed = Failed {
        status: "exit status: 1".into(),
        said: texts(&["/dev/ttyACM0: no such file"]),
        had_devices: true,
    };
    for (name, wish) in [
        ("Try again (Enter)", Wish::Again),
        ("Try with simulated devices", Wish::AgainEmulated),
        ("Another task (Esc)", Wish::Another),
        ("Quit", Wish::Quit),
    ] {
        let mut desk = harness(Screen::Failed(failed.clone()));
        desk.run();
        desk.get_by_label("/dev/ttyACM0: no such file");
        desk.get_by_label("The station stopped: exit status: 1");
        desk.get_by_label(name).click();
        desk.run();
        assert_eq!(desk.state().wishes, [wish]);
    }
    let mut desk = harness(Screen::Failed(Failed {
        had_devices: false,
        ..failed
    }));
    desk.run();
    let emulated = desk.query_all_by_label("Try with simulated devices");
    assert_eq!(emulated.count(), 0);
}

#[test]
fn every_screen_speaks_every_language_and_fits_a_small_one() {
    for language in Language::ALL {
        for screen in [
            Screen::Start(start()),
            Screen::Running(Running {
                task: "scope".into(),
                ..Running::default()
            }),
            Screen::Debrief(debrief()),
            Screen::Points(points(0)),
            Screen::Points(Points {
                asking: Asking::Sheet,
                items: vec![("tissue".into(), "?".into())],
                ..points(0)
            }),
            Screen::Failed(Failed::default()),
        ] {
            let title = Launcher {
                words: Words::new(language),
                look: Look::default(),
                screen: screen.clone(),
            }
            .title();
            assert!(!title.contains("launcher-"), "{title}");
            let mut desk = harness_in(language, screen);
            desk.set_size(egui::vec2(800.0, 600.0));
            desk.run();
            // A missing message is shown as its id.
            for id in [
                "task-",
                "start-",
                "running-",
                "debrief-",
                "metric-",
                "points-",
                "question-",
                "goals-",
                "failed-",
                "difficulty-",
                "outcome-",
                "alarm-",
                "advice-",
                "page-",
                "progress-",
                "settings-",
            ] {
                let shown = desk.query_all_by_label_contains(id).count();
                assert_eq!(shown, 0, "{language:?}: {id}");
            }
        }
    }
}
