//! Haply's Inverse3: its serial protocol is not published, but its maker's service on this computer
//! speaks JSON over a WebSocket, one state for each command.
//!
//! A thread keeps that conversation, a thousand times a second; the tick takes the newest sample
//! and leaves the newest force. Force that nobody renews for 50 ms is no longer asked for, and the
//! service itself drops a force that is not repeated.
//!
//! Source: Haply's documentation of the service, 3.0 to 3.5, and drivers that use it. Not
//! published, and assumed low: what the device bears for ever, its damping and delay.

mod driver;
mod stream;
pub mod wire;

pub use driver::Inverse3Haptic;
