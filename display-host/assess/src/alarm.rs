//! What was wrong, and when.

/// What an alarm is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlarmKind {
    /// A structure was touched that must not be.
    Touched,
    /// A structure was burnt that must not be.
    Burnt,
    /// A structure was cut that must not be.
    Cut,
    /// A structure was torn.
    Torn,
    /// A wall was opened.
    Perforated,
    /// Jaws crushed something.
    Crushed,
    /// A clip closed on nothing.
    ClipLost,
    /// A clip closed on what must not be clipped.
    ClipMisplaced,
    /// Clipped before the critical view of safety was there.
    TooEarly,
    /// Duct or artery was divided without being clamped. The task fails.
    Unclamped,
}

impl AlarmKind {
    /// As `summary.json` has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Touched => "touched",
            Self::Burnt => "burnt",
            Self::Cut => "cut",
            Self::Torn => "torn",
            Self::Perforated => "perforated",
            Self::Crushed => "crushed",
            Self::ClipLost => "clip_lost",
            Self::ClipMisplaced => "clip_misplaced",
            Self::TooEarly => "too_early",
            Self::Unclamped => "unclamped",
        }
    }
}

/// Something that was wrong.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Alarm {
    /// When, s since the task began.
    pub at_s: f64,
    /// What.
    pub kind: AlarmKind,
    /// On what, if on something.
    pub organ: Option<String>,
    /// Where, world frame, m.
    pub at_m: [f32; 3],
}

impl Alarm {
    /// What the trainee reads.
    #[must_use]
    pub fn text(&self) -> String {
        let organ = self.organ.as_deref().unwrap_or("something");
        match self.kind {
            AlarmKind::Touched => format!("touched the {organ}"),
            AlarmKind::Burnt => format!("burnt the {organ}"),
            AlarmKind::Cut => format!("cut the {organ}"),
            AlarmKind::Torn => format!("tore the {organ}"),
            AlarmKind::Perforated => format!("opened the {organ}"),
            AlarmKind::Crushed => format!("crushed the {organ}: grip less"),
            AlarmKind::ClipLost => "a clip closed on nothing".to_owned(),
            AlarmKind::ClipMisplaced => format!("a clip on the {organ}"),
            AlarmKind::TooEarly => {
                format!("clipped the {organ} before the critical view was there")
            }
            AlarmKind::Unclamped => format!("divided the {organ} unclamped"),
        }
    }
}
