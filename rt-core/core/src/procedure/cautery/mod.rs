//! Electrosurgery: current through the hook's bare tip divides or desiccates the tissue that the
//! tip touches.
//!
//! First the contact area is summed over all touched tissue: links of tubes, bands and sutures,
//! cells, and surfaces of organs. Then each area absorbs its share of the tick's energy
//! ([`electrode`]). The damage of a link grows by the energy that it absorbs, divided by the energy
//! that boils it away over the width of the electrode. Vessels are desiccated, and walls are burnt
//! through ([`wall`]). Current without contact has no effect. O(attachments and elastic links of
//! organs that move, contacts) while current flows.

mod burn;
mod electrode;
mod wall;

pub(crate) use burn::TouchedCell;
pub(crate) use electrode::{Dose, Electrode};

use heapless::Vec;

use crate::capacity::MAX_ORGANS;
use crate::contact::contact_force::ContactForce;
use crate::math::Vec3;
use crate::procedure::journal::Journal;
use crate::procedure::vessel::Vessels;
use crate::scene::Scene;
use crate::tissue::Bodies;
use crate::tissue::damage::{Severed, damage_all, spare_none};
use crate::tool::Tool;
use crate::words::{Event, EventKind};
use wall::{HOLE_M2, Walls};

/// Ticks between two burn events.
const REPORT_TICKS: u32 = 50;

/// Largest number of links of tubes that a tick desiccates: more than lie under a tip.
const DESICCATED_LINKS_MAX: usize = 32;

/// Burns since the last event.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cautery {
    /// Energy not yet in an event, by organ, J.
    burnt_j: [f32; MAX_ORGANS],
    /// Ticks until the next event may be raised.
    quiet_ticks: u32,
    /// Position of the last burn, m.
    at_m: Vec3,
    walls: Walls,
}

/// Energy of a tick's current, by the tissue that absorbed it.
#[derive(Debug, Clone)]
pub(crate) struct Shares {
    pub(crate) dose: Dose,
    touched_m2: f32,
    /// Links of tubes, and the energy that has desiccated each, J.
    pub(crate) links: Vec<(u32, f32), DESICCATED_LINKS_MAX>,
    /// Area of each organ's surface, m².
    pub(crate) surfaces_m2: [f32; MAX_ORGANS],
    /// Area of links and attachments, m².
    other_m2: f32,
}

impl Shares {
    /// Energy that becomes heat near the tip, J: half of the generator's.
    pub(crate) fn near_j(&self) -> f32 {
        self.dose.total_j_m2() * self.touched_m2
    }

    /// Energy that divides tissue, J.
    pub(crate) fn dividing_j(&self) -> f32 {
        self.dose.dividing_j_m2 * self.touched_m2
    }

    /// Energy that has desiccated links of tubes, J.
    fn links_j(&self) -> f32 {
        self.links.iter().map(|(_, energy_j)| energy_j).sum()
    }

    /// Energy that has desiccated attachments, J.
    pub(crate) fn other_drying_j(&self) -> f32 {
        (self.dose.drying_j_m2 * self.other_m2 - self.links_j()).max(0.0)
    }

    /// Share of the touched area that belongs to links of tubes.
    pub(crate) fn tube_share(&self) -> f32 {
        let whole_j = self.dose.drying_j_m2 * self.touched_m2;
        if whole_j > 0.0 {
            (self.links_j() / whole_j).min(1.0)
        } else {
            0.0
        }
    }
}

impl Cautery {
    /// Applies a tick of current through `electrode`, which touches tissue at `contacts`, and
    /// touches `cells`. Returns the shares of the energy; `None` if the tip touches nothing.
    pub(crate) fn burn(
        &mut self,
        electrode: &Electrode,
        (contacts, cells): (&[ContactForce], &[TouchedCell]),
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        vessels: &mut Vessels,
        journal: &mut Journal,
    ) -> Option<Shares> {
        let mut surfaces = touched_surfaces(electrode, contacts, scene);
        for cell in cells {
            // An organ with cells absorbs heat by its cells, not by its surface.
            if let Some(area_m2) = surfaces.get_mut(usize::from(cell.organ)) {
                *area_m2 = 0.0;
            }
        }
        let cells_m2: f32 = cells.iter().map(|it| it.area_m2).sum();
        let surfaces_m2: f32 = surfaces.iter().sum();
        let layered = layered(scene, bodies);
        let bars_m2 = touched_bars_m2(electrode, &layered, scene, bodies);
        let touched_m2 = bars_m2 + surfaces_m2 + cells_m2;
        let dose = electrode.dose(touched_m2)?;
        self.at_m = electrode.middle_m();
        let mut areas_m2 = surfaces;
        let mut links: Vec<(u32, f32), DESICCATED_LINKS_MAX> = Vec::new();
        let severed = |severed: Severed| {
            vessels.mark_changed();
            journal.raise(severed.event(EventKind::Cut));
        };
        damage_all(scene, bodies, spare_none, severed, |bar, damage| {
            let is_layered = layered.get(usize::from(bar.organ)) == Some(&true);
            if damage >= 1.0 || is_layered {
                return damage;
            }
            let touched = electrode.touches_bar(&bar.ends_m, bar.radius_m);
            if touched <= 0.0 {
                return damage;
            }
            if let Some(area_m2) = areas_m2.get_mut(usize::from(bar.organ)) {
                *area_m2 += bar.area_m2 * touched;
            }
            if let Some(link) = bar.link {
                let _ = links.push((link, dose.drying_j_m2 * bar.area_m2 * touched));
            }
            bar.damage_after_burn(damage, dose.boiled_share() * touched)
        });
        for (link, energy_j) in &links {
            if let Some(link) = scene.links.get(*link as usize) {
                vessels.desiccate(link.a, 0.5 * energy_j, scene, bodies);
                vessels.desiccate(link.b, 0.5 * energy_j, scene, bodies);
            }
        }
        let burnt_j = &mut self.burnt_j;
        let burnt = |organ: u8, energy_j| {
            if let Some(burnt_j) = burnt_j.get_mut(usize::from(organ)) {
                *burnt_j += energy_j;
            }
        };
        bodies.burn_cells(cells, &dose, scene, burnt, |removed| {
            journal.raise(removed.event());
        });
        for ((organ, area_m2), burnt_j) in (0u8..).zip(areas_m2).zip(&mut self.burnt_j) {
            if area_m2 <= 0.0 {
                continue;
            }
            *burnt_j += dose.total_j_m2() * area_m2;
            let wall_energy_j = dose.opening_j_m2(scene.organs.get(usize::from(organ))) * area_m2;
            if let Some(hole) = self
                .walls
                .burn(organ, &self.at_m, wall_energy_j, scene, bodies)
            {
                vessels.perforate(hole.sphere, HOLE_M2);
                journal.raise(Event {
                    kind: EventKind::Perforation,
                    organ: Some(u32::from(organ)),
                    at_m: self.at_m,
                    value: hole.energy_j,
                });
            }
        }
        Some(Shares {
            dose,
            touched_m2,
            links,
            surfaces_m2: surfaces,
            other_m2: touched_m2 - surfaces_m2 - cells_m2,
        })
    }

    /// Raises the burn events when they are due, and when the current `is_off`.
    pub(crate) fn report(&mut self, is_off: bool, journal: &mut Journal) {
        self.quiet_ticks = self.quiet_ticks.saturating_sub(1);
        if self.quiet_ticks > 0 && !is_off {
            return;
        }
        for (organ, burnt_j) in (0u32..).zip(&mut self.burnt_j) {
            let value = core::mem::take(burnt_j);
            if value > 0.0 {
                self.quiet_ticks = REPORT_TICKS;
                journal.raise(Event {
                    kind: EventKind::Burn,
                    organ: Some(organ),
                    at_m: self.at_m,
                    value,
                });
            }
        }
    }
}

/// True for organs with cells: their links weaken with the cells, and are not burnt themselves.
/// O(cells).
fn layered(scene: &Scene<'_>, bodies: &Bodies) -> [bool; MAX_ORGANS] {
    let mut layered = [false; MAX_ORGANS];
    for cell in scene.layers.cells {
        let organ = usize::from(*bodies.organ.at(cell.sphere()));
        if let Some(layered) = layered.get_mut(organ) {
            *layered = true;
        }
    }
    layered
}

fn touched_bars_m2(
    electrode: &Electrode,
    layered: &[bool; MAX_ORGANS],
    scene: &Scene<'_>,
    bodies: &mut Bodies,
) -> f32 {
    let mut sum_m2 = 0.0;
    damage_all(
        scene,
        bodies,
        spare_none,
        |_| (),
        |bar, damage| {
            let is_layered = layered.get(usize::from(bar.organ)) == Some(&true);
            if damage < 1.0 && !is_layered {
                let touched = electrode.touches_bar(&bar.ends_m, bar.radius_m);
                sum_m2 += bar.area_m2 * touched;
            }
            damage
        },
    );
    sum_m2
}

/// Contact area of the electrode with each organ's surface, m². A tube counts by its links, not by
/// its surface.
fn touched_surfaces(
    electrode: &Electrode,
    contacts: &[ContactForce],
    scene: &Scene<'_>,
) -> [f32; MAX_ORGANS] {
    let mut areas_m2 = [0.0; MAX_ORGANS];
    let point_m2 = electrode.diameter_m() * electrode.diameter_m();
    for contact in contacts.iter().filter(|it| it.tool == Tool::Instrument) {
        let organ = usize::from(contact.organ.unwrap_or(u8::MAX));
        let is_surface = scene.organs.get(organ).is_some_and(|it| !it.is_tube());
        // A contact lies on the tool's surface.
        let touched = electrode.touches_ball(&contact.at_m, 0.0);
        if let (true, Some(area_m2)) = (is_surface, areas_m2.get_mut(organ)) {
            *area_m2 = (*area_m2 + point_m2 * touched).min(electrode.side_m2());
        }
    }
    areas_m2
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use crate::scene::{Inside, Link};
    use proptest::prelude::*;
    use std::boxed::Box;
    use std::vec::Vec;

    const LINKS: u32 = 12;

    proptest! {
        /// On any path of the tip, the damage of a link never falls, never exceeds 1, and grows
        /// only under the tip. The energy in the events equals the supplied energy.
        #[test]
        fn damage_grows_only_under_the_tip_and_energy_is_accounted(
            tips in prop::collection::vec((-0.002f32..0.03, -0.004f32..0.004, 1u32..120), 1..12),
        ) {
            let spheres: Vec<_> = (0..=LINKS)
                .map(|i| sphere(Vec3::new(0.002 * i as f32, 0.0, 0.0), 0.001))
                .collect();
            let links: Vec<_> = (0..LINKS)
                .map(|a| Link { a, b: a + 1, rest_length_m: 0.002, compliance_m_n: 0.2 })
                .collect();
            let organs = [crate::scene::Organ {
                inside: Inside::Blood,
                ..organ(0, LINKS + 1, 0, LINKS)
            }];
            let scene = Scene::new(&organs, &spheres, &links, room()).expect("sound");
            let mut state = Box::new(crate::state::State::new());
            state.bodies.load(&scene);
            state.bodies.begin(&scene, true);
            let (mut cautery, mut journal) = (Cautery::default(), Journal::default());
            let mut left = [1.0; LINKS as usize];
            let (mut given_j, mut reported_j) = (0.0, 0.0);
            for (x, z, ticks) in tips {
                let ends_m = [Vec3::new(x, -0.002, z), Vec3::new(x, 0.002, z)];
                let electrode = Electrode::cutting(ends_m);
                for _ in 0..ticks {
                    journal.begin();
                    let (bodies, vessels) = (&mut state.bodies, &mut state.vessels);
                    let layered = layered(&scene, bodies);
                    let touches = touched_bars_m2(&electrode, &layered, &scene, bodies) > 0.0;
                    given_j += if touches { 0.015 } else { 0.0 };
                    cautery.burn(&electrode, (&[], &[]), &scene, bodies, vessels, &mut journal);
                    cautery.report(false, &mut journal);
                    reported_j += burn_energy_j(&journal);
                    for (i, before) in (0..LINKS).zip(&mut left) {
                        let now = bodies.damage.intact_of_link(i);
                        prop_assert!((0.0..=*before).contains(&now));
                        let near = (x - 0.002 * i as f32).min(0.002 * (i + 1) as f32 - x);
                        let is_under = near > -0.0022 && z.abs() < 0.0022;
                        prop_assert!(is_under || now >= *before, "{} at {}, {}", i, x, z);
                        *before = now;
                    }
                }
            }
            journal.begin();
            cautery.report(true, &mut journal);
            reported_j += burn_energy_j(&journal);
            prop_assert!((reported_j - given_j).abs() < 1.0e-3 * given_j.max(0.1), "{} {}", reported_j, given_j);
        }
    }

    fn burn_energy_j(journal: &Journal) -> f32 {
        let burns = journal
            .events()
            .iter()
            .filter(|it| it.kind == EventKind::Burn);
        burns.map(|it| it.value).sum()
    }
}
