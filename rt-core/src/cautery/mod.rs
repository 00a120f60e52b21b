//! Electrosurgery: what the hook's bare tip touches is parted or dried by the energy that its current
//! brings there.
//!
//! Everything touched (links of tubes, bands and sutures, the surfaces of organs) first says by how
//! much; then each gets its part of the tick's energy ([`electrode`]). A bar is parted by the energy
//! over what it takes to boil it through, across the electrode's width. Current that touches nothing
//! does nothing. O(attachments and elastic links of organs that move, contacts) while it flows.

mod electrode;

pub(crate) use electrode::{Dose, Electrode};

use crate::capacity::MAX_ORGANS;
use crate::collision::tool_contact::Contact;
use crate::event::{Event, EventKind, Journal};
use crate::math::Vec3;
use crate::scene::{Organ, Scene};
use crate::soft_body::Bodies;
use crate::soft_body::part::{Apart, part_all};
use crate::tool::Tool;

/// Ticks between two events of one organ's burn.
const TOLD_TICKS: u32 = 50;

/// What current has done and nobody was told of yet.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cautery {
    /// By organ, J.
    burnt_j: [f32; MAX_ORGANS],
    /// Ticks until it may be told.
    quiet: u32,
    /// Where that was last, m.
    at_m: Vec3,
}

impl Cautery {
    /// A tick of current at `electrode`, whose tool meets tissue as `contacts` say. `apart` hears of
    /// what it has parted.
    pub(crate) fn burn(
        &mut self,
        electrode: &Electrode,
        contacts: &[Contact],
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        apart: impl FnMut(Apart),
    ) {
        let surfaces = touched_surfaces(electrode, contacts, scene);
        let touched_m2 = touched_bars_m2(electrode, scene, bodies) + surfaces.iter().sum::<f32>();
        let Some(dose) = electrode.dose(touched_m2) else {
            return;
        };
        self.at_m = electrode.middle_m();
        for (burnt_j, area_m2) in self.burnt_j.iter_mut().zip(surfaces) {
            *burnt_j += dose.whole_j_m2() * area_m2;
        }
        self.burn_bars(electrode, &dose, scene, bodies, apart);
    }

    fn burn_bars(
        &mut self,
        electrode: &Electrode,
        dose: &Dose,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        apart: impl FnMut(Apart),
    ) {
        part_all(scene, bodies, apart, |bar, parted| {
            let touched = electrode.touches_bar(&bar.ends_m, bar.radius_m);
            if touched <= 0.0 || parted >= 1.0 {
                return parted;
            }
            if let Some(burnt_j) = self.burnt_j.get_mut(usize::from(bar.organ)) {
                *burnt_j += dose.whole_j_m2() * bar.area_m2 * touched;
            }
            bar.parted_by(parted, dose.parts() * touched)
        });
    }

    /// Tells of what was burnt: when it is time to, and when the current `is_off`.
    pub(crate) fn tell(&mut self, is_off: bool, journal: &mut Journal) {
        self.quiet = self.quiet.saturating_sub(1);
        if self.quiet > 0 && !is_off {
            return;
        }
        for (organ, burnt_j) in (0u32..).zip(&mut self.burnt_j) {
            let value = core::mem::take(burnt_j);
            if value > 0.0 {
                self.quiet = TOLD_TICKS;
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

fn touched_bars_m2(electrode: &Electrode, scene: &Scene<'_>, bodies: &mut Bodies) -> f32 {
    let mut sum_m2 = 0.0;
    part_all(
        scene,
        bodies,
        |_| (),
        |bar, parted| {
            if parted < 1.0 {
                let touched = electrode.touches_bar(&bar.ends_m, bar.radius_m);
                sum_m2 += bar.area_m2 * touched;
            }
            parted
        },
    );
    sum_m2
}

/// How much of each organ's surface the electrode touches, m². Tubes are bars, not surfaces.
fn touched_surfaces(
    electrode: &Electrode,
    contacts: &[Contact],
    scene: &Scene<'_>,
) -> [f32; MAX_ORGANS] {
    let mut areas_m2 = [0.0; MAX_ORGANS];
    let point_m2 = electrode.diameter_m() * electrode.diameter_m();
    for contact in contacts.iter().filter(|it| it.tool == Tool::Instrument) {
        let organ = usize::from(contact.organ.unwrap_or(u8::MAX));
        let is_surface = scene.organs.get(organ).is_some_and(|it| !is_tube(it));
        // A contact lies on the tool's own surface.
        let touched = electrode.touches_ball(&contact.at_m, 0.0);
        if let (true, Some(area_m2)) = (is_surface, areas_m2.get_mut(organ)) {
            *area_m2 = (*area_m2 + point_m2 * touched).min(electrode.side_m2());
        }
    }
    areas_m2
}

fn is_tube(organ: &Organ) -> bool {
    organ.batch_count == 0 && organ.elastic_links > 0
}
