//! Comments fit 100 columns, documentation opens with its subject, and `rt-core` has no words that
//! its vocabulary replaced. The vocabulary is in `rt-core`'s crate documentation.

use tidy::{report, tracked};

const COLUMNS: usize = 100;

/// Openings of documentation that name no subject.
const OPENINGS: &[&str] = &[
    "What", "Where", "Whether", "How", "Which", "Who", "The same",
];

/// Places in which a replaced word may not stand.
#[derive(Clone, Copy, PartialEq)]
enum In {
    /// Comments, and parts of identifiers.
    All,
    /// Parts of identifiers only: the word is plain English in a comment.
    Identifiers,
}

/// Words that may not return in `rt-core`, and the word to use instead. They are in lower case and
/// found as whole words, also inside longer identifiers: `owed` in `OWED_M`, not in `allowed_m`.
const REPLACED: &[(&str, In, &str)] = &[
    ("lean", In::All, "warm_start"),
    ("leans", In::All, "warm_start"),
    ("leaning", In::All, "warm start"),
    ("owed", In::All, "separation offset"),
    ("forgiven", In::All, "separation offset"),
    ("presser", In::All, "contact, contact constraint"),
    ("pressers", In::All, "contacts, contact constraints"),
    ("beside", In::Identifiers, "influence, coupling"),
    ("beside it", In::All, "next to it, coupled"),
    ("gone", In::Identifiers, "damage"),
    ("told", In::Identifiers, "reported, announced, given"),
    ("way_m", In::Identifiers, "travel_m, displacement_m"),
];

#[test]
fn comment_lines_fit_a_hundred_columns() {
    let mut findings = Vec::new();
    for file in tracked(".rs") {
        for (row, line) in file.text.lines().enumerate() {
            let columns = line.chars().count();
            if line.trim_start().starts_with("//") && columns > COLUMNS {
                findings.push(format!(
                    "{}:{}: {columns} columns; wrap the comment at {COLUMNS}",
                    file.path,
                    row + 1
                ));
            }
        }
    }
    report(&findings);
}

#[test]
fn documentation_opens_with_its_subject() {
    let mut findings = Vec::new();
    for file in tracked(".rs") {
        for (row, text) in openings(&file.text) {
            if let Some(opening) = question(text) {
                findings.push(format!(
                    "{}:{row}: opens with '{opening}'; name the subject: \
                     \"Force on the tool\", not \"What the tool feels\"",
                    file.path
                ));
            }
        }
    }
    report(&findings);
}

#[test]
fn words_that_the_vocabulary_replaced_stay_away_from_the_core() {
    let mut findings = Vec::new();
    for file in tracked(".rs") {
        if !file.path.starts_with("rt-core/core/") {
            continue;
        }
        for (row, line) in file.text.lines().enumerate() {
            for (word, instead) in replaced(line) {
                findings.push(format!(
                    "{}:{}: '{word}' is replaced; write: {instead}",
                    file.path,
                    row + 1
                ));
            }
        }
    }
    report(&findings);
}

/// First line of every documentation comment, with its line number.
fn openings(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut was_doc = false;
    for (row, line) in text.lines().enumerate() {
        let line = line.trim_start();
        let doc = line
            .strip_prefix("//!")
            .or_else(|| line.strip_prefix("///"));
        if let Some(doc) = doc
            && !was_doc
        {
            found.push((row + 1, doc.trim_start()));
        }
        was_doc = doc.is_some();
    }
    found
}

/// Opening of a text, if it is one of [`OPENINGS`].
fn question(text: &str) -> Option<&'static str> {
    let is_opening = |it: &&&str| {
        let rest = text.strip_prefix(**it);
        rest.is_some_and(|it| !it.starts_with(|letter: char| letter.is_alphanumeric()))
    };
    OPENINGS.iter().find(is_opening).copied()
}

/// Replaced words of a line of code, with the word to use instead.
fn replaced(line: &str) -> Vec<(&'static str, &'static str)> {
    let (code, comment) = line.find("//").map_or((line, ""), |at| line.split_at(at));
    let (code, comment) = (spoken(code), spoken(comment));
    let mut found = Vec::new();
    for (word, place, instead) in REPLACED {
        let word_between_blanks = format!(" {} ", word.replace('_', " "));
        let is_in_comment = *place == In::All && comment.contains(&word_between_blanks);
        if code.contains(&word_between_blanks) || is_in_comment {
            found.push((*word, *instead));
        }
    }
    found
}

/// Text in lower case with one blank around every word; `GapRate` and `gap_rate` are two words.
fn spoken(text: &str) -> String {
    let mut out = String::from(" ");
    let mut was_lower = false;
    for letter in text.chars() {
        if letter.is_uppercase() && was_lower {
            out.push(' ');
        }
        was_lower = letter.is_lowercase() || letter.is_numeric();
        if letter.is_alphanumeric() {
            out.extend(letter.to_lowercase());
        } else if !out.ends_with(' ') {
            out.push(' ');
        }
    }
    if !out.ends_with(' ') {
        out.push(' ');
    }
    out
}

#[test]
fn an_opening_is_the_first_line_of_each_documentation_comment() {
    let text =
        "//! How it works.\n//! What else.\n\n/// Whatever.\nfn a() {}\n// Who.\n/// The same.\n";
    let found: Vec<Option<&str>> = openings(text)
        .into_iter()
        .map(|it| question(it.1))
        .collect();
    assert_eq!(found, [Some("How"), None, Some("The same")]);
}

#[test]
fn replaced_words_are_found_in_parts_of_identifiers_and_in_comments() {
    let found = |line| -> Vec<&str> { replaced(line).into_iter().map(|it| it.0).collect() };
    assert_eq!(
        found("struct PresserRow; // leans on it"),
        ["leans", "presser"]
    );
    assert_eq!(found("let away_m = way_m + a.way_m_s;"), ["way_m"]);
    assert_eq!(found("let OWED_M = 1.0; let allowed_m = 2.0;"), ["owed"]);
    assert!(found("/// The contact is gone; the host is told.").is_empty());
    assert_eq!(found("fn carry_gone() {}"), ["gone"]);
}
