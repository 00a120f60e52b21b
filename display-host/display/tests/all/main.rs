//! All tests of the display that need neither a window nor a controller. They are one program,
//! because each test program links all of wgpu and egui.

mod effects;
mod feed;
mod feel;
mod first_hour;
mod gallery;
mod identity;
mod inside;
mod launcher;
mod overlay;
mod panel;
mod picture;
mod quality;
mod screens;
mod shaders;
mod skinning;
#[path = "../support/mod.rs"]
mod support;
