//! The texts of a debrief in the reader's language. The caller supplies them, so this package holds
//! no translations.

use crate::step::{Reason, Step};

/// Texts in the reader's language.
pub trait Words {
    /// Code of the language, for the attribute `lang` of a page.
    fn code(&self) -> &str;
    /// Text of a message, with values for its variables.
    fn say_with(&self, id: &str, values: &[(&str, &str)]) -> String;
    /// True if the language has this message.
    fn has(&self, id: &str) -> bool;
    /// Displayed name of a metric or of the score. `name` is its key in JSON.
    fn metric(&self, name: &str) -> String;
    /// Displayed name of an organ. `name` is its name in the scene.
    fn organ(&self, name: &str) -> String;
    /// Text of a step.
    fn step(&self, step: &Step) -> String;
    /// Advice for a step: where to begin, and how to go on.
    fn place(&self, step: &Step) -> String;
    /// Text that says why the attempt did not pass.
    fn reason(&self, reason: &Reason) -> String;
    /// A number with this many decimals, as the language writes it.
    fn number(&self, value: f64, digits: usize) -> String;

    /// Text of a message without variables.
    fn say(&self, id: &str) -> String {
        self.say_with(id, &[])
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The text of a message is its id and its values.
    #[derive(Debug)]
    pub(in crate::report) struct Ids;

    impl Words for Ids {
        fn code(&self) -> &str {
            "en"
        }

        fn say_with(&self, id: &str, values: &[(&str, &str)]) -> String {
            let mut said = id.to_owned();
            for (name, value) in values {
                said += &format!(" {name}={value}");
            }
            said
        }

        fn has(&self, _: &str) -> bool {
            true
        }

        fn metric(&self, name: &str) -> String {
            name.to_owned()
        }

        fn organ(&self, name: &str) -> String {
            name.to_owned()
        }

        fn step(&self, step: &Step) -> String {
            step.to_string()
        }

        fn place(&self, step: &Step) -> String {
            format!("place of: {step}")
        }

        fn reason(&self, reason: &Reason) -> String {
            reason.to_string()
        }

        fn number(&self, value: f64, digits: usize) -> String {
            format!("{value:.digits$}")
        }
    }
}
