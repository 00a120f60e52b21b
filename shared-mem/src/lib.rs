//! Every type and service that crosses Calot's process border, and the compiled scene's layout,
//! which both processes map.
//!
//! Payloads are `#[repr(C)]`, hold no pointers, and are any-bit-pattern safe: a reader may get
//! garbage from a broken peer, never undefined behaviour.

pub mod inputs;
pub mod limits;
pub mod message;
pub mod scene;
pub mod service;
pub mod task;
pub mod words;
