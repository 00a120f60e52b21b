//! Prints a message when a vendor's library ends the whole process.
#![allow(unsafe_code)] // The C library's list of functions to call when the process ends.

use std::cell::Cell;
use std::ffi::c_int;
use std::io::Write as _;
use std::sync::{Mutex, Once, PoisonError};

unsafe extern "C" {
    /// The C library's list of functions to call when the process ends.
    safe fn atexit(call: extern "C" fn()) -> c_int;
    /// Ends the process without calling the functions on that list.
    safe fn _exit(code: c_int) -> !;
}

thread_local! {
    /// True while this thread opens a device through the library.
    static IN_LIBRARY: Cell<bool> = const { Cell::new(false) };
}
/// Path of the library that was opened last, for the message.
static OPENED: Mutex<String> = Mutex::new(String::new());

/// Calls `open`, which calls the library. Some libraries end the whole process in this call. They
/// print no message, and their exit code means something else to Calot's caller. In that case this
/// function's exit handler prints the reason and ends the process with code 1.
pub(super) fn guarded<T>(library: &str, open: impl FnOnce() -> T) -> T {
    static REGISTERED: Once = Once::new();
    // If the list is full, only the message is missing.
    REGISTERED.call_once(|| {
        let _ = atexit(report_exit);
    });
    library.clone_into(&mut OPENED.lock().unwrap_or_else(PoisonError::into_inner));
    IN_LIBRARY.set(true);
    let opened = open();
    IN_LIBRARY.set(false);
    opened
}

extern "C" fn report_exit() {
    // Runs on the thread that ended the process. If no library was being opened on that thread, the
    // process ended as intended.
    if IN_LIBRARY.try_with(Cell::get) != Ok(true) {
        return;
    }
    let library = OPENED.try_lock();
    let library = library.as_ref().map_or("a library", |path| path.as_str());
    let _ = writeln!(
        std::io::stderr(),
        "calot: {library}: the vendor's library ended the program while it opened the device. Run the \
         vendor's own diagnosis, which shows why (often the licence, a configuration file or a missing permission)"
    );
    _exit(1);
}
