//! Start and end of the process's threads. A panic becomes an error with its message.

use std::any::Any;
use std::thread::{Builder, JoinHandle};

use crate::error::RtError;

/// Stack of the tick's thread, bytes. Building a simulation's state puts two copies of 4 MB there;
/// the tick itself needs far less.
pub(crate) const TICK_STACK_BYTES: usize = 16 << 20;

pub(crate) fn spawn(
    thread: &'static str,
    stack_bytes: usize,
    body: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, RtError> {
    Builder::new()
        .name(format!("calot-{thread}"))
        .stack_size(stack_bytes)
        .spawn(body)
        .map_err(|source| RtError::Thread { thread, source })
}

pub(crate) fn join(thread: &'static str, handle: JoinHandle<()>) -> Result<(), RtError> {
    handle.join().map_err(|panic| RtError::Panicked {
        thread,
        message: panic_message(&*panic),
    })
}

/// Error for a thread that ended before it reported anything: it panicked.
pub(crate) fn ended_without_report(thread: &'static str, handle: JoinHandle<()>) -> RtError {
    let silent = RtError::Panicked {
        thread,
        message: "ended before it reported anything".to_owned(),
    };
    join(thread, handle).err().unwrap_or(silent)
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}
