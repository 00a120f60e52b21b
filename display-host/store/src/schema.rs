//! Tables of the store, and the marks of its file. Any program that reads SQLite can use them.
//!
//! | table | a row is |
//! |---|---|
//! | `trainee` | a person |
//! | `session` | an assessed session |
//! | `answer` | an answer to a questionnaire, 1 to 5; the newest replaces older ones |
//! | `rating` | a scoring sheet that a rater filled for a session |
//! | `point` | an item of such a sheet; `value` is within the scale of the sheet |
//! | `forgotten_trainee` | the mark of a name that was forgotten |
//! | `forgotten_session` | the mark of one of their sessions |
//! | `forgotten_person` | a person whom a station asked this store, as a centre's, to forget |
//! | `setting` | a setting of the store by name; `site`: name of the station's site |
//! | `destination` | a centre to which results go |
//! | `delivery` | a note on a session and a centre; a session without a note has to be sent |
//! | `withdrawal` | a person whom a centre has to forget |
//!
//! - `trainee`: `name` is the name that the person chose, in Unicode's form NFC. `cohort` is free
//!   text such as `novice`; empty: not stated. `consent` to a study is `yes`, `no` or `unknown`.
//!   `cohort_unix_s` and `consent_unix_s` give the time of the statement; NULL: there was none, or
//!   an earlier version took it.
//! - `session`: `id` is a UUID of version 7. `metrics` is a JSON object of numbers; a metric
//!   without a value is absent, and only rows of equal `metrics_version` compare. `hand` is
//!   `person` or `scripted`. `realtime` (1 or 0) and `missed_ticks` say how the controller ran;
//!   NULL: unknown. `device` and `driver` name the haptic device; empty: none or unknown. `site` is
//!   the store's site when the session was kept.
//! - `rating`: `rater` is the name that the rater chose; empty: none. `blinded` is 1 if the
//!   rater did not know who operated.
//! - `forgotten_trainee`: no name can be read from it, but whoever has the file can test a guess.
//! - `forgotten_person`: `person` is a UUID of version 5, as in `withdrawal`.
//! - `destination`: `address` has no password. The empty address stands for centres that are named
//!   later; they take over its rows of `withdrawal`, which stay.
//! - `delivery`: `state` is `there`, `differs` (the centre holds another session of this id, which
//!   stays), `forgotten` (the centre forgot this person later) or `left-out` (nothing that such a
//!   centre takes). A new sheet, cohort or consent removes the note.
//! - `withdrawal`: `person` is a UUID of version 5, from which no name can be read, but whoever has
//!   the file can test a guess. `sessions` is a JSON array of ids. The row is deleted with its
//!   withdrawal.
//!
//! `user_version` is [`SCHEMA_VERSION`], `application_id` is "Calo" in ASCII. A store of an older
//! version becomes one of this version when a command writes to it; reading leaves it as it is.

/// Version of the tables.
pub const SCHEMA_VERSION: i64 = 5;
/// Oldest version that this program reads.
pub(crate) const OLDEST_VERSION: i64 = 1;
/// SQLite's application id, "Calo" in ASCII. It marks the file as a store of Calot.
pub(crate) const APPLICATION: i64 = 0x4361_6c6f;

/// SQL that makes the tables that version 1 had, as far as this version kept them.
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
";

/// SQL that adds what version 2 has beyond [`TABLES`].
pub(crate) const SECOND: &str = "
ALTER TABLE trainee ADD COLUMN cohort TEXT NOT NULL DEFAULT '';
ALTER TABLE trainee ADD COLUMN consent TEXT NOT NULL DEFAULT 'unknown'
    CHECK (consent IN ('yes', 'no', 'unknown'));
ALTER TABLE session ADD COLUMN hand TEXT NOT NULL DEFAULT 'person'
    CHECK (hand IN ('person', 'scripted'));
ALTER TABLE session ADD COLUMN realtime INTEGER CHECK (realtime IN (0, 1));
ALTER TABLE session ADD COLUMN missed_ticks INTEGER CHECK (missed_ticks >= 0);
ALTER TABLE session ADD COLUMN device TEXT NOT NULL DEFAULT '';
ALTER TABLE session ADD COLUMN driver TEXT NOT NULL DEFAULT '';
ALTER TABLE session ADD COLUMN site TEXT NOT NULL DEFAULT '';
CREATE TABLE rating (
    session TEXT NOT NULL REFERENCES session ON DELETE CASCADE,
    sheet TEXT NOT NULL,                -- name of the scoring sheet
    rater TEXT NOT NULL,                -- empty: not told
    blinded INTEGER NOT NULL CHECK (blinded IN (0, 1)),
    PRIMARY KEY (session, sheet, rater)
) STRICT;
CREATE TABLE point (
    session TEXT NOT NULL,
    sheet TEXT NOT NULL,
    rater TEXT NOT NULL,
    item TEXT NOT NULL,
    value INTEGER NOT NULL CHECK (value BETWEEN 0 AND 100),
    PRIMARY KEY (session, sheet, rater, item),
    FOREIGN KEY (session, sheet, rater) REFERENCES rating ON DELETE CASCADE
) STRICT;
CREATE TABLE forgotten_trainee (
    mark BLOB PRIMARY KEY NOT NULL,     -- keyed hash of the name
    salt BLOB NOT NULL,                 -- its key
    at_unix_s INTEGER NOT NULL          -- sessions from then on are kept
) STRICT;
CREATE TABLE forgotten_session (
    mark BLOB PRIMARY KEY NOT NULL      -- hash of the session's id
) STRICT;
CREATE TABLE setting (
    name TEXT PRIMARY KEY NOT NULL,
    value TEXT NOT NULL
) STRICT;
";

/// SQL that moves what version 1 kept elsewhere: scripted sessions had a table of their own, and
/// each session had at most one sheet, of GOALS. Late stores of version 1 have the first table.
pub(crate) const FROM_FIRST: &str = "
CREATE TABLE IF NOT EXISTS scripted (session TEXT PRIMARY KEY) STRICT;
UPDATE session SET hand = 'scripted' WHERE id IN (SELECT session FROM scripted);
DROP TABLE scripted;
INSERT INTO rating (session, sheet, rater, blinded)
    SELECT DISTINCT session, 'goals', '', 0 FROM sheet WHERE session IN (SELECT id FROM session);
INSERT INTO point (session, sheet, rater, item, value)
    SELECT session, 'goals', '', item, value FROM sheet WHERE session IN (SELECT id FROM session);
DROP TABLE sheet;
";

/// SQL that adds what version 3 has beyond version 2.
pub(crate) const THIRD: &str = "
CREATE TABLE destination (
    id INTEGER PRIMARY KEY,
    address TEXT NOT NULL UNIQUE        -- without a password
) STRICT;
CREATE TABLE delivery (
    destination INTEGER NOT NULL REFERENCES destination ON DELETE CASCADE,
    session TEXT NOT NULL REFERENCES session ON DELETE CASCADE,
    state TEXT NOT NULL CHECK (state IN ('there', 'differs', 'forgotten', 'left-out')),
    PRIMARY KEY (destination, session)
) STRICT;
CREATE TABLE withdrawal (
    destination INTEGER NOT NULL REFERENCES destination ON DELETE CASCADE,
    person TEXT NOT NULL,               -- UUID of version 5
    at_unix_s INTEGER NOT NULL,         -- sessions from then on stay
    sessions TEXT NOT NULL,             -- JSON: their ids
    PRIMARY KEY (destination, person)
) STRICT;
-- Whoever changes what a centre has of a session, has it sent again.
CREATE TRIGGER rated AFTER INSERT ON point BEGIN
    DELETE FROM delivery WHERE session = NEW.session AND state = 'there';
END;
CREATE TRIGGER enrolled AFTER UPDATE OF cohort, consent ON trainee
WHEN OLD.cohort <> NEW.cohort OR OLD.consent <> NEW.consent BEGIN
    DELETE FROM delivery WHERE state = 'there'
        AND session IN (SELECT id FROM session WHERE trainee = NEW.id);
END;
";

/// SQL that adds what version 4 has beyond version 3. A later statement goes to centres even if its
/// content is the same, because a centre may have received another one in between.
pub(crate) const FOURTH: &str = "
ALTER TABLE trainee ADD COLUMN cohort_unix_s INTEGER;
ALTER TABLE trainee ADD COLUMN consent_unix_s INTEGER;
DROP TRIGGER enrolled;
CREATE TRIGGER enrolled AFTER UPDATE OF cohort, consent, cohort_unix_s, consent_unix_s ON trainee
WHEN OLD.cohort <> NEW.cohort OR OLD.consent <> NEW.consent
    OR OLD.cohort_unix_s IS NOT NEW.cohort_unix_s OR OLD.consent_unix_s IS NOT NEW.consent_unix_s BEGIN
    DELETE FROM delivery WHERE state = 'there'
        AND session IN (SELECT id FROM session WHERE trainee = NEW.id);
END;
";

/// SQL that adds what version 5 has beyond version 4.
pub(crate) const FIFTH: &str = "
CREATE TABLE forgotten_person (
    person TEXT PRIMARY KEY NOT NULL,   -- UUID of version 5
    at_unix_s INTEGER NOT NULL          -- sessions from then on are taken
) STRICT;
";
