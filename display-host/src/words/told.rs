//! What the assessment says, in the user's language. It writes plain English into sessions and reports, which
//! are read with other programs too; here that English is found among the messages `told-…` and said anew.

use std::sync::LazyLock;

use super::{FluentValue, Language, Words};

/// A message in pieces: what stands there, or a variable's name.
#[derive(Debug, PartialEq)]
enum Piece {
    Text(&'static str),
    Variable(&'static str),
}

/// Messages `told-…` of the English file, in its order.
static ENGLISH: LazyLock<Vec<(&'static str, Vec<Piece>)>> = LazyLock::new(|| {
    let lines = Language::English.source().lines();
    let messages = lines.filter_map(|line| line.split_once(" = "));
    let told = messages.filter(|(id, _)| id.starts_with("told-"));
    told.map(|(id, text)| (id, pieces(text))).collect()
});

fn pieces(mut text: &'static str) -> Vec<Piece> {
    let mut found = Vec::new();
    while let Some((before, rest)) = text.split_once("{ $")
        && let Some((name, after)) = rest.split_once(" }")
    {
        if !before.is_empty() {
            found.push(Piece::Text(before));
        }
        found.push(Piece::Variable(name));
        text = after;
    }
    if !text.is_empty() {
        found.push(Piece::Text(text));
    }
    found
}

/// The variables' values, if the whole text is so made.
fn fit<'a>(pieces: &[Piece], text: &'a str) -> Option<Vec<(&'static str, &'a str)>> {
    match pieces {
        [] => text.is_empty().then(Vec::new),
        [Piece::Text(own), rest @ ..] => fit(rest, text.strip_prefix(own)?),
        [Piece::Variable(name)] => (!text.is_empty()).then(|| vec![(*name, text)]),
        [Piece::Variable(name), rest @ ..] => {
            let Some(Piece::Text(next)) = rest.first() else {
                return None;
            };
            text.match_indices(next).find_map(|(at, _)| {
                let mut values = fit(rest, &text[at..])?;
                values.insert(0, (*name, &text[..at]));
                Some(values)
            })
        }
    }
}

impl Words {
    /// A sentence of the assessment (a step, a hint, a reason); as it is where it is none of those known.
    #[must_use]
    pub fn tell(&self, english: &str) -> String {
        let known = ENGLISH.iter();
        let found = known
            .filter_map(|(id, pieces)| Some((*id, fit(pieces, english)?)))
            .next();
        let Some((id, values)) = found else {
            return english.to_owned();
        };
        let said = values.into_iter().map(|(name, value)| {
            let value = match name {
                "step" => self.tell(value),
                "organ" => self.organ(value),
                "instrument" => self.of("instrument-named", value),
                "metric" => self.of("metric", value),
                _ => value.to_owned(),
            };
            (name, FluentValue::from(value))
        });
        self.say_with(id, &said.collect::<Vec<_>>())
    }

    /// An organ by its name in the scene; that name where it is none of the usual ones.
    #[must_use]
    pub fn organ(&self, name: &str) -> String {
        self.of("organ", name)
    }

    /// Message `group-name`, or the name.
    fn of(&self, group: &str, name: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let id: String = name.to_lowercase().chars().map(plain).collect();
        let id = format!("{group}-{id}");
        let said = self.say(&id);
        if said == id { name.to_owned() } else { said }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_said_anew_with_what_stands_in_them() {
        let german = Words::new(Language::German);
        for (english, said) in [
            (
                "Put 3 clips on the cystic duct",
                "3 Clips setzen: Ductus cysticus",
            ),
            (
                "not done: Clear Calot's triangle",
                "nicht getan: Calots Dreieck frei legen",
            ),
            (
                "Put 3 clips on the cystic artery: take the clip applier (4).",
                "3 Clips setzen: Arteria cystica. Dazu: Clipzange (4).",
            ),
            (
                "clips_lost is 2.0, at most 0 is allowed",
                "Clips verloren: 2.0, erlaubt höchstens 0",
            ),
            ("Show the spleen", "Zeigen: spleen"),
            ("Mind the gap", "Mind the gap"),
            ("", ""),
        ] {
            assert_eq!(german.tell(english), said);
        }
    }

    #[test]
    fn english_stays_as_it_is_but_for_names_of_metrics() {
        let english = Words::default();
        for text in [
            "Divide the cystic artery between clips",
            "Free the gallbladder from the liver: hook a strand, lift it clear, then a short current.",
            "it took longer than 900 s",
        ] {
            assert_eq!(english.tell(text), text);
        }
        let said = english.tell("blood_ml is 30.0, at most 20 is allowed");
        assert_eq!(said, "Blood lost is 30.0, at most 20 is allowed");
    }

    #[test]
    fn every_message_is_found_by_its_own_text() {
        for (id, pieces) in ENGLISH.iter() {
            let text: String = pieces
                .iter()
                .map(|piece| match piece {
                    Piece::Text(text) => *text,
                    Piece::Variable(_) => "7",
                })
                .collect();
            let found = ENGLISH
                .iter()
                .find(|(_, pieces)| fit(pieces, &text).is_some());
            assert_eq!(found.map(|(id, _)| *id), Some(*id), "{text}");
        }
    }
}
