//! Errors of the reference solver.

/// Errors of meshing, of materials and of solving.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FemError {
    /// A material constant outside of its range.
    #[error("{name} is {value}; allowed: {range}")]
    Material {
        /// Name of the constant.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its allowed range.
        range: &'static str,
    },
    /// A mesh without a usable element.
    #[error(
        "the mesh has no tetrahedra at an edge length of {size_m} m; choose one above 0 that is smaller than the body"
    )]
    NoElements {
        /// Requested edge length, m.
        size_m: f64,
    },
    /// An element that is flat or inside out at rest.
    #[error(
        "tetrahedron {element} has a Jacobian of {jacobian} m³ at rest; allowed: above 0; repair the mesh there"
    )]
    Element {
        /// Index of the element.
        element: usize,
        /// Smallest determinant at its quadrature points, m³.
        jacobian: f64,
    },
    /// The sparse factorisation cannot be set up.
    #[error("the sparse matrix of {unknowns} unknowns could not be analysed: {reason}")]
    Matrix {
        /// Free degrees of freedom.
        unknowns: usize,
        /// The linear algebra library's message.
        reason: String,
    },
    /// Newton's method finds no equilibrium at the smallest allowed step of the load.
    #[error(
        "no equilibrium beyond {:.1} % of the load (residual {residual_n:.3e} N after {iterations} \
         iterations): refine the mesh or lower the load",
        reached * 100.0
    )]
    NoEquilibrium {
        /// Reached share of the load.
        reached: f64,
        /// Largest unbalanced nodal force, N.
        residual_n: f64,
        /// Newton iterations of the last attempt.
        iterations: usize,
    },
}
