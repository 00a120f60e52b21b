//! Contact of the tools with all organs: organs with a contact skin ([`crate::contact::skin`]), and
//! ducts and vessels ([`crate::contact::tube`]).
//!
//! Stage `contact` ([`ToolContacts::find`]) lists the spheres of skins near the tools: it finds
//! organs whose box is near a tool, then their spheres, O(spheres of organs near · parts). Skins
//! and tubes then give candidates. Stage `solve` removes the overlaps after each substep of the
//! tissue ([`crate::contact::constraint`]); after the last substep, [`ToolContacts::push_out`]
//! removes them and lists the forces.

use core::cmp::Ordering;

use heapless::Vec;
use heapless::binary_heap::{BinaryHeap, Min};

use crate::capacity::{MAX_CAPSULES, MAX_CONTACT_CONSTRAINTS, MAX_CONTACTS, MAX_ORGANS};
use crate::contact::constraint::{ContactConstraints, ContactSite};
use crate::contact::contact_force::ContactForce;
use crate::contact::dent::Dent;
use crate::contact::part_box::part_box;
use crate::contact::rigid::RigidContacts;
use crate::contact::skin::SkinContacts;
use crate::contact::tube::TubeContacts;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::scene::Scene;
use crate::tissue::lanes::Lanes;
use crate::tissue::substeps::Coupling;
use crate::tissue::{Bodies, Bounds};
use crate::tool::Capsule;
use crate::words::SphereBits;

/// Distance from a tool within which a sphere under a skin is kept, m: the skin lies up to half a
/// spacing above the sphere.
const NEAR_SKIN_M: f32 = 0.010;

/// A sphere near a tool, ordered by depth, then by index, so that every run keeps the same spheres.
#[derive(Debug, Clone, Copy)]
struct SphereByDepth {
    /// Overlap of the sphere with the tool's capsules before the solve, m. A capsule contains the
    /// part, so this is an upper bound.
    depth_m: f32,
    sphere: u32,
}

impl Ord for SphereByDepth {
    fn cmp(&self, other: &Self) -> Ordering {
        // At equal depth, the lower index counts as deeper, because it was found first.
        let depth = self.depth_m.total_cmp(&other.depth_m);
        depth.then_with(|| other.sphere.cmp(&self.sphere))
    }
}

impl PartialOrd for SphereByDepth {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for SphereByDepth {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for SphereByDepth {}

/// Tissue near the tools, and the contacts with it.
#[derive(Debug, Clone, Default)]
pub(crate) struct ToolContacts {
    /// Spheres under a skin that are near a tool.
    near: BinaryHeap<SphereByDepth, Min, MAX_CONTACTS>,
    skin: SkinContacts,
    tubes: TubeContacts,
    constraints: ContactConstraints,
    rigid: RigidContacts,
    /// Forces of this tick's contacts; written by [`ToolContacts::push_out`].
    pub(crate) forces: Vec<ContactForce, { MAX_CONTACT_CONSTRAINTS + MAX_CAPSULES }>,
}

impl ToolContacts {
    /// Spheres near the tools.
    pub(crate) fn near_spheres(&self, bodies: &Bodies) -> impl Iterator<Item = u32> {
        let under_skin = self.near.iter().map(|near| near.sphere);
        under_skin.chain(self.tubes.near_spheres(bodies))
    }

    /// The sphere that overlaps these parts of a tool most, and the overlap, m.
    pub(crate) fn deepest_overlap(&self, parts: &[Capsule], bodies: &Bodies) -> Option<(u32, f32)> {
        let overlaps = parts.iter().flat_map(|part| {
            let segment = Segment::new(part, &Bounds::EMPTY);
            self.near_spheres(bodies).filter_map(move |sphere| {
                let center_m = bodies.nodes.at(sphere).center().vec3();
                let radius_m = *bodies.radius_m.at(sphere);
                let depth_m = segment.depth_m(&center_m, radius_m, 0.0)?;
                Some((sphere, depth_m))
            })
        });
        overlaps.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The dents of the tools in the tissue, after the solve.
    pub(crate) fn dents(&self, bodies: &Bodies) -> impl Iterator<Item = Dent> {
        self.constraints.dents(bodies)
    }

    /// Depth of the tools in tissue at the deepest place, before the solve, m; `None` without
    /// contact.
    pub(crate) fn deepest_m(&self) -> Option<f32> {
        let depths = self
            .constraints
            .iter()
            .map(|constraint| -constraint.separation_m);
        depths.filter(|m| *m > 0.0).reduce(f32::max)
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.near.clear();
        self.skin.clear();
        self.tubes.clear();
        self.constraints.clear();
        self.rigid.clear();
        self.forces.clear();
    }

    /// Finds the tissue near `parts`, before the solve. When there is no room, the shallowest is
    /// dropped.
    pub(crate) fn find(
        &mut self,
        parts: &[Capsule],
        scene: &Scene<'_>,
        bounds: &[Bounds; MAX_ORGANS],
        bodies: &Bodies,
        faults: &mut FaultSet,
    ) {
        self.near.clear();
        self.constraints.clear();
        self.forces.clear();
        for (organ, organ_box) in scene.organs.iter().zip(bounds) {
            if scene.skin.near_sphere(organ.sphere_start).is_none() {
                continue;
            }
            let mut parts_near: Vec<Segment, MAX_CAPSULES> = Vec::new();
            for part in parts
                .iter()
                .filter(|part| part_box(part).is_near(organ_box, NEAR_SKIN_M))
            {
                let _ = parts_near.push(Segment::new(part, organ_box)); // room for all parts
            }
            if parts_near.is_empty() {
                continue;
            }
            let first = organ.sphere_start;
            let nodes = bodies.nodes.range(first, organ.sphere_count).iter();
            let radii = bodies.radius_m.range(first, organ.sphere_count);
            for (sphere, (node, &radius_m)) in (first..).zip(nodes.zip(radii)) {
                let center = node.center();
                let near = |part: &&Segment| part.may_be_near(center, radius_m);
                let depth = |part: &Segment| part.depth_m(&center.vec3(), radius_m, NEAR_SKIN_M);
                let near = parts_near.iter().filter(near);
                let deepest = near.filter_map(depth).fold(f32::MIN, f32::max);
                if deepest > -NEAR_SKIN_M {
                    self.keep(
                        SphereByDepth {
                            depth_m: deepest,
                            sphere,
                        },
                        faults,
                    );
                }
            }
        }
        let near = self.near.iter().map(|near| near.sphere);
        let constraints = &mut self.constraints;
        self.skin
            .find(parts, &near, scene, bodies, constraints, faults);
        self.tubes
            .find(parts, scene, bounds, bodies, constraints, faults);
        let forces = &mut self.forces;
        self.rigid.find(parts, |contact| {
            let _ = forces.push(contact); // room for one contact of each part
        });
    }

    fn keep(&mut self, near: SphereByDepth, faults: &mut FaultSet) {
        let Err(near) = self.near.push(near) else {
            return;
        };
        let Some(mut shallowest) = self.near.peek_mut() else {
            return;
        };
        if near > *shallowest {
            *shallowest = near;
        }
        // The skin over the dropped sphere may touch a tool.
        faults.raise(Fault::ContactOverflow);
    }

    /// Solves every organ's constraints in its last substep, and lists the contact forces.
    pub(crate) fn push_out(&mut self, scene: &Scene<'_>, bodies: &mut Bodies) {
        for (organ, _) in (0u8..).zip(scene.organs) {
            self.constraints
                .solve(organ, scene.step_s_of(organ), bodies);
        }
        self.forces.retain(|contact| contact.organ.is_none()); // found anew below
        for constraint in self.constraints.iter() {
            match constraint.site {
                ContactSite::Skin { point } => {
                    self.skin
                        .store(constraint.organ, point, constraint.cached());
                }
                ContactSite::Tube { bead, part } => {
                    self.tubes.store(bead, part, constraint.cached());
                }
            }
            if constraint.mean_force_n <= 0.0 {
                continue;
            }
            for (sphere, _) in constraint.patch.spheres() {
                let bits = bodies.bits.at_mut(sphere);
                *bits = bits.with(SphereBits::CONTACT);
            }
            let _ = self.forces.push(ContactForce {
                tool: constraint.site.tool(),
                organ: Some(constraint.organ),
                at_m: constraint.at_m,
                normal: constraint.normal,
                force_n: constraint.mean_force_n,
                stiffness_n_m: constraint.stiffness_n_m,
                friction_n: constraint.mean_friction_n,
                friction_stiffness_n_m: constraint.friction_stiffness_n_m,
            }); // room for all constraints
        }
    }
}

impl Coupling for ToolContacts {
    fn pre_solve(&mut self, organ: u8, step_s: f32, bodies: &mut Bodies) {
        self.constraints.warm_start(organ, step_s, bodies);
    }

    fn post_solve(&mut self, organ: u8, _: f32, step_s: f32, bodies: &mut Bodies) {
        self.constraints.solve(organ, step_s, bodies);
    }
}

/// The capsule of a part, prepared for tests against many spheres. It contains the cylinder with
/// flat ends.
#[derive(Debug, Clone, Copy)]
struct Segment {
    a_m: Vec3,
    along_m: Vec3,
    inverse_length_squared: f32,
    radius_m: f32,
    /// Middle of the box around the piece of the axis that is near the organ's box, m.
    middle_m: Lanes,
    /// Half of the sides of this box, m. The box is larger than the piece by the radius and
    /// [`NEAR_SKIN_M`].
    half_m: Lanes,
}

impl Segment {
    /// Prepares a part for the spheres of an organ in this box.
    fn new(part: &Capsule, organ_box: &Bounds) -> Self {
        let along_m = part.b_m - part.a_m;
        let reach_m = part.radius_m + NEAR_SKIN_M;
        let within = organ_box.within(&part.a_m, &part.b_m, reach_m);
        let inverse_length_squared = along_m.norm_squared().max(1.0e-12).recip();
        Self {
            a_m: part.a_m,
            along_m,
            inverse_length_squared,
            radius_m: part.radius_m,
            middle_m: Lanes::new(&((within.low_m + within.high_m) * 0.5), 0.0),
            half_m: Lanes::new(&((within.high_m - within.low_m) * 0.5), f32::MAX),
        }
    }

    /// True if a sphere meets the box around the piece. False only for spheres whose
    /// [`Segment::depth_m`] is `None`.
    #[inline(always)]
    fn may_be_near(&self, center: Lanes, radius_m: f32) -> bool {
        let [x, y, z, _] = (center - self.middle_m).to_array();
        let [a, b, c, _] = (self.half_m + Lanes::splat(radius_m)).to_array();
        x.abs() <= a && y.abs() <= b && z.abs() <= c
    }

    /// Overlap of a sphere with the capsule, m; negative: the gap. `None` if the gap is wider than
    /// `margin_m`.
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
    use crate::testing::vector;
    use crate::tool::Role;
    use proptest::prelude::*;
    use std::boxed::Box;

    /// A bar along the z axis, with its lower end at `z`.
    fn bar(z: f32) -> Capsule {
        Capsule {
            a_m: Vec3::new(0.0, 0.0, z + 0.1),
            b_m: Vec3::new(0.0, 0.0, z),
            radius_m: 0.002,
            role: Role::Shaft,
        }
    }

    /// A bar that comes down on a ball of 10 mm radius in one tick, from 4 mm above `z` to `z`.
    fn meet(z: f32, held: bool) -> (ToolContacts, Box<Bodies>) {
        let mut ball = sphere(Vec3::zeros(), 0.01);
        ball.held = held;
        let (organs, spheres) = ([organ(0, 1, 0, 0)], [ball]);
        let scene = Scene::new(&organs, &spheres, &[], room()).unwrap();
        let mut bodies = Box::new(Bodies::new());
        bodies.load(&scene);
        let bounds = [bodies.bounds(&organs[0]); MAX_ORGANS];
        let (mut contacts, mut faults) = (ToolContacts::default(), FaultSet::NONE);
        for z in [z + 0.004, z] {
            contacts.find(&[bar(z)], &scene, &bounds, &bodies, &mut faults);
            contacts.push_out(&scene, &mut bodies);
        }
        (contacts, bodies)
    }

    #[test]
    fn contact_force_acts_on_tool_and_tissue_alike() {
        // The round end of 2 mm radius is 2 mm deep in a 10 mm sphere. Of these 2 mm, the sphere of
        // 2 g yields 0.5 mm/N in a tick; the wall of 500 N/m, flat at 16 mm, yields the rest.
        let (contacts, bodies) = meet(0.010, false);
        let [contact] = contacts.forces[..] else {
            panic!("{:?}", contacts.forces)
        };
        let force_n = contact.force_n;
        let wall_m = 0.002 - 0.000_5 * force_n;
        let wall_n = 500.0 * wall_m * (1.0 + wall_m / 0.016);
        assert!(
            (force_n - wall_n).abs() < 1.0e-4 && force_n > 0.8,
            "{contact:?}"
        );
        assert!(math::norm(&(contact.normal - Vec3::z())) < 1.0e-5);
        assert!(
            math::norm(&(contact.at_m - Vec3::z() * 0.008)) < 1.0e-6,
            "{contact:?}"
        );
        // The tissue moves the other way, by F w dt².
        let moved = bodies.nodes.at(0).moved_m();
        assert!(
            math::norm(&(moved + Vec3::z() * (0.000_5 * force_n))) < 1.0e-7,
            "{moved}"
        );
        assert!(bodies.bits.at(0).contains(SphereBits::CONTACT));
        // The display draws the overlap that is left after the sphere has yielded.
        let dents: std::vec::Vec<Dent> = contacts.dents(&bodies).collect();
        let [dent] = dents[..] else {
            panic!("{dents:?}")
        };
        assert!((dent.depth_m - wall_m).abs() < 1.0e-6, "{dent:?}");
        assert!(dent.normal == contact.normal && dent.organ == 0, "{dent:?}");
        assert!(math::norm(&(dent.center_m - Vec3::z() * 0.010)) < 1.0e-6);
    }

    #[test]
    fn fixed_sphere_stays_and_pushes() {
        let (contacts, bodies) = meet(0.010, true);
        let wall_n = 500.0 * 0.002 * (1.0 + 0.002 / 0.016);
        let force_n = contacts.forces[0].force_n;
        assert!((force_n / wall_n - 1.0).abs() < 0.01, "{force_n}");
        assert!(math::norm(&bodies.nodes.at(0).moved_m()) < f32::EPSILON);
    }

    #[test]
    fn near_sphere_without_overlap_has_no_force() {
        let (contacts, bodies) = meet(0.013, false);
        assert!(contacts.near_spheres(&bodies).count() > 0 && contacts.forces.is_empty());
        let (contacts, bodies) = meet(0.05, false);
        assert_eq!(contacts.near_spheres(&bodies).count(), 0);
    }

    proptest! {
        /// The box around a part excludes no sphere of the organ that is near the part.
        #[test]
        fn box_excludes_no_near_sphere(
            a_m in vector(0.2), b_m in vector(0.2), low_m in vector(0.1), size_m in vector(0.1),
            at in (0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0), radius_m in 0.001f32..0.015,
        ) {
            let size_m = size_m.abs() + Vec3::repeat(2.0 * radius_m);
            let organ_box = Bounds { low_m, high_m: low_m + size_m };
            let part = Capsule { a_m, b_m, radius_m: 0.0025, role: Role::Shaft };
            let inner_m = size_m - Vec3::repeat(2.0 * radius_m);
            let share = Vec3::new(at.0, at.1, at.2);
            let center_m = low_m + Vec3::repeat(radius_m) + inner_m.component_mul(&share);
            let segment = Segment::new(&part, &organ_box);
            // A tenth of a micrometre allows for rounding.
            if segment.depth_m(&center_m, radius_m, NEAR_SKIN_M - 1.0e-7).is_some() {
                prop_assert!(segment.may_be_near(Lanes::new(&center_m, 0.0), radius_m));
            }
        }
    }
}
