//! The bounded queue between the listening and the writing thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::time::Duration;

use shared_mem::inputs::InputBatch;
use shared_mem::message::{EventMsg, StateFrame, TimingBatch, ToolFrame};

/// Capacity of the queue to the writing thread, messages: about 40 s of a session.
pub(super) const QUEUE: usize = 6144;
/// Part of the capacity that only events may use, so that a queue full of ticks still takes events.
const FOR_EVENTS: usize = 1024;

pub(super) enum Item {
    Inputs(Box<InputBatch>),
    /// The tools. The flag is true if their poses are also written for viewers.
    Tools(Box<ToolFrame>, bool),
    /// The organs, for an identity image.
    State(Box<StateFrame>),
    Event(EventMsg),
    Timing(Box<TimingBatch>),
}

/// The writing thread's end of the queue.
#[derive(Debug)]
pub(super) struct Items {
    items: Receiver<Item>,
    waiting: Arc<AtomicUsize>,
    pub(super) heard: Arc<AtomicU64>,
}

impl Items {
    pub(super) fn next(&self) -> Result<Item, RecvTimeoutError> {
        let item = self.items.recv_timeout(Duration::from_millis(100));
        if item.is_ok() {
            self.waiting.fetch_sub(1, Relaxed);
        }
        item
    }
}

/// The listening thread's end of the queue.
pub(super) struct Queue {
    items: SyncSender<Item>,
    waiting: Arc<AtomicUsize>,
    overflowed: Arc<AtomicU64>,
    /// One more than the number of the newest event. It reveals events that were lost at the end.
    pub(super) heard: Arc<AtomicU64>,
}

impl Queue {
    /// Queues an item for the writer. A full queue drops the item. Items other than events are
    /// dropped earlier, so that room remains for events.
    pub(super) fn send(&self, item: Item) {
        let is_event = match &item {
            Item::Event(event) => {
                self.heard.store(event.sequence.saturating_add(1), Relaxed);
                true
            }
            _ => false,
        };
        let waiting = self.waiting.fetch_add(1, Relaxed);
        let has_room = is_event || waiting < QUEUE - FOR_EVENTS;
        let sent = match has_room {
            true => self
                .items
                .try_send(item)
                .map_err(|it| matches!(it, TrySendError::Full(_))),
            false => Err(true),
        };
        if let Err(is_full) = sent {
            self.waiting.fetch_sub(1, Relaxed);
            self.overflowed.fetch_add(u64::from(is_full), Relaxed);
        }
    }
}

pub(super) fn queue(overflowed: Arc<AtomicU64>) -> (Queue, Items) {
    let (sender, items) = mpsc::sync_channel(QUEUE);
    let (waiting, heard) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicU64::new(0)));
    let queue = Queue {
        items: sender,
        waiting: waiting.clone(),
        overflowed,
        heard: heard.clone(),
    };
    (
        queue,
        Items {
            items,
            waiting,
            heard,
        },
    )
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    #[test]
    fn a_queue_full_of_ticks_still_takes_events() {
        let overflowed = Arc::new(AtomicU64::new(0));
        let (queue, items) = queue(overflowed.clone());
        for _ in 0..QUEUE + 100 {
            queue.send(Item::Inputs(Box::new(InputBatch::zeroed())));
        }
        assert_eq!(overflowed.load(Relaxed), FOR_EVENTS as u64 + 100);
        for _ in 0..FOR_EVENTS {
            queue.send(Item::Event(EventMsg::zeroed()));
        }
        assert_eq!(overflowed.load(Relaxed), FOR_EVENTS as u64 + 100);
        queue.send(Item::Event(EventMsg::zeroed()));
        assert_eq!(overflowed.load(Relaxed), FOR_EVENTS as u64 + 101);
        let (mut inputs, mut events) = (0, 0);
        drop(queue);
        while let Ok(item) = items.next() {
            match item {
                Item::Event(_) => events += 1,
                _ => inputs += 1,
            }
        }
        assert_eq!((inputs, events), (QUEUE - FOR_EVENTS, FOR_EVENTS));
    }
}
