//! Checkpoints: a copy of the state between two ticks, from which the simulation can continue. A
//! copy takes about 4 MB, so it is not for use within a tick.

use super::Sim;
use crate::capacity::MAX_ORGANS;
use crate::contact::tool_contact::ToolContacts;
use crate::fault::FaultCounters;
use crate::haptics::output_limit::OutputLimit;
use crate::haptics::proxy::Proxy;
use crate::haptics::transition::Transition;
use crate::haptics::trocar::TrocarLaw;
use crate::procedure::cautery::Cautery;
use crate::procedure::clip::Clips;
use crate::procedure::grasp::Grasp;
use crate::procedure::journal::Journal;
use crate::procedure::opening::JawDrive;
use crate::procedure::unrest::Unrest;
use crate::sim::sample::Inputs;
use crate::state::State;
use crate::tissue::Bounds;
use crate::tissue::sleep::Sleep;
use crate::tool::{Kinematics, ToolState};

/// All data of a simulation that changes. It is about as large as [`State`]: keep it on the heap.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    state: State,
    sleep: Sleep,
    unrest: Unrest,
    kinematics: Kinematics,
    inputs: Inputs,
    tool: ToolState,
    proxy: Proxy,
    drive: JawDrive,
    bounds: [Bounds; MAX_ORGANS],
    contacts: ToolContacts,
    grasp: Grasp,
    cautery: Cautery,
    clips: Clips,
    transition: Transition,
    trocar: TrocarLaw,
    limit: OutputLimit,
    renders_torque: bool,
    journal: Journal,
    fault_counters: FaultCounters,
    tick: u64,
}

impl Sim<'_> {
    /// Copies the state between two ticks.
    #[must_use]
    pub fn checkpoint(&self) -> Checkpoint {
        // Destructured in full, so that a new field cannot be forgotten here.
        let Self {
            scene: _,
            state,
            method: _,
            sleep,
            unrest,
            kinematics,
            inputs,
            tool,
            proxy,
            drive,
            bounds,
            contacts,
            grasp,
            cautery,
            clips,
            transition,
            trocar,
            limit,
            renders_torque,
            asks_force: _, // each tick sets it anew
            journal,
            fault_counters,
            tick,
        } = self;
        Checkpoint {
            state: (**state).clone(),
            sleep: sleep.clone(),
            unrest: unrest.clone(),
            kinematics: *kinematics,
            inputs: *inputs,
            tool: tool.clone(),
            proxy: *proxy,
            drive: *drive,
            bounds: *bounds,
            contacts: contacts.clone(),
            grasp: grasp.clone(),
            cautery: cautery.clone(),
            clips: clips.clone(),
            transition: *transition,
            trocar: *trocar,
            limit: *limit,
            renders_torque: *renders_torque,
            journal: journal.clone(),
            fault_counters: *fault_counters,
            tick: *tick,
        }
    }

    /// Restores a checkpoint of a simulation of the same scene by the same method. Equal inputs
    /// then give equal results, bit for bit. With a checkpoint of another scene, this does not
    /// panic, but the results have no meaning.
    pub fn go_back(&mut self, checkpoint: &Checkpoint) {
        let Checkpoint {
            state,
            sleep,
            unrest,
            kinematics,
            inputs,
            tool,
            proxy,
            drive,
            bounds,
            contacts,
            grasp,
            cautery,
            clips,
            transition,
            trocar,
            limit,
            renders_torque,
            journal,
            fault_counters,
            tick,
        } = checkpoint;
        self.state.clone_from(state);
        self.sleep = sleep.clone();
        self.unrest = unrest.clone();
        self.kinematics = *kinematics;
        self.inputs = *inputs;
        self.tool = tool.clone();
        self.proxy = *proxy;
        self.drive = *drive;
        self.bounds = *bounds;
        self.contacts = contacts.clone();
        self.grasp = grasp.clone();
        self.cautery = cautery.clone();
        self.clips = clips.clone();
        self.transition = *transition;
        self.trocar = *trocar;
        self.limit = *limit;
        self.renders_torque = *renders_torque;
        self.journal = journal.clone();
        self.fault_counters = *fault_counters;
        self.tick = *tick;
    }
}
