//! Tables of a centre in PostgreSQL, in the schema `calot`.
//!
//! | table | a row is |
//! |---|---|
//! | `trainee` | a person; `person` is a UUID of version 5 from the name, equal at each station |
//! | `session` | an assessed session, as in a station's store, without the recording's path |
//! | `point` | an item of a rater's scoring sheet for a session |
//! | `forgotten` | a person who was forgotten; sessions that began by then stay out |
//! | `setting` | a setting by name; `version`: the number of [`STEPS`] that were taken |
//!
//! In `trainee`, `cohort_unix_s` and `consent_unix_s` give the time of the statement; NULL:
//! unknown. The later statement counts (`store::Told`). Before step 4 the time was the start of the
//! newest session that came with the statement.

/// Version of the tables that this program needs.
pub(crate) const VERSION: usize = STEPS.len();

/// SQL that makes the tables, step by step. A centre of an older version takes the steps that it
/// lacks.
pub(crate) const STEPS: [&str; 4] = [FIRST, SECOND, THIRD, FOURTH];

const FIRST: &str = "
CREATE SCHEMA calot;
CREATE TABLE calot.setting (
    name text PRIMARY KEY,
    value text NOT NULL
);
CREATE TABLE calot.trainee (
    person uuid PRIMARY KEY,
    name text NOT NULL,
    cohort text NOT NULL,
    consent text NOT NULL CHECK (consent IN ('yes', 'no', 'unknown'))
);
CREATE TABLE calot.session (
    id uuid PRIMARY KEY,
    person uuid NOT NULL REFERENCES calot.trainee ON DELETE CASCADE,
    began_unix_s bigint NOT NULL,
    task text NOT NULL,
    difficulty text NOT NULL,
    outcome text NOT NULL,
    score double precision NOT NULL,
    alarms bigint NOT NULL,
    metrics_version bigint NOT NULL,
    metrics jsonb NOT NULL,
    scene text NOT NULL,
    program text NOT NULL,
    hand text NOT NULL CHECK (hand IN ('person', 'scripted')),
    realtime boolean,
    missed_ticks bigint,
    device text NOT NULL,
    driver text NOT NULL,
    site text NOT NULL,
    arrived timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX session_of ON calot.session (person, began_unix_s);
CREATE TABLE calot.forgotten (
    person uuid PRIMARY KEY,
    at_unix_s bigint NOT NULL
);
";

const SECOND: &str = "
CREATE TABLE calot.point (
    session uuid NOT NULL REFERENCES calot.session ON DELETE CASCADE,
    sheet text NOT NULL,
    rater text NOT NULL,
    blinded boolean NOT NULL,
    item text NOT NULL,
    value integer NOT NULL,
    PRIMARY KEY (session, sheet, rater, item)
);
";

const THIRD: &str = "
ALTER TABLE calot.trainee ADD COLUMN cohort_unix_s bigint, ADD COLUMN consent_unix_s bigint;
";

// A cohort or consent that nobody stated has no time.
const FOURTH: &str = "
UPDATE calot.trainee SET cohort_unix_s = NULL WHERE cohort = '';
UPDATE calot.trainee SET consent_unix_s = NULL WHERE consent = 'unknown';
";

/// Columns of a session, in the order of the values that `INSERT` and `SAME` take.
const COLUMNS: &str = "id, person, began_unix_s, task, difficulty, outcome, score, alarms, metrics_version, metrics, \
    scene, program, hand, realtime, missed_ticks, device, driver, site";
const SLOTS: &str =
    "$1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18";
/// Columns of a session except its site, which may be named later.
const LASTING: &str = "id, person, began_unix_s, task, difficulty, outcome, score, alarms, metrics_version, metrics, \
    scene, program, hand, realtime, missed_ticks, device, driver";

/// Adds a session, if there is none of its id.
pub(crate) fn insert() -> String {
    format!("INSERT INTO calot.session ({COLUMNS}) VALUES ({SLOTS}) ON CONFLICT (id) DO NOTHING")
}

/// Finds a session of exactly these values, whatever its site.
pub(crate) fn same() -> String {
    format!(
        "SELECT EXISTS (SELECT FROM calot.session WHERE ({LASTING}) IS NOT DISTINCT FROM \
         ($1::uuid, $2::uuid, $3::bigint, $4::text, $5::text, $6::text, $7::double precision, $8::bigint, $9::bigint, \
         $10::jsonb, $11::text, $12::text, $13::text, $14::boolean, $15::bigint, $16::text, $17::text))"
    )
}

/// Names the site of a session that has none.
pub(crate) const FILL_SITE: &str =
    "UPDATE calot.session SET site = $2 WHERE id = $1 AND site = '' AND $2 <> ''";

/// Cohort and consent of a person, with the times of the statements.
pub(crate) const KNOWN: &str =
    "SELECT cohort, cohort_unix_s, consent, consent_unix_s FROM calot.trainee WHERE person = $1";

/// Adds a person, or replaces cohort and consent.
pub(crate) const ENROL: &str = "INSERT INTO calot.trainee \
    (person, name, cohort, cohort_unix_s, consent, consent_unix_s) \
    VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (person) DO UPDATE SET \
    cohort = excluded.cohort, cohort_unix_s = excluded.cohort_unix_s, \
    consent = excluded.consent, consent_unix_s = excluded.consent_unix_s";

/// Removes what a person stated before a forgetting.
pub(crate) const PLAIN: &str = "UPDATE calot.trainee SET \
    cohort = CASE WHEN cohort_unix_s > $2 THEN cohort ELSE '' END, \
    consent = CASE WHEN consent_unix_s > $2 THEN consent ELSE 'unknown' END WHERE person = $1";

/// Time of a forgetting, but no later than now: a station's clock may be years ahead.
pub(crate) const CAPPED: &str = "SELECT least($1, extract(epoch FROM clock_timestamp())::bigint)";

/// Removes a rater's sheet, before it is added anew.
pub(crate) const REMOVE_SHEET: &str =
    "DELETE FROM calot.point WHERE session = $1 AND sheet = $2 AND rater = $3";

/// Adds an item of a sheet.
pub(crate) const ADD_POINT: &str = "INSERT INTO calot.point (session, sheet, rater, blinded, item, value) \
    VALUES ($1, $2, $3, $4, $5, $6)";
