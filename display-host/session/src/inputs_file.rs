//! Recorded operations without a session around them: a run's setup and its packed ticks, in a file
//! of their own. Tests and measurements repeat them.

use std::io::{Error, Result};
use std::path::Path;

use shared_mem::inputs::{InputRecord, RunSetup};

use crate::pack::{pack, unpack};

/// Bytes of the length that precedes each message.
const LENGTH: usize = size_of::<u32>();

/// Writes an operation.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, setup: &RunSetup, mut records: &[InputRecord]) -> Result<()> {
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
///
/// # Errors
/// When the file cannot be read, or breaks off.
pub fn read(path: &Path) -> Result<(RunSetup, Vec<InputRecord>)> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_operation_is_read_as_it_was_written_and_not_if_it_breaks_off() {
        let folder = std::env::temp_dir().join(format!("calot-operation-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("an.inputs");
        let setup: RunSetup = bytemuck::Zeroable::zeroed();
        let record = |tick| InputRecord {
            tick,
            ..bytemuck::Zeroable::zeroed()
        };
        let records: Vec<InputRecord> = (0..50).map(record).collect();
        write(&path, &setup, &records).expect("it can be written");
        let (setup_again, again) = read(&path).expect("it can be read");
        assert_eq!(bytemuck::bytes_of(&setup_again), bytemuck::bytes_of(&setup));
        let ticks = |records: &[InputRecord]| records.iter().map(|it| it.tick).collect::<Vec<_>>();
        assert_eq!(ticks(&again), ticks(&records));
        let bytes = std::fs::read(&path).expect("bytes");
        std::fs::write(&path, &bytes[..bytes.len() - 1]).expect("written");
        let said = read(&path).expect_err("a byte is missing").to_string();
        assert!(said.contains("breaks off"), "{said}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
