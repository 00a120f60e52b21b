//! Choice of trainee, task, help, endoscope and devices.

use egui::{Frame, Id, Key, RichText, TextEdit, Ui, Vec2, vec2};

use super::progress::{self, ProgressView};
use super::{Wish, pressed, screen, typed};
use crate::ui::screens::{self, Look, part, title};
use crate::ui::widgets::{Mark, line};
use crate::ui::{names, sketch};
use crate::words::{Language, Words};

/// Keys of the tasks, in order.
const TASK_KEYS: [Key; 9] = [
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
/// Size of the moving picture of a task, points.
const PICTURE_POINTS: Vec2 = vec2(160.0, 120.0);
/// Width of a page below which everything stands in one column, points.
const SIDE_BY_SIDE_POINTS: f32 = 680.0;
/// Height from which the list of names scrolls, points.
const NAMES_HEIGHT_POINTS: f32 = 110.0;

/// The choices.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StartForm {
    /// Name of the trainee; empty: a guest, whose session counts for nobody.
    pub trainee: String,
    /// Name of the task.
    pub task: String,
    /// Degree of help: a difficulty's name.
    pub difficulty: String,
    /// True if the trainee places the sutures.
    pub own_sutures: bool,
    /// The endoscope's angle, degrees.
    pub scope_degrees: u16,
    /// Name of the scene, or its file.
    pub scene: String,
    /// The station file, used unless the devices are simulated.
    pub station_file: String,
    /// True for simulated devices.
    pub emulated: bool,
    /// The interface's language.
    pub language: Language,
    /// Look of the interface, and settings of mouse and keyboard.
    pub look: Look,
}

/// The start screen.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Start {
    /// The choices.
    pub form: StartForm,
    /// Names in the store.
    pub trainees: Vec<String>,
    /// Tasks to choose from.
    pub tasks: Vec<String>,
    /// Tasks in which the trainee may place the sutures.
    pub hanging: Vec<String>,
    /// Tasks that the expert shows.
    pub shown: Vec<String>,
    /// Difficulties to choose from.
    pub difficulties: Vec<String>,
    /// Endoscope angles to choose from, degrees.
    pub scopes: Vec<u16>,
    /// Scenes to choose from.
    pub scenes: Vec<String>,
    /// Present state of the station's devices.
    pub devices: Vec<DeviceLine>,
    /// Problem of the station file, if any.
    pub station_file_problem: Option<String>,
    /// Other connected devices.
    pub plugged_in: Vec<String>,
    /// Path of the store.
    pub store: String,
    /// True if nobody has worked here yet: the guided first steps are offered.
    pub is_first: bool,
    /// Progress of the chosen trainee; `None` for a guest.
    pub progress: Option<ProgressView>,
    /// Pictures a second that the last operation's window showed, if they were too few to train
    /// with.
    pub slow_per_second: Option<f64>,
    /// Problem of the store or of the name, if any.
    pub problem: Option<String>,
    /// Result of the last request.
    pub notice: Option<String>,
}

/// A device of the station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceLine {
    /// Message that names it.
    pub name: &'static str,
    /// Its state.
    pub state: DeviceState,
}

/// State of a device before the start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DeviceState {
    /// It will be simulated.
    Emulated,
    /// The station file names it, and it is present.
    There(String),
    /// The station file names it, and it is missing.
    Missing(String),
    /// The station file names it without a path, so only opening it shows if it is present.
    Named(String),
}

pub(super) fn show(ui: &mut Ui, words: &Words, start: &Start, wishes: &mut Vec<Wish>) {
    let name = Id::unique("launcher name");
    let file = Id::unique("launcher station file");
    // The key that ends the editing of a field is not meant for the screen.
    let writes = ui.memory(|memory| {
        let written = |id| memory.has_focus(id) || memory.had_focus_last_frame(id);
        [name, file].into_iter().any(written)
    });
    let mut form = start.form.clone();
    let mut seeks_name = false;
    let is_shown = start.shown.contains(&form.task);
    if !writes {
        keys(ui, start, &mut form, wishes);
        if is_shown && pressed(ui, Key::W) {
            wishes.push(Wish::Watch);
        }
        if start.is_first && pressed(ui, Key::G) {
            wishes.push(Wish::Guided);
        }
        let has_certificate = start.progress.as_ref().is_some_and(|it| it.has_certificate);
        if has_certificate && pressed(ui, Key::C) {
            wishes.push(Wish::Certificate);
        }
        if pressed(ui, Key::N) {
            ui.memory_mut(|memory| memory.request_focus(name));
            seeks_name = true;
            form.trainee.clear();
            // The letter that selected the field is not part of the name.
            ui.input_mut(|input| {
                input
                    .events
                    .retain(|event| !matches!(event, egui::Event::Text(_)));
            });
        }
    }
    let mut buttons = vec![(words.say("start-begin"), Wish::Begin)];
    if is_shown {
        buttons.push((words.say("start-watch"), Wish::Watch));
    }
    buttons.push((words.say("start-quit"), Wish::Quit));
    screen(ui, "start", Some(0), &buttons, wishes, |ui, wishes| {
        if start.is_first {
            first(ui, words, wishes);
        }
        title(ui, &words.say("start-title"));
        if let Some(problem) = &start.problem {
            line(ui, Mark::Care, problem);
        }
        if let Some(notice) = &start.notice {
            line(ui, Mark::Good, notice);
        }
        if let Some(rate) = start.slow_per_second {
            let rate = words.number(rate, 1).into();
            let text = words.say_with("start-slow-computer", &[("rate", rate)]);
            line(ui, Mark::Care, &text);
        }
        let is_narrow = ui.available_width() < SIDE_BY_SIDE_POINTS;
        let left = |ui: &mut Ui, form: &mut StartForm| {
            trainee(ui, words, start, form, (name, seeks_name));
            task(ui, words, start, form);
        };
        let mut right = |ui: &mut Ui, form: &mut StartForm| {
            if let Some(view) = &start.progress {
                progress::show(ui, words, view, form, wishes);
            }
            help(ui, words, start, form);
            scope_and_scene(ui, words, start, form);
            devices(ui, words, start, form, file);
            languages(ui, words, form);
            egui::CollapsingHeader::new(words.say("start-look"))
                .id_salt("look")
                .show(ui, |ui| screens::look(ui, words, &mut form.look));
        };
        if is_narrow {
            left(ui, &mut form);
            right(ui, &mut form);
            return;
        }
        ui.columns(2, |columns| {
            if let [one, other] = columns {
                one.vertical(|ui| left(ui, &mut form));
                other.vertical(|ui| right(ui, &mut form));
            }
        });
    });
    if form != start.form {
        wishes.push(Wish::Form(form));
    }
}

/// Offers the guided first steps, for a person who is here for the first time.
fn first(ui: &mut Ui, words: &Words, wishes: &mut Vec<Wish>) {
    Frame::group(ui.style()).inner_margin(10).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            let text = words.say("start-first");
            sketch::task(ui, "basics", PICTURE_POINTS, &text);
            ui.vertical(|ui| {
                ui.label(RichText::new(words.say("start-first-title")).strong());
                ui.label(&text);
                if ui.button(words.say("start-guided")).clicked() {
                    wishes.push(Wish::Guided);
                }
            });
        });
    });
    ui.add_space(8.0);
}

fn keys(ui: &Ui, start: &Start, form: &mut StartForm, wishes: &mut Vec<Wish>) {
    for key in typed(ui) {
        let number = TASK_KEYS.iter().position(|it| *it == key);
        if let Some(task) = number.and_then(|it| start.tasks.get(it)) {
            form.task.clone_from(task);
        }
    }
    // Esc leaves every other screen, so a person who presses it once more than needed stays here.
    let quits = |input: &mut egui::InputState| input.consume_key(egui::Modifiers::COMMAND, Key::Q);
    if ui.input_mut(quits) {
        wishes.push(Wish::Quit);
    }
}

/// Shows the names, and the field for a new one. The page scrolls to the field if `seeks_name`.
fn trainee(
    ui: &mut Ui,
    words: &Words,
    start: &Start,
    form: &mut StartForm,
    (name, seeks_name): (Id, bool),
) {
    let label = part(ui, &words.say("start-trainee"));
    egui::ScrollArea::vertical()
        .id_salt("names")
        .max_height(NAMES_HEIGHT_POINTS)
        .show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let nobody = words.say("start-nobody");
                // A new name stands among the others at once, as the one that is chosen.
                let own = start.form.trainee.trim();
                let is_new = !own.is_empty() && !start.trainees.iter().any(|it| it == own);
                let new = is_new.then(|| start.form.trainee.clone());
                let known = start.trainees.iter().cloned().chain(new);
                let named = known.map(|it| (it.clone(), names::drawn(&it)));
                let names = core::iter::once((String::new(), nobody)).chain(named);
                for (value, shown) in names {
                    ui.selectable_value(&mut form.trainee, value, shown);
                }
            });
        });
    ui.horizontal(|ui| {
        let new = ui.label(words.say("start-new-name"));
        // The field is for a person who is not in the list: it is empty while one of the list is
        // chosen, and who begins to write is another person.
        let writes = ui.memory(|memory| memory.has_focus(name));
        let is_listed = !writes && start.trainees.contains(&form.trainee);
        let mut own = match is_listed {
            true => String::new(),
            false => form.trainee.clone(),
        };
        let field = TextEdit::singleline(&mut own)
            .id(name)
            .char_limit(64)
            .desired_width(f32::INFINITY);
        let field = ui.add(field).labelled_by(new.id).labelled_by(label.id);
        if seeks_name {
            field.scroll_to_me(None);
        }
        if field.changed() || is_listed && field.gained_focus() {
            form.trainee = own;
        }
    });
    names::warn(ui, words, &form.trainee);
    let kept = match form.trainee.trim().is_empty() {
        true => words.say("start-not-kept"),
        false => words.say("start-kept"),
    };
    // A path says nothing to a trainee, so only the pointer calls it up.
    let store = [("store", start.store.as_str().into())];
    ui.label(RichText::new(kept).weak())
        .on_hover_text(words.say_with("start-kept-where", &store));
}

fn task(ui: &mut Ui, words: &Words, start: &Start, form: &mut StartForm) {
    part(ui, &words.say("start-task"));
    for (number, task) in start.tasks.iter().enumerate() {
        let text = format!("{} ({})", words.say(&format!("task-{task}")), number + 1);
        ui.radio_value(&mut form.task, task.clone(), text);
    }
    let asks = words.say(&format!("start-asks-{}", form.task));
    ui.horizontal_top(|ui| {
        sketch::task(ui, &form.task, PICTURE_POINTS, &asks);
        ui.vertical(|ui| ui.label(&asks));
    });
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
            // A patient's scene has a colon in its name, and the name of a message must not have
            // one.
            let id = format!("scene-{}", scene.replace(':', "-"));
            let said = words.say(&id);
            // A scene file has no message and is shown by its own name.
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
    // Lines of this computer concern only those who use real devices.
    if form.emulated {
        ui.label(RichText::new(words.say("start-hand")).italics());
        return;
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
