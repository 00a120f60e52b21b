//! Organs that fall or shake: finds the organs that a tool moves, and raises the events.

use crate::math;
use crate::port::Buttons;
use crate::procedure::unrest::UnrestKind;
use crate::sim::{Sim, WAKE_GAP_M};
use crate::tool::Tool;
use crate::words::{Event, EventKind};

/// Speed below which the handle counts as at rest, m/s: five times the tremor of a resting hand.
const HANDLE_REST_SPEED_M_S: f32 = 0.005;
/// Lower bound of the length of the shaft outside the body in `Sim::tip_speed_ratio`, m: about half
/// the width of a hand.
const LEVER_MIN_M: f32 = 0.05;
/// Ticks between two searches for organs next to those that a tool moves.
const SPREAD_TICKS: u64 = 16;

impl Sim<'_> {
    /// Records which organs attachments join, and where the organs are.
    pub(super) fn load_unrest(&mut self) {
        let organs = &self.state.bodies.organ;
        self.unrest.load(&self.scene, |sphere| *organs.at(sphere));
        self.unrest.start(&self.scene, &self.bounds);
    }

    /// Raises the events of organs that fall or shake. Nothing here feeds back into the simulation.
    pub(super) fn note_unrest(&mut self) {
        if self.tool.switches.paused {
            return;
        }
        let speed_m_s = math::norm(&self.tool.handle_velocity_m_s);
        let pedal = self.tool.switches.pedal;
        let moves = speed_m_s > HANDLE_REST_SPEED_M_S
            || self.grasp.count() > 0
            || self.tool.buttons != Buttons::default()
            || pedal.cut
            || pedal.coagulate;
        let at_tools = self.organs_at_tools();
        for (organ, _) in at_tools
            .iter()
            .enumerate()
            .filter(|(_, at_tools)| **at_tools)
        {
            if moves {
                self.unrest.disturb(organ);
            } else {
                self.unrest.touch(organ);
            }
        }
        let lens_m = (self.tool.endoscope).map(|_| self.tool.world_from_camera.translation.vector);
        let lens_m_s = self.unrest.follow_lens(lens_m);
        let touched = self.contacts.forces.iter();
        let touched = touched.filter(|it| it.tool == Tool::Endoscope && lens_m_s > 0.0);
        for organ in touched.filter_map(|it| it.organ) {
            self.unrest.disturb(organ.into());
        }
        for sphere in self.grasp.spheres() {
            self.unrest
                .mark_freed((*self.state.bodies.organ.at(sphere)).into());
        }
        self.note_freed();
        if self.tick.is_multiple_of(SPREAD_TICKS) {
            self.unrest.spread_disturbance(&self.bounds, WAKE_GAP_M);
        }
        let organs = self.scene.organs;
        let bodies = &self.state.bodies;
        self.unrest
            .note_velocities(organs.len(), |sphere| bodies.net_velocity_m_s(sphere));
        let hand_m_s = lens_m_s.max(speed_m_s * self.tip_speed_ratio());
        let (bounds, journal) = (&self.bounds, &mut self.journal);
        let mut report = |organ: u32, at_m, found| {
            let (kind, value) = match found {
                UnrestKind::Falls(distance_m) => (EventKind::Fall, distance_m),
                UnrestKind::Shakes(speed_m_s) => (EventKind::Shake, speed_m_s),
            };
            // These events come last, so that they displace no events of the operation.
            if journal.has_room() && (organ as usize) < organs.len() {
                journal.raise(Event {
                    kind,
                    organ: Some(organ),
                    at_m,
                    value,
                });
            }
        };
        self.unrest.end_tick(bounds, &mut report);
        let fastest = |organ| organs.get(organ).map(|it| bodies.fastest(it));
        self.unrest
            .end_tick_of_worked_organs(hand_m_s, bounds, fastest, &mut report);
    }

    /// Speed of the tip divided by the speed of the handle, at least 1. The shaft is a lever about
    /// the port.
    fn tip_speed_ratio(&self) -> f32 {
        let port_m = self.scene.room.instrument_port_m;
        let [tip_m, handle_m] = [
            self.tool.tip_m,
            self.tool.world_from_handle.translation.vector,
        ]
        .map(|it| math::norm(&(it - port_m)));
        if tip_m > handle_m {
            tip_m / handle_m.max(LEVER_MIN_M)
        } else {
            1.0
        }
    }

    /// Marks the organs at which this tick has cut, burnt away or torn something as freed.
    fn note_freed(&mut self) {
        let is_worked_on = self.unrest.is_worked_on();
        for event in self.journal.events() {
            let is_freed = match event.kind {
                EventKind::Cut | EventKind::Removed | EventKind::Divided => true,
                // If tissue tears without a tool, the scene is faulty.
                EventKind::Tear | EventKind::Perforation => is_worked_on,
                _ => false,
            };
            if let (true, Some(organ)) = (is_freed, event.organ) {
                self.unrest.mark_freed(organ as usize);
            }
        }
    }
}
