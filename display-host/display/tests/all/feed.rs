//! The feed accepts any content of shared memory and shows only valid frames.

use bytemuck::Zeroable as _;
use display_host::feed::{Feed, Offer, hex};
use proptest::prelude::*;
use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};

use crate::support;

fn event(sequence: u64) -> EventMsg {
    EventMsg {
        sequence,
        ..EventMsg::zeroed()
    }
}

#[test]
fn gaps_in_the_events_are_counted_and_a_late_start_is_none() {
    let mut feed = Feed::new(&support::scene(12));
    for sequence in [100, 101, 104, 105, 0, 1, 3] {
        feed.note_event(&event(sequence));
    }
    // Events 102 and 103 are missing. Then the controller restarts, and event 2 is missing.
    assert_eq!(feed.counters().events, 7);
    assert_eq!(feed.counters().events_lost, 3);
}

#[test]
fn a_batch_that_claims_too_many_records_is_refused() {
    let mut feed = Feed::new(&support::scene(12));
    let mut batch: Box<TimingBatch> = bytemuck::allocation::zeroed_box();
    assert!(feed.note_timing(&batch));
    batch.count = 65;
    assert!(!feed.note_timing(&batch));
    assert_eq!(feed.counters().malformed, 1);
}

#[test]
fn a_tick_that_falls_is_a_controller_that_started_afresh() {
    let scene = support::scene(12);
    let mut feed = Feed::new(&scene);
    let mut state = support::state(&scene, 0.0);
    for tick in [5, 6, 6, 900, 1, 2] {
        state.tick = tick;
        assert_eq!(feed.offer_state(&state), Offer::Taken);
    }
    assert_eq!(feed.counters().restarts, 1);
    assert_eq!(feed.state().map(|s| s.tick), Some(2));
}

#[test]
fn another_scene_is_kept_out_and_named() {
    let scene = support::scene(12);
    let mut feed = Feed::new(&scene);
    let mut state = support::state(&scene, 0.0);
    state.scene_id = [0x0f; 16];
    assert_eq!(feed.offer_state(&state), Offer::OtherScene);
    assert!(feed.state().is_none());
    let other = feed.other_scene_id().map(hex);
    assert_eq!(other.as_deref(), Some("0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f0f"));
    // A controller of the right scene returns.
    feed.offer_state(&support::state(&scene, 0.0));
    assert!(feed.other_scene_id().is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any bytes are accepted only if every check holds, and never cause a panic.
    #[test]
    fn garbage_in_a_state_is_never_shown(
        at in 0usize..200, word in any::<u32>(), count in prop_oneof![any::<u32>(), 0u32..5000],
    ) {
        let scene = support::scene(12);
        let mut feed = Feed::new(&scene);
        let mut state = support::state(&scene, 0.0);
        let used = state.sphere_count;
        state.sphere_count = if count % 3 == 0 { count } else { used };
        let words: &mut [u32] = bytemuck::cast_slice_mut(&mut state.spheres);
        words[at] = word;
        let offer = feed.offer_state(&state);
        let sound = state.sphere_count == used
            && state.spheres.iter().all(|s| s.center_m.iter().all(|x| x.abs() < 1e3));
        prop_assert_eq!(offer == Offer::Taken, sound);
        prop_assert_eq!(feed.state().is_some(), sound);
        prop_assert_eq!(feed.counters().malformed, u64::from(!sound));
    }

    #[test]
    fn garbage_in_a_tool_frame_is_never_shown(
        bytes in proptest::collection::vec(any::<u8>(), size_of::<ToolFrame>()),
    ) {
        let scene = support::scene(12);
        let mut feed = Feed::new(&scene);
        let mut tools = ToolFrame::zeroed();
        bytemuck::bytes_of_mut(&mut tools).copy_from_slice(&bytes);
        tools.scene_id = scene.short_id();
        let offer = feed.offer_tools(&tools);
        prop_assert_eq!(offer == Offer::Taken, tools.capsules().is_some());
    }
}

/// A frame of zeros comes from a controller that has not filled it. No scene has the identity 0.
#[test]
fn zeros_show_nothing() {
    let mut feed = Feed::new(&support::scene(12));
    let state: Box<StateFrame> = bytemuck::allocation::zeroed_box();
    assert_ne!(feed.offer_state(&state), Offer::Taken);
    assert_ne!(feed.offer_tools(&ToolFrame::zeroed()), Offer::Taken);
}

#[test]
fn tools_are_shown() {
    let scene = support::scene(12);
    let mut feed = Feed::new(&scene);
    let tools = support::tools(&scene, 0.01, 0.5);
    assert_eq!(feed.offer_tools(&tools), Offer::Taken);
}
