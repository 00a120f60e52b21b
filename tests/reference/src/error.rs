//! Errors of the reference solver.

/// Errors of meshing and of solving.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FemError {
    /// A material constant outside of its range.
    #[error("{name} is {value}; it has to be {range}")]
    Material {
        /// Name of the constant.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its allowed range.
        range: &'static str,
    },
    /// A mesh without a usable element.
    #[error("the mesh has no tetrahedra: choose a smaller size than {size_m} m")]
    NoElements {
        /// Edge length asked for, m.
        size_m: f64,
    },
    /// An element that is flat or inside out at rest.
    #[error("tetrahedron {element} has a rest Jacobian of {jacobian}; it has to be above 0")]
    Element {
        /// Index of the element.
        element: usize,
        /// Smallest determinant at its quadrature points, m³.
        jacobian: f64,
    },
    /// The sparse factorisation could not be set up.
    #[error("the sparse matrix of {unknowns} unknowns could not be analysed: {reason}")]
    Matrix {
        /// Free degrees of freedom.
        unknowns: usize,
        /// The linear algebra library's words.
        reason: String,
    },
    /// Newton's method did not find equilibrium at the smallest load step allowed.
    #[error(
        "no equilibrium beyond {:.1} % of the load (residual {residual_n:.3e} N after {iterations} \
         iterations): refine the mesh or lower the load",
        reached * 100.0
    )]
    NoEquilibrium {
        /// Share of the load that was carried.
        reached: f64,
        /// Largest unbalanced nodal force, N.
        residual_n: f64,
        /// Newton iterations of the last attempt.
        iterations: usize,
    },
}
