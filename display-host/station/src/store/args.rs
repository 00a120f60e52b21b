//! Options of `calot store`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::{StoreFile, parse_difficulty, parse_task, parse_trainee};
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The store holds a name that each trainee chooses, results of sessions (`calot run --task T --trainee NAME`),
answers and instructors' sheets, but no recordings. Only its user can read the file.

Examples:
  calot store list                          all trainees
  calot store list Ada                      her sessions
  calot store add Ada out/SESSION           a killed run, from its recording
  calot store curve Ada --task clamp --out ada.svg
  calot store sheet SESSION 4 3 4 5 3       an instructor's GOALS points
  calot store ask Ada                       the questionnaire
  calot store export Ada --csv > ada.csv
  calot store forget Ada
  calot store merge theatre-1.sqlite theatre-2.sqlite --store centre.sqlite")]
pub(crate) struct StoreArgs {
    #[command(flatten)]
    pub(crate) file: StoreFile,
    #[command(subcommand)]
    pub(crate) command: StoreCommand,
}

/// Examples of queries on a merged store.
const MERGED: &str = "\
The merged file is SQLite, which R, Python and every spreadsheet's database driver open:
  sqlite3 centre.sqlite < scores.sql       with, for example, in scores.sql:

SELECT trainee.name, session.task, count(*) AS sessions, avg(session.score) AS score,
       avg(json_extract(session.metrics, '$.time_s')) AS time_s
FROM session JOIN trainee ON trainee.id = session.trainee
WHERE session.outcome IN ('passed', 'failed')
  AND session.id NOT IN (SELECT session FROM scripted)
GROUP BY trainee.name, session.task ORDER BY trainee.name, session.task;

For Parquet, DuckDB makes it of the sessions as CSV:
  calot store export --csv --store centre.sqlite > sessions.csv
  duckdb -c \"COPY (FROM 'sessions.csv') TO 'sessions.parquet'\"

Into PostgreSQL, each column as text:
  psql -c \"CREATE TABLE session ($(head -1 sessions.csv | sed 's/,/ text, /g') text)\"
  psql -c \"\\copy session FROM 'sessions.csv' CSV HEADER\"";

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum StoreCommand {
    /// Lists all trainees, or the sessions of one
    List {
        /// Trainee whose sessions to list [default: list the trainees]
        name: Option<String>,
        /// Print one JSON object on standard output
        #[arg(long)]
        json: bool,
    },
    /// Adds sessions afterwards and assesses them from their recordings: those of a run that was
    /// killed, that named no trainee, or that the store refused. A session that breaks off before
    /// its task was decided is kept as cut-short and counts in no curve. A session already in the
    /// store stays unchanged
    Add {
        /// Trainee to add them to; a recording does not name one
        #[arg(value_parser = parse_trainee)]
        name: String,
        /// Recordings (.mcap), or folders of `calot run --out DIR`
        #[arg(value_name = "SESSION", required = true)]
        sessions: Vec<PathBuf>,
        /// Print one JSON object per added session on standard output
        #[arg(long)]
        json: bool,
    },
    /// Prints everything stored about all trainees or one, as JSON
    Export {
        /// Trainee to export [default: all]
        name: Option<String>,
        /// Print the sessions as CSV instead, with metrics as columns
        #[arg(long)]
        csv: bool,
    },
    /// Adds the contents of other stations' stores. Repeating it changes nothing. Equal names mean
    /// the same person; session names differ between stations. A trainee who was forgotten here but
    /// is in another store comes back
    #[command(after_help = MERGED)]
    Merge {
        /// Stores to read, e.g. theatre-1.sqlite; they stay unchanged
        #[arg(value_name = "STORE", required = true)]
        others: Vec<PathBuf>,
        /// Print one JSON object per store on standard output
        #[arg(long)]
        json: bool,
    },
    /// Forgets a trainee: overwrites name, sessions, answers and sheets. Recordings stay on disk;
    /// the command lists them
    Forget {
        /// Trainee
        name: String,
    },
    /// Draws a learning curve as SVG: each session, and the pass rule. Aborted sessions and
    /// practice do not count
    Curve {
        /// Trainee
        name: String,
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
    /// Stores an instructor's five GOALS points for a session, 1 to 5 each: depth perception,
    /// bimanual dexterity, efficiency, tissue handling, autonomy
    Sheet {
        /// Session id, as `calot store list NAME` prints it
        session: String,
        /// Five points, e.g. 4 3 4 5 3
        #[arg(num_args = 5, value_parser = clap::value_parser!(u8).range(1..=5))]
        points: Vec<u8>,
    },
    /// Asks a questionnaire in the terminal
    Ask {
        /// Trainee
        name: String,
        /// Questionnaire (TOML) [default: the paper's fourteen items]
        #[arg(long, value_name = "FILE")]
        questionnaire: Option<PathBuf>,
        /// Answers, 1 to 5 each, instead of asking, e.g. 3,4,2,…
        #[arg(long, value_name = "N,N,…", value_delimiter = ',')]
        answers: Vec<u8>,
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
