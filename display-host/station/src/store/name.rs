//! A trainee's name as the only argument of a command: one word or several.

use clap::Args;

use crate::problem::Problem;

/// Name of a trainee, typed with or without quotes.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct TraineeName {
    /// Trainee. A name of several words needs no quotes
    #[arg(value_name = "NAME", required = true, num_args = 1..)]
    words: Vec<String>,
}

impl TraineeName {
    /// The words as one name.
    pub(crate) fn read(&self) -> Result<String, Problem> {
        store::check_name(&self.words.join(" ")).map_err(Problem::from)
    }
}

#[cfg(test)]
impl From<&str> for TraineeName {
    fn from(name: &str) -> Self {
        let words = vec![name.to_owned()];
        Self { words }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use crate::cli::{Cli, Command};
    use crate::store::args::{StoreCommand, joined};

    #[test]
    fn a_name_of_several_words_needs_no_quotes() {
        let name_of = |words: &str| {
            let Some(Command::Store(args)) = Cli::parse_from(words.split(' ')).command else {
                panic!("{words} is a command of the store");
            };
            match args.command {
                StoreCommand::List { name, .. } => joined(&name).unwrap_or_default(),
                StoreCommand::Forget { name }
                | StoreCommand::Progress { name, .. }
                | StoreCommand::Curve { name, .. } => name.read().unwrap(),
                other => panic!("{other:?}"),
            }
        };
        for words in [
            "calot store list Dr. Lea Mueller",
            "calot store forget Dr. Lea Mueller",
            "calot store progress Dr. Lea Mueller --json",
            "calot store curve Dr. Lea Mueller --task clamp",
        ] {
            assert_eq!(name_of(words), "Dr. Lea Mueller", "{words}");
        }
        assert_eq!(name_of("calot store list"), "");
    }
}
