//! Work at a few organs of the built-in scene, to be repeated.

use shared_mem::scene::SceneFile;

use super::trial::{self, Found, Work};
use super::{compiled, organ_name};

/// Organs, and the work that is done at them.
const WORKS: [(&str, Work, u64); 2] = [("gallbladder", Work::Pull, 1), ("fat", Work::Sweep, 1)];

/// The largest values that the works left.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Left {
    /// Speed, m/s.
    pub(crate) speed_m_s: f32,
    /// Depth of an organ in another, m.
    pub(crate) inside_m: f32,
    /// Growth of an attachment, m.
    pub(crate) loose_m: f32,
    /// Number of works that tore tissue.
    pub(crate) torn: usize,
}

/// The built-in scene.
pub(crate) struct Sample(SceneFile);

impl Sample {
    /// Prepares the scene.
    ///
    /// # Errors
    /// When it cannot be prepared, in words.
    pub(crate) fn new() -> Result<Self, String> {
        compiled(false).map(Self)
    }

    /// The scene.
    pub(crate) const fn scene(&self) -> &SceneFile {
        &self.0
    }

    /// Does the works.
    ///
    /// # Errors
    /// When the scene cannot be run, in words.
    pub(crate) fn work(&self) -> Result<Left, String> {
        let mut left = Left::default();
        for (name, work, seed) in WORKS {
            let organs = 0..self.0.organs().len();
            let mut organs = organs.filter(|number| organ_name(&self.0, *number) == name);
            let organ = organs.next().ok_or_else(|| format!("no {name}"))?;
            let found = trial::run(&self.0, organ, work, seed)?;
            left.add(&found.ok_or_else(|| format!("{name} cannot be reached"))?);
        }
        Ok(left)
    }
}

impl Left {
    fn add(&mut self, found: &Found) {
        self.speed_m_s = self.speed_m_s.max(found.speed_m_s.value);
        self.inside_m = self.inside_m.max(found.inside_m.value);
        self.loose_m = self.loose_m.max(found.loose_m.value);
        self.torn += usize::from(found.is_torn);
    }
}
