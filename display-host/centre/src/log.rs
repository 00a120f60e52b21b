//! The centre's log: who logged in, who watched which station and when, what went wrong. Each line
//! is a JSON object. Lines are appended and never changed.

use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Seek as _, SeekFrom, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::error::CentreError;
use crate::state::Heard;

/// Alarms in the log.
pub const ALARM: &str = "alarm";
/// Number of bytes at the end of the log that are searched for alarms. It bounds the time in which
/// a centre starts.
const READ_BACK: u64 = 4_000_000;

/// The log.
#[derive(Debug)]
pub struct Log(Mutex<File>);

impl Log {
    /// Opens the log, which is made if it is missing.
    ///
    /// # Errors
    /// [`CentreError::File`].
    pub fn open(path: &Path) -> Result<Self, CentreError> {
        let mut options = OpenOptions::new();
        options.create(true).append(true).mode(0o600);
        let file = options.open(path).map_err(|error| CentreError::File {
            path: path.to_owned(),
            problem: error.to_string(),
        })?;
        Ok(Self(Mutex::new(file)))
    }

    /// Alarms that a log has at its end, with their stations, the oldest first. A missing log has
    /// none.
    #[must_use]
    pub fn alarms(path: &Path) -> Vec<(String, Heard)> {
        let Ok(mut file) = File::open(path) else {
            return Vec::new();
        };
        let length = file.metadata().map_or(0, |it| it.len());
        let from = SeekFrom::Start(length.saturating_sub(READ_BACK));
        if file.seek(from).is_err() {
            return Vec::new();
        }
        // The first line may be incomplete, and a kill may have left another incomplete line.
        let lines = BufReader::new(file).split(b'\n').map_while(Result::ok);
        let lines = lines.filter_map(|it| serde_json::from_slice::<Value>(&it).ok());
        let alarms = lines.filter(|it| it["what"] == ALARM);
        let alarms = alarms.filter_map(|it| {
            let heard = serde_json::from_value(it["detail"].clone()).ok()?;
            Some((it["station"].as_str()?.to_owned(), heard))
        });
        alarms.collect()
    }

    /// Appends an entry. `who` and `station` may be empty. If the disk refuses it, a message on
    /// standard error says so.
    pub fn note(&self, what: &str, who: &str, station: &str, detail: &Value) {
        let mut line = json!({"at_unix_ms": now_ms(), "what": what});
        for (key, value) in [("who", who), ("station", station)] {
            if !value.is_empty() {
                line[key] = value.into();
            }
        }
        if !detail.is_null() {
            line["detail"] = detail.clone();
        }
        let mut file = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Err(error) = writeln!(file, "{line}") {
            eprintln!("calot-centre: the log takes nothing: {error}: {line}");
        }
    }
}

/// Time now, ms since 1970.
#[must_use]
pub fn now_ms() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    u64::try_from(now.unwrap_or_default().as_millis()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_is_appended_and_for_its_user_alone() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        for who in ["bo", ""] {
            let log = Log::open(&path).unwrap();
            log.note("watch", who, "left", &json!({"seconds": 3}));
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<Value> = text
            .lines()
            .map(|it| serde_json::from_str(it).unwrap())
            .collect();
        assert_eq!(
            (&lines[0]["who"], &lines[0]["station"]),
            (&json!("bo"), &json!("left"))
        );
        assert_eq!((lines.len(), &lines[1]["who"]), (2, &Value::Null));
        let mode = std::fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        assert_eq!(Log::alarms(&path), []);
        let said = Log::open(folder.path()).unwrap_err().to_string();
        assert!(said.contains("Is a directory"), "{said}");
    }

    #[test]
    fn alarms_are_read_back_past_pieces_of_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log");
        assert_eq!(Log::alarms(&path), [], "there is none yet");
        std::fs::write(&path, b"alf a line\xff\n{\"what\": \"alarm\"}\n").unwrap();
        let alarm = crate::state::tests::state(7, 1).newest_alarms.remove(0);
        let heard = Heard {
            at_unix_ms: 1,
            operation: 7,
            trainee: Some("Kim".to_owned()),
            alarm,
        };
        let log = Log::open(&path).unwrap();
        log.note(ALARM, "", "left", &serde_json::to_value(&heard).unwrap());
        assert_eq!(Log::alarms(&path), [("left".to_owned(), heard)]);
    }
}
