//! Stones in the gallbladder.

use crate::capacity::MAX_STONES;
use crate::math::{Pose, Quat, Vec3};
use crate::scene::check::check_pose;
use crate::scene::{Scene, SceneError};

/// Stones in the gallbladder, all of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stones {
    /// Number of stones.
    pub count: u32,
    /// Diameter of each, m.
    pub diameter_m: f32,
    /// Volume inside the gallbladder's wall, m³: bile and stones together.
    pub room_m3: f32,
    /// The abdomen below the organs, in which stones that miss them come to rest.
    pub bowl: Bowl,
}

/// The lower half of an ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bowl {
    /// Middle and axes: right, up, back.
    pub world_from_bowl: Pose,
    /// Radii along the axes, m.
    pub radii_m: [f32; 3],
}

impl Stones {
    /// No stones.
    pub const NONE: Self = Self {
        count: 0,
        diameter_m: 0.0,
        room_m3: 0.0,
        bowl: Bowl {
            world_from_bowl: Pose {
                rotation: Quat::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
                translation: nalgebra::Translation {
                    vector: Vec3::new(0.0, 0.0, 0.0),
                },
            },
            radii_m: [1.0; 3],
        },
    };

    /// Radius of each, m.
    pub(crate) const fn radius_m(&self) -> f32 {
        0.5 * self.diameter_m
    }

    /// Number of stones that leave with a cubic metre of bile, while the stones are spread evenly
    /// in the gallbladder: their number divided by the volume of the bile.
    pub(crate) fn per_bile_m3(&self) -> f32 {
        let own_m3 = self.count as f32 * core::f32::consts::PI / 6.0
            * (self.diameter_m * self.diameter_m * self.diameter_m);
        let bile_m3 = (self.room_m3 - own_m3).max(f32::MIN_POSITIVE);
        self.count as f32 / bile_m3
    }
}

impl Scene<'_> {
    /// Adds the stones in the gallbladder.
    ///
    /// # Errors
    /// If there are too many stones, or a value is out of range.
    pub fn with_stones(mut self, stones: Stones) -> Result<Self, SceneError> {
        let count = stones.count as usize;
        if count > MAX_STONES {
            return Err(SceneError::TooMany {
                what: "stones",
                count,
                limit: MAX_STONES,
            });
        }
        let checks = [
            (
                "diameter of the stones",
                stones.diameter_m,
                1.0e-3,
                0.05,
                "0.001 to 0.05 m",
            ),
            (
                "volume of the gallbladder",
                stones.room_m3,
                1.0e-6,
                1.0e-3,
                "1e-6 to 1e-3 m³",
            ),
        ];
        let radii = stones.bowl.radii_m.map(|radius_m| {
            (
                "radius of the bowl",
                radius_m,
                1.0e-3,
                10.0,
                "0.001 to 10 m",
            )
        });
        check_pose("world_from_bowl", &stones.bowl.world_from_bowl)?;
        for (what, value, least, most, allowed) in checks.into_iter().chain(radii) {
            if count > 0 && !(least..=most).contains(&value) {
                return Err(SceneError::Value {
                    what,
                    index: 0,
                    value,
                    allowed,
                });
            }
        }
        self.stones = stones;
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use std::string::ToString as _;

    const FEW: Stones = Stones {
        count: 20,
        diameter_m: 0.004,
        room_m3: 40.0e-6,
        ..Stones::NONE
    };

    #[test]
    fn twenty_stones_in_forty_millilitres_leave_every_second_millilitre() {
        let each_m3 = 1.0 / FEW.per_bile_m3();
        assert!((each_m3 - 1.966e-6).abs() < 0.01e-6, "{each_m3}");
        assert!(Stones::NONE.per_bile_m3() <= 0.0);
    }

    #[test]
    fn stones_out_of_range_are_refused() {
        let organs = [organ(0, 1, 0, 0)];
        let spheres = [sphere(Vec3::zeros(), 0.01)];
        let scene = Scene::new(&organs, &spheres, &[], room()).unwrap();
        assert!(scene.with_stones(FEW).is_ok() && scene.with_stones(Stones::NONE).is_ok());
        for (stones, says) in [
            (
                Stones { count: 31, ..FEW },
                "scene has 31 stones, the limit is 30",
            ),
            (
                Stones {
                    diameter_m: f32::NAN,
                    ..FEW
                },
                "diameter of the stones",
            ),
            (
                Stones {
                    room_m3: 1.0,
                    ..FEW
                },
                "volume of the gallbladder",
            ),
            (
                Stones {
                    bowl: Bowl {
                        radii_m: [0.1, f32::INFINITY, 0.1],
                        ..FEW.bowl
                    },
                    ..FEW
                },
                "radius of the bowl",
            ),
            (
                Stones {
                    bowl: Bowl {
                        world_from_bowl: Pose {
                            rotation: Quat::new_unchecked(nalgebra::Quaternion::default()),
                            ..FEW.bowl.world_from_bowl
                        },
                        ..FEW.bowl
                    },
                    ..FEW
                },
                "world_from_bowl",
            ),
        ] {
            let error = scene.with_stones(stones).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
