//! The recipe: a TOML file that names organs, where their surfaces come from, what they are made
//! of, where they are held, and the room around them.
//!
//! Everything except `name` and the organs' names, kinds and surfaces has a default. An unknown key
//! is an error. Axes are the atlas': x to the patient's left, y to the head, z to the front.

mod check;
mod locate;
mod material;
mod raw;

use std::path::{Path, PathBuf};

use shared_mem::scene::OrganKind;

pub use material::Material;

use crate::Vec3;
use crate::error::RecipeError;
use crate::shape::Shape;

/// Spheres of one organ, at least.
pub const SPHERES_MIN: usize = 8;
/// Spheres of one organ, at most: the realtime process holds no more in a whole scene.
pub const SPHERES_MAX: usize = rt_core::capacity::MAX_SPHERES;

/// Bytes of a recipe's file, at most.
const BYTES_MAX: u64 = 1 << 20;

/// A checked recipe.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// Scene's name.
    pub name: String,
    /// Time budget of a tick, µs on one core ([`crate::cost`]): as many spheres as it allows are
    /// taken, shared as the organs' counts are. Tubes and organs with an error budget keep theirs.
    pub tick_us: Option<f64>,
    /// Room around the organs; a `None` is derived from the organs.
    pub room: RoomPlan,
    /// Organs, at least one, names unique.
    pub organs: Vec<OrganPlan>,
    /// Sutures and bands between places of organs, or to the world.
    pub ties: Vec<Tie>,
}

/// The room as the recipe gives it, world frame, SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RoomPlan {
    /// Gravity, m/s². Default: supine, head 20° up.
    pub gravity_m_s2: Option<Vec3>,
    /// The instrument's trocar.
    pub instrument_port_m: Option<Vec3>,
    /// Handle to tip.
    pub instrument_length_m: Option<f64>,
    /// The endoscope's port.
    pub endoscope_port_m: Option<Vec3>,
    /// Point in the middle of the picture.
    pub look_at_m: Option<Vec3>,
    /// Camera to that point.
    pub camera_distance_m: Option<f64>,
    /// Time of a breath, s. Default: nobody breathes.
    pub breath_s: Option<f64>,
    /// Up in the picture.
    pub up: Option<Vec3>,
    /// Haptic device's base: position and quaternion x y z w.
    pub device: Option<Frame>,
    /// Tracker's transmitter.
    pub tracker: Option<Frame>,
    /// Organ that the scripted hand works on.
    pub target_organ: Option<usize>,
    /// Wanted place of the target; the best reachable point near it is taken.
    pub target_near_m: Option<Vec3>,
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
    /// Source of its surface.
    pub surface: Surface,
    /// Treatment of an open surface.
    pub closing: Closing,
    /// Treatment of a surface in separate pieces.
    pub pieces: Pieces,
    /// Number of spheres; the first guess if there is an error budget.
    pub spheres: usize,
    /// Error budget: 95 % of the skin may be no farther than this from the spheres, m. The
    /// smallest count that keeps it is taken.
    pub gap_95_m: Option<f64>,
    /// Counts of the scene's coarser levels, finest first. A level beyond the last takes the last;
    /// without any, every level has the finest count.
    pub coarser: Vec<usize>,
    /// Packing of the spheres.
    pub packing: Packing,
    /// Share of gravity that acts. Default 0: the surface is the shape in the body, where weight
    /// is in balance. 1: it is the unloaded shape.
    pub gravity_share: f64,
    /// Displacement of its held spheres with a breath, m.
    pub breath_m: Vec3,
    /// Material.
    pub material: Material,
    /// Spheres whose centre is in one of these are attached to the surroundings.
    pub held: Vec<Region>,
    /// Organs that it is grown to.
    pub attached: Vec<Attached>,
    /// Tissue that is taken away bit by bit: its cells.
    pub layers: Option<Layers>,
}

/// Layered tissue: hexahedra between what the organ lies around and its own surface.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Name of the organ that it lies around: the course along which the cross-sections stand.
    pub around: String,
    /// Number of layers.
    pub count: usize,
    /// Edge of a cell along the course and around it, about, m.
    pub cell_m: f64,
}

/// Another organ that this one is grown to.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attached {
    /// That organ's name.
    pub to: String,
    /// Spheres whose surface is no farther than this from its skin are tied to it, m.
    pub within_m: f64,
}

/// A thread or band: `[[suture]]` or `[[band]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// One end, in an organ.
    pub from: Place,
    /// The other.
    pub to: Place,
    /// Length when slack, m. Default: as far as the ends lie apart.
    pub length_m: Option<f64>,
    /// By how much shorter it is than that, m: a suture to the world is drawn in by it within two
    /// seconds.
    pub drawn_m: f64,
    /// Force per stretch, N/m. Default: a 3-0 suture, or a band of the organ's tissue as thick as
    /// the sphere that it ends at.
    pub stiffness_n_m: Option<f64>,
    /// Pulls and never pushes: a suture.
    pub is_thread: bool,
}

/// End of a tie.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Place {
    /// At the sphere of an organ that is nearest to a point, world frame, m.
    Organ {
        /// The organ's name.
        organ: String,
        /// The point.
        near_m: [f64; 3],
    },
    /// At a point of the world, m: it never moves.
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
        /// Names of the parts to take; empty: all.
        parts: Vec<String>,
        /// Metres a file unit; `None`: metres, or millimetres if it is more than 2 m across.
        unit_m: Option<f64>,
    },
    /// A shape of our own.
    Shape(Box<Shape>),
}

/// Treatment of an open surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Closing {
    /// Refuse it.
    Refuse,
    /// Close each loop with a patch; refuse what cannot be closed so.
    Fill,
    /// Close each loop with a patch; wrap what cannot be closed so; make solid what is a hollow
    /// wall.
    Auto,
    /// Build a new closed surface around it.
    Wrap,
    /// Build a new closed surface from what is seen from outside: hollow organs become solid,
    /// openings narrower than a tenth of the organ are closed.
    Solid,
}

/// Treatment of a surface in separate pieces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pieces {
    /// Link pieces that are no farther apart than the spheres, refuse others.
    #[default]
    Near,
    /// Link them however far apart they are.
    Join,
    /// Keep only the largest.
    Largest,
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
}

impl Unit {
    /// Metres a unit.
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e-2,
            Self::Millimetre => 1e-3,
        }
    }
}

/// Packing of spheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// Even spacing (Lloyd), outer layer just under the skin: best for mechanics.
    Even,
    /// Along the centre line: for ducts and vessels.
    Line,
    /// The paper's: medial axis, radius reduction (Eq. 1), filling (Eq. 2).
    Paper,
}

/// A part of space, world frame, m.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Region {
    /// Between two corners.
    Box {
        /// Smallest coordinates.
        min_m: [f64; 3],
        /// Largest coordinates.
        max_m: [f64; 3],
    },
    /// Beyond a plane.
    Plane {
        /// A point on it.
        point_m: [f64; 3],
        /// To the held side.
        normal: [f64; 3],
    },
    /// Inside a ball.
    Ball {
        /// Centre.
        center_m: [f64; 3],
        /// Radius.
        radius_m: f64,
    },
    /// Near another organ's skin.
    Near {
        /// That organ's name.
        organ: String,
        /// Distance of the sphere's surface from that skin.
        within_m: f64,
    },
    /// The lowest share of the organ's height, along gravity, 0..=1.
    Base(f64),
}

impl Recipe {
    /// Reads a recipe from text. Relative mesh paths are looked up in `meshes_dir`.
    ///
    /// # Errors
    /// Names the line, the key, the value, what is allowed.
    pub fn parse(text: &str, file: &str, meshes_dir: &Path) -> Result<Self, RecipeError> {
        check::check(text, file, meshes_dir)
    }

    /// Reads a recipe file. Relative mesh paths are looked up in `meshes_dir`, by default beside
    /// the recipe.
    ///
    /// # Errors
    /// As [`Recipe::parse`], and when the file cannot be read.
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
            let why = format!("{} bytes, allowed are {BYTES_MAX}", found.len());
            return Err(unreadable(&why));
        }
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(&error))?;
        let beside = path.parent().unwrap_or(Path::new("."));
        Self::parse(&text, &file, meshes_dir.unwrap_or(beside))
    }

    /// The built-in scene: a liver and a gallbladder of our own shapes.
    ///
    /// # Errors
    /// Never in a build whose tests pass.
    pub fn built_in() -> Result<Self, RecipeError> {
        Self::parse(BUILT_IN, "built-in recipe", Path::new("."))
    }

    /// Calot's triangle: the built-in scene with ducts, arteries, stomach and intestine; with the
    /// variant course of duct and artery, if asked for.
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

    /// A scene of a single organ, of kind liver, from a mesh. Without a unit its numbers are taken
    /// for metres or, if it would be more than 2 m across, for millimetres, and the report says
    /// so.
    ///
    /// # Errors
    /// When the path has no usable name.
    pub fn from_mesh(path: &Path, unit: Option<Unit>) -> Result<Self, RecipeError> {
        check::from_mesh(path, unit)
    }

    /// Number of levels of detail, the finest included.
    #[must_use]
    pub fn levels(&self) -> usize {
        let coarser = self.organs.iter().map(|organ| organ.coarser.len()).max();
        1 + coarser.unwrap_or(0)
    }

    /// Level `level` of it, 0 the finest, as a recipe of one level. Budgets choose the finest only.
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
    /// `finest` are the organs' counts. Tubes have few spheres and keep them.
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

    /// Returns the recipe with this many spheres in all, shared among the organs as before. Budgets
    /// no longer choose.
    ///
    /// # Errors
    /// When an organ would get too few, or the scene too many.
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
                    "is {spheres}, which leaves {least} to the smallest of {} organs; allowed are at \
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
