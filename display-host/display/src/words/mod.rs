//! Words of the interface in the user's language: a Fluent file for each language.

mod number;
mod page;
mod told;

use std::fmt;
use std::sync::Arc;

pub use fluent_bundle::FluentValue;
use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource};
use unic_langid::langid;

/// A language of the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Language {
    /// `en`.
    #[default]
    English,
    /// `de`.
    German,
}

impl Language {
    /// All languages.
    pub const ALL: [Self; 2] = [Self::English, Self::German];

    /// Name of the language in the language itself.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::English => "English",
            Self::German => "Deutsch",
        }
    }

    /// Code of the language on the command line and in POSIX locales.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
        }
    }

    /// Language of a POSIX locale such as `de_AT.UTF-8`; English if it is not supported.
    #[must_use]
    pub fn of_locale(locale: &str) -> Self {
        let code = locale.split(['_', '.', '@', '-']).next().unwrap_or("");
        let found = Self::ALL.into_iter().find(|it| it.code() == code);
        found.unwrap_or_default()
    }

    const fn source(self) -> &'static str {
        match self {
            Self::English => include_str!("en.ftl"),
            Self::German => include_str!("de.ftl"),
        }
    }

    /// Definitions of the metrics; empty for English, in which the assessment itself has them.
    const fn definitions(self) -> &'static str {
        match self {
            Self::English => "",
            Self::German => include_str!("definitions.de.ftl"),
        }
    }
}

/// The words of one language. Cheap to clone.
#[derive(Clone)]
pub struct Words {
    language: Language,
    bundle: Arc<FluentBundle<FluentResource>>,
}

impl Words {
    /// The words of this language.
    #[must_use]
    pub fn new(language: Language) -> Self {
        let tag = match language {
            Language::English => langid!("en"),
            Language::German => langid!("de"),
        };
        let mut bundle = FluentBundle::new_concurrent(vec![tag]);
        // Isolation marks are for mixed text directions, which do not occur.
        bundle.set_use_isolating(false);
        // An invalid message is left out; a test finds it. The other messages stay usable.
        for source in [language.source(), language.definitions()] {
            let (Ok(resource) | Err((resource, _))) = FluentResource::try_new(source.to_owned());
            bundle.add_resource_overriding(resource);
        }
        Self {
            language,
            bundle: Arc::new(bundle),
        }
    }

    /// The language.
    #[must_use]
    pub const fn language(&self) -> Language {
        self.language
    }

    /// Text of message `id`; the id itself if the language lacks the message.
    #[must_use]
    pub fn say(&self, id: &str) -> String {
        self.say_with(id, &[])
    }

    /// Text of a message with values for its variables.
    #[must_use]
    pub fn say_with(&self, id: &str, values: &[(&str, FluentValue<'_>)]) -> String {
        let message = self.bundle.get_message(id);
        let Some(pattern) = message.and_then(|message| message.value()) else {
            return id.to_owned();
        };
        let mut arguments = FluentArgs::new();
        for (name, value) in values {
            arguments.set(*name, value.clone());
        }
        let mut errors = Vec::new();
        let text = self
            .bundle
            .format_pattern(pattern, Some(&arguments), &mut errors);
        debug_assert!(errors.is_empty(), "{id}: {errors:?}");
        text.into_owned()
    }
}

impl Default for Words {
    fn default() -> Self {
        Self::new(Language::default())
    }
}

impl fmt::Debug for Words {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_tuple("Words")
            .field(&self.language)
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Messages of a language, with the variables of each.
    fn messages(language: Language) -> BTreeMap<String, Vec<String>> {
        let source = language.source();
        FluentResource::try_new(source.to_owned())
            .map_err(|(_, errors)| errors)
            .expect("every message parses");
        let mut all = BTreeMap::new();
        let mut last = String::new();
        for line in source.lines().filter(|line| !line.starts_with('#')) {
            if let Some((id, _)) = line.split_once(" =").filter(|_| !line.starts_with(' ')) {
                last = id.to_owned();
                let before = all.insert(last.clone(), Vec::new());
                assert_eq!(before, None, "{language:?} says {id} twice");
            }
            let variables = line.split('$').skip(1).map(|rest| {
                let end = rest.find(|c: char| !c.is_alphanumeric() && c != '-');
                rest[..end.unwrap_or(rest.len())].to_owned()
            });
            if let Some(own) = all.get_mut(&last) {
                own.extend(variables);
            }
        }
        for own in all.values_mut() {
            own.sort();
            own.dedup();
        }
        all
    }

    #[test]
    fn every_language_has_the_same_messages_with_the_same_variables() {
        let english = messages(Language::English);
        assert!(english.len() > 50);
        for language in Language::ALL {
            assert_eq!(messages(language), english, "{language:?}");
        }
    }

    #[test]
    fn german_messages_differ_from_english_ones() {
        let (english, german) = (Words::default(), Words::new(Language::German));
        let all = messages(Language::English);
        let same = all.keys().filter(|id| {
            // Leave out a message with variables, because it needs values.
            all[*id].is_empty() && english.say(id) == german.say(id)
        });
        // Names, and words common to both languages, may be the same.
        let same: Vec<_> = same.collect();
        assert!(same.len() * 10 < all.len(), "{same:?}");
    }

    #[test]
    fn a_locale_chooses_its_language_and_others_get_english() {
        for (locale, language) in [
            ("de_AT.UTF-8", Language::German),
            ("de", Language::German),
            ("en_GB", Language::English),
            ("fr_FR.UTF-8", Language::English),
            ("C", Language::English),
            ("", Language::English),
        ] {
            assert_eq!(Language::of_locale(locale), language, "{locale}");
        }
    }

    #[test]
    fn values_stand_where_they_belong_and_a_missing_message_is_its_id() {
        let words = Words::new(Language::German);
        let text = words.say_with("task-score", &[("score", "87".into())]);
        assert_eq!(text, "87 von 100 Punkten");
        assert_eq!(words.say("no-such-message"), "no-such-message");
    }
}
