//! Closes a session that breaks off, so that other programs open it: they need the index at its
//! end.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;

use mcap::records::{Metadata, Record, op};
use mcap::write::{NoSeek, Writer};

use crate::error::ReadError;
use crate::index;
use crate::info;
use crate::opened;
use crate::records::{self, End, Records};
use crate::storage::create_private;

/// Reason for a repair of a session whose data are whole.
const NO_INDEX: &str = "its index is missing or damaged; its data are whole";

/// Result of a repair.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Repaired {
    /// The session is whole. Nothing was written.
    Whole,
    /// The session was written again up to the place where it breaks off.
    Closed {
        /// Messages in the repaired session.
        messages: u64,
        /// Place where the session broke off or is damaged.
        why: String,
        /// Bytes after that place, which the repaired session lacks.
        left_out_bytes: u64,
    },
}

/// Copies all complete records of the session at `from` to `to`, with an index. The session at
/// `from` stays as it is. If the session breaks off or is damaged, the copy says where, and every
/// reader of Calot repeats this.
///
/// # Errors
/// When the session cannot be read or is being recorded, when no message of it is left, or when the
/// copy cannot be written.
pub fn repair(from: &Path, to: &Path) -> Result<Repaired, ReadError> {
    if crate::is_being_recorded(from) {
        let path = from.to_owned();
        return Err(ReadError::BeingRecorded { path });
    }
    let (bytes, source) = opened::source(from)?;
    let mut records = Records::new(source);
    // A first reading tells whether there is anything to repair.
    while records.next().is_some() {}
    let is_closed = match &records.end {
        Some(End::Whole) | None => true,
        Some(End::BrokenOff(why)) => records::was_repaired(why),
        Some(End::Damaged(_)) => false,
    };
    if !is_closed && records.at <= mcap::MAGIC.len() as u64 {
        return Err(opened::not_a_session(from, "it holds no record"));
    }
    let has_index = || {
        index::is_sound(from, records.at).map_err(|source| ReadError::Io {
            path: from.to_owned(),
            source,
        })
    };
    if is_closed && has_index()? {
        return Ok(Repaired::Whole);
    }
    let (_, source) = opened::source(from)?;
    let written = copy(Records::new(source), to, bytes);
    let repaired = written.map_err(|problem| ReadError::Write {
        path: to.to_owned(),
        problem,
    })?;
    if let Repaired::Closed {
        messages: 0, why, ..
    } = &repaired
    {
        let _ = std::fs::remove_file(to);
        let nothing = format!("no message of it can be read: {why}");
        return Err(opened::not_a_session(from, &nothing));
    }
    Ok(repaired)
}

fn copy(mut records: Records, to: &Path, bytes: u64) -> Result<Repaired, String> {
    let words = |error: mcap::McapError| error.to_string();
    let file = create_private(to).map_err(|error| error.to_string())?;
    let options = mcap::WriteOptions::new()
        .profile("")
        .library("calot replay --repair")
        .chunk_size(None)
        .disable_seeking(true)
        .compression(None);
    let mut writer = Writer::with_options(NoSeek::new(file), options).map_err(words)?;
    let mut messages = 0;
    let (at, end) = loop {
        let at = records.at;
        match next(&mut records) {
            Ok(found) => {
                for record in found {
                    messages += u64::from(matches!(record, Record::Message { .. }));
                    take(&mut writer, record).map_err(words)?;
                }
                writer.flush().map_err(words)?;
            }
            Err(end) => break (at, records.placed(end, at)),
        }
    };
    let (End::BrokenOff(why) | End::Damaged(why)) = end else {
        writer.finish().map_err(words)?;
        return Ok(Repaired::Closed {
            messages,
            why: NO_INDEX.to_owned(),
            left_out_bytes: 0,
        });
    };
    writer
        .write_metadata(&Metadata {
            name: info::REPAIRED.to_owned(),
            metadata: BTreeMap::from([(info::WHY.to_owned(), why.clone())]),
        })
        .map_err(words)?;
    writer.finish().map_err(words)?;
    Ok(Repaired::Closed {
        messages,
        why,
        left_out_bytes: bytes.saturating_sub(at),
    })
}

/// The next records of the file to copy: a whole chunk of them, or a single one.
fn next(records: &mut Records) -> Result<Vec<Record<'static>>, End> {
    let (opcode, body) = records.raw()?;
    match opcode {
        op::CHUNK => records::chunk(&body),
        op::ATTACHMENT | op::METADATA => Ok(vec![records::parsed(opcode, &body)?.into_owned()]),
        op::DATA_END => Err(End::Whole),
        _ => Ok(Vec::new()),
    }
}

/// Writes a record with its own numbers of schema and channel.
fn take(writer: &mut Writer<NoSeek<File>>, record: Record<'_>) -> mcap::McapResult<()> {
    match record {
        Record::Schema { header, data } => writer
            .add_schema_with_id(header.id, &header.name, &header.encoding, &data)
            .map(|_| ()),
        Record::Channel(it) => {
            let (topic, encoding) = (&it.topic, &it.message_encoding);
            writer
                .add_channel_with_id(it.id, it.schema_id, topic, encoding, &it.metadata)
                .map(|_| ())
        }
        Record::Message { header, data } => writer.write_to_known_channel(&header, &data),
        Record::Metadata(metadata) => writer.write_metadata(&metadata),
        Record::Attachment { header, data, .. } => writer.attach(&mcap::Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name,
            media_type: header.media_type,
            data,
        }),
        _ => Ok(()),
    }
}
