//! Line about the current: what flows, and why none flows although a pedal is pressed.

use assess::Step;
use shared_mem::message::{DeviceHealth, ToolFrame};
use shared_mem::words::{Instrument, Switches};

use super::UiState;

/// Message about the current of the electrode. The controller's own switches decide. They differ
/// from the pressed keys if the pedal's line is late, or if the pedal was held when its line
/// returned.
pub(super) fn message(state: &UiState, tools: &ToolFrame) -> &'static str {
    let both = [Switches::CUT, Switches::COAGULATE];
    let pedals = both.map(|it| tools.switches().contains(it));
    let is_pressed = both.iter().any(|it| state.pressed.contains(*it));
    match pedals {
        [true, true] => "hud-pedal-both",
        [false, false] if !is_pressed => "hud-pedal-none",
        [false, false] if tools.health[2].status != DeviceHealth::LIVE => "hud-current-late",
        [false, false] => "hud-current-held",
        _ if !tools.has(Instrument::Hook) && !sews(state, tools) => "hud-current-instrument",
        [true, false] => "hud-pedal-cut",
        [false, true] => "hud-pedal-coagulate",
    }
}

/// True if the line about the current says more than that the pedal is off.
pub(super) fn tells(state: &UiState, tools: &ToolFrame) -> bool {
    message(state, tools) != "hud-pedal-none"
}

/// True while the grasper places a suture, for which the pedal is pressed without any current.
fn sews(state: &UiState, tools: &ToolFrame) -> bool {
    let mut steps = state.task_view.iter().flat_map(|it| &it.steps);
    tools.has(Instrument::Grasper)
        && steps.any(|(step, done)| !done && matches!(step, Step::Hang { .. }))
}
