//! The index at the end of a session, which other programs need to open it.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use mcap::records::op;

/// Size of the opcode and the length before each record, bytes.
const HEAD_BYTES: usize = 9;
/// Length of the last record, bytes: two places and a checksum.
const FOOTER_BYTES: usize = 20;
/// Longest index that is read, bytes. The index of an hour has about 0.5 MB.
const INDEX_MAX_BYTES: u64 = 64 << 20;

/// True if the file has a whole index from byte `from` on, where its data end.
pub(crate) fn is_sound(path: &Path, from: u64) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(from))?;
    let mut index = Vec::new();
    file.take(INDEX_MAX_BYTES).read_to_end(&mut index)?;
    Ok(is_whole(&index, from))
}

fn is_whole(index: &[u8], from: u64) -> bool {
    let Some(records) = index.strip_suffix(mcap::MAGIC) else {
        return false;
    };
    let Some((records, footer)) = records.split_last_chunk::<{ HEAD_BYTES + FOOTER_BYTES }>()
    else {
        return false;
    };
    let u64_at = |at: usize| {
        let bytes = footer.get(at..).and_then(|it| it.first_chunk());
        bytes.copied().map(u64::from_le_bytes)
    };
    let is_footer = footer.first() == Some(&op::FOOTER) && u64_at(1) == Some(FOOTER_BYTES as u64);
    let begins = u64_at(HEAD_BYTES) == Some(from);
    let checked = footer.split_last_chunk::<4>().is_some_and(|(before, crc)| {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(records);
        hasher.update(before);
        hasher.finalize() == u32::from_le_bytes(*crc)
    });
    is_footer && begins && checked
}
