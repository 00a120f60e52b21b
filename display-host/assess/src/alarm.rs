//! Alarms. Each is an error of the trainee, with its kind, organ, time and place.

/// The kind of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlarmKind {
    /// A protected structure was pressed hard, or an organ that may be touched was pressed too
    /// hard.
    Touched,
    /// A protected structure was burnt, or an organ that may be burnt was burnt too deep.
    Burnt,
    /// A structure other than cystic duct, cystic artery, gallbladder, liver, fat and connective
    /// tissue was cut.
    Cut,
    /// An organ was torn. Fat and connective tissue do not count.
    Torn,
    /// The wall of an organ was burnt through, or a tube was torn, cut or burnt half through.
    Perforated,
    /// Jaws crushed an organ. Fat and connective tissue do not count.
    Crushed,
    /// A clip closed with no tissue in it.
    ClipLost,
    /// A clip closed on a structure that must not be clipped, or on cystic duct and artery at once.
    ClipMisplaced,
    /// A clip on cystic duct or artery leaves a part of it open, so it does not count.
    ClipOpen,
    /// Cystic duct or artery was clipped before the critical view of safety was achieved. Only the
    /// whole operation raises this alarm.
    TooEarly,
    /// A clip closed, or scissors divided a duct or vessel, outside the endoscope's picture. It
    /// names no organ, because nobody saw one.
    Unseen,
    /// Cystic duct or artery was divided and not closed by enough tight clips. Every task except
    /// free practice fails.
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
            Self::ClipOpen => "clip_open",
            Self::TooEarly => "too_early",
            Self::Unseen => "unseen",
            Self::Unclamped => "unclamped",
        }
    }
}

/// An error of the trainee.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Alarm {
    /// Counted time since the task began, s. Pauses and gaps do not count.
    pub at_s: f64,
    /// Time since the recording began, s, at which a replay shows the error.
    pub session_s: f64,
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
        let organ = match &self.organ {
            Some(organ) => format!("the {organ}"),
            None => "an unknown organ".to_owned(),
        };
        match self.kind {
            AlarmKind::Touched => format!("pressed hard on {organ}"),
            AlarmKind::Burnt => format!("burnt {organ}"),
            AlarmKind::Cut => format!("cut {organ}"),
            AlarmKind::Torn => format!("tore {organ}"),
            AlarmKind::Perforated => format!("perforated {organ}"),
            AlarmKind::Crushed => format!("crushed {organ}: loosen the grip"),
            AlarmKind::ClipLost => "closed a clip with no tissue in it".to_owned(),
            AlarmKind::ClipMisplaced => format!("misplaced a clip on {organ}"),
            AlarmKind::ClipOpen => format!("closed a clip that leaves a part of {organ} open"),
            AlarmKind::TooEarly => {
                format!("clipped {organ} before the critical view was achieved")
            }
            AlarmKind::Unseen => "clipped or divided outside the picture".to_owned(),
            AlarmKind::Unclamped => {
                format!("divided or tore {organ}: clips do not close it safely")
            }
        }
    }
}
