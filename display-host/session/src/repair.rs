//! Closes a session that breaks off, and saves what is whole of a damaged one, so that other
//! programs open it: they need the index at its end.

use std::fs::File;
use std::path::Path;

use shared_mem::scene::SceneFile;

use crate::copy::{Copied, Copy};
use crate::error::ReadError;
use crate::index;
use crate::info::{Info, hex};
use crate::lost::Lost;
use crate::opened;
use crate::records::{self, End, Part, Records};

/// Result of a repair.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Repaired {
    /// The session is whole. Nothing was written.
    Whole,
    /// The session was written again without its damaged parts.
    Closed {
        /// Messages in the repaired session.
        messages: u64,
        /// Place where the session broke off or is first damaged.
        why: String,
        /// Bytes of the session that the repaired one lacks.
        left_out_bytes: u64,
        /// Parts that are lost before the session's last whole record.
        lost: Lost,
    },
}

/// Copies all whole records of the session at `from` to `to`, with an index. The session at `from`
/// stays as it is. If the session breaks off or is damaged, the copy says what it lacks, and every
/// reader of Calot repeats this. `scene` replaces the session's own if that is damaged.
///
/// # Errors
/// When the session cannot be read or is being recorded, when no message of it is left, when it ran
/// on another scene, or when the copy cannot be written.
pub fn repair(from: &Path, to: &Path, scene: Option<&SceneFile>) -> Result<Repaired, ReadError> {
    if crate::is_being_recorded(from) {
        let path = from.to_owned();
        return Err(ReadError::BeingRecorded { path });
    }
    let io = |source| ReadError::Io {
        path: from.to_owned(),
        source,
    };
    let (bytes, source) = opened::source(from)?;
    let file = File::open(from).map_err(io)?;
    let index = index::of(&file, bytes).map_err(io)?;
    let mut records = Records::new(source);
    // A first reading tells whether there is anything to repair.
    let (mut has_scene, mut wanted) = (false, None);
    while let Some(part) = records.next() {
        match part {
            Part::Scene(_) => has_scene = true,
            Part::Info(map) => wanted = Info::from_map(&map).ok().map(|it| it.scene_id),
            _ => {}
        }
    }
    let scene = scene.filter(|_| !has_scene);
    if let Some((wanted, scene)) = wanted.zip(scene) {
        let (path, found) = (from.to_owned(), hex(scene.short_id()));
        if found != wanted {
            return Err(ReadError::OtherScene {
                path,
                wanted,
                found,
            });
        }
    }
    let is_closed = match &records.end {
        Some(End::Whole | End::Lost(_)) | None => true,
        Some(End::BrokenOff(why)) => records::was_repaired(why),
        Some(End::Damaged(_)) => false,
    };
    if !is_closed && records.at <= mcap::MAGIC.len() as u64 {
        return Err(opened::not_a_session(from, "it holds no record"));
    }
    if is_closed && index.as_ref().is_some_and(|it| it.begins == records.at) {
        return Ok(Repaired::Whole);
    }
    let scene = scene.map(|it| it.bytes().to_vec());
    let copy = Copy::create((file, bytes), index, scene, to);
    let copied = copy
        .and_then(Copy::run)
        .map_err(|problem| ReadError::Write {
            path: to.to_owned(),
            problem,
        })?;
    let Copied {
        messages,
        why,
        left_out_bytes,
        lost,
    } = copied;
    if messages == 0 {
        let _ = std::fs::remove_file(to);
        let nothing = format!("no message of it can be read: {why}");
        return Err(opened::not_a_session(from, &nothing));
    }
    Ok(Repaired::Closed {
        messages,
        why,
        left_out_bytes,
        lost,
    })
}
