//! STL, text and binary.
//!
//! A binary file states the number of its triangles. A file whose length fits this number is
//! binary, even if it begins with the word "solid", as many binary files do. Normals are ignored:
//! the order of the corners gives them, and some programs write zeros or NaN.

use super::ears::push_polygon;
use super::text::{at_line, lines, point, without_mark, words};
use super::{Parts, check_size, malformed};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::mesh::Mesh;

/// Bytes of a binary file's header and count.
const BINARY_HEAD: usize = 84;
/// Bytes of a triangle in a binary file.
const BINARY_TRIANGLE: usize = 50;

pub(super) fn parse(content: &[u8], parts: &mut Parts<'_>) -> Result<Mesh, MeshProblem> {
    let has = |word: &[u8]| {
        let mut places = content.windows(word.len());
        places.any(|place| place.eq_ignore_ascii_case(word))
    };
    let exact = announced(content).is_some_and(|count| {
        content.len() as u64 == BINARY_HEAD as u64 + count * BINARY_TRIANGLE as u64
    });
    let text = without_mark("STL", content)?;
    if !exact && !content.contains(&0) && (has(b"facet") || has(b"solid")) {
        return parse_text(text, parts);
    }
    let triangles = binary(content)?;
    if !parts.take(&[]) {
        return Ok(Mesh::default());
    }
    check_size(
        content.len() as u64,
        (triangles.len() / BINARY_TRIANGLE) as u64,
    )?;
    let mut mesh = Mesh::default();
    for triangle in triangles.as_chunks::<BINARY_TRIANGLE>().0 {
        let numbers = triangle.as_chunks::<4>().0.iter().copied();
        let numbers: Vec<f64> = numbers.map(|b| f64::from(f32::from_le_bytes(b))).collect();
        // The first three numbers are the normal.
        let corners = numbers[3..].as_chunks::<3>().0.iter().copied();
        push_corners(&mut mesh, corners.map(Vec3::from))?;
    }
    Ok(mesh)
}

/// Number of triangles that a binary file announces.
fn announced(content: &[u8]) -> Option<u64> {
    let count = content.get(BINARY_HEAD - 4..BINARY_HEAD)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

/// The bytes of a binary file's triangles.
fn binary(content: &[u8]) -> Result<&[u8], MeshProblem> {
    let (Some(announced), Some(data)) = (announced(content), content.get(BINARY_HEAD..)) else {
        return Err(malformed("STL", "shorter than its header"));
    };
    let whole = data.len().is_multiple_of(BINARY_TRIANGLE);
    // Exporters that stream their output cannot fill in the count at the end.
    if whole && (announced == 0 || announced == u64::from(u32::MAX)) {
        return Ok(data);
    }
    check_size(content.len() as u64, announced)?;
    let needed = announced as usize * BINARY_TRIANGLE;
    let Some((triangles, rest)) = data.split_at_checked(needed) else {
        let detail = format!(
            "truncated: {announced} triangles need {} bytes, but it has {}",
            needed + BINARY_HEAD,
            content.len()
        );
        return Err(malformed("STL", &detail));
    };
    if rest.iter().all(|b| *b == 0 || b.is_ascii_whitespace()) {
        return Ok(triangles);
    }
    let detail = format!(
        "announces {announced} triangles, but {} bytes follow them: the count is wrong, or files \
         were joined",
        rest.len()
    );
    Err(malformed("STL", &detail))
}

fn push_corners(mesh: &mut Mesh, corners: impl Iterator<Item = Vec3>) -> Result<(), MeshProblem> {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    let polygon: Vec<u32> = (first..mesh.vertices.len() as u32).collect();
    push_polygon(&mut mesh.triangles, &polygon, &mesh.vertices)
}

/// Reads the facets of the wanted solids. Corners stand only within loops. Unknown words outside of
/// loops are skipped.
fn parse_text(content: &[u8], parts: &mut Parts<'_>) -> Result<Mesh, MeshProblem> {
    let mut mesh = Mesh::default();
    let mut name = String::new();
    let mut corners: Option<Vec<Vec3>> = None;
    for (number, line) in lines(content) {
        let bad = |problem: &str| at_line("STL", (number, line), problem);
        let mut rest: &[&[u8]] = &words(line).collect::<Vec<_>>();
        while let Some((word, after)) = rest.split_first() {
            rest = after;
            match (word.to_ascii_lowercase().as_slice(), &mut corners) {
                (b"solid", None) => {
                    let (words, facets) = rest.split_at(facet(rest));
                    name = String::from_utf8_lossy(&words.join(&b' ')).into();
                    rest = facets;
                }
                (b"endsolid", None) => rest = &rest[facet(rest)..],
                (b"loop", None) => corners = Some(Vec::new()),
                (b"vertex", Some(corners)) => {
                    let corner = point(rest.iter().copied()).map_err(|problem| bad(&problem))?;
                    corners.push(Vec3::from(corner));
                    rest = &rest[3..];
                }
                (b"endloop", Some(loops)) => {
                    if loops.len() < 3 {
                        return Err(bad("its facet has fewer than three corners"));
                    }
                    if parts.take(&[&name]) {
                        push_corners(&mut mesh, loops.drain(..))?;
                    }
                    check_size(content.len() as u64, mesh.triangles.len() as u64)?;
                    corners = None;
                }
                (b"vertex", None) => return Err(bad("a vertex outside of a loop")),
                (_, Some(_)) => return Err(bad("expected 'vertex' or 'endloop'")),
                (_, None) => {}
            }
        }
    }
    match corners {
        None => Ok(mesh),
        Some(_) => Err(malformed("STL", "truncated: it ends within a facet")),
    }
}

/// Number of words before the next "facet normal" of the line. The name of a solid may have any
/// words.
fn facet(words: &[&[u8]]) -> usize {
    let is_facet = |pair: &[&[u8]]| {
        pair[0].eq_ignore_ascii_case(b"facet") && pair[1].eq_ignore_ascii_case(b"normal")
    };
    words.windows(2).position(is_facet).unwrap_or(words.len())
}
