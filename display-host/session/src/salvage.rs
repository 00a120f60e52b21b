//! Finds the next whole record of a session behind a damaged one.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;

use mcap::records::{Record, op};

use crate::file::SCENE;
use crate::info;
use crate::records::{self, CHUNK_HEAD_BYTES, HEAD_BYTES, RECORD_MAX_BYTES};

/// Bytes that are searched at once.
const WINDOW_BYTES: usize = 1 << 20;
/// Bytes that tell a record's beginning from other bytes: the heads of a record and of a chunk.
const BEGINNING_BYTES: usize = HEAD_BYTES + CHUNK_HEAD_BYTES as usize;
/// Step over a part of the disk that cannot be read, bytes.
const SECTOR_BYTES: u64 = 4096;
/// Largest number of bytes that are read without finding a whole record. A hostile file may hold a
/// beginning in every byte.
const VAIN_MAX_BYTES: u64 = 1 << 30;

/// Place of the next whole chunk, metadata record or scene in the first `length` bytes of a file,
/// from byte `from` on. `None` if none follows.
pub(crate) fn next_record(file: &File, from: u64, length: u64) -> Option<u64> {
    let (mut at, mut vain_bytes) = (from, 0);
    let mut window = vec![0; WINDOW_BYTES];
    while at < length && vain_bytes < VAIN_MAX_BYTES {
        let Ok(read) = read_up_to(file, at, &mut window) else {
            at = (at / SECTOR_BYTES + 1) * SECTOR_BYTES;
            continue;
        };
        let searched = window.get(..read).unwrap_or_default();
        for (offset, beginning) in searched.windows(BEGINNING_BYTES).enumerate() {
            let Some(bytes) = plausible(beginning) else {
                continue;
            };
            let place = at + offset as u64;
            if place + bytes <= length && is_whole(file, place, bytes) {
                return Some(place);
            }
            vain_bytes += bytes.min(length);
        }
        // The last bytes are searched again, together with what follows them.
        at += match read {
            WINDOW_BYTES => (WINDOW_BYTES - BEGINNING_BYTES + 1) as u64,
            _ => return None,
        };
    }
    None
}

/// Length of the record that may begin with these bytes, with its head.
fn plausible(beginning: &[u8]) -> Option<u64> {
    let (head, body) = beginning.split_at_checked(HEAD_BYTES)?;
    let length = records::u64_at(head, 1).filter(|it| *it <= RECORD_MAX_BYTES)?;
    let text_is = |text: &str, at: usize| {
        records::u32_at(body, at) == Some(text.len() as u32)
            && body
                .get(at + 4..)
                .is_some_and(|it| it.starts_with(text.as_bytes()))
    };
    let is_plausible = match *head.first()? {
        op::CHUNK => {
            let agrees = records::u64_at(body, 32)?.checked_add(CHUNK_HEAD_BYTES) == Some(length);
            agrees && records::u32_at(body, 28) == Some(0)
        }
        op::METADATA => [info::NAME, info::ASSIGNMENT, info::FINISH, info::REPAIRED]
            .iter()
            .any(|name| text_is(name, 0)),
        op::ATTACHMENT => text_is(SCENE, 16),
        _ => false,
    };
    is_plausible.then_some(length + HEAD_BYTES as u64)
}

/// True if the record of this length, with its head, is as it was written.
fn is_whole(file: &File, at: u64, bytes: u64) -> bool {
    let mut record = vec![0; usize::try_from(bytes).unwrap_or_default()];
    if file.read_exact_at(&mut record, at).is_err() {
        return false;
    }
    let Some((&[opcode, ..], body)) = record.split_first_chunk::<HEAD_BYTES>() else {
        return false;
    };
    match opcode {
        op::CHUNK => records::chunk(body).is_ok(),
        _ => {
            let parsed = || records::parsed(opcode, body);
            records::is_sound(opcode, body)
                && matches!(
                    parsed(),
                    Ok(Record::Metadata(_) | Record::Attachment { .. })
                )
        }
    }
}

/// Fills `buffer` from byte `at` on, as far as the file goes. Returns the number of bytes.
fn read_up_to(file: &File, at: u64, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while let Some(rest) = buffer.get_mut(filled..).filter(|it| !it.is_empty()) {
        match file.read_at(rest, at + filled as u64)? {
            0 => break,
            read => filled += read,
        }
    }
    Ok(filled)
}
