//! Tools against the skin of organs: where they touch, and the force that follows.
//!
//! Stage `contact` ([`SkinContacts::find`]) walks from where each place of a tool was on the skin
//! to where it is now, O(places near organs). Stage `solve` ([`SkinContacts::press`]) closes the
//! gaps: the spheres yield, and what they are too coarse for yields by the law of the half-space
//! ([`law`]). The multiplier is the force, and what it does to the tissue is what the hand feels.

mod closest;
mod friction;
mod law;
mod stations;
#[cfg(test)]
mod tests;

use heapless::Vec;

use crate::capacity::{MAX_ORGANS, MAX_SKIN_CONTACTS, MAX_STATIONS};
use crate::collision::tool_contact::Contact;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::scene::{Material, NO_VERTEX, Scene};
use crate::soft_body::Bodies;
use crate::state::SphereBits;
use crate::tool::Capsule;
use closest::{Closest, Patch, walk};
use friction::Bristle;
use law::Law;
use stations::{Station, stations};

/// Skin nearer than this to a tool is looked at again after the solve, m: what the fastest sphere
/// moves in a tick.
const NEAR_M: f32 = 0.003;
/// Skin farther than this is forgotten, m.
const FORGET_M: f32 = 0.012;
/// μ between wet tissue and steel.
const FRICTION: f32 = 0.1;
/// Passes over the contacts of an organ in a step; each begins with the last tick's forces.
const PASSES: u32 = 4;

/// What is remembered of a place of a tool on an organ.
#[derive(Debug, Clone, Copy)]
struct Track {
    vertex: u16,
    /// Whether the skin was near enough to be touched.
    is_near: bool,
    force_n: f32,
    /// Added to the gap, and dying away: what a contact that is found deep in the skin, or that
    /// jumps to another place of it, would else change at once, m.
    forgiven_m: f32,
    /// The gap, this included, m.
    gap_m: f32,
    /// Where the skin was touched, m; its outward normal there, and the place of the tool, m.
    at_m: Vec3,
    normal: Vec3,
    center_m: Vec3,
    /// How the place of the tool went in the last tick, m.
    way_m: Vec3,
    bristle: Bristle,
}

const NOWHERE: Track = Track {
    vertex: NO_VERTEX,
    is_near: false,
    force_n: 0.0,
    forgiven_m: 0.0,
    gap_m: 0.0,
    at_m: Vec3::new(0.0, 0.0, 0.0),
    normal: Vec3::new(0.0, 0.0, 0.0),
    center_m: Vec3::new(0.0, 0.0, 0.0),
    way_m: Vec3::new(0.0, 0.0, 0.0),
    bristle: Bristle::STRAIGHT,
};

/// What is left of a forgiven gap after a tick: it dies away within 0.1 s.
const FORGIVEN_KEEP: f32 = 0.99;
/// A place of the skin, or the gap, that goes this much farther in a tick than twice the tool has
/// jumped, m.
const JUMP_M: f32 = 0.0002;
/// A tool that slips off an edge goes over the skin by this a tick, and twice its own way, m.
const SLIP_M: f32 = 0.000_03;

impl Track {
    /// Takes in what was found, and keeps the gap from jumping.
    fn follow(&mut self, found: &Closest, gap_m: f32, center_m: &Vec3) {
        self.forgiven_m *= FORGIVEN_KEEP;
        if self.is_near {
            let moved_m = math::norm(&(found.at_m - self.at_m));
            let raw_m = self.gap_m - self.forgiven_m / FORGIVEN_KEEP;
            let closed_m = (raw_m - gap_m).abs();
            if moved_m.max(closed_m) > 2.0 * math::norm(&(center_m - self.center_m)) + JUMP_M {
                self.forgiven_m = self.gap_m - gap_m;
            }
            self.way_m = center_m - self.center_m;
        } else {
            self.forgiven_m = -gap_m;
            self.force_n = 0.0;
            self.way_m = Vec3::zeros();
            self.bristle = Bristle::STRAIGHT;
        }
        // Nothing that does not overlap is forgiven, nor owed.
        self.forgiven_m = if gap_m < 0.0 {
            self.forgiven_m.max(gap_m)
        } else {
            0.0
        };
        self.vertex = found.vertex;
        self.is_near = gap_m < NEAR_M;
        self.gap_m = gap_m + self.forgiven_m;
        self.at_m = found.at_m;
        self.normal = found.normal;
        self.center_m = *center_m;
    }
}

/// A place of a tool near or on the skin.
#[derive(Debug, Clone)]
struct Touch {
    organ: u8,
    station: u8,
    patch: Patch,
    normal: Vec3,
    /// What is taken from the centre's height over the patch to give the gap: the tool's radius, what
    /// the skin is curved, less what is forgiven, m.
    reach_m: f32,
    center_m: Vec3,
    /// Where the skin was when it was found, m.
    at_m: Vec3,
    law: Law,
    /// Gap before the solve, m.
    gap_m: f32,
    inverse_mass_per_kg: f32,
    force_n: f32,
    stiffness_n_m: f32,
    /// μ: the most that friction pulls, per normal force.
    friction: f32,
    /// How the place of the tool has gone in this tick, m.
    way_m: Vec3,
    /// Where the patch was before the solve, m.
    patch_m: Vec3,
    bristle: Bristle,
    /// Of the skin on the tool, N.
    friction_n: Vec3,
    friction_stiffness_n_m: f32,
}

/// Every place of the tools that is near skin.
#[derive(Debug)]
pub(crate) struct SkinContacts {
    tracks: [[Track; MAX_STATIONS]; MAX_ORGANS],
    near: Vec<Touch, MAX_SKIN_CONTACTS>,
}

impl Default for SkinContacts {
    fn default() -> Self {
        Self {
            tracks: [[NOWHERE; MAX_STATIONS]; MAX_ORGANS],
            near: Vec::new(),
        }
    }
}

impl SkinContacts {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.tracks = [[NOWHERE; MAX_STATIONS]; MAX_ORGANS];
        self.near.clear();
    }

    /// Finds the skin near `parts`, as it lies before the solve. `near_spheres` are the spheres
    /// near them. When there is more than [`MAX_SKIN_CONTACTS`] the deepest stay.
    pub(crate) fn find(
        &mut self,
        parts: &[Capsule],
        near_spheres: &(impl Iterator<Item = u32> + Clone),
        scene: &Scene<'_>,
        bodies: &Bodies,
        faults: &mut FaultSet,
    ) {
        self.near.clear();
        if scene.skin.vertices.is_empty() {
            return;
        }
        let stations = stations(parts);
        for ((organ, it), tracks) in (0u8..).zip(scene.organs).zip(&mut self.tracks) {
            let mut own = near_spheres
                .clone()
                .filter(|sphere| *bodies.organ.at(*sphere) == organ && has_skin(scene, *sphere))
                .peekable();
            if own.peek().is_none() {
                *tracks = [NOWHERE; MAX_STATIONS];
                continue;
            }
            for (place, track) in (0u8..).zip(&stations).zip(tracks.iter_mut()) {
                let found = look(place.1, track, own.clone(), scene, bodies);
                let Some(found) = found.filter(|(_, gap_m)| *gap_m < FORGET_M) else {
                    *track = NOWHERE;
                    continue;
                };
                track.follow(&found.0, found.1, &place.1.center_m);
                if !track.is_near {
                    continue;
                }
                let organ = (organ, &it.material);
                let closest = spread_under(place.1, found.0, scene, bodies);
                let touch = Touch::new(organ, place, closest, track, bodies);
                keep(&mut self.near, touch, faults);
            }
        }
    }

    /// How deep each place near skin lies in it, m; negative: the gap.
    pub(crate) fn depths_m(&self) -> impl Iterator<Item = f32> {
        self.near.iter().map(|touch| -touch.gap_m)
    }

    /// Presses the tools against the skin of organ `organ`, within a substep of `step_s`.
    pub(crate) fn press(&mut self, organ: u8, step_s: f32, bodies: &mut Bodies) {
        let squared = step_s * step_s;
        // The last forces first: what is left to find is the change.
        for touch in self.near.iter().filter(|touch| touch.organ == organ) {
            let push = (touch.normal * touch.force_n + touch.friction_n) * -squared;
            touch.patch.push(&push, bodies);
        }
        for _ in 0..PASSES {
            for i in 0..self.near.len() {
                let Some(touch) = self.near.get(i).filter(|touch| touch.organ == organ) else {
                    continue;
                };
                let yield_m_n = touch.inverse_mass_per_kg * squared;
                let patch_m = touch.patch.at_m(bodies);
                let height_m = touch.normal.dot(&(touch.center_m - patch_m));
                // The gap as it were without this contact's own force.
                let gap_m = height_m - touch.reach_m - yield_m_n * touch.force_n
                    + self.beside_others_m(i, touch);
                let (force_n, stiffness_n_m) = touch.law.force_n(gap_m, yield_m_n);
                // Along the skin the same: how far the tool is ahead without this contact's friction.
                let ahead_m =
                    touch.way_m - (patch_m - touch.patch_m) - touch.friction_n * yield_m_n;
                let most_n = touch.friction * force_n;
                let friction_n = touch
                    .bristle
                    .pull_n(&ahead_m, &touch.normal, yield_m_n, most_n);
                let change_n =
                    touch.normal * (touch.force_n - force_n) + (touch.friction_n - friction_n);
                touch.patch.push(&(change_n * squared), bodies);
                if let Some(touch) = self.near.get_mut(i) {
                    touch.force_n = force_n;
                    touch.stiffness_n_m = stiffness_n_m;
                    touch.friction_n = friction_n;
                    touch.friction_stiffness_n_m = touch.bristle.felt_n_m(yield_m_n);
                }
            }
        }
    }

    /// How far the other contacts on the same skin have already pressed it away from contact `i`,
    /// beyond what the spheres carry over, m.
    fn beside_others_m(&self, i: usize, touch: &Touch) -> f32 {
        let mut sum_m = 0.0;
        for (j, other) in self.near.iter().enumerate() {
            if j == i || other.organ != touch.organ || other.force_n <= 0.0 {
                continue;
            }
            let along = other.normal.dot(&touch.normal);
            if along <= 0.0 {
                continue;
            }
            let distance_m = math::norm(&(other.at_m - touch.at_m));
            let half_width_m = other.law.half_width_m(other.force_n);
            sum_m += along * other.force_n * other.law.beside_m_n(distance_m, half_width_m);
        }
        sum_m
    }

    /// Lists what the tools do to the skin, and remembers it for the next tick.
    pub(crate) fn list(&mut self, bodies: &mut Bodies, mut add: impl FnMut(Contact)) {
        for touch in &self.near {
            let track = self
                .tracks
                .get_mut(usize::from(touch.organ))
                .and_then(|tracks| tracks.get_mut(usize::from(touch.station)));
            if let Some(track) = track {
                track.force_n = touch.force_n;
                track.bristle = touch.bristle.after(&touch.friction_n);
            }
            if touch.force_n <= 0.0 {
                continue;
            }
            for (sphere, _) in touch.patch.parts() {
                let bits = bodies.bits.at_mut(sphere);
                *bits = bits.with(SphereBits::CONTACT);
            }
            add(Contact {
                organ: touch.organ,
                at_m: touch.at_m,
                normal: touch.normal,
                force_n: touch.force_n,
                stiffness_n_m: touch.stiffness_n_m,
                friction_n: touch.friction_n,
                friction_stiffness_n_m: touch.friction_stiffness_n_m,
            });
        }
    }
}

/// Whether a sphere's organ collides by its skin.
pub(crate) fn has_skin(scene: &Scene<'_>, sphere: u32) -> bool {
    scene.skin.near_sphere(sphere).is_some()
}

/// The skin of an organ nearest to a place of a tool, and the gap between them, m. One that is
/// touched is followed; otherwise the spheres say where else it could be nearer.
fn look(
    station: &Station,
    track: &Track,
    near_spheres: impl Iterator<Item = u32>,
    scene: &Scene<'_>,
    bodies: &Bodies,
) -> Option<(Closest, f32)> {
    let (center_m, skin) = (&station.center_m, &scene.skin);
    let gap_m = |found: &Closest| found.normal.dot(&(center_m - found.at_m)) - station.radius_m;
    // From under the skin the nearest point of it jumps. A tool that touches is lifted onto the skin
    // along the last normal and followed there, as a god-object is (Zilles and Salisbury 1995).
    let lifted_m = if track.is_near {
        let lift_m = track.normal.dot(&(track.at_m - center_m));
        let slip_m = center_m + track.normal * lift_m - track.at_m;
        let most_m = 2.0 * math::norm(&(center_m - track.center_m)) + SLIP_M;
        track.at_m + slip_m * (most_m / math::norm(&slip_m).max(most_m))
    } else {
        *center_m
    };
    let followed = walk(&lifted_m, track.vertex, skin, bodies);
    if let Some(found) = followed {
        let gap_m = gap_m(&found);
        if gap_m <= 0.0 || track.force_n > 0.0 {
            return Some((found, gap_m));
        }
    }
    let off_m = |sphere: u32| {
        let from = bodies.nodes.at(sphere).center_m() - center_m;
        math::norm(&from) - bodies.radius_m.at(sphere)
    };
    let mut nearest: Option<(u32, f32)> = None;
    for sphere in near_spheres {
        let off_m = off_m(sphere);
        if nearest.is_none_or(|(_, least_m)| off_m < least_m) {
            nearest = Some((sphere, off_m));
        }
    }
    let (sphere, off_m) = nearest?;
    if off_m > station.radius_m + FORGET_M {
        return None;
    }
    let found = walk(center_m, skin.near_sphere(sphere)?, skin, bodies)?;
    let gap_m = gap_m(&found);
    Some((found, gap_m))
}

/// Least patch under a tip, its radii: narrower ones would be pushed in ahead of the skin around
/// them as soon as the contact is as wide as they are.
const PATCH_RADII: f32 = 0.8;

fn spread_under(
    station: &Station,
    mut closest: Closest,
    scene: &Scene<'_>,
    bodies: &Bodies,
) -> Closest {
    let least_m = PATCH_RADII * station.radius_m;
    let missing_m2 = least_m * least_m - closest.patch_m * closest.patch_m;
    if missing_m2 > 0.0 {
        closest.spread(math::sqrt(missing_m2), &scene.skin, bodies);
    }
    closest
}

impl Touch {
    /// At a place of a tool (`station`, with this number) on what was found of an organ's skin.
    fn new(
        (organ, material): (u8, &Material),
        (number, station): (u8, &Station),
        closest: Closest,
        track: &Track,
        bodies: &Bodies,
    ) -> Self {
        let modulus_pa = material.young_pa / (1.0 - material.poisson * material.poisson);
        let law = Law::new(station.shape, modulus_pa, closest.patch_m);
        let bristle_n_m = law.along_n_m(track.force_n, material.poisson);
        let bristle = track.bristle.on(&closest.normal, bristle_n_m);
        let patch_m = closest.patch.at_m(bodies);
        Self {
            organ,
            station: number,
            normal: closest.normal,
            reach_m: closest.normal.dot(&(station.center_m - patch_m)) - track.gap_m,
            center_m: station.center_m,
            at_m: closest.at_m,
            law,
            gap_m: track.gap_m,
            inverse_mass_per_kg: closest.patch.inverse_mass_per_kg(bodies),
            force_n: track.force_n,
            stiffness_n_m: 0.0,
            friction: FRICTION,
            way_m: track.way_m,
            patch_m,
            // Where nothing has moved yet it pulls as in the last tick, where that is allowed.
            friction_n: bristle.pull_n(
                &Vec3::zeros(),
                &closest.normal,
                0.0,
                FRICTION * track.force_n,
            ),
            friction_stiffness_n_m: 0.0,
            bristle,
            patch: closest.patch,
        }
    }
}

/// Adds a touch; of too many the deepest stay.
fn keep(near: &mut Vec<Touch, MAX_SKIN_CONTACTS>, touch: Touch, faults: &mut FaultSet) {
    let Err(touch) = near.push(touch) else {
        return;
    };
    let mut lost_m = touch.gap_m;
    let shallowest = near
        .iter_mut()
        .reduce(|a, b| if b.gap_m > a.gap_m { b } else { a });
    if let Some(shallowest) = shallowest.filter(|shallowest| shallowest.gap_m > touch.gap_m) {
        lost_m = shallowest.gap_m;
        *shallowest = touch;
    }
    faults.raise_if(lost_m < 0.0, Fault::ContactOverflow);
}
