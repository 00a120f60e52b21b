//! Packing of spheres: a box with known depths, and random blobs.

use proptest::prelude::*;
use scene_prepare::mesh::mend;
use scene_prepare::pack::{Interior, Quality, isotropy, pack_as_paper, pack_evenly};
use scene_prepare::recipe::Closing;
use scene_prepare::{Vec3, bind, links};
use shared_mem::scene::WEIGHT_SUM;

/// Eq. 1 by hand: in a box of 2 × 4 × 6 cm, the middle is 1 cm from the nearest side, and a point 3
/// mm from a side has D = 3 mm.
#[test]
fn equation_1_by_hand() {
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let mesh = scene_prepare::mesh::Mesh {
        vertices: (0..8)
            .map(|i| {
                let step = |bit: usize, size: f64| size * (i >> bit & 1) as f64;
                Vec3::new(step(0, 0.02), step(1, 0.04), step(2, 0.06))
            })
            .collect(),
        triangles: sides
            .iter()
            .flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]])
            .collect(),
    };
    let interior = Interior::new(&mesh, mesh.volume(), 40).unwrap();
    let cases = [
        ([0.01, 0.02, 0.03], 0.01),
        ([0.01, 0.003, 0.03], 0.003),
        ([0.01, 0.02, 0.0599], 0.0001),
    ];
    for (center, expected) in cases {
        assert!(
            (interior.depth(&Vec3::from(center)) - expected).abs() < 1e-8,
            "{center:?}"
        );
    }
    assert!(
        (interior.depth(&Vec3::new(0.01, 0.02, 0.065)) + 0.005).abs() < 1e-8,
        "outside is negative"
    );
    let ball = interior.inscribed(Vec3::new(0.01, 0.02, 0.03), f64::INFINITY);
    assert!((ball.radius_m - 0.01).abs() < 1e-8);
}

#[test]
fn links_join_overlapping_balls_and_reach_a_far_one() {
    use scene_prepare::pack::Ball;
    // A row of overlapping balls and one far away.
    let at = |x: f64| Ball {
        center: Vec3::new(x, 0.0, 0.0),
        radius_m: 0.6,
    };
    let mut balls: Vec<Ball> = (0..12).map(|i| at(f64::from(i))).collect();
    balls.push(at(30.0));
    let list = links::link(&balls);
    let (_, pieces) = links::pieces(&list, balls.len());
    assert_eq!(pieces, 1);
    for i in 0..12u32 {
        let degree = list.iter().flatten().filter(|&&j| j == i).count();
        assert!(degree >= 3, "{i} has {degree}");
    }
    // Neighbours overlap, so they are linked.
    assert!((0..11).all(|i| list.contains(&[i, i + 1])));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// In random blobs, spheres lie inside, links join them in one piece with at least three links
    /// each, and the weights of a vertex have the right sum.
    #[test]
    fn blobs_are_packed_soundly(
        lumps in prop::collection::vec(
            ((-0.03f64..0.03), (-0.03f64..0.03), (-0.03f64..0.03), 0.008f64..0.03), 1..5),
        spheres in 8usize..220,
        paper in any::<bool>(),
    ) {
        let blob = |p: &Vec3| {
            let lump = |(x, y, z, r): &(f64, f64, f64, f64)| (p - Vec3::new(*x, *y, *z)).norm() - r;
            let nearest = lumps.iter().map(lump).fold(f64::INFINITY, f64::min);
            // A core joins lumps that would not meet.
            nearest.min(p.norm() - 0.02)
        };
        let bounds = [Vec3::repeat(-0.065), Vec3::repeat(0.065)];
        let mended = mend(&scene_prepare::shape::skin(&blob, bounds, 0.004), Closing::Auto).unwrap();
        let interior = Interior::new(&mended.mesh, mended.volume_m3, spheres).unwrap();
        let balls = if paper { pack_as_paper(&interior, spheres) } else { pack_evenly(&interior, spheres) };
        prop_assert!(balls.len() >= 4 && balls.len() <= spheres);
        let quality = Quality::measure(&interior, &mended.mesh, &balls);
        prop_assert!(quality.protrusion_max_m < 0.02 * interior.spacing_m, "{quality:?}");
        let list = links::link(&balls);
        prop_assert_eq!(links::pieces(&list, balls.len()).1, 1);
        let mut degree = vec![0; balls.len()];
        for &i in list.as_flattened() {
            degree[i as usize] += 1;
        }
        prop_assert!(degree.iter().all(|&d| d >= 3));
        prop_assert!((0.0..=1.0).contains(&isotropy(&balls, &list)));
        for v in bind::bind(&mended.mesh, &balls, 0) {
            prop_assert_eq!(v.weights.iter().map(|&w| u32::from(w)).sum::<u32>(), WEIGHT_SUM);
            prop_assert!(v.spheres.iter().all(|&s| usize::from(s) < balls.len()));
        }
    }
}
