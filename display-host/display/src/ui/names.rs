//! Names of people, which may be in any script.

use egui::{FontId, Ui};

use super::widgets::{Mark, line};
use crate::words::Words;

/// A name as it is drawn. The text engine shapes each word in its own direction, and puts words
/// from left to right. So words of a script that runs to the left are put in reverse order.
pub(super) fn drawn(name: &str) -> String {
    let words: Vec<&str> = name.split(' ').collect();
    let mut drawn: Vec<&str> = Vec::with_capacity(words.len());
    let mut first = 0;
    for (number, word) in words.iter().enumerate() {
        if !runs_left(word) {
            first = number + 1;
        }
        drawn.insert(first.min(drawn.len()), word);
    }
    drawn.join(" ")
}

/// True for a word of a script that runs to the left: Hebrew, Arabic and their neighbours.
fn runs_left(word: &str) -> bool {
    let is_letter = |it: &char| it.is_alphabetic();
    let first = word.chars().find(is_letter).map(u32::from);
    first.is_some_and(|it| {
        matches!(it, 0x590..=0x8FF | 0xFB1D..=0xFDFF | 0xFE70..=0xFEFF | 0x10800..=0x10FFF | 0x1E800..=0x1EFFF)
    })
}

/// Shows a note if no font has the letters of a name. The name is used nevertheless.
pub(super) fn warn(ui: &mut Ui, words: &Words, name: &str) {
    let font = FontId::default();
    // Marks have no glyph of their own in some fonts, and are drawn with their letter.
    let letters: String = name.chars().filter(|it| it.is_alphanumeric()).collect();
    if !ui
        .ctx()
        .fonts_mut(|fonts| fonts.has_glyphs(&font, &letters))
    {
        line(ui, Mark::Care, &words.say("start-no-font"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_run_to_the_left_are_put_in_reverse_order() {
        for (name, shown) in [
            ("Ada Lovelace", "Ada Lovelace"),
            (
                "\u{5E2}\u{5D3}\u{5D4} \u{5DB}\u{5D4}\u{5DF}",
                "\u{5DB}\u{5D4}\u{5DF} \u{5E2}\u{5D3}\u{5D4}",
            ),
            (
                "Dr \u{645}\u{646}\u{649} \u{639}\u{644}\u{64A} III",
                "Dr \u{639}\u{644}\u{64A} \u{645}\u{646}\u{649} III",
            ),
            ("\u{5F20}\u{4F1F}", "\u{5F20}\u{4F1F}"),
            ("", ""),
        ] {
            assert_eq!(drawn(name), shown, "{name}");
        }
    }
}
