//! The irrigator: its jet of water, and its suction into a jar.

use glam::Vec3;

use super::super::chance;
use super::super::stain::Skin;
use super::Fluids;
use super::field::MIDDLE_PER_M3;
use super::parcel::Lying;
use super::surface::{Place, Surface};
use super::volume::{Volumes, WATER};

/// Distance that the jet reaches before it falls, m.
const JET_M: f32 = 0.06;
/// Step in which the jet's path is searched for tissue, m.
const SEARCH_M: f32 = 0.001_5;
/// Speed of the jet, m/s. Assumed.
const JET_M_S: f32 = 0.8;
/// Radius of the place where the jet meets tissue, m. Assumed.
const WASHED_M: f32 = 0.006;
/// Speed at which the jet pushes fluid away from that place, m/s. Assumed.
const WASHES_M_S: f32 = 0.05;
/// Distance from the suction's mouth within which the mouth takes fluid, m. Assumed: the tip has
/// holes around its end.
const TAKES_M: f32 = 0.005;
/// Distance from the suction's mouth within which fluid flows towards the mouth, m. Assumed: a pool
/// empties into a tip that dips into it.
const DRAWS_M: f32 = 0.012;
/// Speed of that flow, m/s. Assumed.
const DRAWS_M_S: f32 = 0.02;
/// A film thinner than this stays on the tissue around the suction's mouth, m. Assumed.
const STAYS_M: f32 = 0.000_2;
/// Fluid that the suction takes, m³/s. Wall suction takes more air than fluid; assumed.
const TAKES_M3_S: f64 = 12e-6;
/// Volume of the jar, m³.
const JAR_M3: f64 = 2e-3;

impl Fluids {
    /// Sends water along the jet from `at_m`. The jet pushes fluid away where it meets tissue.
    pub(in crate::effects) fn rinse(
        &mut self,
        (at_m, along): (Vec3, Vec3),
        volume_m3: f64,
        step_s: f32,
        skin: &Skin<'_>,
    ) {
        let mut water: Volumes = [0.0; 3];
        water[WATER] = volume_m3;
        self.came_m3[0][WATER] += volume_m3;
        let steps = (JET_M / SEARCH_M) as u32;
        let way = (0..steps).map(|step| at_m + along * (step as f32 * SEARCH_M));
        let met = way.filter_map(|at| skin.struck(at)).find_map(|vertex| {
            let (triangle, weights) = skin.place_at(vertex)?;
            Some((vertex, Place { triangle, weights }))
        });
        let Some((vertex, mut place)) = met else {
            return self.throw(at_m, along * JET_M_S, water, 0.0);
        };
        let meets_m = skin.place(vertex);
        self.open_window(meets_m, vertex, skin);
        if let Some(mut surface) = self.surface.take() {
            self.thrown = self.thrown.wrapping_add(1);
            surface.walk(&mut place, chance(self.thrown) * (0.3 * WASHED_M), skin);
            self.wash(meets_m, step_s, &mut surface, skin);
            self.surface = Some(surface);
        }
        self.lie(Lying::new(place, water, 0.0), skin);
    }

    /// Pushes fluid away from the place where the jet meets tissue.
    fn wash(&mut self, meets_m: Vec3, step_s: f32, surface: &mut Surface, skin: &Skin<'_>) {
        for it in &mut self.lying {
            let off = surface.position(&it.place, skin) - meets_m;
            if off.length_squared() < WASHED_M * WASHED_M {
                let way = off.normalize_or_zero() * (WASHES_M_S * step_s);
                surface.walk(&mut it.place, way, skin);
            }
        }
    }

    /// Takes fluid near the suction's mouth into the jar, until the jar is full. Fluid around flows
    /// towards the mouth.
    pub(in crate::effects) fn suck(&mut self, at_m: Vec3, step_s: f32, skin: &Skin<'_>) {
        let room_m3 = JAR_M3 - self.jar_m3.iter().sum::<f64>();
        let mut left_m3 = (TAKES_M3_S * f64::from(step_s)).min(room_m3).max(0.0);
        if left_m3 <= 0.0 {
            return;
        }
        let jar_m3 = &mut self.jar_m3;
        let mut take = |near: bool, volume_m3: &mut Volumes| {
            let total: f64 = volume_m3.iter().sum();
            if !near || left_m3 <= 0.0 || total <= 0.0 {
                return true;
            }
            let share = (left_m3 / total).min(1.0);
            left_m3 -= total * share;
            for (jar, volume) in jar_m3.iter_mut().zip(volume_m3.iter_mut()) {
                *jar += *volume * share;
                *volume -= *volume * share;
            }
            share < 1.0
        };
        let is_near = |at: Vec3| at.distance_squared(at_m) < TAKES_M * TAKES_M;
        self.falling
            .retain_mut(|it| take(is_near(it.at_m), &mut it.volume_m3));
        if let Some(surface) = &mut self.surface {
            self.lying.retain_mut(|it| {
                let at = surface.position(&it.place, skin);
                take(is_near(at), &mut it.volume_m3)
            });
        }
        self.draw(at_m, step_s, skin);
    }

    /// Lets fluid around the suction's mouth flow towards it. Fluid that lies deeper than the mouth
    /// reaches does not rise to it.
    fn draw(&mut self, at_m: Vec3, step_s: f32, skin: &Skin<'_>) {
        let (Some(surface), Some(field)) = (&mut self.surface, &self.field) else {
            return;
        };
        for it in &mut self.lying {
            let off = at_m - surface.position(&it.place, skin);
            let is_far = off.length_squared() >= DRAWS_M * DRAWS_M || off.dot(self.up) >= TAKES_M;
            if is_far || it.stands() {
                continue;
            }
            let own_m = it.total_m3() as f32 * MIDDLE_PER_M3;
            let (film_m, _) = field.thickness(Surface::at_rest(&it.place, skin));
            if film_m.max(own_m) > STAYS_M {
                let way = off.normalize_or_zero() * (DRAWS_M_S * step_s);
                surface.walk(&mut it.place, way, skin);
            }
        }
    }

    /// Volume in the jar, ml, and share of the jar that is full.
    #[must_use]
    pub fn jar(&self) -> (f64, f64) {
        let in_it_m3: f64 = self.jar_m3.iter().sum();
        (in_it_m3 * 1e6, in_it_m3 / JAR_M3)
    }
}
