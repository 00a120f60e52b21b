//! The panel by accessible name, without a picture or a controller.

use assess::{Advice, Hint, Instrument, Step};
use display_host::ui::{
    ActsView, Asked, Bulletin, Link, Look, Overlay, RecordingView, ReplayView, Settings, TaskEnd,
    TaskNote, TaskView, TickHealth, UiState, ui,
};
use display_host::words::{Language, Words};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use shared_mem::message::{DeviceHealth, TimingBatch, ToolFrame};
use shared_mem::words::ActKind;

struct Seen {
    state: UiState,
    asked: Vec<Asked>,
}

fn harness(state: UiState) -> Harness<'static, Seen> {
    let seen = Seen {
        state,
        asked: Vec::new(),
    };
    let show = |area: &mut egui::Ui, seen: &mut Seen| {
        let (asked, _) = ui(area, &seen.state);
        seen.asked.extend(asked);
    };
    Harness::builder()
        .with_size([1100.0, 1000.0])
        .build_ui_state(show, seen)
}

fn live() -> UiState {
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    tools.switches = 16;
    tools.force_n = [0.0, 3.0, 4.0];
    tools.health[0].status = DeviceHealth::LIVE;
    tools.health[0].age_us = 400;
    tools.health[1].status = DeviceHealth::STALE;
    tools.health[1].age_us = 81_000;
    tools.health[2].status = DeviceHealth::LOST;
    UiState {
        station: "here".into(),
        scene: "Liver and gallbladder".into(),
        task: "Press the liver".into(),
        link: Link::Live,
        tools: Some(tools),
        ..UiState::default()
    }
}

/// The engineering view shows the machine, of which a trainee sees nothing while it works.
fn engineering() -> UiState {
    UiState {
        overlay: Some(Overlay::default()),
        ..live()
    }
}

#[test]
fn a_trainee_sees_of_the_machine_only_what_fails() {
    let alarmed = |state: UiState| UiState {
        alarm: Some("draw it out".into()),
        machine_alarm: Some("the device is late".into()),
        frames_per_second: 3.0,
        ..state
    };
    let mut panel = harness(alarmed(live()));
    panel.run();
    panel.get_by_label("Alarm: draw it out");
    panel.get_by_label("Foot pedal: connection lost; plug it in again");
    panel.get_by_label(
        "This computer draws only 3.0 pictures a second: too few to train with. A graphics card helps.",
    );
    for machine in [
        "is late",
        "Safety chain",
        "Ticks",
        "last reading",
        "Controller",
    ] {
        let shown = panel.query_all_by_label_contains(machine).count();
        assert_eq!(shown, 0, "{machine}");
    }
    for state in [
        engineering(),
        UiState {
            instructor: true,
            ..live()
        },
    ] {
        let mut panel = harness(alarmed(state));
        panel.run();
        panel.get_by_label("Alarm: the device is late");
        panel.get_by_label("Alarm: draw it out");
        panel.get_by_label("Acknowledge (A)");
    }
}

#[test]
fn every_control_works_by_pointer() {
    let mut panel = harness(live());
    for (name, asked) in [
        ("Pause (P)", Asked::Pause(true)),
        ("Reset organs (R)", Asked::Reset),
        ("Disable force (F)", Asked::EnableForce(false)),
        ("Engineering view (E)", Asked::ToggleEngineering),
        ("Control with mouse and keyboard (M)", Asked::ToggleHand),
        ("Scissors (3)", Asked::Instrument(2)),
        ("Next endoscope (S)", Asked::NextScope),
        ("Focus nearer (-)", Asked::TurnFocus(-1)),
        ("Clean lens (W)", Asked::WipeLens),
        ("Quit (Esc)", Asked::Quit),
    ] {
        panel.get_by_label(name).click();
        panel.run();
        assert_eq!(panel.state().asked.last(), Some(&asked), "{name}");
    }
}

#[test]
fn every_control_works_by_key() {
    let mut panel = harness(live());
    for (key, asked) in [
        (egui::Key::P, Asked::Pause(true)),
        (egui::Key::R, Asked::Reset),
        (egui::Key::F, Asked::EnableForce(false)),
        (egui::Key::Num4, Asked::Instrument(3)),
        (egui::Key::Num5, Asked::Instrument(4)),
        (egui::Key::E, Asked::ToggleEngineering),
        (egui::Key::M, Asked::ToggleHand),
        (egui::Key::H, Asked::TogglePanel),
        (egui::Key::F11, Asked::ToggleFullScreen),
        (egui::Key::S, Asked::NextScope),
        (egui::Key::OpenBracket, Asked::TurnScope(-1)),
        (egui::Key::CloseBracket, Asked::TurnScope(1)),
        (egui::Key::Minus, Asked::TurnFocus(-1)),
        (egui::Key::Plus, Asked::TurnFocus(1)),
        (egui::Key::W, Asked::WipeLens),
        (egui::Key::Escape, Asked::Quit),
    ] {
        panel.key_press(key);
        panel.run();
        assert_eq!(panel.state().asked, [asked]);
        panel.state_mut().asked.clear();
    }
}

#[test]
fn a_button_is_reached_and_pressed_by_keyboard_alone() {
    let mut panel = harness(live());
    for _ in 0..40 {
        panel.key_press(egui::Key::Tab);
        panel.run();
        if panel.get_by_label("Reset organs (R)").is_focused() {
            break;
        }
    }
    panel.key_press(egui::Key::Enter);
    panel.run();
    assert_eq!(panel.state().asked, [Asked::Reset]);
}

#[test]
fn devices_and_force_are_told_in_words() {
    let mut panel = harness(engineering());
    panel.run();
    panel.get_by_label("Haptic device: ready, last reading 0.4 ms ago");
    panel.get_by_label("Endoscope tracker: delayed, last reading 81 ms ago");
    panel.get_by_label("Foot pedal: connection lost; plug it in again");
    panel.get_by_label("Force on the hand: 5.00 N");
    panel.get_by_label("Controller: live");
    panel.get_by_label("Ticks: none recorded yet");
}

#[test]
fn ticks_that_are_not_realtime_say_what_they_lack() {
    let mut health = TickHealth::default();
    let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
    batch.count = 1;
    batch.records[0].wake_latency_ns = 52_000;
    batch.records[0].tick_ns = 180_000;
    batch.missed_periods = 3;
    batch.realtime = TimingBatch::LOCKED;
    health.take(&batch);
    let mut panel = harness(UiState {
        health,
        ..engineering()
    });
    panel.run();
    panel.get_by_label("Not real time: missing SCHED_FIFO, a core of its own");
    panel.get_by_label("Missed 3, late 0, allocations 0, page faults 0");
    panel.get_by_label("Wake-up delay: 99 % within 52 µs, longest 52 µs");
}

#[test]
fn a_missing_controller_and_an_alarm_are_no_dead_ends() {
    let mut panel = harness(UiState {
        station: "here".into(),
        alarm: Some("force was cut".into()),
        ..UiState::default()
    });
    panel.run();
    panel.get_by_label("Waiting for the controller of station 'here'.\nStart one with: calot rt");
    panel.get_by_label("Alarm: force was cut");
    panel.get_by_label("Acknowledge (A)").click();
    panel.run();
    assert_eq!(panel.state().asked, [Asked::Acknowledge]);

    let mut panel = harness(UiState {
        link: Link::Silent(2.5),
        ..live()
    });
    panel.run();
    panel.get_by_label("Controller: no response for 2.5 s");
}

#[test]
fn operator_lets_the_instrument_go_before_the_station_ends() {
    let mut panel = harness(UiState {
        in_hand: true,
        ..live()
    });
    panel.key_press(egui::Key::Escape);
    panel.run();
    assert_eq!(panel.state().asked, [Asked::ToggleHand]);
    panel.get_by_label("Release the instrument (M)");
}

#[test]
fn the_safety_chain_tells_what_each_gate_did() {
    let mut health = TickHealth::default();
    let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
    batch.faults[5] = 2;
    batch.faults[7] = 40;
    health.take(&batch);
    let mut panel = harness(UiState {
        health,
        ..engineering()
    });
    panel.run();
    panel
        .get_by_label("Safety chain: intervened 42 times")
        .click();
    panel.run();
    panel.get_by_label("2 × switched off: the handle moved too fast");
    panel.get_by_label("40 × smoothed: the force changed too fast");
}

/// State with a picture, on which the task's cards lie.
fn at_work(task: TaskView) -> UiState {
    UiState {
        picture: Some((egui::TextureId::default(), 4.0 / 3.0)),
        task_view: Some(task),
        ..live()
    }
}

fn hint() -> Hint {
    Hint {
        step: Step::Free,
        advice: Advice::Take(Instrument::Hook),
        percent: Some(40),
    }
}

fn clamp() -> TaskView {
    TaskView {
        task: "clamp".into(),
        time_s: 75.0,
        alarms: 2,
        ..TaskView::default()
    }
}

#[test]
fn a_task_shows_time_instrument_clips_pedal_and_what_was_wrong() {
    let mut state = at_work(TaskView {
        alarm: Some(TaskNote {
            kind: "burnt".into(),
            organ: Some("bile duct".into()),
        }),
        hint: Some(hint()),
        ..clamp()
    });
    let tools = state.tools.as_mut().unwrap();
    (tools.instrument, tools.clips_left, tools.switches) = (3, 7, 16 | 2 | 4);
    let mut panel = harness(state);
    panel.run();
    assert_eq!(
        panel.get_all_by_label("Time: 1:15").count(),
        2,
        "panel, picture"
    );
    panel.get_by_label("Clip applier");
    panel.get_by_label("7 clips left");
    panel.get_by_label("No current: only the cautery hook (2) has one");
    panel.get_by_label("Camera locked");
    panel.get_by_label("Alarm: burnt: bile duct");
    panel.get_by_label("Next: Free the gallbladder from the liver: take the cautery hook (2).");
}

#[test]
fn a_guided_step_has_a_sentence_a_picture_a_goal_and_a_next_step() {
    let clip = Step::Clip {
        organ: "cystic duct".into(),
        count: 1,
    };
    let mut panel = harness(at_work(TaskView {
        task: "basics".into(),
        steps: vec![
            (Step::Meet, true),
            (clip.clone(), false),
            (Step::Coagulate, false),
        ],
        hint: Some(Hint {
            step: clip,
            advice: Advice::Use(Instrument::ClipApplier),
            percent: Some(0),
        }),
        ..clamp()
    }));
    panel.run_steps(4);
    let sentence = "Place a clip on the cystic duct: pass both jaws around it, keep the tips in view, then close.";
    assert!(
        panel.query_all_by_label(sentence).count() >= 2,
        "picture and sentence"
    );
    for told in [
        "Step 2 of 3",
        "Goal: one clip closes the tube.",
        "Then: Coagulate a strand of tissue",
    ] {
        panel.get_by_label(told);
    }
}

#[test]
fn a_hint_says_where_to_begin_and_how_much_is_left() {
    let mut panel = harness(at_work(TaskView {
        hint: Some(hint()),
        ..clamp()
    }));
    panel.run();
    panel.get_by_label_contains("Begin at the neck and go towards the fundus.");
    panel.get_by_label_contains("  60 % of this step left");
}

#[test]
fn a_task_that_is_over_says_how_and_leads_on() {
    let mut panel = harness(at_work(TaskView {
        score: Some(64.0),
        end: Some(TaskEnd {
            passed: false,
            outcome: "failed".into(),
            reasons: vec![assess::Reason::Unclamped {
                organ: "cystic duct".into(),
            }],
        }),
        ..clamp()
    }));
    panel.run();
    panel.get_by_label("Failed");
    panel.get_by_label("clips do not close the cystic duct");
    panel.get_by_label("Show the report (Esc)").click();
    panel.run();
    assert_eq!(panel.state().asked, [Asked::Quit]);
}

#[test]
fn a_pause_leads_on_back_and_out_by_pointer_and_key() {
    let paused = || {
        let mut state = at_work(clamp());
        state.tools.as_mut().unwrap().switches |= 8;
        state
    };
    for (name, asked) in [("Restart (R)", Asked::Again), ("End (Esc)", Asked::Quit)] {
        let mut panel = harness(paused());
        panel.run();
        panel.get_by_label("Paused");
        panel.get_by_label(name).click();
        panel.run();
        assert_eq!(panel.state().asked, [asked]);
    }
    for (key, asked) in [
        (egui::Key::P, Asked::Pause(false)),
        (egui::Key::R, Asked::Again),
        (egui::Key::O, Asked::ShowSettings(true)),
    ] {
        let mut panel = harness(paused());
        panel.key_press(key);
        panel.run();
        assert_eq!(panel.state().asked, [asked]);
    }
}

#[test]
fn settings_are_chosen_and_left_by_pointer_and_key() {
    let open = || UiState {
        settings_open: true,
        ..live()
    };
    let usual = Settings::default();
    for (name, settings) in [
        (
            "Deutsch",
            Settings {
                language: Language::German,
                ..usual
            },
        ),
        (
            "125 %",
            Settings {
                look: Look {
                    text_percent: 125,
                    ..Look::default()
                },
                ..usual
            },
        ),
        (
            "off",
            Settings {
                sound: false,
                ..usual
            },
        ),
    ] {
        let mut panel = harness(open());
        panel.get_by_label(name).click();
        panel.step();
        assert!(
            panel.state().asked.contains(&Asked::Set(settings)),
            "{name}"
        );
    }
    let mut panel = harness(open());
    // The keys of the operation are inactive while the settings are open.
    panel.key_press(egui::Key::R);
    panel.run();
    assert!(panel.state().asked.is_empty());
    panel.key_press(egui::Key::Escape);
    panel.run();
    assert_eq!(panel.state().asked, [Asked::ShowSettings(false)]);
}

#[test]
fn panel_is_said_in_every_language() {
    for language in Language::ALL {
        let mut state = at_work(TaskView {
            alarm: Some(TaskNote {
                kind: "too_early".into(),
                organ: Some("cystic duct".into()),
            }),
            hint: Some(hint()),
            steps: vec![(Step::Free, true), (Step::Triangle, false)],
            score: Some(1.0),
            ..clamp()
        });
        state.tools.as_mut().unwrap().switches |= 8;
        state.set(Settings {
            language,
            ..Settings::default()
        });
        let words = Words::new(language);
        for settings_open in [false, true] {
            state.settings_open = settings_open;
            let mut panel = harness(state.clone());
            panel.run();
            if !settings_open {
                panel.get_by_label(&words.say("pause-title"));
                panel.get_by_label(&words.say("switch-reset"));
            } else {
                panel.get_by_label(&words.say("settings-title"));
            }
            // A missing message is shown as its id.
            let ids = [
                "task-",
                "hud-",
                "pause-",
                "alarm-",
                "settings-",
                "switch-",
                "device-",
            ];
            for id in ids {
                let shown = panel.query_all_by_label_contains(id).count();
                assert_eq!(shown, 0, "{language:?}: {id}");
            }
        }
    }
}

#[test]
fn an_instructor_sees_how_an_exam_stands_and_reaches_into_nothing() {
    let bulletin = Bulletin {
        task: TaskView {
            score: Some(64.0),
            steps: vec![(Step::LowerBed, true)],
            ..clamp()
        },
        difficulty: "exam".into(),
        alarms: vec![(
            75.0,
            TaskNote {
                kind: "burnt".into(),
                organ: Some("liver".into()),
            },
        )],
        metrics: vec![("economy".into(), "1".into(), 0.43)],
    };
    let mut state = at_work(bulletin.task.clone());
    (state.instructor, state.bulletin) = (true, Some(bulletin));
    let mut panel = harness(state);
    panel.run();
    for told in [
        "Instructor: station 'here'",
        "Guidance: Exam",
        "Score: 64 of 100",
        "Free the lower third of the gallbladder from its bed (done)",
        "1:15  burnt: liver",
        "Straightness of movements",
        "43 %",
        "Haptic device: ready, last reading 0.4 ms ago",
        "Ticks: none recorded yet",
    ] {
        panel.get_by_label(told);
    }
    for offered in ["Pause (P)", "Reset organs (R)", "Disable force (F)"] {
        assert_eq!(panel.query_all_by_label(offered).count(), 0, "{offered}");
    }
    for key in [
        egui::Key::P,
        egui::Key::R,
        egui::Key::F,
        egui::Key::M,
        egui::Key::Num2,
    ] {
        panel.key_press(key);
        panel.run();
    }
    assert!(panel.state().asked.is_empty());
    panel.key_press(egui::Key::E);
    panel.run();
    panel.key_press(egui::Key::Escape);
    panel.run();
    assert_eq!(panel.state().asked, [Asked::ToggleEngineering, Asked::Quit]);
}

#[test]
fn an_old_task_is_not_shown_once_nobody_tells_of_it() {
    let mut state = UiState {
        instructor: true,
        ..live()
    };
    state.watch(Some(Bulletin {
        task: clamp(),
        ..Bulletin::default()
    }));
    assert!(state.task_view.is_some());
    let mut panel = harness(state);
    panel.run();
    panel.get_by_label("Alarms");
    panel.state_mut().state.watch(None);
    panel.run();
    panel.get_by_label("No task: free work without assessment");
    assert!(panel.state().state.task_view.is_none());
}

/// Acts that were asked for.
fn acts(asked: &[Asked]) -> Vec<(ActKind, String)> {
    let acts = asked.iter().filter_map(|asked| match asked {
        Asked::Act(act) => Some((act.kind().ok()?, act.text()?.to_owned())),
        _ => None,
    });
    acts.collect()
}

#[test]
fn an_instructor_acts_by_button_text_and_a_click_on_the_picture() {
    let mut panel = harness(UiState {
        instructor: true,
        picture: Some((egui::TextureId::default(), 4.0 / 3.0)),
        ..live()
    });
    panel.run();
    for button in ["Pause", "Fog the lens", "Start bleeding", "Let a clip slip"] {
        panel.get_by_label(button).click();
        panel.run();
    }
    let kinds: Vec<_> = acts(&panel.state().asked)
        .into_iter()
        .map(|it| it.0)
        .collect();
    let all = [
        ActKind::Pause,
        ActKind::Fog,
        ActKind::Bleeding,
        ActKind::SlippedClip,
    ];
    assert_eq!(kinds, all);
    panel.state_mut().asked.clear();
    let field = panel.get_by_role_and_label(Role::TextInput, "Remark for the debrief");
    field.focus();
    panel.run();
    let field = panel.get_by_role_and_label(Role::TextInput, "Remark for the debrief");
    field.type_text("Open the jaws, more");
    panel.run();
    // Letters of the remark are no keys of the panel.
    for key in [egui::Key::E, egui::Key::S] {
        panel.key_press(key);
        panel.run();
    }
    assert_eq!(panel.state().asked, []);
    panel.key_press(egui::Key::Enter);
    panel.run();
    let remark = (ActKind::Remark, "Open the jaws, more".to_owned());
    assert_eq!(acts(&panel.state().asked), [remark]);
    panel.state_mut().asked.clear();
    // It stays until the station has saved it.
    let text = |panel: &Harness<'_, Seen>| {
        let field = panel.get_by_role_and_label(Role::TextInput, "Remark for the debrief");
        field.value().unwrap_or_default()
    };
    assert_eq!(text(&panel), "Open the jaws, more");
    panel.state_mut().state.saved_remarks += 1;
    panel.run();
    assert_eq!(text(&panel), "");
    let field = panel.get_by_role_and_label(Role::TextInput, "Remark for the debrief");
    field.focus();
    field.type_text(&"ä".repeat(100));
    panel.run();
    assert_eq!(text(&panel).len(), 176, "88 letters of two bytes");
    panel.get_by_label("Endoscope picture").click();
    panel.run();
    let [Asked::Point(at)] = panel.state().asked[..] else {
        panic!("{:?}", panel.state().asked);
    };
    assert!(at.iter().all(|it| it.abs() < 0.02), "{at:?}");
}

#[test]
fn an_instructor_reads_why_an_act_was_refused() {
    let text = Words::default().say("act-refused-exam");
    let mut panel = harness(UiState {
        instructor: true,
        act_answer: Some((text.clone(), false)),
        ..live()
    });
    panel.run();
    panel.get_by_label(&text);
}

#[test]
fn a_trainee_is_told_that_the_instructor_acts() {
    let mut panel = harness(UiState {
        picture: Some((egui::TextureId::default(), 4.0 / 3.0)),
        acts: ActsView {
            notice: Some((ActKind::Bleeding, None)),
            ..ActsView::default()
        },
        ..live()
    });
    panel.run();
    panel.get_by_label("Instructor");
    panel.get_by_label("Made a vessel bleed");
}

#[test]
fn instructor_without_a_task_is_told_so_and_sees_the_station() {
    let mut panel = harness(UiState {
        instructor: true,
        ..live()
    });
    panel.run();
    panel.get_by_label("No task: free work without assessment");
    panel.get_by_label("Controller: live");
}

fn shown_again() -> UiState {
    UiState {
        replay: Some(ReplayView {
            at_s: 65.0,
            length_s: 130.0,
            speed: 1.0,
            seeks_s: None,
        }),
        ..live()
    }
}

#[test]
fn a_session_shown_again_goes_where_it_is_asked_to() {
    let mut panel = harness(shown_again());
    panel.run();
    panel.get_by_label("Recording: 1:05.0 of 2:10.0");
    for (name, asked) in [
        ("-10 s", Asked::Seek(55_000)),
        ("+1 s", Asked::Seek(66_000)),
        ("0.25×", Asked::Speed(250)),
        ("Free camera (C)", Asked::FreeView(true)),
    ] {
        panel.get_by_label(name).click();
        panel.run();
        assert_eq!(panel.state().asked, [asked], "{name}");
        panel.state_mut().asked.clear();
    }
    panel.event(egui::Event::PointerGone);
    for (key, asked) in [
        (egui::Key::ArrowLeft, Asked::Seek(64_000)),
        (egui::Key::PageDown, Asked::Seek(75_000)),
        (egui::Key::Home, Asked::Seek(0)),
    ] {
        panel.get_by_label("Free camera (C)"); // no widget has the focus
        panel.key_press(key);
        panel.run();
        assert_eq!(panel.state().asked, [asked], "{key:?}");
        panel.state_mut().asked.clear();
    }
    // During a seek, steps count from its target.
    if let Some(view) = &mut panel.state_mut().state.replay {
        view.seeks_s = Some(20.0);
    }
    panel.key_press(egui::Key::ArrowRight);
    panel.run();
    assert_eq!(panel.state().asked, [Asked::Seek(21_000)]);
    panel.get_by_label("Going from 1:05.0 to 0:20.0 …");
}

#[test]
fn a_replay_lists_the_instructors_acts_and_goes_to_them() {
    let mut panel = harness(UiState {
        acts: ActsView {
            all: vec![(0.4, ActKind::Point), (61.5, ActKind::Fog)],
            ..ActsView::default()
        },
        ..shown_again()
    });
    panel.run();
    for (name, asked) in [
        ("0:00  Look here", Asked::Seek(0)),
        ("1:01  Fogged the lens", Asked::Seek(60_500)),
    ] {
        panel.get_by_label(name).click();
        panel.run();
        assert_eq!(panel.state().asked, [asked], "{name}");
        panel.state_mut().asked.clear();
    }
    assert!(
        harness(shown_again())
            .query_by_label_contains("Fogged")
            .is_none()
    );
}

#[test]
fn in_a_pause_no_instrument_is_exchanged() {
    for is_paused in [false, true] {
        let mut state = live();
        if let (Some(tools), true) = (&mut state.tools, is_paused) {
            tools.switches |= 8;
        }
        let mut panel = harness(state);
        panel.run();
        panel.key_press(egui::Key::Num3);
        panel.run();
        let asked = panel.state().asked.contains(&Asked::Instrument(2));
        assert_ne!(asked, is_paused);
    }
}

#[test]
fn the_slider_asks_once_it_is_let_go() {
    let mut panel = harness(shown_again());
    panel.run();
    let slider = panel.get_by_label("Position in the session").rect();
    let at = |share: f32| egui::pos2(slider.left() + share * slider.width(), slider.center().y);
    panel.drag_at(at(0.5));
    panel.run();
    panel.hover_at(at(0.1));
    panel.run();
    assert_eq!(panel.state().asked, [], "while it is held nothing is asked");
    panel.drop_at(at(0.1));
    panel.run();
    let asked = &panel.state().asked;
    let [Asked::Seek(at_ms)] = asked[..] else {
        panic!("{asked:?}");
    };
    assert!(at_ms < 65_000, "earlier than it stood: {at_ms}");
}

#[test]
fn panel_without_a_session_shows_and_asks_nothing_of_one() {
    let mut panel = harness(live());
    for key in [egui::Key::ArrowLeft, egui::Key::Home, egui::Key::C] {
        panel.key_press(key);
        panel.run();
    }
    assert_eq!(panel.state().asked, []);
    assert!(panel.query_by_label("Free camera (C)").is_none());
}

#[test]
fn the_recording_says_how_it_does() {
    use session::Standing;
    let shown = |standing, [missing, missing_events]: [u64; 2]| {
        let recording = RecordingView {
            standing,
            bytes: 12_300_000,
            waiting: 4_000_000,
            missing,
            missing_events,
            reported: None,
        };
        let mut panel = harness(UiState {
            recording: Some(recording),
            ..live()
        });
        panel.run();
        panel
    };
    let with = |standing, missing| shown(standing, [missing, 0]);
    with(Standing::Recording, 0).get_by_label("Recording, 12.3 MB");
    shown(Standing::Recording, [0, 3]).get_by_label("Recording, but 3 events are missing");
    shown(Standing::Recording, [7, 3]).get_by_label("Recording, but 7 ticks are missing");
    with(Standing::Recording, 7).get_by_label("Recording, but 7 ticks are missing");
    with(Standing::Refused, 0)
        .get_by_label("Recording: the disk is full or missing, 4.0 MB waiting; free some space");
    with(Standing::Hanging, 0)
        .get_by_label("Recording: the disk has not responded for some seconds; check it");
    with(Standing::Ended, 0).get_by_label("Recording stopped: the disk was full for too long");
    assert!(
        harness(live())
            .query_by_label_contains("Recording")
            .is_none()
    );
}
