//! The material table: appearance of every kind of organ and every material of an instrument.
//!
//! Albedos are in linear RGB. They are dark and saturated, because wet tissue gets its brightness
//! from the reflections of its film. Colours were set by eye against laparoscopic pictures.

use shared_mem::scene::OrganKind;

use super::layout::{LOOKS, Look};

/// Row of tissue cooked by heat. No kind of organ has this number.
pub(super) const COOKED: u32 = 0;
/// Row of bare steel. Rows from this one on belong to no organ.
pub(super) const STEEL: u32 = 12;
/// Row of the black insulation of a shaft.
pub(super) const INSULATION: u32 = 13;
/// Row of the white ceramic of an electrode's collar.
pub(super) const CERAMIC: u32 = 14;
/// Row of the bright, worn steel of blades and teeth.
pub(super) const BLADE: u32 = 15;

/// Look of a tissue, from which its row of the table is packed. Lengths are in cm.
struct Tissue {
    /// Darkest albedo.
    low: [f32; 3],
    /// Lightest albedo.
    high: [f32; 3],
    /// Colour of streaks, and their share.
    streak: ([f32; 3], f32),
    /// Frequencies of the noise, 1/cm: coarse, medium, lobules, grain.
    frequencies: [f32; 4],
    /// Slopes of the bumps: medium, lobules, grain, wet film.
    slopes: [f32; 4],
    roughness: f32,
    /// Wet film: strength, roughness.
    film: [f32; 2],
    /// Scattered light, by colour.
    scatter: [f32; 3],
    /// Contrast of lobules and grain.
    contrast: f32,
    /// Visibility of the fine vessels on the tissue.
    veins: f32,
    /// Packed bumps (cellular noise; not the cells of layered tissue): frequency (1/cm), steepness,
    /// darkness of furrows, lightness of middles.
    cells: [f32; 4],
    /// Colour of a thin wall at grazing view, and its opacity.
    veil: ([f32; 3], f32),
}

impl Tissue {
    fn row(&self) -> Look {
        let with = |[r, g, b]: [f32; 3], w: f32| [r, g, b, w];
        let [coarse, middle, lobule, grain] = self.frequencies;
        Look {
            low: with(self.low, coarse),
            high: with(self.high, middle),
            streak: with(self.streak.0, self.streak.1),
            slope: self.slopes,
            wet: [self.roughness, self.film[0], self.film[1], 0.03],
            scatter: with(self.scatter, self.contrast),
            lobule: [lobule, grain, 0.0, self.veins],
            cell: self.cells,
            veil: with(self.veil.0, self.veil.1),
        }
    }
}

const LIVER: Tissue = Tissue {
    low: [0.074, 0.0125, 0.0095],
    high: [0.132, 0.0290, 0.0200],
    streak: ([0.170, 0.052, 0.034], 0.22),
    frequencies: [0.35, 1.3, 6.5, 17.0],
    slopes: [0.030, 0.030, 0.020, 0.018],
    roughness: 0.42,
    film: [1.0, 0.085],
    scatter: [0.45, 0.18, 0.14],
    contrast: 0.22,
    veins: 0.0,
    cells: [8.5, 0.010, 0.35, 0.10],
    veil: ([0.150, 0.050, 0.042], 0.35),
};

const GALLBLADDER: Tissue = Tissue {
    low: [0.036, 0.042, 0.026],
    high: [0.092, 0.092, 0.052],
    streak: ([0.090, 0.066, 0.028], 0.40),
    frequencies: [0.55, 1.6, 5.0, 12.0],
    slopes: [0.034, 0.022, 0.022, 0.018],
    roughness: 0.38,
    film: [1.0, 0.075],
    scatter: [0.50, 0.40, 0.25],
    contrast: 0.12,
    veins: 0.55,
    cells: [0.0; 4],
    veil: ([0.190, 0.165, 0.110], 0.75),
};

const DUCT: Tissue = Tissue {
    low: [0.170, 0.140, 0.066],
    high: [0.290, 0.235, 0.128],
    streak: ([0.290, 0.120, 0.075], 0.35),
    frequencies: [0.9, 2.6, 7.0, 16.0],
    slopes: [0.040, 0.030, 0.015, 0.020],
    roughness: 0.40,
    film: [1.0, 0.10],
    scatter: [0.50, 0.35, 0.22],
    contrast: 0.12,
    veins: 0.35,
    cells: [0.0; 4],
    veil: ([0.330, 0.270, 0.170], 0.4),
};

const ARTERY: Tissue = Tissue {
    low: [0.235, 0.046, 0.036],
    high: [0.340, 0.108, 0.080],
    streak: ([0.420, 0.215, 0.150], 0.40),
    frequencies: [1.0, 3.0, 8.0, 18.0],
    slopes: [0.035, 0.025, 0.015, 0.018],
    roughness: 0.36,
    film: [1.0, 0.09],
    scatter: [0.50, 0.22, 0.16],
    contrast: 0.12,
    veins: 0.0,
    cells: [0.0; 4],
    veil: ([0.400, 0.200, 0.150], 0.4),
};

const GUT: Tissue = Tissue {
    low: [0.210, 0.082, 0.058],
    high: [0.330, 0.160, 0.112],
    streak: ([0.300, 0.075, 0.052], 0.40),
    frequencies: [0.45, 1.5, 4.5, 11.0],
    slopes: [0.050, 0.030, 0.016, 0.026],
    roughness: 0.44,
    film: [1.0, 0.12],
    scatter: [0.50, 0.30, 0.22],
    contrast: 0.14,
    veins: 0.6,
    cells: [0.0; 4],
    veil: ([0.330, 0.190, 0.150], 0.5),
};

const FAT: Tissue = Tissue {
    low: [0.380, 0.190, 0.048],
    high: [0.540, 0.340, 0.115],
    streak: ([0.520, 0.130, 0.060], 0.30),
    frequencies: [0.5, 1.7, 4.5, 12.0],
    slopes: [0.130, 0.110, 0.030, 0.060],
    roughness: 0.48,
    film: [0.9, 0.17],
    scatter: [0.60, 0.50, 0.30],
    contrast: 0.16,
    veins: 0.3,
    cells: [4.2, 0.34, 0.75, 0.18],
    veil: ([0.560, 0.390, 0.150], 0.4),
};

const DONE: Tissue = Tissue {
    low: [0.070, 0.030, 0.010],
    high: [0.230, 0.110, 0.036],
    streak: ([0.030, 0.016, 0.009], 0.55),
    frequencies: [0.8, 2.4, 6.0, 15.0],
    slopes: [0.100, 0.090, 0.040, 0.020],
    roughness: 0.66,
    film: [0.25, 0.30],
    scatter: [0.25, 0.15, 0.08],
    contrast: 0.30,
    veins: 0.0,
    cells: [5.0, 0.10, 0.50, 0.10],
    veil: ([0.150, 0.090, 0.045], 0.2),
};

const MEMBRANE: Tissue = Tissue {
    low: [0.270, 0.150, 0.104],
    high: [0.400, 0.265, 0.190],
    streak: ([0.300, 0.075, 0.058], 0.30),
    frequencies: [0.7, 2.2, 6.0, 15.0],
    slopes: [0.060, 0.050, 0.025, 0.045],
    roughness: 0.46,
    film: [1.0, 0.14],
    scatter: [0.60, 0.45, 0.35],
    contrast: 0.18,
    veins: 0.6,
    cells: [0.0; 4],
    veil: ([0.400, 0.330, 0.270], 0.6),
};

const PERITONEUM: Tissue = Tissue {
    low: [0.270, 0.062, 0.047],
    high: [0.420, 0.150, 0.110],
    streak: ([0.480, 0.230, 0.130], 0.30),
    frequencies: [0.22, 0.8, 3.2, 9.0],
    slopes: [0.060, 0.030, 0.018, 0.030],
    roughness: 0.50,
    film: [0.8, 0.21],
    scatter: [0.50, 0.30, 0.25],
    contrast: 0.14,
    veins: 0.5,
    cells: [0.0; 4],
    veil: ([0.300, 0.130, 0.100], 0.3),
};

/// A solid material. Its albedo lies between `tint * low` and `tint * low * gain`. `wet` has four
/// numbers: roughness of the surface, strength of the film, roughness of the film, reflectance.
/// `metal` has two: the shares of metal and of brushing.
const fn solid(low: f32, tint: [f32; 3], gain: f32, wet: [f32; 4], metal: [f32; 2]) -> Look {
    let [r, g, b] = tint;
    Look {
        low: [r * low, g * low, b * low, 1.1],
        high: [r * low * gain, g * low * gain, b * low * gain, 1.0],
        streak: [0.0; 4],
        slope: [0.0; 4],
        wet,
        scatter: [0.0; 4],
        lobule: [1.0, 1.0, metal[0], metal[1]],
        cell: [0.0; 4],
        veil: [0.0; 4],
    }
}

/// The table, indexed by [`OrganKind`] and the constants above.
#[must_use]
pub(super) fn table() -> [Look; LOOKS] {
    let mut rows = [PERITONEUM.row(); LOOKS];
    for kind in OrganKind::ALL {
        rows[kind as usize] = match kind {
            OrganKind::Liver => LIVER,
            OrganKind::Gallbladder => GALLBLADDER,
            OrganKind::CysticDuct | OrganKind::BileDuct => DUCT,
            OrganKind::CysticArtery | OrganKind::Vessel => ARTERY,
            OrganKind::Stomach | OrganKind::Intestine => GUT,
            OrganKind::Fat => FAT,
            OrganKind::ConnectiveTissue => MEMBRANE,
            OrganKind::AbdominalWall => PERITONEUM,
        }
        .row();
    }
    rows[COOKED as usize] = DONE.row();
    let steel = [1.0, 0.97, 0.93];
    let grey = [1.0, 1.0, 1.0];
    rows[STEEL as usize] = solid(0.52, steel, 1.15, [0.27, 0.0, 0.3, 0.5], [1.0, 1.0]);
    rows[BLADE as usize] = solid(0.60, steel, 1.15, [0.22, 0.0, 0.3, 0.5], [1.0, 0.5]);
    rows[INSULATION as usize] = solid(0.010, grey, 1.6, [0.42, 0.35, 0.22, 0.045], [0.0, 0.2]);
    rows[CERAMIC as usize] = solid(
        0.62,
        [1.0, 0.98, 0.93],
        1.1,
        [0.28, 0.6, 0.15, 0.05],
        [0.0, 0.0],
    );
    rows
}
