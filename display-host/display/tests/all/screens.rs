//! Every screen in every language at seven sizes: nothing is cut off, and nothing over the picture
//! covers another thing. `SCREENS=DIR cargo test -p display-host --test all screens` also draws the
//! screens into the folder, to be looked at.

use std::path::PathBuf;

use assess::{Act, Advice, Hint, Hold, Instrument, Lack, Metric, Reason, Step};
use display_host::ui::feel::{View, feel};
use display_host::ui::launcher::{
    Asking, ClosePicture, Debrief, DeviceLine, DeviceState, Earlier, Failed, Launcher, LessonView,
    LevelView, MetricRow, Points, ProgressView, Running, Screen, Start, StartForm, TaskProgress,
    launcher,
};
use display_host::ui::{
    Bulletin, Link, Look, Notes, Overlay, ReplayView, Settings, TaskEnd, TaskNote, TaskView,
    TickHealth, UiState, ui,
};
use display_host::words::{Language, Words};
use egui::accesskit::Role;
use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::words::ActKind;

use crate::feel::views;

/// Width and height, pixels; size of the text, per cent.
const SIZES: [[u16; 3]; 7] = [
    [800, 600, 100],
    [800, 600, 200],
    [1280, 720, 100],
    [1280, 720, 150],
    [1280, 720, 200],
    [1920, 1080, 80],
    [3840, 2160, 200],
];

enum Shown {
    Launcher(Box<Screen>),
    Window(Box<UiState>),
    Feel(Box<View>),
}

fn texts(all: &[&str]) -> Vec<String> {
    all.iter().map(|it| (*it).to_owned()).collect()
}

fn note(kind: &str, organ: &str) -> TaskNote {
    TaskNote {
        kind: kind.into(),
        organ: Some(organ.into()),
    }
}

fn unclamped() -> Reason {
    let organ = "cystic artery".into();
    Reason::Unclamped { organ }
}

fn start(problem: bool) -> Screen {
    let device = |name, state| DeviceLine { name, state };
    Screen::Start(Start {
        form: StartForm {
            trainee: "Ada".into(),
            task: "identify".into(),
            difficulty: "exam".into(),
            scene: "triangle".into(),
            emulated: !problem,
            station_file: "/home/ada/station.toml".into(),
            ..StartForm::default()
        },
        progress: Some(progress()),
        trainees: texts(&["Ada", "Bo", "Cy", "Dagmar", "Emil"]),
        tasks: texts(&[
            "identify",
            "clamp",
            "cut",
            "disconnect",
            "full",
            "free",
            "scope",
        ]),
        shown: texts(&["identify", "full", "scope"]),
        hanging: texts(&["identify", "full", "free"]),
        difficulties: texts(&["beginner", "trainee", "exam"]),
        scopes: vec![0, 30, 45],
        scenes: texts(&[
            "triangle",
            "triangle-variant",
            "built-in",
            "patient:ada",
            "patient:berta",
            "patient:clara",
            "patient:dora",
            "patient:edith",
            "patient:frieda",
        ]),
        devices: match problem {
            false => ["device-haptic", "device-tracker", "device-pedal"]
                .map(|name| device(name, DeviceState::Emulated))
                .into(),
            true => vec![
                device(
                    "device-haptic",
                    DeviceState::Missing("/dev/serial/by-id/usb-Touch".into()),
                ),
                device("device-tracker", DeviceState::Named("192.168.0.1".into())),
                device(
                    "device-pedal",
                    DeviceState::There("/dev/input/by-id/pedal".into()),
                ),
            ],
        },
        plugged_in: texts(&["/dev/ttyS0", "Arduino Due (/dev/ttyACM0)"]),
        store: "/home/ada/.local/share/calot/store.sqlite".into(),
        problem: problem.then(|| "the store is busy: another program writes it".into()),
        ..Start::default()
    })
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
        next: Some(("disconnect".into(), "beginner".into())),
        has_certificate: true,
    }
}

/// The first start of all.
fn first() -> Screen {
    let Screen::Start(usual) = start(false) else {
        unreachable!("it is the start");
    };
    Screen::Start(Start {
        is_first: true,
        trainees: Vec::new(),
        ..usual
    })
}

fn debrief() -> Screen {
    let row = |name: &str, unit: &str, value: f64, most: Option<f64>| MetricRow {
        name: name.into(),
        unit: unit.into(),
        value: Some(value),
        passes: most.map(|most| [f64::NEG_INFINITY, most]),
        best: Some(value / 2.0),
    };
    let close = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/close.png"));
    Screen::Debrief(Debrief {
        trainee: "Ada".into(),
        task: "full".into(),
        difficulty: "trainee".into(),
        outcome: "failed".into(),
        reasons: vec![unclamped()],
        score: 31.0,
        acts: vec![
            Act {
                at_s: 62.0,
                session_s: 66.5,
                kind: "slipped_clip".into(),
                remark: None,
            },
            Act {
                at_s: 80.0,
                session_s: 84.5,
                kind: "remark".into(),
                remark: Some("Look for the artery behind the duct before you clip".into()),
            },
        ],
        lessons: [
            ("touched", "duodenum"),
            ("burnt", "liver"),
            ("too_early", "cystic duct"),
        ]
        .map(|(kind, organ)| LessonView {
            note: note(kind, organ),
            moments: vec![[75.5, 80.0], [90.0, 94.5]],
            close: ClosePicture::read(&close),
        })
        .into(),
        progress: Some(progress()),
        lost: vec![("cautery_air_s".into(), 6.0)],
        can_replay: true,
        metrics: vec![
            row("clips_misplaced", "n", 2.0, Some(0.0)),
            row("burn_gallbladder_j", "J", 41.0, Some(20.0)),
            row("time_s", "s", 731.0, Some(900.0)),
            row("path_m", "m", 4.2, None),
            row("cvs_bed", "1", 0.4, None),
            row("force_saturated_s", "s", 1.2, None),
            row("blood_ml", "ml", 12.5, Some(20.0)),
        ],
        earlier: vec![Earlier {
            when: "2026-03-01 10:12".into(),
            outcome: "aborted".into(),
            score: 0.0,
        }],
        report: Some("/home/ada/out/debrief.html".into()),
        machine: texts(&["not realtime: lacks SCHED_FIFO"]),
        ..Debrief::default()
    })
}

fn points(asking: Asking, items: &[&str], at: usize) -> Screen {
    Screen::Points(Points {
        asking,
        trainee: "Ada".into(),
        items: items.iter().map(|it| ((*it).into(), "?".into())).collect(),
        given: items.iter().map(|_| Some(4)).collect(),
        at,
        rater: String::new(),
        problem: None,
    })
}

fn task() -> TaskView {
    let clip = Step::Clip {
        organ: "cystic artery".into(),
        count: 2,
    };
    TaskView {
        task: "full".into(),
        time_s: 605.0,
        steps: vec![
            (Step::Triangle, true),
            (Step::LowerBed, false),
            (clip, false),
        ],
        alarm: Some(note("too_early", "cystic duct")),
        alarms: 3,
        score: Some(64.0),
        hint: Some(Hint {
            step: Step::LowerBed,
            advice: Advice::Take(Instrument::Hook),
            percent: Some(40),
        }),
        hold: Some(Hold {
            share: 0.6,
            lack: Some(Lack::Tilt),
        }),
        views_held: [true, false],
        end: None,
        start: None,
    }
}

fn window() -> UiState {
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    (tools.switches, tools.instrument, tools.clips_left) = (16 + 2, 1, 9);
    tools.force_n = [0.0, 1.0, 0.4];
    let states = [DeviceHealth::LIVE, DeviceHealth::STALE, DeviceHealth::LOST];
    for (health, status) in tools.health.iter_mut().zip(states) {
        (health.status, health.age_us, health.bad_frames) = (status, 41_000, 3);
    }
    UiState {
        station: "main".into(),
        scene: "Calot's triangle".into(),
        link: Link::Live,
        tools: Some(tools),
        health: TickHealth::default(),
        adapter: "llvmpipe (LLVM 19.1.7, 256 bits) (Vulkan, Mesa 25.0.7)".into(),
        task_view: Some(task()),
        quality: [0, 2],
        ..UiState::default()
    }
}

fn with(change: impl FnOnce(&mut UiState)) -> Shown {
    let mut state = window();
    change(&mut state);
    Shown::Window(Box::new(state))
}

fn page(screen: Screen) -> Shown {
    Shown::Launcher(Box::new(screen))
}

fn screens() -> Vec<(&'static str, Shown)> {
    let switch = |state: &mut UiState, bit| {
        if let Some(tools) = &mut state.tools {
            tools.switches |= bit;
        }
    };
    let running = Screen::Running(Running {
        trainee: "Ada".into(),
        task: "disconnect".into(),
        preparing: Some("The organs are being prepared: 35 %".into()),
        ..Running::default()
    });
    let failed = Screen::Failed(Failed {
        status: "exit status: 1".into(),
        said: texts(&["calot: /dev/ttyACM0 cannot be opened: plug it in, or name another"]),
        ..Failed::default()
    });
    let goals = ["depth", "hands", "efficiency", "tissue", "autonomy"];
    vec![
        ("start", page(start(false))),
        ("start-first", page(first())),
        ("start-problem", page(start(true))),
        ("running", page(running)),
        ("failed", page(failed)),
        ("debrief", page(debrief())),
        (
            "questions",
            page(points(
                Asking::Questions,
                &["notes-skills", "other-coordination"],
                1,
            )),
        ),
        ("sheet", page(points(Asking::Sheet, &goals, 1))),
        ("sheet-all", page(points(Asking::Sheet, &goals, 5))),
        ("task", with(|_| ())),
        ("task-in-hand", with(|state| state.in_hand = true)),
        (
            "task-noted",
            with(|state| {
                state.in_hand = true;
                state.note = Some(state.words.say("note-jaws-empty"));
                state.tip_away = Some([0.2, -0.9]);
            }),
        ),
        (
            "watched",
            with(|state| (state.watched, state.simulated) = (true, [true; 3])),
        ),
        (
            "task-invites",
            with(|state| {
                state.simulated = [true; 3];
                state.alarm_is_old = true;
            }),
        ),
        (
            "task-alarm",
            with(|state| state.alarm = Some("the handle was too fast".into())),
        ),
        ("task-alone", with(|state| state.panel_hidden = true)),
        ("pause", with(|state| switch(state, 8))),
        (
            "over",
            with(|state| {
                if let Some(task) = &mut state.task_view {
                    task.end = Some(TaskEnd {
                        passed: false,
                        outcome: "failed".into(),
                        reasons: vec![
                            unclamped(),
                            Reason::TooMuch {
                                metric: Some(Metric::Blood),
                                value: 30.4,
                                limit: 20.0,
                            },
                        ],
                    });
                }
            }),
        ),
        (
            "engineering",
            with(|state| {
                state.overlay = Some(Overlay {
                    notes: Notes {
                        counts: [1532, 9210, 6011, 12],
                        organs: 11,
                        awake: texts(&["gallbladder", "connective tissue", "cystic duct"]),
                    },
                    ..Overlay::default()
                });
            }),
        ),
        ("settings", with(|state| state.settings_open = true)),
        (
            "contrast-left",
            with(|state| {
                state.settings.look.high_contrast = true;
                state.settings.look.left_handed = true;
                state.tip_away = Some([0.6, -0.8]);
            }),
        ),
        (
            "guide",
            with(|state| {
                if let Some(task) = &mut state.task_view {
                    task.task = "basics".into();
                    task.alarm = None;
                    task.steps = vec![(Step::Meet, true), (Step::Coagulate, false)];
                    task.hint = Some(Hint {
                        step: Step::Coagulate,
                        advice: Advice::Use(Instrument::Hook),
                        percent: Some(40),
                    });
                }
            }),
        ),
        (
            "act",
            with(|state| {
                let remark = "Go nearer: the artery lies behind the duct".to_owned();
                state.acts.notice = Some((ActKind::Remark, Some(remark)));
                state.act_mark = Some(glam::Vec2::new(0.2, 0.1));
            }),
        ),
        (
            "replay",
            with(|state| {
                state.task_view = None;
                state.replayed_task = Some("clamp".into());
                state.replay = Some(ReplayView {
                    at_s: 65.0,
                    length_s: 130.0,
                    speed: 1.0,
                    seeks_s: None,
                });
                state.acts.all = vec![(12.0, ActKind::Point), (61.5, ActKind::SlippedClip)];
            }),
        ),
        (
            "drill",
            with(|state| {
                if let Some(task) = &mut state.task_view {
                    task.task = "phantom".into();
                    task.alarm = None;
                    let carry = || Step::Carry {
                        organ: "rope".into(),
                        to: "right ball".into(),
                    };
                    let clip = Step::Clip {
                        organ: "tube".into(),
                        count: 2,
                    };
                    task.steps = vec![(carry(), false), (clip, false)];
                    task.hint = Some(Hint {
                        step: carry(),
                        advice: Advice::Use(Instrument::Grasper),
                        percent: None,
                    });
                }
            }),
        ),
        ("waiting", with(|state| state.link = Link::Waiting)),
        (
            "instructor",
            with(|state| {
                state.instructor = true;
                let refused = state.words.say("act-refused-nothing");
                state.act_answer = Some((refused, false));
                state.watch(Some(Bulletin {
                    task: task(),
                    difficulty: "exam".into(),
                    alarms: vec![(75.0, note("clip_misplaced", "hepatic artery"))],
                    metrics: vec![
                        ("force_saturated_s".into(), "s".into(), 1.2),
                        ("cautery_air_s".into(), "s".into(), 12.0),
                    ],
                }));
            }),
        ),
    ]
}

/// The shown state, and the picture's texture once it exists.
type Desk = (Shown, Words, Option<TextureHandle>);

fn harness(language: Language, shown: Shown, size: [u16; 3]) -> Harness<'static, Desk> {
    let [width, height, text_percent] = size;
    let words = Words::new(language);
    let show = move |area: &mut egui::Ui, (shown, words, picture): &mut Desk| match shown {
        Shown::Launcher(screen) => {
            if let Screen::Start(start) = &mut **screen {
                start.form.language = words.language();
            }
            let state = Launcher {
                words: words.clone(),
                look: Look {
                    text_percent,
                    ..Look::default()
                },
                screen: (**screen).clone(),
            };
            launcher(area, &state);
        }
        Shown::Feel(view) => {
            area.ctx().set_zoom_factor(f32::from(text_percent) * 0.01);
            view.words = words.clone();
            feel(area, view);
        }
        Shown::Window(state) => {
            let texture = picture.get_or_insert_with(|| {
                let red = ColorImage::filled([4, 3], Color32::from_rgb(120, 40, 30));
                area.ctx()
                    .load_texture("picture", red, TextureOptions::default())
            });
            let look = Look {
                text_percent,
                ..state.settings.look
            };
            state.set(Settings {
                language: words.language(),
                look,
                ..Settings::default()
            });
            state.picture = Some((texture.id(), 4.0 / 3.0));
            ui(area, state);
        }
    };
    Harness::builder()
        .with_size([f32::from(width), f32::from(height)])
        .build_ui_state(show, (shown, words, None))
}

#[test]
fn words_are_not_cut_off_and_do_not_cover_each_other() {
    let out = std::env::var_os("SCREENS").map(PathBuf::from);
    let mut wrong = Vec::new();
    for language in Language::ALL {
        for size in SIZES {
            let views = views().into_iter();
            let feel = views.map(|(name, view)| (name, Shown::Feel(Box::new(view))));
            for (name, shown) in screens().into_iter().chain(feel) {
                let is_window = matches!(shown, Shown::Window(_));
                let mut desk = harness(language, shown, size);
                let [width, height, percent] = size.map(f32::from);
                desk.run_steps(2);
                // With larger text, a window of the same size has fewer points.
                let [wide, high] = [width, height].map(|it| it * 100.0 / percent);
                desk.set_size(egui::vec2(wide, high));
                desk.run_steps(4);
                let place = format!("{name} {} {width}x{height} {percent} %", language.code());
                let roles = [Role::Label, Role::Button, Role::RadioButton];
                let nodes = roles
                    .into_iter()
                    .flat_map(|role| desk.query_all_by_role(role));
                let mut texts = Vec::new();
                // The panel's content scrolls above the keys.
                let words = Words::new(language);
                let keys = words.say("help");
                let keys = desk.query_all_by_label(&keys).next().map(|it| it.rect());
                for node in nodes {
                    let (rect, node) = (node.rect(), node.accesskit_node());
                    let text = node.label().or_else(|| node.value()).unwrap_or_default();
                    if rect.left() < -1.0 || rect.right() > wide + 1.0 {
                        wrong.push(format!("{place}: cut off: {text} {rect}"));
                    }
                    // A launcher's page is left out, because it scrolls above buttons that do not.
                    // So is the part of the panel that is scrolled out of the window.
                    let is_below = keys.is_some_and(|keys| {
                        let is_beside = keys.x_range().contains(rect.center().x);
                        is_beside && rect != keys && rect.bottom() > keys.top()
                    });
                    if is_window && rect.bottom() <= high && !is_below {
                        texts.push((text, rect));
                    }
                }
                for (i, (text, rect)) in texts.iter().enumerate() {
                    for (other, beside) in &texts[..i] {
                        let common = rect.intersect(*beside);
                        if common.width() > 2.0 && common.height() > 2.0 && text != other {
                            wrong.push(format!("{place}: {text} covers {other}"));
                        }
                    }
                }
                if let Some(out) = &out {
                    std::fs::create_dir_all(out).expect("the folder of SCREENS");
                    let file = format!("{name}-{}-{width}-{percent}.png", language.code());
                    let picture = desk.render().expect("a driver draws it");
                    picture.save(out.join(file)).expect("a file in SCREENS");
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_tight_picture_shows_the_alarm_if_no_panel_does() {
    let out = std::env::var_os("SCREENS").map(PathBuf::from);
    for language in Language::ALL {
        for (panel_hidden, times) in [(true, 1), (false, 0)] {
            let shown = with(|state| state.panel_hidden = panel_hidden);
            let mut desk = harness(language, shown, [800, 600, 200]);
            desk.run_steps(2);
            desk.set_size(egui::vec2(400.0, 300.0));
            desk.run_steps(4);
            let labels: Vec<_> = desk.query_all_by_role(Role::Label).collect();
            let said = |node: &egui_kittest::Node<'_>| {
                let node = node.accesskit_node();
                node.label().or_else(|| node.value()).unwrap_or_default()
            };
            let alarms = labels.iter().filter(|it| said(it).starts_with("Alarm: "));
            let alarms: Vec<_> = alarms.map(|it| it.rect()).collect();
            let all: Vec<_> = labels.iter().map(said).collect();
            assert_eq!(alarms.len(), times, "{all:?}");
            for (alarm, label) in alarms
                .iter()
                .flat_map(|it| labels.iter().map(move |b| (it, b)))
            {
                let common = label.rect().intersect(*alarm);
                let is_apart = common.width() <= 2.0 || common.height() <= 2.0;
                assert!(is_apart || label.rect() == *alarm, "{}", said(label));
            }
            if let Some(out) = out.as_ref().filter(|_| panel_hidden) {
                let file = format!("tight-{}.png", language.code());
                let picture = desk.render().expect("a driver draws it");
                std::fs::create_dir_all(out).expect("the folder of SCREENS");
                picture.save(out.join(file)).expect("a file in SCREENS");
            }
        }
    }
}

#[test]
fn a_low_window_shows_the_outcome_of_a_debrief_and_whole_cards() {
    let wanted: [(&str, &[&str]); 3] = [
        (
            "pause",
            &[
                "pause-title",
                "pause-go-on",
                "pause-again",
                "settings",
                "pause-end",
            ],
        ),
        ("over", &["hud-end"]),
        ("debrief", &["outcome-failed", "debrief-again"]),
    ];
    for language in Language::ALL {
        let words = Words::new(language);
        for (name, ids) in wanted {
            let (_, shown) = screens().into_iter().find(|it| it.0 == name).expect(name);
            let mut desk = harness(language, shown, [800, 600, 200]);
            desk.run_steps(2);
            desk.set_size(egui::vec2(400.0, 300.0));
            desk.run_steps(4);
            let mut below = 0.0;
            for id in ids {
                let text = words.say(id);
                // The panel beside a card may have the same button; the card's comes last.
                let found = desk.query_all_by_label(&text).last().map(|it| it.rect());
                let rect = found.unwrap_or_else(|| panic!("{name} in {language:?}: no '{text}'"));
                assert!(
                    rect.top() >= below - 1.0 && rect.bottom() <= 300.0,
                    "{name} in {language:?}: '{text}' at {rect}"
                );
                below = rect.top();
            }
        }
    }
}
