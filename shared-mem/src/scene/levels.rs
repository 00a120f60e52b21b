//! Levels of detail in one file. Each level is a complete scene; the finest comes first.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::MAGIC;
use super::header::{ALIGN, HEADER_BYTES, Header};

/// Largest number of levels in a file.
pub const LEVELS_MAX: usize = 8;

/// Offset and length of each level, bytes. A file that does not consist of whole levels counts as
/// one level, so that opening it reports the error. An empty file has no level.
pub(super) fn find(file: &mut File) -> std::io::Result<Vec<(u64, usize)>> {
    let total = file.metadata()?.len();
    let size = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
    let mut found = Vec::new();
    let mut offset = 0;
    while found.len() < LEVELS_MAX && total - offset >= HEADER_BYTES as u64 {
        let mut head = [0; HEADER_BYTES];
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(&mut head)?;
        let header: Header = bytemuck::pod_read_unaligned(&head);
        let rest = total - offset;
        if header.magic != MAGIC || !(HEADER_BYTES as u64..=rest).contains(&header.bytes) {
            break;
        }
        found.push((offset, size(header.bytes)));
        if header.bytes == rest {
            return Ok(found);
        }
        offset = (offset + header.bytes.next_multiple_of(ALIGN as u64)).min(total);
    }
    Ok(if total > 0 {
        vec![(0, size(total))]
    } else {
        Vec::new()
    })
}

/// Splits `scene.calot#2` into the path of the file and the number of the level. If a file with the
/// whole name exists, the name is not split, and the level is 0.
pub(super) fn split(path: &Path) -> (PathBuf, usize) {
    let named = path.to_str().and_then(|text| text.rsplit_once('#'));
    let level = named.and_then(|(file, level)| Some((file, level.parse().ok()?)));
    match level {
        Some((file, level)) if !path.exists() => (file.into(), level),
        _ => (path.to_owned(), 0),
    }
}

/// The path that names a level of `file`, as [`split`] reads it.
pub(super) fn join(file: &Path, level: usize) -> PathBuf {
    let mut path = file.as_os_str().to_owned();
    path.push(format!("#{level}"));
    path.into()
}
