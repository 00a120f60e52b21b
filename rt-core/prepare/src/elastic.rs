//! Links that carry load where tetrahedra do not, and the number of an organ's substeps.

use std::f64::consts::PI;

use crate::links;
use crate::order;
use crate::pack::Ball;
use crate::recipe::Material;
use crate::tetra::Tetra;

/// One control period, s.
pub(crate) const TICK_S: f64 = 0.001;
/// Stiffness number `E dt² / (ρ h²)` of a substep that the chosen number of substeps keeps, except
/// in tubes. Up to it, one pass over links gives the material's stiffness within 3 %. An organ that
/// would need more than [`SUBSTEPS_MAX`] substeps exceeds it.
pub(crate) const STIFFNESS_NUMBER_MAX: f64 = 0.2;
/// Stiffness number that substeps of tubes keep. The core knows the compliance that one pass adds
/// to the links of a tube, and leaves it out (`one_pass`). Up to this number, the stiffness is then
/// right within 3 %.
pub(crate) const TUBE_STIFFNESS_NUMBER_MAX: f64 = 2.4;
/// A tube with a larger number has the force of a tube with this one
/// (`a_tube_that_is_too_stiff_is_softer_and_rests`).
pub(crate) const TUBE_STIFFNESS_LIMIT: f64 = 2.5;
/// Stiffness of the links of a sphere in an even tube, in `E A / s`, with the spacing `s`: half of
/// it for each of two short links, an eighth for each of two long ones.
pub(crate) const LINKS_OF_A_SPHERE: f64 = 1.25;
/// Preparation warns of an organ with tetrahedra whose stiffness number is larger. Tetrahedra have
/// their material's stiffness at any number. The larger the number, the less compression they bear
/// before they may invert: a cube at 0.3 can be squeezed to 30 % of its height, a cube at 0.6 to
/// 40 %.
pub(crate) const TETRA_STIFFNESS_NUMBER_MAX: f64 = 0.6;
/// Largest widening of a tube's cross-section beyond its spheres'. A tube whose spheres fill less
/// than half of it is no round tube.
const WIDENING_MAX: f64 = 2.0;
/// Largest number of substeps in a tick.
pub(crate) const SUBSTEPS_MAX: u32 = 16;

/// An organ's links in the order in which the solver walks them, and its substeps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Elastic {
    /// The links, first those that carry load. The second value is a link's compliance, m/N.
    pub(crate) links: Vec<([u32; 2], f64)>,
    /// Number of links that carry load.
    pub(crate) count: usize,
    /// Substeps in a tick. Tubes get theirs from `tube`.
    pub(crate) substeps: u32,
    /// Stiffness number of a substep.
    pub(crate) stiffness_number: f64,
}

/// Gives each link a compliance, and finds the links that carry load. Where tetrahedra join the
/// spheres, the tetrahedra alone carry load. Elsewhere links carry load: between pieces that
/// tetrahedra do not join, at spheres in no tetrahedron, and in tubes.
///
/// A link is a bar as thick as its thinner sphere: compliance `L / (E A)`, `A = π r²`.
///
/// A tube's cross-section is [`widening`] times its spheres'. Links to the next sphere (`steps`)
/// and links to the next but one each take half of the cross-section, so that a length `L` of the
/// tube stretches by `L / (E A)` per force. One short link (length `s`) and two long ones (`2 s`)
/// pass every cross-section, so their compliances are `2 s / (E A)` and `8 s / (E A)`. The long
/// links resist bending only to second order while the row is straight. A real tube has the
/// bending stiffness `E I`, `I = π r⁴ / 4`: 2e-6 N m² for the cystic duct. So 3 cm of it, clamped
/// at one end, bend by a millimetre under 0.2 mN, which no hand feels.
pub(crate) fn elastic(
    balls: &[Ball],
    links: &[[u32; 2]],
    steps: &[[u32; 2]],
    tets: &[Tetra],
    volume_m3: f64,
    material: &Material,
) -> Elastic {
    let edges: Vec<[u32; 2]> = tets.iter().flat_map(tetra_edges).collect();
    let (piece, _) = links::pieces(&edges, balls.len());
    let wider = match steps {
        [] => 1.0,
        _ => widening(balls, steps, volume_m3),
    };
    let compliance = |&[a, b]: &[u32; 2]| {
        let (a, b) = (&balls[a as usize], &balls[b as usize]);
        let radius_m = a.radius_m.min(b.radius_m);
        (a.center - b.center).norm() / (material.young_pa * PI * radius_m * radius_m * wider)
    };
    let share = |link: &[u32; 2]| match steps {
        [] => 1.0,
        _ if steps.contains(link) => 0.5,
        _ => 0.25,
    };
    let bears = |[a, b]: &[u32; 2]| piece[*a as usize] != piece[*b as usize];
    let with_compliance = |link: &[u32; 2]| (*link, compliance(link) / share(link));
    let (bearing, others): (Vec<[u32; 2]>, Vec<_>) = links.iter().partition(|link| bears(link));
    let spacing_m = if tets.is_empty() {
        let lengths = links
            .iter()
            .map(|&[a, b]| (balls[a as usize].center - balls[b as usize].center).norm());
        lengths.fold(f64::MAX, f64::min)
    } else {
        libm::cbrt(volume_m3 / balls.len() as f64)
    };
    let number =
        material.young_pa * TICK_S * TICK_S / (material.density_kg_m3 * spacing_m * spacing_m);
    let substeps = substeps(number);
    // A solver walks either the links that carry load or all links. So the links that carry load
    // and the others are ordered separately.
    let ordered = [&bearing, &others].map(|part| {
        let order = order::spread(part, balls.len()).into_iter();
        order.map(|i| with_compliance(&part[i]))
    });
    Elastic {
        count: bearing.len(),
        links: ordered.into_iter().flatten().collect(),
        substeps,
        stiffness_number: number / f64::from(substeps * substeps),
    }
}

/// Cross-section of a tube, as a multiple of its spheres'. The spheres lie inside the tube, and
/// are a little thinner. Each stands for a length of tube: half the way to each neighbour, and at
/// an end as much beyond it.
fn widening(balls: &[Ball], steps: &[[u32; 2]], volume_m3: f64) -> f64 {
    let mut reach = vec![(0.0, 0); balls.len()];
    for &[a, b] in steps {
        let half_m = (balls[a as usize].center - balls[b as usize].center).norm() / 2.0;
        for end in [a, b] {
            let (length_m, neighbours) = &mut reach[end as usize];
            *length_m += half_m;
            *neighbours += 1;
        }
    }
    let inside = balls
        .iter()
        .zip(&reach)
        .map(|(ball, (length_m, neighbours))| {
            let length_m = if *neighbours == 1 {
                2.0 * length_m
            } else {
                *length_m
            };
            PI * ball.radius_m * ball.radius_m * length_m
        });
    (volume_m3 / inside.sum::<f64>()).clamp(1.0, WIDENING_MAX)
}

/// Number of substeps for the stiffness number of a whole tick: the square root of this number over
/// [`STIFFNESS_NUMBER_MAX`], rounded up to a power of two, at most [`SUBSTEPS_MAX`]. With powers of
/// two, the substeps of organs that are attached to each other end at the same times.
fn substeps(stiffness_number: f64) -> u32 {
    let steps = (stiffness_number / STIFFNESS_NUMBER_MAX).sqrt().ceil();
    (steps as u32).clamp(1, SUBSTEPS_MAX).next_power_of_two()
}

fn tetra_edges(t: &Tetra) -> [[u32; 2]; 3] {
    let [a, b, c, d] = t.spheres;
    [[a, b], [a, c], [a, d]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use shared_mem::scene::OrganKind;

    #[test]
    fn one_step_while_soft_and_more_as_it_gets_stiff() {
        assert_eq!(substeps(0.0), 1);
        assert_eq!(substeps(0.2), 1);
        assert_eq!(substeps(0.21), 2);
        assert_eq!(substeps(1.7), 4);
        assert_eq!(substeps(3.0), 4);
        assert_eq!(substeps(1e9), SUBSTEPS_MAX);
    }

    /// A straight tube of 10 cm is stretched by a uniform strain `ε`. A cross-section in the middle
    /// carries the force `E A ε`.
    #[test]
    fn a_tube_stretches_by_its_cross_section() {
        let spacing_m = 0.005;
        let balls: Vec<Ball> = (0..21)
            .map(|i| Ball {
                center: Vec3::x() * (spacing_m * f64::from(i)),
                radius_m: 0.002,
            })
            .collect();
        let steps: Vec<[u32; 2]> = (0..20).map(|i| [i, i + 1]).collect();
        let line = crate::pack::Line {
            balls: balls.clone(),
            steps: steps.clone(),
        };
        let links = links::link_line(&line);
        let material = Material::typical(OrganKind::CysticDuct);
        let made = elastic(&balls, &links, &steps, &[], 1e-6, &material);
        assert_eq!(made.count, links.len());
        let strain = 0.01;
        let through_the_middle: f64 = made
            .links
            .iter()
            .filter(|([a, b], _)| *a.min(b) <= 10 && *a.max(b) >= 11)
            .map(|([a, b], compliance)| strain * spacing_m * f64::from(a.abs_diff(*b)) / compliance)
            .sum();
        let expected = material.young_pa * PI * 0.002 * 0.002 * strain;
        assert!(
            (through_the_middle / expected - 1.0).abs() < 1e-9,
            "{through_the_middle} N, {expected} N"
        );
    }

    #[test]
    fn only_what_no_tetrahedron_joins_bears() {
        let ball = |x, y, z| Ball {
            center: Vec3::new(x, y, z) * 0.01,
            radius_m: 0.005,
        };
        let balls = [
            ball(0.0, 0.0, 0.0),
            ball(1.0, 0.0, 0.0),
            ball(0.0, 1.0, 0.0),
            ball(0.0, 0.0, 1.0),
            ball(2.0, 0.0, 0.0),
        ];
        let tet = Tetra {
            spheres: [0, 1, 2, 3],
            volume_m3: 1e-6,
        };
        let links = [[0, 1], [1, 2], [1, 4]];
        let material = Material::typical(OrganKind::Liver);
        let made = elastic(&balls, &links, &[], &[tet], 1e-6, &material);
        assert_eq!(made.count, 1);
        let (first, compliance) = made.links[0];
        assert_eq!(first, [1, 4]);
        let expected = 0.01 / (5400.0 * PI * 25e-6);
        assert!((compliance / expected - 1.0).abs() < 1e-12);
        assert_eq!(elastic(&balls, &links, &[], &[], 1e-6, &material).count, 3);
    }
}
