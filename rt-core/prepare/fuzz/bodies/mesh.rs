//! Body of the fuzz target for meshes. No input may make the reader panic, hang, or take far more
//! memory than the size of the input justifies.

use std::path::Path;

use scene_prepare::mesh::{self, Format};
use scene_prepare::recipe::Closing;

/// Reads the bytes as a mesh file of the format that the first byte chooses, and mends the mesh if
/// it can be read. Wrapping is left out, because it takes seconds; it has tests of its own.
pub(crate) fn read(bytes: &[u8]) {
    let Some((&first, content)) = bytes.split_first() else {
        return;
    };
    let format = Format::ALL[usize::from(first) % Format::ALL.len()];
    let Ok(mesh) = mesh::parse(format, content, Path::new("no such folder"), &[]) else {
        return;
    };
    if let Ok(mended) = mesh::mend(&mesh, Closing::Fill) {
        assert!(mended.volume_m3 > 0.0, "{} m3", mended.volume_m3);
        assert!(mended.mesh.is_closed());
    }
}
