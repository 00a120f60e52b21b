//! What the display knows of its controller: the newest valid frames, what it refused, and what
//! it lost. Plain inputs, so that it is tested without shared memory.

use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::scene::SceneFile;

/// Counters of what came in. All only grow.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct FeedCounters {
    /// Good states.
    pub states: u64,
    /// Good tool frames.
    pub tools: u64,
    /// Events.
    pub events: u64,
    /// Timing batches.
    pub batches: u64,
    /// States, tool frames and batches thrown away: count, number, pose out of range.
    pub malformed: u64,
    /// Frames of another scene, thrown away.
    pub other_scene: u64,
    /// Events that the sequence number says were lost.
    pub events_lost: u64,
    /// Timing batches that the sequence number says were lost.
    pub batches_lost: u64,
    /// Times that the controller was seen to start afresh.
    pub restarts: u64,
}

/// What became of an offered frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Offer {
    /// It is the newest now.
    Taken,
    /// Counts or numbers are out of range.
    Malformed,
    /// It shows another scene.
    OtherScene,
}

/// The newest valid frames of one scene.
#[derive(Debug)]
pub struct Feed {
    scene_id: [u8; 16],
    sphere_count: usize,
    state: Option<Box<StateFrame>>,
    tools: Option<Box<ToolFrame>>,
    other_scene_id: Option<[u8; 16]>,
    next_event: Option<u64>,
    next_batch: Option<u64>,
    counters: FeedCounters,
}

impl Feed {
    /// A feed for one scene.
    #[must_use]
    pub fn new(scene: &SceneFile) -> Self {
        Self {
            scene_id: scene.short_id(),
            sphere_count: scene.spheres().len(),
            state: None,
            tools: None,
            other_scene_id: None,
            next_event: None,
            next_batch: None,
            counters: FeedCounters::default(),
        }
    }

    /// The newest valid state.
    #[must_use]
    pub fn state(&self) -> Option<&StateFrame> {
        self.state.as_deref()
    }

    /// The newest valid tools.
    #[must_use]
    pub fn tools(&self) -> Option<&ToolFrame> {
        self.tools.as_deref()
    }

    /// Identity of another scene that the controller runs, if the last frame showed one.
    #[must_use]
    pub fn other_scene_id(&self) -> Option<[u8; 16]> {
        self.other_scene_id
    }

    /// What came in so far.
    #[must_use]
    pub fn counters(&self) -> FeedCounters {
        self.counters
    }

    /// Offers a state as it came out of shared memory.
    pub fn offer_state(&mut self, frame: &StateFrame) -> Offer {
        if frame.scene_id != self.scene_id {
            return self.refuse_scene(frame.scene_id);
        }
        if frame.spheres().map(<[_]>::len) != Some(self.sphere_count) {
            self.counters.malformed += 1;
            return Offer::Malformed;
        }
        if self.state().is_some_and(|last| frame.tick < last.tick) {
            self.counters.restarts += 1;
        }
        match &mut self.state {
            Some(state) => **state = *frame,
            None => self.state = Some(Box::new(*frame)),
        }
        self.counters.states += 1;
        self.other_scene_id = None;
        Offer::Taken
    }

    /// Offers a tool frame as it came out of shared memory.
    pub fn offer_tools(&mut self, frame: &ToolFrame) -> Offer {
        if frame.scene_id != self.scene_id {
            return self.refuse_scene(frame.scene_id);
        }
        if frame.capsules().is_none() {
            self.counters.malformed += 1;
            return Offer::Malformed;
        }
        self.tools = Some(Box::new(*frame));
        self.counters.tools += 1;
        Offer::Taken
    }

    /// Counts an event, and what is missing before it.
    pub fn note_event(&mut self, event: &EventMsg) {
        self.counters.events_lost += gap(&mut self.next_event, event.sequence);
        self.counters.events += 1;
    }

    /// Counts a timing batch, and what is missing before it. `false`: malformed.
    pub fn note_timing(&mut self, batch: &TimingBatch) -> bool {
        if batch.records().is_none() {
            self.counters.malformed += 1;
            return false;
        }
        self.counters.batches_lost += gap(&mut self.next_batch, batch.sequence);
        self.counters.batches += 1;
        true
    }

    fn refuse_scene(&mut self, id: [u8; 16]) -> Offer {
        self.other_scene_id = Some(id);
        self.counters.other_scene += 1;
        Offer::OtherScene
    }
}

/// Numbers missing before `sequence`. A number that falls is a controller that started afresh;
/// the first number seen is no gap, because a display may join late.
fn gap(next: &mut Option<u64>, sequence: u64) -> u64 {
    let expected = next.replace(sequence.wrapping_add(1));
    expected.map_or(0, |expected| sequence.saturating_sub(expected))
}

/// First half of a scene's identity as text.
#[must_use]
pub fn hex(id: [u8; 16]) -> String {
    use core::fmt::Write as _;
    id.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
