//! Finds what is new in each answer of a station.

use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::task::TaskMsg;

use crate::clock::RemoteClock;
use crate::wire::{Answer, Ask, MAGIC};

/// New data. Their time stamps are on this computer's clock.
#[derive(Debug, Default)]
pub struct Fresh {
    /// A newer state.
    pub state: Option<Box<StateFrame>>,
    /// Newer tools.
    pub tools: Option<Box<ToolFrame>>,
    /// Newer progress of the task.
    pub task: Option<Box<TaskMsg>>,
    /// Events that had not arrived before, oldest first.
    pub events: Vec<EventMsg>,
    /// Timing batches that had not arrived before, oldest first.
    pub batches: Vec<TimingBatch>,
}

/// Takes answers that may arrive twice, late or not at all, and returns every item once and in
/// order.
#[derive(Debug)]
pub struct Inbox {
    clock: RemoteClock,
    next: Ask,
    /// Number of the newest answer.
    newest: u64,
    /// Events that the server had dropped before the watcher asked for them.
    pub events_lost: u64,
}

impl Default for Inbox {
    fn default() -> Self {
        Self {
            clock: RemoteClock::default(),
            next: Ask {
                magic: MAGIC,
                server: 0,
                events_from: 0,
                batches_from: 0,
                state_at_ns: 0,
                tools_at_ns: 0,
                task_at_ns: 0,
            },
            newest: 0,
            events_lost: 0,
        }
    }
}

impl Inbox {
    /// The next question.
    #[must_use]
    pub fn ask(&self) -> Ask {
        self.next
    }

    /// Takes an answer that arrived at `arrived_ns` to a question that left at `asked_ns`.
    pub fn take(&mut self, answer: Answer, asked_ns: u64, arrived_ns: u64) -> Fresh {
        let Answer {
            head,
            state,
            tools,
            task,
            events,
            batches,
        } = answer;
        if head.server != self.next.server {
            // Another server counts its answers, events and batches anew.
            *self = Self {
                next: Ask {
                    server: head.server,
                    events_from: head.first_event,
                    ..Self::default().next
                },
                events_lost: self.events_lost,
                ..Self::default()
            };
        }
        self.clock.learn(asked_ns, head.now_ns, arrived_ns);
        let clock = self.clock;
        let mut fresh = Fresh::default();
        // An answer that arrives after a later one holds no newer state.
        if head.number > self.newest {
            self.newest = head.number;
            fresh.state = state.map(|mut it| {
                self.next.state_at_ns = it.at_ns;
                it.at_ns = clock.ours_ns(it.at_ns);
                it.sample_ns = clock.ours_ns(it.sample_ns);
                it
            });
            fresh.tools = tools.map(|mut it| {
                self.next.tools_at_ns = it.at_ns;
                it.at_ns = clock.ours_ns(it.at_ns);
                it.sample_ns = clock.ours_ns(it.sample_ns);
                it
            });
            fresh.task = task.map(|mut it| {
                self.next.task_at_ns = it.at_ns;
                it.at_ns = clock.ours_ns(it.at_ns);
                it
            });
        }
        let lost = head.first_event.saturating_sub(self.next.events_from);
        self.events_lost = self.events_lost.saturating_add(lost);
        let known = skipped(self.next.events_from, head.first_event);
        for mut event in events.into_iter().skip(known) {
            event.at_ns = clock.ours_ns(event.at_ns);
            fresh.events.push(event);
        }
        self.next.events_from = self
            .next
            .events_from
            .max(head.first_event.saturating_add(u64::from(head.events)));
        let known = skipped(self.next.batches_from, head.first_batch);
        for mut batch in batches.into_iter().skip(known) {
            for record in &mut batch.records {
                record.scheduled_ns = clock.ours_ns(record.scheduled_ns);
            }
            fresh.batches.push(batch);
        }
        self.next.batches_from = self
            .next
            .batches_from
            .max(head.first_batch.saturating_add(u64::from(head.batches)));
        fresh
    }
}

/// Number of items, from `first` on, that have already arrived.
fn skipped(next: u64, first: u64) -> usize {
    usize::try_from(next.saturating_sub(first)).unwrap_or(usize::MAX)
}
