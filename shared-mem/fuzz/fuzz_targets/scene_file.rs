//! Fuzzes the reader of compiled scenes.

#![no_main]

#[path = "../body.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::scene_file(bytes));
