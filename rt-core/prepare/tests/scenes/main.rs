//! Whole scenes: the built-in one, the atlas', and random blobs.

mod atlas;
mod budgets;
mod built_in;
mod meshes;
mod packing;
mod sound;
mod triangle;
