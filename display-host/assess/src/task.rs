//! The tasks, how much help is given, and how they end.

use shared_mem::scene::OrganKind;

use crate::anatomy::{Anatomy, Region};

/// What the trainee is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Clear Calot's triangle until the critical view of safety is there (paper, task 1).
    Identify,
    /// Clip cystic duct and artery (paper, task 2).
    Clamp,
    /// Divide both between the clips (paper, task 3).
    Cut,
    /// Free the gallbladder from the liver (paper, task 4).
    Disconnect,
    /// All four, in order.
    Full,
    /// Nothing is asked; everything is measured.
    Free,
    /// Show one organ after the other with the endoscope.
    Scope,
}

impl Task {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Identify,
        Self::Clamp,
        Self::Cut,
        Self::Disconnect,
        Self::Full,
        Self::Free,
        Self::Scope,
    ];

    /// As it is typed.
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
        }
    }

    /// The task that is typed so.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|task| task.name() == name)
    }

    /// What the trainee reads.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Identify => "Identify: show cystic duct and artery",
            Self::Clamp => "Clamp: clip cystic duct and artery",
            Self::Cut => "Cut: divide both between the clips",
            Self::Disconnect => "Disconnect: free the gallbladder from the liver",
            Self::Full => "The whole operation",
            Self::Free => "Free practice",
            Self::Scope => "Endoscope: show the organs in turn",
        }
    }

    /// Whether the trainee may place the sutures in it: whether it begins with nothing done.
    #[must_use]
    pub fn may_hang(self) -> bool {
        matches!(self, Self::Identify | Self::Full | Self::Free)
    }

    /// What it needs and a scene lacks, if anything.
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
            Self::Identify => layer(&[Region::Triangle, Region::LowerBed]),
            Self::Disconnect => layer(&[Region::LowerBed, Region::UpperBed]),
            Self::Full => vessel.or_else(|| layer(&Region::COUNTED)),
            Self::Free => None,
            Self::Scope => (!anatomy.has(OrganKind::Gallbladder)).then(|| "gallbladder".to_owned()),
        }
    }
}

/// How much help is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Difficulty {
    /// The next step is said.
    Beginner,
    /// Alarms and progress are shown.
    #[default]
    Trainee,
    /// Only time and task are shown; what went wrong is said at the end.
    Exam,
}

impl Difficulty {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Beginner, Self::Trainee, Self::Exam];

    /// As it is typed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Beginner => "beginner",
            Self::Trainee => "trainee",
            Self::Exam => "exam",
        }
    }

    /// The one that is typed so.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// How a task stands or ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It goes on.
    Running,
    /// Done, and the pass rules are met.
    Passed,
    /// Something that must not happen did, or it is done and a pass rule is not met.
    Failed,
    /// It ended before it was done.
    Aborted,
    /// Free practice, which cannot be passed.
    Practised,
}

impl Outcome {
    /// As `summary.json` has it.
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
