//! Connected serial lines and input devices, with their stable names and a guess at their type.

use std::fs;
use std::path::{Path, PathBuf};

use nusb::MaybeFuture;
use serialport::SerialPortType;

/// A connected device that a station could use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Present path, e.g. `/dev/ttyACM0`.
    pub path: PathBuf,
    /// Path that does not depend on the order in which devices are plugged in. The station file
    /// should name this path.
    pub stable_path: Option<PathBuf>,
    /// Name that the device reports.
    pub name: String,
    /// Likely type, and the driver to name in the station file.
    pub guess: Option<&'static str>,
}

/// Serial lines and input devices of this machine.
#[must_use]
pub fn devices() -> Vec<Found> {
    let mut found: Vec<Found> = serialport::available_ports()
        .unwrap_or_default()
        .into_iter()
        .map(line)
        .collect();
    found.extend(
        crate::pedal::find("")
            .into_iter()
            .map(|(path, name)| Found {
                stable_path: stable("/dev/input/by-id".as_ref(), &path),
                guess: pedal(&name),
                path,
                name,
            }),
    );
    found.extend(usb_devices());
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// Known devices on the USB that are not serial lines.
fn usb_devices() -> Vec<Found> {
    let units = nusb::list_devices().wait().into_iter().flatten();
    units
        .filter_map(|unit| {
            let numbers = (unit.vendor_id(), unit.product_id());
            let (path, kind, guess) = usb_device_by_itself(numbers)?;
            // libdhd opens a device by a number that differs from the serial number on the USB.
            let serial = unit.serial_number().filter(|_| path == "usb");
            Some(Found {
                path: PathBuf::from(path),
                stable_path: serial.map(PathBuf::from),
                name: format!(
                    "{} ({:04x}:{:04x})",
                    unit.product_string().unwrap_or(kind),
                    numbers.0,
                    numbers.1
                ),
                guess: Some(guess),
            })
        })
        .collect()
}

/// Path, kind and guess of a device that is no serial line.
fn usb_device_by_itself(numbers: (u16, u16)) -> Option<(&'static str, &'static str, &'static str)> {
    let force_dimension = "driver \"force-dimension\", path of the vendor's libdhd.so.3 or none";
    match numbers {
        (vendor, product) if crate::bird::is_trakstar(vendor, product) => {
            let guess = "Ascension trakSTAR: driver \"trakstar\"";
            Some(("usb", "trakSTAR", guess))
        }
        (0x1451, _) => Some((
            crate::dhd::LIBRARY,
            "Force Dimension device",
            force_dimension,
        )),
        (0x0403, 0xCB48) => Some((crate::dhd::LIBRARY, "Novint Falcon", force_dimension)),
        _ => None,
    }
}

fn line(port: serialport::SerialPortInfo) -> Found {
    let path = PathBuf::from(port.port_name);
    let (name, guess) = match port.port_type {
        SerialPortType::UsbPort(usb) => {
            let maker = usb.manufacturer.unwrap_or_default();
            let product = usb.product.unwrap_or_default();
            let name = format!("{maker} {product} ({:04x}:{:04x})", usb.vid, usb.pid);
            (name.trim().to_owned(), usb_device(usb.vid, usb.pid))
        }
        SerialPortType::PciPort => ("serial port of the computer".to_owned(), None),
        SerialPortType::BluetoothPort => ("Bluetooth".to_owned(), None),
        SerialPortType::Unknown => ("serial line".to_owned(), None),
    };
    Found {
        stable_path: stable("/dev/serial/by-id".as_ref(), &path),
        path,
        name,
        guess,
    }
}

/// The link in `directory` that leads to `path`.
fn stable(directory: &Path, path: &Path) -> Option<PathBuf> {
    let target = fs::canonicalize(path).ok()?;
    let links = fs::read_dir(directory).ok()?;
    let mut names: Vec<PathBuf> = links
        .filter_map(|link| Some(link.ok()?.path()))
        .filter(|link| fs::canonicalize(link).is_ok_and(|to| to == target))
        .collect();
    names.sort();
    names.into_iter().next()
}

fn usb_device(vendor: u16, product: u16) -> Option<&'static str> {
    Some(match (vendor, product) {
        (0x0301, 0x2988) | (0x2988, 0x0302) => {
            "3D Systems Touch: driver \"touch\", path of the vendor's libHD.so"
        }
        (0x2341, 0x003D | 0x003E) => {
            "Arduino Due: a Haply hAPI board (\"hapi\") or a rig (\"rig\")"
        }
        // Teensy, by far the most common board of rigs. Haply's Inverse3 has the same USB ids.
        (0x16C0, 0x0483) => "Teensy: driver \"woody\" or \"rig\" (or an Inverse3)",
        (0x0403, 0x6001) => "FTDI adapter: a tracker (\"bird\"), a rig or a pedal (\"modem\")",
        _ => return None,
    })
}

fn pedal(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    ["foot", "pedal", "vec", "pcsensor"]
        .iter()
        .any(|word| name.contains(word))
        .then_some("foot pedal: driver \"evdev\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_found_by_its_permanent_name() {
        let directory = tempfile::tempdir().unwrap();
        let device = directory.path().join("ttyACM0");
        fs::write(&device, "").unwrap();
        let names = directory.path().join("by-id");
        fs::create_dir(&names).unwrap();
        assert_eq!(stable(&names, &device), None);
        let link = names.join("usb-Maker_Rig_0001-if00");
        std::os::unix::fs::symlink("../ttyACM0", &link).unwrap();
        assert_eq!(stable(&names, &device), Some(link));
    }

    #[test]
    fn known_numbers_and_names_are_guessed() {
        assert!(usb_device(0x0301, 0x2988).unwrap().contains("touch"));
        assert_eq!(usb_device(0x1234, 0x5678), None);
        for numbers in [(0x1451, 0x0402), (0x0403, 0xCB48)] {
            let (_, _, guess) = usb_device_by_itself(numbers).unwrap();
            assert!(guess.contains("\"force-dimension\""), "{guess}");
        }
        assert_eq!(usb_device_by_itself((0x0403, 0x6001)), None);
        assert!(pedal("VEC VEC USB Footpedal").is_some());
        assert_eq!(pedal("AT Translated Set 2 keyboard"), None);
    }

    #[test]
    fn listing_devices_never_fails() {
        for found in devices() {
            let is_usb = ["usb", crate::dhd::LIBRARY].map(Path::new);
            let is_usb = is_usb.contains(&found.path.as_path());
            assert!(found.path.is_absolute() || is_usb, "{found:?}");
        }
    }
}
