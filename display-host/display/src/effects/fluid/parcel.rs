//! A parcel of fluid: how it runs over the skin, hangs, lets go and falls.

use glam::Vec3;

use super::super::stain::Skin;
use super::field::{Field, MIDDLE_PER_M3};
use super::surface::{Place, Surface};
use super::volume::Volumes;

/// Density of blood, kg/m³; bile has 1010, and the difference is not modelled.
const DENSITY_KG_M3: f32 = 1060.0;
const GRAVITY_M_S2: f32 = 9.81;
/// Viscosity of blood, Pa s. Measured: 3.5 to 5.5 mPa s at high shear rates and 37 °C.
const BLOOD_PA_S: f32 = 0.004;
/// Viscosity of gallbladder bile, Pa s. Measured: 1.8 to 8 mPa s, many times that of hepatic bile.
const BILE_PA_S: f32 = 0.003;
/// Viscosity of the irrigator's water at 37 °C, Pa s.
const WATER_PA_S: f32 = 0.000_7;
/// Time in which clotting makes blood more viscous by the factor e, s. Assumed.
const THICKENS_S: f32 = 45.0;
/// Time after which blood has clotted and stands, s. In glass blood clots in 4 to 10 minutes, on
/// tissue faster; the lower end is assumed.
const CLOTS_S: f32 = 240.0;
/// Stress that the rim of a film on tissue withstands, Pa. Assumed: 0.2 mm of blood stay on a wall.
const HELD_PA: f32 = 2.2;
/// Thickness above which a film moves no faster, m: it flows in drops and rivulets.
const THICK_M: f32 = 0.000_4;
/// Fastest flow along skin, m/s.
const FASTEST_M_S: f32 = 0.045;
/// Least share of the weight by which a film evens out. It stands for surface tension, which evens
/// out a film on a steep slope and under a ceiling. Assumed.
const EVENS: f32 = 0.12;
/// Fastest spread of a pool, m/s. A faster spread would overshoot, because the steps are explicit.
const SPREADS_M_S: f32 = 0.012;
/// Volume that running fluid leaves behind on each metre of dry tissue, m³/m: a film of 2 mm width
/// and 0.1 mm thickness.
const LEFT_M3_PER_M: f64 = 2e-7;
/// A film thinner than this counts as dry tissue, m.
const DRY_M: f32 = 0.000_05;
/// Distance between the marks that running fluid leaves, m.
const MARK_M: f32 = 0.001_2;

/// Fluid on the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lying {
    pub(super) place: Place,
    /// Volumes of blood, bile and water, m³.
    pub(super) volume_m3: Volumes,
    pub(super) age_s: f32,
    /// Distance run since the last mark, m.
    pub(super) ran_m: f32,
    /// Speed in the last step, m/s.
    pub(super) speed_m_s: f32,
}

/// Fluid in the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Falling {
    pub(super) at_m: Vec3,
    pub(super) velocity_m_s: Vec3,
    pub(super) volume_m3: Volumes,
    pub(super) age_s: f32,
    /// Time in the air, s.
    pub(super) flies_s: f32,
}

/// Share of blood of this age that has clotted.
pub(super) fn clotted(age_s: f32) -> f32 {
    (age_s / CLOTS_S).clamp(0.0, 1.0)
}

impl Lying {
    pub(super) fn new(place: Place, volume_m3: Volumes, age_s: f32) -> Self {
        Self {
            place,
            volume_m3,
            age_s,
            ran_m: 0.0,
            speed_m_s: 0.0,
        }
    }

    pub(super) fn total_m3(&self) -> f64 {
        self.volume_m3.iter().sum()
    }

    /// True for blood that has clotted: it neither runs nor drips any more.
    pub(super) fn stands(&self) -> bool {
        self.age_s >= CLOTS_S && self.volume_m3[0] >= 0.5 * self.total_m3()
    }

    /// Viscosity under a film of which `water` is the share of water.
    fn viscosity_pa_s(&self, water: f32) -> f32 {
        let total = self.total_m3().max(1e-18);
        let [blood, bile, _] = self.volume_m3.map(|v| (v / total) as f32 * (1.0 - water));
        let thin = (1.0 - blood - bile).max(0.0);
        let fresh = BLOOD_PA_S * blood + BILE_PA_S * bile + WATER_PA_S * thin;
        fresh * (blood * self.age_s / THICKENS_S).min(12.0).exp()
    }

    /// Velocity along the skin, m/s. `thick_m` is the thickness of the film here, `water` its share
    /// of water, and `slope` the gradient of the thickness along the present skin.
    fn velocity(&self, up: Vec3, normal: Vec3, [thick_m, water]: [f32; 2], slope: Vec3) -> Vec3 {
        let level = normal.dot(up);
        let down = -(up - normal * level);
        let drives_pa = DENSITY_KG_M3 * GRAVITY_M_S2 * down.length() * thick_m;
        let film_m = thick_m.min(THICK_M);
        // Mean velocity of a film on a slope (Huppert 1982): ρ g h² / 3 μ.
        let per_slope =
            DENSITY_KG_M3 * GRAVITY_M_S2 * film_m * film_m / (3.0 * self.viscosity_pa_s(water));
        let runs = match drives_pa > HELD_PA {
            true => down * per_slope * (1.0 - HELD_PA / drives_pa),
            false => Vec3::ZERO,
        };
        let spreads = match thick_m > 2.0 * DRY_M {
            true => slope * (-per_slope * level.max(EVENS)),
            false => Vec3::ZERO,
        };
        runs.clamp_length_max(FASTEST_M_S) + spreads.clamp_length_max(SPREADS_M_S)
    }

    /// Moves by a step. Returns the mark that it leaves on dry tissue, and its present normal,
    /// thickness (m) and position (m).
    pub(super) fn step(
        &mut self,
        step_s: f32,
        up: Vec3,
        field: &Field,
        surface: &mut Surface,
        skin: &Skin<'_>,
    ) -> (Option<Self>, [Vec3; 2], f32) {
        self.age_s += step_s;
        let rest_m = Surface::at_rest(&self.place, skin);
        let (mut thick_m, slope) = field.thickness(rest_m);
        let water = field.water_share(rest_m);
        // Outside of the window the field is empty, so the parcel's own thickness counts there.
        let own_m = self.total_m3() as f32 * MIDDLE_PER_M3;
        thick_m = thick_m.max(own_m);
        let [a, b, c] = surface.corners(self.place.triangle, skin);
        let normal = (b - a).cross(c - a).normalize_or(up);
        let slope = surface.carried(self.place.triangle, slope, skin);
        let velocity = match self.stands() {
            true => Vec3::ZERO,
            false => self.velocity(up, normal, [thick_m, water], slope),
        };
        let before = self.place;
        let came_m = surface.walk(&mut self.place, velocity * step_s, skin);
        self.speed_m_s = came_m / step_s;
        let at = surface.position(&self.place, skin);
        let is_dry = thick_m - own_m < DRY_M;
        self.ran_m = if is_dry { self.ran_m + came_m } else { 0.0 };
        let mark = (self.ran_m > MARK_M).then(|| {
            let left = (LEFT_M3_PER_M * f64::from(self.ran_m)).min(0.5 * self.total_m3());
            let share = left / self.total_m3().max(1e-18);
            let mark = self.volume_m3.map(|v| v * share);
            self.volume_m3 = self.volume_m3.map(|v| v * (1.0 - share));
            self.ran_m = 0.0;
            Self::new(before, mark, self.age_s)
        });
        (mark, [normal, at], thick_m)
    }
}

impl Falling {
    /// True for a jet rather than a drop.
    pub(super) fn is_fast(&self) -> bool {
        self.velocity_m_s.length_squared() > 0.15 * 0.15
    }

    /// Moves by a step.
    pub(super) fn step(&mut self, step_s: f32, up: Vec3) {
        self.age_s += step_s;
        self.flies_s += step_s;
        self.at_m += self.velocity_m_s * step_s - up * (0.5 * GRAVITY_M_S2 * step_s * step_s);
        self.velocity_m_s -= up * (GRAVITY_M_S2 * step_s);
    }
}
