//! Alarms. Each is an error of the trainee, with its kind, organ, time and place.

/// The kind of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlarmKind {
    /// A protected structure was touched.
    Touched,
    /// A protected structure was burnt.
    Burnt,
    /// A protected structure was cut.
    Cut,
    /// A structure was torn.
    Torn,
    /// A wall was perforated.
    Perforated,
    /// Jaws crushed tissue.
    Crushed,
    /// A clip closed without tissue.
    ClipLost,
    /// A clip closed on a structure that must not be clipped.
    ClipMisplaced,
    /// A vessel was clipped before the critical view of safety was achieved.
    TooEarly,
    /// Duct or artery was divided without being clamped. The task fails.
    Unclamped,
}

impl AlarmKind {
    /// Name in `summary.json`.
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

/// An error of the trainee.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Alarm {
    /// Counted time since the task began, s. Pauses and gaps do not count.
    pub at_s: f64,
    /// Kind of error.
    pub kind: AlarmKind,
    /// The organ concerned, if any.
    pub organ: Option<String>,
    /// Position in the world frame, m.
    pub at_m: [f32; 3],
}

impl Alarm {
    /// Text for the trainee.
    #[must_use]
    pub fn text(&self) -> String {
        let organ = self.organ.as_deref().unwrap_or("something");
        match self.kind {
            AlarmKind::Touched => format!("touched the {organ}"),
            AlarmKind::Burnt => format!("burnt the {organ}"),
            AlarmKind::Cut => format!("cut the {organ}"),
            AlarmKind::Torn => format!("tore the {organ}"),
            AlarmKind::Perforated => format!("opened the {organ}"),
            AlarmKind::Crushed => format!("crushed the {organ}: loosen the grip"),
            AlarmKind::ClipLost => "a clip closed without tissue".to_owned(),
            AlarmKind::ClipMisplaced => format!("clip misplaced on the {organ}"),
            AlarmKind::TooEarly => {
                format!("clipped the {organ} before the critical view was achieved")
            }
            AlarmKind::Unclamped => format!("divided the {organ} without clips"),
        }
    }
}
