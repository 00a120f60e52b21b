//! Ducts and vessels of Calot's triangle, each drawn straight and stretched by itself.

use std::cell::Cell;

use rt_core::math::Vec3;
use rt_core::scene::{Link, Organ, RestSphere, Room, Scene};
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use shared_mem::scene::SceneData;

use crate::support::LoadedScene;

/// Ticks in which the grip draws the tube out, and in which it rests before its force is read.
const TICKS: [u32; 2] = [300, 700];
const READ_TICKS: u32 = 100;
const STRAIN: f32 = 0.05;

/// A tube laid out straight along x, with the masses and the links that preparation gave it.
struct Straight {
    organ: Organ,
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    room: Room,
}

impl Straight {
    /// `softer` divides the stiffness of its links.
    fn new(data: &SceneData, loaded: &LoadedScene, organ: usize, softer: f32) -> Self {
        let record = &data.organs[organ];
        let [first, count] = record.spheres;
        let [first_link, links] = record.links.map(|it| it as usize);
        let own = &data.spheres[first as usize..][..count as usize];
        let (mut end_m, mut x_m) = (0.0, vec![0.0]);
        for two in own.windows(2) {
            end_m += (Vec3::from(two[1].center_m) - Vec3::from(two[0].center_m)).norm();
            x_m.push(end_m);
        }
        let spheres = own.iter().zip(&x_m).map(|(sphere, x_m)| RestSphere {
            center_m: Vec3::new(*x_m, 0.0, 0.0),
            radius_m: sphere.radius_m,
            mass_kg: sphere.mass_kg,
            held: false,
        });
        let links = data.links[first_link..][..links].iter().map(|link| {
            let [a, b] = [link.a - first, link.b - first];
            let rest_length_m = (x_m[a as usize] - x_m[b as usize]).abs();
            Link {
                a,
                b,
                rest_length_m,
                compliance_m_n: link.compliance_m_n * softer * rest_length_m / link.rest_length_m,
            }
        });
        Self {
            organ: Organ {
                sphere_start: 0,
                link_start: 0,
                batch_start: 0,
                batch_count: 0,
                gravity_share: 0.0,
                ..loaded.organs[organ]
            },
            spheres: spheres.collect(),
            links: links.collect(),
            room: *loaded.scene().room(),
        }
    }

    fn length_m(&self) -> f32 {
        self.spheres
            .iter()
            .map(|it| it.center_m.x)
            .fold(0.0, f32::max)
    }

    /// Stretches the tube by [`STRAIN`] with a grip at its end, and lets it rest. Returns the force
    /// on the grip, N, and the largest speed of a sphere, m/s.
    fn stretched(&self) -> [f32; 2] {
        let organs = [self.organ];
        let scene = Scene::new(&organs, &self.spheres, &self.links, self.room);
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(scene.expect("sound"), &mut bodies, Method::NeoHookean);
        let count = self.spheres.len() as u32;
        let impulse_n_s = Cell::new(0.0);
        let mut fastest_m_s = 0.0f32;
        for tick in 0..TICKS[0] + TICKS[1] {
            let share = (tick as f32 / TICKS[0] as f32).min(1.0);
            let out_m = STRAIN * self.length_m() * share;
            let is_read = tick >= TICKS[0] + TICKS[1] - READ_TICKS;
            let put_back = tissue.step_with(|tissue, step_s| {
                for i in [0, 1, count - 2, count - 1] {
                    let to_m = if i < 2 { 0.0 } else { out_m };
                    let step_m = self.spheres[i as usize].center_m - tissue.center_m(i)
                        + Vec3::new(to_m, 0.0, 0.0);
                    if is_read && i >= 2 {
                        let own_n_s = step_m.x / (tissue.inverse_mass_per_kg(i) * step_s);
                        impulse_n_s.set(impulse_n_s.get() + own_n_s);
                    }
                    tissue.move_by(i, &step_m);
                }
            });
            assert_eq!(put_back, 0, "a sphere was put back");
            if is_read {
                let speeds = (0..count).map(|i| tissue.velocity_m_s(i).norm());
                fastest_m_s = speeds.fold(fastest_m_s, f32::max);
            }
        }
        [impulse_n_s.get() / (READ_TICKS as f32 * 1e-3), fastest_m_s]
    }
}

/// The force is compared with two others. In a tube a hundred times as soft, one pass over the
/// links suffices for their static force. A rod with the tube's volume and length has the force
/// `E A ε`.
#[test]
fn ducts_of_the_triangle_are_as_stiff_as_their_material() {
    const SOFTER: f32 = 100.0;
    let prepared = crate::prepared_triangle(false);
    let loaded = LoadedScene::new(&prepared.scene);
    for name in [
        "cystic duct",
        "bile duct",
        "hepatic artery",
        "cystic artery",
    ] {
        let mut reports = prepared.report.organs.iter().enumerate();
        let (i, report) = reports
            .find(|(_, it)| it.name == name)
            .expect("it is there");
        let straight = |softer| Straight::new(&prepared.scene, &loaded, i, softer);
        let [force_n, fastest_m_s] = straight(1.0).stretched();
        let [soft_n, _] = straight(SOFTER).stretched();
        let of_static = force_n / (soft_n * SOFTER);
        let area_m2 = 1e-6 * report.volume_ml as f32 / straight(1.0).length_m();
        let young_pa = loaded.organs[i].material.young_pa;
        let of_rod = force_n / (young_pa * area_m2 * STRAIN);
        println!(
            "{name}: {force_n} N, {of_static:.3} of static, {of_rod:.3} of a rod, {fastest_m_s} m/s, \
             stiffness number {:.2} in {} substeps",
            report.stiffness_number, report.substeps
        );
        assert!((of_static - 1.0).abs() < 0.04, "{name}: {of_static}");
        assert!((of_rod - 1.0).abs() < 0.07, "{name}: {of_rod}");
        assert!(fastest_m_s < 2.0e-4, "{name}: {fastest_m_s} m/s");
    }
}
