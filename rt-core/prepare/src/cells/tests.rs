use proptest::prelude::*;

use super::*;
use crate::shape;

/// Four layers of cells of 2 mm.
const PLAN: Layers = Layers {
    around: String::new(),
    count: 4,
    cell_m: 0.002,
};

/// A bent bar along x with round ends and bumps on its surface. Its centre line is
/// `y = bend_per_m · x²`, `half_m` long on each side, and its bumps are at most `lump_m` high.
fn bar(half_m: f64, radius_m: f64, bend_per_m: f64, lump_m: f64) -> Mesh {
    let distance = move |p: &Vec3| {
        let x = p.x.clamp(-half_m, half_m);
        let middle = Vec3::new(x, bend_per_m * x * x, 0.0);
        let lumps = libm::sin(700.0 * p.x) * libm::cos(900.0 * p.y) * libm::sin(800.0 * p.z);
        (p - middle).norm() - radius_m - lump_m * lumps
    };
    // Bounds with a margin of 4 mm around the surface.
    let reach = radius_m + 0.004;
    let [low, high] = [-1.0, 1.0].map(|s| Vec3::new(s * (half_m + reach), 0.0, s * reach));
    let bend = bend_per_m * half_m * half_m;
    let bounds = [
        low - Vec3::y() * (reach + (-bend).max(0.0)),
        high + Vec3::y() * (reach + bend.max(0.0)),
    ];
    shape::skin(&distance, bounds, 0.0015)
}

#[test]
fn volume_shape_and_faces_of_a_box_are_as_computed_by_hand() {
    let p: [Vec3; 8] = std::array::from_fn(|i| {
        let at = |bit: usize, m: f64| if i >> bit & 1 == 1 { m } else { 0.0 };
        Vec3::new(at(0, 1.0), at(1, 2.0), at(2, 3.0))
    });
    assert!((hexa::volume_m3(&p) - 6.0).abs() < 1e-12);
    assert!((hexa::shape(&p) - 1.0).abs() < 1e-12);
    assert!(hexa::holds(&p, &Vec3::new(0.9, 1.9, 2.9)));
    assert!(!hexa::holds(&p, &Vec3::new(0.9, 2.1, 2.9)));
    // The corners of a face run counter-clockwise as seen from outside.
    for (face, corners) in hexa::FACES.iter().enumerate() {
        let [a, b, c, d] = corners.map(|i| p[i]);
        let middle = (a + b + c + d) / 4.0 - Vec3::new(0.5, 1.0, 1.5);
        assert!((c - a).cross(&(d - b)).dot(&middle) > 0.0, "{face}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// No cell is flat, the cells fill the space between an inner and an outer bar, and each cell
    /// is a neighbour of its neighbours.
    #[test]
    fn cells_fill_the_tissue_around_a_bar(
        radius_m in 0.004f64..0.010, bend_per_m in -8.0f64..8.0, lump_m in 0.0f64..0.0008,
        half_m in 0.008f64..0.02,
    ) {
        let own = bar(half_m, radius_m, bend_per_m, lump_m);
        let around = bar(half_m + 0.01, 0.002, bend_per_m, 0.0);
        let cells = Cells::new(&own, &around, &PLAN);
        let filling = cells.filling(&own, PLAN.cell_m);
        prop_assert!(filling.shape_min > 0.0, "{filling:?}");
        prop_assert!((filling.volume_share - 1.0).abs() < 0.06, "{filling:?}");
        prop_assert!(filling.covered > 0.9, "{filling:?}");
        for (i, neighbours) in cells.neighbours.iter().enumerate() {
            for (face, next) in neighbours.iter().enumerate() {
                if let Some(next) = next {
                    let back = cells.neighbours[*next as usize][hexa::opposite(face)];
                    prop_assert_eq!(back, Some(i as u32));
                }
            }
        }
    }
}
