//! The display's view of its controller: the latest valid frames, and counts of the frames and
//! events that were refused or lost. The inputs are plain values, so that a test needs no shared
//! memory.

use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::scene::SceneFile;

/// Counts of received, refused and lost messages, and of restarts. No count ever decreases.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct FeedCounters {
    /// Valid states.
    pub states: u64,
    /// Valid tool frames.
    pub tools: u64,
    /// Events.
    pub events: u64,
    /// Valid timing batches.
    pub batches: u64,
    /// States, tool frames and batches that were discarded because a count, a number or a pose in
    /// them is out of range.
    pub malformed: u64,
    /// Discarded frames of another scene.
    pub other_scene: u64,
    /// Lost events, counted from gaps in their sequence numbers.
    pub events_lost: u64,
    /// Lost timing batches, counted from gaps in their sequence numbers.
    pub batches_lost: u64,
    /// Restarts of the controller.
    pub restarts: u64,
}

/// Result of offering a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Offer {
    /// Accepted: the frame is now the newest.
    Taken,
    /// Refused: counts or numbers are out of range.
    Malformed,
    /// Refused: the frame belongs to another scene.
    OtherScene,
}

/// The latest valid frames of one scene.
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

    /// The latest valid state.
    #[must_use]
    pub fn state(&self) -> Option<&StateFrame> {
        self.state.as_deref()
    }

    /// The latest valid tools.
    #[must_use]
    pub fn tools(&self) -> Option<&ToolFrame> {
        self.tools.as_deref()
    }

    /// Identity of another scene, if the controller runs one. It comes from the newest refused
    /// frame. It is `None` again after a valid state of this scene; a valid tool frame does not
    /// suffice.
    #[must_use]
    pub fn other_scene_id(&self) -> Option<[u8; 16]> {
        self.other_scene_id
    }

    /// The counters.
    #[must_use]
    pub fn counters(&self) -> FeedCounters {
        self.counters
    }

    /// Offers a state from shared memory.
    pub fn offer_state(&mut self, frame: &StateFrame) -> Offer {
        if frame.scene_id != self.scene_id {
            return self.refuse_scene(frame.scene_id);
        }
        let has_all = frame.spheres().map(<[_]>::len) == Some(self.sphere_count);
        if !has_all || frame.parted().is_none() {
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

    /// Offers a tool frame from shared memory.
    pub fn offer_tools(&mut self, frame: &ToolFrame) -> Offer {
        if frame.scene_id != self.scene_id {
            return self.refuse_scene(frame.scene_id);
        }
        if frame.capsules().is_none() || frame.dents().is_none() {
            self.counters.malformed += 1;
            return Offer::Malformed;
        }
        self.tools = Some(Box::new(*frame));
        self.counters.tools += 1;
        Offer::Taken
    }

    /// Counts an event, and the events lost before it.
    pub fn note_event(&mut self, event: &EventMsg) {
        self.counters.events_lost += gap(&mut self.next_event, event.sequence);
        self.counters.events += 1;
    }

    /// Counts a timing batch, and the batches lost before it. Returns `false` if it is malformed.
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

/// Number of messages lost before `sequence`. A number below the expected one comes from a
/// restarted controller and counts as no loss. So does the first number, because a display may join
/// late.
fn gap(next: &mut Option<u64>, sequence: u64) -> u64 {
    let expected = next.replace(sequence.wrapping_add(1));
    expected.map_or(0, |expected| sequence.saturating_sub(expected))
}

/// A scene's short identity ([`SceneFile::short_id`]) as hexadecimal digits.
#[must_use]
pub fn hex(id: [u8; 16]) -> String {
    use core::fmt::Write as _;
    id.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
