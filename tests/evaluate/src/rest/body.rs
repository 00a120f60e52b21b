//! Bodies for the tests of rest: their surfaces, as files for a recipe.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::{Rotation3, Unit, Vector3};
use scene_prepare::mesh::Mesh;
use scene_prepare::shape::skin;

type V3 = Vector3<f64>;

/// Form of a body of one organ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// A cube of 40 mm.
    Cube,
    /// A ball of 40 mm.
    Ball,
    /// A plate of 60 × 40 × 5 mm.
    Plate,
    /// A rod of 100 × 10 × 10 mm.
    Rod,
    /// A hollow ball of 50 mm with a wall of 4 mm.
    Shell,
    /// Two balls of 30 mm with a neck of 8 mm.
    Dumbbell,
}

impl Form {
    /// All forms.
    pub(super) const ALL: [Self; 6] = [
        Self::Cube,
        Self::Ball,
        Self::Plate,
        Self::Rod,
        Self::Shell,
        Self::Dumbbell,
    ];

    /// Name of the form in the table and of its file.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Cube => "cube",
            Self::Ball => "ball",
            Self::Plate => "plate",
            Self::Rod => "rod",
            Self::Shell => "shell",
            Self::Dumbbell => "dumbbell",
        }
    }

    /// Half of the body's size along the axes, m.
    fn half_m(self) -> V3 {
        match self {
            Self::Cube => V3::repeat(0.020),
            Self::Ball => V3::repeat(0.020),
            Self::Plate => V3::new(0.030, 0.020, 0.0025),
            Self::Rod => V3::new(0.050, 0.005, 0.005),
            Self::Shell => V3::repeat(0.025),
            Self::Dumbbell => V3::new(0.035, 0.015, 0.015),
        }
    }

    /// Signed distance of a point from the surface, m.
    fn distance_m(self, p: &V3) -> f64 {
        let half = self.half_m();
        match self {
            Self::Cube | Self::Plate | Self::Rod => {
                let over = p.abs() - half;
                over.sup(&V3::zeros()).norm() + over.max().min(0.0)
            }
            Self::Ball => p.norm() - half.x,
            Self::Shell => (p.norm() - half.x).max(half.x - 0.004 - p.norm()),
            Self::Dumbbell => {
                let end = V3::new(p.x.abs() - 0.020, p.y, p.z);
                let neck = V3::new((p.x.abs() - 0.020).max(0.0), p.y, p.z);
                (end.norm() - half.y).min(neck.norm() - 0.004)
            }
        }
    }

    /// The surface, rotated about its middle.
    fn surface(self, turn: &Rotation3<f64>) -> Mesh {
        let half = self.half_m();
        let thinnest = match self {
            Self::Shell => 0.004,
            Self::Dumbbell => 0.008,
            _ => 2.0 * half.min(),
        };
        let cell_m = (thinnest / 5.0).min(half.max() / 15.0);
        let back = turn.inverse();
        let room = V3::repeat(half.norm() + 3.0 * cell_m);
        skin(
            &|p: &V3| self.distance_m(&(back * p)),
            [-room, room],
            cell_m,
        )
    }

    /// Writes the surface, rotated about an oblique axis, as an OBJ file into a folder. Returns the
    /// file's name.
    ///
    /// # Errors
    /// When the file cannot be written, in words.
    pub(super) fn write(self, folder: &Path, turn_deg: f64) -> Result<String, String> {
        let axis = Unit::new_normalize(V3::new(1.0, 2.0, 0.5));
        let turn = Rotation3::from_axis_angle(&axis, turn_deg.to_radians());
        let name = format!("{}-{turn_deg:.0}.obj", self.name());
        write(folder, &name, &self.surface(&turn), 0.0)?;
        Ok(name)
    }

    /// Writes the surface, moved down along z, as an OBJ file into a folder. Returns the file's
    /// name.
    ///
    /// # Errors
    /// When the file cannot be written, in words.
    pub(super) fn write_below(self, folder: &Path, down_m: f64) -> Result<String, String> {
        let name = format!("{}-below.obj", self.name());
        write(folder, &name, &self.surface(&Rotation3::identity()), down_m)?;
        Ok(name)
    }
}

fn write(folder: &Path, name: &str, mesh: &Mesh, down_m: f64) -> Result<(), String> {
    let mut text = String::new();
    for p in &mesh.vertices {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z - down_m);
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| v + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    let path = folder.join(name);
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}
