//! The curriculum: levels of tasks in the order in which they are learnt, each with a benchmark.
//! A file (TOML) defines it, and one is built in.

mod certificate;
mod progress;

pub(crate) use progress::Progress;

use std::collections::BTreeMap;
use std::path::Path;

use assess::{Difficulty, Task};
use display_host::words::Language;

use crate::problem::Problem;

pub(crate) const BUILT_IN: &str = include_str!("built_in.toml");
/// Version of the file format.
const VERSION: u32 = 1;
/// Largest file that is read, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Levels of tasks, in the order in which they are learnt.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curriculum {
    levels: Vec<Level>,
}

#[derive(Debug, Clone, PartialEq)]
struct Level {
    /// Title by the code of a language.
    title: BTreeMap<String, String>,
    tasks: Vec<Aim>,
}

/// A task, and what makes a trainee proficient in it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Aim {
    task: Task,
    difficulty: Difficulty,
    /// Least score of a pass that counts.
    score: f64,
    /// Passes that must follow each other.
    passes: usize,
}

mod written {
    //! The curriculum as the file writes it.
    use super::{BTreeMap, Difficulty, Task};

    #[derive(serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct File {
        pub(super) version: u32,
        pub(super) passes_in_a_row: usize,
        pub(super) level: Vec<Level>,
    }

    #[derive(serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Level {
        pub(super) title: BTreeMap<String, String>,
        pub(super) tasks: Vec<Aim>,
    }

    #[derive(serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(super) struct Aim {
        pub(super) task: Task,
        pub(super) difficulty: Difficulty,
        pub(super) score: f64,
        pub(super) passes_in_a_row: Option<usize>,
    }
}

impl Curriculum {
    /// Reads a file, or takes the built-in curriculum.
    pub(crate) fn read(path: Option<&Path>) -> Result<Self, Problem> {
        let Some(path) = path else {
            return Self::parse(BUILT_IN).map_err(Problem::from);
        };
        let named = |why: &dyn core::fmt::Display| -> Problem {
            let shown = path.display();
            format!(
                "{shown}: {why}. `calot store curriculum` prints the built-in file to begin with"
            )
            .into()
        };
        let size = path.metadata().map_err(|error| named(&error))?.len();
        if size > MAX_BYTES {
            let why = format!("{size} bytes, at most {MAX_BYTES} are read as a curriculum");
            return Err(named(&why));
        }
        let text = std::fs::read_to_string(path).map_err(|error| named(&error))?;
        Self::parse(&text).map_err(|why| named(&why))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let file: written::File =
            toml::from_str(text).map_err(|error| error.to_string().trim_end().to_owned())?;
        if file.version != VERSION {
            let version = file.version;
            return Err(format!(
                "version is {version}, this program reads a curriculum of version {VERSION}"
            ));
        }
        let usual = file.passes_in_a_row;
        let level = |level: written::Level| {
            let tasks = level.tasks.iter().map(|aim| checked(aim, usual));
            let tasks: Vec<Aim> = tasks.collect::<Result<_, String>>()?;
            let title = level.title;
            Ok(Level { title, tasks })
        };
        let levels: Vec<Level> = file
            .level
            .into_iter()
            .map(level)
            .collect::<Result<_, String>>()?;
        match levels.iter().any(|level| !level.tasks.is_empty()) {
            true => Ok(Self { levels }),
            false => {
                Err("the curriculum has no task; add one to `tasks` of a [[level]]".to_owned())
            }
        }
    }
}

impl Level {
    /// Title in a language. If it is missing, the title in English, or else in any language.
    fn title(&self, language: Language) -> &str {
        let own = self.title.get(language.code());
        let found = own.or_else(|| self.title.get(Language::English.code()));
        found
            .or_else(|| self.title.values().next())
            .map_or("", |it| it)
    }
}

fn checked(aim: &written::Aim, usual: usize) -> Result<Aim, String> {
    let passes = aim.passes_in_a_row.unwrap_or(usual);
    let name = aim.task.name();
    if !(1..=20).contains(&passes) {
        return Err(format!(
            "passes_in_a_row of task '{name}' is {passes}; allowed is 1 to 20"
        ));
    }
    if !(0.0..=100.0).contains(&aim.score) {
        let score = aim.score;
        return Err(format!(
            "score of task '{name}' is {score}; allowed is 0 to 100"
        ));
    }
    if aim.task == Task::Free {
        return Err(format!(
            "task '{name}' cannot be passed, so it has no place in a curriculum; leave it out"
        ));
    }
    Ok(Aim {
        task: aim.task,
        difficulty: aim.difficulty,
        score: aim.score,
        passes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_comes_before_a_clip_as_in_the_operation() {
        let curriculum = Curriculum::read(None).unwrap();
        for level in &curriculum.levels {
            let place = |task| level.tasks.iter().position(|it| it.task == task);
            let order = [Task::Identify, Task::Clamp, Task::Cut, Task::Disconnect].map(place);
            assert!(order.is_sorted(), "{level:?}");
        }
    }

    #[test]
    fn the_built_in_curriculum_leads_from_the_first_steps_to_the_exam() {
        let curriculum = Curriculum::read(None).unwrap();
        let aims: Vec<_> = curriculum.levels.iter().flat_map(|it| &it.tasks).collect();
        assert_eq!(aims.first().unwrap().task, Task::Basics);
        let last = aims.last().unwrap();
        assert_eq!((last.task, last.difficulty), (Task::Full, Difficulty::Exam));
        assert_eq!(last.passes, 2);
        for language in Language::ALL {
            for level in &curriculum.levels {
                assert!(level.title.contains_key(language.code()), "{level:?}");
            }
        }
    }

    #[test]
    fn mistakes_are_reported_with_the_allowed_values() {
        let refused = |from: &str, to: &str| {
            assert!(BUILT_IN.contains(from), "{from}");
            Curriculum::parse(&BUILT_IN.replacen(from, to, 1)).unwrap_err()
        };
        for (from, to, said) in [
            (
                "version = 1",
                "version = 2",
                "reads a curriculum of version 1",
            ),
            ("\"basics\"", "\"dance\"", "unknown variant `dance`"),
            (
                "passes_in_a_row = 2",
                "passes_in_a_row = 0",
                "is 0; allowed is 1 to 20",
            ),
            (
                "score = 80.0",
                "score = 180.0",
                "is 180; allowed is 0 to 100",
            ),
            ("\"basics\"", "\"free\"", "has no place in a curriculum"),
            ("tasks = [", "task = [", "unknown field `task`"),
        ] {
            let error = refused(from, to);
            assert!(error.contains(said), "{error}");
        }
        let empty = "version = 1\npasses_in_a_row = 2\nlevel = []\n";
        let error = Curriculum::parse(empty).unwrap_err();
        assert!(error.contains("the curriculum has no task"), "{error}");
    }

    #[test]
    fn a_file_is_named_with_its_problem() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.toml");
        let error = |path: &Path| Curriculum::read(Some(path)).unwrap_err().to_string();
        assert!(error(&path).contains("own.toml"), "it is missing");
        std::fs::write(&path, "version = 3").unwrap();
        assert!(error(&path).contains("prints the built-in file to begin with"));
        std::fs::write(&path, "#".repeat(MAX_BYTES as usize + 1)).unwrap();
        assert!(error(&path).contains("are read as a curriculum"));
        std::fs::write(&path, BUILT_IN).unwrap();
        assert_eq!(
            Curriculum::read(Some(&path)).unwrap(),
            Curriculum::read(None).unwrap()
        );
    }
}
