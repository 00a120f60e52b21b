//! Stage `procedure`: the work of the jaws and of the current, and the events of the tick.

use crate::fault::{Fault, FaultSet};
use crate::math;
use crate::port::Buttons;
use crate::procedure::cautery::Electrode;
use crate::procedure::clip::Clips;
use crate::procedure::cut::cut_all;
use crate::procedure::grasp::Jaws;
use crate::procedure::heat::current::Current;
use crate::sim::Sim;
use crate::tissue::damage::tear_all;
use crate::tool::{Instrument, Tool, ToolState};
use crate::words::{Event, EventKind};

/// Opening at or below which closing jaws grasp the tissue between them, 0 shut to 1 wide open.
const GRASP_OPENING: f32 = 0.35;

impl Sim<'_> {
    /// Follows the handle's buttons and opening: changes the instrument, and moves the jaws, which
    /// then grasp, cut or clip. Places sutures. In a pause nothing changes, whatever the hand does.
    pub(super) fn work_instrument(&mut self, faults: &mut FaultSet) {
        if self.tool.switches.paused {
            self.sew(); // records only the pedal's state, so that the end of a pause is no press
            return;
        }
        let pressed = self.inputs.newly_pressed();
        if pressed.contains(Buttons::CHANGE) {
            self.change_instrument(self.tool.instrument.next());
        }
        let pressed = self.tool.buttons.contains(Buttons::GRASP);
        let closing = self
            .drive
            .handle_opening()
            .map_or(pressed, |opening| opening <= GRASP_OPENING);
        let jaw = (self.drive).jaw(pressed, &jaws(&self.tool), &self.grasp);
        let jaw = self.stopped_by_stone(jaw);
        let starts_grasp = self.tool.jaw > GRASP_OPENING && jaw <= GRASP_OPENING;
        let closed_share = self.tool.jaw - jaw;
        self.tool.jaw = jaw;
        let holds_stone = self.catch_stone(closed_share);
        match self.tool.instrument {
            Instrument::Scissors if closed_share > 0.0 => self.cut(closed_share, faults),
            Instrument::Grasper if starts_grasp && self.grasp.count() == 0 && !holds_stone => {
                self.close_jaws(faults);
            }
            Instrument::ClipApplier if closed_share > 0.0 => self.clip(starts_grasp, faults),
            _ => {}
        }
        self.hold(closing);
        self.tool.grasped_count = self.grasp.count();
        self.sew();
    }

    /// Applies current to the tissue that the bare tip of the hook touches, and raises the burn
    /// events.
    pub(super) fn burn(&mut self) {
        let electrode = Electrode::of(&self.tool, self.electric_pedal());
        let (state, journal) = (&mut *self.state, &mut self.journal);
        if let Some(electrode) = &electrode {
            let (bodies, vessels) = (&mut state.bodies, &mut state.vessels);
            let cells = bodies.touched_cells(electrode, &self.scene, &self.bounds);
            let touched = (self.contacts.forces.as_slice(), cells.as_slice());
            let shares =
                (self.cautery).burn(electrode, touched, &self.scene, bodies, vessels, journal);
            if let Some(shares) = &shares {
                let current = Current {
                    electrode,
                    shares,
                    cells: &cells,
                };
                (state.heat).take(&current, &self.scene, bodies, &self.bounds);
            }
        } else {
            state.heat.end_current();
        }
        self.cautery.report(electrode.is_none(), journal);
    }

    /// Spreads heat, and sums the damage that it does to tissue.
    pub(super) fn spread_heat(&mut self) {
        if self.tool.switches.paused {
            return;
        }
        let (state, journal) = (&mut *self.state, &mut self.journal);
        (state.heat).advance(&self.scene, &state.bodies, journal);
    }

    /// Tears tissue that the tick has overstretched.
    pub(super) fn tear(&mut self) {
        if self.tool.switches.paused {
            return;
        }
        let (bodies, journal) = (&mut self.state.bodies, &mut self.journal);
        let vessels = &mut self.state.vessels;
        tear_all(&self.scene, bodies, |severed| {
            vessels.mark_changed();
            journal.raise(severed.event(EventKind::Tear));
        });
        bodies.tear_cells(&self.scene, |removed| journal.raise(removed.event()));
    }

    /// Cuts with scissors that have closed in this tick by the share `closed_share` of their full
    /// opening. The blades grasp the tissue while they cut it.
    fn cut(&mut self, closed_share: f32, faults: &mut FaultSet) {
        let (scene, bodies, journal) = (&self.scene, &mut self.state.bodies, &mut self.journal);
        let blades = jaws(&self.tool);
        let (clips, vessels) = (self.clips.places(bodies), &mut self.state.vessels);
        let work = cut_all(&blades, closed_share, &clips, scene, bodies, |severed| {
            vessels.mark_changed();
            journal.raise(severed.event(EventKind::Cut));
        });
        self.drive.set_cut_energy(work.full_closing_j);
        match (work.is_cutting, self.grasp.count()) {
            (true, 0) => self.grasp.close(&blades, |_| true, scene, bodies, faults),
            (false, 1..) => {
                self.grasp.open(bodies);
                self.transition.discontinuity();
            }
            _ => {}
        }
    }

    /// Grasps the tubes between the closing jaws of the applier. Closes a clip if the jaws start to
    /// grasp in this tick.
    fn clip(&mut self, starts_grasp: bool, faults: &mut FaultSet) {
        let (scene, bodies, journal) = (&self.scene, &mut self.state.bodies, &mut self.journal);
        let (jaws, at_m) = (jaws(&self.tool), self.tool.tip_m);
        if self.grasp.count() == 0 {
            let between = Clips::between(&jaws, scene, bodies);
            if between.contains(&true) {
                let may_grasp = |organ: u8| between.get(usize::from(organ)) == Some(&true);
                self.grasp.close(&jaws, may_grasp, scene, bodies, faults);
            }
        }
        if starts_grasp {
            self.state.vessels.mark_changed();
            self.clips.close(&jaws, scene, bodies, |number, closed| {
                let organ = closed.map(|it| u32::from(it.organ));
                let mut raise = |kind, value| {
                    journal.raise(Event {
                        kind,
                        organ,
                        at_m,
                        value,
                    });
                };
                if let Some(closed) = closed {
                    raise(EventKind::ClipCloses, closed.share);
                    raise(EventKind::ClipAlong, closed.along_m);
                }
                raise(EventKind::Clip, number as f32);
            });
        }
    }

    /// Spreads the pressure of blood and bile, and raises the events of leaks.
    pub(super) fn leak(&mut self) {
        if self.tool.switches.paused {
            return;
        }
        let (state, journal) = (&mut *self.state, &mut self.journal);
        (state.vessels).flow(&self.scene, &self.clips, &mut state.bodies, journal);
    }

    fn close_jaws(&mut self, faults: &mut FaultSet) {
        let (scene, bodies) = (&self.scene, &mut self.state.bodies);
        let jaws = jaws(&self.tool);
        (self.grasp).close(&jaws, |_| true, scene, bodies, faults);
        self.raise_grasp_event(EventKind::Grasp, self.grasp.count() as f32);
    }

    /// Updates the grip, and releases tissue if the jaws have opened or the tissue has slid out.
    /// Raises the events of tissue that slips, is crushed or is released.
    fn hold(&mut self, closing: bool) {
        let Some(first) = self.grasp.first() else {
            return;
        };
        let (grasped_count, force_n) = (self.grasp.count(), math::norm(&self.grasp.pull_n()));
        // Tissue that slips while the jaws open is being released, so it raises no slip event.
        let force_max_n = self.drive.grip_max_n(self.tool.instrument);
        let slipped = (self.grasp).hold(&jaws(&self.tool), force_max_n, &mut self.state.bodies);
        if slipped && closing {
            self.raise_grasp_event(EventKind::Slip, force_n);
        }
        if let Some((sphere, grip_n)) = self.grasp.crush(&self.scene, &self.state.bodies) {
            self.raise_event(EventKind::Crush, sphere, grip_n);
        }
        if !closing && self.grasp.is_loose() {
            self.release_tissue();
        } else if self.grasp.count() == 0 {
            self.raise_event(EventKind::LetGo, first, grasped_count as f32);
            self.grasp.open(&mut self.state.bodies);
            self.transition.discontinuity();
        }
    }

    pub(super) fn release_tissue(&mut self) {
        self.raise_grasp_event(EventKind::LetGo, self.grasp.count() as f32);
        self.grasp.open(&mut self.state.bodies);
        self.transition.discontinuity();
    }

    fn raise_grasp_event(&mut self, kind: EventKind, value: f32) {
        if let (Some(first), Instrument::Grasper) = (self.grasp.first(), self.tool.instrument) {
            self.raise_event(kind, first, value);
        }
    }

    /// Raises an event at the tip, for the organ of this sphere.
    fn raise_event(&mut self, kind: EventKind, sphere: u32, value: f32) {
        self.journal.raise(Event {
            kind,
            organ: Some(u32::from(*self.state.bodies.organ.at(sphere))),
            at_m: self.tool.tip_m,
            value,
        });
    }

    pub(super) fn change_instrument(&mut self, instrument: Instrument) {
        self.release_tissue();
        self.state.stones.leave_with_instrument(&mut self.journal);
        // The persistent contacts of the old instrument are not valid for the new instrument.
        self.contacts.clear();
        self.tool.instrument = instrument;
        // The new jaws start as open as the handle, so that the change neither bites nor cuts.
        self.tool.jaw = self.drive.handle_opening().unwrap_or(1.0);
        self.drive.set_cut_energy(0.0);
    }

    pub(super) fn note_events(&mut self, faults: &mut FaultSet) {
        let forces = &self.contacts.forces;
        let instrument_forces = forces.iter().filter(|it| it.tool == Tool::Instrument);
        self.tool.contact_count = instrument_forces.count() as u32;
        self.journal
            .note_contacts(forces, self.scene.organs, math::norm(&self.tool.force_n));
        let pedal = self.tool.switches.pedal;
        let is_electric = self.tool.instrument != Instrument::Irrigator;
        let are_both = pedal.cut && pedal.coagulate && is_electric;
        faults.raise_if(are_both, Fault::BothElectrodes);
        let pedal = self.electric_pedal();
        self.journal.note_electro(&pedal, self.tool.tip_m);
        self.journal.note_faults(faults, self.tool.tip_m);
    }
}

pub(super) fn jaws(tool: &ToolState) -> Jaws<'_> {
    Jaws {
        instrument: tool.instrument,
        world_from_instrument: &tool.world_from_instrument,
        jaw: tool.jaw,
    }
}
