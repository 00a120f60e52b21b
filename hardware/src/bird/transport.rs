//! Transports of commands and records.

use core::fmt;
use std::path::Path;

use super::wire::command;
use crate::line::{Line, Read, Written};

/// Carries commands and records over a serial line or in USB packets. No method waits. Once records
/// flow, no method allocates.
pub(super) trait Transport: fmt::Debug + Send {
    /// Path that was opened.
    fn path(&self) -> &Path;
    /// True if the transport is lost.
    fn is_lost(&self) -> bool;
    /// Reads the bytes that have arrived.
    fn read(&mut self, buffer: &mut [u8]) -> Read;
    /// Sends one command.
    fn write(&mut self, bytes: &[u8]) -> Written;
    /// Starts the flow of records; `point` is the command for one record.
    fn begin(&mut self, point: &[u8]) -> Written;
    /// True if even a single bird must be configured as a group and needs its address before each
    /// command.
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
