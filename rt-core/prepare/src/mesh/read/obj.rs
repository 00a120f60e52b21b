//! Wavefront OBJ, through tobj.

use super::{Parts, check_size, malformed};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::mesh::Mesh;

pub(super) fn parse(content: &[u8]) -> Result<Parts, MeshProblem> {
    let lines = content.split(|&b| b == b'\n');
    let faces = lines
        .filter(|line| line.trim_ascii_start().starts_with(b"f "))
        .count();
    check_size(content.len() as u64, faces as u64)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..Default::default()
    };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let mut reader = std::io::Cursor::new(content);
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, no_materials)
        .map_err(|error| malformed("OBJ", &error))?;
    let part = |model: tobj::Model| {
        let points = model.mesh.positions.as_chunks::<3>().0;
        let mesh = Mesh {
            vertices: points
                .iter()
                .map(|p| Vec3::from(p.map(f64::from)))
                .collect(),
            triangles: model.mesh.indices.as_chunks::<3>().0.to_vec(),
        };
        (model.name, mesh)
    };
    Ok(models.into_iter().map(part).collect())
}
