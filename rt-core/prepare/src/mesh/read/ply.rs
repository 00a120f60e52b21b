//! PLY, text and binary, through ply-rs.

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::{check_size, malformed, push_polygon};
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

/// A face's indices as they are written. An index that no `u32` holds becomes `u32::MAX`, which is
/// out of range.
#[derive(Debug, Default)]
struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
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

pub(super) fn parse(content: &[u8]) -> Result<Mesh, MeshProblem> {
    let mut reader = Reader::new(std::io::Cursor::new(content));
    let vertices = Parser::<Vertex>::new();
    let faces = Parser::<Face>::new();
    let header = vertices.read_header(&mut reader).map_err(bad)?;
    for (name, element) in &header.elements {
        if name == "vertex" || name == "face" {
            check_size(content.len() as u64, element.count as u64)?;
        } else if element.count > content.len() || element.properties.is_empty() {
            // Elements without properties take no bytes, so any count of them would fit into any
            // file.
            let detail = format!(
                "announces {} of element '{name}' with {} properties in {} bytes",
                element.count,
                element.properties.len(),
                content.len()
            );
            return Err(malformed("PLY", &detail));
        }
    }
    let mut mesh = Mesh::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                mesh.vertices = read.map_err(bad)?.into_iter().map(|v| v.0).collect();
            }
            "face" => {
                let read = faces.read_payload_for_element(&mut reader, element, &header);
                for face in read.map_err(bad)? {
                    push_polygon(&mut mesh.triangles, &face.0);
                }
            }
            // Skip elements that are neither vertices nor faces.
            _ => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                read.map_err(bad)?;
            }
        }
    }
    Ok(mesh)
}
