//! Two organs in unequal substeps, and what acts between them in those of the finer.

use crate::scene::Scene;
use crate::time::TICK_S;
use crate::tissue::lanes::Lanes;
use crate::tissue::{Bodies, Node};

/// A step of what acts between organs so and so often in a tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// The finest step with which it begins.
    now: u32,
    /// How many of the finest ones it is long, and how many a tick has.
    length: u32,
    finest: u32,
}

impl Moment {
    /// What acts so many `times` in a tick has a step that begins with the finest step `now`, or none.
    pub(crate) fn due(now: u32, times: u32, scene: &Scene<'_>) -> Option<Self> {
        let finest = scene.finest();
        let length = (finest / times.max(1)).max(1);
        now.is_multiple_of(length).then_some(Self {
            now,
            length,
            finest,
        })
    }

    /// How long it is, s.
    pub(crate) fn step_s(&self) -> f32 {
        TICK_S * self.length as f32 / self.finest as f32
    }
}

/// How a sphere that is on its way through its own organ's substep takes part in a [`Moment`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// Share of its own substep that is over when the moment ends.
    gone: f32,
    /// How many moments its substep has.
    longer: f32,
    /// Inverse mass, 1/kg.
    weight_per_kg: f32,
}

impl Pace {
    pub(crate) fn of(sphere: u32, at: &Moment, scene: &Scene<'_>, bodies: &Bodies) -> Self {
        let own = (at.finest / scene.substeps_of(*bodies.organ.at(sphere))).max(1);
        let longer = (own / at.length).max(1) as f32;
        let ended = (at.now % own) / at.length + 1;
        Self {
            gone: ended as f32 / longer,
            longer,
            weight_per_kg: bodies.weight_per_kg(sphere),
        }
    }

    /// How far the sphere has gone in its substep when the moment ends, m.
    pub(crate) fn way(&self, node: &Node) -> Lanes {
        node.step_m.scaled(self.gone)
    }

    /// The same when it begins.
    pub(crate) fn way_before(&self, node: &Node) -> Lanes {
        node.step_m.scaled(self.gone - self.longer.recip())
    }

    /// How far it is by then for a push on it ([`Pace::push`]), 1/kg.
    pub(crate) fn weight(&self) -> f32 {
        self.weight_per_kg * self.gone * self.longer
    }

    /// Gives it an impulse of `push_m_kg` over the moment's length, which acts for the whole of its substep.
    pub(crate) fn push(&self, node: &mut Node, push_m_kg: Lanes) {
        node.step_m = node.step_m + push_m_kg.scaled(self.weight_per_kg * self.longer);
    }
}
