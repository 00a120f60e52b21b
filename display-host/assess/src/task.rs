//! Tasks, degrees of help, and outcomes.

use shared_mem::scene::OrganKind;

use crate::anatomy::{Anatomy, Region};

/// A task for the trainee.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Clear Calot's triangle until the critical view of safety is achieved (paper, task 1).
    Identify,
    /// Clip cystic duct and artery (paper, task 2).
    Clamp,
    /// Divide duct and artery between the clips (paper, task 3).
    Cut,
    /// Free the gallbladder from the liver (paper, task 4).
    Disconnect,
    /// The four tasks above, in order.
    Full,
    /// Free practice: nothing is required, everything is measured.
    Free,
    /// Show one organ after the other with the endoscope.
    Scope,
    /// The first steps with camera and instrument, each with its goal.
    Basics,
    /// Drills on the phantom: touch, grasp and carry, clip, cut, hook.
    Phantom,
}

impl Task {
    /// All tasks, in the order in which they are learnt.
    pub const ALL: [Self; 9] = [
        Self::Basics,
        Self::Scope,
        Self::Phantom,
        Self::Identify,
        Self::Clamp,
        Self::Cut,
        Self::Disconnect,
        Self::Full,
        Self::Free,
    ];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Identify => "identify",
            Self::Clamp => "clamp",
            Self::Cut => "cut",
            Self::Disconnect => "disconnect",
            Self::Full => "full",
            Self::Free => "free",
            Self::Scope => "scope",
            Self::Basics => "basics",
            Self::Phantom => "phantom",
        }
    }

    /// The task of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|task| task.name() == name)
    }

    /// Title for the trainee.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Identify => "Identify: expose cystic duct and artery",
            Self::Clamp => "Clamp: clip cystic duct and artery",
            Self::Cut => "Cut: divide both between the clips",
            Self::Disconnect => "Disconnect: free the gallbladder from the liver",
            Self::Full => "The whole operation",
            Self::Free => "Free practice",
            Self::Scope => "Endoscope: show each organ in turn",
            Self::Basics => "First steps: camera, tip, grasp, clip, current",
            Self::Phantom => "Drills on the phantom: touch, carry, clip, cut, hook",
        }
    }

    /// True if hanging the gallbladder is the first step of the task, so that the trainee may place
    /// the sutures.
    #[must_use]
    pub fn may_hang(self) -> bool {
        matches!(self, Self::Identify | Self::Full | Self::Free)
    }

    /// The first thing that the task needs and the scene lacks, if any.
    #[must_use]
    pub fn lacks(self, anatomy: &Anatomy) -> Option<String> {
        let vessels = [
            (OrganKind::CysticDuct, "cystic duct"),
            (OrganKind::CysticArtery, "cystic artery"),
        ];
        let vessel = vessels.into_iter().find(|(kind, _)| !anatomy.has(*kind));
        let vessel = vessel.map(|(_, name)| name.to_owned());
        let layer = |regions: &[Region]| {
            let none = regions.iter().any(|region| !anatomy.has_cells(*region));
            none.then(|| "layered tissue in the triangle and the gallbladder's bed".to_owned())
        };
        match self {
            Self::Clamp | Self::Cut => vessel,
            Self::Basics => vessel.or_else(|| layer(&[Region::UpperBed])),
            Self::Identify => layer(&[Region::Triangle, Region::LowerBed]),
            Self::Disconnect => layer(&[Region::LowerBed, Region::UpperBed]),
            Self::Full => vessel.or_else(|| layer(&Region::COUNTED)),
            Self::Free => None,
            Self::Phantom => (!anatomy.is_phantom())
                .then(|| "balls, rope, tube and fat of the phantom".to_owned()),
            Self::Scope => (!anatomy.has(OrganKind::Gallbladder)).then(|| "gallbladder".to_owned()),
        }
    }
}

/// Degree of help.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Difficulty {
    /// Hints give the next step.
    Beginner,
    /// Alarms and progress are shown.
    #[default]
    Trainee,
    /// Only time and task are shown; errors are shown at the end.
    Exam,
}

impl Difficulty {
    /// All degrees of help.
    pub const ALL: [Self; 3] = [Self::Beginner, Self::Trainee, Self::Exam];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Beginner => "beginner",
            Self::Trainee => "trainee",
            Self::Exam => "exam",
        }
    }

    /// The degree of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// Outcome of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The task is still running.
    Running,
    /// All steps are done, and all pass rules are met.
    Passed,
    /// A critical error happened, or the task is done and a pass rule is not met.
    Failed,
    /// The task ended before all steps were done.
    Aborted,
    /// Free practice, which has no pass rules.
    Practised,
}

impl Outcome {
    /// Name in `summary.json`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Aborted => "aborted",
            Self::Practised => "practised",
        }
    }
}
