//! Errors of compiled scenes.

use std::path::PathBuf;

use super::LAYOUT_VERSION;

/// An error of reading or writing a compiled scene.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum SceneError {
    #[error("{path}: {source}; prepare the scene with `calot prepare RECIPE --out FILE`")]
    Io {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{path}: cannot be written ({source}); name a new file in a folder that exists")]
    Unwritable {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("not a compiled scene ({0}); prepare it again with `calot prepare`")]
    NotAScene(&'static str),
    #[error(
        "compiled scene has layout version {found}, this program reads {LAYOUT_VERSION}; \
         prepare it again with `calot prepare`"
    )]
    Version { found: u32 },
    #[error("compiled scene is damaged: its content does not match its identity; prepare it again")]
    Identity,
    #[error(
        "compiled scene has {levels} levels of detail, there is no level {level}; the finest is 0"
    )]
    NoSuchLevel { level: usize, levels: usize },
    #[error("scene has no room record; prepare it again with `calot prepare`")]
    MissingRoom,
    #[error("scene has {found} {what}, allowed are {min} to {max}; choose a coarser level")]
    Count {
        what: &'static str,
        found: usize,
        min: usize,
        max: usize,
    },
    #[error(
        "{what} {index}: {problem}; change the recipe, or prepare the scene again with \
         `calot prepare`"
    )]
    Record {
        what: &'static str,
        index: usize,
        problem: String,
    },
}
