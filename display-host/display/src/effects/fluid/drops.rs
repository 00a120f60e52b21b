//! Drops: fluid lets go of overhanging skin, falls, and stays where it lands.

use glam::Vec3;

use super::super::stain::Skin;
use super::super::{Kind, Particle, chance};
use super::parcel::{Falling, Lying};
use super::surface::{Place, Surface};
use super::volume::Volumes;
use super::{FALLING, Fluids, PARCEL_M3};

/// Volume at which a drop takes no more parcels while it lets go, m³. A whole drop of blood has
/// 30e-9 to 50e-9 m³.
const DROP_M3: f64 = 15e-9;
/// Largest gap to skin below that fluid bridges, m. The capillary length of blood is 2.3 mm.
const TOUCHES_M: f32 = 0.002;
/// Largest distance to a covering organ at which fluid comes up onto that organ, m.
const COVERED_M: f32 = 0.004;
/// Time after which a drop that has met nothing counts as gone, s.
const LOST_S: f32 = 1.2;

impl Fluids {
    /// The drops in the air, as particles.
    pub fn drops(&self) -> impl Iterator<Item = Particle> + '_ {
        self.falling.iter().map(|it| {
            let [blood, bile, water] = it.volume_m3;
            let total = blood + bile + water;
            let kind = match () {
                () if water > 4.0 * (blood + bile) => Kind::Water,
                () if blood >= bile => Kind::Blood,
                () => Kind::Bile,
            };
            Particle {
                kind,
                at_m: it.at_m,
                velocity_m_s: it.velocity_m_s,
                age_s: it.flies_s,
                lasts_s: LOST_S,
                // Spurting blood is a jet: thinner and longer than a drop.
                size_m: (0.239 * total as f32).cbrt() * if it.is_fast() { 0.4 } else { 1.0 },
                own: 0.5,
            }
        })
    }

    pub(super) fn throw(&mut self, at_m: Vec3, velocity_m_s: Vec3, volume_m3: Volumes, age_s: f32) {
        if !at_m.is_finite() || !velocity_m_s.is_finite() || self.falling.len() >= FALLING {
            return self.lose(volume_m3);
        }
        self.falling.push(Falling {
            at_m,
            velocity_m_s,
            volume_m3,
            age_s,
            flies_s: 0.0,
        });
    }

    /// Moves a parcel to skin that covers it or lies close below it, or lets it fall. Returns false
    /// if the parcel left the skin.
    pub(super) fn pass_on(
        &mut self,
        it: &mut Lying,
        [normal, at]: [Vec3; 2],
        thick_m: f32,
        surface: &mut Surface,
        skin: &Skin<'_>,
    ) -> bool {
        let Some((columns, _)) = &self.columns else {
            return true;
        };
        if it.stands() {
            return true;
        }
        // Cosine of the skin's inclination: 1 on skin that faces up, −1 on an underside.
        let level = normal.dot(self.up);
        // Above an underside lies the organ itself, which does not count as a cover.
        if let Some((place, far_m)) = columns.nearest(at, false, surface, skin)
            && far_m < COVERED_M
            && (0.0..0.9).contains(&level)
            && it.speed_m_s < 0.002
        {
            it.place = place;
            return true;
        }
        if level > 0.3 {
            return true;
        }
        if let Some((place, _)) = columns
            .nearest(at, true, surface, skin)
            .filter(|(_, far_m)| *far_m < TOUCHES_M)
        {
            it.place = place;
            return true;
        }
        // Fluid hangs at the lowest places of an overhang, where it is slow.
        let hangs = level < -0.25 && it.speed_m_s < 0.006 || level < -0.8;
        let drop_m = 0.000_5;
        if hangs && thick_m > drop_m && it.total_m3() > 0.1 * PARCEL_M3 {
            let drop = self.falling.iter_mut().find(|drop| {
                let near = drop.at_m.distance_squared(at) < 0.002 * 0.002;
                near && drop.flies_s < 0.05 && drop.volume_m3.iter().sum::<f64>() < DROP_M3
            });
            match drop {
                Some(drop) => {
                    for (sum, volume) in drop.volume_m3.iter_mut().zip(it.volume_m3) {
                        *sum += volume;
                    }
                }
                None => self.throw(at - self.up * 0.001, Vec3::ZERO, it.volume_m3, it.age_s),
            }
            return false;
        }
        true
    }

    /// Moves the drops. Those that meet skin stay there.
    pub(super) fn fly(&mut self, step_s: f32, surface: &mut Surface, skin: &Skin<'_>) {
        let mut falling = std::mem::take(&mut self.falling);
        let mut left = Vec::with_capacity(falling.len());
        for mut drop in falling.drain(..) {
            let from = drop.at_m;
            drop.step(step_s, self.up);
            let fell_m = (from - drop.at_m).dot(self.up);
            let below = self.columns.as_ref().and_then(|(columns, _)| {
                let above = drop.at_m + self.up * fell_m.max(0.0);
                columns.nearest(above, true, surface, skin)
            });
            let met = match below {
                Some((place, far_m)) if fell_m > 0.0 && far_m <= fell_m + 0.001 => Some(place),
                _ if drop.flies_s > 0.04 => skin.struck(drop.at_m).and_then(|vertex| {
                    let (triangle, weights) = skin.place_at(vertex)?;
                    Some(Place { triangle, weights })
                }),
                _ => None,
            };
            if let Some(place) = met {
                self.splash(place, &drop, surface, skin);
            } else if drop.flies_s > LOST_S || !drop.at_m.is_finite() {
                self.lose(drop.volume_m3);
            } else {
                left.push(drop);
            }
        }
        self.falling = left;
    }

    /// A drop spreads where it meets the skin.
    fn splash(&mut self, place: Place, drop: &Falling, surface: &mut Surface, skin: &Skin<'_>) {
        let total: f64 = drop.volume_m3.iter().sum();
        let parts = ((total / PARCEL_M3).ceil() as u32).clamp(1, 6);
        for _ in 0..parts {
            self.thrown = self.thrown.wrapping_add(1);
            let mut place = place;
            let way = chance(self.thrown) * 0.002;
            surface.walk(&mut place, way, skin);
            let share = drop.volume_m3.map(|v| v / f64::from(parts));
            self.lie(Lying::new(place, share, drop.age_s), skin);
        }
    }
}
