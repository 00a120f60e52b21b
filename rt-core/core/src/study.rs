//! Tissue without instrument or devices: for studies, tests and preparation.

use crate::capacity::MAX_ORGANS;
use crate::contact::contact_force::ContactForce;
use crate::contact::tool_contact::ToolContacts;
use crate::fault::FaultSet;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::tissue::substeps::{self, Coupling};
use crate::tissue::{Bodies, Bounds, Method, damage, inverse_mass_per_kg};
use crate::tool::Capsule;

/// Organs of a scene, stepped as in the tick, each in its substeps.
#[derive(Debug)]
pub struct Tissue<'a> {
    scene: Scene<'a>,
    bodies: &'a mut Bodies,
    method: Method<'a>,
    contacts: ToolContacts,
    tick: u64,
}

/// Every organ moves.
const ALL_MOVE: [bool; MAX_ORGANS] = [true; MAX_ORGANS];

/// Force and contacts of a tool in one tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pressed {
    /// Force of the tissue on the tool, world frame, N.
    pub force_n: Vec3,
    /// Torque of the tissue on the tool about the world's origin, N m.
    moment_nm: Vec3,
    /// Number of contact places.
    pub contacts: usize,
    /// Number of spheres that were not finite or had diverged, and were put back to their last
    /// place.
    pub quarantined: u32,
}

impl Pressed {
    /// Torque of the tissue on the tool about a point, world frame, N m. In the full simulation,
    /// the torque about the port reaches the hand through the lever.
    #[must_use]
    pub fn torque_nm(&self, about_m: &Vec3) -> Vec3 {
        self.moment_nm - about_m.cross(&self.force_n)
    }
}

impl<'a> Tissue<'a> {
    /// Puts `scene` at rest into `bodies`.
    #[must_use]
    pub fn new(scene: Scene<'a>, bodies: &'a mut Bodies, method: Method<'a>) -> Self {
        bodies.load(&scene);
        Self {
            scene,
            bodies,
            method,
            contacts: ToolContacts::default(),
            tick: 0,
        }
    }

    /// Holds a sphere in place, or releases it. [`Tissue::lead`] moves a held sphere.
    pub fn hold(&mut self, sphere: u32, held: bool) {
        let Some(rest) = self.scene.spheres.get(sphere as usize) else {
            return;
        };
        let node = self.bodies.nodes.at_mut(sphere);
        let free = (rest.mass_kg).recip();
        node.set_inverse_mass_per_kg(if held { 0.0 } else { free });
        let moved_m = node.moved_m();
        node.put(&moved_m, &Vec3::zeros());
        let Bodies {
            nodes,
            organ: organs,
            warm_start,
            ..
        } = &mut *self.bodies;
        if let Some(organ) = self.scene.organs.get(usize::from(*organs.at(sphere))) {
            warm_start.set_masses(&self.scene, organ, nodes);
        }
    }

    /// Leads a held sphere to this displacement from rest within the next tick, m.
    pub fn lead(&mut self, sphere: u32, displacement_m: &Vec3) {
        if self.bodies.nodes.at(sphere).inverse_mass_per_kg() <= 0.0 {
            self.bodies.lead(sphere, displacement_m);
        }
    }

    /// Sets a sphere's displacement from rest, m, and its velocity, m/s.
    pub fn put(&mut self, sphere: u32, displacement_m: &Vec3, velocity_m_s: &Vec3) {
        self.bodies
            .nodes
            .at_mut(sphere)
            .put(displacement_m, velocity_m_s);
    }

    /// Puts everything back to rest, held as in the scene.
    pub fn rest(&mut self) {
        self.bodies.reset(&self.scene);
        self.contacts.clear();
        self.tick = 0;
    }

    /// Advances one tick. Returns the number of spheres that were put back.
    pub fn step(&mut self) -> u32 {
        self.step_with(|_, _| ())
    }

    /// Advances one tick. `correct` is called after the constraints of every organ's substep, with
    /// the substep's length, s. `correct` may move spheres, as a contact does.
    pub fn step_with(&mut self, correct: impl FnMut(&mut Correction<'_>, f32)) -> u32 {
        self.step_between(|_, _| (), correct)
    }

    /// Advances one tick as [`Tissue::step_with`]. `warm_start` is called before the constraints of
    /// every organ's substep. At this point, a contact of the full simulation applies a share of
    /// its last force.
    pub fn step_between(
        &mut self,
        warm_start: impl FnMut(&mut Correction<'_>, f32),
        correct: impl FnMut(&mut Correction<'_>, f32),
    ) -> u32 {
        let mut hooks = SubstepHooks {
            warm_start,
            correct,
        };
        self.bodies.begin(&self.scene, true);
        self.breathe();
        let (scene, bodies) = (&self.scene, &mut *self.bodies);
        let method = &mut self.method;
        let mut quarantined = substeps::run(scene, method, &ALL_MOVE, &mut hooks, bodies);
        for (i, _) in (0u8..).zip(scene.organs) {
            hooks.post_solve(i, 1.0, scene.step_s_of(i), bodies);
        }
        quarantined += self.end();
        quarantined
    }

    /// Advances one tick with these parts of a tool against the tissue, as in the full simulation.
    pub fn press(&mut self, parts: &[Capsule]) -> Pressed {
        self.bodies.begin(&self.scene, true);
        self.breathe();
        let (scene, bodies, contacts) = (&self.scene, &mut *self.bodies, &mut self.contacts);
        let mut bounds = [Bounds::EMPTY; MAX_ORGANS];
        for (organ, bounds) in scene.organs.iter().zip(&mut bounds) {
            *bounds = bodies.bounds(organ);
        }
        let mut faults = FaultSet::NONE; // not reported; an overflow lowers the force
        contacts.find(parts, scene, &bounds, bodies, &mut faults);
        let mut quarantined = substeps::run(scene, &mut self.method, &ALL_MOVE, contacts, bodies);
        contacts.push_out(scene, bodies);
        quarantined += self.end();
        let forces = &self.contacts.forces;
        Pressed {
            force_n: forces.iter().map(ContactForce::whole_force_n).sum(),
            moment_nm: (forces.iter())
                .map(|force| force.at_m.cross(&force.whole_force_n()))
                .sum(),
            contacts: forces.len(),
            quarantined,
        }
    }

    fn breathe(&mut self) {
        for organ in self.scene.organs {
            self.bodies.breathe(&self.scene, organ, self.tick);
        }
    }

    /// Ends the last substep of every organ, and the tick. Returns the number of spheres that were
    /// put back.
    fn end(&mut self) -> u32 {
        let (scene, bodies) = (self.scene, &mut *self.bodies);
        let mut quarantined = 0;
        for (i, organ) in (0u8..).zip(scene.organs) {
            quarantined += bodies.advance(&scene, organ, scene.step_s_of(i));
            bodies.stop_leading(organ);
        }
        damage::tear_all(&scene, bodies, |_| ());
        self.tick = self.tick.wrapping_add(1);
        quarantined
    }

    /// Deepest penetration of these parts of a tool into the tissue, m, as stage `contact` finds
    /// it; `None` without contact. Moves nothing.
    pub fn meet(&mut self, parts: &[Capsule]) -> Option<f32> {
        let (scene, bodies) = (self.scene, &*self.bodies);
        let mut bounds = [Bounds::EMPTY; MAX_ORGANS];
        for (organ, bounds) in scene.organs.iter().zip(&mut bounds) {
            *bounds = bodies.bounds(organ);
        }
        let mut faults = FaultSet::NONE;
        self.contacts
            .find(parts, &scene, &bounds, bodies, &mut faults);
        self.contacts.deepest_m()
    }

    /// Displacement of a sphere from rest, m.
    #[must_use]
    pub fn displacement_m(&self, sphere: u32) -> Vec3 {
        self.bodies.nodes.at(sphere).moved_m()
    }

    /// Velocity of a sphere, m/s.
    #[must_use]
    pub fn velocity_m_s(&self, sphere: u32) -> Vec3 {
        self.bodies.nodes.at(sphere).velocity_m_s()
    }

    /// True if the scene itself holds the sphere.
    #[must_use]
    pub fn is_held(&self, sphere: u32) -> bool {
        let rest = self.scene.spheres.get(sphere as usize);
        rest.is_some_and(|rest| inverse_mass_per_kg(rest) <= 0.0)
    }
}

/// Callbacks in every substep: before and after the constraints.
struct SubstepHooks<W, F> {
    warm_start: W,
    correct: F,
}

impl<W, F> Coupling for SubstepHooks<W, F>
where
    W: FnMut(&mut Correction<'_>, f32),
    F: FnMut(&mut Correction<'_>, f32),
{
    fn pre_solve(&mut self, _: u8, step_s: f32, bodies: &mut Bodies) {
        (self.warm_start)(&mut Correction { bodies }, step_s);
    }

    fn post_solve(&mut self, _: u8, _: f32, step_s: f32, bodies: &mut Bodies) {
        (self.correct)(&mut Correction { bodies }, step_s);
    }
}

/// Access to the tissue within a substep.
#[derive(Debug)]
pub struct Correction<'a> {
    bodies: &'a mut Bodies,
}

impl Correction<'_> {
    /// Predicted centre of a sphere, m.
    #[must_use]
    pub fn center_m(&self, sphere: u32) -> Vec3 {
        self.bodies.nodes.at(sphere).center_m()
    }

    /// Inverse mass, 1/kg; 0 if the sphere is held.
    #[must_use]
    pub fn inverse_mass_per_kg(&self, sphere: u32) -> f32 {
        self.bodies.nodes.at(sphere).inverse_mass_per_kg()
    }

    /// Adds `step_m` to its displacement, m.
    pub fn move_by(&mut self, sphere: u32, step_m: &Vec3) {
        self.bodies.nodes.at_mut(sphere).move_by(step_m);
    }
}
