//! Readers of mesh files: OBJ, STL, PLY, glTF. They do not trust a file: they check counts before
//! they take memory, and indices before they use them. Mending checks the coordinates.

mod ears;
mod gltf;
mod obj;
mod ply;
mod stl;
mod text;

use std::path::Path;

use super::Mesh;
use crate::error::MeshProblem;

/// Largest number of triangles of one file.
pub(super) const TRIANGLES_MAX: u64 = 4_000_000;
/// Largest number of bytes of one file.
const BYTES_MAX: u64 = 1 << 30;

/// Largest number of names of parts that an error lists.
const NAMES_MAX: usize = 40;

/// Names of the parts that are wanted, and of the parts that a file has.
struct Parts<'a> {
    wanted: &'a [String],
    found: Vec<bool>,
    names: Vec<String>,
}

impl<'a> Parts<'a> {
    fn new(wanted: &'a [String]) -> Self {
        Self {
            wanted,
            found: vec![false; wanted.len()],
            names: Vec::new(),
        }
    }

    /// True if the part with these names is wanted. Records that the file has it.
    fn take(&mut self, names: &[&str]) -> bool {
        if self.wanted.is_empty() {
            return true;
        }
        let mut taken = false;
        for (found, wanted) in self.found.iter_mut().zip(self.wanted) {
            let named = names.contains(&wanted.as_str());
            *found |= named;
            taken |= named;
        }
        for name in names.iter().filter(|name| !name.is_empty()) {
            if self.names.len() < NAMES_MAX && !self.names.iter().any(|known| known == name) {
                self.names.push((*name).into());
            }
        }
        taken
    }

    /// Checks that the file has every wanted part.
    fn check(self) -> Result<(), MeshProblem> {
        let Some(missing) = self.found.iter().position(|found| !found) else {
            return Ok(());
        };
        let available = if self.names.is_empty() {
            "none has a name".into()
        } else {
            self.names.join(", ")
        };
        Err(MeshProblem::NoSuchPart {
            wanted: self.wanted[missing].clone(),
            available,
        })
    }
}

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

/// Reads the triangles of a file, in the file's own units. `parts` names the solids (text STL),
/// objects or groups (OBJ), or nodes or meshes (glTF, with all nodes below them) to take; if it is
/// empty, all are taken.
///
/// # Errors
/// The error says what is wrong with the file.
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

/// Parses a file's content as [`read`] does. A glTF file's data are looked for in `folder`.
///
/// # Errors
/// As for [`read`].
pub fn parse(
    format: Format,
    content: &[u8],
    folder: &Path,
    parts: &[String],
) -> Result<Mesh, MeshProblem> {
    let mut parts = Parts::new(parts);
    let mesh = match format {
        Format::Obj => obj::parse(content, &mut parts)?,
        Format::Stl => stl::parse(content, &mut parts)?,
        Format::Ply => ply::parse(content, &mut parts)?,
        Format::Gltf => gltf::parse(content, folder, &mut parts)?,
    };
    parts.check()?;
    check_size(content.len() as u64, mesh.triangles.len() as u64)?;
    if mesh.triangles.is_empty() && !mesh.vertices.is_empty() {
        let points = mesh.vertices.len();
        return Err(MeshProblem::OnlyPoints { points });
    }
    Ok(mesh.without_unused())
}

/// Adds a strip of triangles: each corner from the third on makes a triangle with the two corners
/// before it.
fn push_strip(triangles: &mut Vec<[u32; 3]>, strip: &[u32]) {
    for (i, &[a, b, c]) in strip.array_windows().enumerate() {
        // Every second triangle runs the other way.
        triangles.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
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
