//! What a session says of itself: scene, program, clock. MCAP metadata, so that any viewer shows it.

use std::collections::BTreeMap;

/// Name of the metadata record.
pub(crate) const NAME: &str = "calot";

/// Name of the record at the end.
pub(crate) const FINISH: &str = "calot.end";

/// Name of the record of what a session is for.
pub(crate) const ASSIGNMENT: &str = "calot.task";

/// What a session is for, if it is for a task: enough to assess it again. Nothing of a person.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Assignment {
    /// The task's name.
    pub task: String,
    /// How much help is given.
    pub difficulty: String,
    /// The pass rules as they were, TOML; empty: the built-in ones.
    pub rules: String,
    /// The session's own name, by which a store knows it; empty: it has none.
    pub id: String,
}

impl Assignment {
    pub(crate) fn to_map(&self) -> BTreeMap<String, String> {
        let texts = [
            ("task", &self.task),
            ("difficulty", &self.difficulty),
            ("rules", &self.rules),
            ("id", &self.id),
        ];
        let texts = texts.into_iter();
        texts
            .map(|(key, value)| (key.to_owned(), value.clone()))
            .collect()
    }

    pub(crate) fn from_map(map: &BTreeMap<String, String>) -> Self {
        let text = |key: &str| map.get(key).cloned().unwrap_or_default();
        Self {
            task: printable(&text("task")),
            difficulty: printable(&text("difficulty")),
            // Whoever reads it checks it as he would a file.
            rules: text("rules"),
            id: printable(&text("id")),
        }
    }
}

/// What a session says of itself.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Info {
    /// The scene's name.
    pub scene: String,
    /// The compiled scene's identity, hexadecimal.
    pub scene_id: String,
    /// Program and version that recorded it, its commit, how it was built and for what.
    pub build: String,
    /// What to add to host times (`CLOCK_MONOTONIC`) for the wall clock's, ns.
    pub wall_from_host_ns: i64,
}

impl Info {
    pub(crate) fn to_map(&self) -> BTreeMap<String, String> {
        [
            ("version", crate::FILE_VERSION.to_string()),
            ("scene", self.scene.clone()),
            ("scene_id", self.scene_id.clone()),
            ("build", self.build.clone()),
            ("wall_from_host_ns", self.wall_from_host_ns.to_string()),
        ]
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
    }

    /// `Err`: the version of a file that this program does not read.
    pub(crate) fn from_map(map: &BTreeMap<String, String>) -> Result<Self, String> {
        let text = |key: &str| map.get(key).cloned().unwrap_or_default();
        if text("version") != crate::FILE_VERSION.to_string() {
            return Err(printable(&text("version")));
        }
        Ok(Self {
            scene: printable(&text("scene")),
            scene_id: printable(&text("scene_id")),
            build: printable(&text("build")),
            wall_from_host_ns: text("wall_from_host_ns").parse().unwrap_or(0),
        })
    }
}

/// What a recorder says when it ends a session in order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Finish {
    /// Ticks that the controller ran, as it said at its end. `None`: it said nothing, for it was killed or
    /// the recorder ended first; whether ticks ran after the last recorded one cannot be known.
    pub ran: Option<u64>,
    /// Ticks that are known to have run and are not in the session.
    pub missing: u64,
    /// Events that are known to have happened and are not in it.
    pub missing_events: u64,
}

impl Finish {
    pub(crate) fn to_map(self) -> BTreeMap<String, String> {
        let ran = self.ran.map(|ran| ("ran".to_owned(), ran.to_string()));
        let missing = ("missing".to_owned(), self.missing.to_string());
        let events = ("missing_events".to_owned(), self.missing_events.to_string());
        ran.into_iter().chain([missing, events]).collect()
    }

    pub(crate) fn from_map(map: &BTreeMap<String, String>) -> Option<Self> {
        Some(Self {
            ran: map.get("ran").map(|ran| ran.parse()).transpose().ok()?,
            missing: map.get("missing")?.parse().ok()?,
            // Older programs did not count them.
            missing_events: match map.get("missing_events") {
                Some(events) => events.parse().ok()?,
                None => 0,
            },
        })
    }
}

/// A text from a file, fit for a terminal: without control characters, 200 characters at most.
#[must_use]
pub fn printable(text: &str) -> String {
    let shown = text.chars().filter(|it| !it.is_control());
    shown.take(200).collect()
}

/// Half a scene's identity, as text.
#[must_use]
pub fn hex(id: [u8; 16]) -> String {
    use core::fmt::Write as _;
    id.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
