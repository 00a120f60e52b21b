//! Walls that current burns through, place by place.
//!
//! A place moves with the sphere that was nearest to it at its first burn. It accumulates the
//! energy that it absorbs.

use heapless::Vec;

use crate::capacity::MAX_SCORCHED;
use crate::math::{self, Vec3};
use crate::procedure::cautery::electrode::BOIL_J_M3;
use crate::scene::{Inside, Organ, Scene};
use crate::tissue::Bodies;

/// Distance within which burns count as burns of one place, and radius of a hole, m.
const PLACE_RADIUS_M: f32 = 0.001_5;
/// Area of a hole, m².
pub(super) const HOLE_M2: f32 = core::f32::consts::PI * PLACE_RADIUS_M * PLACE_RADIUS_M;

/// A place of a wall.
#[derive(Debug, Clone, Copy)]
struct Place {
    organ: u8,
    sphere: u32,
    from_sphere_m: Vec3,
    absorbed_j: f32,
}

/// Burnt places of walls.
#[derive(Debug, Clone, Default)]
pub(super) struct Walls {
    places: Vec<Place, MAX_SCORCHED>,
}

/// A wall that was just burnt through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hole {
    pub(super) sphere: u32,
    /// Energy that the hole took, J.
    pub(super) energy_j: f32,
}

impl Walls {
    /// Heats the wall of the organ with this index at `at_m`. Returns the hole if the wall is now
    /// burnt through. O(spheres of the organ).
    pub(super) fn burn(
        &mut self,
        organ: u8,
        at_m: &Vec3,
        energy_j: f32,
        scene: &Scene<'_>,
        bodies: &Bodies,
    ) -> Option<Hole> {
        let burn_through_j = BOIL_J_M3 * HOLE_M2 * wall_m(scene.organs.get(usize::from(organ))?)?;
        let offset_m = |sphere: u32| at_m - bodies.nodes.at(sphere).center_m();
        let near_m = |it: &Place| math::norm(&(offset_m(it.sphere) - it.from_sphere_m));
        let mut own = self.places.iter_mut().filter(|it| it.organ == organ);
        let place = match own.find(|it| near_m(it) < PLACE_RADIUS_M) {
            Some(place) => place,
            None => {
                let it = scene.organs.get(usize::from(organ))?;
                let spheres = it.sphere_start..it.sphere_start.saturating_add(it.sphere_count);
                let distance2 = |sphere: &u32| offset_m(*sphere).norm_squared();
                let sphere = spheres.min_by(|a, b| distance2(a).total_cmp(&distance2(b)))?;
                let place = Place {
                    organ,
                    sphere,
                    from_sphere_m: offset_m(sphere),
                    absorbed_j: 0.0,
                };
                self.add(place)?
            }
        };
        let before_j = place.absorbed_j;
        place.absorbed_j += energy_j.max(0.0);
        (before_j < burn_through_j && place.absorbed_j >= burn_through_j).then_some(Hole {
            sphere: place.sphere,
            energy_j: burn_through_j,
        })
    }

    /// Adds a place. If there is no room, it replaces the least burnt place.
    fn add(&mut self, place: Place) -> Option<&mut Place> {
        if self.places.push(place).is_ok() {
            return self.places.last_mut();
        }
        let by_energy = |a: &&mut Place, b: &&mut Place| a.absorbed_j.total_cmp(&b.absorbed_j);
        let least_burnt = self.places.iter_mut().min_by(by_energy)?;
        *least_burnt = place;
        Some(least_burnt)
    }
}

/// Thickness of a hollow organ's wall, m: gallbladder 2 mm, gut 3 mm, ducts 1 mm, small arteries
/// 0.5 mm. `None` for solid tissue.
fn wall_m(organ: &Organ) -> Option<f32> {
    match (organ.inside, organ.is_tube()) {
        (Inside::Bile, false) => Some(0.002),
        (Inside::Bile, true) => Some(0.001),
        (Inside::Blood, _) => Some(0.000_5),
        (Inside::Food, _) => Some(0.003),
        (Inside::Solid | Inside::Liver, _) => None,
    }
}
