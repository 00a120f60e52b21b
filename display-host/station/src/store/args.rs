//! What `calot store` understands.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::{StoreFile, parse_difficulty, parse_task, parse_trainee};

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
It holds a name that each trainee chooses, what sessions came to (`calot run --task T --trainee NAME`),
answers and instructors' sheets; no recordings. Only its user can read the file.

Examples:
  calot store list                          everybody
  calot store list Ada                      her sessions
  calot store add Ada out/SESSION           one that was killed, from its recording
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
    pub(crate) what: What,
}

/// What can be done with a merged store.
const MERGED: &str = "\
The merged file is SQLite, which R, Python and every spreadsheet's database driver open:
  sqlite3 centre.sqlite < scores.sql       with, for example, in scores.sql:

SELECT trainee.name, session.task, count(*) AS sessions, avg(session.score) AS score,
       avg(json_extract(session.metrics, '$.time_s')) AS time_s
FROM session JOIN trainee ON trainee.id = session.trainee
WHERE session.outcome IN ('passed', 'failed')
GROUP BY trainee.name, session.task ORDER BY trainee.name, session.task;

For Parquet, DuckDB makes it of the sessions as CSV:
  calot store export --csv --store centre.sqlite > sessions.csv
  duckdb -c \"COPY (FROM 'sessions.csv') TO 'sessions.parquet'\"

Into PostgreSQL, each column as text:
  psql -c \"CREATE TABLE session ($(head -1 sessions.csv | sed 's/,/ text, /g') text)\"
  psql -c \"\\copy session FROM 'sessions.csv' CSV HEADER\"";

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum What {
    /// Everybody, or the sessions of one
    List {
        /// Whose sessions
        name: Option<String>,
        /// One JSON object on standard output
        #[arg(long)]
        json: bool,
    },
    /// Takes sessions in afterwards, assessed from their recordings: of a run that was killed, that
    /// did not name its trainee, or that the store refused. One that breaks off before its task was
    /// decided is kept as cut-short and counts in no curve. A session that is there already stays
    /// as it is
    Add {
        /// Whose they are: no recording says
        #[arg(value_parser = parse_trainee)]
        name: String,
        /// Recordings, or folders of `calot run --out DIR`
        #[arg(value_name = "SESSION", required = true)]
        sessions: Vec<PathBuf>,
        /// One JSON object a session that was added, on standard output
        #[arg(long)]
        json: bool,
    },
    /// All that is kept, of everybody or of one, on standard output: JSON
    Export {
        /// Of whom
        name: Option<String>,
        /// Sessions as CSV instead, metrics as columns
        #[arg(long)]
        csv: bool,
    },
    /// Adds all that other stations' stores hold; again changes nothing. The same name is the same
    /// person; sessions have names that no two stations give. Who was forgotten here and is there
    /// comes back
    #[command(after_help = MERGED)]
    Merge {
        /// The other stores, which are only read
        #[arg(value_name = "STORE", required = true)]
        others: Vec<PathBuf>,
        /// One JSON object a store on standard output
        #[arg(long)]
        json: bool,
    },
    /// Forgets somebody: name, sessions, answers and sheets are overwritten. Recordings stay where
    /// they are; it says where
    Forget {
        /// Whom
        name: String,
    },
    /// A learning curve, session by session, with the pass rule: SVG. Sessions that were aborted or
    /// were practice do not count
    Curve {
        /// Whose
        name: String,
        /// Of which task
        #[arg(long, value_name = "TASK", value_parser = parse_task)]
        task: assess::Task,
        /// At which difficulty [default: that of the newest session]
        #[arg(long, value_name = "HOW", value_parser = parse_difficulty)]
        difficulty: Option<assess::Difficulty>,
        /// `score`, or a metric (`calot report --metrics`)
        #[arg(long, value_name = "METRIC", default_value = "score", value_parser = parse_metric)]
        metric: String,
        /// Where it goes
        #[arg(long, value_name = "FILE", default_value = "curve.svg")]
        out: PathBuf,
    },
    /// An instructor's points for a session, 1 to 5 each: depth perception, bimanual dexterity,
    /// efficiency, tissue handling, autonomy (GOALS)
    Sheet {
        /// The session, as `list NAME` names it
        session: String,
        /// The five points
        #[arg(num_args = 5, value_parser = clap::value_parser!(u8).range(1..=5))]
        points: Vec<u8>,
    },
    /// Asks a questionnaire in the terminal
    Ask {
        /// Whom
        name: String,
        /// Another questionnaire (TOML) [default: the paper's fourteen items]
        #[arg(long, value_name = "FILE")]
        questionnaire: Option<PathBuf>,
        /// The answers, 1 to 5 each, instead of asking: 3,4,2,…
        #[arg(long, value_name = "N,N,…", value_delimiter = ',')]
        answers: Vec<u8>,
    },
    /// What everybody answered: mean and standard deviation, beside the paper's
    Answers {
        /// Another questionnaire (TOML) [default: the paper's fourteen items]
        #[arg(long, value_name = "FILE")]
        questionnaire: Option<PathBuf>,
        /// One JSON object on standard output
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
