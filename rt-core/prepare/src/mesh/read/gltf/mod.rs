//! glTF and GLB, through the gltf crate. The crate checks the file's structure. Buffers and
//! accessors are read here, because the crate's readers trust them and accept neither embedded data
//! nor percent-encoded names.

mod data;
mod extensions;

use std::path::Path;

use gltf::mesh::Mode;
use nalgebra::Matrix4;

use self::data::Data;
use super::text::without_mark;
use super::{Parts, check_size, malformed, push_strip};
use crate::Vec3;
use crate::error::MeshProblem;
use crate::mesh::Mesh;

/// Nodes nested deeper than this are refused.
const DEPTH_MAX: usize = 64;

struct Reading<'a, 'b> {
    data: Data,
    parts: &'a mut Parts<'b>,
    /// True for nodes that were visited. A second visit is an error: with nodes of two parents, a
    /// short file could have endless paths.
    met: Vec<bool>,
    mesh: Mesh,
    bytes: u64,
}

pub(super) fn parse(
    content: &[u8],
    folder: &Path,
    parts: &mut Parts<'_>,
) -> Result<Mesh, MeshProblem> {
    let bad = |error: gltf::Error| malformed("glTF", &error);
    let content = without_mark("glTF", content)?;
    let file = gltf::Gltf::from_slice_without_validation(content).map_err(bad)?;
    let blob = file.blob;
    let mut root = file.document.into_json();
    extensions::check(&root)?;
    // The required extensions are checked already. The crate would refuse even those that concern
    // only textures.
    root.extensions_required.clear();
    check_positions(&root)?;
    let file = gltf::Document::from_json(root).map_err(bad)?;
    let mut reading = Reading {
        data: Data::read(&file, blob, folder)?,
        parts,
        met: vec![false; file.nodes().len()],
        mesh: Mesh::default(),
        bytes: content.len() as u64,
    };
    match file.default_scene().or_else(|| file.scenes().next()) {
        Some(scene) => {
            for node in scene.nodes() {
                reading.visit(&node, &Matrix4::identity(), false, 0)?;
            }
        }
        None => reading.visit_library(&file)?,
    }
    Ok(reading.mesh)
}

impl Reading<'_, '_> {
    /// Takes a file without a scene: the nodes without a parent, or all meshes if there are no
    /// nodes.
    fn visit_library(&mut self, file: &gltf::Document) -> Result<(), MeshProblem> {
        let mut is_child = vec![false; file.nodes().len()];
        for child in file.nodes().flat_map(|node| node.children()) {
            is_child[child.index()] = true;
        }
        for node in file.nodes().filter(|node| !is_child[node.index()]) {
            self.visit(&node, &Matrix4::identity(), false, 0)?;
        }
        if file.nodes().len() == 0 {
            for mesh in file.meshes() {
                if self.parts.take(&[mesh.name().unwrap_or_default()]) {
                    self.take(&mesh, &Matrix4::identity())?;
                }
            }
        }
        Ok(())
    }

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
        let mesh = node.mesh();
        let mesh_name = mesh.as_ref().and_then(gltf::Mesh::name);
        let names = [node.name(), mesh_name].map(Option::unwrap_or_default);
        let taken = self.parts.take(&names) || taken;
        if let Some(mesh) = mesh.filter(|_| taken) {
            self.take(&mesh, &world)?;
        }
        for child in node.children() {
            self.visit(&child, &world, taken, depth + 1)?;
        }
        Ok(())
    }

    fn take(&mut self, mesh: &gltf::Mesh<'_>, world: &Matrix4<f64>) -> Result<(), MeshProblem> {
        let first = self.mesh.triangles.len();
        for primitive in mesh.primitives() {
            self.take_primitive(&primitive, world)?;
        }
        // A node that mirrors its mesh turns the mesh inside out, so its triangles are turned back.
        if world.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
            for triangle in &mut self.mesh.triangles[first..] {
                triangle.swap(1, 2);
            }
        }
        Ok(())
    }

    fn take_primitive(
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
        // Many primitives may share one accessor, so its vertices are counted each time.
        let vertices = (self.mesh.vertices.len() as u64).saturating_add(positions.count() as u64);
        check_size(self.bytes, vertices / 3)?;
        let first = self.mesh.vertices.len() as u32;
        let place = |p: [f32; 3]| {
            let p = Vec3::from(p.map(f64::from));
            world.fixed_view::<3, 3>(0, 0) * p + world.fixed_view::<3, 1>(0, 3)
        };
        let points = self.data.positions(&positions)?;
        self.mesh.vertices.extend(points.into_iter().map(place));
        let corners = match &indices {
            Some(indices) => self.data.indices(indices)?,
            None => (0..count as u32).collect(),
        };
        let shift = |i: u32| i.saturating_add(first);
        let corners: Vec<u32> = corners.into_iter().map(shift).collect();
        let triangles = &mut self.mesh.triangles;
        match primitive.mode() {
            Mode::Triangles => triangles.extend(corners.as_chunks::<3>().0),
            Mode::TriangleStrip => push_strip(triangles, &corners),
            Mode::TriangleFan => {
                if let Some((&tip, rim)) = corners.split_first() {
                    triangles.extend(rim.array_windows().map(|&[a, b]| [tip, a, b]));
                }
            }
            // Points and lines are not a surface.
            _ => {}
        }
        Ok(())
    }
}

/// Checks that the accessors of all positions exist. The crate's validation uses the accessors'
/// numbers before it checks them.
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
