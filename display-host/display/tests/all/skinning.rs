//! The two implementations of skinning against each other, and against cases solved by hand.

use display_host::render::gpu::Gpu;
use display_host::skinning::gpu::GpuSkinning;
use display_host::skinning::motion::{Follow, Motion, Motions};
use display_host::skinning::{SkinMesh, SkinnedVertex, Touch};
use glam::Vec3;
use proptest::prelude::*;
use shared_mem::message::SphereState;

use crate::support;

fn skinned(mesh: &SkinMesh, motions: &[Motion]) -> Vec<SkinnedVertex> {
    let mut out = mesh.at_rest();
    mesh.skin(motions, &Touch::default(), &mut out);
    out
}

/// Motions of spheres that only translate.
fn shifts(each: impl Iterator<Item = Vec3>) -> Vec<Motion> {
    each.map(|v| [v.x, v.y, v.z].map(|x| [0.0, 0.0, 0.0, x]))
        .collect()
}

/// Various translations, all different.
fn lively(count: usize, size_m: f32) -> Vec<Motion> {
    let wave = |i: usize, k: f32| (i as f32 * k).sin() * size_m;
    shifts((0..count).map(|i| Vec3::new(wave(i, 1.3), wave(i, 2.1), wave(i, 3.7))))
}

#[test]
fn gpu_and_cpu_agree() {
    let scene = support::scene(40);
    let mut mesh = SkinMesh::from_scene(&scene);
    // Vertices without spheres stay in place in both implementations.
    let fixed = mesh.vertices[..3].to_vec();
    mesh.add_fixed(&fixed, &[[0, 1, 2]]);
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    let skinning = GpuSkinning::new(&gpu, &mesh, scene.spheres().len()).unwrap();
    let tools = support::tools(&scene, 0.012, 0.5);
    let pressed = Touch::of(&mesh, scene.organs(), &[], &[], &tools);
    assert_eq!(pressed.count[0], 1, "the tool presses: {pressed:?}");
    for (size_m, touch) in [
        (0.0, Touch::default()),
        (0.001, Touch::default()),
        (0.02, Touch::default()),
        (0.001, pressed),
    ] {
        let mut motions = lively(scene.spheres().len(), size_m);
        // The motions also turn and stretch. Over a metre, that moves skin ten times as far as the
        // translations do.
        for (i, x) in motions
            .as_flattened_mut()
            .as_flattened_mut()
            .iter_mut()
            .enumerate()
        {
            if i % 4 != 3 {
                *x = (i as f32 * 0.7).sin() * 10.0 * size_m;
            }
        }
        skinning.upload(&gpu, &motions, &touch);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        skinning.encode(&mut encoder, None);
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read_buffer(&skinning.now).unwrap();
        let there: &[SkinnedVertex] = bytemuck::cast_slice(&bytes);
        let mut here = mesh.at_rest();
        mesh.skin(&motions, &touch, &mut here);
        let mut free = mesh.at_rest();
        mesh.skin(&motions, &Touch::default(), &mut free);
        let most = here.iter().zip(&free).fold(0.0, |most: f32, (here, free)| {
            let [here, free] = [here, free].map(|v| Vec3::from_slice(&v.position));
            most.max(here.distance(free))
        });
        assert_eq!(most > 0.002, touch != Touch::default(), "moved by {most} m");
        assert_eq!(here.len(), there.len());
        let worst = |part: fn(&SkinnedVertex) -> Vec3| {
            let far = here
                .iter()
                .zip(there)
                .map(|(a, b)| part(a).distance(part(b)));
            // `f32::max` would ignore a NaN.
            far.fold(0.0, |most: f32, x| if x <= most { most } else { x })
        };
        let position = worst(|v| Vec3::from_slice(&v.position));
        let normal = worst(|v| Vec3::from_slice(&v.normal));
        let bend = worst(|v| Vec3::splat(v.normal[3] * 1e-3));
        assert!(
            position <= 1e-6,
            "position differs by {position} m at {size_m}"
        );
        // Vulkan allows `normalize` errors of a few units in the last place. Where the skin bends
        // most, the normal is a difference of nearly equal vectors: an NVIDIA H200 differs by
        // 1.3e-5.
        assert!(normal <= 1e-4, "normal differs by {normal} at {size_m}");
        assert!(bend <= 1e-3, "bend differs by {bend} per mm at {size_m}");
    }
}

/// The drawn skin is not the contact skin, so a dent is as deep as the tool is in the drawn skin.
/// A light touch, and skin of another wall, leave the published depth.
#[test]
fn a_dent_is_as_deep_as_the_tool_is_in_the_drawn_skin() {
    let scene = support::scene(40);
    let mesh = SkinMesh::from_scene(&scene);
    let state = support::state(&scene, 0.0);
    let mut motions = Motions::new(&scene, Follow::Deform);
    let spheres = state.spheres().unwrap();
    let motions = motions.update(spheres).to_vec();
    let liver = &scene.vertices()[..scene.organs()[0].vertices[1] as usize];
    let near = |v: &&shared_mem::scene::VertexRecord| {
        let off = Vec3::from(v.position_m) - support::PRESSED_M;
        off.truncate().length()
    };
    let upper = liver.iter().filter(|v| v.normal[2] > 0.5);
    let top = upper.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
    let (radius_m, true_m) = (0.002, 0.003);
    let depth_m = |published_m: f32, off_m: f32| {
        let mut tools = support::tools(&scene, 0.012, 0.5);
        let dent = &mut tools.dents[0];
        let up = Vec3::Z * (radius_m - true_m + off_m);
        dent.center_m = (Vec3::from(top.position_m) + up).to_array();
        (dent.radius_m, dent.depth_m) = (radius_m, published_m);
        Touch::of(&mesh, scene.organs(), spheres, &motions, &tools).dents[0].b[3]
    };
    for published_m in [0.002, 0.003, 0.004] {
        let found_m = depth_m(published_m, 0.0);
        assert!((found_m - true_m).abs() < 3e-4, "{published_m}: {found_m}");
    }
    assert!((depth_m(1e-6, 0.0) - 1e-6).abs() < 1e-5);
    assert!((depth_m(0.002, 0.02) - 0.002).abs() < 1e-9);
}

#[test]
fn a_shift_of_all_spheres_shifts_the_skin() {
    let scene = support::scene(16);
    let mesh = SkinMesh::from_scene(&scene);
    let shift = Vec3::new(0.01, -0.02, 0.03);
    let now = skinned(&mesh, &shifts(scene.spheres().iter().map(|_| shift)));
    for (now, rest) in now.iter().zip(&mesh.vertices) {
        let wanted = Vec3::from(rest.position) + shift;
        assert!(Vec3::from_slice(&now.position).distance(wanted) < 1e-6);
        assert!(now.normal[3].abs() < 0.5, "no bend: {}", now.normal[3]);
    }
}

#[test]
fn a_vertex_follows_the_weighted_mean_of_its_spheres() {
    let scene = support::scene(16);
    let mesh = SkinMesh::from_scene(&scene);
    let motions = lively(scene.spheres().len(), 0.01);
    let now = skinned(&mesh, &motions);
    for (i, vertex) in scene.vertices().iter().enumerate() {
        // As in the paper: v' = Σ f c' / Σ f + (v − Σ f c / Σ f).
        let mean = |centre: &dyn Fn(usize) -> Vec3| -> Vec3 {
            let parts = vertex.spheres.iter().zip(&vertex.weights);
            parts
                .map(|(&s, &w)| centre(usize::from(s)) * (f32::from(w) / 65535.0))
                .sum()
        };
        let rest = |s: usize| Vec3::from(scene.spheres()[s].center_m);
        let moved = |s: usize| rest(s) + Vec3::from(motions[s].map(|row| row[3]));
        let wanted = mean(&moved) + (Vec3::from(vertex.position_m) - mean(&rest));
        let found = Vec3::from_slice(&now[i].position);
        assert!(
            found.distance(wanted) < 2e-6,
            "vertex {i}: {found} and {wanted}"
        );
    }
}

/// A liver twisted by 90° over its length: the paper's fixed offsets err by millimetres.
#[test]
fn skin_turns_with_the_tissue() {
    let scene = support::scene(24);
    let mesh = SkinMesh::from_scene(&scene);
    let twisted = |p: Vec3| {
        let angle = p.x / 0.17 * core::f32::consts::FRAC_PI_2;
        glam::Quat::from_rotation_x(angle) * p
    };
    let spheres: Vec<SphereState> = scene
        .spheres()
        .iter()
        .map(|s| SphereState {
            center_m: twisted(s.center_m.into()).to_array(),
            bits: 0,
        })
        .collect();
    let [paper, ours] = [Follow::Shift, Follow::Deform].map(|follow| {
        let mut motions = Motions::new(&scene, follow);
        let now = skinned(&mesh, motions.update(&spheres));
        let errors = now.iter().zip(&mesh.vertices).map(|(now, rest)| {
            Vec3::from_slice(&now.position).distance_squared(twisted(rest.position.into()))
        });
        (errors.sum::<f32>() / now.len() as f32).sqrt()
    });
    assert!(paper > 0.001, "{paper} m");
    assert!(
        ours < paper / 4.0,
        "{ours} m, and the paper's way {paper} m"
    );
}

#[test]
fn a_dent_is_felt_as_bent_inwards() {
    let scene = support::scene(48);
    let mesh = SkinMesh::from_scene(&scene);
    let state = support::state(&scene, 0.010);
    let mut motions = Motions::new(&scene, Follow::Deform);
    let now = skinned(&mesh, motions.update(state.spheres().unwrap()));
    let liver = scene.organs()[0].vertices[1] as usize;
    let deepest = (0..liver)
        .max_by(|&a, &b| {
            let depth = |i: usize| mesh.vertices[i].position[2] - now[i].position[2];
            depth(a).total_cmp(&depth(b))
        })
        .unwrap();
    let depth = mesh.vertices[deepest].position[2] - now[deepest].position[2];
    assert!(depth > 0.003, "{depth}");
    // A pit 3 mm deep or more and one or two centimetres wide has a curvature of some tens of 1/m.
    assert!(now[deepest].normal[3] > 10.0, "{:?}", now[deepest].normal);
    let far = now[..liver].iter().filter(|v| v.position[0] > 0.06);
    assert!(far.clone().count() > 10);
    far.for_each(|v| assert!(v.normal[3].abs() < 1.0, "{:?}", v.normal));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn normals_stay_unit_and_finite(size_m in 0.0f32..0.05, seed in 0usize..1000) {
        let scene = support::scene(12);
        let mesh = SkinMesh::from_scene(&scene);
        let motions = lively(scene.spheres().len() + seed, size_m).split_off(seed);
        for vertex in skinned(&mesh, &motions) {
            let length = Vec3::from_slice(&vertex.normal).length();
            prop_assert!((length - 1.0).abs() < 1e-4, "{length}");
            prop_assert!(vertex.position.iter().chain(&vertex.normal).all(|x| x.is_finite()));
        }
    }
}
