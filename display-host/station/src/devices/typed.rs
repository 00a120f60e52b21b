//! Lines that a person types, without waiting for them.

use std::io::BufRead as _;
use std::sync::mpsc::{Receiver, sync_channel};

/// Reads lines from standard input in a thread of its own. The channel closes at the input's end.
pub(super) fn typed_lines() -> Receiver<String> {
    // One pending line is enough; further lines are dropped until it is read.
    let (sender, lines) = sync_channel(1);
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { return };
            let _ = sender.try_send(line);
        }
    });
    lines
}
