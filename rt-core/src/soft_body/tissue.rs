//! Tissue alone, without instrument or devices: for studies, tests and preparation.

use crate::math::Vec3;
use crate::scene::Scene;
use crate::sim::TICK_S;
use crate::soft_body::{Bodies, Method, Solver, attachment, inverse_mass_per_kg};

/// A scene's organs, stepped as the tick steps them, each in its substeps.
#[derive(Debug)]
pub struct Tissue<'a> {
    scene: Scene<'a>,
    bodies: &'a mut Bodies,
    method: Method,
    tick: u64,
}

impl<'a> Tissue<'a> {
    /// Puts `scene` at rest into `bodies`.
    #[must_use]
    pub fn new(scene: Scene<'a>, bodies: &'a mut Bodies, method: Method) -> Self {
        bodies.load(&scene);
        Self {
            scene,
            bodies,
            method,
            tick: 0,
        }
    }

    /// Holds a sphere where it is, or lets it go. It is led by [`Tissue::lead`].
    pub fn hold(&mut self, sphere: u32, held: bool) {
        let Some(rest) = self.scene.spheres.get(sphere as usize) else {
            return;
        };
        let node = self.bodies.nodes.at_mut(sphere);
        let free = (rest.mass_kg).recip();
        node.set_inverse_mass_per_kg(if held { 0.0 } else { free });
        let moved_m = node.moved_m();
        node.put(&moved_m, &Vec3::zeros());
    }

    /// Leads a held sphere to this displacement from rest within the next tick, m.
    pub fn lead(&mut self, sphere: u32, displacement_m: &Vec3) {
        if self.bodies.nodes.at(sphere).inverse_mass_per_kg() <= 0.0 {
            self.bodies.lead(sphere, displacement_m);
        }
    }

    /// Puts a sphere to this displacement from rest, m, with this velocity, m/s.
    pub fn put(&mut self, sphere: u32, displacement_m: &Vec3, velocity_m_s: &Vec3) {
        self.bodies
            .nodes
            .at_mut(sphere)
            .put(displacement_m, velocity_m_s);
    }

    /// Everything back to rest, held as the scene has it.
    pub fn rest(&mut self) {
        self.bodies.rest(&self.scene);
        self.tick = 0;
    }

    /// One tick. Returns how many spheres were not finite, or far away, and were put back.
    pub fn step(&mut self) -> u32 {
        self.step_with(|_, _| ())
    }

    /// One tick; `correct` sees every organ's tissue after its constraints, in each substep of
    /// this length, s, and may move spheres: a contact.
    pub fn step_with(&mut self, mut correct: impl FnMut(&mut Correction<'_>, f32)) -> u32 {
        let mut put_back = 0;
        let (scene, bodies) = (self.scene, &mut *self.bodies);
        bodies.begin(&scene, true);
        for organ in scene.organs {
            bodies.breathe(&scene, organ, self.tick);
            let substeps = organ.substeps.max(1);
            let step_s = TICK_S / substeps as f32;
            for substep in 1..=substeps {
                bodies.predict(&scene, organ, step_s);
                self.method.project(&scene, organ, step_s, bodies);
                correct(&mut Correction { bodies }, step_s);
                if substep < substeps {
                    put_back += bodies.advance(organ, step_s).put_back;
                }
            }
        }
        attachment::project_all(&scene, bodies);
        for organ in scene.organs {
            let step_s = TICK_S / organ.substeps.max(1) as f32;
            put_back += bodies.advance(organ, step_s).put_back;
            bodies.stop_leading(organ);
        }
        self.tick = self.tick.wrapping_add(1);
        put_back
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

    /// Whether the scene itself holds a sphere.
    #[must_use]
    pub fn is_held(&self, sphere: u32) -> bool {
        let rest = self.scene.spheres.get(sphere as usize);
        rest.is_some_and(|rest| inverse_mass_per_kg(rest) <= 0.0)
    }
}

/// Tissue within a substep.
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

    /// Its inverse mass, 1/kg; 0 if it is held.
    #[must_use]
    pub fn inverse_mass_per_kg(&self, sphere: u32) -> f32 {
        self.bodies.nodes.at(sphere).inverse_mass_per_kg()
    }

    /// Moves it on, m.
    pub fn move_by(&mut self, sphere: u32, step_m: &Vec3) {
        self.bodies.nodes.at_mut(sphere).move_by(step_m);
    }
}
