//! The recipe: a TOML file with the organs, the sources of their surfaces, their materials, their
//! attachments, and the room around them.
//!
//! Every key has a default, except `name` and the organs' names, kinds and surfaces. An unknown key
//! is an error. Axes are those of the Human Reference Atlas: x to the patient's left, y to the
//! head, z to the front.

mod check;
mod locate;
mod material;
mod raw;
mod sourced;

use std::path::{Path, PathBuf};

use shared_mem::scene::OrganKind;

pub use material::Material;
pub use sourced::{Sourced, sourced};

use crate::Vec3;
use crate::error::RecipeError;
use crate::shape::Shape;

/// Fewest spheres of one organ.
pub const SPHERES_MIN: usize = 8;
/// Largest number of spheres of one organ, and of a whole scene in the realtime process.
pub const SPHERES_MAX: usize = rt_core::capacity::MAX_SPHERES;

/// Largest number of bytes of a recipe's file.
const BYTES_MAX: u64 = 1 << 20;

/// A checked recipe.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// The scene's name.
    pub name: String,
    /// Time budget of a tick, µs on one core ([`crate::cost`]). The scene gets about as many
    /// spheres as the budget allows, in the proportions of the organs' counts. Tubes and organs
    /// with an error budget keep their counts.
    pub tick_us: Option<f64>,
    /// The room around the organs. A value that is `None` has a default, or follows from the
    /// organs.
    pub room: RoomPlan,
    /// The organs, at least one, with unique names.
    pub organs: Vec<OrganPlan>,
    /// Sutures and bands between places of organs, or from an organ to the world.
    pub ties: Vec<Tie>,
    /// Stones in the gallbladder. By default there are none.
    pub stones: Option<StonesPlan>,
}

/// Stones in the gallbladder, all of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StonesPlan {
    /// Number of stones.
    pub count: u32,
    /// Diameter of each, m.
    pub diameter_m: f64,
    /// Volume inside the gallbladder's wall, m³: bile and stones.
    pub room_m3: f64,
}

/// The room as the recipe gives it, world frame, SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RoomPlan {
    /// Gravity, m/s². By default, the patient lies on her back, head 20° up.
    pub gravity_m_s2: Option<Vec3>,
    /// The instrument's port, m.
    pub instrument_port_m: Option<Vec3>,
    /// Length of the instrument from handle to tip, m.
    pub instrument_length_m: Option<f64>,
    /// The endoscope's port, m.
    pub endoscope_port_m: Option<Vec3>,
    /// Point in the middle of the picture, m.
    pub look_at_m: Option<Vec3>,
    /// Distance from the camera to `look_at_m`, m.
    pub camera_distance_m: Option<f64>,
    /// Period of breathing, s. By default the patient does not breathe.
    pub breath_s: Option<f64>,
    /// The instrument's trocar. By default it neither rubs nor resists tilting.
    pub trocar: Option<TrocarPlan>,
    /// Direction that is up in the picture.
    pub up: Option<Vec3>,
    /// Pose of the haptic device's base.
    pub device: Option<Frame>,
    /// Pose of the tracker's transmitter.
    pub tracker: Option<Frame>,
    /// Index of the organ on which the scripted hand works.
    pub target_organ: Option<usize>,
    /// Wanted place of the scripted hand's target, m. The best reachable point near it is taken.
    pub target_near_m: Option<Vec3>,
}

/// The instrument's trocar. Untilted, it points to the scripted hand's target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrocarPlan {
    /// Friction of the shaft that slides in the seal, N.
    pub sliding_n: f64,
    /// Friction at which a resting shaft breaks away, N. By default the sliding friction.
    pub breakaway_n: f64,
    /// Elasticity of the abdominal wall against tilting, N m/rad.
    pub wall_nm_rad: f64,
}

/// A frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin, m.
    pub position_m: Vec3,
    /// Unit quaternion x y z w.
    pub orientation: [f64; 4],
}

/// One organ to build.
#[derive(Debug, Clone, PartialEq)]
pub struct OrganPlan {
    /// Name, unique in the scene.
    pub name: String,
    /// Kind of organ.
    pub kind: OrganKind,
    /// Source of the surface.
    pub surface: Surface,
    /// Treatment of an open surface.
    pub closing: Closing,
    /// Treatment of a surface in separate pieces.
    pub pieces: Pieces,
    /// Number of spheres. With an error budget it is the first guess.
    pub spheres: usize,
    /// Error budget: distance from the spheres within which 95 % of the skin must lie, m. The
    /// smallest tried count that keeps the budget is taken.
    pub gap_95_m: Option<f64>,
    /// Counts of spheres at the scene's coarser levels of detail, finest first. A level beyond the
    /// last count uses the last count. Without counts, every level uses the count of the finest
    /// level.
    pub coarser: Vec<usize>,
    /// Packing of the spheres.
    pub packing: Packing,
    /// Share of gravity that acts on the organ. 0, the default: the surface is the organ's shape in
    /// the body, in balance with its weight. 1: the surface is the unloaded shape.
    pub gravity_share: f64,
    /// Displacement of the organ's held spheres at full inspiration, world frame, m.
    pub breath_m: Vec3,
    /// Material.
    pub material: Material,
    /// Regions of space. A sphere is held if its centre lies in one of them. In a
    /// [`Region::Near`], the sphere's surface counts instead of its centre.
    pub held: Vec<Region>,
    /// Other organs to which this one is attached.
    pub attached: Vec<Attached>,
    /// Layers of cells, for tissue that is taken away bit by bit.
    pub layers: Option<Layers>,
}

/// Layers of hexahedra between an inner organ and this organ's own surface.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Name of the inner organ. Cross-sections are perpendicular to its longest axis.
    pub around: String,
    /// Number of layers.
    pub count: usize,
    /// Approximate length of a cell's edges along the inner organ and around it, m.
    pub cell_m: f64,
}

/// Another organ to which this one is attached.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attached {
    /// The other organ's name.
    pub to: String,
    /// Spheres whose surface is no farther than this from the other organ's skin are attached, m.
    pub within_m: f64,
}

/// A thread or band between two places: `[[suture]]` or `[[band]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// One end, in an organ.
    pub from: Place,
    /// The other end.
    pub to: Place,
    /// Length at rest before the tie is shortened, m. By default it is the distance of the ends.
    pub length_m: Option<f64>,
    /// Length by which the tie is shortened, m. A suture to the world is shortened over the first
    /// two seconds.
    pub drawn_m: f64,
    /// Stiffness, N/m. By default, a suture is a 3-0 thread, and a band is a bar of the first
    /// organ's tissue, as thick as the sphere at which it starts.
    pub stiffness_n_m: Option<f64>,
    /// True for a suture, which pulls and never pushes.
    pub is_thread: bool,
}

/// An end of a tie.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Place {
    /// The sphere of an organ that is nearest to a point, world frame, m.
    Organ {
        /// The organ's name.
        organ: String,
        /// The point.
        near_m: [f64; 3],
    },
    /// A point of the world, m, which never moves.
    World {
        /// The point.
        world_m: [f64; 3],
    },
}

/// Source of an organ's surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// A mesh file.
    Mesh {
        /// The file.
        path: PathBuf,
        /// Names of the parts to take; all if empty.
        parts: Vec<String>,
        /// Metres per unit of the file. `None` takes its numbers for metres, or for millimetres if
        /// the mesh would be more than 2 m across.
        unit_m: Option<f64>,
        /// Directions of the file's axes.
        axes: Axes,
    },
    /// A built-in shape.
    Shape(Box<Shape>),
}

/// Treatment of an open surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Closing {
    /// Refuse it.
    Refuse,
    /// Close each loop with a patch. Refuse a surface that is still open or overlaps itself.
    Fill,
    /// Close each loop with a patch. Wrap a surface that is still open or overlaps itself. Make a
    /// hollow wall solid.
    Auto,
    /// Build a new closed surface around the mesh.
    Wrap,
    /// Build a new closed surface from the parts that can be reached from outside. A hollow organ
    /// becomes solid, and openings narrower than a tenth of the organ are closed.
    Solid,
}

/// Treatment of a surface in separate pieces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pieces {
    /// Link the pieces. Refuse a piece farther from the larger ones than the spacing of the
    /// spheres.
    #[default]
    Near,
    /// Link all pieces, however far apart they are.
    Join,
    /// Keep only the largest piece.
    Largest,
}

/// Directions of the three axes of a mesh file. The names are radiology's: the letters are the
/// directions in which the axes point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Deserialize)]
pub enum Axes {
    /// The scene's own axes: to the patient's left, to her head, to her front. People in glTF files
    /// stand like this, with y up.
    #[default]
    #[serde(rename = "LSA")]
    Lsa,
    /// To the left, to the back, to the head: DICOM, ITK, VTK files of segmentations.
    #[serde(rename = "LPS")]
    Lps,
    /// To the right, to the front, to the head: NIfTI, 3D Slicer, FreeSurfer.
    #[serde(rename = "RAS")]
    Ras,
}

impl Axes {
    /// A point of the file in the scene's axes.
    #[must_use]
    pub fn in_scene(self, p: Vec3) -> Vec3 {
        match self {
            Self::Lsa => p,
            Self::Lps => Vec3::new(p.x, p.z, -p.y),
            Self::Ras => Vec3::new(-p.x, p.z, p.y),
        }
    }
}

/// Options of a single mesh. The fields have the names of a recipe's keys.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// Unit of the mesh's numbers; `None`: metres, or millimetres for a mesh more than 2 m across.
    pub unit: Option<Unit>,
    /// Factor on top of the unit, 0.001 to 1000.
    pub scale: f64,
    /// Directions of the mesh's axes.
    pub axes: Axes,
    /// Kind of organ. It decides material, number of spheres, colour and usual size.
    pub kind: OrganKind,
    /// Treatment of separate pieces.
    pub pieces: Pieces,
    /// Treatment of an open surface.
    pub closing: Closing,
    /// Names of the parts to take; all if empty.
    pub parts: Vec<String>,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            unit: None,
            scale: 1.0,
            axes: Axes::default(),
            kind: OrganKind::Liver,
            pieces: Pieces::default(),
            closing: Closing::Auto,
            parts: Vec::new(),
        }
    }
}

/// The kind of organ that a recipe calls by this name.
///
/// # Errors
/// The error lists the known names.
pub fn organ_kind(name: &str) -> Result<OrganKind, String> {
    check::organ_kind(name)
}

/// The unit of a mesh file's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
pub enum Unit {
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
    /// Inches.
    #[serde(rename = "in")]
    Inch,
}

impl Unit {
    /// Metres per unit.
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e-2,
            Self::Millimetre => 1e-3,
            Self::Inch => 0.0254,
        }
    }
}

/// Packing of spheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// Even spacing (Lloyd) with the outer layer just under the skin, for good mechanics.
    Even,
    /// Along the centre line, for ducts and vessels.
    Line,
    /// The paper's packing: medial axis, radius reduction (Eq. 1), filling (Eq. 2).
    Paper,
}

/// A part of space, world frame, m.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Region {
    /// The box between two corners.
    Box {
        /// Smallest coordinates.
        min_m: [f64; 3],
        /// Largest coordinates.
        max_m: [f64; 3],
    },
    /// The half space beyond a plane.
    Plane {
        /// A point of the plane.
        point_m: [f64; 3],
        /// Direction to the held side.
        normal: [f64; 3],
    },
    /// The inside of a ball.
    Ball {
        /// Centre.
        center_m: [f64; 3],
        /// Radius.
        radius_m: f64,
    },
    /// The space near another organ's skin.
    Near {
        /// The other organ's name.
        organ: String,
        /// Largest distance from that skin to the surface of a held sphere.
        within_m: f64,
    },
    /// The lowest part of the organ along gravity, as a share of the organ's height, 0..=1.
    Base(f64),
}

impl Recipe {
    /// Reads a recipe from text. Relative paths of meshes start at `meshes_dir`.
    ///
    /// # Errors
    /// The error names the line, the key, the value and the allowed range.
    pub fn parse(text: &str, file: &str, meshes_dir: &Path) -> Result<Self, RecipeError> {
        check::check(text, file, meshes_dir)
    }

    /// Reads a recipe file. Relative paths of meshes start at `meshes_dir`, by default the recipe's
    /// folder.
    ///
    /// # Errors
    /// As for [`Recipe::parse`], and when the file cannot be read.
    pub fn load(path: &Path, meshes_dir: Option<&Path>) -> Result<Self, RecipeError> {
        let file = path.display().to_string();
        let unreadable = |why: &dyn std::fmt::Display| RecipeError {
            file: file.clone(),
            line: 0,
            key: "recipe".into(),
            problem: format!("cannot be read ({why}); give the path of a TOML recipe"),
        };
        // Only plain files are read, because a pipe or device might have no end.
        let found = std::fs::metadata(path).map_err(|error| unreadable(&error))?;
        if !found.is_file() {
            return Err(unreadable(&"it is not a plain file"));
        }
        if found.len() > BYTES_MAX {
            let why = format!("{} bytes; allowed: at most {BYTES_MAX}", found.len());
            return Err(unreadable(&why));
        }
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(&error))?;
        let beside = path.parent().unwrap_or(Path::new("."));
        Self::parse(&text, &file, meshes_dir.unwrap_or(beside))
    }

    /// The built-in scene: a liver and a gallbladder, both built-in shapes.
    ///
    /// # Errors
    /// Never in a build whose tests pass.
    pub fn built_in() -> Result<Self, RecipeError> {
        Self::parse(BUILT_IN, "built-in recipe", Path::new("."))
    }

    /// Calot's triangle: liver, gallbladder, ducts, arteries, fat, connective tissue, stomach,
    /// duodenum and intestine. With `variant`, cystic duct and cystic artery take their variant
    /// courses.
    ///
    /// # Errors
    /// Never in a build whose tests pass.
    pub fn triangle(variant: bool) -> Result<Self, RecipeError> {
        let text = if variant {
            TRIANGLE.replace("\"usual\"", "\"variant\"")
        } else {
            TRIANGLE.into()
        };
        Self::parse(&text, "built-in recipe of Calot's triangle", Path::new("."))
    }

    /// The phantom for basic drills.
    ///
    /// # Errors
    /// Never in a build whose tests pass.
    pub fn phantom() -> Result<Self, RecipeError> {
        Self::parse(PHANTOM, "built-in recipe of the phantom", Path::new("."))
    }

    /// A scene of a single organ from a mesh, of the kind that `options` names. Without a unit the
    /// mesh's numbers are taken for metres, or for millimetres if the mesh would be more than 2 m
    /// across. The report names the guessed unit.
    ///
    /// # Errors
    /// When the path has no usable name.
    pub fn from_mesh(path: &Path, options: &MeshOptions) -> Result<Self, RecipeError> {
        check::from_mesh(path, options)
    }

    /// Number of levels of detail, the finest included.
    #[must_use]
    pub fn levels(&self) -> usize {
        let coarser = self.organs.iter().map(|organ| organ.coarser.len()).max();
        1 + coarser.unwrap_or(0)
    }

    /// Level `level` of the recipe, 0 the finest, as a recipe of one level. The time budget applies
    /// to the finest level only. A coarser count replaces an organ's error budget.
    #[must_use]
    pub fn level(&self, level: usize) -> Self {
        let mut recipe = self.clone();
        for organ in &mut recipe.organs {
            let coarser = std::mem::take(&mut organ.coarser);
            let last = coarser.len().min(level);
            if let Some(count) = last.checked_sub(1).and_then(|i| coarser.get(i)) {
                organ.spheres = *count;
                organ.gap_95_m = None;
            }
        }
        if level > 0 {
            recipe.tick_us = None;
        }
        recipe
    }

    /// Returns the recipe with `levels` levels, each with half the spheres of the one before.
    /// `finest` has the organs' counts at the finest level. Tubes keep their counts at every level.
    #[must_use]
    pub fn with_levels(mut self, levels: usize, finest: &[usize]) -> Self {
        for (organ, &count) in self.organs.iter_mut().zip(finest) {
            organ.coarser.clear();
            if organ.packing != Packing::Line {
                let halves = (1..levels).map(|level| count >> level);
                organ.coarser = halves.take_while(|&n| n >= SPHERES_MIN).collect();
            }
        }
        self
    }

    /// Returns the recipe with this many spheres in all and without its budgets. The organs keep
    /// their shares of the spheres.
    ///
    /// # Errors
    /// When an organ would get too few spheres, or the scene too many.
    pub fn with_spheres(mut self, spheres: usize) -> Result<Self, RecipeError> {
        let before: usize = self.organs.iter().map(|organ| organ.spheres).sum();
        let share = spheres as f64 / before.max(1) as f64;
        self.tick_us = None;
        for organ in &mut self.organs {
            organ.spheres = (organ.spheres as f64 * share).round() as usize;
            organ.gap_95_m = None;
        }
        let least = self.organs.iter().map(|o| o.spheres).min().unwrap_or(0);
        if spheres > SPHERES_MAX || least < SPHERES_MIN {
            return Err(RecipeError {
                file: self.name,
                line: 0,
                key: "spheres".into(),
                problem: format!(
                    "is {spheres}, which leaves {least} to the smallest of {} organs; allowed: at \
                     least {SPHERES_MIN} an organ and {SPHERES_MAX} together",
                    self.organs.len()
                ),
            });
        }
        Ok(self)
    }
}

/// Text of the recipe of Calot's triangle.
pub const TRIANGLE: &str = include_str!("../../recipes/triangle.toml");
/// Text of the built-in recipe.
pub const BUILT_IN: &str = include_str!("../../recipes/built-in.toml");
/// The recipe of the phantom for basic drills.
pub const PHANTOM: &str = include_str!("../../recipes/phantom.toml");
