//! Names that people choose: which are allowed, and which look alike.

use unicode_normalization::UnicodeNormalization as _;

use crate::error::StoreError;

/// Longest name, characters.
const NAME_MAX: usize = 64;

/// Trims a name, brings it to Unicode's form NFC, and checks that it has 1 to 64 characters, all of
/// them visible.
///
/// # Errors
/// [`StoreError::Value`] names the forbidden character.
pub fn check_name(name: &str) -> Result<String, StoreError> {
    checked(name, "a trainee's name")
}

/// Checks the name of a rater, a site or a cohort as [`check_name`] checks that of a trainee.
/// `what` names it in the error.
pub(crate) fn checked(name: &str, what: &str) -> Result<String, StoreError> {
    let name: String = name.trim().nfc().collect();
    let unseen = name.chars().find(|it| is_unseen(*it));
    if unseen.is_none() && (1..=NAME_MAX).contains(&name.chars().count()) {
        return Ok(name);
    }
    let shown = shown(&name);
    Err(StoreError::Value {
        what: what.to_owned(),
        value: match unseen {
            Some(it) => format!(
                "'{shown}', with the invisible character U+{:04X}",
                u32::from(it)
            ),
            None => format!("'{shown}'"),
        },
        allowed: "1 to 64 characters without control characters, characters of no width, and characters that \
                  reverse the text: two names that look alike would be two people".to_owned(),
    })
}

/// Start of a refused text, escaped for a terminal.
pub(crate) fn shown(text: &str) -> String {
    text.escape_debug().take(80).collect()
}

/// True for control characters and for Unicode's format characters, line separators and fillers.
/// They are invisible or change how the following text looks.
fn is_unseen(it: char) -> bool {
    it.is_control()
        || matches!(
            u32::from(it),
            0xad | 0x34f | 0x600..=0x605 | 0x61c | 0x6dd | 0x70f | 0x890..=0x891 | 0x8e2
                | 0x115f..=0x1160 | 0x17b4..=0x17b5 | 0x180b..=0x180f | 0x200b..=0x200f
                | 0x2028..=0x202e | 0x2060..=0x206f | 0x2800 | 0x3164 | 0xfe00..=0xfe0f | 0xfeff
                | 0xffa0 | 0xfff0..=0xfffb | 0x110bd | 0x110cd | 0x13430..=0x1343f
                | 0x1bca0..=0x1bca3 | 0x1d173..=0x1d17a | 0xe0000..=0xe0fff
        )
}

/// Two forms of a name. Two names with a form in common are easily confused: their letters are the
/// same in another case or width, or look the same (the skeleton of Unicode Technical Standard 39).
/// The first form keeps the case, because a large I looks like a small L.
fn looks(name: &str) -> [String; 2] {
    let wide: String = name.nfkc().collect();
    let wide = wide.split_whitespace().collect::<Vec<_>>().join(" ");
    // Upper case first, because it joins letters that have one large form, such as ß and ss.
    let folded: String = wide
        .to_uppercase()
        .chars()
        .flat_map(char::to_lowercase)
        .collect();
    let skeleton = |text: &str| unicode_security::skeleton(text).collect::<String>();
    [skeleton(&wide), skeleton(&folded)]
}

/// True if two names that differ are easily confused.
pub(crate) fn are_alike(one: &str, other: &str) -> bool {
    let pairs = looks(one).into_iter().zip(looks(other));
    one != other && { pairs }.any(|(one, other)| one == other)
}
