//! The vector kernel against its references, and single tetrahedra by hand.

extern crate std;

use std::boxed::Box;
use std::vec::Vec;

use nalgebra::Matrix3;
use proptest::prelude::*;

use super::kernel::{self, Moduli};
use super::{POISSON_MAX, moduli};
use crate::math::{self, Vec3};
use crate::scene::tests::{organ, sphere};
use crate::scene::{RestSphere, Tetra, TetraBatch, batches};
use crate::tissue::Node;
use crate::tissue::lanes::Lanes;
use crate::tissue::per_sphere::PerSphere;
use crate::tissue::warm_start::{BatchMemory, Limits};

const STEP_S: f32 = 0.001;
const KEPT_SHARE: Limits = Limits {
    kept_share: 1.0,
    rate_max: 10.0,
};

/// 4 × 4 × 4 spheres 1 cm apart.
fn grid() -> Vec<RestSphere> {
    let at = |i: u16| Vec3::new(f32::from(i % 4), f32::from(i / 4 % 4), f32::from(i / 16));
    (0..64).map(|i| sphere(at(i) * 0.01, 0.006)).collect()
}

/// Six tetrahedra in each cube of the grid.
fn cells() -> Vec<Tetra> {
    let mut packed_batches = Vec::new();
    for i in 0..27 {
        let corner = i % 3 + i / 3 % 3 * 4 + i / 9 * 16;
        for (a, b, sign) in [
            (1, 4, 1),
            (4, 16, 1),
            (16, 1, 1),
            (1, 16, -1),
            (4, 1, -1),
            (16, 4, -1),
        ] {
            let mut spheres = [corner, corner + a, corner + a + b, corner + 21];
            if sign < 0 {
                spheres.swap(1, 2);
            }
            packed_batches.push(Tetra {
                spheres,
                volume_m3: 1.0e-6 / 6.0,
            });
        }
    }
    packed_batches
}

fn stiff() -> Moduli {
    let mut material = organ(0, 64, 0, 0).material;
    material.retardation_s = 0.002;
    moduli(&material, STEP_S, KEPT_SHARE).unwrap()
}

fn packed() -> Vec<TetraBatch> {
    let mut packed_batches = Vec::new();
    batches(&cells(), &grid(), |batch| packed_batches.push(batch)).unwrap();
    packed_batches
}

/// Memories of tetrahedra at rest between these nodes.
fn memories(batches: &[TetraBatch], nodes: &PerSphere<Node>) -> Vec<BatchMemory> {
    let weighed = |batch| {
        let mut memory = BatchMemory::REST;
        memory.set_masses(batch, nodes);
        memory
    };
    batches.iter().map(weighed).collect()
}

/// One pass over tetrahedra that were at rest in the last substep.
fn pass(
    project: fn(&mut PerSphere<Node>, &[TetraBatch], &mut [BatchMemory], &Moduli),
    nodes: &mut PerSphere<Node>,
) {
    let batches = packed();
    let mut last = memories(&batches, nodes);
    project(nodes, &batches, &mut last, &stiff());
}

/// Spheres with displacements and steps; the first four are held.
fn nodes(displacements: &[[f32; 6]]) -> Box<PerSphere<Node>> {
    let mut nodes = Box::new(PerSphere::new(Node::ZERO));
    for (i, (rest, [x, y, z, u, v, w])) in (0u32..).zip(grid().iter().zip(displacements)) {
        let node = nodes.at_mut(i);
        node.rest_m = Lanes::new(&rest.center_m, 0.0);
        node.put(&Vec3::new(*x, *y, *z), &Vec3::zeros());
        node.set_inverse_mass_per_kg(if i < 4 { 0.0 } else { 1000.0 });
        node.step_m = Lanes::new(&(Vec3::new(*u, *v, *w) * 0.1), 0.0);
    }
    nodes
}

fn steps(nodes: &PerSphere<Node>) -> Vec<[u32; 4]> {
    let bits = |i| nodes.at(i).step_m.to_array().map(f32::to_bits);
    (0..64).map(bits).collect()
}

/// Deformation of a tetrahedron and its cofactor matrix.
fn deformed(nodes: &PerSphere<Node>, corners: [u32; 4]) -> [Matrix3<f64>; 3] {
    let x = |i: u32| nodes.at(i).rest_m().cast::<f64>();
    let u = |i: u32| {
        (nodes.at(i).moved_m + nodes.at(i).step_m)
            .vec3()
            .cast::<f64>()
    };
    let [o, a, b, c] = corners;
    let edges = |of: &dyn Fn(u32) -> nalgebra::Vector3<f64>| {
        Matrix3::from_columns(&[of(a) - of(o), of(b) - of(o), of(c) - of(o)])
    };
    let inverse = edges(&x).try_inverse().unwrap();
    let f = Matrix3::identity() + edges(&u) * inverse;
    let cofactor = Matrix3::from_columns(&[
        f.column(1).cross(&f.column(2)),
        f.column(2).cross(&f.column(0)),
        f.column(0).cross(&f.column(1)),
    ]);
    [f, cofactor, inverse]
}

/// The equations of the kernel's documentation in `f64`, as a linear system for `F⁺`, one
/// tetrahedron after the other. The last impulse is zero.
fn project_by_formula(nodes: &mut PerSphere<Node>, moduli: &Moduli) {
    let volume_m3 = 1.0e-6 / 6.0;
    let (shear, ratio) = (f64::from(moduli.shear), f64::from(moduli.shear_over_bulk));
    let (gamma, rate) = (f64::from(moduli.rest_volume), f64::from(moduli.rate));
    for batch in packed() {
        for corners in batch.corners() {
            let [f, cofactor, inverse] = deformed(nodes, corners);
            let ends = [0, 1, 2].map(|k| inverse.row(k).transpose());
            let gradients = [-(ends[0] + ends[1] + ends[2]), ends[0], ends[1], ends[2]];
            let weights = corners.map(|i| f64::from(nodes.at(i).inverse_mass_per_kg()));
            let mut mobility = Matrix3::zeros();
            for (b, w) in gradients.iter().zip(weights) {
                mobility += b * b.transpose() * (w * shear * volume_m3);
            }
            let s = f64::max(1.0, (f.determinant() - gamma).abs() / ratio);
            // P as a function of p is affine: J⁺ at p = 0 and p = 1 give p.
            let after = |p: f64| {
                let inverse = (Matrix3::identity() + mobility * (1.0 + s))
                    .try_inverse()
                    .unwrap();
                (f + (cofactor * p + f * s) * mobility) * inverse
            };
            let volume = |p: f64| f.determinant() + cofactor.dot(&(after(p) - f));
            let slope = volume(1.0) - volume(0.0);
            let error = volume(0.0) - gamma + rate * (volume(0.0) - 1.0);
            let p = -error / (ratio + (1.0 + rate) * slope);
            let stress = cofactor * p - after(p) - (after(p) - f) * s;
            for ((corner, b), w) in corners.into_iter().zip(gradients).zip(weights) {
                let push = stress * b * (w * shear * volume_m3);
                nodes.at_mut(corner).move_by(&push.cast());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn registers_and_arrays_give_the_same_bits(
        displaced in prop::collection::vec(prop::array::uniform6(-0.02f32..0.02), 64)
    ) {
        let mut plain = nodes(&displaced);
        pass(kernel::project_plain, &mut plain);
        let mut fast = nodes(&displaced);
        pass(kernel::project, &mut fast);
        prop_assert_eq!(steps(&plain), steps(&fast));
        prop_assert!((0..64).all(|i| math::is_finite(&fast.at(i).moved_m())));
    }

    #[test]
    fn kernel_matches_the_formula(
        displaced in prop::collection::vec(prop::array::uniform6(-0.002f32..0.002), 64)
    ) {
        let mut fast = nodes(&displaced);
        pass(kernel::project, &mut fast);
        let mut formula = nodes(&displaced);
        project_by_formula(&mut formula, &stiff());
        for i in 0..64 {
            let difference_m = math::norm(&(fast.at(i).moved_m() - formula.at(i).moved_m()));
            prop_assert!(difference_m < 2.0e-6, "sphere {} is {} m off", i, difference_m);
        }
    }

    #[test]
    fn momentum_is_conserved(displaced in prop::collection::vec(prop::array::uniform6(-0.02f32..0.02), 64)) {
        let mut all = nodes(&displaced);
        for i in 0..64 {
            all.at_mut(i).set_inverse_mass_per_kg(200.0 + 50.0 * (i % 7) as f32);
        }
        let momentum = |nodes: &PerSphere<Node>| -> Vec3 {
            let of = |i| nodes.at(i).step_m.vec3() / nodes.at(i).inverse_mass_per_kg();
            (0..64).map(of).sum()
        };
        let before = momentum(&all);
        pass(kernel::project, &mut all);
        let moved: f32 = (0..64).map(|i| math::norm(&all.at(i).step_m.vec3())).sum();
        let lost = math::norm(&(momentum(&all) - before));
        prop_assert!(lost < 1.0e-6 * moved / 200.0 * 8.0 + 1.0e-9, "{} of {}", lost, moved);
    }
}

#[test]
fn a_rigid_motion_is_left_alone() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.7f32, -1.9, 2.4);
    let mut turned = nodes(&[[0.0; 6]; 64]);
    for i in 0..64 {
        let rest = turned.at(i).rest_m();
        let moved = turn * rest - rest + Vec3::new(0.3, 0.1, -0.2);
        turned.at_mut(i).put(&moved, &Vec3::zeros());
        turned.at_mut(i).set_inverse_mass_per_kg(1000.0);
    }
    pass(kernel::project, &mut turned);
    let step_max_m = (0..64).map(|i| math::norm(&turned.at(i).step_m.vec3()));
    let step_max_m = step_max_m.fold(0.0, f32::max);
    assert!(step_max_m < 1.0e-6, "moved by {step_max_m} m");
}

/// One tetrahedron under a constant force comes to the stress of the energy, not of its
/// linearisation, even when it is deformed far.
#[test]
fn a_tetrahedron_in_balance_has_the_stress_of_its_energy() {
    let one = [Tetra {
        spheres: [4, 5, 8, 20],
        volume_m3: 1.0e-6 / 6.0,
    }];
    let mut packed_batches = Vec::new();
    batches(&one, &grid(), |batch| packed_batches.push(batch)).unwrap();
    let mut nodes = nodes(&[[0.0; 6]; 64]);
    for held in [4, 5, 8] {
        nodes.at_mut(held).set_inverse_mass_per_kg(0.0);
    }
    let moduli = stiff();
    let force_n = Vec3::new(-0.02, 0.01, -0.03);
    let fall_m = force_n * (1000.0 * STEP_S * STEP_S);
    let mut last = memories(&packed_batches, &nodes);
    let mut pushed_m = Lanes::ZERO;
    for _ in 0..3000 {
        // Overdamped: the sphere begins each step at rest.
        let node = nodes.at_mut(20);
        let moved_m = node.moved_m();
        node.put(&moved_m, &Vec3::zeros());
        node.step_m = Lanes::new(&fall_m, 0.0) + pushed_m;
        kernel::project(&mut nodes, &packed_batches, &mut last, &moduli);
        pushed_m = nodes.at(20).step_m - Lanes::new(&fall_m, 0.0);
    }
    let [f, cofactor, inverse] = deformed(&nodes, [4, 5, 8, 20]);
    let mu_pa = f64::from(moduli.shear / (STEP_S * STEP_S));
    let pressure =
        (f.determinant() - f64::from(moduli.rest_volume)) / f64::from(moduli.shear_over_bulk);
    let stress_pa = (f + cofactor * pressure) * mu_pa;
    let elastic_n = stress_pa * inverse.row(2).transpose() * (-1.0e-6 / 6.0);
    assert!((f - Matrix3::identity()).norm() > 0.3, "{f}");
    let residual_n = (elastic_n + force_n.cast()).norm();
    assert!(
        residual_n < 1.0e-4,
        "{residual_n} N of {} N are left",
        math::norm(&force_n)
    );
}

#[test]
fn poisson_beyond_locking_is_clamped() {
    let mut material = organ(0, 1, 0, 0).material;
    material.poisson = 0.499;
    let clamped = moduli(&material, STEP_S, KEPT_SHARE);
    material.poisson = POISSON_MAX;
    assert_eq!(clamped, moduli(&material, STEP_S, KEPT_SHARE));
    material.young_pa = 0.0;
    assert_eq!(moduli(&material, STEP_S, KEPT_SHARE), None);
}
