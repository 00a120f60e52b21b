//! STL, text and binary, through stl_io.

use super::{check_size, malformed};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::mesh::Mesh;

/// Bytes of a binary file's header and count.
const BINARY_HEAD: usize = 84;
/// Bytes of a triangle of a binary file.
const BINARY_TRIANGLE: u64 = 50;

pub(super) fn parse(content: &[u8]) -> Result<Mesh, MeshProblem> {
    let text = content.trim_ascii_start().starts_with(b"solid") && content.is_ascii();
    if !text {
        let announced = content.get(80..BINARY_HEAD).and_then(|b| b.try_into().ok());
        let Some(announced) = announced.map(u32::from_le_bytes).map(u64::from) else {
            return Err(malformed("STL", "shorter than its header"));
        };
        check_size(content.len() as u64, announced)?;
        let needed = BINARY_HEAD as u64 + BINARY_TRIANGLE * announced;
        if (content.len() as u64) < needed {
            let detail = format!(
                "truncated: {announced} triangles need {needed} bytes, but it has {}",
                content.len()
            );
            return Err(malformed("STL", &detail));
        }
    }
    let mut reader = std::io::Cursor::new(content);
    let triangles =
        stl_io::create_stl_reader(&mut reader).map_err(|error| malformed("STL", &error))?;
    let mut mesh = Mesh::default();
    for triangle in triangles {
        let triangle = triangle.map_err(|error| malformed("STL", &error))?;
        let first = mesh.vertices.len() as u32;
        let corner = |p: &stl_io::Vertex| Vec3::from([p[0], p[1], p[2]].map(f64::from));
        mesh.vertices.extend(triangle.vertices.iter().map(corner));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(mesh)
}
