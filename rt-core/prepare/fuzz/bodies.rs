//! What the fuzz targets do with any bytes at all: nothing here may panic, hang or take memory
//! out of proportion.

use std::path::Path;

use scene_prepare::Recipe;
use scene_prepare::mesh::{self, Format};
use scene_prepare::recipe::Closing;

/// A recipe: read and checked. An error says where and what.
pub(crate) fn recipe(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(error) = Recipe::parse(&text, "fuzz.toml", Path::new("no such folder")) {
        assert!(!error.problem.is_empty() && error.line > 0, "{error}");
    }
}

/// A mesh file of the format that the first byte chooses: read, and mended if it can be read.
pub(crate) fn mesh(bytes: &[u8]) {
    let Some((&first, content)) = bytes.split_first() else {
        return;
    };
    let format = Format::ALL[usize::from(first) % Format::ALL.len()];
    let Ok(mesh) = mesh::parse(format, content, Path::new("no such folder"), &[]) else {
        return;
    };
    if let Ok(mended) = mesh::mend(&mesh, Closing::Auto) {
        assert!(mended.volume_m3 > 0.0 && mended.mesh.is_closed());
    }
}
