//! Readers of mesh files: OBJ, STL, PLY, glTF. They do not trust a file's contents: they check
//! counts before they take memory, and indices and numbers before they use them.

mod gltf;
mod obj;
mod ply;
mod stl;

use std::path::Path;

use super::Mesh;
use crate::error::MeshProblem;

/// Triangles of one file, at most.
pub(super) const TRIANGLES_MAX: u64 = 4_000_000;
/// Bytes of one file, at most.
const BYTES_MAX: u64 = 1 << 30;

/// Parts of a file by name.
type Parts = Vec<(String, Mesh)>;

/// A mesh file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// STL, text or binary.
    Stl,
    /// PLY, text or binary.
    Ply,
    /// glTF or GLB.
    Gltf,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Obj, Self::Stl, Self::Ply, Self::Gltf];

    fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "ply" => Some(Self::Ply),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// Reads the triangles of a file, in its own units. `parts` names the objects (OBJ) or nodes (glTF,
/// with all below them) to take; if it is empty, all are taken.
///
/// # Errors
/// Says what is wrong with the file.
pub fn read(path: &Path, parts: &[String]) -> Result<Mesh, MeshProblem> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let extension = extension.to_ascii_lowercase();
    let format = Format::of_extension(&extension)
        .ok_or_else(|| MeshProblem::UnknownFormat(format!(".{extension}")))?;
    let content = content(path)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    parse(format, &content, folder, parts)
}

/// A file's bytes. Only plain files are read, because a pipe or device might have no end.
fn content(path: &Path) -> Result<Vec<u8>, MeshProblem> {
    let unreadable = |error: std::io::Error| MeshProblem::Unreadable(error.to_string());
    let file = std::fs::metadata(path).map_err(unreadable)?;
    if !file.is_file() {
        return Err(MeshProblem::Unreadable("it is not a plain file".into()));
    }
    if file.len() > BYTES_MAX {
        // The most compact format needs about 12 bytes a triangle.
        return Err(too_large(file.len(), file.len() / 12));
    }
    std::fs::read(path).map_err(unreadable)
}

/// Parses a file's content as [`read`] does. glTF looks for its data in `folder`.
///
/// # Errors
/// As for [`read`].
pub fn parse(
    format: Format,
    content: &[u8],
    folder: &Path,
    parts: &[String],
) -> Result<Mesh, MeshProblem> {
    let named: Parts = match format {
        Format::Obj => obj::parse(content)?,
        Format::Stl => vec![(String::new(), stl::parse(content)?)],
        Format::Ply => vec![(String::new(), ply::parse(content)?)],
        Format::Gltf => return gltf::parse(content, folder, parts),
    };
    let mesh = take_parts(named, parts)?;
    check_size(content.len() as u64, mesh.triangles.len() as u64)?;
    Ok(mesh)
}

fn take_parts(named: Parts, wanted: &[String]) -> Result<Mesh, MeshProblem> {
    if let Some(missing) = wanted
        .iter()
        .find(|w| !named.iter().any(|(name, _)| name == *w))
    {
        let available = named.iter().map(|(name, _)| name.as_str());
        return Err(no_such_part(missing, available));
    }
    let mut mesh = Mesh::default();
    for (name, part) in named {
        if wanted.is_empty() || wanted.contains(&name) {
            mesh.append(&part);
        }
    }
    Ok(mesh)
}

fn no_such_part<'a>(wanted: &str, available: impl Iterator<Item = &'a str>) -> MeshProblem {
    let mut names: Vec<&str> = available.filter(|name| !name.is_empty()).collect();
    names.truncate(40);
    let available = if names.is_empty() {
        "none has a name".into()
    } else {
        names.join(", ")
    };
    MeshProblem::NoSuchPart {
        wanted: wanted.into(),
        available,
    }
}

fn check_size(bytes: u64, triangles: u64) -> Result<(), MeshProblem> {
    if triangles > TRIANGLES_MAX {
        return Err(too_large(bytes, triangles));
    }
    Ok(())
}

fn too_large(bytes: u64, triangles: u64) -> MeshProblem {
    MeshProblem::TooLarge {
        bytes,
        triangles,
        max: TRIANGLES_MAX,
    }
}

fn malformed(format: &'static str, detail: &(impl ToString + ?Sized)) -> MeshProblem {
    let detail = detail.to_string();
    let detail = detail.split_whitespace().collect::<Vec<_>>().join(" ");
    MeshProblem::Malformed { format, detail }
}

/// Adds a polygon as a fan of triangles.
fn push_polygon(triangles: &mut Vec<[u32; 3]>, polygon: &[u32]) {
    for pair in polygon.get(1..).unwrap_or_default().windows(2) {
        triangles.push([polygon[0], pair[0], pair[1]]);
    }
}
