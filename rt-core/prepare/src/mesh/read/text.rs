//! Lines, words and numbers of text formats. Text is bytes, because names may be in any encoding.

use super::malformed;
use crate::error::MeshProblem;

/// Content without a byte order mark.
///
/// # Errors
/// When the text is UTF-16.
pub(super) fn without_mark<'a>(
    format: &'static str,
    content: &'a [u8],
) -> Result<&'a [u8], MeshProblem> {
    if content.starts_with(b"\xff\xfe") || content.starts_with(b"\xfe\xff") {
        return Err(malformed(format, "UTF-16 text; save it as UTF-8 or ASCII"));
    }
    Ok(content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content))
}

/// Lines with their numbers, from 1. Lines end with LF or CR LF, or, in a file without LF, with CR.
pub(super) fn lines(content: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let end = if content.contains(&b'\n') {
        b'\n'
    } else {
        b'\r'
    };
    (1..).zip(content.split(move |&b| b == end))
}

/// Words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// The name that follows a line's first word.
pub(super) fn name(line: &[u8]) -> String {
    let line = line.trim_ascii();
    let end = line.iter().position(u8::is_ascii_whitespace);
    String::from_utf8_lossy(&line[end.unwrap_or(line.len())..])
        .trim()
        .into()
}

/// The finite number that a word states, or a description of the word's fault.
pub(super) fn number(word: &[u8]) -> Result<f64, String> {
    let text = std::str::from_utf8(word).ok();
    let value = text.and_then(|text| text.parse::<f64>().ok());
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("'{}' is not finite", shown(word))),
        None if word.contains(&b',') => Err(format!(
            "'{}' is not a number: it has a comma; set the exporter to decimal points",
            shown(word)
        )),
        None => Err(format!("'{}' is not a number", shown(word))),
    }
}

/// Three numbers from the words of a line.
pub(super) fn point<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], String> {
    let mut point = [0.0; 3];
    for value in &mut point {
        let word = words.next().ok_or("it needs three numbers")?;
        *value = number(word)?;
    }
    Ok(point)
}

/// Beginning of a text, for a message.
pub(super) fn shown(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(&text[..text.len().min(200)]).into_owned();
    let text = text.trim().chars().filter(|c| !c.is_control());
    text.take(40).collect()
}

/// The error of a line.
pub(super) fn at_line(
    format: &'static str,
    (number, line): (usize, &[u8]),
    problem: &str,
) -> MeshProblem {
    malformed(
        format,
        &format!("line {number}, '{}': {problem}", shown(line)),
    )
}
