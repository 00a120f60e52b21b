//! The centre's log: who came in, who watched which station and when, what went wrong. A JSON
//! object a line, appended and never changed.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use crate::error::CentreError;

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

    /// Notes what happened. `who` and `station` may be empty. A disk that takes no more is told on
    /// standard error.
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
        let said = Log::open(folder.path()).unwrap_err().to_string();
        assert!(said.contains("Is a directory"), "{said}");
    }
}
