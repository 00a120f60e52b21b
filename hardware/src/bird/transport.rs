//! What carries the commands and the records.

use core::fmt;
use std::path::Path;

use super::wire::command;
use crate::line::{Line, Read, Written};

/// A serial line, or packets. Nothing here waits or, once records flow, allocates.
pub(super) trait Transport: fmt::Debug + Send {
    /// What was opened.
    fn path(&self) -> &Path;
    /// Whether it is gone.
    fn is_lost(&self) -> bool;
    /// What has come.
    fn read(&mut self, buffer: &mut [u8]) -> Read;
    /// Sends one command.
    fn write(&mut self, bytes: &[u8]) -> Written;
    /// Makes records flow; `point` asks for one.
    fn begin(&mut self, point: &[u8]) -> Written;
    /// Whether a lone bird wants its address, and its units counted, too.
    fn is_addressed(&self) -> bool;
}

impl Transport for Line {
    fn path(&self) -> &Path {
        Self::path(self)
    }

    fn is_lost(&self) -> bool {
        Self::is_lost(self)
    }

    fn read(&mut self, buffer: &mut [u8]) -> Read {
        Self::read(self, buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> Written {
        Self::write(self, bytes)
    }

    fn begin(&mut self, _point: &[u8]) -> Written {
        Self::write(self, &[command::STREAM])
    }

    fn is_addressed(&self) -> bool {
        false
    }
}
