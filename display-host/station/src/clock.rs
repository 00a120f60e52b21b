//! Time of day.

use std::time::{SystemTime, UNIX_EPOCH};

/// Current time, s since 1970.
pub(crate) fn now_unix_s() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| now.as_secs() as i64)
}
