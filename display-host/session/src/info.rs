//! A session's description of itself: scene, program, clock. It is MCAP metadata, which any viewer
//! shows.

use std::collections::BTreeMap;

/// Name of the metadata record that holds the description.
pub(crate) const NAME: &str = "calot";

/// Name of the metadata record at the end of a properly ended session.
pub(crate) const FINISH: &str = "calot.end";

/// Name of the metadata record that marks a repaired session.
pub(crate) const REPAIRED: &str = "calot.repaired";

/// Key of the place where a repaired session broke off.
pub(crate) const WHY: &str = "why";

/// Key of the text about what a repaired session lost before its end.
pub(crate) const LOST: &str = "lost";

/// Name of the metadata record with the session's purpose.
pub(crate) const ASSIGNMENT: &str = "calot.task";

/// Purpose of a session that belongs to a task, sufficient to assess the session again. It holds no
/// personal data.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Assignment {
    /// The task's name.
    pub task: String,
    /// Degree of help.
    pub difficulty: String,
    /// Pass rules of the session, TOML; empty: the built-in ones.
    pub rules: String,
    /// The session's identifier in a store; empty: none.
    pub id: String,
    /// True if a scripted hand works the session at emulated devices, instead of a person. Older
    /// programs did not say so, which counts as a person.
    pub is_scripted: bool,
}

/// Name of the endoscope drill. It begins at once, not with the first move: a trainee may have to
/// hold the endoscope still from the start, because it shows the first organ already.
pub const ENDOSCOPE_DRILL: &str = "scope";

/// Word for a scripted hand.
const SCRIPTED: &str = "scripted";

impl Assignment {
    /// Word for the hand that works the session: `person` or `scripted`.
    #[must_use]
    pub fn hand(&self) -> &'static str {
        match self.is_scripted {
            true => SCRIPTED,
            false => "person",
        }
    }

    pub(crate) fn to_map(&self) -> BTreeMap<String, String> {
        let texts = [
            ("task", &self.task),
            ("difficulty", &self.difficulty),
            ("rules", &self.rules),
            ("id", &self.id),
        ];
        let texts = texts.map(|(key, value)| (key.to_owned(), value.clone()));
        let hand = ("hand".to_owned(), self.hand().to_owned());
        texts.into_iter().chain([hand]).collect()
    }

    pub(crate) fn from_map(map: &BTreeMap<String, String>) -> Self {
        let text = |key: &str| map.get(key).cloned().unwrap_or_default();
        Self {
            task: printable(&text("task")),
            difficulty: printable(&text("difficulty")),
            // The program that applies the rules checks them as it checks a rules file.
            rules: text("rules"),
            id: printable(&text("id")),
            is_scripted: text("hand") == SCRIPTED,
        }
    }
}

/// A session's description of itself.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Info {
    /// The scene's name.
    pub scene: String,
    /// Identity of the compiled scene, hexadecimal.
    pub scene_id: String,
    /// Recording program: version, commit, build.
    pub build: String,
    /// Offset from host time (`CLOCK_MONOTONIC`) to wall-clock time, ns.
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

    /// Parses the metadata. If this program cannot read the file's version, the error is that
    /// version.
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

/// The recorder's final record of a properly ended session.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Finish {
    /// Number of ticks that the controller reported at its end. `None` if the controller was killed
    /// or the recorder ended first: more ticks may have run after the last recorded one.
    pub ran: Option<u64>,
    /// Ticks known to have run that are not recorded.
    pub missing: u64,
    /// Events known to have happened that are not recorded.
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
            // Older programs did not count missing events.
            missing_events: match map.get("missing_events") {
                Some(events) => events.parse().ok()?,
                None => 0,
            },
        })
    }
}

/// Makes a file's text fit for a terminal: no control characters, 200 characters at most.
#[must_use]
pub fn printable(text: &str) -> String {
    let shown = text.chars().filter(|it| !it.is_control());
    shown.take(200).collect()
}

/// Half of a scene's identity as hexadecimal text.
#[must_use]
pub fn hex(id: [u8; 16]) -> String {
    use core::fmt::Write as _;
    id.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
