//! Body of the fuzz target for the link: no answer of a station may make a watcher panic or take
//! memory out of proportion, and an answer that is accepted is within its limits.

use link::wire::{Answer, BATCHES_MAX, EVENTS_MAX, SCENE_MAX, SCENE_PART, scene_part};

/// Reads the bytes as each kind of answer.
pub(crate) fn read(bytes: &[u8]) {
    if let Ok(answer) = Answer::read(bytes) {
        assert!(answer.events.len() <= EVENTS_MAX && answer.batches.len() <= BATCHES_MAX);
        for event in &answer.events {
            let _ = event.decode();
        }
        if let Some(state) = &answer.state {
            assert!(
                state.spheres().is_some() && state.clips().is_some() && state.cells().is_some()
            );
        }
        assert!(answer.task.is_none_or(|task| task.text().is_some()));
    }
    if let Ok((total, offset, part)) = scene_part(bytes) {
        assert!(total <= SCENE_MAX && part.len() <= SCENE_PART);
        assert!(offset + part.len() as u64 <= total);
    }
}
