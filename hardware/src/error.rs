//! Errors while a device is opened, tested or emulated, each with its remedy.

use std::path::PathBuf;

use crate::characterise::Halt;

/// Reasons for which a device cannot be used. Every message names the device and the next step.
#[derive(Debug, thiserror::Error)]
pub enum HardwareError {
    /// The path does not exist.
    #[error("{path}: no such device. Plug it in, or name another path (`ls /dev/serial/by-id`)")]
    Missing {
        /// Device path as given.
        path: PathBuf,
    },
    /// The user lacks permission for the path.
    #[error(
        "{path}: permission denied. Add yourself to the group of the device (often `dialout`): \
         `sudo usermod -aG dialout $USER`, then log in again"
    )]
    Permission {
        /// Device path as given.
        path: PathBuf,
    },
    /// No trakSTAR of this name is on the USB.
    #[error("{path}: no trakSTAR on the USB. Plug it in and switch it on; `lsusb` shows it")]
    NoUnit {
        /// Name as given.
        path: PathBuf,
    },
    /// The user lacks permission for the USB device.
    #[error(
        "{path}: no permission to use it on the USB. As root put into \
         /etc/udev/rules.d/70-trakstar.rules: SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"21e2\", \
         MODE=\"0660\", GROUP=\"dialout\" (and one with 04b4), then plug it in again"
    )]
    UsbPermission {
        /// Name as given.
        path: PathBuf,
    },
    /// The vendor's library libdhd finds no device of Force Dimension or Novint.
    #[error(
        "{path}: no Force Dimension device or Falcon found. Plug it in and switch it on; `lsusb` shows 1451 or \
         0403:cb48. If it does, this user may not use it: as root put into \
         /etc/udev/rules.d/70-force-dimension.rules: SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"1451\", \
         MODE=\"0660\", GROUP=\"dialout\" (for a Falcon 0403, with ATTR{{idProduct}}==\"cb48\"), then plug it in \
         again"
    )]
    NoForceDevice {
        /// Device as given.
        path: PathBuf,
    },
    /// Another program uses the line.
    #[error("{path}: in use by another program. Stop it first (`fuser -v {path}` names it)")]
    Busy {
        /// Device path as given.
        path: PathBuf,
    },
    /// Programs that are known by name use the line.
    #[error("{path}: in use by {by}. Stop it first")]
    Held {
        /// Device path as given.
        path: PathBuf,
        /// The programs, each with its process id.
        by: String,
    },
    /// The line cannot tell whether switches at its CTS and DSR are closed.
    #[error(
        "{path}: switches cannot be read from this line ({what}). Use a serial port, or a USB adapter with the wires CTS and DSR, such as /dev/ttyUSB0, and feed the switches from its RTS or DTR"
    )]
    NoSwitches {
        /// Device path as given.
        path: PathBuf,
        /// State of the line.
        what: String,
    },
    /// The path is not a serial device.
    #[error("{path}: not a serial device ({what}). Name a tty such as /dev/ttyACM0")]
    NotSerial {
        /// Device path as given.
        path: PathBuf,
        /// Error of the operating system.
        what: String,
    },
    /// A folder, a pipe or a device stands where the station file should.
    #[error(
        "{path}: not a station file but a folder, a pipe or a device. Give a TOML file that names the devices"
    )]
    NoStationFile {
        /// Path as given.
        path: PathBuf,
    },
    /// A step failed, for a reason that no other error names.
    #[error("{path}: {doing} failed: {what}")]
    Line {
        /// Device path as given.
        path: PathBuf,
        /// Step that failed.
        doing: &'static str,
        /// Cause of the failure.
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
        /// Expected device.
        expected: &'static str,
        /// Time waited, ms.
        waited_ms: u64,
        /// Bytes received that were no answer: 0 means a dead line, many mean a wrong device or
        /// rate.
        heard: u64,
    },
    /// The device sent bytes, but no answer.
    #[error("{path}: no answer from a {expected} in {waited_ms} ms. {heard}")]
    Garbled {
        /// Device path as given.
        path: PathBuf,
        /// Expected device.
        expected: &'static str,
        /// Time waited, ms.
        waited_ms: u64,
        /// Sentences about the bytes, with the likely mistake and its remedy.
        heard: String,
    },
    /// The device must pass a test by hand (`calot devices feel`) before it may render a force.
    #[error(
        "{path}: no force before a test by hand: two sources contradict each other about the signs of a \
         WoodenHaptics device. Run `calot devices feel --station-file FILE --out FILE --overwrite` with \
         this station file"
    )]
    Unfelt {
        /// Device path as given.
        path: PathBuf,
    },
    /// A device of another kind answered.
    #[error("{path}: expected a {expected}, found {found}. Correct the path in the station file")]
    WrongDevice {
        /// Device path as given.
        path: PathBuf,
        /// Expected device.
        expected: &'static str,
        /// Device that answered.
        found: String,
    },
    /// The device speaks another version of the protocol.
    #[error("{path}: speaks protocol version {found}, this driver {expected}. Update the {older}")]
    Version {
        /// Device path as given.
        path: PathBuf,
        /// Version of this driver.
        expected: u8,
        /// Version of the device.
        found: u8,
        /// The older of the two, which needs an update.
        older: &'static str,
    },
    /// The device reports a capability that is impossible or unsafe.
    #[error(
        "{path}: the device reports {what} = {value}, allowed is {allowed}. Correct its firmware or driver"
    )]
    Capability {
        /// Device path as given.
        path: PathBuf,
        /// Name of the capability.
        what: &'static str,
        /// Reported value.
        value: f32,
        /// Allowed range.
        allowed: &'static str,
    },
    /// The device reports an error that forbids its use.
    #[error(
        "{path}: the device reports error {code}. Look it up in the manual, then switch the device off and on"
    )]
    Fault {
        /// Device path as given.
        path: PathBuf,
        /// Error code of the device.
        code: u32,
    },
    /// The Inverse3's service does not answer or has no such device.
    #[error(
        "{path}: {what}. Start the service (`systemctl start haply-inverse-service`) and plug the Inverse3 in"
    )]
    Service {
        /// Address as given.
        path: PathBuf,
        /// Description of the problem.
        what: String,
    },
    /// A vendor's library is missing or unusable.
    #[error("{path}: {what}. {remedy}")]
    Library {
        /// Library as given.
        path: PathBuf,
        /// Cause.
        what: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// A call into a vendor's library does not return.
    #[error(
        "{path}: the vendor's library {library} did not return within {waited_s} s. Unplug the device and \
         plug it in, then start Calot again; if the vendor's own diagnosis hangs too, ask the vendor"
    )]
    Hangs {
        /// Device as given.
        path: PathBuf,
        /// Library as given.
        library: PathBuf,
        /// Time waited, s.
        waited_s: u64,
    },
    /// The vendor's library reports an error.
    #[error("{path}: {doing} failed with error {code:04X}: {remedy}")]
    Vendor {
        /// Device as given.
        path: PathBuf,
        /// Step that failed.
        doing: &'static str,
        /// Error code of the library.
        code: u16,
        /// Remedy.
        remedy: &'static str,
    },
    /// The device needs calibration by hand.
    #[error("{path}: not calibrated. {remedy}, then try again")]
    Calibration {
        /// Device as given.
        path: PathBuf,
        /// Remedy.
        remedy: &'static str,
    },
    /// The station file has an invalid entry.
    #[error("{path}:{line}: {what}")]
    Station {
        /// The file.
        path: PathBuf,
        /// Line of the file, from 1.
        line: usize,
        /// The problem and the allowed values.
        what: String,
    },
    /// The measurement of a device's properties (`characterise`) was stopped.
    #[error(transparent)]
    Halted(#[from] Halt),
    /// The emulated station cannot be set up.
    #[error("emulation: {what} is {value}, allowed is {allowed}. {remedy}")]
    Emulation {
        /// Name of the setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Allowed range.
        allowed: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
}
