//! Multirate coupling: constraints between two organs with unequal numbers of substeps.
//!
//! A constraint acts in windows; the number of windows in a tick is a power of two. A window begins
//! with a substep of the finer organ. A sphere of the coarser organ is then in the middle of a
//! longer substep. The constraint uses the position that the sphere will have at the window's end,
//! and the impulse on the sphere acts over the whole of the longer substep. A window may also
//! contain several substeps of the finer organ. The position at the window's end is then
//! extrapolated, and the impulse is spread over the substeps.

use crate::capacity::MAX_ORGANS;
use crate::scene::Scene;
use crate::time::TICK_S;
use crate::tissue::lanes::Lanes;
use crate::tissue::{Bodies, Node};

/// One step of a constraint between organs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SubstepWindow {
    /// Index of the finest substep with which it begins.
    now: u32,
    /// Length of the window, and of a tick, in finest substeps.
    length: u32,
    finest: u32,
}

impl SubstepWindow {
    /// The window that begins with the finest substep `now`, of a constraint that has `times`
    /// windows in a tick; `None` if none begins there.
    pub(crate) fn due(now: u32, times: u32, scene: &Scene<'_>) -> Option<Self> {
        let finest = scene.finest();
        let length = (finest / times.max(1)).max(1);
        now.is_multiple_of(length).then_some(Self {
            now,
            length,
            finest,
        })
    }

    /// Length of the window, s.
    pub(crate) fn step_s(&self) -> f32 {
        TICK_S * self.length as f32 / self.finest as f32
    }
}

/// Position of a [`SubstepWindow`] within the substep of an organ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// Share of the organ's substep that has passed when the window ends; above 1 if the window is
    /// longer.
    elapsed: f32,
    /// Length of the substep divided by the length of the window.
    longer: f32,
}

impl Pace {
    /// Pace of an organ with as many substeps as there are windows.
    pub(crate) const SAME: Self = Self {
        elapsed: 1.0,
        longer: 1.0,
    };

    /// Pace of an organ with this number of substeps. All lengths are powers of two.
    pub(crate) fn of(substeps: u32, at: &SubstepWindow) -> Self {
        let own = (at.finest / substeps.max(1)).max(1);
        let passed = at.now % own + at.length;
        Self {
            elapsed: passed as f32 / own as f32,
            longer: own as f32 / at.length as f32,
        }
    }

    /// Displacement in one of the organ's substeps, per positional impulse for the window and per
    /// inverse mass.
    #[inline(always)]
    pub(crate) fn spread(&self) -> f32 {
        self.longer * self.longer.min(1.0)
    }

    /// Paces of all organs.
    pub(crate) fn of_all(scene: &Scene<'_>, at: &SubstepWindow) -> [Self; MAX_ORGANS] {
        let mut all = [Self::SAME; MAX_ORGANS];
        for (pace, organ) in all.iter_mut().zip(scene.organs) {
            *pace = Self::of(organ.substeps, at);
        }
        all
    }
}

/// A sphere of a constraint, at the place of the [`SubstepWindow`] within the substep of the
/// sphere's organ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Multirate {
    pace: Pace,
    /// Inverse mass, 1/kg.
    weight_per_kg: f32,
}

impl Multirate {
    /// State of a sphere whose organ has this pace.
    #[inline(always)]
    pub(crate) fn of(sphere: u32, pace: Pace, bodies: &Bodies) -> Self {
        Self {
            pace,
            weight_per_kg: bodies.weight_per_kg(sphere),
        }
    }

    /// Displacement of the sphere in its substep up to the end of the window, m.
    #[inline(always)]
    pub(crate) fn way(&self, node: &Node) -> Lanes {
        node.step_m.scaled(self.pace.elapsed)
    }

    /// Displacement of the sphere in its substep up to the start of the window, m.
    pub(crate) fn way_before(&self, node: &Node) -> Lanes {
        node.step_m
            .scaled(self.pace.elapsed - self.pace.longer.recip())
    }

    /// Displacement at the end of the window per unit of [`Multirate::push`], 1/kg.
    #[inline(always)]
    pub(crate) fn weight(&self) -> f32 {
        self.weight_per_kg * self.pace.elapsed * self.pace.longer
    }

    /// Applies a positional impulse for the window, m kg, so that it acts over the whole substep.
    #[inline(always)]
    pub(crate) fn push(&self, node: &mut Node, push_m_kg: Lanes) {
        node.step_m = node.step_m + push_m_kg.scaled(self.weight_per_kg * self.pace.longer);
    }
}
