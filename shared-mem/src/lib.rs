//! Messages and services by which Calot's processes communicate, and the layout of the compiled
//! scene, which the processes map into memory.
//!
//! Payloads are `#[repr(C)]`, contain no pointers, and are valid with any bit pattern. A broken
//! peer can cause wrong values but never undefined behaviour. A reader converts raw numbers with
//! [`words`] and [`message::EventMsg::decode`], which refuse unknown values.

pub mod inputs;
pub mod limits;
pub mod message;
pub mod scene;
pub mod service;
pub mod task;
pub mod words;
