//! Heat that the hook's current leaves in tissue. The heat spreads, blood carries it off, and it
//! destroys tissue.
//!
//! Every sphere has a temperature, the mean of the tissue whose mass it carries. A burn smaller
//! than that tissue is averaged over it: the coarse spheres of a liver hardly warm under the tip,
//! the spheres of a duct do.
//!
//! | stage | does |
//! |---|---|
//! | `current` | turns a tick's current into heat: under the tip, around it, and along tubes |
//! | `conduction` | lets heat flow along links and attachments |
//! | `advance` | lets blood and gas carry heat off, boils water, sums damage (`arrhenius`) |
//!
//! # Balance
//!
//! The generator gives 30 W. All of it is accounted for ([`Balance`]): it is in tissue, or has
//! boiled water and tissue away, or blood or gas has carried it off, or it went through the body
//! with the current.
//!
//! # Cost
//!
//! Heat moves by millimetres in seconds, so a tick takes only every `TURNS`th link, attachment
//! and sphere, with a step of `TURNS` ticks. While nothing is warm, a tick does nothing.
//!
//! # Effects
//!
//! Heat moves nothing, so it changes no force. It destroys: an organ whose tissue has reached an
//! Arrhenius sum of 1 raises an event with the destroyed volume. Shrinking tissue is not modelled.

mod arrhenius;
mod conduction;
pub(crate) mod current;
mod tube_current;

use crate::capacity::MAX_ORGANS;
use crate::procedure::journal::Journal;
use crate::scene::{Inside, Organ, Scene};
use crate::time::TICK_S;
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;
use crate::words::{Event, EventKind};
use tube_current::TubeCurrent;

/// Ticks in which every link, attachment and sphere has its turn once.
const TURNS: u32 = 50;
/// Time step of heat, s.
const STEP_S: f32 = TURNS as f32 * TICK_S;

/// Density of tissue, kg/m³, and its heat capacity, J/(kg K).
const DENSITY_KG_M3: f32 = 1060.0;
const CAPACITY_J_KG_K: f32 = 3600.0;
/// Heat that a wet surface loses to the gas, W/(m² K): free convection 5, radiation 6, evaporation
/// 39. By Lewis, evaporation takes 16.5 K/kPa of the convection for each kPa of the difference in
/// vapour pressure: 0.47 kPa for each kelvin between 37 °C in moist gas and 52 °C on the tissue.
const SURFACE_LOSS_W_M2_K: f32 = 50.0;
/// Share of the surface of a tube or sheet that gas touches: half. The other half lies on other
/// tissue (assumed).
const OPEN_SHARE: f32 = 0.5;
/// Rise of temperature at which water boils, K.
const BOILS_K: f32 = 63.0;
/// Energy that boils the water of tissue away, J/kg: three quarters of tissue is water.
const DRYING_J_KG: f32 = 0.75 * 2.26e6;
/// Highest rise of temperature, K: at 300 °C dry tissue burns, and further heat leaves with the
/// smoke.
const HOTTEST_K: f32 = 263.0;
/// Rise of temperature below which tissue counts as cold, K.
const COLD_K: f32 = 0.1;
/// Ticks between two events of destroyed tissue of one organ.
const REPORT_TICKS: u32 = 500;

/// Energy since the last reset, J, by the place to which it went.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Given by the generator while its tip touched tissue.
    pub given_j: f64,
    /// In tissue, as temperature.
    pub stored_j: f64,
    /// Left as steam and smoke.
    pub boiled_j: f64,
    /// Carried off by blood.
    pub perfused_j: f64,
    /// Lost to the gas at the surface of tubes and sheets.
    pub cooled_j: f64,
    /// Went with the current through the body, too thinly spread to warm it.
    pub spread_j: f64,
    /// Still to warm tubes and sheets: the core collects it for a round of ticks.
    pub due_j: f64,
}

/// Temperature and damage of the tissue at a sphere, in bytes, for the display. Renewed once in
/// `TURNS` ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HeatCode {
    /// Temperature above the body's, K; 255 also stands for higher values.
    pub rise_k: u8,
    /// Share of proteins that heat has denatured: 255 is all.
    pub denatured: u8,
    /// Share of its water that the tissue has lost: 255 is all.
    pub dried: u8,
}

/// Destroyed tissue of an organ.
#[derive(Debug, Clone, Copy, Default)]
struct Destroyed {
    /// Volume, m³.
    volume_m3: f32,
    /// Volume in the last event, m³.
    reported_m3: f32,
    /// Ticks until the next event.
    quiet_ticks: u32,
}

/// Temperature and damage of all tissue.
#[derive(Debug, Clone)]
pub(crate) struct Heat {
    /// Heat above the temperature of the body, without that of evaporation, J.
    warmth_j: PerSphere<f32>,
    /// Heat that has evaporated water, J.
    dried_j: PerSphere<f32>,
    /// Heat capacity, J/K; 0 for spheres that are not in the scene.
    capacity_j_k: PerSphere<f32>,
    /// Number of links at each sphere.
    link_count: PerSphere<u16>,
    /// Arrhenius sum.
    damage: PerSphere<f32>,
    /// Electric potential at spheres of tubes, as a share of the tip's.
    potential: PerSphere<f32>,
    /// Sums of one sweep of the potential: conductance times potential, and conductance.
    sums: PerSphere<(f32, f32)>,
    tube_current: TubeCurrent,
    codes: PerSphere<HeatCode>,
    destroyed: [Destroyed; MAX_ORGANS],
    balance: Balance,
    /// Turn of the next tick.
    turn: u32,
    /// Highest rise of temperature in this round of turns, K.
    warmest_k: f32,
    /// True if some tissue is warm.
    is_warm: bool,
}

impl Heat {
    pub(crate) const fn new() -> Self {
        Self {
            warmth_j: PerSphere::new(0.0),
            dried_j: PerSphere::new(0.0),
            capacity_j_k: PerSphere::new(0.0),
            link_count: PerSphere::new(0),
            damage: PerSphere::new(0.0),
            potential: PerSphere::new(0.0),
            sums: PerSphere::new((0.0, 0.0)),
            tube_current: TubeCurrent::NONE,
            codes: PerSphere::new(HeatCode {
                rise_k: 0,
                denatured: 0,
                dried: 0,
            }),
            destroyed: [Destroyed {
                volume_m3: 0.0,
                reported_m3: 0.0,
                quiet_ticks: 0,
            }; MAX_ORGANS],
            balance: Balance {
                given_j: 0.0,
                stored_j: 0.0,
                boiled_j: 0.0,
                perfused_j: 0.0,
                cooled_j: 0.0,
                spread_j: 0.0,
                due_j: 0.0,
            },
            turn: 0,
            warmest_k: 0.0,
            is_warm: false,
        }
    }

    /// Loads a scene. All tissue starts at the temperature of the body.
    pub(crate) fn load(&mut self, scene: &Scene<'_>) {
        *self = Self::new();
        for (sphere, rest) in (0u32..).zip(scene.spheres) {
            *self.capacity_j_k.at_mut(sphere) = rest.mass_kg * CAPACITY_J_KG_K;
        }
        for link in scene.links {
            for sphere in [link.a, link.b] {
                let count = self.link_count.at_mut(sphere);
                *count = count.saturating_add(1);
            }
        }
    }

    /// Energy since the last reset, by the place to which it went.
    pub(crate) fn balance(&self, scene: &Scene<'_>) -> Balance {
        let count = scene.spheres.len() as u32;
        let stored = self.warmth_j.range(0, count).iter();
        Balance {
            stored_j: stored.map(|it| f64::from(*it)).sum(),
            due_j: f64::from(self.tube_current.due_j),
            ..self.balance
        }
    }

    /// Temperature above the body's, K.
    fn rise_k(&self, sphere: u32) -> f32 {
        let capacity_j_k = *self.capacity_j_k.at(sphere);
        if capacity_j_k > 0.0 {
            *self.warmth_j.at(sphere) / capacity_j_k
        } else {
            0.0
        }
    }

    /// Codes of the first `count` spheres.
    pub(crate) fn codes(&self, count: u32) -> &[HeatCode] {
        self.codes.range(0, count)
    }

    fn code(&self, sphere: u32, rise_k: f32) -> HeatCode {
        let drying_j = self.drying_j(sphere);
        let dried = *self.dried_j.at(sphere) / drying_j.max(f32::MIN_POSITIVE);
        // `as` saturates and truncates.
        HeatCode {
            rise_k: rise_k as u8,
            denatured: (255.0 * denatured_share(*self.damage.at(sphere))) as u8,
            dried: (255.0 * dried) as u8,
        }
    }

    /// Volume of the tissue of a sphere, m³.
    fn volume_m3(&self, sphere: u32) -> f32 {
        *self.capacity_j_k.at(sphere) / (CAPACITY_J_KG_K * DENSITY_KG_M3)
    }

    /// Energy that boils all water at a sphere away, J.
    fn drying_j(&self, sphere: u32) -> f32 {
        *self.capacity_j_k.at(sphere) * (DRYING_J_KG / CAPACITY_J_KG_K)
    }

    /// Adds heat to a sphere. Beyond the boiling point it evaporates water, and dry tissue burns.
    fn warm(&mut self, sphere: u32, energy_j: f32) {
        let capacity_j_k = *self.capacity_j_k.at(sphere);
        // NaN counts as no heat.
        let is_heat = energy_j > 0.0 && energy_j.is_finite() && capacity_j_k > 0.0;
        if !is_heat {
            return;
        }
        self.is_warm = true;
        let mut warmth_j = *self.warmth_j.at(sphere) + energy_j;
        let excess_j = (warmth_j - BOILS_K * capacity_j_k).min(energy_j);
        let room_j = self.drying_j(sphere) - *self.dried_j.at(sphere);
        let evaporates_j = excess_j.min(room_j).max(0.0);
        *self.dried_j.at_mut(sphere) += evaporates_j;
        warmth_j -= evaporates_j;
        let burns_j = (warmth_j - HOTTEST_K * capacity_j_k).max(0.0);
        *self.warmth_j.at_mut(sphere) = warmth_j - burns_j;
        self.balance.boiled_j += f64::from(evaporates_j + burns_j);
    }

    /// Advances by a tick: heat flows, blood and gas carry it off, and damage grows.
    pub(crate) fn advance(&mut self, scene: &Scene<'_>, bodies: &Bodies, journal: &mut Journal) {
        if self.is_warm {
            self.conduct(scene, bodies);
            self.cool_and_destroy(scene, bodies);
            self.turn += 1;
            if self.turn >= TURNS {
                self.is_warm = self.warmest_k > COLD_K;
                (self.turn, self.warmest_k) = (0, 0.0);
            }
        }
        self.report(scene, bodies, journal);
    }

    /// Lets blood and gas carry heat off, and sums damage, at the spheres of this turn.
    fn cool_and_destroy(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        let count = scene.spheres.len() as u32;
        for sphere in (self.turn..count).step_by(TURNS as usize) {
            let rise_k = self.rise_k(sphere);
            if rise_k <= 0.0 {
                continue;
            }
            self.warmest_k = self.warmest_k.max(rise_k);
            let before = *self.damage.at(sphere);
            let after = arrhenius::sum_after(before, rise_k, STEP_S);
            *self.damage.at_mut(sphere) = after;
            let organ = usize::from(*bodies.organ.at(sphere));
            if before < 1.0
                && after >= 1.0
                && let Some(destroyed) = self.destroyed.get_mut(organ)
            {
                destroyed.volume_m3 +=
                    *self.capacity_j_k.at(sphere) / (CAPACITY_J_KG_K * DENSITY_KG_M3);
            }
            let it = scene.organs.get(organ);
            // No blood flows through destroyed tissue.
            if after < 1.0 {
                let per_s = it.map_or(0.0, flow_per_s);
                let carried_j = *self.warmth_j.at(sphere) * (per_s * STEP_S);
                *self.warmth_j.at_mut(sphere) -= carried_j;
                self.balance.perfused_j += f64::from(carried_j);
            }
            if it.is_some_and(Organ::is_tube) {
                let rest = scene.spheres.get(sphere as usize);
                let per_s = rest.map_or(0.0, |it| loss_per_s(it.radius_m));
                let cooled_j = *self.warmth_j.at(sphere) * (per_s * STEP_S).min(1.0);
                *self.warmth_j.at_mut(sphere) -= cooled_j;
                self.balance.cooled_j += f64::from(cooled_j);
            }
            *self.codes.at_mut(sphere) = self.code(sphere, rise_k);
        }
    }

    /// Raises an event for each organ of which heat has destroyed more tissue, at most twice a
    /// second.
    fn report(&mut self, scene: &Scene<'_>, bodies: &Bodies, journal: &mut Journal) {
        for (organ, destroyed) in (0u8..).zip(&mut self.destroyed) {
            destroyed.quiet_ticks = destroyed.quiet_ticks.saturating_sub(1);
            let is_more = destroyed.volume_m3 > destroyed.reported_m3;
            if !is_more || destroyed.quiet_ticks > 0 || !journal.has_room() {
                continue;
            }
            destroyed.quiet_ticks = REPORT_TICKS;
            destroyed.reported_m3 = destroyed.volume_m3;
            let Some(it) = scene.organs.get(usize::from(organ)) else {
                continue;
            };
            // The hottest place.
            let own = it.sphere_start..it.sphere_start.saturating_add(it.sphere_count);
            let hottest = own.max_by(|a, b| {
                let [a, b] = [a, b]
                    .map(|it| *self.warmth_j.at(*it) * per_capacity(*self.capacity_j_k.at(*it)));
                a.total_cmp(&b)
            });
            journal.raise(Event {
                kind: EventKind::Seared,
                organ: Some(u32::from(organ)),
                at_m: hottest.map_or(bodies.nodes.at(it.sphere_start).center_m(), |sphere| {
                    bodies.nodes.at(sphere).center_m()
                }),
                value: destroyed.volume_m3,
            });
        }
    }
}

/// `1 − exp(−Ω)`, by a series that is off by less than 0.01.
fn denatured_share(damage: f32) -> f32 {
    let power = 1.0 + damage * (1.0 + damage * (0.5 + damage * (1.0 / 6.0 + damage / 24.0)));
    1.0 - 1.0 / power
}

fn per_capacity(capacity_j_k: f32) -> f32 {
    if capacity_j_k > 0.0 {
        1.0 / capacity_j_k
    } else {
        0.0
    }
}

/// Share of its heat that a tube with this radius loses at its surface in a second. The surface has
/// an area of 2 / radius for each volume.
fn loss_per_s(radius_m: f32) -> f32 {
    let loss_w_m3_k = SURFACE_LOSS_W_M2_K * OPEN_SHARE * 2.0 / radius_m.max(1.0e-4);
    loss_w_m3_k / (DENSITY_KG_M3 * CAPACITY_J_KG_K)
}

/// Flow of blood through tissue, in volumes of the tissue a second. Liver: 1 ml/min for each ml.
/// Vessels: assumed, because their flow carries heat away. Walls of gut and gallbladder: 0.4 ml/min
/// for each ml, assumed. Fat and connective tissue: 0.05 ml/min for each ml, assumed.
///
/// Ducts lie on the portal vein and the hepatic artery, whose blood cools them: a third of the
/// surface conducts through 2 mm of tissue, 0.5 W/(m K) / 2 mm. With a radius of 3 mm this carries
/// off as much as 0.015 volumes a second, on top of the wall's own blood.
fn flow_per_s(organ: &Organ) -> f32 {
    match organ.inside {
        Inside::Liver => 0.017,
        Inside::Blood => 0.1,
        Inside::Bile if organ.is_tube() => 0.022,
        Inside::Bile | Inside::Food => 0.007,
        Inside::Solid => 0.000_8,
    }
}

#[cfg(test)]
mod tests;
