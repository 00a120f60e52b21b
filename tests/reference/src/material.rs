//! The tissue's energy: stable neo-Hookean (Smith et al. 2018 without the logarithm). The
//! position-based solver minimises the same energy.
//!
//! `W(F) = μ/2 (F:F − 3) + λ/2 (det F − γ)²`, `λ = λ₀ + μ`, `γ = 1 + μ/λ`, up to a constant.
//! Linearised at rest it is Hooke's law with Lamé's `μ` and `λ₀`. It stays finite for inverted
//! elements (`det F ≤ 0`).

use nalgebra::{Matrix3, SMatrix};

use crate::FemError;

/// Energy of a neo-Hookean material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Law {
    /// Calot's law, finite for inverted elements.
    Stable,
    /// `W(F) = μ/2 (J^(−2/3) F:F − 3) + K/2 (J − 1)²`, `J = det F`: the law that other programs
    /// call neo-Hookean.
    Isochoric,
}

/// Derivative of the stress with respect to the deformation gradient, both flattened column by
/// column.
pub(crate) type Stiffness9 = SMatrix<f64, 9, 9>;

/// An isotropic neo-Hookean material in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa.
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density at rest, kg/m³.
    pub density_kg_m3: f64,
    mu: f64,
    lambda: f64,
    gamma: f64,
    law: Law,
}

impl Material {
    /// Makes a material. Computes Lamé's constants from `young_pa` and `poisson`.
    ///
    /// # Errors
    /// [`FemError::Material`] unless `young_pa > 0`, `0 <= poisson < 0.5` and `density_kg_m3 >= 0`,
    /// all finite.
    pub fn new(young_pa: f64, poisson: f64, density_kg_m3: f64) -> Result<Self, FemError> {
        let check = |name, value: f64, ok: bool, range| {
            if ok && value.is_finite() {
                Ok(())
            } else {
                Err(FemError::Material { name, value, range })
            }
        };
        check("young_pa", young_pa, young_pa > 0.0, "above 0")?;
        let elastic = (0.0..0.5).contains(&poisson);
        check("poisson", poisson, elastic, "from 0 to below 0.5")?;
        check(
            "density_kg_m3",
            density_kg_m3,
            density_kg_m3 >= 0.0,
            "0 or above",
        )?;
        let mu = young_pa / (2.0 * (1.0 + poisson));
        let lame = young_pa * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let lambda = lame + mu;
        Ok(Self {
            young_pa,
            poisson,
            density_kg_m3,
            mu,
            lambda,
            gamma: 1.0 + mu / lambda,
            law: Law::Stable,
        })
    }

    /// This material with the energy that other programs call neo-Hookean. It separates the change
    /// of volume from the change of shape: `μ/2 (J^(−2/3) F:F − 3) + K/2 (J − 1)²`.
    #[must_use]
    pub fn isochoric(self) -> Self {
        Self {
            law: Law::Isochoric,
            ..self
        }
    }

    /// Bulk modulus, Pa.
    #[must_use]
    pub fn bulk_pa(&self) -> f64 {
        self.lambda - self.mu / 3.0
    }

    /// Lamé's second constant (shear modulus), Pa.
    #[must_use]
    pub fn mu_pa(&self) -> f64 {
        self.mu
    }

    /// The energy's volume stiffness `λ₀ + μ`, Pa.
    #[must_use]
    pub fn lambda_pa(&self) -> f64 {
        self.lambda
    }

    /// The determinant of `F` at which the volume term alone is zero.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Energy per rest volume, J/m³; 0 if undeformed.
    #[must_use]
    pub fn energy(&self, f: &Matrix3<f64>) -> f64 {
        // Computed from F − 1, so that the energy of a small strain is not lost by rounding.
        let h = f - Matrix3::identity();
        let trace = h.trace();
        let second = 0.5 * (trace * trace - (h * h).trace()) + h.determinant();
        let growth = trace + second;
        if self.law == Law::Isochoric {
            let volume = 1.0 + growth;
            if volume <= 0.0 {
                return f64::INFINITY;
            }
            let shape = volume.powf(-2.0 / 3.0) * f.norm_squared() - 3.0;
            return 0.5 * self.mu * shape + 0.5 * self.bulk_pa() * growth * growth;
        }
        self.mu * (0.5 * h.norm_squared() - second) + 0.5 * self.lambda * growth * growth
    }

    /// First Piola–Kirchhoff stress `∂W/∂F`, Pa.
    #[must_use]
    pub fn stress(&self, f: &Matrix3<f64>) -> Matrix3<f64> {
        if self.law == Law::Isochoric {
            let volume = f.determinant();
            let scale = self.mu * volume.powf(-2.0 / 3.0);
            let pressure = self.bulk_pa() * (volume - 1.0);
            let across = scale * f.norm_squared() / (3.0 * volume);
            return scale * f + (pressure - across) * cofactor(f);
        }
        let pressure = self.lambda * (f.determinant() - self.gamma);
        self.mu * f + pressure * cofactor(f)
    }

    /// Derivative of the stress, `∂²W/∂F²`, Pa. With `project`, negative eigenvalues become zero,
    /// for Newton's method far from equilibrium.
    #[must_use]
    pub(crate) fn stiffness(&self, f: &Matrix3<f64>, project: bool) -> Stiffness9 {
        if self.law == Law::Isochoric {
            let h = self.numerical_stiffness(f);
            return if project {
                without_negative_eigenvalues(h)
            } else {
                h
            };
        }
        let cof = cofactor(f);
        let flat = SMatrix::<f64, 9, 1>::from_column_slice(cof.as_slice());
        let pressure = self.lambda * (f.determinant() - self.gamma);
        let mut h = Stiffness9::identity() * self.mu + flat * flat.transpose() * self.lambda;
        // Adds pressure · ∂cof(F)/∂F. The columns of cof are cross products of columns of F.
        for column in 0..3 {
            let (next, last) = ((column + 1) % 3, (column + 2) % 3);
            let (a, b) = (cross(&f.column(last).into()), cross(&f.column(next).into()));
            for row in 0..3 {
                for k in 0..3 {
                    // d(f_next × f_last) = [f_next]× df_last − [f_last]× df_next
                    h[(3 * column + row, 3 * last + k)] += pressure * b[(row, k)];
                    h[(3 * column + row, 3 * next + k)] -= pressure * a[(row, k)];
                }
            }
        }
        if project {
            without_negative_eigenvalues(h)
        } else {
            h
        }
    }

    /// Derivative of the stress by central differences, made symmetric.
    fn numerical_stiffness(&self, f: &Matrix3<f64>) -> Stiffness9 {
        let step = 1e-6;
        let mut h = Stiffness9::zeros();
        for j in 0..9 {
            let (mut plus, mut minus) = (*f, *f);
            plus[j] += step;
            minus[j] -= step;
            let slope = (self.stress(&plus) - self.stress(&minus)) / (2.0 * step);
            h.column_mut(j).copy_from_slice(slope.as_slice());
        }
        (h + h.transpose()) * 0.5
    }

    /// Closed form for a bar of Calot's law under uniaxial tension to `stretch`: its lateral
    /// stretch, and its nominal axial stress, Pa.
    #[must_use]
    pub fn uniaxial(&self, stretch: f64) -> (f64, f64) {
        // The lateral stress is zero: μ + λ (s t² − γ) s = 0.
        let lateral_squared = (self.gamma - self.mu / (self.lambda * stretch)) / stretch;
        let pressure = self.lambda * (stretch * lateral_squared - self.gamma);
        let stress = self.mu * stretch + pressure * lateral_squared;
        (lateral_squared.max(0.0).sqrt(), stress)
    }
}

/// Cofactor `det(F) F⁻ᵀ`. It exists for singular `F` too.
pub(crate) fn cofactor(f: &Matrix3<f64>) -> Matrix3<f64> {
    let (a, b, c) = (f.column(0), f.column(1), f.column(2));
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

fn cross(v: &nalgebra::Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

fn without_negative_eigenvalues(h: Stiffness9) -> Stiffness9 {
    let eigen = h.symmetric_eigen();
    if eigen.eigenvalues.min() >= 0.0 {
        return h;
    }
    let clamped = eigen.eigenvalues.map(|value| value.max(0.0));
    eigen.eigenvectors * Stiffness9::from_diagonal(&clamped) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tissue() -> Material {
        Material::new(5000.0, 0.45, 1060.0).expect("valid")
    }

    fn bent() -> Matrix3<f64> {
        Matrix3::new(1.2, 0.3, -0.1, 0.2, 0.8, 0.15, -0.25, 0.1, 1.1)
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for m in [tissue(), tissue().isochoric()] {
            compare_with_differences(&m);
        }
    }

    fn compare_with_differences(m: &Material) {
        let (f, step) = (bent(), 1e-6);
        let (stress, stiffness) = (m.stress(&f), m.stiffness(&f, false));
        for j in 0..9 {
            let (mut plus, mut minus) = (f, f);
            plus[j] += step;
            minus[j] -= step;
            let slope = (m.energy(&plus) - m.energy(&minus)) / (2.0 * step);
            assert!((slope - stress[j]).abs() < 1e-5 * m.young_pa, "stress {j}");
            let column = (m.stress(&plus) - m.stress(&minus)) / (2.0 * step);
            for i in 0..9 {
                let error = (column[i] - stiffness[(i, j)]).abs();
                assert!(error < 1e-5 * m.young_pa, "stiffness {i} {j}");
            }
        }
    }

    #[test]
    fn rest_is_free_of_stress_and_follows_hooke() {
        let m = tissue();
        for m in [m, m.isochoric()] {
            assert!(m.stress(&Matrix3::identity()).norm() < 1e-9);
            assert!(m.energy(&Matrix3::identity()).abs() < 1e-9);
            // At small strain both laws equal the same Hooke's law.
            let strain = Matrix3::new(2.0, 1.0, 0.0, 1.0, -1.0, 0.5, 0.0, 0.5, 0.3) * 1e-6;
            let lame = m.lambda_pa() - m.mu_pa();
            let hooke = strain * (2.0 * m.mu_pa()) + Matrix3::identity() * (lame * strain.trace());
            let stress = m.stress(&(Matrix3::identity() + strain));
            assert!((stress - hooke).norm() < 1e-4 * hooke.norm());
        }
        let strain = 1e-6;
        let (lateral, stress) = m.uniaxial(1.0 + strain);
        assert!((stress / strain / m.young_pa - 1.0).abs() < 1e-4);
        assert!(((1.0 - lateral) / strain / m.poisson - 1.0).abs() < 1e-4);
    }

    #[test]
    fn projection_leaves_no_negative_curvature() {
        let squeezed = Matrix3::from_diagonal(&nalgebra::Vector3::new(0.3, 0.4, 0.5));
        let raw = tissue().stiffness(&squeezed, false).symmetric_eigen();
        assert!(raw.eigenvalues.min() < 0.0, "the case must need it");
        let h = tissue().stiffness(&squeezed, true).symmetric_eigen();
        assert!(h.eigenvalues.min() > -1e-6 * h.eigenvalues.max());
    }

    #[test]
    fn invalid_values_are_named() {
        assert!(Material::new(0.0, 0.3, 1.0).is_err());
        assert!(Material::new(1.0, 0.5, 1.0).is_err());
        assert!(Material::new(1.0, f64::NAN, 1.0).is_err());
        assert!(Material::new(1.0, 0.3, f64::INFINITY).is_err());
    }
}
