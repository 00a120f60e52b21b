//! Fuzzes the reader of mesh files.

#![no_main]

#[path = "../bodies/mesh.rs"]
mod mesh;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mesh::read(bytes));
