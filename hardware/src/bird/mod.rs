//! Ascension's Flock-of-Birds protocol: records of position and quaternion from one bird or a
//! group. Serial trackers (Flock of Birds, miniBIRD, laserBIRD) stream them. A trakSTAR takes the
//! same commands in USB packets and sends one record per request.

mod bulk;
pub mod device;
mod filter;
mod tracker;
mod transport;
mod usb;
pub mod wire;

pub use bulk::{BulkPipe, PACKET_BYTES};
pub(crate) use tracker::BAUD;
pub use tracker::{BirdSetup, BirdTracker};
pub(crate) use usb::is_trakstar;
