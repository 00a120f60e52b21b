//! Blood, bile and water that flow: over the skin, downhill, in pools, and in drops from one organ
//! to the next.
//!
//! ```text
//! leak (tick) × rate (assess) ─► source ─► parcels on the skin ◄──► drops in the air
//! irrigator ─► jet (rinse) ────────────────►  │  └──────► jar (rinse)
//!                                              │
//!                                              ▼
//!                              thickness of the film (field) ─► flow, picture
//! ```
//!
//! # Volumes
//!
//! The tick owns each leak: its place and its share of the full flow. `assess` owns the full flow
//! of each kind of organ, ml/min. Both are published. The product of both is the metric `blood_ml`
//! or `bile_ml`, and the same product fills this model. [`Balance`] says where the volume is:
//! what left a vessel or the irrigator lies on tissue, falls, is in the jar, or is gone out of
//! reach. A tube that is cut or torn also empties itself once. No leak reports that, so the balance
//! has it as a sum of its own.
//!
//! # Law
//!
//! The fluid is a bounded number of parcels. A parcel is a place on the skin with volumes of blood,
//! bile and water. Spread by a kernel, all parcels give the thickness h of the film ([`Field`]). A
//! parcel moves with the mean velocity of a viscous film on a slope, ρ g h² / 3 μ times the slope
//! of the free surface (H. E. Huppert, "Flow and instability of a viscous current down a slope",
//! Nature 300, 1982). The slope is that of the tissue, and on level ground also that of the film
//! itself, which evens out pools. A film stands still if its weight does not overcome the hold of
//! its rim. Blood becomes more viscous with time. Once it has clotted it stands, and drips no more.
//! A parcel that runs over dry tissue leaves a thin film there.
//!
//! Where skin overhangs, a thick film at a lowest place lets go as a drop. Fluid passes to another
//! organ at once where that organ lies close below, and comes up where another organ covers it.
//! Blood of arteries spurts with each heartbeat; its mean flow is that of the leak.
//!
//! The irrigator's water runs like blood, only thinner. Where water lies, blood is thinner too, and
//! the jet pushes it along. Suction takes parcels and drops near the tip into the jar, and the pool
//! around flows towards the tip (`rinse`).
//!
//! Assumed numbers are marked so at their constants. A pool is a thick film: the picture raises its
//! surface by its thickness, up to 6 mm, but organs that dip into it displace nothing. Blood and
//! water do not mix within a parcel.
//!
//! The steps have a fixed length, and the pseudo-random numbers are a fixed sequence. So the same
//! record gives the same fluid, as far as the tissue moves alike between two pictures.

mod columns;
mod drops;
mod field;
mod parcel;
mod rinse;
mod room;
mod surface;
mod volume;
mod window;

use core::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;

use self::columns::Columns;
pub use self::field::{Block, Field, Film, SIZE, VOXEL_M};
use self::parcel::{Falling, Lying, clotted};
use self::surface::{Place, Surface};
pub use self::volume::Volumes;
pub(super) use self::volume::WATER_M3;
use super::stain::Skin;
use super::{Kind, chance};

/// Largest number of parcels on the skin.
pub const LYING: usize = 4096;
/// Largest number of drops in the air.
pub const FALLING: usize = 192;
/// Ordinary volume of a parcel that a source gives off, m³.
const PARCEL_M3: f64 = 1.5e-9;
/// Radius of a vessel's mouth, m.
const MOUTH_M: f32 = 0.000_8;
/// Age of the columns after which they are sorted again, s.
const COLUMNS_S: f32 = 0.5;
/// Number of steps from one search of a parcel for skin below and above it to the next.
const LOOKS: u32 = 5;

/// Volumes of blood, bile and water by their place, ml.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Volume from leaks that the controller reports; for water, from the irrigator.
    pub leaked_ml: Volumes,
    /// Volume from divided tubes that emptied themselves.
    pub emptied_ml: Volumes,
    /// Volume that lies on tissue.
    pub lies_ml: Volumes,
    /// Volume that falls.
    pub falls_ml: Volumes,
    /// Volume that is gone: it fell out of reach, or found no skin to lie on or no room among the
    /// drops in the air.
    pub gone_ml: Volumes,
    /// Volume in the suction's jar.
    pub jar_ml: Volumes,
}

/// Volumes of one fluid by their place, ml.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Whereabouts {
    /// Left a vessel or the irrigator.
    pub left_ml: f64,
    /// Lies on tissue, or falls.
    pub on_tissue_ml: f64,
    /// In the suction's jar.
    pub jar_ml: f64,
    /// Gone out of reach.
    pub gone_ml: f64,
}

impl Balance {
    /// Volumes of blood, bile and water.
    #[must_use]
    pub fn by_fluid(&self) -> [Whereabouts; 3] {
        core::array::from_fn(|k| Whereabouts {
            left_ml: self.leaked_ml[k] + self.emptied_ml[k],
            on_tissue_ml: self.lies_ml[k] + self.falls_ml[k],
            jar_ml: self.jar_ml[k],
            gone_ml: self.gone_ml[k],
        })
    }
}

/// All blood and bile outside of vessels.
#[derive(Debug, Clone)]
pub struct Fluids {
    up: Vec3,
    lying: Vec<Lying>,
    falling: Vec<Falling>,
    field: Option<Field>,
    surface: Option<Surface>,
    columns: Option<(Columns, f32)>,
    middle_m: Vec3,
    came_m3: [Volumes; 2],
    gone_m3: Volumes,
    jar_m3: Volumes,
    steps: u32,
    thrown: u32,
    /// Number of the last change. No two changes of any fluids have the same number.
    change: u64,
}

/// Fluid that leaves a source.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gush {
    pub(super) kind: Kind,
    pub(super) at_m: Vec3,
    /// Vertex of the skin at the source.
    pub(super) mouth: Option<usize>,
    pub(super) volume_m3: f64,
    /// Velocity of the part that spurts, m/s, and its share.
    pub(super) spurts: (Vec3, f32),
    /// True for a leak, false for a tube that empties itself.
    pub(super) is_leak: bool,
}

impl Fluids {
    pub(super) fn new(up: Vec3) -> Self {
        Self {
            up,
            lying: Vec::new(),
            falling: Vec::new(),
            field: None,
            surface: None,
            columns: None,
            middle_m: Vec3::ZERO,
            came_m3: [[0.0; 3]; 2],
            gone_m3: [0.0; 3],
            jar_m3: [0.0; 3],
            steps: 0,
            thrown: 0,
            change: next_change(),
        }
    }

    /// Unit vector against gravity.
    pub(crate) fn up(&self) -> Vec3 {
        self.up
    }

    /// Thickness of the films; `None` while nothing has leaked.
    #[must_use]
    pub fn field(&self) -> Option<&Field> {
        self.field.as_ref()
    }

    /// Number of the last change of the films. Equal numbers mean equal films.
    pub(crate) fn change(&self) -> u64 {
        self.change
    }

    /// Number of parcels on the skin, and of drops in the air.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        [self.lying.len(), self.falling.len()]
    }

    /// Volumes, by where they are.
    #[must_use]
    pub fn balance(&self) -> Balance {
        let sum = |volumes: &mut dyn Iterator<Item = Volumes>| {
            let total = volumes.fold([0.0; 3], |a, b| core::array::from_fn(|k| a[k] + b[k]));
            total.map(|it| it * 1e6)
        };
        Balance {
            leaked_ml: self.came_m3[0].map(|it| it * 1e6),
            emptied_ml: self.came_m3[1].map(|it| it * 1e6),
            lies_ml: sum(&mut self.lying.iter().map(|it| it.volume_m3)),
            falls_ml: sum(&mut self.falling.iter().map(|it| it.volume_m3)),
            gone_ml: self.gone_m3.map(|it| it * 1e6),
            jar_ml: self.jar_m3.map(|it| it * 1e6),
        }
    }

    /// Places of the fluid on the skin, world frame, m.
    #[must_use]
    pub fn places(&self, skin: &Skin<'_>) -> Vec<Vec3> {
        let mut surface = self.surface.clone().unwrap_or_default();
        if !surface.fits(skin) {
            return Vec::new();
        }
        surface.begin_moment();
        let places = self.lying.iter();
        places.map(|it| surface.position(&it.place, skin)).collect()
    }

    /// Forgets the neighbours of the skin's triangles, because the skin was cut.
    pub(crate) fn skin_changed(&mut self) {
        (self.surface, self.columns) = (None, None);
    }

    /// Takes fluid from a source.
    pub(super) fn pour(&mut self, gush: &Gush, skin: &Skin<'_>) {
        let slot = usize::from(gush.kind == Kind::Bile);
        let mut volume_m3 = [0.0; 3];
        volume_m3[slot] = gush.volume_m3;
        self.came_m3[usize::from(!gush.is_leak)][slot] += gush.volume_m3;
        let place = gush.mouth.and_then(|vertex| skin.place_at(vertex));
        let (velocity, share) = gush.spurts;
        // Where there is no skin, the part that does not spurt joins the jet, or falls without
        // speed if nothing spurts.
        let (velocity, share) = match place {
            Some(_) => (velocity, f64::from(share)),
            None if share > 0.0 => (velocity, 1.0),
            None => (Vec3::ZERO, 1.0),
        };
        let spurts = volume_m3.map(|v| v * share);
        let runs = volume_m3.map(|v| v * (1.0 - share));
        if spurts.iter().sum::<f64>() > 0.0 {
            self.throw(gush.at_m, velocity, spurts, 0.0);
        }
        if let Some((triangle, weights)) = place {
            self.open_window(gush.at_m, gush.mouth.unwrap_or(0), skin);
            let mut place = Place { triangle, weights };
            // Parcels at one point would hold each other there.
            self.thrown = self.thrown.wrapping_add(1);
            if let Some(surface) = &mut self.surface {
                surface.walk(&mut place, chance(self.thrown) * MOUTH_M, skin);
            }
            self.lie(Lying::new(place, runs, 0.0), skin);
        }
    }

    /// Volume of the parcels that a source of this flow gives off, m³.
    pub(super) fn parcel_m3(&self, flow_m3_s: f64) -> f64 {
        (flow_m3_s / 90.0).clamp(0.1 * PARCEL_M3, 4.0 * PARCEL_M3)
    }

    fn lose(&mut self, volume_m3: Volumes) {
        for (gone, volume) in self.gone_m3.iter_mut().zip(volume_m3) {
            *gone += volume;
        }
    }

    /// Prepares for steps at this moment of the skin.
    pub(super) fn begin_moment(&mut self, skin: &Skin<'_>) {
        let fits = self.surface.as_ref().is_some_and(|it| it.fits(skin));
        if let Some(surface) = self.surface.as_mut().filter(|_| fits) {
            surface.begin_moment();
        } else {
            self.surface = None;
            self.lay_anew(skin);
        }
    }

    /// Advances by a step.
    pub(super) fn step(&mut self, step_s: f32, skin: &Skin<'_>) {
        if self.lying.is_empty() && self.falling.is_empty() {
            return;
        }
        let mut surface = self.surface.take().unwrap_or_else(|| {
            let mut surface = Surface::of(skin);
            surface.begin_moment();
            surface
        });
        self.flow(step_s, &mut surface, skin);
        self.surface = Some(surface);
    }

    /// Sums up the parcels in the field.
    fn spread(&mut self, skin: &Skin<'_>) {
        let Some(field) = &mut self.field else { return };
        self.change = next_change();
        field.clear();
        for it in &self.lying {
            let at = Surface::at_rest(&it.place, skin);
            field.add(at, it.volume_m3, clotted(it.age_s));
        }
    }

    fn flow(&mut self, step_s: f32, surface: &mut Surface, skin: &Skin<'_>) {
        self.steps = self.steps.wrapping_add(1);
        self.fly(step_s, surface, skin);
        self.renew_columns(step_s, surface, skin);
        let Some(field) = self.field.take() else {
            return;
        };
        let mut lying = std::mem::take(&mut self.lying);
        let mut marks = Vec::new();
        let mut left = Vec::with_capacity(lying.len());
        for (number, mut it) in (0u32..).zip(lying.drain(..)) {
            let (mark, [normal, at], thick_m) = it.step(step_s, self.up, &field, surface, skin);
            marks.extend(mark);
            let looks = (self.steps.wrapping_add(number)).is_multiple_of(LOOKS);
            if looks && !self.pass_on(&mut it, [normal, at], thick_m, surface, skin) {
                continue;
            }
            left.push(it);
        }
        self.lying = left;
        for mark in marks {
            self.lie(mark, skin);
        }
        self.field = Some(field);
        if self.lying.len() > LYING * 7 / 8 {
            self.thin_out(skin);
        }
        self.spread(skin);
    }

    /// Sorts the columns again if they are old.
    fn renew_columns(&mut self, step_s: f32, surface: &mut Surface, skin: &Skin<'_>) {
        match &mut self.columns {
            Some((_, age_s)) if *age_s + step_s < COLUMNS_S => *age_s += step_s,
            _ => {
                self.move_window(surface, skin);
                let columns = Columns::around(self.middle_m, self.up, surface, skin);
                self.columns = Some((columns, 0.0));
            }
        }
    }
}

/// A number that no change had before.
fn next_change() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed)
}

#[cfg(test)]
mod tests;
