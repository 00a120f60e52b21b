//! Requests of the user, and their keys.

use egui::{Key, Ui};
use shared_mem::message::ActMsg;

use super::UiState;
use super::screens::Settings;

/// A request of the user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// Pause, or resume.
    Pause(bool),
    /// Restart the task if it has a start of its own, else reset all organs.
    Reset,
    /// Enable the force, or disable it.
    EnableForce(bool),
    /// Take an instrument.
    Instrument(u32),
    /// Acknowledge the alarm.
    Acknowledge,
    /// Turn to the next state of the engineering view.
    ToggleEngineering,
    /// Hide or show the panel.
    TogglePanel,
    /// Take the instrument with mouse and keyboard, or release it.
    ToggleHand,
    /// Fill the screen, or leave full screen.
    ToggleFullScreen,
    /// Take the next endoscope: 0°, 30°, 45°.
    NextScope,
    /// Turn the endoscope's light cable a step to the left (−1) or the right (1).
    TurnScope(i8),
    /// Turn the focus ring of the endoscope's camera a step: nearer (−1) or farther (1).
    TurnFocus(i8),
    /// Wipe the endoscope's lens.
    WipeLens,
    /// Open the trocar's valve, through which smoke is evacuated, or close it.
    ToggleSuction,
    /// [`Reset`](Self::Reset), and resume.
    Again,
    /// In a replay: go to this time from its start, ms.
    Seek(u32),
    /// In a replay: play at this speed, in thousandths of the recorded one.
    Speed(u32),
    /// Leave the endoscope's view, or return to it.
    FreeView(bool),
    /// Move the free view.
    LookAround(FreeView),
    /// Open or close the settings.
    ShowSettings(bool),
    /// Apply these settings.
    Set(Settings),
    /// As an instructor, point at this place of the picture. The place is given from the picture's
    /// middle, in half heights, y up.
    Point([f32; 2]),
    /// As an instructor, do this at the station.
    Act(ActMsg),
    /// Quit.
    Quit,
}

impl Asked {
    /// True if the request leads the instrument or restarts the task. In a replay the recorded
    /// hand leads.
    const fn leads(self) -> bool {
        matches!(
            self,
            Self::Reset
                | Self::Again
                | Self::EnableForce(_)
                | Self::Instrument(_)
                | Self::ToggleHand
        )
    }

    /// True if the request commands the controller. An instructor's display may not command it,
    /// because the station decides on an instructor's acts.
    #[must_use]
    pub const fn reaches_in(self) -> bool {
        match self {
            Self::Pause(_)
            | Self::Reset
            | Self::EnableForce(_)
            | Self::Instrument(_)
            | Self::ToggleHand
            | Self::Seek(_)
            | Self::Speed(_)
            | Self::Again => true,
            Self::Acknowledge
            | Self::ToggleEngineering
            | Self::TogglePanel
            | Self::ToggleFullScreen
            | Self::NextScope
            | Self::TurnScope(_)
            | Self::TurnFocus(_)
            | Self::WipeLens
            | Self::ToggleSuction
            | Self::FreeView(_)
            | Self::LookAround(_)
            | Self::ShowSettings(_)
            | Self::Set(_)
            | Self::Point(_)
            | Self::Act(_)
            | Self::Quit => false,
        }
    }
}

/// Motion of the free view, in points of pointer and wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FreeView {
    /// Motion of the pointer to the right.
    pub right: i16,
    /// Motion of the pointer down.
    pub down: i16,
    /// Motion of the wheel away from the user.
    pub nearer: i16,
}

/// Requests by keys, while no page of settings takes the keys.
pub(super) fn keys(ui: &Ui, state: &UiState) -> Vec<Asked> {
    // Letters of a remark are no requests.
    if ui.ctx().egui_wants_keyboard_input() && state.instructor {
        return Vec::new();
    }
    ui.input(|input| {
        let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5];
        let instruments = (0..)
            .zip(numbers)
            .map(|(i, key)| (key, Asked::Instrument(i)));
        let table = [
            // The first Esc releases the instrument, the next one ends the station.
            (
                Key::Escape,
                if state.in_hand {
                    Asked::ToggleHand
                } else {
                    Asked::Quit
                },
            ),
            (Key::M, Asked::ToggleHand),
            (Key::P, Asked::Pause(!state.is_paused())),
            (
                Key::R,
                if state.is_paused() {
                    Asked::Again
                } else {
                    Asked::Reset
                },
            ),
            (Key::O, Asked::ShowSettings(true)),
            (Key::F, Asked::EnableForce(!state.is_force_enabled())),
            (Key::A, Asked::Acknowledge),
            (Key::E, Asked::ToggleEngineering),
            (Key::H, Asked::TogglePanel),
            (Key::F11, Asked::ToggleFullScreen),
            (Key::S, Asked::NextScope),
            (Key::OpenBracket, Asked::TurnScope(-1)),
            (Key::CloseBracket, Asked::TurnScope(1)),
            (Key::Minus, Asked::TurnFocus(-1)),
            // Plus is on one of these keys on any keyboard layout.
            (Key::Plus, Asked::TurnFocus(1)),
            (Key::Equals, Asked::TurnFocus(1)),
            (Key::W, Asked::WipeLens),
            (Key::D, Asked::ToggleSuction),
        ];
        let pressed = table.into_iter().chain(instruments);
        pressed
            .filter(|&(key, _)| input.key_pressed(key))
            .map(|(_, asked)| asked)
            .filter(|asked| !(state.instructor && asked.reaches_in()))
            // An exchange would release tissue, and nothing may change in a pause. The expert
            // chooses the instruments that it uses.
            .filter(|asked| {
                let is_closed = state.is_paused() || state.watched;
                !(is_closed && matches!(asked, Asked::Instrument(_)))
            })
            .filter(|asked| state.replay.is_none() || !asked.leads())
            .collect()
    })
}
