//! A trakSTAR's pipes on the USB.
//!
//! Source of device and endpoint numbers: two open-source drivers of medSAFE and trakSTAR units.
//! The numbers were not tested on every unit, so run `calot devices conformance` first.

use std::io;
use std::path::Path;
use std::time::Duration;

use nusb::transfer::{Buffer, Bulk, In, Out, TransferError};
use nusb::{Endpoint, MaybeFuture};

use super::bulk::{BulkPipe, PACKET_BYTES};
use crate::HardwareError;

/// Vendor and product ids of medSAFE, trakSTAR, driveBAY 2.
const UNITS: [(u16, u16); 3] = [(0x04B4, 0x1003), (0x04B4, 0x1005), (0x21E2, 0x1008)];
const OUT: u8 = 0x02;
const IN: u8 = 0x86;
/// Longest wait for a unit to take a command.
const WRITE_LIMIT: Duration = Duration::from_millis(500);

/// True for the USB ids of a trakSTAR.
pub(crate) fn is_trakstar(vendor: u16, product: u16) -> bool {
    UNITS.contains(&(vendor, product))
}

/// An open trakSTAR.
pub(super) struct UsbPipe {
    to_unit: Endpoint<Bulk, Out>,
    from_unit: Endpoint<Bulk, In>,
}

impl UsbPipe {
    /// Opens the unit with this serial number; `usb` opens the first unit found.
    pub(super) fn open(name: &Path) -> Result<Self, HardwareError> {
        let failed = |doing: &'static str| {
            move |error: nusb::Error| match error.kind() {
                nusb::ErrorKind::PermissionDenied => HardwareError::UsbPermission {
                    path: name.to_path_buf(),
                },
                nusb::ErrorKind::Busy => HardwareError::Busy {
                    path: name.to_path_buf(),
                },
                _ => HardwareError::Line {
                    path: name.to_path_buf(),
                    doing,
                    what: error.to_string(),
                },
            }
        };
        let wanted = name.to_str().unwrap_or_default();
        let unit = nusb::list_devices()
            .wait()
            .map_err(failed("listing USB devices"))?
            .filter(|unit| is_trakstar(unit.vendor_id(), unit.product_id()))
            .find(|unit| wanted == "usb" || unit.serial_number() == Some(wanted))
            .ok_or_else(|| HardwareError::NoUnit {
                path: name.to_path_buf(),
            })?;
        let device = unit.open().wait().map_err(failed("opening the unit"))?;
        let interface = device
            .claim_interface(0)
            .wait()
            .map_err(failed("claiming its interface"))?;
        let mut from_unit = interface
            .endpoint::<Bulk, In>(IN)
            .map_err(failed("opening its pipe"))?;
        let to_unit = interface
            .endpoint::<Bulk, Out>(OUT)
            .map_err(failed("opening its pipe"))?;
        from_unit
            .clear_halt()
            .wait()
            .map_err(failed("clearing its pipe"))?;
        Ok(Self { to_unit, from_unit })
    }
}

impl BulkPipe for UsbPipe {
    fn write(&mut self, packet: &[u8]) -> io::Result<()> {
        let done = self
            .to_unit
            .transfer_blocking(Buffer::from(packet.to_vec()), WRITE_LIMIT);
        done.status.map_err(io::Error::from)
    }

    fn read(&mut self, packet: &mut [u8; PACKET_BYTES], wait: Duration) -> io::Result<usize> {
        // Keep one transfer pending, so that no packet is lost between two calls.
        if self.from_unit.pending() == 0 {
            self.from_unit.submit(Buffer::new(PACKET_BYTES));
        }
        let Some(done) = self.from_unit.wait_next_complete(wait) else {
            return Ok(0);
        };
        match done.status {
            Ok(()) => {}
            // The pipe halted or was disturbed. The next transfer shows whether the unit is gone.
            Err(TransferError::Stall | TransferError::Fault) => {
                let _ = self.from_unit.clear_halt().wait();
                return Ok(0);
            }
            Err(error) => return Err(error.into()),
        }
        for (slot, &byte) in packet.iter_mut().zip(done.buffer.iter()) {
            *slot = byte;
        }
        Ok(done.actual_len.min(PACKET_BYTES))
    }
}
