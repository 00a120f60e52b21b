//! Checks that an organ comes to rest after a disturbance. A packing has a few flat tetrahedra,
//! which are stiffer than the organ's stiffness number says. Some of them oscillate at one substep
//! a tick and come to rest at two.

use rt_core::math::{Pose, Vec3, norm};
use rt_core::scene::{Inside, Link, Material, Organ, RestSphere, Room, Scene, Tetra, batches};
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use shared_mem::scene::SceneData;

use crate::elastic::SUBSTEPS_MAX;

/// Initial speed of every sphere, m/s: 10 µm in a tick. Each has its own direction.
const SHAKEN_M_S: f32 = 0.01;
/// An organ with a sphere faster than this at the end of the test oscillates, m/s. A soft organ
/// with little damping is then still about as fast as at the start.
const SHAKES_M_S: f32 = 0.03;
/// Ticks after which the motion is judged. A motion that grows by a twentieth in each tick has
/// grown more than a thousandfold by then.
const TICKS: u32 = 150;

/// The fewest substeps with which the organ with this index comes to rest after it is shaken, but
/// never fewer than the organ already has.
pub(crate) fn substeps(scene: &SceneData, organ: usize) -> u32 {
    let Some(alone) = Alone::new(scene, organ) else {
        return scene.organs[organ].substeps; // the scene's own check says what is wrong
    };
    let mut substeps = alone.organ.substeps.max(1);
    while substeps < SUBSTEPS_MAX && !alone.comes_to_rest(substeps) {
        substeps *= 2;
    }
    substeps
}

/// One organ without the others and without weight.
struct Alone {
    organ: Organ,
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    batches: Vec<rt_core::scene::TetraBatch>,
}

impl Alone {
    fn new(scene: &SceneData, organ: usize) -> Option<Self> {
        let record = scene.organs.get(organ)?;
        fn own<T>(all: &[T], [first, count]: [u32; 2]) -> Option<&[T]> {
            all.get(first as usize..)?.get(..count as usize)
        }
        let first = record.spheres[0];
        let spheres: Vec<_> = own(&scene.spheres, record.spheres)?
            .iter()
            .map(|s| RestSphere {
                center_m: Vec3::from(s.center_m),
                radius_m: s.radius_m,
                mass_kg: s.mass_kg,
                held: s.held != 0,
            })
            .collect();
        let links: Vec<_> = own(&scene.links, record.links)?
            .iter()
            .map(|l| Link {
                a: l.a - first,
                b: l.b - first,
                rest_length_m: l.rest_length_m,
                compliance_m_n: l.compliance_m_n,
            })
            .collect();
        let tetrahedra: Vec<_> = own(&scene.tetrahedra, record.tetrahedra)?
            .iter()
            .map(|t| Tetra {
                spheres: t.spheres.map(|i| u32::from(i) - first),
                volume_m3: t.volume_m3,
            })
            .collect();
        let mut packed = Vec::new();
        batches(&tetrahedra, &spheres, |batch| packed.push(batch)).ok()?;
        let m = &record.material;
        let organ = Organ {
            sphere_start: 0,
            sphere_count: spheres.len() as u32,
            link_start: 0,
            link_count: links.len() as u32,
            elastic_links: record.elastic_links,
            batch_start: 0,
            batch_count: packed.len() as u32,
            substeps: record.substeps,
            gravity_share: 0.0,
            breath_m: Vec3::zeros(),
            inside: Inside::Solid,
            material: Material {
                young_pa: m.young_pa,
                poisson: m.poisson,
                retardation_s: m.retardation_s,
                stretch_stiffness: m.stretch_stiffness,
                laplacian_stiffness: m.laplacian_stiffness,
                damping_per_s: m.damping_per_s,
                contact_stiffness_n_m: m.contact_stiffness_n_m,
                friction: m.friction,
                toughness_j_m2: 0.0,
            },
        };
        Some(Self {
            organ,
            spheres,
            links,
            batches: packed,
        })
    }

    /// True if no sphere still oscillates at the end of the test.
    fn comes_to_rest(&self, substeps: u32) -> bool {
        let organs = [Organ {
            substeps,
            ..self.organ
        }];
        let Ok(scene) = Scene::new(&organs, &self.spheres, &self.links, weightless())
            .and_then(|scene| scene.with_tetrahedra(&self.batches))
        else {
            return true; // the scene's own check says what is wrong
        };
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(scene, &mut bodies, Method::NeoHookean);
        let mut spheres = 0..self.spheres.len() as u32;
        for i in spheres.clone().filter(|i| !self.spheres[*i as usize].held) {
            // Directions follow the golden ratio: no two are alike, and they are the same in every
            // run.
            let (sin, cos) = libm::sincosf(i as f32 * 2.399_963);
            let up = (i as f32 * 0.618_034).fract() * 2.0 - 1.0;
            let level = (1.0 - up * up).sqrt();
            let way = Vec3::new(level * cos, level * sin, up);
            tissue.put(i, &Vec3::zeros(), &(way * SHAKEN_M_S));
        }
        let mut quarantined = 0;
        for _ in 0..TICKS {
            quarantined += tissue.step();
        }
        let is_slow = |i: u32| norm(&tissue.velocity_m_s(i)) < SHAKES_M_S;
        quarantined == 0 && spheres.all(is_slow)
    }
}

fn weightless() -> Room {
    Room {
        gravity_m_s2: Vec3::zeros(),
        world_from_device: Pose::identity(),
        world_from_tracker: Pose::identity(),
        instrument_port_m: Vec3::zeros(),
        instrument_length_m: 0.33,
        endoscope_port_m: Vec3::zeros(),
        world_from_camera: Pose::identity(),
        breath_s: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recipe;

    #[test]
    fn what_shakes_gets_the_fewest_substeps_in_which_it_does_not() {
        // Flat tetrahedra lie in the fat of the triangle.
        let built = crate::prepare(&Recipe::triangle(true).unwrap(), &mut |_| {}).unwrap();
        let mut scene = built.scene;
        let organs = &built.report.organs;
        let named = |name: &str| organs.iter().position(|organ| organ.name == name).unwrap();
        let (fat, liver) = (named("fat"), named("liver"));
        scene.organs[fat].substeps = 1;
        let alone = Alone::new(&scene, fat).unwrap();
        assert!(!alone.comes_to_rest(1) && alone.comes_to_rest(2));
        assert_eq!(substeps(&scene, fat), 2);
        assert_eq!(
            (built.report.organs[fat].substeps, substeps(&scene, liver)),
            (2, 1)
        );
    }
}
