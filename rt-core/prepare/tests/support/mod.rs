//! Support for the tests and examples of whole scenes.
#![allow(dead_code)] // every user takes what it needs

pub(crate) mod hand;
mod loaded;

pub(crate) use loaded::LoadedScene;
