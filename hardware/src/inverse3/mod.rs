//! Haply's Inverse3. Its serial protocol is not published, but the maker's service on this computer
//! speaks JSON over a WebSocket: one state per command.
//!
//! A thread exchanges messages a thousand times a second; the tick takes the newest sample and
//! leaves the newest force. A force that is not renewed for 50 ms is no longer commanded, and the
//! service itself drops a force that is not repeated.
//!
//! Source: Haply's documentation of the service, 3.0 to 3.5, and drivers that use it. Continuous
//! force, damping and delay are not published. Low values are assumed.

mod driver;
mod stream;
pub mod wire;

pub use driver::Inverse3Haptic;
