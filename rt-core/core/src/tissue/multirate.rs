//! Multirate coupling: constraints between two organs with unequal numbers of substeps.
//!
//! They are solved in the substeps of the finer organ. A sphere of the coarser organ is then in the
//! middle of its own, longer substep.

use crate::scene::Scene;
use crate::time::TICK_S;
use crate::tissue::lanes::Lanes;
use crate::tissue::{Bodies, Node};

/// One step of a constraint between organs. A tick has a fixed number of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SubstepWindow {
    /// Index of the finest substep with which it begins.
    now: u32,
    /// Its length, in finest substeps; and the number of finest substeps in a tick.
    length: u32,
    finest: u32,
}

impl SubstepWindow {
    /// The step that begins with the finest substep `now`, of a constraint that acts `times` in a
    /// tick; `None` if none begins there.
    pub(crate) fn due(now: u32, times: u32, scene: &Scene<'_>) -> Option<Self> {
        let finest = scene.finest();
        let length = (finest / times.max(1)).max(1);
        now.is_multiple_of(length).then_some(Self {
            now,
            length,
            finest,
        })
    }

    /// Length of the step, s.
    pub(crate) fn step_s(&self) -> f32 {
        TICK_S * self.length as f32 / self.finest as f32
    }
}

/// State of a sphere within its own organ's substep, as a [`SubstepWindow`] sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Multirate {
    /// Share of its own substep that has passed when the window ends.
    elapsed: f32,
    /// Number of windows in its substep.
    longer: f32,
    /// Inverse mass, 1/kg.
    weight_per_kg: f32,
}

impl Multirate {
    pub(crate) fn of(sphere: u32, at: &SubstepWindow, scene: &Scene<'_>, bodies: &Bodies) -> Self {
        let own = (at.finest / scene.substeps_of(*bodies.organ.at(sphere))).max(1);
        let longer = (own / at.length).max(1) as f32;
        let ended = (at.now % own) / at.length + 1;
        Self {
            elapsed: ended as f32 / longer,
            longer,
            weight_per_kg: bodies.weight_per_kg(sphere),
        }
    }

    /// Displacement of the sphere in its substep up to the end of the window, m.
    pub(crate) fn way(&self, node: &Node) -> Lanes {
        node.step_m.scaled(self.elapsed)
    }

    /// Displacement of the sphere in its substep up to the start of the window, m.
    pub(crate) fn way_before(&self, node: &Node) -> Lanes {
        node.step_m.scaled(self.elapsed - self.longer.recip())
    }

    /// Displacement at the end of the window per unit of [`Multirate::push`], 1/kg.
    pub(crate) fn weight(&self) -> f32 {
        self.weight_per_kg * self.elapsed * self.longer
    }

    /// Applies an impulse of `push_m_kg` over the window's length. It acts over the whole substep.
    pub(crate) fn push(&self, node: &mut Node, push_m_kg: Lanes) {
        node.step_m = node.step_m + push_m_kg.scaled(self.weight_per_kg * self.longer);
    }
}
