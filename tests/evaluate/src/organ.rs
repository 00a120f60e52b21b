//! The organs on which methods are compared.

use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use scene_prepare::mesh::{Mesh, mend, read};
use scene_prepare::recipe::Closing;
use scene_prepare::shape::{Form, Shape, skin};

type Point = Vector3<f64>;

/// An organ under test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Organ {
    /// A liver of three ellipsoids and a fossa, 214 mm long, 1.17 L. It is smooth, so that
    /// reference solutions converge.
    Liver,
    /// Calot's built-in gallbladder.
    Gallbladder,
    /// A woman's liver (Human Reference Atlas), if this machine has its mesh.
    Atlas,
}

/// Environment variable with the folder of real organ meshes. An organ without a mesh in it is left
/// out.
pub(crate) const ANATOMY: &str = "CALOT_ANATOMY";

impl Organ {
    /// Name of the organ in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Liver => "liver",
            Self::Gallbladder => "gallbladder",
            Self::Atlas => "atlas liver",
        }
    }

    /// Surface of the organ.
    ///
    /// # Errors
    /// When this machine has no usable mesh of a real organ. The error gives the reason in words.
    pub(crate) fn mesh(self) -> Result<Mesh, String> {
        match self {
            Self::Liver => Ok(skin(&liver, LIVER_BOUNDS.map(Point::from), 0.0035)),
            Self::Gallbladder => Ok(Shape::from(Form::Gallbladder).mesh()),
            Self::Atlas => {
                let folder = std::env::var_os(ANATOMY).ok_or(format!(
                    "{ANATOMY} is not set; set it to the folder of real organ meshes"
                ))?;
                let path = Path::new(&folder).join("derived/liver_8128.obj");
                let mesh = read(&path, &[]).and_then(|mesh| mend(&mesh, Closing::Auto));
                mesh.map(|mended| mended.mesh)
                    .map_err(|e| format!("{}: {e}", path.display()))
            }
        }
    }
}

const LIVER_BOUNDS: [[f64; 3]; 2] = [[-0.115, -0.080, -0.060], [0.120, 0.075, 0.055]];

/// Signed distance to the liver: right lobe, left lobe, a bulge below and a fossa, smoothly joined.
fn liver(p: &Point) -> f64 {
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), -0.25);
    let at = |x, y, z| p - Point::new(x, y, z);
    let right = ellipsoid(&at(-0.032, 0.0, 0.0), [0.072, 0.062, 0.042]);
    let left = ellipsoid(&(turned * at(0.050, 0.006, 0.004)), [0.060, 0.048, 0.030]);
    let bulge = ellipsoid(&at(-0.060, -0.030, -0.012), [0.035; 3]);
    let fossa = ellipsoid(&at(-0.010, -0.035, -0.052), [0.018, 0.040, 0.024]);
    let whole = join(join(right, left, 0.03), bulge, 0.02);
    -join(-whole, fossa, 0.012)
}

/// Approximate signed distance to an ellipsoid around the origin (after Quilez).
fn ellipsoid(p: &Point, radii: [f64; 3]) -> f64 {
    let r = Point::from(radii);
    let (once, twice) = (p.component_div(&r), p.component_div(&r.component_mul(&r)));
    let k = once.norm();
    k * (k - 1.0) / twice.norm().max(1e-9)
}

/// The smaller of two distances, rounded over `width`.
fn join(a: f64, b: f64, width: f64) -> f64 {
    let share = (0.5 + 0.5 * (b - a) / width).clamp(0.0, 1.0);
    b + (a - b) * share - width * share * (1.0 - share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_liver_is_closed_and_has_a_livers_size() {
        let mesh = Organ::Liver.mesh().expect("built in");
        assert!(mesh.is_closed());
        assert!(
            (1.0e-3..1.35e-3).contains(&mesh.volume()),
            "{}",
            mesh.volume()
        );
        let [min, max] = mesh.bounds();
        assert!((0.20..0.23).contains(&(max.x - min.x)));
    }
}
