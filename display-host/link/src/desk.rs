//! The station's newest data, ready for watchers.

use std::collections::VecDeque;

use bytemuck::bytes_of;
use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::task::TaskMsg;

use crate::error::LinkError;
use crate::wire::{
    self, Ask, BATCHES_MAX, EVENTS_MAX, Head, MAGIC, SCENE_PART, SceneAsk, SceneHead,
};

/// Events kept for watchers that fall behind.
const EVENTS_KEPT: usize = 4096;
/// Timing batches kept for watchers that fall behind: about 4 s.
const BATCHES_KEPT: usize = 64;

/// Past events that a new watcher receives: as many as a new display gets from shared memory.
const EVENTS_FIRST: u64 = 64;

/// Age of the last message about a task above which the task counts as finished, ns. During a task,
/// the process that assesses it sends a message every 50 ms.
const TASK_KEPT_NS: u64 = 5_000_000_000;

/// The newest data of a station, and its last events and timing batches. Its size is bounded.
#[derive(Debug)]
pub struct Desk {
    server: u64,
    answers: u64,
    state: Option<Box<StateFrame>>,
    tools: Option<Box<ToolFrame>>,
    task: Option<Box<TaskMsg>>,
    events: Kept<EventMsg, EVENTS_KEPT>,
    batches: Kept<TimingBatch, BATCHES_KEPT>,
}

/// The last `CAPACITY` items, numbered from 0 since the desk began.
#[derive(Debug)]
struct Kept<T, const CAPACITY: usize> {
    items: VecDeque<T>,
    /// Number of the oldest item that is kept.
    first: u64,
}

impl<T: Copy, const CAPACITY: usize> Kept<T, CAPACITY> {
    fn new() -> Self {
        let items = VecDeque::with_capacity(CAPACITY);
        Self { items, first: 0 }
    }

    fn add(&mut self, item: T) {
        if self.items.len() >= CAPACITY {
            self.items.pop_front();
            self.first += 1;
        }
        self.items.push_back(item);
    }

    /// Number of the next item.
    fn end(&self) -> u64 {
        self.first + self.items.len() as u64
    }

    /// At most `most` items from `number` on, and the number of the first of them.
    fn from(&self, number: u64, most: usize) -> (u64, impl Iterator<Item = &T>) {
        let first = number.clamp(self.first, self.end());
        let skipped = usize::try_from(first - self.first).unwrap_or(usize::MAX);
        (first, self.items.iter().skip(skipped).take(most))
    }
}

impl Desk {
    /// Makes a desk. `server` distinguishes this desk from earlier and later ones of the station.
    #[must_use]
    pub fn new(server: u64) -> Self {
        Self {
            server,
            answers: 0,
            state: None,
            tools: None,
            task: None,
            events: Kept::new(),
            batches: Kept::new(),
        }
    }

    /// Identity of the running scene.
    #[must_use]
    pub fn scene_id(&self) -> Option<[u8; 16]> {
        self.state.as_ref().map(|it| it.scene_id)
    }

    /// Replaces the state.
    pub fn set_state(&mut self, state: &StateFrame) {
        match &mut self.state {
            Some(to) => **to = *state,
            to @ None => *to = Some(Box::new(*state)),
        }
    }

    /// Replaces the tools.
    pub fn set_tools(&mut self, tools: &ToolFrame) {
        self.tools = Some(Box::new(*tools));
    }

    /// Replaces the progress of the task.
    pub fn set_task(&mut self, task: &TaskMsg) {
        self.task = Some(Box::new(*task));
    }

    /// Adds an event.
    pub fn add_event(&mut self, event: EventMsg) {
        self.events.add(event);
    }

    /// Adds a timing batch.
    pub fn add_batch(&mut self, batch: &TimingBatch) {
        self.batches.add(*batch);
    }

    /// Answers a watcher's question.
    ///
    /// # Errors
    /// [`LinkError::Malformed`] when `asked` is not an [`Ask`].
    pub fn answer(&mut self, mut asked: &[u8], now_ns: u64) -> Result<Vec<u8>, LinkError> {
        let ask: Ask = wire::take(&mut asked, "half a question")?;
        wire::check(ask.magic)?;
        let known = ask.server == self.server;
        let (events_from, batches_from) = match known {
            true => (ask.events_from, ask.batches_from),
            false => (
                self.events.end().saturating_sub(EVENTS_FIRST),
                self.batches.end(),
            ),
        };
        let (first_event, events) = self.events.from(events_from, EVENTS_MAX);
        let (first_batch, batches) = self.batches.from(batches_from, BATCHES_MAX);
        self.answers += 1;
        let mut head = Head {
            magic: MAGIC,
            server: self.server,
            number: self.answers,
            now_ns,
            first_event,
            first_batch,
            state_bytes: 0,
            tools: 0,
            events: 0,
            batches: 0,
            task_bytes: 0,
            reserved: 0,
        };
        let mut body = Vec::with_capacity(64 << 10);
        let state = self.state.as_deref();
        if let Some(state) = state.filter(|it| !known || it.at_ns != ask.state_at_ns) {
            // A malformed state is left out.
            head.state_bytes = wire::put_state(&mut body, state).unwrap_or(0);
        }
        let tools = self.tools.as_deref();
        let is_new = |it: &&ToolFrame| !known || it.at_ns != ask.tools_at_ns;
        if let Some(tools) = tools.filter(is_new).filter(|it| it.capsules().is_some()) {
            head.tools = 1;
            body.extend_from_slice(bytes_of(tools));
        }
        let is_new = |it: &&TaskMsg| !known || it.at_ns != ask.task_at_ns;
        let is_of_now = |it: &&TaskMsg| now_ns.saturating_sub(it.at_ns) < TASK_KEPT_NS;
        let task = self.task.as_deref().filter(is_new);
        if let Some(task) = task.filter(is_of_now) {
            head.task_bytes = wire::put_task(&mut body, task).unwrap_or(0);
        }
        for event in events {
            head.events += 1;
            body.extend_from_slice(bytes_of(event));
        }
        for batch in batches {
            // Batches are checked before they are added, so all can be sent.
            head.batches += u32::from(wire::put_batch(&mut body, batch).is_some());
        }
        let mut answer = bytes_of(&head).to_vec();
        answer.append(&mut body);
        Ok(answer)
    }
}

/// Scene and first byte that a watcher asks for.
pub(crate) fn scene_asked(mut asked: &[u8]) -> Result<SceneAsk, LinkError> {
    let ask: SceneAsk = wire::take(&mut asked, "half a question")?;
    wire::check(ask.magic)?;
    Ok(ask)
}

/// Part of a scene, or the answer that the scene is missing.
pub(crate) fn scene_answer(scene: Option<&[u8]>, ask: &SceneAsk) -> Vec<u8> {
    let scene = scene.unwrap_or_default();
    let from = usize::try_from(ask.offset)
        .unwrap_or(usize::MAX)
        .min(scene.len());
    let rest = scene.get(from..).unwrap_or_default();
    let head = SceneHead {
        magic: MAGIC,
        total: scene.len() as u64,
        offset: from as u64,
    };
    let mut answer = bytes_of(&head).to_vec();
    let wanted = usize::try_from(ask.part_bytes).unwrap_or(SCENE_PART);
    let part = rest.get(..wanted.clamp(1, SCENE_PART));
    answer.extend_from_slice(part.unwrap_or(rest));
    answer
}
