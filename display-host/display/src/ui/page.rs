//! Layout and keys of a window that shows widgets and no picture: content that scrolls, and below
//! it buttons that stay.

use egui::{Button, Color32, Id, Response, RichText, Ui};

use super::screens::{BODY_POINTS, legible};

/// Height of a window below which it is low, points, as with large text. Only the first buttons
/// then stay visible, so that the content has room.
const LOW: f32 = 420.0;
/// Number of the buttons that stay visible in a low window.
const STAYING: usize = 2;

/// Name of a screen. The content scrolls to its top if the name changes.
#[derive(Debug, Clone, Copy, Hash)]
pub(super) struct Name<'a> {
    /// Name of the kind of screen, for the focus.
    pub(super) screen: &'static str,
    /// The thing that is shown, such as a session.
    pub(super) of: &'a str,
    /// Result of the last request, which stands beside the buttons.
    pub(super) notice: Option<&'a str>,
}

impl From<&'static str> for Name<'_> {
    fn from(screen: &'static str) -> Self {
        Self {
            screen,
            of: "",
            notice: None,
        }
    }
}

/// Shows a screen: its content, and below it the buttons, which are always visible. In a low window
/// only the first [`STAYING`] buttons are always visible, and the others follow the content. Enter
/// presses the button with the index `meant`, if any, unless another widget has the focus.
pub(super) fn screen<'a, Wish: Clone>(
    ui: &mut Ui,
    name: impl Into<Name<'a>>,
    meant: Option<usize>,
    buttons: &[(String, Wish)],
    wishes: &mut Vec<Wish>,
    add: impl FnOnce(&mut Ui, &mut Vec<Wish>),
) {
    let name = name.into();
    // The default button of a new screen gets the focus in its first frame, and acts on keys from
    // the next frame on. Until then this code handles Enter.
    let none_chosen = ui.memory(|memory| memory.focused().is_none());
    if let Some((_, wish)) = meant.and_then(|it| buttons.get(it))
        && none_chosen
        && pressed(ui, egui::Key::Enter)
    {
        wishes.push(wish.clone());
    }
    let staying = match ui.available_height() < LOW {
        true => buttons.len().min(STAYING.max(meant.map_or(0, |it| it + 1))),
        false => buttons.len(),
    };
    let (staying, following) = buttons.split_at(staying);
    settle(ui, name);
    egui::Panel::bottom("page buttons")
        .resizable(false)
        .show(ui, |ui| {
            legible(ui);
            if let Some(notice) = name.notice {
                ui.add_space(6.0);
                ui.label(RichText::new(notice).italics());
            }
            ui.add_space(10.0);
            // Each screen has widget ids of its own, so that the previous screen's focus does not
            // carry over.
            ui.push_id(name.screen, |ui| row(ui, staying, meant, wishes));
            ui.add_space(6.0);
        });
    egui::CentralPanel::default().show(ui, |ui| {
        let salt = (name.screen, name.of);
        egui::ScrollArea::vertical().id_salt(salt).show(ui, |ui| {
            legible(ui);
            ui.set_width(ui.available_width());
            add(ui, wishes);
            if !following.is_empty() {
                ui.add_space(10.0);
                row(ui, following, None, wishes);
            }
        });
    });
}

/// Asks for another frame if the notice is new: the panel at the bottom takes its height from the
/// frame before, so that the last buttons would stay below the window's edge.
fn settle(ui: &Ui, name: Name<'_>) {
    let (id, now) = (Id::unique("page notice"), name.notice.map(str::to_owned));
    let before = ui.data_mut(|data| {
        let before = data.get_temp::<Option<String>>(id);
        data.insert_temp(id, now.clone());
        before
    });
    if before != Some(now) {
        ui.ctx().request_repaint();
    }
}

/// Shows buttons beside each other. The one with the index `meant` is the default button.
fn row<Wish: Clone>(
    ui: &mut Ui,
    buttons: &[(String, Wish)],
    meant: Option<usize>,
    wishes: &mut Vec<Wish>,
) {
    ui.horizontal_wrapped(|ui| {
        for (number, (text, wish)) in buttons.iter().enumerate() {
            let response = match meant == Some(number) {
                true => first(ui, text),
                false => ui.button(text.as_str()),
            };
            if response.clicked() {
                wishes.push(wish.clone());
            }
        }
    });
}

/// The default button: Enter presses it unless another widget has the focus.
fn first(ui: &mut Ui, text: &str) -> Response {
    let text = RichText::new(text).size(1.2 * BODY_POINTS).strong();
    let response =
        ui.add(Button::new(text.color(Color32::WHITE)).fill(Color32::from_rgb(25, 95, 60)));
    if ui.memory(|memory| memory.focused().is_none()) {
        response.request_focus();
    }
    response
}

/// Drops the repeats of keys, so that a held key makes one request and does not act on the next
/// screen. Backspace, Delete, Tab and the arrow keys repeat, and so does typed text.
pub(super) fn drop_repeats(ui: &Ui) {
    use egui::Key;
    let goes_on = |key: &Key| {
        matches!(
            key,
            Key::Backspace
                | Key::Delete
                | Key::Tab
                | Key::ArrowLeft
                | Key::ArrowRight
                | Key::ArrowUp
                | Key::ArrowDown
        )
    };
    ui.input_mut(|input| {
        input.events.retain(|event| match event {
            egui::Event::Key { repeat, key, .. } => !repeat || goes_on(key),
            _ => true,
        });
    });
}

pub(super) fn pressed(ui: &Ui, key: egui::Key) -> bool {
    ui.input(|input| input.key_pressed(key))
}

/// Keys pressed since the last frame, in order. On a slow machine there may be several.
pub(super) fn typed(ui: &Ui) -> Vec<egui::Key> {
    let key = |event: &egui::Event| match event {
        egui::Event::Key {
            key, pressed: true, ..
        } => Some(*key),
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(key).collect())
}
