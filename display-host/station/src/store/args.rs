//! Options of `calot store`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use store::Consent;

use super::name::TraineeName;
use super::study::StudyArgs;
use crate::args::{NewRater, NewTrainee, StoreFile, parse_difficulty, parse_task, parse_trainee};
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The store holds a name that each trainee chooses, results of sessions (`calot run --task T --trainee NAME`),
answers and instructors' sheets. It holds no recordings. Only its user can read the file.

Examples:
  calot store list                          all trainees
  calot store list Ada                      her sessions
  calot store progress Ada                  what she is proficient in, and what comes next
  calot store curriculum > own.toml         a copy of the curriculum, to change
  calot store add Ada out/SESSION           the session of a killed run
  calot store curve Ada --task clamp --out ada.svg
  calot store trainee Ada --cohort novice --consent yes
  calot store sheet SESSION 4 3 4 5 3       an instructor's GOALS points
  calot store sheet SESSION --sheet cvs --rater Bo --blinded
  calot store ask Ada                       the questionnaire
  calot store export Ada --csv > ada.csv
  calot store export --csv > sessions.csv
  calot store study --by cohort --out study
  calot store forget Ada
  calot store merge theatre-1.sqlite theatre-2.sqlite --store centre.sqlite
  calot store push --to postgres://station@centre.example/calot
  calot store rescore recordings --rules strict.toml > rescored.csv

The file is SQLite. Its tables: trainee (name, cohort, consent), session (task, score, metrics as JSON, hand,
realtime, missed_ticks, device, driver, site, …), answer, rating and point (scoring sheets), setting, and marks
of forgotten trainees; destination, delivery and withdrawal record what a centre has. Reading never changes the file.
A store of an older version becomes one of version 4 with the first command that writes to it.")]
pub(crate) struct StoreArgs {
    #[command(flatten)]
    pub(crate) file: StoreFile,
    #[command(subcommand)]
    pub(crate) command: StoreCommand,
}

/// Help after the options of `calot store merge`: queries on the merged store.
const MERGED: &str = "\
The merged file is SQLite, which R, Python and every spreadsheet's database driver open:
  sqlite3 centre.sqlite < scores.sql       with, for example, in scores.sql:

SELECT trainee.name, session.task, count(*) AS sessions, avg(session.score) AS score,
       avg(json_extract(session.metrics, '$.time_s')) AS time_s
FROM session JOIN trainee ON trainee.id = session.trainee
WHERE session.outcome IN ('passed', 'failed') AND session.hand = 'person'
GROUP BY trainee.name, session.task ORDER BY trainee.name, session.task;

DuckDB turns the sessions from CSV into Parquet:
  calot store export --csv --store centre.sqlite > sessions.csv
  duckdb -c \"COPY (FROM 'sessions.csv') TO 'sessions.parquet'\"

PostgreSQL takes them with each column as text:
  psql -c \"CREATE TABLE session ($(head -1 sessions.csv | sed 's/,/ text, /g') text)\"
  psql -c \"\\copy session FROM 'sessions.csv' CSV HEADER\"";

/// Help after the options of `calot store push`.
const PUSH: &str = "\
Examples:
  PGPASSWORD=… calot store push --to postgres://station@centre.example/calot
  calot store push --to-file ~/.config/calot/centre       its first line is the address with the password
  CALOT_LRS_USER=… CALOT_LRS_PASSWORD=… calot store push --to https://lrs.example/xapi
  */10 * * * *  calot store push --to-file ~/.config/calot/centre      in crontab: every ten minutes

PostgreSQL: the first push makes the schema `calot` with trainee, session, point, forgotten and setting, so the user of that
push must own the database or have the right CREATE. Later, stations need USAGE on the schema, and SELECT, INSERT, UPDATE
and DELETE on its tables. The connection is encrypted, unless the server is on this computer or the address says
sslmode=disable.

xAPI: no statement has a name. Its actor is a UUID that each station derives from the name, because equal names are
one person; `calot store trainee NAME` prints it. Whoever has it can test if a guessed name is the right one. Sessions of scripted
hands are left out. A record store never deletes: it voids the statements of forgotten trainees.

Exit code 1: results still wait in the store, or the centre refused them.";

/// Help after the options of `calot store rescore`.
const RESCORE: &str = "\
Examples:
  calot report --rules-file > strict.toml           a copy of the rules, to change
  calot store rescore recordings --rules strict.toml --store centre.sqlite > rescored.csv
  calot store rescore monday tuesday/session.mcap   by each session's own rules, with this program's metrics

Folders are searched with all folders in them for recordings (.mcap). If a recording cannot be read, the last
column has the reason, and the exit code is 1. Each thread scores one recording at a time, so the time falls
with the number of cores.";

/// Help after the options of `calot store sheet`: the form of a sheet in a file.
const SHEETS: &str = "\
A scoring sheet as a file:
  name = \"knots\"
  title = \"Knot tying\"
  least = 1
  most = 5
  [[item]]
  id = \"tension\"
  text = \"Tension of the thread\"
  anchors = { 1 = \"loose or torn\", 5 = \"even\" }";

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum StoreCommand {
    /// Lists all trainees, or the sessions of one
    List {
        /// Trainee whose sessions to list; a name of several words needs no quotes [default: list
        /// the trainees]
        name: Vec<String>,
        /// Print one JSON object on standard output
        #[arg(long)]
        json: bool,
    },
    /// Shows a trainee's progress in the curriculum, and the task that comes next
    Progress {
        #[command(flatten)]
        name: TraineeName,
        /// Curriculum (TOML) [default: the built-in one]
        #[arg(long, value_name = "FILE")]
        curriculum: Option<PathBuf>,
        /// Print one JSON object on standard output
        #[arg(long)]
        json: bool,
    },
    /// Writes a trainee's certificate of the levels that are complete, as a page to print
    Certificate {
        #[command(flatten)]
        name: TraineeName,
        /// Curriculum (TOML) [default: the built-in one]
        #[arg(long, value_name = "FILE")]
        curriculum: Option<PathBuf>,
        /// File for the page [default: certificate.html]
        #[arg(long, value_name = "FILE.html")]
        out: Option<PathBuf>,
        #[command(flatten)]
        overwrite: Overwrite,
    },
    /// Prints the built-in curriculum, to copy and change
    Curriculum,
    /// Adds sessions from their recordings, and assesses them. This is for runs that were killed,
    /// that named no trainee, or that the store refused. A session that breaks off before its task
    /// was decided is kept as cut-short and counts in no curve. A session already in the store
    /// stays unchanged
    Add {
        /// Trainee to add them to; a recording does not name one
        #[arg(value_parser = parse_trainee)]
        name: String,
        /// Recordings (.mcap), folders of `calot run --out DIR`, or names of kept sessions
        #[arg(value_name = "SESSION", required = true)]
        sessions: Vec<PathBuf>,
        #[command(flatten)]
        new: NewTrainee,
        /// Print one JSON object per added session on standard output
        #[arg(long)]
        json: bool,
    },
    /// Prints everything stored about all trainees or one, as JSON
    Export {
        /// Trainee to export [default: all]
        name: Option<String>,
        /// Print a table as CSV instead: sessions (one a row, with every metric and the means of
        /// GOALS as columns), answers (one answer to a questionnaire a row), or sheets (one item of
        /// a scoring sheet a row). A table has the same columns whatever is in the store; `trainee`
        /// and `session` join them. An apostrophe goes before a text that begins with =, +, - or
        /// @, so that a spreadsheet does not take it for a formula
        #[arg(long, value_name = "TABLE", value_enum, num_args = 0..=1, require_equals = true,
            default_missing_value = "sessions")]
        csv: Option<Table>,
    },
    /// Sets a trainee's cohort and consent for studies, and adds the trainee if the name is new;
    /// without options, prints them
    Trainee {
        #[command(flatten)]
        name: TraineeName,
        /// Cohort, free text, e.g. novice; "" for none
        #[arg(long, value_name = "TEXT")]
        cohort: Option<String>,
        /// Consent to studies: yes, no or unknown. `calot store study` leaves out trainees who
        /// refused
        #[arg(long, value_name = "WHETHER", value_parser = parse_consent)]
        consent: Option<Consent>,
        #[command(flatten)]
        new: NewTrainee,
    },
    /// Names the site of the sessions that are kept from now on; without a name, prints it
    Site {
        /// Site, e.g. theatre-1
        name: Option<String>,
    },
    /// Adds the contents of other stations' stores. Repeating it changes nothing. Equal names mean
    /// the same person; session names differ between stations. A trainee who was forgotten in one
    /// of the stores stays out; sessions that began later are added
    #[command(after_help = MERGED)]
    Merge {
        /// Stores to read, e.g. theatre-1.sqlite; they stay unchanged
        #[arg(value_name = "STORE", required = true)]
        others: Vec<PathBuf>,
        /// Print one JSON object per store on standard output
        #[arg(long)]
        json: bool,
    },
    /// Sends results to a centre: into PostgreSQL, or as xAPI 2.0 statements to a learning record
    /// store. Results that do not arrive wait in the store for the next push. Repeating it sends
    /// nothing twice, however the last push ended. The centre also forgets forgotten trainees
    #[command(after_help = PUSH)]
    Push(PushArgs),
    /// Forgets a trainee: overwrites name, sessions, answers and sheets. Recordings stay on disk;
    /// the command lists them. A centre that has results learns of it by the next `calot store
    /// push`. Marks remain, which show no name, so that a merge brings nothing of it back. To come
    /// back, the trainee works a new session under any name
    Forget {
        #[command(flatten)]
        name: TraineeName,
    },
    /// Scores recordings again, many at once, and prints a table as CSV: outcome and score in the
    /// store and by these rules, and every metric. The store stays as it is, because a session
    /// keeps the rules that it was assessed by
    #[command(after_help = RESCORE)]
    Rescore(RescoreArgs),
    /// Draws a learning curve as SVG: each session, and the pass rule. Aborted sessions and
    /// practice do not count
    Curve {
        #[command(flatten)]
        name: TraineeName,
        /// Task, e.g. clamp
        #[arg(long, value_name = "TASK", value_parser = parse_task)]
        task: assess::Task,
        /// Difficulty [default: that of the newest session]
        #[arg(long, value_name = "HOW", value_parser = parse_difficulty)]
        difficulty: Option<assess::Difficulty>,
        /// `score`, or a metric that `calot report --metrics` names, e.g. time_s
        #[arg(long, value_name = "METRIC", default_value = "score", value_parser = parse_metric)]
        metric: String,
        /// File for the curve [default: curve.svg, or curve-2.svg, curve-3.svg, … if it is there]
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        #[command(flatten)]
        overwrite: Overwrite,
    },
    /// Stores a rater's points for a session, on a scoring sheet. Without points, asks for each
    /// item and shows its anchors; without a session, prints the sheets with their anchors
    #[command(after_help = SHEETS)]
    Sheet {
        /// Session id, as `calot store list NAME` prints it
        session: Option<String>,
        /// Points, one for each item; for GOALS e.g. 4 3 4 5 3
        points: Vec<u8>,
        /// Sheet: goals (Vassiliou 2005), osats (Martin 1997), cvs (critical view of safety,
        /// Sanford and Strasberg 2014), or a file (TOML)
        #[arg(long, value_name = "NAME|FILE", default_value = "goals")]
        sheet: String,
        /// Rater's name, as chosen. Each rater has one sheet of a kind for each session; a second
        /// one is refused, unless --replace is given
        #[arg(
            long,
            value_name = "NAME",
            default_value = "",
            hide_default_value = true
        )]
        rater: String,
        #[command(flatten)]
        new: NewRater,
        /// The rater did not know who operated
        #[arg(long)]
        blinded: bool,
        /// Replace the sheet of this kind that the rater filled for this session before
        #[arg(long)]
        replace: bool,
        /// Print as JSON: the sheets of the session, or without a session the forms
        #[arg(long, conflicts_with = "points")]
        json: bool,
    },
    /// Compares groups of trainees: writes study.csv (a row for each person and task) and
    /// study.html (medians and quartiles, tests, learning, agreement of raters). Both have
    /// numbers instead of names. Sessions of scripted hands, and those that were not realtime, are
    /// left out
    Study(StudyArgs),
    /// Asks a questionnaire in the terminal
    Ask {
        /// Trainee
        name: String,
        /// Questionnaire (TOML) [default: the paper's fourteen items]
        #[arg(long, value_name = "FILE")]
        questionnaire: Option<PathBuf>,
        /// Answers, 1 to 5 each, or 0 if the item does not apply, instead of asking, e.g. 3,4,0,…
        #[arg(long, value_name = "N,N,…", value_delimiter = ',')]
        answers: Vec<u8>,
        #[command(flatten)]
        new: NewTrainee,
    },
    /// Prints mean and standard deviation of all answers, next to the paper's
    Answers {
        /// Questionnaire (TOML) [default: the paper's fourteen items]
        #[arg(long, value_name = "FILE")]
        questionnaire: Option<PathBuf>,
        /// Print one JSON object on standard output
        #[arg(long)]
        json: bool,
    },
}

/// Options of `calot store push`.
#[derive(Debug, Clone, Args)]
pub(crate) struct PushArgs {
    /// Centre: postgres://USER@HOST:PORT/DATABASE, or the address above /statements of a learning
    /// record store. A password goes into PGPASSWORD, or into CALOT_LRS_USER and
    /// CALOT_LRS_PASSWORD
    #[arg(long, value_name = "ADDRESS", required_unless_present = "to_file")]
    pub(crate) to: Option<String>,
    /// File of mode 600 whose first line is the centre's address with its password
    #[arg(long, value_name = "FILE", conflicts_with = "to")]
    pub(crate) to_file: Option<PathBuf>,
    /// Authority that signed the centre's certificate (PEM) [default: those that this computer
    /// trusts]
    #[arg(long, value_name = "FILE")]
    pub(crate) ca: Option<PathBuf>,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options of `calot store rescore`.
#[derive(Debug, Clone, Args)]
pub(crate) struct RescoreArgs {
    /// Recordings (.mcap), and folders to search for them
    #[arg(value_name = "RECORDING", required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Score by these rules (TOML) instead of those of each session
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Recordings that are scored at once [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<std::num::NonZeroUsize>,
}

/// A table to export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Table {
    /// One session a row
    Sessions,
    /// One answer a row
    Answers,
    /// One item of a scoring sheet a row
    Sheets,
}

/// A name of several words, or `None` if none was typed.
pub(crate) fn joined(words: &[String]) -> Option<String> {
    (!words.is_empty()).then(|| words.join(" "))
}

fn parse_consent(text: &str) -> Result<Consent, String> {
    Consent::from_name(text).ok_or_else(|| "yes, no or unknown".to_owned())
}

fn parse_metric(text: &str) -> Result<String, String> {
    match text == "score" || assess::Metric::from_name(text).is_some() {
        true => Ok(text.to_owned()),
        false => Err("`score`, or a metric that `calot report --metrics` names".into()),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_help_shows_the_query_that_is_tested() {
        assert!(super::MERGED.contains(store::EXAMPLE_SQL));
    }
}
