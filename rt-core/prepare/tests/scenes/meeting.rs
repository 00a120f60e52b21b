//! An organ that lies on another: their skins meet, and it lies still.

use crate::support::LoadedScene;
use rt_core::math::{self, Vec3};
use rt_core::port::{DeviceCapabilities, ForceCommand, Polled};
use rt_core::scene::{Organ, SkinVertex};
use rt_core::sim::{Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use scene_prepare::mesh::Mesh;
use scene_prepare::pack::Interior;
use scene_prepare::{Prepared, Recipe, prepare, shape};

/// Halves of the length, width and height of the bed, then of the cushion, m.
const HALF_M: [[f64; 3]; 2] = [[0.04, 0.04, 0.012], [0.022, 0.018, 0.012]];
/// Radius of the rounded edges, m.
const ROUND_M: f64 = 0.009;
/// Gap between the two before the cushion falls, m.
const FALL_M: f64 = 0.002;
/// Two skins meet if their depth in each other, or the gap between them, is below this, m. With
/// spheres alone, the skins would be at least 0.7 mm inside each other.
const NEAR_M: f64 = 0.00055;
/// The cushion lies still if all its spheres are slower than this, m/s. The limit is not zero,
/// because the cushion still slides on the bed.
const STILL_M_S: f32 = 0.03;
/// Number of ticks after which the cushion lies on the bed.
const TICKS: u64 = 3000;

/// A bed of a liver's tissue, held at its base, and a free cushion of the same tissue above it.
fn bed_and_cushion(spheres: usize) -> Prepared {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from("name = \"a test\"\n[room]\ngravity_m_s2 = [0.0, 0.0, -9.81]\n");
    let up_m = [0.0, HALF_M[0][2] + FALL_M + HALF_M[1][2]];
    for (number, held) in ["{ base = 0.2 }", ""].into_iter().enumerate() {
        let file = format!("{number}.obj");
        let mesh = as_obj(&block(HALF_M[number], up_m[number]));
        std::fs::write(folder.path().join(&file), mesh).expect("written");
        text.push_str(&format!(
            "[[organ]]\nname = \"{number}\"\nkind = \"liver\"\nmesh = \"{file}\"\nunit = \"m\"\nspheres = {spheres}\n\
             held = [{held}]\ngravity_share = {number}.0\n[organ.material]\nyoung_pa = 5000.0\npoisson = 0.45\n",
        ));
    }
    let recipe = Recipe::parse(&text, "a test", folder.path()).expect("a good recipe");
    prepare(&recipe, &mut |_| {}).expect("two organs")
}

/// A block with round edges.
fn block(half_m: [f64; 3], up_m: f64) -> Mesh {
    use scene_prepare::Vec3;
    let (half_m, up) = (Vec3::from(half_m), Vec3::z() * up_m);
    let distance = |p: &Vec3| {
        let beyond = (p - up).abs() - half_m.add_scalar(-ROUND_M);
        beyond.sup(&Vec3::zeros()).norm() + beyond.max().min(0.0) - ROUND_M
    };
    let margin = Vec3::repeat(0.004);
    shape::skin(
        &distance,
        [up - half_m - margin, up + half_m + margin],
        0.002,
    )
}

fn as_obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for v in &mesh.vertices {
        text.push_str(&format!("v {} {} {}\n", v.x, v.y, v.z));
    }
    for [a, b, c] in &mesh.triangles {
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    }
    text
}

/// Records the places of the spheres, m.
#[derive(Default)]
struct Nobody {
    now_ns: u64,
    centers_m: Vec<Vec3>,
}

impl Ports for Nobody {
    fn sample(&mut self) -> Samples {
        Samples {
            now_ns: self.now_ns,
            device: Polled::Nothing,
            tracker: Polled::Nothing,
            pedal: Polled::Nothing,
            command: None,
        }
    }

    fn send_force(&mut self, _: ForceCommand) {}

    fn publish(&mut self, view: &TickView<'_>) {
        self.centers_m.clear();
        self.centers_m.extend(view.spheres().map(|it| it.center_m));
    }

    fn stamp(&mut self, _: Stage) {}
}

/// The two contact skins at the end, and the speed of the fastest sphere, m/s.
fn lie(built: &Prepared) -> ([Mesh; 2], f32) {
    let loaded = LoadedScene::new(&built.scene);
    let mut state = Box::new(State::new());
    let mut sim = Sim::new(
        loaded.scene(),
        &mut state,
        DeviceCapabilities::TOUCH,
        Parameters::default(),
    );
    let mut hand = Nobody::default();
    let mut before_m = Vec::new();
    for _ in 0..TICKS {
        std::mem::swap(&mut before_m, &mut hand.centers_m);
        hand.now_ns += 1_000_000;
        sim.tick(&mut hand);
    }
    let ways = hand.centers_m.iter().zip(&before_m);
    let fastest_m_s = ways.map(|(a, b)| math::norm(&(a - b)) * 1000.0);
    let skins = [0, 1].map(|organ| skin_of(&loaded, &loaded.organs[organ], &hand.centers_m));
    (skins, fastest_m_s.fold(0.0, f32::max))
}

/// An organ's contact skin while its spheres are at these places.
fn skin_of(loaded: &LoadedScene, organ: &Organ, centers_m: &[Vec3]) -> Mesh {
    let own = organ.sphere_start..organ.sphere_start + organ.sphere_count;
    let all = &loaded.skin_vertices;
    let is_own = |it: &SkinVertex| own.contains(&u32::from(it.spheres[0]));
    let first = all.iter().position(is_own).expect("it has a skin") as u32;
    let mut mesh = Mesh::default();
    for (number, vertex) in all.iter().enumerate().filter(|(_, it)| is_own(it)) {
        let parts = vertex.spheres.iter().zip(vertex.weights);
        let at_m: Vec3 = parts.map(|(s, w)| centers_m[usize::from(*s)] * w).sum();
        mesh.vertices.push(at_m.cast());
        let start = vertex.fan_start as usize;
        for [b, c] in &loaded.skin_fans[start..start + vertex.fan_count as usize] {
            let [a, b, c] = [number as u32, u32::from(*b), u32::from(*c)].map(|it| it - first);
            // Each triangle is in the fans of its three corners.
            if a < b && a < c {
                mesh.triangles.push([a, b, c]);
            }
        }
    }
    assert!(mesh.is_closed());
    mesh
}

/// Depth of the deepest vertex of one mesh in the other, m; negative if they are apart.
fn deepest(of: &Mesh, within: &Mesh) -> f64 {
    let interior = Interior::new(within, within.volume(), 4000).expect("a body");
    let depths = of.vertices.iter().map(|it| interior.depth(it));
    depths.fold(f64::NEG_INFINITY, f64::max)
}

/// Contact of the spheres alone would let the skins go 0.7 to 1.1 mm into each other.
#[test]
fn organs_lie_on_each_other_at_their_skins() {
    for spheres in [250, 600, 1200] {
        let ([bed, cushion], speed_m_s) = lie(&bed_and_cushion(spheres));
        let depths_m = [deepest(&cushion, &bed), deepest(&bed, &cushion)];
        println!("{spheres} spheres: {depths_m:?} m, {speed_m_s} m/s");
        let meet = depths_m.iter().all(|it| it.abs() < NEAR_M);
        assert!(meet, "{spheres} spheres: {depths_m:?} m");
        assert!(speed_m_s < STILL_M_S, "{spheres} spheres: {speed_m_s} m/s");
    }
}
