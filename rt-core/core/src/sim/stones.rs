//! Stones in the tick: they spill, move, are held by the jaws and leave the body.

use heapless::Vec;

use crate::capacity::MAX_CAPSULES;
use crate::procedure::stones::Surroundings;
use crate::procedure::stones::grip::holds_stones;
use crate::sim::Sim;
use crate::sim::procedure::jaws;
use crate::tool::{Capsule, Instrument, Role};

impl Sim<'_> {
    /// Opening of the jaws that a held stone stops.
    pub(super) fn stopped_by_stone(&self, jaw: f32) -> f32 {
        self.state.stones.stopped(jaw)
    }

    /// Closes the jaws around a stone if one is between them. Returns true if they hold a stone.
    pub(super) fn catch_stone(&mut self, closed_share: f32) -> bool {
        let is_grasper = holds_stones(self.tool.instrument);
        if !is_grasper || self.grasp.count() > 0 {
            return false;
        }
        let (stones, journal) = (&mut self.state.stones, &mut self.journal);
        if closed_share > 0.0 {
            stones.close(&jaws(&self.tool), &self.scene, journal)
        } else {
            stones.held().is_some()
        }
    }

    /// Lets stones spill, move and leave the body. O(spheres) for each of four stones at most.
    pub(super) fn move_stones(&mut self) {
        if self.tool.switches.paused || self.scene.stones.count == 0 {
            return;
        }
        let state = &mut *self.state;
        let mut tools: Vec<&Capsule, MAX_CAPSULES> = Vec::new();
        for part in self.tool.capsules.iter().chain(&self.tool.endoscope) {
            let _ = tools.push(part); // both tools together have fewer
        }
        let around = Surroundings {
            scene: &self.scene,
            bodies: &state.bodies,
            bounds: &self.bounds,
            tools: &tools,
        };
        let (stones, journal) = (&mut state.stones, &mut self.journal);
        stones.carry(&jaws(&self.tool), &self.scene, journal);
        let sucks =
            self.tool.instrument == Instrument::Irrigator && self.tool.switches.pedal.coagulate;
        let is_mouth = |part: &&Capsule| part.role == Role::Tip;
        if let (true, Some(mouth)) = (sucks, self.tool.capsules.iter().find(is_mouth)) {
            stones.suck(mouth, &self.scene, journal);
        }
        stones.advance(self.tick, &state.vessels, &around, journal);
    }
}
