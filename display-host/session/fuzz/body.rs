//! Body of the fuzz target for sessions: no bytes may make a reader panic, hang or take memory out
//! of proportion.

use std::path::Path;

use session::{Operation, Session};

/// Reads the bytes as a replay and as a report would. Reads them also as one message of packed
/// ticks, because the file's checksums keep most damaged messages from the two other readers.
pub(crate) fn read(bytes: &[u8]) {
    let mut ticks = Vec::new();
    let _ = session::pack::unpack(bytes, &mut ticks);
    let path = Path::new("fuzz.mcap");
    let length = bytes.len() as u64;
    let source = || Box::new(std::io::Cursor::new(bytes.to_vec()));
    let ticks = Session::read(path, length, source()).map_or(0, Iterator::count);
    let entries = Operation::read(path, length, source()).map_or(0, Iterator::count);
    assert!(
        ticks.max(entries) as u64 <= length,
        "each takes a byte and more"
    );
}
