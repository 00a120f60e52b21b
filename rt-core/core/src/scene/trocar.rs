//! The instrument's trocar: a seal that rubs on the shaft, in an elastic abdominal wall.

use crate::math::Vec3;

/// Seal and wall at the instrument's port. A value of 0 leaves out its effect.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Trocar {
    /// Friction of the shaft that slides in the seal, N.
    pub sliding_n: f32,
    /// Friction at which a resting shaft breaks away, N: at least `sliding_n`.
    pub breakaway_n: f32,
    /// Elasticity of the abdominal wall against tilting of the trocar, N m/rad.
    pub wall_nm_rad: f32,
    /// Direction of the untilted trocar, into the body: a unit vector, or zero with a wall of 0.
    pub axis: Vec3,
}

/// Friction of a sliding dry shaft of 5 mm, N: the geometric mean of the range 0.25 to 3.0 N of six
/// trocars (van den Dobbelsteen and others 2007, doi:10.1007/s00464-006-9105-8).
const DRY_SLIDING_N: f32 = 0.87;
/// Additional friction when a dry shaft starts or reverses, N: the geometric mean of the
/// fluctuations of 0.2 to 2.5 N in the same trocars.
const DRY_JUMP_N: f32 = 0.71;
/// Share of the friction that is left on a moist shaft. In the same trocars, moistening reduced the
/// friction by 15 to 45 %; the middle of this range is 30 %.
const WET_SHARE: f32 = 0.7;
/// Elasticity of the wall, N m/rad. Assumed: Picod and others 2005
/// (doi:10.1007/s00464-003-9330-3) measured the torque of a tilted trocar, but we know only their
/// abstract.
const WALL_NM_RAD: f32 = 0.3;

impl Trocar {
    /// A port without friction or elasticity.
    pub const NONE: Self = Self {
        sliding_n: 0.0,
        breakaway_n: 0.0,
        wall_nm_rad: 0.0,
        axis: Vec3::new(0.0, 0.0, 0.0),
    };
    /// An average trocar with a dry shaft. The scene gives the axis.
    pub const DRY: Self = Self {
        sliding_n: DRY_SLIDING_N,
        breakaway_n: DRY_SLIDING_N + DRY_JUMP_N,
        wall_nm_rad: WALL_NM_RAD,
        ..Self::NONE
    };
    /// An average trocar with a moist shaft. The scene gives the axis.
    pub const WET: Self = Self {
        sliding_n: WET_SHARE * DRY_SLIDING_N,
        breakaway_n: WET_SHARE * (DRY_SLIDING_N + DRY_JUMP_N),
        wall_nm_rad: WALL_NM_RAD,
        ..Self::NONE
    };

    /// True if the port acts on the hand.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.breakaway_n > 0.0 || self.wall_nm_rad > 0.0
    }
}

/// The trocar that a station uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum TrocarChoice {
    /// The scene's.
    #[default]
    Scene = 0,
    /// A real one on the rig: nothing is rendered.
    Real = 1,
    /// [`Trocar::DRY`].
    Dry = 2,
    /// [`Trocar::WET`].
    Wet = 3,
}

impl TrocarChoice {
    /// The choice with this number.
    #[must_use]
    pub const fn from_number(number: u32) -> Option<Self> {
        Some(match number {
            0 => Self::Scene,
            1 => Self::Real,
            2 => Self::Dry,
            3 => Self::Wet,
            _ => return None,
        })
    }

    /// The trocar that acts in a scene whose own trocar is `scene`. The axis is always that of
    /// `scene`.
    #[must_use]
    pub const fn of(self, scene: Trocar) -> Trocar {
        let chosen = match self {
            Self::Scene => return scene,
            Self::Real => Trocar::NONE,
            Self::Dry => Trocar::DRY,
            Self::Wet => Trocar::WET,
        };
        Trocar {
            axis: scene.axis,
            ..chosen
        }
    }
}
