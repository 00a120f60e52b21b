//! View of a tick: the results that are published.

use crate::capacity::MAX_TUBE_LINKS;
use crate::contact::dent::Dent;
use crate::contact::tool_contact::ToolContacts;
use crate::fault::{FaultCounters, FaultSet};
use crate::math::Vec3;
use crate::procedure::clip::Clip;
use crate::procedure::heat::{Balance, Heat, HeatCode};
use crate::procedure::stones::{Stone, StoneState};
use crate::scene::{Scene, is_suture};
use crate::time::TimeNs;
use crate::tissue::Bodies;
use crate::tissue::suture::Suture;
use crate::tool::ToolState;
use crate::words::{Event, Health, SphereBits};

/// A sphere after a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereView {
    /// Centre, world frame, m.
    pub center_m: Vec3,
    /// Flags.
    pub bits: SphereBits,
    /// Temperature and damage.
    pub heat: HeatCode,
}

/// Results of a tick.
#[derive(Debug)]
pub struct TickView<'a> {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// Time at which the newest device sample was read; 0 before the first.
    pub sample_ns: TimeNs,
    /// True if that sample is new in this tick.
    pub sample_is_fresh: bool,
    /// Tools and switches.
    pub tool: &'a ToolState,
    /// Events, in order.
    pub events: &'a [Event],
    /// Energy that the hand put into contact and did not get back, J. Below zero, contact has
    /// generated energy.
    pub energy_j: f32,
    /// True if tissue or jaws demanded a force in this tick, and the simulation is not paused.
    pub asks_force: bool,
    /// Share of the demanded force that the ramp let through; 0 while force is cut.
    pub force_share: f32,
    /// Faults of this tick.
    pub faults: FaultSet,
    /// Number of ticks in which each fault has happened.
    pub fault_counters: &'a FaultCounters,
    /// Health of the haptic device.
    pub device: Health,
    /// Health of the tracker.
    pub tracker: Health,
    /// Health of the pedal.
    pub pedal: Health,
    /// Clips on tubes, in the order of closing.
    pub clips: &'a [Clip],
    /// Clips left in the applier.
    pub clips_left: u32,
    pub(super) contacts: &'a ToolContacts,
    pub(super) scene: &'a Scene<'a>,
    pub(super) bodies: &'a Bodies,
    pub(super) heat: &'a Heat,
    pub(super) stones: &'a StoneState,
}

impl<'a> TickView<'a> {
    /// Cells of layered tissue, in the scene's order: heat absorbed, as a share of the energy that
    /// removes the cell, 0 to 254; or [`crate::tissue::cells::REMOVED`].
    #[must_use]
    pub fn cells(&self) -> &'a [u8] {
        self.bodies.cells.heat_code(self.scene.layers.cells.len())
    }

    /// Energy of the current since the last reset, by the place to which it went.
    #[must_use]
    pub fn heat_balance(&self) -> Balance {
        self.heat.balance(self.scene)
    }

    /// Dents of the tools in tissue, at most [`crate::capacity::MAX_CONTACT_CONSTRAINTS`].
    pub fn dents(&self) -> impl Iterator<Item = Dent> + use<'a> {
        self.contacts.dents(self.bodies)
    }

    /// The elastic links of tubes (organs without tetrahedra), in the scene's order, at most
    /// [`MAX_TUBE_LINKS`]: true for each that is severed.
    pub fn severed_links(&self) -> impl Iterator<Item = bool> + use<'a> {
        let tubes = self.scene.organs.iter().filter(|organ| organ.is_tube());
        let links = tubes.flat_map(|organ| {
            let first = organ.link_start;
            first..first.saturating_add(organ.elastic_links)
        });
        let damage = &self.bodies.damage;
        links
            .take(MAX_TUBE_LINKS)
            .map(|link| damage.intact_of_link(link) <= 0.0)
    }

    /// Sutures that hang organs on the abdominal wall, in the order of the scene's attachments,
    /// each with true if it is severed.
    pub fn sutures(&self) -> impl Iterator<Item = (&'a Suture, bool)> + use<'a> {
        let damage = &self.bodies.damage;
        let ties = self.scene.attachments.iter().enumerate();
        let own = ties.filter(|(_, tie)| is_suture(tie));
        let is_cut = own.map(|(tie, _)| damage.intact_of_tie(tie) <= 0.0);
        self.bodies.sutures.all().iter().zip(is_cut)
    }

    /// The stones, in the order of their numbers.
    #[must_use]
    pub fn stones(&self) -> &'a [Stone] {
        self.stones.all(self.scene)
    }

    /// Radius of each stone, m.
    #[must_use]
    pub const fn stone_radius_m(&self) -> f32 {
        self.scene.stones.radius_m()
    }

    /// The spheres, in the scene's order.
    pub fn spheres(&self) -> impl ExactSizeIterator<Item = SphereView> + use<'a> {
        let count = self.scene.spheres.len() as u32;
        let nodes = self.bodies.nodes.range(0, count).iter();
        nodes
            .zip(self.bodies.bits.range(0, count))
            .zip(self.heat.codes(count))
            .map(|((node, bits), heat)| SphereView {
                center_m: node.center_m(),
                bits: *bits,
                heat: *heat,
            })
    }
}
