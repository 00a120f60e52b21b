//! Enter on standard input.

use std::io::BufRead as _;
use std::sync::mpsc::{Receiver, sync_channel};

/// Reads Enter from standard input in a thread of its own.
pub(super) fn enter_keys() -> Receiver<()> {
    // One pending key is enough.
    let (sender, keys) = sync_channel(1);
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            if line.is_err() {
                return;
            }
            let _ = sender.try_send(());
        }
    });
    keys
}
