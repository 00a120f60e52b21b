//! The cheapest pedal: two plain switches on a serial port. One connects CTS, the other DSR, with
//! RTS or DTR, which this driver holds high.

use core::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};
use std::path::Path;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use rt_core::port::{LineCounters, Pedal, PedalSample, Polled};
use rt_core::time::TimeNs;
use serialport::{SerialPort, TTYPort};

use super::debounce::Debounced;
use crate::HardwareError;

/// Reads the two wires. It is a trait because a pty has no such wires: tests implement it.
pub trait ModemLines {
    /// True for each of CTS and DSR whose switch is closed; `None` if the line is lost.
    fn closed(&mut self) -> Option<[bool; 2]>;
}

/// Interval between two reads of the wires. It is short against the debouncer's 20 ms.
const READ_INTERVAL: Duration = Duration::from_millis(2);
/// Age of the last reading above which the switches count as released, ms.
const SILENT_MS: u64 = 250;
/// Time after which CTS and DSR follow a change of RTS and DTR. A USB adapter reports its wires
/// every 16 ms.
const SETTLE: Duration = Duration::from_millis(50);
/// Bit of [`WireReading::found`] for a closed CTS.
const CTS: u8 = 1;
/// Bit of `WireReading::found` for a closed DSR.
const DSR: u8 = 2;
/// Value of `WireReading::found` when the line is lost.
const LOST: u8 = 4;

/// The wires of a real serial line. A thread reads them, because a query over USB takes a
/// millisecond or more.
#[derive(Debug)]
pub struct SerialLines(Arc<WireReading>);

/// The thread's last reading and its time.
#[derive(Debug)]
struct WireReading {
    found: AtomicU8,
    /// Time of the last reading, ms after `began`.
    at_ms: AtomicU64,
    began: Instant,
}

impl WireReading {
    fn elapsed_ms(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// States of the two wires; both count as open when the last reading is too old. `None` when
    /// the line is lost.
    fn closed(&self) -> Option<[bool; 2]> {
        let found = self.found.load(Relaxed);
        let age_ms = self.elapsed_ms().saturating_sub(self.at_ms.load(Relaxed));
        let closed = |wire| found & wire != 0 && age_ms <= SILENT_MS;
        (found != LOST).then_some([closed(CTS), closed(DSR)])
    }
}

impl SerialLines {
    /// Opens the line and feeds the switches from RTS and DTR. Refuses a line whose wires cannot be
    /// read (a pty), or do not follow RTS and DTR. Never call it from the tick, because it waits.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        let mut port = crate::line::open_port(path, 9600)?;
        let refused = |what| HardwareError::NoSwitches {
            path: path.to_path_buf(),
            what,
        };
        let no_wires = |error: serialport::Error| {
            refused(format!(
                "its CTS and DSR cannot be read: {}",
                error.description
            ))
        };
        power_switches(&mut port, false).map_err(no_wires)?;
        let cts = port.read_clear_to_send().map_err(no_wires)?;
        let dsr = port.read_data_set_ready().map_err(no_wires)?;
        check_unpowered([cts, dsr]).map_err(refused)?;
        power_switches(&mut port, true).map_err(no_wires)?;
        let found = Arc::new(WireReading {
            found: AtomicU8::new(0),
            at_ms: AtomicU64::new(0),
            began: Instant::now(),
        });
        let into = Arc::downgrade(&found);
        std::thread::Builder::new()
            .name("calot-pedal".to_owned())
            .stack_size(128 << 10)
            .spawn(move || read_wires(&mut port, &into))
            .map_err(|error| HardwareError::Line {
                path: path.to_path_buf(),
                doing: "starting its reading thread",
                what: error.to_string(),
            })?;
        Ok(Self(found))
    }
}

/// Sets RTS and DTR, and waits until the wires have settled.
fn power_switches(port: &mut TTYPort, is_on: bool) -> serialport::Result<()> {
    port.write_request_to_send(is_on)?;
    port.write_data_terminal_ready(is_on)?;
    std::thread::sleep(SETTLE);
    Ok(())
}

/// Refuses wires that are on while RTS and DTR are off. Some drivers always report a wire as on
/// (Linux's `cdc_acm` does so with CTS), and the pedal would then be pressed for ever.
fn check_unpowered([cts, dsr]: [bool; 2]) -> Result<(), String> {
    let wires = match (cts, dsr) {
        (false, false) => return Ok(()),
        (true, false) => "CTS is",
        (false, true) => "DSR is",
        (true, true) => "CTS and DSR are",
    };
    Err(format!("its {wires} on although RTS and DTR are off"))
}

/// Reads the wires until the line is lost or the pedal is dropped.
fn read_wires(port: &mut TTYPort, into: &Weak<WireReading>) {
    while let Some(into) = into.upgrade() {
        let found = match (port.read_clear_to_send(), port.read_data_set_ready()) {
            (Ok(cts), Ok(dsr)) => (u8::from(cts) * CTS) | (u8::from(dsr) * DSR),
            _ => LOST,
        };
        into.found.store(found, Relaxed);
        into.at_ms.store(into.elapsed_ms(), Relaxed);
        if found == LOST {
            return;
        }
        drop(into);
        std::thread::sleep(READ_INTERVAL);
    }
}

impl ModemLines for SerialLines {
    fn closed(&mut self) -> Option<[bool; 2]> {
        self.0.closed()
    }
}

/// Two debounced switches: CTS cuts, DSR coagulates.
#[derive(Debug)]
pub struct ModemPedal<L> {
    lines: L,
    lost: bool,
    cut: Debounced,
    coagulate: Debounced,
    counters: LineCounters,
}

impl ModemPedal<SerialLines> {
    /// Opens the line at `path`. Never call it from the tick, because it waits.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        Ok(Self::on(SerialLines::open(path)?))
    }
}

impl<L: ModemLines> ModemPedal<L> {
    /// A pedal that reads its switches from `lines`.
    pub fn on(lines: L) -> Self {
        Self {
            lines,
            lost: false,
            cut: Debounced::default(),
            coagulate: Debounced::default(),
            counters: LineCounters::default(),
        }
    }
}

impl<L: ModemLines> Pedal for ModemPedal<L> {
    fn poll(&mut self, now_ns: TimeNs) -> Polled<PedalSample> {
        let read = if self.lost { None } else { self.lines.closed() };
        let Some([cts, dsr]) = read else {
            self.lost = true;
            return Polled::Lost;
        };
        self.counters.frames += 1;
        Polled::Fresh(PedalSample {
            cut: self.cut.update(cts, now_ns),
            coagulate: self.coagulate.update(dsr, now_ns),
            camera_lock: false,
            at_ns: now_ns,
        })
    }

    fn counters(&self) -> LineCounters {
        self.counters
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::rc::Rc;

    #[test]
    fn a_pedal_on_a_hanging_adapter_reads_as_released() {
        let began = Instant::now()
            .checked_sub(Duration::from_millis(SILENT_MS * 4))
            .unwrap();
        let reading = WireReading {
            found: AtomicU8::new(CTS),
            at_ms: AtomicU64::new(SILENT_MS * 1000),
            began,
        };
        assert_eq!(reading.closed(), Some([true, false]), "a new reading");
        reading.at_ms.store(SILENT_MS, Relaxed);
        assert_eq!(reading.closed(), Some([false, false]), "an old reading");
        reading.found.store(LOST, Relaxed);
        assert_eq!(reading.closed(), None);
    }

    struct Wires(Rc<Cell<Option<[bool; 2]>>>);

    impl ModemLines for Wires {
        fn closed(&mut self) -> Option<[bool; 2]> {
            self.0.get()
        }
    }

    #[test]
    fn a_closed_switch_presses_bounces_are_ignored_and_a_lost_line_stays_lost() {
        let wires = Rc::new(Cell::new(Some([false, false])));
        let mut pedal = ModemPedal::on(Wires(Rc::clone(&wires)));
        let mut at = |closed: Option<[bool; 2]>, ms: u64| {
            wires.set(closed);
            pedal.poll(ms * 1_000_000)
        };
        let is = |polled: Polled<PedalSample>, cut: bool, coagulate: bool| matches!(polled, Polled::Fresh(s) if s.cut == cut && s.coagulate == coagulate);
        assert!(is(at(Some([false, false]), 0), false, false));
        assert!(is(at(Some([true, false]), 1), true, false));
        assert!(is(at(Some([false, false]), 2), true, false), "a bounce");
        assert!(is(at(Some([true, true]), 3), true, true));
        assert!(is(at(Some([false, true]), 20), true, true));
        assert!(is(at(Some([false, true]), 41), false, true));
        assert_eq!(at(None, 50), Polled::Lost);
        assert_eq!(
            at(Some([true, true]), 51),
            Polled::Lost,
            "until it is opened again"
        );
    }

    #[test]
    fn a_wire_that_is_on_without_feed_is_refused() {
        assert_eq!(check_unpowered([false, false]), Ok(()));
        let said = check_unpowered([true, false]).unwrap_err();
        assert_eq!(said, "its CTS is on although RTS and DTR are off");
        assert!(check_unpowered([false, true]).is_err());
        assert!(check_unpowered([true, true]).is_err());
    }

    #[test]
    fn a_pty_is_refused_because_it_has_no_modem_wires() {
        let (_master, slave) = TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        drop(slave);
        let error = SerialLines::open(path.as_ref()).unwrap_err();
        assert!(matches!(error, HardwareError::NoSwitches { .. }), "{error}");
    }
}
