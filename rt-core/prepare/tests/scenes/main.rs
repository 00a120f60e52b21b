//! Prepared scenes: the built-in ones, those from the Human Reference Atlas, and others; some with
//! an instrument at work.

mod at_work;
mod atlas;
mod budgets;
mod built_in;
mod dissect;
mod ducts;
mod faults;
mod mechanics;
mod meeting;
mod meshes;
mod packing;
mod patients;
mod press;
mod sewing;
mod sound;
#[path = "../support/mod.rs"]
mod support;
mod triangle;
mod turned;

use std::sync::OnceLock;

use scene_prepare::{Prepared, Recipe, prepare};

/// Calot's triangle or its variant, prepared once for all tests, because it takes a while.
fn prepared_triangle(variant: bool) -> &'static Prepared {
    static BOTH: [OnceLock<Prepared>; 2] = [OnceLock::new(), OnceLock::new()];
    BOTH[usize::from(variant)].get_or_init(|| {
        let recipe = Recipe::triangle(variant).expect("a built-in recipe");
        prepare(&recipe, &mut |_| {}).expect("it can be prepared")
    })
}

/// The built-in scene, prepared once for all tests.
fn prepared_built_in() -> &'static Prepared {
    static ONCE: OnceLock<Prepared> = OnceLock::new();
    ONCE.get_or_init(|| {
        let recipe = Recipe::built_in().expect("a built-in recipe");
        prepare(&recipe, &mut |_| {}).expect("it can be prepared")
    })
}
