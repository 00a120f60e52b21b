//! Recorded operations in the folder of this file. Each has a run's setup and its packed ticks.

use std::io::{Error, Result};
use std::path::Path;

use session::pack::{pack, unpack};
use shared_mem::inputs::{InputRecord, RunSetup};

/// Bytes of the length that precedes each message.
const LENGTH: usize = size_of::<u32>();

/// Writes an operation.
pub(crate) fn write(path: &Path, setup: &RunSetup, mut records: &[InputRecord]) -> Result<()> {
    let mut bytes = bytemuck::bytes_of(setup).to_vec();
    while !records.is_empty() {
        let mut message = Vec::new();
        let packed = pack(records, &mut message);
        records = records.get(packed..).unwrap_or_default();
        bytes.extend((message.len() as u32).to_le_bytes());
        bytes.extend(message);
    }
    std::fs::write(path, bytes)
}

/// Reads an operation.
pub(crate) fn read(path: &Path) -> Result<(RunSetup, Vec<InputRecord>)> {
    let bytes = std::fs::read(path)?;
    let broken = || Error::other(format!("{} breaks off", path.display()));
    let (setup, mut rest) = bytes
        .split_at_checked(size_of::<RunSetup>())
        .ok_or_else(broken)?;
    let setup = bytemuck::pod_read_unaligned(setup);
    let mut records = Vec::new();
    while let Some((length, after)) = rest.split_first_chunk::<LENGTH>() {
        let length = u32::from_le_bytes(*length) as usize;
        let (message, after) = after.split_at_checked(length).ok_or_else(broken)?;
        unpack(message, &mut records).ok_or_else(broken)?;
        rest = after;
    }
    Ok((setup, records))
}
