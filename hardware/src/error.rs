//! What can be wrong with a device when it is opened, tested or emulated, and what to do.

use std::path::PathBuf;

/// Why a device could not be used. Every message names the line and the next step.
#[derive(Debug, thiserror::Error)]
pub enum HardwareError {
    /// Nothing at the path.
    #[error("{path}: no such device. Plug it in, or name another path (`ls /dev/serial/by-id`)")]
    Missing {
        /// Device path as given.
        path: PathBuf,
    },
    /// The user may not open the path.
    #[error(
        "{path}: permission denied. Add yourself to the group of the device (often `dialout`): \
         `sudo usermod -aG dialout $USER`, then log in again"
    )]
    Permission {
        /// Device path as given.
        path: PathBuf,
    },
    /// No such unit on the USB.
    #[error("{path}: no trakSTAR on the USB. Plug it in and switch it on; `lsusb` shows it")]
    NoUnit {
        /// Name as given.
        path: PathBuf,
    },
    /// The user may not open the USB device.
    #[error(
        "{path}: no permission to use it on the USB. As root put into \
         /etc/udev/rules.d/70-trakstar.rules: SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"21e2\", \
         MODE=\"0660\", GROUP=\"dialout\" (and one with 04b4), then plug it in again"
    )]
    UsbPermission {
        /// Name as given.
        path: PathBuf,
    },
    /// Another program has the line.
    #[error("{path}: in use by another program. Stop it first (`fuser -v {path}` names it)")]
    Busy {
        /// Device path as given.
        path: PathBuf,
    },
    /// The path is not a serial device.
    #[error("{path}: not a serial device ({what}). Name a tty such as /dev/ttyACM0")]
    NotSerial {
        /// Device path as given.
        path: PathBuf,
        /// What the system says.
        what: String,
    },
    /// A folder, a pipe or a device stands where the station file should.
    #[error(
        "{path}: not a station file, but a folder, a pipe or a device. Name a text file (TOML) that names the devices"
    )]
    NoStationFile {
        /// Path as given.
        path: PathBuf,
    },
    /// Any other failure of the line while opening it.
    #[error("{path}: {doing} failed: {what}")]
    Line {
        /// Device path as given.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// What the system says.
        what: String,
    },
    /// The device did not answer the handshake.
    #[error(
        "{path}: no answer from a {expected} in {waited_ms} ms ({heard} bytes heard). \
         Is it powered, and is this its line?"
    )]
    Silent {
        /// Device path as given.
        path: PathBuf,
        /// Which device was expected.
        expected: &'static str,
        /// How long.
        waited_ms: u64,
        /// Bytes received that were no answer: 0 means a dead line, many a wrong device or rate.
        heard: u64,
    },
    /// Something else answered.
    #[error("{path}: expected a {expected}, found {found}. Swap the lines in the station")]
    WrongDevice {
        /// Device path as given.
        path: PathBuf,
        /// Which device was expected.
        expected: &'static str,
        /// What answered.
        found: String,
    },
    /// The device speaks another version of the protocol.
    #[error("{path}: speaks protocol version {found}, this driver {expected}. Update the {older}")]
    Version {
        /// Device path as given.
        path: PathBuf,
        /// Our version.
        expected: u8,
        /// The device's version.
        found: u8,
        /// Which of the two is older.
        older: &'static str,
    },
    /// The device reports a capability that cannot be true or is not safe.
    #[error("{path}: the device reports {what} = {value}, allowed is {allowed}. Mend its firmware")]
    Capability {
        /// Device path as given.
        path: PathBuf,
        /// Which capability.
        what: &'static str,
        /// What it reports.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The device answers but reports an error after which it must not be used.
    #[error("{path}: the device reports error {code}. See its manual; switch it off and on")]
    Fault {
        /// Device path as given.
        path: PathBuf,
        /// The device's number of the error.
        code: u32,
    },
    /// The Inverse3's service does not answer, or has no such device.
    #[error(
        "{path}: {what}. Start it (`systemctl start haply-inverse-service`) and plug the Inverse3 in"
    )]
    Service {
        /// Address as given.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A vendor's library is missing or not what it should be.
    #[error("{path}: {what}. Install the vendor's driver, or name its library in the station")]
    Library {
        /// Library as given.
        path: PathBuf,
        /// What the loader says.
        what: String,
    },
    /// The vendor's library reports an error.
    #[error("{path}: {doing} failed with error {code:04X}: {remedy}")]
    Vendor {
        /// Device as given.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The library's code.
        code: u16,
        /// What to do.
        remedy: &'static str,
    },
    /// The device has to be calibrated by hand first.
    #[error("{path}: not calibrated. {remedy}, then try again")]
    Calibration {
        /// Device as given.
        path: PathBuf,
        /// What to do.
        remedy: &'static str,
    },
    /// The station file says something that cannot be.
    #[error("{path}:{line}: {what}")]
    Station {
        /// The file.
        path: PathBuf,
        /// Line of the file, from 1.
        line: usize,
        /// What is wrong and what is allowed.
        what: String,
    },
    /// The emulated station cannot be set up as asked.
    #[error("emulation: {what} is {value}, allowed is {allowed}. {remedy}")]
    Emulation {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
        /// What to do.
        remedy: &'static str,
    },
}
