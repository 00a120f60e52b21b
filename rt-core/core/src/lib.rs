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
mod cautery;
pub mod cells;
pub mod clip;
pub mod collision;
mod cut;
mod event;
mod fade;
pub mod fault;
mod force;
mod grasp;
mod hash;
pub mod math;
pub mod output_limit;
mod passivity;
pub mod port;
mod proxy;
mod sample;
pub mod scene;
pub mod sim;
pub mod soft_body;
pub mod state;
pub mod time;
pub mod tool;
mod vessel;
pub mod words;
