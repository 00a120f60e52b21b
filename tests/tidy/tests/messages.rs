//! Every error message is triggered by a test, which names the message's variant or looks for words
//! of the message. A transparent variant shows the message of the error inside, so a test must name
//! it. `UNTRIGGERED` lists the messages that no test can trigger, each with the reason.

use std::collections::BTreeSet;

use tidy::{Tracked, report, tracked};

/// Messages that no test triggers, and the reason.
const UNTRIGGERED: &[(&str, &str)] = &[
    ("Error::Mcap", "a defect of this program, by definition"),
    ("Error::Thread", "needs a system without a free thread"),
    ("HardwareError::UsbPermission", "needs a tracker on USB"),
    (
        "RtError::Core",
        "needs a forged scene: `prepare` makes the same checks",
    ),
];

/// A text counts as words of a message only if it has at least this many bytes.
const WORDS: usize = 8;

/// A message with the variant that raises it.
struct Message {
    place: String,
    variant: String,
    /// Pieces of its text between the inserted values. Empty for a transparent variant.
    fragments: Vec<String>,
    /// True for a transparent variant, which shows the message of the error inside.
    hands_on: bool,
}

#[test]
fn every_message_is_triggered_by_a_test() {
    let files = tracked(".rs");
    let tests: Vec<&str> = files.iter().filter_map(test_code).collect();
    let texts: BTreeSet<String> = tests.iter().flat_map(|code| literals(code)).collect();
    let is_named = |variant: &str| tests.iter().any(|code| names(code, variant));
    let is_read = |message: &Message| {
        let words = texts.iter().filter(|text| text.len() >= WORDS);
        let mut words = words.filter(|text| !text.contains('\n'));
        words.any(|text| message.fragments.iter().any(|it| shares(it, text)))
    };
    let mut findings = Vec::new();
    let mut known = BTreeSet::new();
    // A message with little text of its own only joins other messages, and is not checked.
    let says =
        |it: &Message| it.hands_on || it.fragments.iter().any(|text| text.trim().len() >= WORDS);
    for message in files.iter().flat_map(messages).filter(says) {
        let Message { place, variant, .. } = &message;
        let is_listed = UNTRIGGERED.iter().any(|(listed, _)| listed == variant);
        known.insert(variant.clone());
        match (is_named(variant) || is_read(&message), is_listed) {
            (false, false) => findings.push(format!(
                "{place}: no test triggers {variant}; write one that {}",
                if message.hands_on {
                    "names it and reads its whole message"
                } else {
                    "looks for its words"
                }
            )),
            (true, true) => findings.push(format!(
                "{place}: a test triggers {variant}; remove it from UNTRIGGERED"
            )),
            _ => {}
        }
    }
    assert!(known.len() > 100, "{} messages found", known.len());
    for (listed, _) in UNTRIGGERED {
        if !known.contains(*listed) {
            findings.push(format!(
                "UNTRIGGERED lists {listed}, but there is no such message"
            ));
        }
    }
    report(&findings);
}

/// True if the code contains the variant. A longer name that ends with the variant's name does not
/// count.
fn names(code: &str, variant: &str) -> bool {
    let mut found = code.match_indices(variant);
    found.any(|(at, _)| {
        let before = code.get(..at).unwrap_or_default();
        !before.ends_with(|c: char| c.is_alphanumeric() || c == '_')
    })
}

/// True if the fragment contains the text, or the text contains the fragment. In the second case
/// the fragment must have at least ten bytes.
fn shares(fragment: &str, text: &str) -> bool {
    let fragment = fragment.trim_matches(|c: char| !c.is_alphanumeric());
    fragment.contains(text) || (fragment.len() > 9 && text.contains(fragment))
}

/// The part of a file that only tests run.
fn test_code(file: &Tracked) -> Option<&str> {
    let path = &file.path;
    if path.starts_with("tests/tidy") {
        return None;
    }
    // `evaluate` is a program and no test, so its texts do not count.
    let is_program = path.starts_with("tests/evaluate/src/");
    let is_in_tests = path.contains("/tests/") || path.starts_with("tests/");
    let is_test = (is_in_tests && !is_program) || path.ends_with("tests.rs");
    let from = match is_test {
        true => 0,
        false => file.text.find("#[cfg(test)]")?,
    };
    file.text.get(from..)
}

/// Messages that a file of the product declares.
fn messages(file: &Tracked) -> Vec<Message> {
    const OPENING: &str = "#[error(";
    const HANDED_ON: &str = "transparent";
    if file.path.starts_with("tests/") || file.path.contains("/tests/") {
        return Vec::new();
    }
    let text = &file.text;
    let mut found = Vec::new();
    for (at, _) in text.match_indices(OPENING) {
        let before = text.get(..at).unwrap_or_default();
        let after = text.get(at + OPENING.len()..).unwrap_or_default();
        let said = literal(after.trim_start()).map(|(message, rest)| (fragments(&message), rest));
        let handed_on = || Some((Vec::new(), after.strip_prefix(HANDED_ON)?));
        let hands_on = said.is_none();
        let Some((fragments, rest)) = said.or_else(handed_on) else {
            continue;
        };
        let row = 1 + before.matches('\n').count();
        found.push(Message {
            place: format!("{}:{row}", file.path),
            variant: variant(before, rest),
            fragments,
            hands_on,
        });
    }
    found
}

/// Name of the variant after the attribute, as `Type::Variant`. The type is the last enum that is
/// declared before it.
fn variant(before: &str, after: &str) -> String {
    let word = |text: &str| {
        let is_letter = |c: &char| c.is_alphanumeric() || *c == '_';
        text.chars().take_while(is_letter).collect::<String>()
    };
    let declared = |line: &str| {
        ["pub enum ", "pub(crate) enum ", "enum "]
            .iter()
            .find_map(|opening| line.strip_prefix(opening))
            .map(word)
    };
    let mut lines = after.lines().skip(1).map(str::trim_start);
    let next = lines.find(|it| it.starts_with(|c: char| c.is_ascii_alphabetic()));
    let next = next.unwrap_or_default();
    // An error that is a struct has no variants.
    match next.split_once("struct ") {
        Some((_, name)) => word(name),
        None => {
            let of = before.lines().rev().find_map(declared).unwrap_or_default();
            format!("{of}::{}", word(next))
        }
    }
}

/// Content of the string literal with which the code begins, and the code after it.
fn literal(text: &str) -> Option<(String, &str)> {
    let mut content = String::new();
    let mut chars = text.strip_prefix('"')?.char_indices();
    while let Some((at, c)) = chars.next() {
        match c {
            '"' => return Some((content, text.get(at + 2..)?)),
            '\\' => match chars.next()?.1 {
                // The text goes on in the next line.
                '\n' => {
                    let rest = chars.as_str().trim_start();
                    let from = text.len() - rest.len();
                    chars = text.get(from..)?.char_indices();
                    let (more, behind) = literal(&format!("\"{}", chars.as_str()))
                        .map(|(more, rest)| (more, rest.len()))?;
                    content.push_str(&more);
                    return Some((content, text.get(text.len() - behind..)?));
                }
                'n' => content.push('\n'),
                escaped => content.push(escaped),
            },
            c => content.push(c),
        }
    }
    None
}

/// The text of every string in a piece of code.
fn literals(code: &str) -> Vec<String> {
    // A quotation mark in a character literal opens no string.
    let code = code.replace("'\"'", "' '");
    let mut found = Vec::new();
    let mut rest = code.as_str();
    while let Some(at) = rest.find('"') {
        let from = rest.get(at..).unwrap_or_default();
        let Some((text, behind)) = literal(from) else {
            break;
        };
        found.push(text);
        rest = behind;
    }
    found
}

/// Pieces of a message between the values that are inserted into it.
fn fragments(message: &str) -> Vec<String> {
    let parts = message.split('{').enumerate();
    let text = parts.map(|(n, part)| match (n, part.split_once('}')) {
        (0, _) | (_, None) => part,
        (_, Some((_, text))) => text,
    });
    text.map(str::to_owned).collect()
}
