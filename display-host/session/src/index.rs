//! The index at the end of a session, which other programs need to open it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;

use mcap::records::{Channel, Record, SchemaHeader, op};

use crate::records::{self, HEAD_BYTES};

/// Length of the last record, bytes: two places and a checksum.
const FOOTER_BYTES: usize = 20;
/// Bytes at the end of a file: the last record, and the format's mark.
const END_BYTES: usize = HEAD_BYTES + FOOTER_BYTES + mcap::MAGIC.len();
/// Longest index that is read, bytes. The index of an hour has about 0.5 MB.
const INDEX_MAX_BYTES: u64 = 64 << 20;
/// Places in the statistics: time of the first message, time of the last one, and the counts.
const FIRST_AT: usize = 26;
const LAST_AT: usize = 34;
const COUNTS_AT: usize = 42;

/// Parts of an index that tell what a damaged session had.
#[derive(Debug, Default)]
pub(crate) struct Index {
    /// Byte at which the index begins, and the data end.
    pub(crate) begins: u64,
    pub(crate) schemas: BTreeMap<u16, (SchemaHeader, Vec<u8>)>,
    pub(crate) channels: BTreeMap<u16, Channel>,
    /// Messages of each channel. Empty: the index has no statistics.
    pub(crate) counts: BTreeMap<u16, u64>,
    /// Stamps of the first and the last message, ns since 1970.
    pub(crate) first_ns: u64,
    pub(crate) last_ns: u64,
}

/// The index of a file of `length` bytes. `None` if it is missing or damaged.
pub(crate) fn of(file: &File, length: u64) -> io::Result<Option<Index>> {
    let mut end = [0; END_BYTES];
    let Some(end_at) = length.checked_sub(END_BYTES as u64) else {
        return Ok(None);
    };
    file.read_exact_at(&mut end, end_at)?;
    let begins = records::u64_at(&end, HEAD_BYTES).unwrap_or(0);
    let is_there = end.first() == Some(&op::FOOTER)
        && records::u64_at(&end, 1) == Some(FOOTER_BYTES as u64)
        && end.ends_with(mcap::MAGIC)
        && (1..=end_at).contains(&begins)
        && end_at - begins <= INDEX_MAX_BYTES;
    if !is_there {
        return Ok(None);
    }
    let mut summary = vec![0; usize::try_from(end_at - begins).unwrap_or_default()];
    file.read_exact_at(&mut summary, begins)?;
    Ok(is_checked(&summary, &end).then(|| read(begins, &summary)))
}

/// True if the checksum is right. It covers the index and the last record up to the checksum.
fn is_checked(summary: &[u8], end: &[u8; END_BYTES]) -> bool {
    let crc_at = HEAD_BYTES + FOOTER_BYTES - 4;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(summary);
    hasher.update(end.get(..crc_at).unwrap_or_default());
    records::u32_at(end, crc_at) == Some(hasher.finalize())
}

fn read(begins: u64, summary: &[u8]) -> Index {
    let mut index = Index {
        begins,
        ..Index::default()
    };
    let mut rest = summary;
    while let Some((head, after)) = rest.split_first_chunk::<HEAD_BYTES>() {
        let length = records::u64_at(head, 1).and_then(|it| usize::try_from(it).ok());
        let Some((body, after)) = length.and_then(|it| after.split_at_checked(it)) else {
            break;
        };
        rest = after;
        let [opcode, ..] = *head;
        match opcode {
            op::STATISTICS => {
                index.counts = counts(body);
                index.first_ns = records::u64_at(body, FIRST_AT).unwrap_or(0);
                index.last_ns = records::u64_at(body, LAST_AT).unwrap_or(0);
            }
            op::SCHEMA | op::CHANNEL if records::is_sound(opcode, body) => index.name(opcode, body),
            _ => {}
        }
    }
    index
}

impl Index {
    /// Takes a description of a channel or of its messages.
    fn name(&mut self, opcode: u8, body: &[u8]) {
        match records::parsed(opcode, body) {
            Ok(Record::Schema { header, data }) => {
                self.schemas.insert(header.id, (header, data.into_owned()));
            }
            Ok(Record::Channel(channel)) => {
                self.channels.insert(channel.id, channel);
            }
            _ => {}
        }
    }
}

/// Messages of each channel, from the statistics.
fn counts(body: &[u8]) -> BTreeMap<u16, u64> {
    let pairs = body.get(COUNTS_AT + 4..).unwrap_or_default();
    let pair = |it: &[u8; 10]| {
        let [low, high, ..] = *it;
        Some((u16::from_le_bytes([low, high]), records::u64_at(it, 2)?))
    };
    pairs.as_chunks::<10>().0.iter().filter_map(pair).collect()
}
