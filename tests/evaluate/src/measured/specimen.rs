//! Specimens, prepared by Calot: a cylinder between two plates, and a block held at one end.

use nalgebra::Vector3;
use scene_prepare::held::Plane;
use scene_prepare::mesh::Mesh;
use scene_prepare::shape::skin;
use scene_prepare::skin::ContactSkin;
use shared_mem::scene::OrganKind;

use crate::body::{Body, Tissue, V3};
use crate::prepared::{prepared, prepared_as};

type Point = Vector3<f64>;

/// Depth of the tissue beyond a plane, in spacings of the spheres. The outer layer of spheres lies
/// half a spacing below the skin; preparation moves it onto the plane.
const BEYOND_SPACINGS: f64 = 0.6;
/// Edge of the skin's triangles, m.
const EDGE_M: f64 = 1.5e-3;

/// A cylinder between two plates, its axis along z, its lower end at z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cylinder {
    pub(super) radius_m: f64,
    pub(super) height_m: f64,
}

impl Cylinder {
    /// Area of an end, m².
    pub(super) fn area_m2(&self) -> f64 {
        std::f64::consts::PI * self.radius_m * self.radius_m
    }

    /// The cylinder as a body of about `spheres` spheres. The spheres on the plates are marked in
    /// `supported`. Tissue beyond the plates is left out.
    ///
    /// # Errors
    /// The reason in words.
    pub(super) fn body(&self, spheres: usize, tissue: Tissue) -> Result<Body, String> {
        let beyond_m = beyond_m(self.area_m2() * self.height_m, spheres);
        let mesh = self.skin([beyond_m; 2], EDGE_M);
        let planes = [end(0.0, -1.0), end(self.height_m, 1.0)];
        let (mut body, _) = prepared(&mesh, spheres, tissue, &planes)?;
        let supported = std::mem::take(&mut body.supported);
        body.tets
            .retain(|tet| tet.nodes.iter().any(|n| !supported[*n]));
        body.supported = supported;
        Ok(body)
    }

    /// The cylinder with its lower end bonded to a table, and its contact skin.
    ///
    /// # Errors
    /// The reason in words.
    pub(super) fn on_table(
        &self,
        spheres: usize,
        tissue: Tissue,
    ) -> Result<(Body, ContactSkin), String> {
        let beyond_m = beyond_m(self.area_m2() * self.height_m, spheres);
        let mesh = self.skin([beyond_m, 0.0], 2.0 * EDGE_M);
        prepared(&mesh, spheres, tissue, &[end(0.0, -1.0)])
    }

    /// The cylinder as a tube (a chain of beads), and the length between its two grips, m. Beads in
    /// the grips are marked in `supported`.
    ///
    /// # Errors
    /// The reason in words.
    pub(super) fn tube(
        &self,
        kind: OrganKind,
        beads: usize,
        gripped_m: f64,
        tissue: Tissue,
    ) -> Result<(Body, f64), String> {
        let mesh = self.skin([0.0; 2], 0.2 * self.radius_m);
        let (mut body, _) = prepared_as(kind, &mesh, beads, tissue, &[])?;
        let grips = [gripped_m, self.height_m - gripped_m].map(|z| z as f32);
        let is_held = |x: &V3| x.z <= grips[0] || x.z >= grips[1];
        body.supported = body.rest_m.iter().map(is_held).collect();
        let held = || {
            body.rest_m
                .iter()
                .map(|x| x.z)
                .filter(|z| !(grips[0]..grips[1]).contains(z))
        };
        let lower = held().filter(|z| *z <= grips[0]).fold(f32::MIN, f32::max);
        let upper = held().filter(|z| *z >= grips[1]).fold(f32::MAX, f32::min);
        Ok((body, f64::from(upper - lower)))
    }

    /// Surface of the cylinder, extended by `longer_m` below and above.
    fn skin(&self, longer_m: [f64; 2], edge_m: f64) -> Mesh {
        let radius_m = self.radius_m;
        let [low_m, high_m] = [-longer_m[0], self.height_m + longer_m[1]];
        let distance = |p: &Point| {
            let round = p.x.hypot(p.y) - radius_m;
            round.max(low_m - p.z).max(p.z - high_m)
        };
        let low = Point::new(-radius_m, -radius_m, low_m).add_scalar(-2.0 * edge_m);
        let high = Point::new(radius_m, radius_m, high_m).add_scalar(2.0 * edge_m);
        skin(&distance, [low, high], edge_m)
    }
}

/// A plane across the cylinder's axis.
fn end(z: f64, up: f64) -> Plane {
    Plane {
        point_m: Point::z() * z,
        normal: Point::z() * up,
    }
}

/// A block along x, held at x = 0 and beyond.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub(super) length_m: f64,
    /// Width and height, m.
    pub(super) side_m: f64,
}

impl Block {
    /// The block as a body of about `spheres` spheres. Held spheres are marked in `supported`.
    ///
    /// # Errors
    /// The reason in words.
    pub(super) fn body(&self, spheres: usize, tissue: Tissue) -> Result<Body, String> {
        let (length_m, half_m) = (self.length_m, 0.5 * self.side_m);
        let beyond_m = beyond_m(length_m * self.side_m * self.side_m, spheres);
        let middle_m = 0.5 * (length_m - beyond_m);
        let distance = |p: &Point| {
            let along = (p.x - middle_m).abs() - 0.5 * (length_m + beyond_m);
            along.max(p.y.abs() - half_m).max(p.z.abs() - half_m)
        };
        let low = Point::new(-beyond_m, -half_m, -half_m).add_scalar(-2.0 * EDGE_M);
        let high = Point::new(length_m, half_m, half_m).add_scalar(2.0 * EDGE_M);
        let mesh = skin(&distance, [low, high], EDGE_M);
        let plane = Plane {
            point_m: Point::zeros(),
            normal: -Point::x(),
        };
        Ok(prepared(&mesh, spheres, tissue, &[plane])?.0)
    }
}

/// Length of the tissue beyond a plane, m.
fn beyond_m(volume_m3: f64, spheres: usize) -> f64 {
    BEYOND_SPACINGS * (volume_m3 / spheres.max(1) as f64).cbrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_has_spheres_on_both_plates_and_the_tissue_between_them() {
        let cylinder = Cylinder {
            radius_m: 0.025,
            height_m: 0.030,
        };
        let body = cylinder.body(250, Tissue::LIVER).expect("prepared");
        let on = |z: f32| {
            let near = |x: &&V3| (x.z - z).abs() < 1e-5;
            body.rest_m.iter().filter(near).count()
        };
        assert!(on(0.0) > 15 && on(0.030) > 15, "{} {}", on(0.0), on(0.030));
        let volume: f64 = body.tets.iter().map(|t| f64::from(t.volume_m3)).sum();
        let exact = cylinder.area_m2() * cylinder.height_m;
        // A tetrahedron with a corner beyond a plate counts with its whole volume.
        assert!((volume / exact - 1.0).abs() < 0.08, "{volume} {exact}");
    }
}
