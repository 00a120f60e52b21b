//! Compares the finite elements with closed forms and with independent integration.

use fem_reference::{Hold, Material, Mesh, Problem, Solution, Vec3, block, lattice, shell_octant};

fn tissue(poisson: f64) -> Material {
    Material::new(5000.0, poisson, 1060.0).expect("valid")
}

fn solve(problem: &Problem<'_>) -> Solution {
    let mut solutions = problem.solve(&[1.0], &mut |_| {}).expect("equilibrium");
    solutions.pop().expect("one stop, one solution")
}

fn unloaded<'a>(mesh: &'a Mesh, material: Material, holds: Vec<Hold<'a>>) -> Problem<'a> {
    Problem {
        mesh,
        material,
        gravity_m_s2: Vec3::zeros(),
        holds,
        tool: None,
    }
}

/// Patch test: if a large affine map moves the surface of an irregular mesh, the inner nodes follow
/// the map.
#[test]
fn an_affine_map_is_exact() {
    let box_m = Vec3::repeat(0.02);
    let mesh = lattice(-box_m, box_m, 0.009, |p| p.norm() - 0.02).expect("filled");
    let map = nalgebra::Matrix3::new(1.3, 0.4, -0.1, 0.1, 0.8, 0.2, -0.3, 0.1, 1.1);
    let mut surface: Vec<u32> = mesh.faces.iter().flatten().copied().collect();
    surface.sort_unstable();
    surface.dedup();
    assert!(surface.len() < mesh.nodes.len(), "something must be free");
    let motion = |x: &Vec3, t: f64| (map * x - x) * t;
    let material = tissue(0.45);
    let done = solve(&unloaded(
        &mesh,
        material,
        vec![Hold::moved(surface, motion)],
    ));
    for (x, u) in mesh.nodes.iter().zip(&done.displacement_m) {
        assert!((x + u - map * x).norm() < 1e-9 * 0.02);
    }
    let exact = material.energy(&map) * mesh.volume_m3(None).expect("sound");
    assert!((done.energy_j / exact - 1.0).abs() < 1e-9);
}

#[test]
fn a_rigid_rotation_has_no_energy() {
    let mesh = block(Vec3::zeros(), Vec3::new(0.04, 0.02, 0.02), [4, 2, 2]);
    let turn = nalgebra::Rotation3::from_axis_angle(&Vec3::y_axis(), 2.0);
    let ends = mesh.nodes_where(|p| p.x < 1e-9);
    let motion = |x: &Vec3, t: f64| nalgebra::Rotation3::new(turn.scaled_axis() * t) * x - x;
    let done = solve(&unloaded(
        &mesh,
        tissue(0.45),
        vec![Hold::moved(ends, motion)],
    ));
    for (x, u) in mesh.nodes.iter().zip(&done.displacement_m) {
        assert!((x + u - turn * x).norm() < 1e-6 * 0.04);
    }
    assert!(done.reaction_n.iter().map(|f| f.norm()).sum::<f64>() < 1e-5);
}

#[test]
fn a_bar_follows_its_closed_form_at_large_stretch() {
    let (length, side) = (0.05, 0.02);
    let mesh = block(Vec3::zeros(), Vec3::new(length, side, side), [3, 2, 2]);
    for poisson in [0.2, 0.3, 0.45, 0.49] {
        for stretch in [0.6, 0.9, 1.1, 2.0] {
            let end = mesh.nodes_where(|p| p.x > length - 1e-9);
            let mut pull = Hold::moved(end.clone(), |_, t| {
                Vec3::x() * (length * (stretch - 1.0) * t)
            });
            pull.axes = [true, false, false];
            let mut holds: Vec<_> = (0..3)
                .map(|axis| Hold::sliding(mesh.nodes_where(|p| p[axis] < 1e-9), axis))
                .collect();
            holds.push(pull);
            let material = tissue(poisson);
            let done = solve(&unloaded(&mesh, material, holds));
            let (lateral, stress) = material.uniaxial(stretch);
            let force: f64 = end.iter().map(|&n| done.reaction_n[n as usize].x).sum();
            let ratio = force / (stress * side * side);
            assert!((ratio - 1.0).abs() < 1e-6, "{poisson} {stretch}: {ratio}");
            for (x, u) in mesh.nodes.iter().zip(&done.displacement_m) {
                let exact = Vec3::new(stretch, lateral, lateral).component_mul(x);
                assert!((x + u - exact).norm() < 1e-6 * length);
            }
        }
    }
}

/// Timoshenko's cantilever under its own weight. The clamped root and the beam's finite slenderness
/// leave a difference below 1 %.
#[test]
fn a_cantilever_sags_as_a_beam() {
    let (length, side, gravity) = (0.4, 0.02, 1e-3);
    let material = tissue(0.3);
    let mesh = block(Vec3::zeros(), Vec3::new(length, side, side), [40, 3, 3]);
    let mut problem = unloaded(
        &mesh,
        material,
        vec![Hold::fixed(mesh.nodes_where(|p| p.x < 1e-9))],
    );
    problem.gravity_m_s2 = Vec3::new(0.0, 0.0, -gravity);
    let done = solve(&problem);
    let load = material.density_kg_m3 * gravity * side * side;
    let bend = load * length.powi(4) / (8.0 * material.young_pa * side.powi(4) / 12.0);
    let shear = load * length * length / (2.0 * 5.0 / 6.0 * material.mu_pa() * side * side);
    let tip = mesh.nodes_where(|p| p.x > length - 1e-9);
    let sag: f64 = tip
        .iter()
        .map(|&n| -done.displacement_m[n as usize].z)
        .sum();
    let ratio = sag / tip.len() as f64 / (bend + shear);
    println!("cantilever: {ratio:.5} of Timoshenko's deflection");
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    let weight: f64 = done.reaction_n.iter().map(|f| f.z).sum();
    let exact = load * length;
    assert!(
        (weight / exact - 1.0).abs() < 1e-6,
        "the root carries the weight"
    );
}

fn inflated(around: usize, through: usize, inner: f64, outer: f64, growth: f64) -> (f64, f64) {
    let mesh = shell_octant(inner, outer, around, through);
    let inside = mesh.nodes_where(|p| p.norm() < inner * (1.0 + 1e-6));
    let motion = |x: &Vec3, t: f64| x * (growth * t);
    let mut holds = vec![Hold::moved(inside, motion)];
    for axis in 0..3 {
        holds.push(Hold::sliding(
            mesh.nodes_where(|p| p[axis].abs() < 1e-9),
            axis,
        ));
    }
    // The inner side's hold comes last, because at nodes with several holds the last one counts.
    holds.rotate_left(1);
    let done = solve(&unloaded(&mesh, tissue(0.45), holds));
    let skin = mesh.nodes_where(|p| p.norm() > outer * (1.0 - 1e-6));
    let out = |&n: &u32| done.displacement_m[n as usize].dot(&mesh.nodes[n as usize].normalize());
    (
        skin.iter().map(out).sum::<f64>() / skin.len() as f64,
        done.energy_j,
    )
}

/// Lamé's thick sphere at small strain, and the order of convergence towards his solution.
#[test]
fn a_thick_sphere_inflates_as_lame_predicts() {
    let (a, b, growth) = (0.01, 0.02, 1e-5);
    let m = tissue(0.45);
    let lame = m.lambda_pa() - m.mu_pa();
    // u = A r + B / r²; σ_r(b) = (3λ₀ + 2μ) A − 4 μ B / b³ = 0.
    let k = (3.0 * lame + 2.0 * m.mu_pa()) / (4.0 * m.mu_pa()) * b * b * b;
    let slope = growth * a / (a + k / (a * a));
    let exact = slope * (b + k / (b * b));
    let error = |n: usize| (inflated(n, n, a, b, growth).0 / exact - 1.0).abs();
    let (coarse, fine) = (error(2), error(4));
    println!(
        "thick sphere: {coarse:.2e}, {fine:.2e} off Lamé; order {:.2}",
        (coarse / fine).log2()
    );
    assert!(
        fine < 1e-3 && coarse / fine > 7.0,
        "{coarse:.2e} {fine:.2e}"
    );
}

/// At 60 % inner growth, the result is compared with the radial equation, integrated independently.
#[test]
fn a_thick_sphere_inflates_far_as_the_radial_equation_predicts() {
    let (a, b, growth) = (0.01, 0.02, 0.6);
    let m = tissue(0.45);
    let (mu, lambda, gamma) = (m.mu_pa(), m.lambda_pa(), m.gamma());
    // A state has r, the nominal radial stress P, and the energy. dP/dR = −2 (P − T)/R, where T is
    // the nominal tangential stress.
    let rate = |radius: f64, [r, p, _]: [f64; 3]| {
        let hoop = r / radius;
        let radial = (p + lambda * gamma * hoop * hoop) / (mu + lambda * hoop.powi(4));
        let volume = lambda * (radial * hoop * hoop - gamma);
        let tangential = mu * hoop + volume * radial * hoop;
        let f = nalgebra::Matrix3::from_diagonal(&Vec3::new(radial, hoop, hoop));
        let octant = std::f64::consts::FRAC_PI_2 * radius * radius;
        [
            radial,
            -2.0 * (p - tangential) / radius,
            m.energy(&f) * octant,
        ]
    };
    let shoot = |pressure: f64| {
        let steps = 2000;
        let h = (b - a) / f64::from(steps);
        let mut y = [a * (1.0 + growth), pressure, 0.0];
        for i in 0..steps {
            let radius = a + h * f64::from(i);
            let to = |k: [f64; 3], by: f64| [0, 1, 2].map(|j| y[j] + by * k[j]);
            let k1 = rate(radius, y);
            let k2 = rate(radius + h / 2.0, to(k1, h / 2.0));
            let k3 = rate(radius + h / 2.0, to(k2, h / 2.0));
            let k4 = rate(radius + h, to(k3, h));
            y = [0, 1, 2].map(|j| y[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]));
        }
        y
    };
    let (mut low, mut high) = (-20.0 * m.young_pa, 0.0);
    for _ in 0..80 {
        let middle = (low + high) / 2.0;
        if shoot(middle)[1] < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let [radius, _, energy] = shoot((low + high) / 2.0);
    let (moved, stored) = inflated(3, 4, a, b, growth);
    let errors = (moved / (radius - b) - 1.0, stored / energy - 1.0);
    println!(
        "inflated by 60 %: outer displacement {:+.2e}, energy {:+.2e}",
        errors.0, errors.1
    );
    assert!(errors.0.abs() < 2e-3 && errors.1.abs() < 2e-3, "{errors:?}");
}
