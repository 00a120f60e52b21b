//! Messages of `proto/calot.proto`, as the build compiles them, and their embedded description.

#![allow(clippy::doc_markdown, unreachable_pub, missing_docs)] // the code is generated

include!(concat!(env!("OUT_DIR"), "/calot.rs"));

/// The description, a `FileDescriptorSet`, with which any reader decodes the messages.
pub(crate) const DESCRIPTION: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/calot.bin"));
