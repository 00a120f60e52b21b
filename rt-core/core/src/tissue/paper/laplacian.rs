//! Laplacian coordinates (paper Eq. 6–8), with the fixed vector `L` as the paper has it.
//!
//! The paper: `c_center` = mean of the linked centres (Eq. 6); before the simulation
//! `L = c − c_center` (Eq. 7); in each iteration `c' = c_center' + L` (Eq. 8). A centre is its
//! rest position plus its displacement, `c' = X + u`, so
//! `X + u = mean(X_n) + mean(u_n) + X − mean(X_n)`, that is **`u = mean(u_n)`**: a sphere goes
//! where its neighbours have gone on average. `L` need not be stored, and no large coordinates
//! are subtracted.
//!
//! Known faults, kept because this is the paper's method: `L` does not rotate with the tissue, so a
//! rotated organ is pulled back; a step moves one sphere alone, so momentum is not conserved.

use crate::tissue::lanes::Lanes;

/// Step of a sphere with the displacement `own` towards its Laplacian target (paper Eq. 8): the
/// share `stiffness` of the distance. The displacements of its `linked` neighbours sum to `sum`. A
/// sphere without neighbours stays.
#[must_use]
#[inline(always)]
pub fn laplacian(own: Lanes, sum: Lanes, linked: usize, stiffness: f32) -> Lanes {
    if linked == 0 {
        return Lanes::ZERO;
    }
    (sum * Lanes::splat((linked as f32).recip()) - own) * Lanes::splat(stiffness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{self, Vec3};

    fn step(own: &Vec3, sum: &Vec3, linked: usize, stiffness: f32) -> Vec3 {
        laplacian(
            Lanes::new(own, 0.0),
            Lanes::new(sum, 0.0),
            linked,
            stiffness,
        )
        .vec3()
    }

    /// Eq. 6–8 in the paper's own form, on centres.
    fn paper(rest: &[Vec3], now: &[Vec3]) -> Vec3 {
        let mean = |c: &[Vec3]| (c[1] + c[2] + c[3]) / 3.0;
        let l = rest[0] - mean(rest);
        mean(now) + l
    }

    #[test]
    fn eq_6_to_8_by_hand() {
        // Neighbours at (±3, 0, 0) and (0, 3, 0): centre (0, 1, 0). The sphere at (0, 1, 2):
        // L = (0, 0, 2). The neighbours move by (3, 0, 0), 0 and (0, 0, 6): centre (1, 1, 2),
        // so the sphere belongs at (1, 1, 4).
        let rest = [
            Vec3::new(0.0, 1.0, 2.0),
            Vec3::new(3.0, 0.0, 0.0),
            Vec3::new(-3.0, 0.0, 0.0),
            Vec3::new(0.0, 3.0, 0.0),
        ];
        let moved = [
            Vec3::new(0.5, 0.0, 0.0),
            Vec3::new(3.0, 0.0, 0.0),
            Vec3::zeros(),
            Vec3::new(0.0, 0.0, 6.0),
        ];
        let now = [0, 1, 2, 3].map(|i| rest[i] + moved[i]);
        assert!(math::norm(&(paper(&rest, &now) - Vec3::new(1.0, 1.0, 4.0))) < 1.0e-6);
        let whole = step(&moved[0], &(moved[1] + moved[2] + moved[3]), 3, 1.0);
        assert!(math::norm(&(now[0] + whole - Vec3::new(1.0, 1.0, 4.0))) < 1.0e-6);
        let half = step(&moved[0], &(moved[1] + moved[2] + moved[3]), 3, 0.5);
        assert!(math::norm(&(half * 2.0 - whole)) < 1.0e-6);
    }

    #[test]
    fn a_rigid_shift_is_no_error_but_a_rotation_is() {
        let shift = Vec3::new(0.1, -0.2, 0.3);
        assert!(math::norm(&step(&shift, &(shift * 4.0), 4, 1.0)) < 1.0e-6);
        // A quarter turn about z of a sphere at (1, 0, 0) with one neighbour at the origin:
        // Eq. 8 wants it back at (1, 0, 0). This is the paper's fault, shown.
        let turned = Vec3::new(-1.0, 1.0, 0.0);
        let back = step(&turned, &Vec3::zeros(), 1, 1.0);
        assert!(math::norm(&(back + turned)) < 1.0e-6);
    }

    #[test]
    fn a_lone_sphere_stays() {
        assert!(math::norm(&step(&Vec3::x(), &Vec3::zeros(), 0, 1.0)) < f32::EPSILON);
    }
}
