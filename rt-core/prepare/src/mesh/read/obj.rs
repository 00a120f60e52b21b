//! Wavefront OBJ: vertices, faces, and the names of objects and groups. Everything else is skipped:
//! materials, textures, normals, points, lines.

use super::ears::push_polygon;
use super::text::{at_line, lines, name, point, shown, without_mark, words};
use super::{Parts, check_size};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::mesh::Mesh;

/// Faces, before they are cut into triangles. They are cut when all vertices are known, because a
/// face may stand before its vertices.
#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    /// For each face, the end of its corners in `corners`, and its line in the file.
    ends: Vec<(usize, usize)>,
}

pub(super) fn parse(content: &[u8], parts: &mut Parts<'_>) -> Result<Mesh, MeshProblem> {
    let content = without_mark("OBJ", content)?;
    let bytes = content.len() as u64;
    let mut mesh = Mesh::default();
    let mut faces = Faces::default();
    let (mut object, mut group) = (String::new(), String::new());
    let mut numbered = lines(content);
    while let Some((number, first)) = numbered.next() {
        let key = words(first).next().unwrap_or_default();
        match key {
            b"o" => (object, group) = (name(first), String::new()),
            b"g" => group = name(first),
            b"v" | b"f" | b"fo" => {
                let line = continued(first, &mut numbered);
                let words = words(&line).skip(1);
                let bad = |problem: String| at_line("OBJ", (number, first), &problem);
                if key == b"v" {
                    mesh.vertices.push(Vec3::from(point(words).map_err(bad)?));
                    check_size(bytes, mesh.vertices.len() as u64 / 3)?;
                } else if parts.take(&[&object, &group]) {
                    for word in words {
                        let corner = corner(word, mesh.vertices.len());
                        faces.corners.push(corner.map_err(bad)?);
                    }
                    faces.ends.push((faces.corners.len(), number));
                    let triangles = faces.corners.len().saturating_sub(2 * faces.ends.len());
                    check_size(bytes, triangles as u64)?;
                }
            }
            _ => {}
        }
    }
    let mut from = 0;
    for (to, number) in faces.ends {
        let corners = &faces.corners[from..to];
        from = to;
        let count = mesh.vertices.len();
        if let Some(missing) = corners.iter().find(|i| **i as usize >= count) {
            let line = lines(content).nth(number - 1).unwrap_or((number, b""));
            let problem = format!(
                "there is no vertex {}: the file has {count}",
                u64::from(*missing) + 1
            );
            return Err(at_line("OBJ", line, &problem));
        }
        push_polygon(&mut mesh.triangles, corners, &mesh.vertices)?;
    }
    Ok(mesh)
}

/// A statement without its comment. As long as a line ends with a backslash, the next line is part
/// of the statement.
fn continued<'a>(first: &[u8], lines: &mut impl Iterator<Item = (usize, &'a [u8])>) -> Vec<u8> {
    let mut line = first.trim_ascii_end().to_vec();
    while line.last() == Some(&b'\\') {
        line.pop();
        line.push(b' ');
        let (_, next) = lines.next().unwrap_or_default();
        line.extend(next.trim_ascii_end());
    }
    let comment = line.iter().position(|b| *b == b'#');
    line.truncate(comment.unwrap_or(line.len()));
    line
}

/// Index, from 0, of a face's vertex written as `v`, `v/vt`, `v//vn` or `v/vt/vn`. A negative
/// number counts back from the last vertex so far.
fn corner(word: &[u8], vertices: usize) -> Result<u32, String> {
    let vertex = word.split(|b| *b == b'/').next().unwrap_or_default();
    let text = std::str::from_utf8(vertex).ok();
    let Some(number) = text.and_then(|text| text.parse::<i64>().ok()) else {
        return Err(format!("'{}' is not a vertex's number", shown(word)));
    };
    let index = match number {
        1.. => Some(number - 1),
        0 => None,
        _ => Some(number.saturating_add(vertices as i64)),
    };
    let index = index.and_then(|index| u32::try_from(index).ok());
    index.ok_or_else(|| format!("there is no vertex {number}: the file has {vertices} before it"))
}
