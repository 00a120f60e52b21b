//! Reads the times of a session's ticks, apart from the ticks themselves.

use std::collections::VecDeque;
use std::path::Path;

use crate::error::ReadError;
use crate::opened;
use crate::records::Records;
use crate::times::TickTimes;

/// Iterator over the times of a session's ticks, in order. It ends where the file ends or is
/// damaged. A session of an older program has none.
pub struct Times {
    records: Records,
    next: VecDeque<TickTimes>,
}

impl core::fmt::Debug for Times {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Times").finish_non_exhaustive()
    }
}

impl Times {
    /// Opens a session.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let (_, source) = opened::source(path)?;
        Ok(Self {
            records: Records::new(source),
            next: VecDeque::new(),
        })
    }

    /// Times of this tick. Skips the times of earlier ticks. `None` if the session lacks them.
    pub fn of(&mut self, tick: u64) -> Option<TickTimes> {
        loop {
            let first = match self.next.front() {
                Some(first) => *first,
                None => {
                    let part = self.records.next()?;
                    self.next.extend(part.times().into_iter().flatten());
                    continue;
                }
            };
            if first.tick > tick {
                return None;
            }
            self.next.pop_front();
            if first.tick == tick {
                return Some(first);
            }
        }
    }
}
