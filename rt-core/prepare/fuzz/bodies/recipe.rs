//! Body of the fuzz target for recipes. No input may make the reader panic, hang, or take far more
//! memory than the size of the input justifies.

use std::path::Path;

use scene_prepare::Recipe;

/// Reads and checks the bytes as a recipe. An error must have a line and a problem.
pub(crate) fn read(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(error) = Recipe::parse(&text, "fuzz.toml", Path::new("no such folder")) {
        assert!(!error.problem.is_empty() && error.line > 0, "{error}");
    }
}
