//! What the user asks for, and the keys that ask for it.

use egui::{Key, Ui};

use super::UiState;
use super::screens::Settings;

/// What the user asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Stand still, or go on.
    Pause(bool),
    /// Put every organ back to rest.
    Reset,
    /// Let force through, or cut it.
    EnableForce(bool),
    /// Take an instrument.
    Instrument(u32),
    /// The alarm was seen.
    Acknowledge,
    /// Show the simulation over the picture, or not.
    ToggleEngineering,
    /// Hide or show the panel.
    TogglePanel,
    /// Take the instrument with mouse and keyboard, or let it go.
    ToggleHand,
    /// Fill the screen, or not.
    ToggleFullScreen,
    /// Take the next endoscope: 0°, 30°, 45°.
    NextScope,
    /// Turn its light cable a step to the left (−1) or the right (1).
    TurnScope(i8),
    /// Turn its camera's focus ring a step: nearer (−1) or farther (1).
    TurnFocus(i8),
    /// Wipe its lens.
    WipeLens,
    /// Open the trocar's valve, so that smoke is drawn off, or close it.
    ToggleSuction,
    /// From the start again.
    Again,
    /// Of a replay: go to this time from its start, ms.
    Seek(u32),
    /// Of a replay: so many times as fast as it was, in thousandths.
    Speed(u32),
    /// Leave the endoscope, or look through it again.
    FreeView(bool),
    /// Move the view that has left it.
    LookAround(FreeView),
    /// Open or close the settings.
    ShowSettings(bool),
    /// Take these settings.
    Set(Settings),
    /// End.
    Quit,
}

impl Asked {
    /// Whether it changes what happens on the station, and not only how it is shown.
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
            | Self::Quit => false,
        }
    }
}

/// How the free view is moved, in points of the pointer's and the wheel's way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FreeView {
    /// The pointer to the right.
    pub right: i16,
    /// The pointer down.
    pub down: i16,
    /// The wheel away from the user.
    pub nearer: i16,
}

/// What the keys ask for while no page takes them.
pub(super) fn keys(ui: &Ui, state: &UiState) -> Vec<Asked> {
    ui.input(|input| {
        let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4];
        let instruments = (0..)
            .zip(numbers)
            .map(|(i, key)| (key, Asked::Instrument(i)));
        let table = [
            // Whoever is caught in the picture gets out before the station ends.
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
            // Wherever the plus lies.
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
            .collect()
    })
}
