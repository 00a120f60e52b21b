//! The instrument against tissue: which spheres its parts touch, how deep, and the push that
//! follows. Organs that have a contact skin meet it there ([`crate::collision::skin`]); of the
//! others the spheres collide.
//!
//! Stage `contact` ([`ToolContacts::find`]) keeps the spheres near the instrument: organs whose
//! box comes near, then their spheres, O(spheres of touched organs · parts). Stage `solve`
//! ([`ToolContacts::push_out`]) measures them again where the tissue has gone meanwhile, and
//! pushes each with the force that the hand feels.

use core::cmp::Ordering;

use heapless::Vec;
use heapless::binary_heap::{BinaryHeap, Min};

use crate::capacity::{MAX_CAPSULES, MAX_CONTACTS, MAX_ORGANS, MAX_SKIN_CONTACTS};
use crate::collision::cylinder::{Touch, touch};
use crate::collision::skin::{SkinContacts, has_skin};
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::scene::Scene;
use crate::soft_body::{Bodies, Bounds};
use crate::state::SphereBits;
use crate::tool::Capsule;

/// How far a sphere may be from the instrument and still be looked at again after the solve, m:
/// what the fastest sphere moves in a tick.
const NEAR_M: f32 = 0.003;
/// The same of spheres that lie under a skin, m: the skin is up to half a spacing above them.
const NEAR_SKIN_M: f32 = 0.010;

/// A sphere near the instrument; ordered by depth, then by index, so that the same ones stay.
#[derive(Debug, Clone, Copy)]
struct Near {
    /// Depth before the solve, of a capsule with round ends, m: quick, and never too small.
    depth_m: f32,
    sphere: u32,
}

impl Ord for Near {
    fn cmp(&self, other: &Self) -> Ordering {
        // A lower index counts as deeper: it was there first.
        let depth = self.depth_m.total_cmp(&other.depth_m);
        depth.then_with(|| other.sphere.cmp(&self.sphere))
    }
}

impl PartialOrd for Near {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Near {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Near {}

/// A sphere that the instrument touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Its organ.
    pub(crate) organ: u8,
    /// Where it touches the instrument, world frame, m.
    pub(crate) at_m: Vec3,
    /// From tissue to tool.
    pub(crate) normal: Vec3,
    /// Force of tissue on tool along the normal, N.
    pub(crate) force_n: f32,
    /// Stiffness of that force, N/m.
    pub(crate) stiffness_n_m: f32,
    /// Friction of tissue on tool, across the normal, N.
    pub(crate) friction_n: Vec3,
    /// Stiffness of the friction while it sticks, N/m.
    pub(crate) friction_stiffness_n_m: f32,
}

impl Contact {
    /// Of tissue on tool, N.
    pub(crate) fn whole_force_n(&self) -> Vec3 {
        self.normal * self.force_n + self.friction_n
    }
}

/// Every sphere that the instrument is near to, and those that it touches.
#[derive(Debug, Default)]
pub(crate) struct ToolContacts {
    near: BinaryHeap<Near, Min, MAX_CONTACTS>,
    skin: SkinContacts,
    /// This tick's contacts; written by [`ToolContacts::push_out`].
    pub(crate) list: Vec<Contact, { MAX_CONTACTS + MAX_SKIN_CONTACTS }>,
}

impl ToolContacts {
    /// The spheres near the instrument.
    pub(crate) fn near_spheres(&self) -> impl Iterator<Item = u32> {
        self.near.iter().map(|near| near.sphere)
    }

    /// How deep the instrument lies in skin, or in spheres without one, m; before the solve.
    pub(crate) fn deepest_m(&self, scene: &Scene<'_>) -> Option<f32> {
        let bare = self.near.iter().filter(|n| !has_skin(scene, n.sphere));
        let depths = bare.map(|near| near.depth_m).chain(self.skin.depths_m());
        depths.filter(|m| *m > 0.0).reduce(f32::max)
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.near.clear();
        self.skin.clear();
        self.list.clear();
    }

    /// Collects the spheres near `parts`, as they lie before the solve. When there are more than
    /// [`MAX_CONTACTS`] the deepest stay.
    pub(crate) fn find(
        &mut self,
        parts: &[Capsule],
        scene: &Scene<'_>,
        bounds: &[Bounds; MAX_ORGANS],
        bodies: &Bodies,
        faults: &mut FaultSet,
    ) {
        self.near.clear();
        self.list.clear();
        for (organ, organ_box) in scene.organs.iter().zip(bounds) {
            let under_skin = has_skin(scene, organ.sphere_start);
            let margin_m = if under_skin { NEAR_SKIN_M } else { NEAR_M };
            let mut parts_near: Vec<Segment, MAX_CAPSULES> = Vec::new();
            for part in parts
                .iter()
                .filter(|part| part_box(part).is_near(organ_box, margin_m))
            {
                let _ = parts_near.push(Segment::new(part)); // as many as `parts` at most
            }
            if parts_near.is_empty() {
                continue;
            }
            let first = organ.sphere_start;
            let nodes = bodies.nodes.range(first, organ.sphere_count).iter();
            let radii = bodies.radius_m.range(first, organ.sphere_count);
            for (sphere, (node, &radius_m)) in (first..).zip(nodes.zip(radii)) {
                let center_m = node.center_m();
                let depth = |part: &Segment| part.depth_m(&center_m, radius_m, margin_m);
                let deepest = parts_near.iter().filter_map(depth).fold(f32::MIN, f32::max);
                let held = bodies.bits.at(sphere).contains(SphereBits::GRASPED);
                if deepest > -margin_m && (under_skin || !held) {
                    self.keep(
                        Near {
                            depth_m: deepest,
                            sphere,
                        },
                        faults,
                    );
                }
            }
        }
        let near = self.near.iter().map(|near| near.sphere);
        self.skin.find(parts, &near, scene, bodies, faults);
    }

    fn keep(&mut self, near: Near, faults: &mut FaultSet) {
        let Err(near) = self.near.push(near) else {
            return;
        };
        let Some(mut shallowest) = self.near.peek_mut() else {
            return;
        };
        let lost = if near > *shallowest {
            core::mem::replace(&mut *shallowest, near)
        } else {
            near
        };
        faults.raise_if(lost.depth_m > 0.0, Fault::ContactOverflow);
    }

    /// Pushes the spheres of organ `organ` that overlap `parts`, within a substep of `step_s`.
    pub(crate) fn push_organ(
        &mut self,
        organ: u8,
        parts: &[Capsule],
        scene: &Scene<'_>,
        step_s: f32,
        bodies: &mut Bodies,
    ) {
        for near in &self.near {
            if *bodies.organ.at(near.sphere) == organ && !has_skin(scene, near.sphere) {
                push(near.sphere, parts, scene, step_s, bodies);
            }
        }
        self.skin.press(organ, step_s, bodies);
    }

    /// Pushes every sphere that overlaps `parts`, in its organ's last substep, and lists what they
    /// do to them.
    pub(crate) fn push_out(&mut self, parts: &[Capsule], scene: &Scene<'_>, bodies: &mut Bodies) {
        self.list.clear();
        for (organ, _) in (0u8..).zip(scene.organs) {
            self.skin.press(organ, scene.step_s_of(organ), bodies);
        }
        let list = &mut self.list;
        self.skin.list(bodies, |contact| {
            let _ = list.push(contact); // holds as many as there can be
        });
        for near in &self.near {
            if has_skin(scene, near.sphere) {
                continue;
            }
            let organ = *bodies.organ.at(near.sphere);
            let step_s = scene.step_s_of(organ);
            let Some((touch, force_n)) = push(near.sphere, parts, scene, step_s, bodies) else {
                continue;
            };
            let radius_m = *bodies.radius_m.at(near.sphere);
            let at_m = bodies.nodes.at(near.sphere).center_m() + touch.normal * radius_m;
            let contact = Contact {
                organ,
                at_m,
                normal: touch.normal,
                force_n,
                stiffness_n_m: felt_stiffness_n_m(near.sphere, scene, bodies),
                friction_n: Vec3::zeros(),
                friction_stiffness_n_m: 0.0,
            };
            let _ = self.list.push(contact); // holds as many as there can be
            let bits = bodies.bits.at_mut(near.sphere);
            *bits = bits.with(SphereBits::CONTACT);
        }
    }
}

/// One contact as a spring that only pushes (XPBD, Macklin 2016): the multiplier is the force, and
/// what it does to the tissue is what the hand feels. The spring stands for the dent in the tissue
/// between skin and sphere, which spheres are too coarse to make. Immovable spheres only push.
fn push(
    sphere: u32,
    parts: &[Capsule],
    scene: &Scene<'_>,
    step_s: f32,
    bodies: &mut Bodies,
) -> Option<(Touch, f32)> {
    let radius_m = *bodies.radius_m.at(sphere);
    let stiffness_n_m = scene
        .material_of(*bodies.organ.at(sphere))
        .contact_stiffness_n_m;
    let node = bodies.nodes.at_mut(sphere);
    let touch = overlap(&node.center_m(), radius_m, parts)?;
    let yielding_m_n = node.inverse_mass_per_kg() * step_s * step_s;
    // k d / (1 + k w dt²): nothing is pushed where nothing is stiff.
    let force_n = stiffness_n_m * touch.depth_m / (1.0 + stiffness_n_m * yielding_m_n);
    node.move_by(&(touch.normal * (-force_n * yielding_m_n)));
    Some((touch, force_n))
}

/// Stiffness of a contact as a slow hand meets it: the contact's own spring, and behind it the
/// tissue that a free sphere lies in, as a half-space under it (`2 E r / (1 − ν²)`).
fn felt_stiffness_n_m(sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
    let material = scene.material_of(*bodies.organ.at(sphere));
    let own = material.contact_stiffness_n_m;
    if bodies.nodes.at(sphere).inverse_mass_per_kg() <= 0.0 {
        return own;
    }
    let modulus_pa = material.young_pa / (1.0 - material.poisson * material.poisson);
    let behind = 2.0 * modulus_pa * *bodies.radius_m.at(sphere);
    own * behind / (own + behind).max(f32::MIN_POSITIVE)
}

/// The overlap of a sphere with all parts as one: `Σ d² n / Σ d`. Alone, a part counts as it is; two
/// that overlap at a joint count once; a sphere between two blades is pushed by both. It changes
/// as little as the depths do: no step in the force when another part becomes the deepest.
fn overlap(center_m: &Vec3, radius_m: f32, parts: &[Capsule]) -> Option<Touch> {
    let (mut sum_m, mut weighted_m2, mut any) = (0.0, Vec3::zeros(), None);
    for part in parts {
        let touch = touch(center_m, radius_m, part);
        if touch.depth_m > 0.0 {
            sum_m += touch.depth_m;
            weighted_m2 += touch.normal * (touch.depth_m * touch.depth_m);
            any = Some(touch.normal);
        }
    }
    let any = any?;
    let overlap_m = weighted_m2 / sum_m;
    Some(Touch {
        depth_m: math::norm(&overlap_m),
        normal: math::unit(&overlap_m).unwrap_or(any),
    })
}

fn part_box(part: &Capsule) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    bounds.add(&part.a_m, part.radius_m);
    bounds.add(&part.b_m, part.radius_m);
    bounds
}

/// A part with round ends, prepared for many spheres. It holds the flat-ended cylinder.
#[derive(Debug, Clone, Copy)]
struct Segment {
    a_m: Vec3,
    along_m: Vec3,
    inverse_length_squared: f32,
    radius_m: f32,
}

impl Segment {
    fn new(part: &Capsule) -> Self {
        let along_m = part.b_m - part.a_m;
        let inverse_length_squared = along_m.norm_squared().max(1.0e-12).recip();
        Self {
            a_m: part.a_m,
            along_m,
            inverse_length_squared,
            radius_m: part.radius_m,
        }
    }

    /// How deep a sphere overlaps it, or `None` if it is not even near.
    #[inline]
    fn depth_m(&self, center_m: &Vec3, radius_m: f32, margin_m: f32) -> Option<f32> {
        let from_a = center_m - self.a_m;
        let t = (from_a.dot(&self.along_m) * self.inverse_length_squared).clamp(0.0, 1.0);
        let squared = (from_a - self.along_m * t).norm_squared();
        let reach = radius_m + self.radius_m;
        let near = reach + margin_m;
        (squared < near * near).then(|| reach - math::sqrt(squared))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::{organ, room, sphere};
    use crate::tool::Role;
    use std::boxed::Box;

    /// A bar that stands on z, its lower end at `z`.
    fn bar(z: f32) -> Capsule {
        Capsule {
            a_m: Vec3::new(0.0, 0.0, z + 0.1),
            b_m: Vec3::new(0.0, 0.0, z),
            radius_m: 0.002,
            role: Role::Shaft,
        }
    }

    fn meet(parts: &[Capsule], held: bool) -> (ToolContacts, Box<Bodies>) {
        let mut ball = sphere(Vec3::zeros(), 0.01);
        ball.held = held;
        let (organs, spheres) = ([organ(0, 1, 0, 0)], [ball]);
        let scene = Scene::new(&organs, &spheres, &[], room()).unwrap();
        let mut bodies = Box::new(Bodies::new());
        bodies.load(&scene);
        let bounds = [bodies.bounds(&organs[0]); MAX_ORGANS];
        let (mut contacts, mut faults) = (ToolContacts::default(), FaultSet::NONE);
        contacts.find(parts, &scene, &bounds, &bodies, &mut faults);
        contacts.push_out(parts, &scene, &mut bodies);
        (contacts, bodies)
    }

    #[test]
    fn the_same_force_on_both_by_hand() {
        // The end stands 8 mm over the middle of a 10 mm sphere: 2 mm deep, 500 N/m; the sphere
        // of 2 g yields 1/500 N/m · 1/4 in a tick: 1 N / 1.25.
        let (contacts, bodies) = meet(&[bar(0.008)], false);
        let [contact] = contacts.list[..] else {
            panic!("{:?}", contacts.list)
        };
        assert!((contact.force_n - 0.8).abs() < 1.0e-4, "{contact:?}");
        assert!(math::norm(&(contact.normal - Vec3::z())) < 1.0e-5);
        assert!(
            math::norm(&(contact.at_m - Vec3::z() * 0.0096)) < 1.0e-6,
            "{contact:?}"
        );
        // The tissue goes the other way: F w dt².
        let moved = bodies.nodes.at(0).moved_m();
        assert!(
            math::norm(&(moved + Vec3::z() * 0.0004)) < 1.0e-7,
            "{moved}"
        );
        assert!(bodies.bits.at(0).contains(SphereBits::CONTACT));
    }

    #[test]
    fn what_is_held_stays_and_pushes_all_the_same() {
        let (contacts, bodies) = meet(&[bar(0.008)], true);
        assert!((contacts.list[0].force_n - 1.0).abs() < 1.0e-4);
        assert!(math::norm(&bodies.nodes.at(0).moved_m()) < f32::EPSILON);
    }

    #[test]
    fn near_is_no_contact_and_parts_count_once() {
        let (contacts, _) = meet(&[bar(0.011)], false);
        assert!(contacts.near.len() == 1 && contacts.list.is_empty());
        assert!(meet(&[bar(0.05)], false).0.near.is_empty());
        let (contacts, _) = meet(&[bar(0.007), bar(0.007), bar(0.007)], false);
        assert_eq!(contacts.list.len(), 1);
        assert!((contacts.list[0].force_n - 1.2).abs() < 1.0e-4);
    }
}
