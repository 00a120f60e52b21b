//! The server of the screen (X or Wayland): checks that there is one, and notices its end.
#![allow(unsafe_code)] // Xlib

use std::env::var_os;
use std::ffi::c_int;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::ptr::null;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use x11_dl::xlib::{Display, Xlib};

use crate::DisplayError;

/// True once the connection to the X server has broken.
static LOST: AtomicBool = AtomicBool::new(false);

/// Checks that a window can be opened: the server that DISPLAY or WAYLAND_DISPLAY names answers.
///
/// # Errors
/// No server is named, the named one does not answer, or the library of X is missing.
pub fn answers() -> Result<(), DisplayError> {
    let named = |name| var_os(name).filter(|it| !it.is_empty());
    let refuse = |detail: String| Err(DisplayError::NoWindow { detail });
    // The order of the variables is winit's. WAYLAND_SOCKET is an open connection.
    if named("WAYLAND_SOCKET").is_some() {
        return Ok(());
    }
    if let Some(name) = named("WAYLAND_DISPLAY") {
        let folder = PathBuf::from(named("XDG_RUNTIME_DIR").unwrap_or_default());
        let socket = folder.join(&name);
        return match UnixStream::connect(&socket) {
            Ok(_) => Ok(()),
            Err(error) => refuse(format!(
                "the Wayland server of WAYLAND_DISPLAY={} does not answer at {} ({error})",
                name.display(),
                socket.display()
            )),
        };
    }
    let Some(name) = named("DISPLAY") else {
        return refuse("there is no screen: neither DISPLAY nor WAYLAND_DISPLAY is set".to_owned());
    };
    let Ok(xlib) = Xlib::open() else {
        return refuse(
            "the library libX11.so.6 is missing: `sudo apt-get install libx11-6`".into(),
        );
    };
    // SAFETY: a null name stands for DISPLAY. The connection is closed once, and not used again.
    let is_there = unsafe {
        let display = (xlib.XOpenDisplay)(null());
        if !display.is_null() {
            (xlib.XCloseDisplay)(display);
        }
        !display.is_null()
    };
    match is_there {
        true => Ok(()),
        false => refuse(format!(
            "the X server of DISPLAY={} does not answer, or refuses this user",
            name.display()
        )),
    }
}

/// Keeps Xlib from ending the process when the X server ends. See [`is_lost`].
pub(super) fn survive_its_loss() {
    // Without the library no connection can break.
    if let Ok(xlib) = Xlib::open() {
        // SAFETY: Xlib keeps the pointer of a function that lives as long as the process.
        unsafe { (xlib.XSetIOErrorHandler)(Some(wait_for_ever)) };
    }
}

/// True once the connection to the X server has broken. The thread that noticed this stays blocked.
pub(super) fn is_lost() -> bool {
    LOST.load(Relaxed)
}

/// Called by Xlib when its server ends. Xlib would end the process if this returned.
extern "C" fn wait_for_ever(_: *mut Display) -> c_int {
    LOST.store(true, Relaxed);
    loop {
        std::thread::park();
    }
}
