//! Surfaces that a stone meets: contact skins of organs, spheres of tubes, tools, other stones.

use heapless::Vec;

use crate::capacity::MAX_ORGANS;
use crate::contact::skin::closest::walk;
use crate::contact::skin::vertex_cache::VertexCache;
use crate::math::{self, Vec3};
use crate::procedure::stones::Surroundings;
use crate::procedure::stones::touch::Touch;
use crate::scene::Organ;
use crate::tool::Capsule;
use crate::words::SphereBits;

/// Distance from a stone within which tissue is looked at, m.
pub(super) const NEAR_M: f32 = 0.006;

impl Surroundings<'_> {
    /// The bowl, and organs whose tissue is near a ball at `at_m`, each at its nearest place.
    pub(super) fn touches(
        &self,
        at_m: &Vec3,
        radius_m: f32,
        cache: &mut VertexCache,
    ) -> Vec<Touch, { MAX_ORGANS + 1 }> {
        let mut touches = Vec::new();
        let below = self.scene.stones.bowl.touch(at_m, radius_m);
        if let Some(below) = below.filter(|it| it.gap_m < NEAR_M) {
            let _ = touches.push(below); // the first
        }
        let reach_m = radius_m + NEAR_M;
        for (organ, bounds) in self.scene.organs.iter().zip(self.bounds) {
            if !bounds.reaches(at_m, reach_m) {
                continue;
            }
            let Some((sphere, gap_m)) = self.nearest_sphere(organ, at_m, radius_m) else {
                continue;
            };
            if gap_m > NEAR_M {
                continue;
            }
            let touch = self
                .on_skin(sphere, at_m, radius_m, cache)
                .unwrap_or_else(|| self.on_sphere(sphere, at_m, radius_m));
            let _ = touches.push(touch); // one for each organ, and the bowl
        }
        touches
    }

    /// Sphere of the organ whose surface is nearest to a ball, and the gap between them, m.
    fn nearest_sphere(&self, organ: &Organ, at_m: &Vec3, radius_m: f32) -> Option<(u32, f32)> {
        let mut nearest: Option<(u32, f32)> = None;
        let end = organ.sphere_start.saturating_add(organ.sphere_count);
        for sphere in organ.sphere_start..end {
            if self.bodies.bits.at(sphere).contains(SphereBits::REMOVED) {
                continue;
            }
            let center_m = self.bodies.nodes.at(sphere).center_m();
            let gap_m = math::norm(&(center_m - at_m)) - self.bodies.radius_m.at(sphere) - radius_m;
            if nearest.is_none_or(|(_, nearest_m)| gap_m < nearest_m) {
                nearest = Some((sphere, gap_m));
            }
        }
        nearest
    }

    /// The contact skin near this sphere; `None` for an organ without one.
    fn on_skin(
        &self,
        sphere: u32,
        at_m: &Vec3,
        radius_m: f32,
        cache: &mut VertexCache,
    ) -> Option<Touch> {
        let from = self.scene.skin.near_sphere(sphere)?;
        let found = walk(at_m, from, &self.scene.skin, self.bodies, cache)?;
        let sunk_m = found.sunk_m(self.scene, self.bodies);
        let offset_m = at_m - (found.at_m - found.normal * sunk_m);
        // Outside, the nearest point may be an edge. Inside, only the skin's normal leads out.
        let height_m = found.normal.dot(&offset_m);
        let (away_m, normal) = match math::unit(&offset_m) {
            Some(direction) if height_m > 0.0 => (math::norm(&offset_m), direction),
            _ => (height_m, found.normal),
        };
        Some(Touch {
            gap_m: away_m - radius_m,
            normal,
            sphere: Some(sphere),
        })
    }

    fn on_sphere(&self, sphere: u32, at_m: &Vec3, radius_m: f32) -> Touch {
        let offset_m = at_m - self.bodies.nodes.at(sphere).center_m();
        Touch {
            gap_m: math::norm(&offset_m) - self.bodies.radius_m.at(sphere) - radius_m,
            normal: math::unit(&offset_m).unwrap_or_else(|| self.up()),
            sphere: Some(sphere),
        }
    }

    /// Unit vector against gravity.
    pub(super) fn up(&self) -> Vec3 {
        math::unit(&-self.scene.room.gravity_m_s2).unwrap_or_else(Vec3::z)
    }
}

/// Gap between a ball and a tool's part, m, and the unit vector from the tool to the ball.
pub(super) fn off_tool(tool: &Capsule, at_m: &Vec3, radius_m: f32) -> (f32, Vec3) {
    let along_m = tool.b_m - tool.a_m;
    let share = along_m.dot(&(at_m - tool.a_m)) / along_m.norm_squared().max(f32::MIN_POSITIVE);
    let nearest_m = tool.a_m + along_m * share.clamp(0.0, 1.0);
    let offset_m = at_m - nearest_m;
    let gap_m = math::norm(&offset_m) - tool.radius_m - radius_m;
    let direction = math::unit(&offset_m).unwrap_or_else(|| math::perpendicular(&along_m));
    (gap_m, direction)
}
