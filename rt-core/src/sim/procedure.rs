//! Stage `procedure`: what the buttons do to the instrument, and what is told of the tick.

use crate::event::{Event, EventKind};
use crate::fault::FaultSet;
use crate::math;
use crate::port::Buttons;
use crate::sim::{Sim, TICK_S};
use crate::tool::Instrument;

/// Time in which the jaws close or open, s.
const JAW_TIME_S: f32 = 0.15;
/// Opening at which closing jaws hold what is between them.
const JAW_HOLDS: f32 = 0.35;

impl Sim<'_> {
    /// Buttons: the jaws close, hold, open; the instrument is changed.
    pub(super) fn work_instrument(&mut self, faults: &mut FaultSet) {
        let pressed = self.inputs.newly_pressed();
        if pressed.contains(Buttons::CHANGE) {
            self.change_instrument(self.tool.instrument.next());
        }
        let closing = self.tool.buttons.contains(Buttons::GRASP);
        if !closing && self.grasp.count() > 0 {
            self.let_go();
        }
        let step = TICK_S / JAW_TIME_S * if closing { -1.0 } else { 1.0 };
        let jaw = (self.tool.jaw + step).clamp(0.0, 1.0);
        let bites = self.tool.jaw > JAW_HOLDS && jaw <= JAW_HOLDS && self.grasp.count() == 0;
        if bites && self.tool.instrument == Instrument::Grasper && !self.tool.switches.paused {
            self.close_jaws(faults);
        }
        // Jaws that hold something do not close further.
        if self.grasp.count() == 0 || jaw > self.tool.jaw {
            self.tool.jaw = jaw;
        }
        self.tool.grasped_count = self.grasp.count();
    }

    fn close_jaws(&mut self, faults: &mut FaultSet) {
        let bodies = &mut self.state.bodies;
        let (instrument, tip_m) = (&self.tool.world_from_instrument, &self.tool.tip_m);
        self.grasp
            .close(instrument, tip_m, &self.scene, bodies, faults);
        if let Some(first) = self.grasp.spheres().next() {
            self.journal.raise(Event {
                kind: EventKind::Grasp,
                organ: Some(u32::from(*bodies.organ.at(first))),
                at_m: *tip_m,
                value: self.grasp.count() as f32,
            });
        }
    }

    pub(super) fn let_go(&mut self) {
        if let Some(first) = self.grasp.spheres().next() {
            self.journal.raise(Event {
                kind: EventKind::LetGo,
                organ: Some(u32::from(*self.state.bodies.organ.at(first))),
                at_m: self.tool.tip_m,
                value: self.grasp.count() as f32,
            });
        }
        self.grasp.open(&mut self.state.bodies);
    }

    pub(super) fn change_instrument(&mut self, instrument: Instrument) {
        self.let_go();
        self.tool.instrument = instrument;
        self.tool.jaw = 1.0;
    }

    pub(super) fn note_events(&mut self, faults: &mut FaultSet) {
        let list = &self.contacts.list;
        self.tool.contact_count = list.len() as u32;
        self.journal
            .note_contacts(list, self.scene.organs, math::norm(&self.tool.force_n));
        self.journal
            .note_electro(&self.tool.switches.pedal, self.tool.tip_m);
        self.journal.note_faults(faults, self.tool.tip_m);
    }
}
