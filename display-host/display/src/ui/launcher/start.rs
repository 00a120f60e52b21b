//! Who does what, with how much help, through which endoscope, on which devices.

use egui::{Id, Key, RichText, TextEdit, Ui};

use super::{Wish, pressed, screen, typed};
use crate::ui::panel::{Mark, line};
use crate::ui::screens::{part, title};
use crate::words::{Language, Words};

/// Keys of the tasks, in their order.
const NUMBERS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];
/// Names are listed up to this height, points; then the list scrolls.
const NAMES_HEIGHT: f32 = 110.0;

/// What is chosen.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StartForm {
    /// Whose session it is; empty: nobody's, and it is not kept.
    pub trainee: String,
    /// The task's name.
    pub task: String,
    /// How much help is given: a difficulty's name.
    pub difficulty: String,
    /// The trainee places the sutures.
    pub own_sutures: bool,
    /// The endoscope's angle, degrees.
    pub scope_degrees: u16,
    /// The scene's name, or its file.
    pub scene: String,
    /// The station file; used unless the devices are to be emulated.
    pub station_file: String,
    /// Emulated devices.
    pub emulated: bool,
    /// The interface's language.
    pub language: Language,
}

/// The start screen.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Start {
    /// What is chosen.
    pub form: StartForm,
    /// Names in the store.
    pub trainees: Vec<String>,
    /// What may be chosen: tasks, difficulties, angles in degrees, scenes.
    pub tasks: Vec<String>,
    /// Tasks in which the trainee may place the sutures.
    pub hanging: Vec<String>,
    /// See [`Start::tasks`].
    pub difficulties: Vec<String>,
    /// See [`Start::tasks`].
    pub scopes: Vec<u16>,
    /// See [`Start::tasks`].
    pub scenes: Vec<String>,
    /// The station's devices as they are now.
    pub devices: Vec<DeviceLine>,
    /// Why the station file cannot be used, if it cannot.
    pub station_file_problem: Option<String>,
    /// What is plugged in beside them.
    pub plugged_in: Vec<String>,
    /// Where sessions are kept.
    pub store: String,
    /// Why they cannot be, if so, or why this name cannot.
    pub problem: Option<String>,
}

/// A device of the station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceLine {
    /// The message that names it.
    pub name: &'static str,
    /// How it is.
    pub state: DeviceState,
}

/// How a device is before anything starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DeviceState {
    /// It will be emulated.
    Emulated,
    /// The station file names it, and there is something where it should be.
    There(String),
    /// The station file names it, and there is nothing.
    Missing(String),
    /// Whether it is there is known when it is opened: it has no path.
    Named(String),
}

pub(super) fn show(ui: &mut Ui, words: &Words, start: &Start, wishes: &mut Vec<Wish>) {
    let name = Id::unique("launcher name");
    let file = Id::unique("launcher station file");
    // The key that ends the writing is not meant for the screen either.
    let writes = ui.memory(|memory| {
        let written = |id| memory.has_focus(id) || memory.had_focus_last_frame(id);
        [name, file].into_iter().any(written)
    });
    let mut form = start.form.clone();
    if !writes {
        keys(ui, start, &mut form, wishes);
        if pressed(ui, Key::N) {
            ui.memory_mut(|memory| memory.request_focus(name));
            // The letter that chose the field is not part of the name.
            ui.input_mut(|input| {
                input
                    .events
                    .retain(|event| !matches!(event, egui::Event::Text(_)));
            });
        }
    }
    let buttons = [
        (words.say("start-begin"), Wish::Begin),
        (words.say("quit"), Wish::Quit),
    ];
    screen(ui, "start", Some(0), &buttons, wishes, |ui, _| {
        title(ui, &words.say("start-title"));
        if let Some(problem) = &start.problem {
            line(ui, Mark::Care, problem);
        }
        ui.columns(2, |columns| {
            if let [left, right] = columns {
                left.vertical(|ui| {
                    trainee(ui, words, start, &mut form, name);
                    task(ui, words, start, &mut form);
                });
                right.vertical(|ui| {
                    help(ui, words, start, &mut form);
                    scope_and_scene(ui, words, start, &mut form);
                    devices(ui, words, start, &mut form, file);
                    languages(ui, words, &mut form);
                });
            }
        });
    });
    if form != start.form {
        wishes.push(Wish::Form(form));
    }
}

fn keys(ui: &Ui, start: &Start, form: &mut StartForm, wishes: &mut Vec<Wish>) {
    for key in typed(ui) {
        let number = NUMBERS.iter().position(|it| *it == key);
        if let Some(task) = number.and_then(|it| start.tasks.get(it)) {
            form.task.clone_from(task);
        }
    }
    if pressed(ui, Key::Escape) {
        wishes.push(Wish::Quit);
    }
}

fn trainee(ui: &mut Ui, words: &Words, start: &Start, form: &mut StartForm, name: Id) {
    let label = part(ui, &words.say("start-trainee"));
    egui::ScrollArea::vertical()
        .id_salt("names")
        .max_height(NAMES_HEIGHT)
        .show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let nobody = words.say("start-nobody");
                let names = core::iter::once((String::new(), nobody))
                    .chain(start.trainees.iter().map(|it| (it.clone(), it.clone())));
                for (value, shown) in names {
                    ui.selectable_value(&mut form.trainee, value, shown);
                }
            });
        });
    ui.horizontal(|ui| {
        let new = ui.label(words.say("start-new-name"));
        ui.add(
            TextEdit::singleline(&mut form.trainee)
                .id(name)
                .char_limit(64)
                .desired_width(f32::INFINITY),
        )
        .labelled_by(new.id)
        .labelled_by(label.id);
    });
    let kept = match form.trainee.trim().is_empty() {
        true => words.say("start-not-kept"),
        false => words.say_with("start-kept", &[("store", start.store.as_str().into())]),
    };
    ui.label(RichText::new(kept).weak());
}

fn task(ui: &mut Ui, words: &Words, start: &Start, form: &mut StartForm) {
    part(ui, &words.say("start-task"));
    for (number, task) in start.tasks.iter().enumerate() {
        let text = format!("{} ({})", words.say(&format!("task-{task}")), number + 1);
        ui.radio_value(&mut form.task, task.clone(), text);
    }
    let asks = words.say(&format!("start-asks-{}", form.task));
    ui.label(RichText::new(asks).italics());
    if start.hanging.contains(&form.task) {
        ui.checkbox(&mut form.own_sutures, words.say("start-own-sutures"));
    }
}

fn help(ui: &mut Ui, words: &Words, start: &Start, form: &mut StartForm) {
    part(ui, &words.say("start-difficulty"));
    ui.horizontal_wrapped(|ui| {
        for it in &start.difficulties {
            let text = words.say(&format!("difficulty-{it}"));
            ui.radio_value(&mut form.difficulty, it.clone(), text);
        }
    });
    let gives = words.say(&format!("difficulty-{}-gives", form.difficulty));
    ui.label(RichText::new(gives).italics());
}

fn scope_and_scene(ui: &mut Ui, words: &Words, start: &Start, form: &mut StartForm) {
    part(ui, &words.say("start-scope"));
    ui.horizontal_wrapped(|ui| {
        for &degrees in &start.scopes {
            ui.radio_value(&mut form.scope_degrees, degrees, format!("{degrees}°"));
        }
    });
    part(ui, &words.say("start-scene"));
    ui.horizontal_wrapped(|ui| {
        for scene in &start.scenes {
            let id = format!("scene-{scene}");
            let said = words.say(&id);
            // A file has no name but its own.
            let text = if said == id { scene.clone() } else { said };
            ui.radio_value(&mut form.scene, scene.clone(), text);
        }
    });
}

fn devices(ui: &mut Ui, words: &Words, start: &Start, form: &mut StartForm, file: Id) {
    part(ui, &words.say("start-devices"));
    ui.horizontal_wrapped(|ui| {
        ui.radio_value(&mut form.emulated, true, words.say("start-emulated"));
        ui.radio_value(&mut form.emulated, false, words.say("start-by-file"));
    });
    if !form.emulated {
        ui.horizontal(|ui| {
            let label = ui.label(words.say("start-station-file"));
            ui.add(
                TextEdit::singleline(&mut form.station_file)
                    .id(file)
                    .desired_width(f32::INFINITY),
            )
            .labelled_by(label.id);
        });
    }
    if let Some(problem) = &start.station_file_problem {
        line(ui, Mark::Bad, problem);
    }
    for device in &start.devices {
        let name = ("device", words.say(device.name).into());
        let (mark, id, path) = match &device.state {
            DeviceState::Emulated => (Mark::Off, "start-device-emulated", ""),
            DeviceState::There(path) => (Mark::Good, "start-device-there", path.as_str()),
            DeviceState::Missing(path) => (Mark::Bad, "start-device-missing", path.as_str()),
            DeviceState::Named(path) => (Mark::Care, "start-device-named", path.as_str()),
        };
        line(
            ui,
            mark,
            &words.say_with(id, &[name, ("path", path.into())]),
        );
    }
    if form.emulated {
        ui.label(RichText::new(words.say("start-hand")).italics());
    }
    let plugged_in = match start.plugged_in.is_empty() {
        true => words.say("start-nothing-plugged-in"),
        false => {
            let list = start.plugged_in.join(", ").into();
            words.say_with("start-plugged-in", &[("list", list)])
        }
    };
    ui.label(RichText::new(plugged_in).weak());
}

fn languages(ui: &mut Ui, words: &Words, form: &mut StartForm) {
    part(ui, &words.say("settings-language"));
    ui.horizontal(|ui| {
        for language in Language::ALL {
            ui.radio_value(&mut form.language, language, language.name());
        }
    });
}
