//! State of the recording.

use egui::Ui;

use super::UiState;
use super::widgets::{Mark, line};
use session::Standing;

/// State of the recording.
pub type RecordingView = session::Health;

/// Shows the recording, if there is one.
pub(super) fn show(ui: &mut Ui, state: &UiState) {
    let Some(health) = &state.recording else {
        return;
    };
    let words = &state.words;
    let megabytes = |bytes: u64| words.number(bytes as f64 / 1e6, 1).into();
    let (mark, text) = match health.standing {
        Standing::Ended => (Mark::Bad, words.say("recording-ended")),
        Standing::Refused => {
            let values = [("megabytes", megabytes(health.waiting))];
            (Mark::Bad, words.say_with("recording-waits", &values))
        }
        Standing::Hanging => (Mark::Bad, words.say("recording-hangs")),
        Standing::Recording if health.missing > 0 => {
            let values = [("missing", health.missing.to_string().into())];
            (Mark::Care, words.say_with("recording-gap", &values))
        }
        Standing::Recording if health.missing_events > 0 => {
            let values = [("missing", health.missing_events.to_string().into())];
            (Mark::Care, words.say_with("recording-events", &values))
        }
        Standing::Recording => {
            let values = [("megabytes", megabytes(health.bytes))];
            (Mark::Good, words.say_with("recording-on", &values))
        }
    };
    line(ui, mark, &text);
}
