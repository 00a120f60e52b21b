//! The display beside live controllers: without a window and in a window. These tests wait for
//! each other in real time, so they do not run beside those that compute.

mod headless;
#[path = "../support/mod.rs"]
mod support;
mod window;
