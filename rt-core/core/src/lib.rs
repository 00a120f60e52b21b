//! Calot's simulation and control law.
//!
//! `no_std`, no `alloc`, no clock, no files, no logs, no randomness. Time, input and storage
//! are arguments; the scene is immutable, the [`state`] mutable. One tick ([`sim::Sim::tick`])
//! reads, in the data's order:
//!
//! ```text
//! sample → tool → contact → solve → force → procedure → publish
//! ```
//!
//! Units are SI. Frames stand in transforms: `world_from_handle` takes handle coordinates to
//! world coordinates. Contact normals point from tissue to tool.
#![no_std]
#![deny(unsafe_code)]

pub mod capacity;
mod contact;
pub mod fault;
pub mod haptics;
mod hash;
pub mod math;
mod organs;
pub mod port;
pub mod procedure;
pub mod scene;
pub mod sim;
pub mod state;
pub mod study;
pub mod time;
pub mod tissue;
pub mod tool;
pub mod words;
