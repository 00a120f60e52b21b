//! Lessons of people who sat at a window for the first time: what covers the picture, what the
//! window offers, and the sentences that it says.

use assess::{Advice, Hint, Hold, Instrument, Lack, Step};
use display_host::ui::launcher::{Debrief, Launcher, MetricRow, Screen, Start, launcher};
use display_host::ui::{Asked, Link, Look, ReplayView, Settings, TaskNote, TaskView, UiState, ui};
use display_host::words::{Language, Words};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::words::Switches;

struct Seen {
    state: UiState,
    asked: Vec<Asked>,
}

/// Shows a window of this size, pixels, and runs some frames.
fn window(state: UiState, [width, height]: [f32; 2]) -> Harness<'static, Seen> {
    let percent = f32::from(state.settings.look.text_percent);
    let seen = Seen {
        state,
        asked: Vec::new(),
    };
    let show = |area: &mut egui::Ui, seen: &mut Seen| {
        let (asked, _) = ui(area, &seen.state);
        seen.asked.extend(asked);
    };
    let mut desk = Harness::builder()
        .with_size([width, height])
        .build_ui_state(show, seen);
    desk.run_steps(2);
    desk.set_size(egui::vec2(width, height) * 100.0 / percent);
    desk.run_steps(4);
    desk
}

fn clamping() -> UiState {
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    (tools.switches, tools.instrument, tools.clips_left) = (16, 3, 12);
    tools
        .health
        .iter_mut()
        .for_each(|it| it.status = DeviceHealth::LIVE);
    let clip = |organ: &str| Step::Clip {
        organ: organ.into(),
        count: 2,
    };
    UiState {
        scene: "Calot's triangle".into(),
        link: Link::Live,
        tools: Some(tools),
        picture: Some((egui::TextureId::default(), 4.0 / 3.0)),
        simulated: [true; 3],
        task_view: Some(TaskView {
            task: "clamp".into(),
            time_s: 9.0,
            steps: vec![(clip("cystic duct"), false), (clip("cystic artery"), false)],
            score: Some(95.0),
            alarm: Some(TaskNote {
                kind: "clip_lost".into(),
                organ: None,
            }),
            alarms: 1,
            hint: Some(Hint {
                step: clip("cystic duct"),
                advice: Advice::Use(Instrument::ClipApplier),
                percent: Some(0),
            }),
            ..TaskView::default()
        }),
        ..UiState::default()
    }
}

fn guided() -> UiState {
    let mut state = clamping();
    if let Some(task) = &mut state.task_view {
        task.task = "basics".into();
        task.hold = Some(Hold {
            share: 0.0,
            lack: Some(Lack::Small),
        });
    }
    state
}

/// Rectangles of the cards over the picture.
fn cards(desk: &Harness<'_, Seen>) -> Vec<(&'static str, egui::Rect)> {
    let names = ["hud", "hud foot", "hud alarm"];
    let rects = names.into_iter().filter_map(|name| {
        let id = egui::Id::unique(name);
        let layer = egui::LayerId::new(egui::Order::Middle, id);
        desk.ctx.memory(|memory| {
            let is_seen = memory.areas().visible_last_frame(&layer);
            let rect = memory.area_rect(id).filter(|_| is_seen)?;
            Some((name, rect))
        })
    });
    rects.collect()
}

#[test]
fn no_size_of_text_lets_the_cards_cover_one_another_or_much_of_the_picture() {
    for language in Language::ALL {
        for (size, percent) in [
            ([1280.0, 720.0], 100),
            ([1280.0, 720.0], 125),
            ([1280.0, 720.0], 150),
            ([800.0, 600.0], 100),
            ([1920.0, 1080.0], 200),
        ] {
            for (name, state) in [("clamp", clamping()), ("guide", guided())] {
                for in_hand in [false, true] {
                    let mut state = UiState {
                        in_hand,
                        ..state.clone()
                    };
                    state.set(Settings {
                        language,
                        look: Look {
                            text_percent: percent,
                            high_contrast: true,
                            ..Look::default()
                        },
                        ..Settings::default()
                    });
                    let mut desk = window(state, size);
                    let place = format!("{name} {language:?} {size:?} {percent} % {in_hand}");
                    let name_of_picture = Words::new(language).say("picture-alt");
                    let picture = desk.get_by_label(&name_of_picture).rect();
                    let cards = cards(&desk);
                    let covered: f32 = cards
                        .iter()
                        .map(|(_, card)| card.intersect(picture).area() / picture.area())
                        .sum();
                    assert!(!cards.is_empty(), "{place}");
                    assert!(
                        covered < 0.3,
                        "{place}: {covered} by {cards:?} of {picture}"
                    );
                    if let Some(out) = std::env::var_os("SCREENS").filter(|_| in_hand) {
                        let out = std::path::PathBuf::from(out);
                        std::fs::create_dir_all(&out).expect("the folder of SCREENS");
                        let file = format!("hour-{name}-{language:?}-{}-{percent}.png", size[0]);
                        let picture = desk.render().expect("a driver draws it");
                        picture.save(out.join(file)).expect("a file in SCREENS");
                    }
                    for (i, (one, rect)) in cards.iter().enumerate() {
                        for (other, beside) in &cards[..i] {
                            let common = rect.intersect(*beside);
                            let is_apart = common.width() <= 0.0 || common.height() <= 0.0;
                            assert!(is_apart, "{place}: {one} covers {other}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn the_keys_stand_in_the_panel_and_a_hidden_panel_gives_them_to_the_picture() {
    for panel_hidden in [false, true] {
        let desk = window(
            UiState {
                in_hand: true,
                panel_hidden,
                ..clamping()
            },
            [1280.0, 720.0],
        );
        let keys = desk.get_by_label_contains("Space, held: jaws close").rect();
        let picture = desk.get_by_label("Endoscope picture").rect();
        assert_eq!(picture.contains(keys.center()), panel_hidden);
    }
}

#[test]
fn a_trainee_who_watches_is_told_so_and_is_offered_no_instrument() {
    let watched = UiState {
        watched: true,
        ..guided()
    };
    let mut desk = window(watched, [1280.0, 720.0]);
    assert_eq!(desk.get_all_by_label("You watch the expert").count(), 2);
    assert!(desk.query_by_label_contains("Press M").is_none());
    assert!(desk.query_by_label_contains("Control with mouse").is_none());
    desk.key_press(egui::Key::Num2);
    desk.run_steps(2);
    assert!(desk.state().asked.is_empty(), "the expert chooses");
    let own = window(guided(), [1280.0, 720.0]);
    own.get_by_label_contains("Press M to lead instrument");
    own.get_by_label_contains("Control with mouse");
    let mut at_device = clamping();
    at_device.simulated = [false; 3];
    let at_device = window(at_device, [1280.0, 720.0]);
    assert!(at_device.query_by_label_contains("Press M").is_none());
}

#[test]
fn a_replay_names_the_recorded_task_and_offers_no_instrument() {
    let replay = UiState {
        task_view: None,
        replayed_task: Some("clamp".into()),
        replay: Some(ReplayView {
            at_s: 65.0,
            length_s: 130.0,
            speed: 1.0,
            seeks_s: None,
        }),
        task: Words::default().say("task-none"),
        ..clamping()
    };
    let mut desk = window(replay, [1280.0, 900.0]);
    desk.get_by_label("Replay");
    desk.get_by_label("Clamp: clip cystic duct and artery");
    desk.get_by_label("Pause (P)");
    for wrong in [
        "Press, grasp",
        "Scissors (3)",
        "Reset organs",
        "(M)",
        "force (F)",
    ] {
        let shown = desk.query_all_by_label_contains(wrong).count();
        assert_eq!(shown, 0, "{wrong}");
    }
    for key in [egui::Key::M, egui::Key::R, egui::Key::F, egui::Key::Num2] {
        desk.key_press(key);
        desk.run_steps(2);
    }
    assert!(desk.state().asked.is_empty(), "{:?}", desk.state().asked);
    desk.key_press(egui::Key::P);
    desk.run_steps(2);
    assert_eq!(desk.state().asked, [Asked::Pause(true)]);
}

#[test]
fn a_simulated_device_asks_for_no_plug() {
    let lost = |simulated| {
        let mut state = UiState {
            simulated,
            ..clamping()
        };
        if let Some(tools) = &mut state.tools {
            tools.health[2].status = DeviceHealth::LOST;
        }
        let desk = window(state, [1280.0, 720.0]);
        desk.query_all_by_label_contains("connection lost; plug it in again")
            .count()
    };
    assert_eq!(lost([true; 3]), 0);
    assert_eq!(lost([true, true, false]), 1);
}

#[test]
fn without_current_the_window_says_why() {
    let said = |instrument: u32, flows: u32, asked: Switches, status: u32| {
        let mut state = UiState {
            in_hand: true,
            pressed: asked,
            ..clamping()
        };
        if let Some(tools) = &mut state.tools {
            (tools.instrument, tools.switches) = (instrument, 16 | flows);
            tools.health[2].status = status;
        }
        window(state, [1280.0, 720.0])
    };
    let (none, coagulate) = (Switches::NONE, Switches::COAGULATE);
    let (live, lost) = (DeviceHealth::LIVE, DeviceHealth::LOST);
    for (desk, text) in [
        (said(1, 0, none, live), "Pedal: off"),
        (said(1, 2, coagulate, live), "Pedal: coagulate"),
        (
            said(0, 2, coagulate, live),
            "No current: only the cautery hook (2) has one",
        ),
        (
            said(1, 0, coagulate, live),
            "No current: release the pedal once, then press it again",
        ),
        (
            said(1, 0, coagulate, lost),
            "No current: this computer is too slow for the pedal now; press it again",
        ),
        (said(1, 3, none, live), "Both pedals pressed: no current"),
    ] {
        desk.get_by_label(text);
    }
}

#[test]
fn a_force_that_is_off_is_one_sentence_and_no_alarm() {
    let mut state = UiState {
        in_hand: true,
        ..clamping()
    };
    if let Some(tools) = &mut state.tools {
        tools.switches = 0;
    }
    if let Some(task) = &mut state.task_view {
        (task.alarm, task.alarms) = (None, 0);
    }
    let sentence = "The tissue does not push back now: press F, then move slowly.";
    let desk = window(state.clone(), [1280.0, 720.0]);
    desk.get_by_label(sentence);
    assert!(desk.query_by_label_contains("Alarm").is_none());
    state.in_hand = false;
    let desk = window(state, [1280.0, 720.0]);
    assert!(desk.query_by_label(sentence).is_none());
}

#[test]
fn an_old_alarm_leaves_the_picture_and_stays_in_the_panel() {
    let shown = |alarm_is_old| {
        let state = UiState {
            alarm_is_old,
            ..clamping()
        };
        let desk = window(state, [1280.0, 720.0]);
        let count = |text: &str| desk.query_all_by_label_contains(text).count();
        (
            count("Alarm: closed a clip"),
            count("Alarm 1: closed a clip"),
        )
    };
    assert_eq!(shown(false), (1, 1));
    assert_eq!(shown(true), (0, 1));
}

#[test]
fn a_hint_does_not_ask_for_the_instrument_that_is_in_the_hand() {
    let hinted = |held: u32| {
        let mut state = clamping();
        if let Some(hint) = state.task_view.as_mut().and_then(|it| it.hint.as_mut()) {
            hint.advice = Advice::Take(Instrument::ClipApplier);
        }
        if let Some(tools) = &mut state.tools {
            tools.instrument = held;
        }
        let desk = window(state, [1280.0, 720.0]);
        desk.query_all_by_label_contains("take the clip applier")
            .count()
    };
    assert_eq!((hinted(3), hinted(1)), (0, 2));
}

#[test]
fn the_scene_has_its_german_name() {
    let mut state = clamping();
    state.set(Settings {
        language: Language::German,
        ..Settings::default()
    });
    let desk = window(state, [1280.0, 720.0]);
    desk.get_by_label("Calot-Dreieck");
}

/// Shows a page of the launcher, which may change.
fn page(screen: Screen) -> Harness<'static, Screen> {
    let show = |area: &mut egui::Ui, screen: &mut Screen| {
        let state = Launcher {
            words: Words::default(),
            look: Look::default(),
            screen: screen.clone(),
        };
        launcher(area, &state);
    };
    let mut desk = Harness::builder()
        .with_size([900.0, 500.0])
        .build_ui_state(show, screen);
    desk.run_steps(4);
    desk
}

fn debrief(report: &str) -> Debrief {
    let row = |number: u32| MetricRow {
        name: format!("metric-{number}"),
        unit: "n".into(),
        value: Some(0.0),
        passes: Some([f64::NEG_INFINITY, 0.0]),
        best: None,
    };
    Debrief {
        task: "clamp".into(),
        difficulty: "beginner".into(),
        outcome: "failed".into(),
        metrics: (0..40).map(row).collect(),
        report: Some(report.into()),
        ..Debrief::default()
    }
}

#[test]
fn a_new_debrief_opens_at_its_top_and_its_message_stands_beside_the_buttons() {
    let mut desk = page(Screen::Debrief(debrief("/one/debrief.html")));
    let outcome = |desk: &Harness<'_, Screen>| {
        let mut all = desk.query_all_by_label("Failed");
        all.next().map(|it| it.rect().top())
    };
    let top = outcome(&desk).expect("the outcome");
    desk.hover_at(egui::pos2(400.0, 200.0));
    for _ in 0..4 {
        desk.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: egui::vec2(0.0, -400.0),
            modifiers: egui::Modifiers::NONE,
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
        });
        desk.run_steps(30);
    }
    assert!(outcome(&desk) < Some(top - 100.0), "it scrolled");
    let notice = "No program opened the report.";
    *desk.state_mut() = Screen::Debrief(Debrief {
        notice: Some(notice.into()),
        ..debrief("/one/debrief.html")
    });
    desk.run_steps(4);
    assert!(outcome(&desk) < Some(top - 100.0), "it is the same debrief");
    let seen = desk.get_by_label(notice).rect();
    assert!(seen.top() > 250.0 && seen.bottom() < 500.0, "{seen}");
    *desk.state_mut() = Screen::Debrief(debrief("/two/debrief.html"));
    desk.run_steps(4);
    assert_eq!(outcome(&desk), Some(top));
}

#[test]
fn none_of_a_counted_thing_passes_in_words() {
    let desk = page(Screen::Debrief(debrief("/one/debrief.html")));
    assert!(desk.query_all_by_label_contains("none").count() > 0);
    assert_eq!(desk.query_all_by_label_contains("≤ 0").count(), 0);
}

#[test]
fn a_new_name_stands_among_the_names_and_its_key_leads_to_the_field() {
    let mut start = Start {
        trainees: (0..60).map(|number| format!("Trainee {number}")).collect(),
        ..Start::default()
    };
    start.form.trainee = "Zoe".into();
    let mut desk = page(Screen::Start(start));
    assert!(desk.query_all_by_label("Zoe").count() > 0);
    let field = "New name (N)";
    desk.key_press(egui::Key::N);
    desk.run_steps(30);
    let field = desk.get_by_label(field).rect();
    assert!(field.top() >= 0.0 && field.bottom() < 500.0, "{field}");
}
