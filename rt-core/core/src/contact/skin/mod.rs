//! Contact of tools with the contact skins of organs: a god-object for each tool point on each
//! skin.
//!
//! Stage `contact` ([`SkinContacts::find`]) moves each god-object over the skin from its last place
//! towards its tool point (Zilles and Salisbury 1995), O(points near organs). The law of a
//! half-space ([`crate::contact::law`]) adds the compliance that the spheres lack.

pub(crate) mod closest;
#[cfg(test)]
mod tests;
mod tool_points;
pub(crate) mod vertex_cache;

use heapless::Vec;

use crate::capacity::{INSTRUMENT_POINTS, MAX_CONTACTS, MAX_ORGANS, MAX_TOOL_POINTS};
use crate::contact::constraint::{
    CachedForce, Candidate, ContactConstraints, ContactModel, ContactSite,
};
use crate::contact::law::{Law, Shape};
use crate::contact::separation::FilteredSeparation;
use crate::fault::FaultSet;
use crate::math::{self, Vec3};
use crate::scene::{Material, NO_VERTEX, Scene};
use crate::tissue::Bodies;
use crate::tool::Capsule;
use closest::{ClosestPoint, walk};
use tool_points::{ToolPoint, tool_points};
use vertex_cache::VertexCache;

/// Separation below which skin becomes a candidate for the solver, m: the travel of the fastest
/// sphere in a tick.
const NEAR_M: f32 = 0.003;
/// Separation beyond which skin is not tracked, m.
const TRACKING_RANGE_M: f32 = 0.012;
/// Assumed travel of tissue in a tick, m. It decides when skin out of reach is searched for again.
/// Contact with faster tissue is found late, and then begins at zero depth.
const TISSUE_TRAVEL_M: f32 = 0.0005;
/// Travel of a contact point over the skin that a tick allows beyond twice the tool's travel, m, so
/// that even a still tool can slip off an edge.
pub(crate) const SLIP_M: f32 = 0.000_01;

/// Largest offset of a contact that opens, m: skin that moves away by more than this in a tick does
/// not push.
const OPENING_MAX_M: f32 = 0.003;
/// Largest change of a contact force, N a tick, by a turn of its direction while the tool is still.
/// Without this bound, the force would turn at once when skin folds or a contact jumps between
/// folds. Several tool points may turn together, and the lever may double the force at the hand.
/// With a larger value the force follows folds faster, in larger steps.
const TURN_STEP_N: f32 = 0.001_5;
/// Largest turn in a tick, rad, however small the force is.
const TURN_MAX_RAD: f32 = 0.1;

/// Largest turn of a force in a tick while the tool is still, rad.
fn turn_max_at_rest_rad(force_n: f32) -> f32 {
    (TURN_STEP_N / force_n.max(TURN_STEP_N)).min(TURN_MAX_RAD)
}

/// Contact of a tool point with an organ, at the end of a tick.
#[derive(Debug, Clone, Copy)]
struct PersistentContact {
    vertex: u16,
    /// True if the separation is below `NEAR_M`.
    is_near: bool,
    /// Relative travel of point and skin before they can be near each other, m.
    clearance_m: f32,
    cached: CachedForce,
    separation: FilteredSeparation,
    /// Contact point on the skin, world frame, m.
    at_m: Vec3,
    /// Outward normal of the skin at the contact point.
    normal: Vec3,
    /// Direction in which the skin pushes the tool; it turns towards `normal` gradually.
    push_direction: Vec3,
    /// The tool point, world frame, m.
    center_m: Vec3,
    /// Travel of the tool point in the last tick, m.
    travel_m: Vec3,
}

const NO_CONTACT: PersistentContact = PersistentContact {
    vertex: NO_VERTEX,
    is_near: false,
    clearance_m: 0.0,
    cached: CachedForce::ZERO,
    separation: FilteredSeparation::NONE,
    at_m: Vec3::new(0.0, 0.0, 0.0),
    normal: Vec3::new(0.0, 0.0, 0.0),
    push_direction: Vec3::new(0.0, 0.0, 0.0),
    center_m: Vec3::new(0.0, 0.0, 0.0),
    travel_m: Vec3::new(0.0, 0.0, 0.0),
};

impl PersistentContact {
    /// A tool point that has no skin near it.
    fn far_from(center_m: &Vec3) -> Self {
        Self {
            clearance_m: TRACKING_RANGE_M - NEAR_M,
            center_m: *center_m,
            ..NO_CONTACT
        }
    }

    /// True while the tool point, now at `center_m`, cannot have come near the skin. Subtracts its
    /// travel from the clearance.
    fn is_still_far(&mut self, center_m: &Vec3) -> bool {
        if self.is_near || self.clearance_m <= 0.0 {
            return false;
        }
        self.clearance_m -= math::norm(&(center_m - self.center_m)) + TISSUE_TRAVEL_M;
        self.center_m = *center_m;
        self.clearance_m > 0.0
    }

    /// Updates the contact with the closest point of the skin. The separation and the direction of
    /// the push change without steps.
    fn track(&mut self, found: &ClosestPoint, separation_m: f32, point: &ToolPoint) {
        let center_m = &point.center_m;
        let mut push_direction = found.normal;
        if self.is_near {
            self.travel_m = center_m - self.center_m;
            let travel_m = math::norm(&self.travel_m);
            self.separation = self.separation.next(separation_m, travel_m, OPENING_MAX_M);
            if self.cached.force_n > 0.0 {
                // A tool that rolls over an edge turns by its travel over its radius.
                let turn_max_rad = (2.0 * travel_m / point.radius_m)
                    .max(turn_max_at_rest_rad(self.cached.force_n));
                push_direction =
                    math::rotated_towards(&self.push_direction, &push_direction, turn_max_rad);
            }
        } else {
            self.travel_m = Vec3::zeros();
            self.separation = FilteredSeparation::first(separation_m);
            self.cached = CachedForce::ZERO;
        }
        self.vertex = found.vertex;
        self.is_near = separation_m < NEAR_M;
        self.clearance_m = (separation_m - NEAR_M).max(0.0);
        self.at_m = found.at_m;
        self.push_direction = push_direction;
        self.normal = found.normal;
        self.center_m = *center_m;
    }
}

/// Every tool point on every skin.
#[derive(Debug, Clone)]
pub(crate) struct SkinContacts {
    contacts: [[PersistentContact; MAX_TOOL_POINTS]; MAX_ORGANS],
    /// Organs on which some tool point is tracked.
    is_tracked: [bool; MAX_ORGANS],
    /// Points of the instrument and of the endoscope in the last tick.
    point_counts: [usize; 2],
    vertices: VertexCache,
}

impl Default for SkinContacts {
    fn default() -> Self {
        Self {
            contacts: [[NO_CONTACT; MAX_TOOL_POINTS]; MAX_ORGANS],
            is_tracked: [false; MAX_ORGANS],
            point_counts: [0; 2],
            vertices: VertexCache::default(),
        }
    }
}

/// A sphere near a tool.
#[derive(Debug, Clone, Copy)]
struct NearSphere {
    sphere: u32,
    center_m: Vec3,
    radius_m: f32,
}

impl SkinContacts {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        // In place, because a new `SkinContacts` is too large for the stack of a tick.
        for contact in self.contacts.iter_mut().flatten() {
            *contact = NO_CONTACT;
        }
        self.is_tracked = [false; MAX_ORGANS];
        self.point_counts = [0; 2];
    }

    /// Forgets points that no longer exist (a shaft drawn out, a camera out of the body), because
    /// they will return elsewhere.
    fn forget_missing(&mut self, tool_points: &[(u8, ToolPoint)]) {
        let is_instrument = |number: u8| usize::from(number) < INSTRUMENT_POINTS;
        let instrument_count = tool_points
            .iter()
            .filter(|(number, _)| is_instrument(*number))
            .count();
        let point_counts = [instrument_count, tool_points.len() - instrument_count];
        if core::mem::replace(&mut self.point_counts, point_counts) == point_counts {
            return;
        }
        for contacts in &mut self.contacts {
            let (instrument, endoscope) =
                contacts.split_at_mut(INSTRUMENT_POINTS.min(MAX_TOOL_POINTS));
            for (contacts, count) in [instrument, endoscope].into_iter().zip(point_counts) {
                for contact in contacts.iter_mut().skip(count) {
                    *contact = NO_CONTACT;
                }
            }
        }
    }

    /// Finds the skin near `parts` and adds its constraints, before the solve. `near_spheres` are
    /// the spheres near the tools.
    pub(crate) fn find(
        &mut self,
        parts: &[Capsule],
        near_spheres: &(impl Iterator<Item = u32> + Clone),
        scene: &Scene<'_>,
        bodies: &Bodies,
        constraints: &mut ContactConstraints,
        faults: &mut FaultSet,
    ) {
        if scene.skin.vertices.is_empty() {
            return;
        }
        let tool_points = tool_points(parts);
        self.forget_missing(&tool_points);
        let cache = &mut self.vertices;
        cache.begin();
        let contacts = self.contacts.iter_mut().zip(&mut self.is_tracked);
        for ((organ_index, organ), (contacts, is_tracked)) in
            (0u8..).zip(scene.organs).zip(contacts)
        {
            let organ_spheres: Vec<NearSphere, MAX_CONTACTS> = near_spheres
                .clone()
                .filter(|sphere| *bodies.organ.at(*sphere) == organ_index)
                .map(|sphere| NearSphere {
                    sphere,
                    center_m: bodies.nodes.at(sphere).center_m(),
                    radius_m: *bodies.radius_m.at(sphere),
                })
                .take(MAX_CONTACTS)
                .collect();
            if organ_spheres.is_empty() {
                if *is_tracked {
                    *contacts = [NO_CONTACT; MAX_TOOL_POINTS];
                    *is_tracked = false;
                }
                continue;
            }
            *is_tracked = true;
            for (number, point) in &tool_points {
                let number = *number;
                let Some(contact) = contacts.get_mut(usize::from(number)) else {
                    continue;
                };
                if contact.is_still_far(&point.center_m) {
                    continue;
                }
                let found = closest_skin(point, contact, &organ_spheres, (scene, bodies), cache);
                let Some(found) =
                    found.filter(|(_, separation_m)| *separation_m < TRACKING_RANGE_M)
                else {
                    *contact = PersistentContact::far_from(&point.center_m);
                    continue;
                };
                contact.track(&found.0, found.1, point);
                if !contact.is_near {
                    continue;
                }
                let closest = widen_patch(point, found.0, (scene, bodies), cache);
                let site = ContactSite::Skin { point: number };
                let found = candidate(
                    (organ_index, &organ.material),
                    site,
                    point,
                    closest,
                    contact,
                );
                constraints.add(found, bodies, faults);
            }
        }
    }

    /// Stores the force of this tool point on this organ for the next tick.
    pub(crate) fn store(&mut self, organ: u8, point: u8, cached: CachedForce) {
        let contacts = self.contacts.get_mut(usize::from(organ));
        if let Some(contact) = contacts.and_then(|contacts| contacts.get_mut(usize::from(point))) {
            contact.cached = cached;
        }
    }
}

/// The closest point of an organ's skin to a tool point, and its separation, m. If the tool point
/// touches the skin, its god-object is followed. Otherwise a walk that starts at the sphere nearest
/// to the tool point finds skin that may be nearer; the nearer of the two is taken.
fn closest_skin(
    point: &ToolPoint,
    contact: &PersistentContact,
    near_spheres: &[NearSphere],
    (scene, bodies): (&Scene<'_>, &Bodies),
    cache: &mut VertexCache,
) -> Option<(ClosestPoint, f32)> {
    let (center_m, skin) = (&point.center_m, &scene.skin);
    let separation_m = |found: &ClosestPoint| {
        let offset_m = center_m - found.at_m;
        let mut away_m = found.normal.dot(&offset_m);
        // A tool point that comes to lie out past an edge is not under the skin, however low it is.
        // A skin that is near already keeps the height, so that its force has no step
        // (`force_on_the_built_in_organs_has_no_step`).
        let is_past_edge = offset_m.norm_squared() > 2.0 * away_m * away_m;
        if is_past_edge && !contact.is_near {
            away_m = math::norm(&offset_m);
        }
        away_m - point.radius_m + found.sunk_m(scene, bodies)
    };
    // While a tool point is under the skin, the nearest point of the skin may jump. So a tool point
    // near skin is first lifted onto the skin along the last normal; the walk leads towards the
    // lifted point.
    let lifted_m = if contact.is_near {
        let lift_m = contact.normal.dot(&(contact.at_m - center_m));
        let slip_m = center_m + contact.normal * lift_m - contact.at_m;
        let move_max_m = 2.0 * math::norm(&(center_m - contact.center_m)) + SLIP_M;
        contact.at_m + slip_m * (move_max_m / math::norm(&slip_m).max(move_max_m))
    } else {
        *center_m
    };
    let followed = walk(&lifted_m, contact.vertex, skin, bodies, cache);
    if let Some(found) = &followed {
        let separation_m = separation_m(found);
        if separation_m <= 0.0 || contact.cached.force_n > 0.0 {
            return followed.map(|found| (found, separation_m));
        }
    }
    let mut nearest: Option<(u32, f32)> = None;
    for ball in near_spheres {
        let distance_m = math::norm(&(ball.center_m - center_m)) - ball.radius_m;
        if nearest.is_none_or(|(_, nearest_m)| distance_m < nearest_m) {
            nearest = Some((ball.sphere, distance_m));
        }
    }
    let (sphere, distance_m) = nearest?;
    if distance_m > point.radius_m + TRACKING_RANGE_M {
        return None;
    }
    let reached = walk(center_m, skin.near_sphere(sphere)?, skin, bodies, cache);
    // The walk from the sphere may end on the other side of a thin organ.
    let distance_m2 = |found: &ClosestPoint| (center_m - found.at_m).norm_squared();
    let both = [followed, reached].into_iter().flatten();
    let found = both.min_by(|a, b| distance_m2(a).total_cmp(&distance_m2(b)))?;
    let separation_m = separation_m(&found);
    Some((found, separation_m))
}

/// Least width of the patch under a tool point, in radii of the tool. A narrower patch would be
/// pushed in ahead of the skin around it. A larger value makes tissue softer under tips.
const PATCH_WIDTH_MIN_RADII: f32 = 0.8;
/// Least width of the patch under a thin round end, in its radii; at most
/// [`THIN_PATCH_WIDTH_MAX_M`]. If the spheres are as close together as the end is wide, a dent of a
/// few millimetres strains them in a way that the law does not describe. Fitted to a 3 mm tip on
/// the neck of a gallbladder of 2500 spheres. Without this width, the contact was 17 % too stiff.
const THIN_PATCH_WIDTH_MIN_RADII: f32 = 1.3;
/// Largest width that `THIN_PATCH_WIDTH_MIN_RADII` gives a patch, m.
const THIN_PATCH_WIDTH_MAX_M: f32 = 0.004;

/// Widens the patch under a tool point to its least width ([`PATCH_WIDTH_MIN_RADII`],
/// [`THIN_PATCH_WIDTH_MIN_RADII`]).
fn widen_patch(
    point: &ToolPoint,
    mut closest: ClosestPoint,
    (scene, bodies): (&Scene<'_>, &Bodies),
    cache: &mut VertexCache,
) -> ClosestPoint {
    let width_min_m = match point.shape {
        Shape::Ball { radius_m } => (THIN_PATCH_WIDTH_MIN_RADII * radius_m)
            .min(THIN_PATCH_WIDTH_MAX_M)
            .max(PATCH_WIDTH_MIN_RADII * radius_m),
        Shape::Cylinder { radius_m, .. } => PATCH_WIDTH_MIN_RADII * radius_m,
    };
    let missing_m2 = width_min_m * width_min_m - closest.patch_width_m * closest.patch_width_m;
    if missing_m2 > 0.0 {
        closest.spread(math::sqrt(missing_m2), &scene.skin, bodies, cache);
    }
    closest
}

/// Candidate of a tool point on the closest point of an organ's skin.
fn candidate(
    (organ, material): (u8, &Material),
    site: ContactSite,
    point: &ToolPoint,
    closest: ClosestPoint,
    contact: &PersistentContact,
) -> Candidate {
    let modulus_pa = material.young_pa / (1.0 - material.poisson * material.poisson);
    let (patch_width_m, curvature_per_m) = (closest.patch_width_m, closest.curvature_per_m);
    let law = Law::new(point.shape, modulus_pa, patch_width_m, curvature_per_m);
    Candidate {
        organ,
        site,
        normal: contact.push_direction,
        center_m: point.center_m,
        half_m: point.half_m,
        radius_m: point.radius_m,
        at_m: closest.at_m,
        bristle_stiffness_n_m: law
            .tangential_stiffness_n_m(contact.cached.force_n, material.poisson),
        model: ContactModel::HalfSpace(law),
        separation_m: contact.separation.separation_m,
        travel_m: contact.travel_m,
        friction: material.friction,
        cached: contact.cached,
        patch: closest.patch,
    }
}
