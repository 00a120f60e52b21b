//! Messages and services by which Calot's processes communicate, and the layout of the compiled
//! scene, which the processes map into memory.
//!
//! Payloads are `#[repr(C)]`, hold no pointers, and are safe with any bit pattern: a broken peer
//! can cause wrong values, never undefined behaviour. A reader converts raw numbers with [`words`]
//! and [`message::EventMsg::decode`], which refuse unknown values.

pub mod inputs;
pub mod limits;
pub mod message;
pub mod scene;
pub mod service;
pub mod task;
pub mod words;
