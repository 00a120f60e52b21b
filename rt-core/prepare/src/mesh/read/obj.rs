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
    let (models, _) =
        tobj::load_obj_buf(&mut reader, &options, no_materials).map_err(
            |error| match faulty_line(content) {
                Some((number, line)) => {
                    malformed("OBJ", &format!("line {number}, '{line}': {error}"))
                }
                None => malformed("OBJ", &error),
            },
        )?;
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

/// Number, from 1, and beginning of the first line that cannot be right: a vertex without three
/// numbers, or a face of vertices that do not exist. The library's error does not name the line.
fn faulty_line(content: &[u8]) -> Option<(usize, String)> {
    let lines = || content.split(|&b| b == b'\n').map(String::from_utf8_lossy);
    let count = |key: &str| {
        let keys = lines().filter(|line| line.split_whitespace().next() == Some(key));
        keys.count() as u64
    };
    // Counts of the three kinds of lines that a corner `v/vt/vn` refers to.
    let counts = ["v", "vt", "vn"].map(count);
    let names_nothing = |(part, count): (&str, u64)| match part.parse::<i64>() {
        Ok(index) => !(1..=count).contains(&index.unsigned_abs()),
        Err(_) => !part.is_empty(),
    };
    let is_faulty = |line: &str| {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers = words.take(3).filter(|word| word.parse::<f32>().is_ok());
                numbers.count() < 3
            }
            Some("f") => words.any(|corner| {
                let parts = corner.split('/').zip(counts);
                corner.starts_with('/') || parts.into_iter().any(names_nothing)
            }),
            _ => line.contains(char::REPLACEMENT_CHARACTER),
        }
    };
    let mut numbered = (1..).zip(lines());
    let (number, line) = numbered.find(|(_, line)| is_faulty(line))?;
    let shown = line.chars().filter(|c| !c.is_control()).take(40);
    Some((number, shown.collect()))
}
