//! Nearest points of a mesh, and lines that meet it, with parry's bounding volume hierarchy.

use parry3d::glamx;
use parry3d::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d::shape::TriMesh;

use super::closest_on_triangle;
use crate::Vec3;
use crate::mesh::Mesh;

/// Finds the points of a mesh that are nearest to given places.
pub struct Nearest<'a> {
    mesh: &'a Mesh,
    tree: TriMesh,
}

fn single(v: &Vec3) -> glamx::Vec3 {
    glamx::Vec3::new(v.x as f32, v.y as f32, v.z as f32)
}

impl<'a> Nearest<'a> {
    /// Prepares a search over this mesh; `None` if it has no triangles.
    #[must_use]
    pub fn new(mesh: &'a Mesh) -> Option<Self> {
        let vertices = mesh.vertices.iter().map(single).collect();
        let tree = TriMesh::new(vertices, mesh.triangles.clone()).ok()?;
        Some(Self { mesh, tree })
    }

    /// The nearest point of the surface. Single precision finds the triangle, double precision the
    /// point on the triangle.
    #[must_use]
    pub fn point(&self, p: &Vec3) -> Vec3 {
        let (_, (triangle, _)) = self
            .tree
            .project_local_point_and_get_location(single(p), false);
        let corners = self.mesh.corners(self.mesh.triangles[triangle as usize]);
        closest_on_triangle(p, &corners)
    }

    /// `D(c)`, paper Eq. 1: the smallest distance from a point to any triangle, m.
    #[must_use]
    pub fn distance(&self, p: &Vec3) -> f64 {
        (self.point(p) - p).norm()
    }

    /// True if the straight line between two points meets the surface.
    #[must_use]
    pub fn blocks(&self, from: &Vec3, to: &Vec3) -> bool {
        let ray = Ray::new(single(from), single(&(to - from)));
        self.tree.cast_local_ray(&ray, 1.0, true).is_some()
    }
}
