//! A modem line of a serial port that is high while a tick runs, or until its force has left. An
//! oscilloscope measures it independently of this machine's clocks.
#![expect(
    unsafe_code,
    reason = "the modem lines' ioctls, which rustix does not have"
)]

use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::PathBuf;

use crate::error::RtError;

/// A modem line that can be driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModemLine {
    /// Request to send.
    Rts,
    /// Data terminal ready.
    Dtr,
}

/// Time at which the line falls again after the beginning of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mark {
    /// The end of the tick.
    #[default]
    Tick,
    /// The departure of the force: its last byte is with the kernel. In a tick that sends no force,
    /// the line falls at the tick's end.
    Force,
}

/// A modem line of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScopeLine {
    /// The port. Nothing else may use it. It must be a real UART: behind USB, each change of a
    /// line takes a transfer of up to milliseconds, in the tick.
    pub tty: PathBuf,
    /// The line.
    pub line: ModemLine,
    /// Time at which the line falls.
    pub mark: Mark,
}

/// Function that sets a line high or low.
pub(crate) type Switch = Box<dyn Fn(bool) + Send>;

/// The line as the tick drives it.
pub(crate) struct Marks {
    pub(crate) set: Switch,
    pub(crate) mark: Mark,
}

impl Marks {
    /// Marks the beginning of a tick.
    pub(crate) fn begin(&self) {
        (self.set)(true);
    }

    /// Marks the force's departure, if asked for.
    pub(crate) fn force_left(&self) {
        if self.mark == Mark::Force {
            (self.set)(false);
        }
    }

    /// Marks the end of a tick. A line that is low stays low.
    pub(crate) fn end(&self) {
        (self.set)(false);
    }
}

/// Function that sets or clears modem bits. It gets the port, `TIOCMBIS` or `TIOCMBIC`, and the
/// bits. It returns false if the kernel refuses.
type SetBits = fn(&File, libc::Ioctl, libc::c_int) -> bool;

/// The open line. It is set low when dropped.
struct OpenLine {
    port: File,
    bit: libc::c_int,
    set_bits: SetBits,
}

impl ScopeLine {
    /// Opens the port and sets the line low; it is set low again when dropped.
    ///
    /// # Errors
    /// [`RtError::ScopeLine`] when the port does not open or has no such line.
    pub(crate) fn open(&self) -> Result<Marks, RtError> {
        let set = self.open_with(set_bits)?;
        Ok(Marks {
            set,
            mark: self.mark,
        })
    }

    fn open_with(&self, set_bits: SetBits) -> Result<Switch, RtError> {
        let failed = |source| RtError::ScopeLine {
            tty: self.tty.clone(),
            source,
        };
        let port = File::options()
            .read(true)
            .write(true)
            .custom_flags(libc::O_NOCTTY | libc::O_NONBLOCK)
            .open(&self.tty)
            .map_err(failed)?;
        let bit = match self.line {
            ModemLine::Rts => libc::TIOCM_RTS,
            ModemLine::Dtr => libc::TIOCM_DTR,
        };
        let line = OpenLine {
            port,
            bit,
            set_bits,
        };
        match line.set(false) {
            true => Ok(Box::new(move |high| {
                // The kernel refuses only when the port is gone. The tick cannot report that to
                // anybody.
                let _ = line.set(high);
            })),
            false => Err(failed(std::io::Error::last_os_error())),
        }
    }
}

impl OpenLine {
    /// Sets the line: one system call, no allocation. Returns false if refused.
    fn set(&self, high: bool) -> bool {
        let request = if high { libc::TIOCMBIS } else { libc::TIOCMBIC };
        (self.set_bits)(&self.port, request, self.bit)
    }
}

/// Sets the bits through the kernel.
fn set_bits(port: &File, request: libc::Ioctl, bits: libc::c_int) -> bool {
    // SAFETY: the descriptor is open; the pointer is to a value that lives through the call.
    unsafe { libc::ioctl(port.as_raw_fd(), request, &raw const bits) == 0 }
}

impl Drop for OpenLine {
    fn drop(&mut self) {
        self.set(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    thread_local! {
        static ASKED: RefCell<Vec<(libc::Ioctl, libc::c_int)>> = const { RefCell::new(Vec::new()) };
    }

    /// Stands for a kernel whose port has both lines: stores each request and grants it.
    fn willing(_port: &File, request: libc::Ioctl, bits: libc::c_int) -> bool {
        ASKED.with_borrow_mut(|asked| asked.push((request, bits)));
        true
    }

    #[test]
    fn each_change_sets_only_the_named_line() {
        for (line, bit) in [
            (ModemLine::Rts, libc::TIOCM_RTS),
            (ModemLine::Dtr, libc::TIOCM_DTR),
        ] {
            ASKED.take();
            let tty = "/dev/null".into();
            let mark = Mark::Tick;
            let scope = ScopeLine { tty, line, mark };
            let switch = scope.open_with(willing).unwrap();
            for _tick in 0..2 {
                switch(true);
                switch(false);
            }
            drop(switch);
            let [up, down] = [(libc::TIOCMBIS, bit), (libc::TIOCMBIC, bit)];
            // Low at first, high and low in each tick, low at the end.
            assert_eq!(ASKED.take(), [down, up, down, up, down, down]);
        }
    }

    #[test]
    fn device_without_such_a_line_is_named() {
        for tty in ["/dev/null", "/nowhere/ttyS0"] {
            for line in [ModemLine::Rts, ModemLine::Dtr] {
                let scope = ScopeLine {
                    tty: tty.into(),
                    line,
                    mark: Mark::Force,
                };
                let error = scope.open().err().unwrap().to_string();
                assert!(error.contains(tty) && error.contains("UART"), "{error}");
            }
        }
    }
}
