//! The time that the debrief counts, at each tick and event of a session.

use std::path::Path;

use assess::Assessment;
use session::{Entry, Operation};

use super::table::Cell;
use crate::problem::Problem;
use crate::report;

/// Meaning of the column, in both tables.
pub(super) const MEANING: &str = "time that debrief and metrics count, s: from the first movement, without pauses, \
     gaps and lost devices; begins again with each attempt; stands still after the task; to 0.01 s";

/// Follows a session's course and its debrief's clock.
pub(super) struct Counted {
    operation: Operation,
    assessment: Assessment,
    next: Option<Entry>,
}

impl Counted {
    /// Opens the session at its beginning.
    pub(super) fn open(file: &Path) -> Result<Self, Problem> {
        let mut operation = Operation::open(file)?;
        let (assessment, _) = report::assessment(&operation, file, None, None)?;
        Ok(Self {
            next: operation.next(),
            operation,
            assessment,
        })
    }

    /// Time at this tick. Ticks come in order.
    pub(super) fn at_tick(&mut self, tick: u64) -> Cell {
        while self.next.as_ref().is_some_and(|it| it.tick <= tick) {
            self.step();
        }
        self.cell()
    }

    /// Next entry of the course, with its time.
    pub(super) fn entry(&mut self) -> Option<(Entry, Cell)> {
        let entry = self.step()?;
        Some((entry, self.cell()))
    }

    fn step(&mut self) -> Option<Entry> {
        let entry = self.next.take()?;
        self.assessment.take(&entry);
        self.next = self.operation.next();
        Some(entry)
    }

    fn cell(&self) -> Cell {
        match self.assessment.has_begun() {
            true => Cell::Double(self.assessment.time_s()),
            false => Cell::Absent,
        }
    }
}
