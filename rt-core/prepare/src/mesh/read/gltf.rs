//! glTF and GLB, through the gltf crate. Buffers come from the GLB itself or from a file beside it.

use std::path::Path;

use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use nalgebra::Matrix4;

use super::{BYTES_MAX, Mesh, check_size, malformed, no_such_part};
use crate::Vec3;
use crate::error::MeshProblem;

/// Nodes nested deeper than this are refused.
const DEPTH_MAX: usize = 64;

struct Reading<'a> {
    buffers: Vec<Vec<u8>>,
    wanted: &'a [String],
    found: Vec<bool>,
    /// Nodes that were met. A second visit is an error: nodes with two parents would let a short
    /// file have endless paths.
    met: Vec<bool>,
    mesh: Mesh,
    bytes: u64,
}

pub(super) fn parse(content: &[u8], folder: &Path, wanted: &[String]) -> Result<Mesh, MeshProblem> {
    let bad = |error: gltf::Error| malformed("glTF", &error);
    let unchecked = gltf::Gltf::from_slice_without_validation(content).map_err(bad)?;
    check_positions(unchecked.as_json())?;
    let mut file = gltf::Gltf::from_slice(content).map_err(bad)?;
    let blob = file.blob.take();
    let mut reading = Reading {
        buffers: read_buffers(&file, blob, folder)?,
        wanted,
        found: vec![false; wanted.len()],
        met: vec![false; file.nodes().len()],
        mesh: Mesh::default(),
        bytes: content.len() as u64,
    };
    let scene = file.default_scene().or_else(|| file.scenes().next());
    let scene = scene.ok_or_else(|| malformed("glTF", "it has no scene"))?;
    for node in scene.nodes() {
        reading.visit(&node, &Matrix4::identity(), wanted.is_empty(), 0)?;
    }
    if let Some(missing) = reading.found.iter().position(|found| !found) {
        let names: Vec<&str> = file.nodes().filter_map(|node| node.name()).collect();
        return Err(no_such_part(&wanted[missing], names.into_iter()));
    }
    Ok(reading.mesh)
}

fn read_buffers(
    file: &gltf::Gltf,
    mut blob: Option<Vec<u8>>,
    folder: &Path,
) -> Result<Vec<Vec<u8>>, MeshProblem> {
    let announced = file.buffers().map(|buffer| buffer.length() as u64);
    let announced = announced.fold(0, u64::saturating_add);
    if announced > BYTES_MAX {
        let detail = format!("announces {announced} bytes of data; allowed: at most {BYTES_MAX}");
        return Err(malformed("glTF", &detail));
    }
    let mut buffers = Vec::new();
    for buffer in file.buffers() {
        let content = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().unwrap_or_default(),
            gltf::buffer::Source::Uri(uri) if uri.starts_with("data:") => {
                return Err(malformed(
                    "glTF",
                    "embeds its data as text; export it as .glb",
                ));
            }
            gltf::buffer::Source::Uri(uri) => {
                let plain = !uri.contains(['/', '\\']) && !uri.contains("..");
                if !plain {
                    let detail = format!(
                        "its data '{uri}' is not a plain file name; put the file beside it"
                    );
                    return Err(malformed("glTF", &detail));
                }
                let mut content = super::content(&folder.join(uri))
                    .map_err(|problem| malformed("glTF", &format!("its data '{uri}' {problem}")))?;
                // Data beyond the announced length are unused. Cut them off: many buffers may name
                // one large file.
                content.truncate(buffer.length());
                content.shrink_to_fit();
                content
            }
        };
        if content.len() < buffer.length() {
            let detail = format!(
                "truncated: buffer {} has {} bytes, but announces {}",
                buffer.index(),
                content.len(),
                buffer.length()
            );
            return Err(malformed("glTF", &detail));
        }
        buffers.push(content);
    }
    Ok(buffers)
}

impl Reading<'_> {
    fn visit(
        &mut self,
        node: &gltf::Node<'_>,
        parent: &Matrix4<f64>,
        taken: bool,
        depth: usize,
    ) -> Result<(), MeshProblem> {
        if depth > DEPTH_MAX {
            return Err(malformed(
                "glTF",
                &format!("nodes are nested more than {DEPTH_MAX} deep"),
            ));
        }
        if std::mem::replace(&mut self.met[node.index()], true) {
            let detail = format!("node {} has more than one parent", node.index());
            return Err(malformed("glTF", &detail));
        }
        let own = Matrix4::from(node.transform().matrix()).map(f64::from);
        let world = parent * own;
        let mut taken = taken;
        for name in [node.name(), node.mesh().and_then(|mesh| mesh.name())]
            .into_iter()
            .flatten()
        {
            if let Some(index) = self.wanted.iter().position(|wanted| wanted == name) {
                self.found[index] = true;
                taken = true;
            }
        }
        if taken {
            for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
                self.take(&primitive, &world)?;
            }
        }
        for child in node.children() {
            self.visit(&child, &world, taken, depth + 1)?;
        }
        Ok(())
    }

    fn take(
        &mut self,
        primitive: &gltf::Primitive<'_>,
        world: &Matrix4<f64>,
    ) -> Result<(), MeshProblem> {
        let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
            return Ok(());
        };
        let indices = primitive.indices();
        let count = indices
            .as_ref()
            .map_or(positions.count(), gltf::Accessor::count);
        check_size(self.bytes, (self.mesh.triangles.len() + count / 3) as u64)?;
        // Many primitives may share one accessor, so their vertices are counted each time.
        let vertices = (self.mesh.vertices.len() as u64).saturating_add(positions.count() as u64);
        check_size(self.bytes, vertices / 3)?;
        check_accessor(&positions, Dimensions::Vec3, &[DataType::F32])?;
        if let Some(indices) = &indices {
            let whole = [DataType::U8, DataType::U16, DataType::U32];
            check_accessor(indices, Dimensions::Scalar, &whole)?;
        }
        let buffers = &self.buffers;
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let Some(points) = reader.read_positions() else {
            return Err(malformed(
                "glTF",
                "positions lie outside of the file's data",
            ));
        };
        let first = self.mesh.vertices.len() as u32;
        let place = |p: [f32; 3]| {
            let p = Vec3::from(p.map(f64::from));
            world.fixed_view::<3, 3>(0, 0) * p + world.fixed_view::<3, 1>(0, 3)
        };
        self.mesh.vertices.extend(points.map(place));
        let corners: Vec<u32> = match (reader.read_indices(), indices) {
            (Some(indices), _) => indices.into_u32().collect(),
            (None, None) => (0..count as u32).collect(),
            (None, Some(_)) => {
                return Err(malformed("glTF", "indices lie outside of the file's data"));
            }
        };
        let corners: Vec<u32> = corners
            .into_iter()
            .map(|i| i.saturating_add(first))
            .collect();
        match primitive.mode() {
            Mode::Triangles => self.mesh.triangles.extend(corners.as_chunks::<3>().0),
            Mode::TriangleStrip => {
                for (i, t) in corners.windows(3).enumerate() {
                    let t = if i % 2 == 0 {
                        [t[0], t[1], t[2]]
                    } else {
                        [t[1], t[0], t[2]]
                    };
                    self.mesh.triangles.push(t);
                }
            }
            Mode::TriangleFan => super::push_polygon(&mut self.mesh.triangles, &corners),
            // Points and lines are not a surface.
            _ => {}
        }
        Ok(())
    }
}

/// Checks the numbers of the positions' accessors. The crate's own validation uses them before it
/// knows that they exist.
fn check_positions(root: &gltf::json::Root) -> Result<(), MeshProblem> {
    let wanted = gltf::json::validation::Checked::Valid(gltf::Semantic::Positions);
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut positions = primitives.filter_map(|primitive| primitive.attributes.get(&wanted));
    match positions.find(|index| index.value() >= root.accessors.len()) {
        None => Ok(()),
        Some(index) => Err(malformed(
            "glTF",
            &format!(
                "a mesh's positions are accessor {}, but there are only {} accessors",
                index.value(),
                root.accessors.len()
            ),
        )),
    }
}

/// Checks an accessor. The crate's readers trust that its elements are of the kind that its use
/// asks for and fit its view, and that sparse accessors are well formed.
fn check_accessor(
    accessor: &gltf::Accessor<'_>,
    shape: Dimensions,
    types: &[DataType],
) -> Result<(), MeshProblem> {
    let outside = || {
        malformed(
            "glTF",
            &format!("accessor {} reaches beyond its data", accessor.index()),
        )
    };
    if accessor.sparse().is_some() {
        return Err(malformed(
            "glTF",
            "has sparse accessors; export it without them",
        ));
    }
    let (found, element) = (accessor.dimensions(), accessor.data_type());
    if found != shape || !types.contains(&element) {
        let detail = format!(
            "accessor {} is {found:?} of {element:?}; it must be {shape:?} of one of {types:?}",
            accessor.index()
        );
        return Err(malformed("glTF", &detail));
    }
    let view = accessor.view().ok_or_else(outside)?;
    let stride = view.stride().unwrap_or(accessor.size());
    let needed = accessor
        .count()
        .checked_sub(1)
        .and_then(|last| last.checked_mul(stride))
        .and_then(|at| at.checked_add(accessor.size()))
        .and_then(|end| end.checked_add(accessor.offset()));
    match needed {
        Some(needed) if needed <= view.length() && stride >= accessor.size() => Ok(()),
        _ => Err(outside()),
    }
}
