//! Small text files of other people: questionnaires and scoring sheets.

use std::io::Read as _;
use std::path::Path;

/// Longest file, bytes.
const MAX_BYTES: u64 = 64 << 10;
/// Longest text of an item or title, characters.
const TEXT_MAX: usize = 300;

/// Reads a file, which may have no end. The error is a message without the path.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(|error| error.to_string())?;
    let read = file.take(MAX_BYTES + 1).read_to_string(&mut text);
    match read.map_err(|error| error.to_string())? as u64 > MAX_BYTES {
        true => Err(format!("the file is longer than {MAX_BYTES} bytes")),
        false => Ok(text),
    }
}

/// Checks a text that will be shown. The error is a message.
pub(crate) fn check(text: &str) -> Result<(), String> {
    let length = text.chars().count();
    if (1..=TEXT_MAX).contains(&length) && !text.chars().any(char::is_control) {
        return Ok(());
    }
    let shown: String = text.escape_debug().take(60).collect();
    Err(format!(
        "the text '{shown}' has {length} characters; allowed are 1 to {TEXT_MAX} without control \
         characters"
    ))
}
