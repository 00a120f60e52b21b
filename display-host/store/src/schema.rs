//! Tables of the store, and the marks of its file.

/// Version of the tables.
pub const SCHEMA_VERSION: i64 = 1;
/// SQLite's application id, "Calo" in ASCII. It marks the file as a store of Calot.
pub(crate) const APPLICATION: i64 = 0x4361_6c6f;

/// SQL that makes the tables.
pub(crate) const TABLES: &str = "
CREATE TABLE trainee (
    id INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE
) STRICT;
CREATE TABLE session (
    id TEXT PRIMARY KEY,                -- UUID of version 7
    trainee INTEGER NOT NULL REFERENCES trainee ON DELETE CASCADE,
    began_unix_s INTEGER NOT NULL,
    task TEXT NOT NULL,
    difficulty TEXT NOT NULL,
    outcome TEXT NOT NULL,
    score REAL NOT NULL,
    alarms INTEGER NOT NULL,
    metrics_version INTEGER NOT NULL,
    metrics TEXT NOT NULL,              -- JSON: number or null by name
    scene TEXT NOT NULL,
    program TEXT NOT NULL,
    file TEXT                           -- the recording, where it was
) STRICT;
CREATE INDEX session_of ON session (trainee, began_unix_s);
CREATE TABLE answer (
    trainee INTEGER NOT NULL REFERENCES trainee ON DELETE CASCADE,
    questionnaire TEXT NOT NULL,
    item TEXT NOT NULL,
    value INTEGER NOT NULL CHECK (value BETWEEN 1 AND 5),
    at_unix_s INTEGER NOT NULL,
    PRIMARY KEY (trainee, questionnaire, item)
) STRICT;
CREATE TABLE sheet (
    session TEXT NOT NULL REFERENCES session ON DELETE CASCADE,
    item TEXT NOT NULL,
    value INTEGER NOT NULL CHECK (value BETWEEN 1 AND 5),
    PRIMARY KEY (session, item)
) STRICT;
";

/// SQL that makes the table of sessions that a scripted hand worked. It came later than the others.
/// Programs that do not know it can still use the file.
pub(crate) const SCRIPTED: &str = "
CREATE TABLE IF NOT EXISTS scripted (
    session TEXT PRIMARY KEY REFERENCES session ON DELETE CASCADE
) STRICT;
";
