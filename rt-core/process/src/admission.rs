//! Cost of a scene on this machine. It decides if the scene is admitted to run.

use serde::Serialize;
use shared_mem::message::STAGES;

/// Share of the period that the worst tick must leave free.
pub const MARGIN: f64 = 0.3;

/// Result of the admission test of a scene: its cost on this machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Admission {
    /// The scene's name.
    pub scene: String,
    /// Number of spheres.
    pub spheres: usize,
    /// Duration of the worst tick with cold caches, ns.
    pub worst_tick_ns: u64,
    /// Time of each stage in that tick, ns: sample, tool, contact, solve, force, procedure,
    /// publish.
    pub worst_stage_ns: [u64; STAGES],
    /// Median duration of a tick with cold caches, ns.
    pub median_tick_ns: u64,
    /// Largest number of contacts in a tick of the measured course, which leads the instrument
    /// through the scene.
    pub contacts_max: u32,
    /// Time that the worst tick may take: the period less the margin, ns.
    pub budget_ns: u64,
    /// True if the worst tick takes at most the budget.
    pub fits: bool,
}

impl Admission {
    /// Summary in one line for people.
    #[must_use]
    pub fn in_words(&self) -> String {
        let us = |ns: u64| ns as f64 / 1000.0;
        format!(
            "scene '{}' ({} spheres): worst tick {:.0} µs, allowed are {:.0} µs ({:.0} % of the \
             period): {}",
            self.scene,
            self.spheres,
            us(self.worst_tick_ns),
            us(self.budget_ns),
            (1.0 - MARGIN) * 100.0,
            if self.fits { "fits" } else { "DOES NOT FIT" },
        )
    }
}
