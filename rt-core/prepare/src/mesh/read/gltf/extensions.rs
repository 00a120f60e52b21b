//! Extensions that a glTF file requires or uses.

use crate::error::MeshProblem;

/// Extensions that change the surface. The second text of each says how, and names an exporter's
/// option that avoids the extension.
const REFUSED: [(&str, &str); 5] = [
    (
        "KHR_draco_mesh_compression",
        "compresses the mesh; export it without: in Blender clear Data > Compression, with \
         gltf-pipeline leave out -d",
    ),
    (
        "EXT_meshopt_compression",
        "compresses the mesh; export it without: leave out gltfpack's -c and -cc, and give -noq",
    ),
    (
        "KHR_meshopt_compression",
        "compresses the mesh; export it without: leave out gltfpack's -c and -cc, and give -noq",
    ),
    (
        "KHR_mesh_quantization",
        "rounds the vertices; export it without: give gltfpack -noq, or run `gltf-transform \
         dequantize IN OUT`",
    ),
    (
        "EXT_mesh_gpu_instancing",
        "repeats a mesh; export each copy as a node of its own: gltfpack without -mi",
    ),
];

/// An extension whose name contains one of these words does not change surfaces.
const HARMLESS: [&str; 9] = [
    "texture",
    "material",
    "image",
    "light",
    "animation",
    "xmp",
    "metadata",
    "audio",
    "interactivity",
];

/// Checks that the file needs no extension that changes its surfaces.
pub(super) fn check(root: &gltf::json::Root) -> Result<(), MeshProblem> {
    for extension in &root.extensions_required {
        let lower = extension.to_ascii_lowercase();
        let harmless = HARMLESS.iter().any(|word| lower.contains(word));
        if !harmless {
            return Err(refuse(extension));
        }
    }
    // A file may use instancing without requiring it. A reader that ignores instancing would see
    // one copy only.
    match root
        .extensions_used
        .iter()
        .find(|name| *name == REFUSED[4].0)
    {
        Some(extension) => Err(refuse(extension)),
        None => Ok(()),
    }
}

/// The error for data that cannot be read. If the file uses an extension that changes the surface,
/// that extension is refused; else the error is `otherwise`.
pub(super) fn blame<'a>(
    used: impl Iterator<Item = &'a str>,
    otherwise: MeshProblem,
) -> MeshProblem {
    let mut used = used.filter(|name| REFUSED.iter().any(|(refused, _)| refused == name));
    used.next().map_or(otherwise, refuse)
}

fn refuse(extension: &str) -> MeshProblem {
    let known = REFUSED.iter().find(|(name, _)| *name == extension);
    let because = known.map_or(
        "is unknown here and may change the surface; export it without",
        |k| k.1,
    );
    let extension = extension
        .chars()
        .filter(|c| !c.is_control())
        .take(60)
        .collect();
    MeshProblem::Extension { extension, because }
}
