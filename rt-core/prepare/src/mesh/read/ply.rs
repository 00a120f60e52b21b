//! PLY, text and binary, through ply-rs. The crate reads only headers with plain names in UTF-8, so
//! the header is rewritten first.

use std::io::{Cursor, Read};

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Header, Property, PropertyAccess, PropertyAccessResult};

use super::ears::push_polygon;
use super::text::without_mark;
use super::{Parts, check_size, malformed, push_strip};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::mesh::Mesh;

#[derive(Debug, Default)]
struct Vertex(Vec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match property {
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            Property::Char(value) => f64::from(value),
            Property::UChar(value) => f64::from(value),
            Property::Short(value) => f64::from(value),
            Property::UShort(value) => f64::from(value),
            Property::Int(value) => f64::from(value),
            Property::UInt(value) => f64::from(value),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Names under which programs write the list of a face's vertices.
const INDICES: [&str; 4] = [
    "vertex_indices",
    "vertex_index",
    "vertex_indexes",
    "indices",
];

/// Indices of a face or strip. An index that does not fit `u32` becomes `u32::MAX`, which is out of
/// range.
#[derive(Debug, Default)]
struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !INDICES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        fn all<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
            list.into_iter()
                .map(|i| i.try_into().unwrap_or(u32::MAX))
                .collect()
        }
        self.0 = match property {
            Property::ListChar(list) => all(list),
            Property::ListUChar(list) => all(list),
            Property::ListShort(list) => all(list),
            Property::ListUShort(list) => all(list),
            Property::ListInt(list) => all(list),
            Property::ListUInt(list) => list,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

fn bad(error: impl std::error::Error) -> MeshProblem {
    malformed("PLY", &error)
}

/// The header with plain names and LF, without comments, and the bytes after the header.
fn header(content: &[u8]) -> Result<(Vec<u8>, &[u8]), MeshProblem> {
    let endless = || malformed("PLY", "its header has no line 'end_header'");
    let first = content.iter().position(|b| matches!(b, b'\n' | b'\r'));
    let (_, from) = content.split_at(first.ok_or_else(endless)?);
    let line_end: &[u8] = match from {
        [b'\r', b'\n', ..] => b"\r\n",
        [b'\r', ..] => b"\r",
        _ => b"\n",
    };
    let mut header = Vec::new();
    let mut rest = content;
    loop {
        let end = rest.windows(line_end.len()).position(|w| w == line_end);
        let (line, after) = rest.split_at(end.ok_or_else(endless)?);
        rest = &after[line_end.len()..];
        let mut words: Vec<Vec<u8>> = super::text::words(line).map(<[u8]>::to_vec).collect();
        let name = match words.first().map(Vec::as_slice) {
            None | Some(b"comment" | b"obj_info") => continue,
            Some(b"element") => words.get_mut(1),
            Some(b"property") => words.last_mut(),
            Some(_) => None,
        };
        for byte in name.into_iter().flatten() {
            if !byte.is_ascii_alphanumeric() {
                *byte = b'_';
            }
        }
        header.extend(words.join(&b' '));
        header.push(b'\n');
        if words == [b"end_header"] {
            return Ok((header, rest));
        }
    }
}

/// Checks the header's counts, before memory is taken, and that faces have a list of vertices.
fn check(header: &Header, bytes: usize) -> Result<(), MeshProblem> {
    for (name, element) in &header.elements {
        if name == "vertex" || name == "face" {
            check_size(bytes as u64, element.count as u64)?;
        } else if element.count > bytes || element.properties.is_empty() {
            // Elements without properties take no bytes, so a file of any size could have any
            // number of them.
            let detail = format!(
                "announces {} of element '{name}' with {} properties in {bytes} bytes",
                element.count,
                element.properties.len(),
            );
            return Err(malformed("PLY", &detail));
        }
        let has_list = INDICES
            .iter()
            .any(|list| element.properties.contains_key(*list));
        if matches!(name.as_str(), "face" | "tristrips") && element.count > 0 && !has_list {
            let detail = format!("its element '{name}' has no list 'vertex_indices'");
            return Err(malformed("PLY", &detail));
        }
    }
    Ok(())
}

pub(super) fn parse(content: &[u8], parts: &mut Parts<'_>) -> Result<Mesh, MeshProblem> {
    let content = without_mark("PLY", content)?;
    let (header, body) = header(content)?;
    let mut body = std::borrow::Cow::Borrowed(body);
    let is_text = header.windows(6).any(|w| w == b" ascii");
    if is_text && !body.contains(&b'\n') {
        let line_ends = body.to_mut().iter_mut().filter(|b| **b == b'\r');
        line_ends.for_each(|b| *b = b'\n');
    }
    let mut reader = Reader::new(Cursor::new(header).chain(Cursor::new(body)));
    let vertices = Parser::<Vertex>::new();
    let faces = Parser::<Face>::new();
    let header = vertices.read_header(&mut reader).map_err(bad)?;
    check(&header, content.len())?;
    let mut mesh = Mesh::default();
    let (mut polygons, mut strips) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                mesh.vertices = read.map_err(bad)?.into_iter().map(|v| v.0).collect();
            }
            "face" | "tristrips" => {
                let read = faces.read_payload_for_element(&mut reader, element, &header);
                let lists = if name == "face" {
                    &mut polygons
                } else {
                    &mut strips
                };
                lists.extend(read.map_err(bad)?);
            }
            // Skip elements that are neither vertices nor faces.
            _ => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                read.map_err(bad)?;
            }
        }
    }
    if !parts.take(&[]) {
        return Ok(Mesh::default());
    }
    for Face(polygon) in polygons {
        push_polygon(&mut mesh.triangles, &polygon, &mesh.vertices)?;
    }
    for Face(strips) in strips {
        // −1, read as `u32::MAX`, separates strips.
        for strip in strips.split(|i| *i == u32::MAX) {
            push_strip(&mut mesh.triangles, strip);
        }
    }
    Ok(mesh)
}
