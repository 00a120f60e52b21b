//! Fuzzes the driver, the safety chain and the firmware of a haptic device, through its line.

#![no_main]

#[path = "../body.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::run(bytes));
