//! Mending of meshes like those from scans and exporters: open, inside out, non-manifold, hollow,
//! contradictory.

use proptest::prelude::*;
use scene_prepare::Vec3;
use scene_prepare::error::MeshProblem;
use scene_prepare::mesh::{Mesh, mend};
use scene_prepare::recipe::Closing;
use scene_prepare::shape::skin;

/// A box, oriented outward, with its lowest corner at `low`, m.
fn cuboid(low: [f64; 3], size: [f64; 3]) -> Mesh {
    let corner = |i: usize| {
        let step = [i & 1, i >> 1 & 1, i >> 2];
        Vec3::from(std::array::from_fn(|k| low[k] + size[k] * step[k] as f64))
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Mesh {
        vertices: (0..8).map(corner).collect(),
        triangles: sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

fn unit_box() -> Mesh {
    cuboid([0.0; 3], [0.1; 3])
}

fn ball(radius: f64, edge: f64) -> Mesh {
    let bounds = [Vec3::repeat(-1.1 * radius), Vec3::repeat(1.1 * radius)];
    skin(&|p: &Vec3| p.norm() - radius, bounds, edge)
}

#[test]
fn inside_out_box_is_turned() {
    let mut mesh = unit_box();
    for t in &mut mesh.triangles {
        t.swap(0, 1);
    }
    assert!(mesh.volume() < 0.0);
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    assert!((mended.volume_m3 - 1e-3).abs() < 1e-9);
    assert!(
        mended.to_string().contains("inside-out surface turned"),
        "{mended}"
    );
}

#[test]
fn triangles_turned_at_random_are_made_to_agree() {
    let mut mesh = unit_box();
    for i in [1, 4, 5, 9] {
        mesh.triangles[i].swap(1, 2);
    }
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    assert!(mended.mesh.is_closed());
    assert!((mended.volume_m3 - 1e-3).abs() < 1e-9);
}

#[test]
fn open_box_is_closed_or_refused_as_asked() {
    let mut mesh = unit_box();
    mesh.triangles.truncate(10);
    match mend(&mesh, Closing::Refuse) {
        Err(MeshProblem::Open { loops: 1, edges: 4 }) => {}
        other => panic!("{other:?}"),
    }
    for closing in [Closing::Fill, Closing::Auto] {
        let mended = mend(&mesh, closing).unwrap();
        assert!(mended.mesh.is_closed());
        assert!(
            (mended.volume_m3 - 1e-3).abs() < 1e-9,
            "{}",
            mended.volume_m3
        );
        assert!(mended.to_string().contains("1 open loops closed"));
    }
}

#[test]
fn a_ball_with_two_large_holes_keeps_its_volume() {
    let mut mesh = ball(0.05, 0.004);
    let whole = mesh.volume();
    let keep = |t: &[u32; 3]| {
        let x = mesh.vertices[t[0] as usize].x;
        (-0.04..0.042).contains(&x)
    };
    let triangles = mesh.triangles.iter().filter(|t| keep(t)).copied().collect();
    mesh.triangles = triangles;
    let filled = mend(&mesh, Closing::Fill).unwrap();
    assert!(filled.mesh.is_closed());
    // The two caps that are cut off have 2.8 and 2.1 % of the ball's volume.
    let share = filled.volume_m3 / whole;
    assert!((0.93..0.97).contains(&share), "{share}");
    let wrapped = mend(&mesh, Closing::Wrap).unwrap();
    assert!(wrapped.mesh.is_closed());
    let share = wrapped.volume_m3 / whole;
    assert!((0.92..1.02).contains(&share), "{share}");
}

#[test]
fn hollow_wall_with_an_opening_becomes_solid() {
    // The wall of a hollow ball. A hole at the top joins its inner side to its outer side.
    let wall = |p: &Vec3| {
        let shell = (p.norm() - 0.0485).abs() - 0.0015;
        let hole = (libm::hypot(p.x, p.y) - 0.003).max(-p.z);
        shell.max(-hole)
    };
    let bounds = [Vec3::repeat(-0.055), Vec3::repeat(0.055)];
    let mesh = skin(&wall, bounds, 0.0025);
    let full = 4.0 / 3.0 * std::f64::consts::PI * 0.05f64.powi(3);
    assert!(mesh.volume() < 0.5 * full, "the ball is hollow");
    let auto = mend(&mesh, Closing::Auto).unwrap();
    assert!(auto.to_string().contains("hollow made solid"), "{auto}");
    let said = auto.filled().unwrap();
    assert!(said.contains("--closing"), "{said}");
    assert_eq!(mend(&mesh, Closing::Fill).unwrap().filled(), None);
    let solid = mend(&mesh, Closing::Solid).unwrap();
    assert_eq!(solid.mesh, auto.mesh);
    assert!(solid.mesh.is_closed());
    assert!(
        (0.95..1.03).contains(&(solid.volume_m3 / full)),
        "{}",
        solid.volume_m3 / full
    );
}

#[test]
fn wall_that_crosses_the_box_is_wrapped() {
    // The added wall makes edges with three triangles.
    let mut mesh = unit_box();
    mesh.vertices.push(Vec3::new(0.05, 0.05, 0.05));
    mesh.triangles.push([0, 1, 8]);
    assert!(matches!(
        mend(&mesh, Closing::Fill),
        Err(MeshProblem::NonManifold { .. })
    ));
    let wrapped = mend(&mesh, Closing::Auto).unwrap();
    assert!(wrapped.mesh.is_closed());
    assert!(
        (0.9..1.1).contains(&(wrapped.volume_m3 / 1e-3)),
        "{}",
        wrapped.volume_m3
    );
}

/// Two boxes of a litre each share a quarter of a litre: together they have 1.75 L, not 2 L.
#[test]
fn what_overlaps_itself_is_merged_or_refused_with_the_place() {
    let mut mesh = unit_box();
    mesh.append(&cuboid([0.075, 0.0, 0.0], [0.1; 3]));
    let refused = mend(&mesh, Closing::Refuse).unwrap_err();
    let MeshProblem::Overlaps { percent, at_m } = refused else {
        panic!("{refused}")
    };
    assert!((percent - 100.0 * 0.25 / 1.75).abs() < 0.5, "{percent}");
    assert!((at_m[0] - 0.0875).abs() < 1e-3, "{at_m:?}");
    let mended = mend(&mesh, Closing::Auto).unwrap();
    assert!(mended.to_string().contains("overlaps itself"), "{mended}");
    assert!(mended.mesh.is_closed() && mended.gaps_m().is_empty());
    assert!(
        (mended.volume_m3 / 1.75e-3 - 1.0).abs() < 0.03,
        "{}",
        mended.volume_m3
    );
}

#[test]
fn separate_pieces_are_measured_and_can_be_dropped() {
    let mut mesh = unit_box();
    mesh.append(&cuboid([0.13, 0.0, 0.0], [0.05; 3]));
    mesh.append(&cuboid([0.0, 0.0, 0.12], [0.04; 3]));
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    let gaps_mm: Vec<i64> = mended
        .gaps_m()
        .iter()
        .map(|gap| (1e3 * gap).round() as i64)
        .collect();
    assert_eq!(gaps_mm, [30, 20]);
    let largest = mended.largest_piece();
    assert!(largest.gaps_m().is_empty());
    assert!((largest.volume_m3 - 1e-3).abs() < 1e-9);
    assert!(
        largest
            .to_string()
            .contains("2 unwanted pieces dropped, 189 mL in all, the largest 125 mL"),
        "{largest}"
    );
}

/// Of two pieces that are equal up to rounding, the first is kept.
#[test]
fn the_first_of_equally_large_pieces_is_the_largest() {
    for more in [-1e-9, 0.0, 1e-9] {
        let mut mesh = unit_box();
        mesh.append(&cuboid([0.13, 0.0, 0.0], [0.1 + more; 3]));
        let largest = mend(&mesh, Closing::Refuse).unwrap().largest_piece();
        let [min, max] = largest.mesh.bounds();
        assert!(min.x.abs() < 1e-9 && (max.x - 0.1).abs() < 1e-9, "{more}");
    }
}

/// Two boxes share an edge, as voxels of a label map do. Both are oriented outward, or both inward.
#[test]
fn bodies_that_touch_along_an_edge_are_parted_and_keep_their_shape() {
    for turned in [false, true] {
        let mut mesh = unit_box();
        mesh.append(&cuboid([0.1, 0.1, 0.0], [0.1; 3]));
        if turned {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let mended = mend(&mesh, Closing::Refuse).unwrap();
        assert!(mended.mesh.is_closed(), "{mended}");
        assert!((mended.volume_m3 - 2e-3).abs() < 1e-9, "{mended}");
        assert_eq!(mended.mesh.triangles.len(), 24);
        let story = mended.to_string();
        assert!(
            story.contains("1 times an edge was split where bodies touched"),
            "{story}"
        );
        assert_eq!(story.contains("turned"), turned, "{story}");
        let gaps_m = mended.gaps_m();
        assert!(gaps_m.len() == 1 && gaps_m[0] < 1e-9, "{gaps_m:?}");
    }
}

/// One of the two bodies is inside out, as some exporters leave a mirrored part.
#[test]
fn bodies_that_touch_may_run_different_ways() {
    for turned in [0, 1] {
        let mut bodies = [unit_box(), cuboid([0.1, 0.1, 0.0], [0.2, 0.1, 0.1])];
        let inside_out = &mut bodies[turned];
        inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let [mut mesh, other] = bodies;
        mesh.append(&other);
        let mended = mend(&mesh, Closing::Refuse).unwrap();
        assert!((mended.volume_m3 - 3e-3).abs() < 1e-9, "{mended}");
        let story = mended.to_string();
        for part in ["1 times an edge was split", "1 inside-out surface turned"] {
            assert!(story.contains(part), "{story}");
        }
    }
}

/// Two boxes share one corner. The first, the second or none of them is inside out.
#[test]
fn bodies_that_touch_in_a_corner_are_oriented_each_by_itself() {
    for (turned, size_m) in [(0, 0.1), (1, 0.1), (0, 0.2), (1, 0.2), (2, 0.1)] {
        let mut bodies = [unit_box(), cuboid([0.1; 3], [size_m; 3])];
        if let Some(inside_out) = bodies.get_mut(turned) {
            inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let [mut mesh, other] = bodies;
        mesh.append(&other);
        let mended = mend(&mesh, Closing::Refuse).unwrap();
        let volume_m3 = 1e-3 + size_m * size_m * size_m;
        assert!((mended.volume_m3 - volume_m3).abs() < 1e-9, "{mended}");
        assert_eq!(mended.mesh.triangles.len(), 24, "{mended}");
        let story = mended.to_string();
        let is_told = story.contains("1 inside-out surface turned");
        assert_eq!(is_told, turned < 2, "{story}");
    }
}

/// A cavity that touches the skin of its body in one corner counts as inside, whichever way its
/// triangles face.
#[test]
fn a_cavity_that_touches_the_skin_in_a_corner_is_filled() {
    for turned in [false, true] {
        let mut mesh = unit_box();
        let mut cavity = cuboid([0.0; 3], [0.06; 3]);
        for (i, p) in cavity.vertices.iter_mut().enumerate().skip(1) {
            *p += Vec3::from([0.01 + 1e-3 * (i & 1) as f64, 0.012, 0.011]);
        }
        if turned {
            cavity.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        mesh.append(&cavity);
        let mended = mend(&mesh, Closing::Refuse).unwrap();
        assert!((mended.volume_m3 - 1e-3).abs() < 1e-9, "{mended}");
        assert!(mended.to_string().contains("1 inner piece of"), "{mended}");
    }
}

/// A square sheet of 0.2 m with this height at each place, m.
fn sheet(height: impl Fn(f64, f64) -> f64) -> Mesh {
    const SIDE: u32 = 24;
    let mut mesh = Mesh::default();
    for i in 0..=SIDE {
        for j in 0..=SIDE {
            let [x, y] = [i, j].map(|k| 0.2 * (f64::from(k) / f64::from(SIDE) - 0.5));
            mesh.vertices.push(Vec3::new(x, y, height(x, y)));
        }
    }
    let at = |i: u32, j: u32| i * (SIDE + 1) + j;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A lid on a curved sheet crosses the sheet in places, and would enclose bodies that nobody
/// modelled.
#[test]
fn an_open_sheet_is_called_one_and_a_bowl_is_not() {
    let saddle = sheet(|x, y| 3.0 * (x * x - y * y));
    let wave = sheet(|x, y| 0.02 * libm::sin(31.4 * x) * libm::cos(31.4 * y));
    let flat_dish = sheet(|x, y| 0.2 * (x * x + y * y));
    for mesh in [saddle, wave, flat_dish] {
        let error = mend(&mesh, Closing::Auto).unwrap_err();
        assert!(matches!(error, MeshProblem::Sheet { .. }), "{error}");
        assert!(error.to_string().contains("Solidify"), "{error}");
    }
    let bowl = mend(&sheet(|x, y| 6.0 * (x * x + y * y)), Closing::Auto).unwrap();
    assert!(bowl.to_string().contains("1 open loops closed"), "{bowl}");
}

/// A cavity of a dropped piece does not count as a cavity of the piece that is kept.
#[test]
fn cavities_of_dropped_pieces_are_forgotten() {
    let mut mesh = unit_box();
    mesh.append(&cuboid([0.2, 0.0, 0.0], [0.09; 3]));
    mesh.append(&cuboid([0.21, 0.01, 0.01], [0.07; 3]));
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    assert!(
        mended.to_string().contains("1 inner piece of 343 mL"),
        "{mended}"
    );
    let largest = mended.largest_piece();
    assert_eq!(largest.filled(), None, "{largest}");
    assert!(!largest.to_string().contains("inner"), "{largest}");
    let mut hollow = unit_box();
    hollow.append(&cuboid([0.02; 3], [0.06; 3]));
    hollow.append(&cuboid([0.2, 0.0, 0.0], [0.09; 3]));
    let largest = mend(&hollow, Closing::Refuse).unwrap().largest_piece();
    assert!(largest.filled().unwrap().contains("216 mL"), "{largest}");
}

/// The result must not depend on which vertex of a body comes first, or on whether this vertex lies
/// in the other body.
#[test]
fn bodies_that_overlap_are_joined_and_none_is_dropped() {
    for x in [0.08, -0.08, 0.0999] {
        for (y, size) in [(0.0, 0.1), (0.01, 0.08)] {
            let mut mesh = unit_box();
            mesh.append(&cuboid([x, y, y], [0.1, size, size]));
            let mended = mend(&mesh, Closing::Auto).unwrap();
            let common = (0.1f64 - x.abs()) * size * size;
            let union_m3 = 1e-3 + 0.1 * size * size - common;
            let error = mended.volume_m3 / union_m3 - 1.0;
            assert!(error.abs() < 0.02, "{x} {y}: {error}, {mended}");
            assert_eq!(mended.filled(), None, "{mended}");
        }
    }
}

/// The triangles of a cavity face into the cavity, as they must. The report must not call them
/// inside out.
#[test]
fn a_cavity_is_not_called_inside_out() {
    let mut mesh = unit_box();
    let mut cavity = cuboid([0.02; 3], [0.06; 3]);
    cavity.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh.append(&cavity);
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    let said = mended.filled().unwrap();
    assert!(said.contains("216 mL within its inner surface"), "{said}");
    let story = mended.to_string();
    assert!(story.contains("1 inner piece of 216 mL dropped"), "{story}");
    assert!(!story.contains("turned"), "{story}");
}

#[test]
fn inner_wall_and_dust_are_dropped() {
    let mut mesh = unit_box();
    mesh.append(&cuboid([0.02; 3], [0.06; 3]));
    mesh.append(&cuboid([0.2; 3], [0.003; 3]));
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    assert_eq!(mended.mesh.triangles.len(), 12);
    let story = mended.to_string();
    for part in [
        "1 inner piece of 216 mL dropped",
        "1 tiny piece of 0.027 mL dropped",
    ] {
        assert!(story.contains(part), "{story}");
    }
    assert!(!story.contains("turned"), "{story}");
}

#[test]
fn duplicate_and_degenerate_triangles_are_dropped() {
    let mut mesh = unit_box();
    let again = mesh.triangles.clone();
    mesh.triangles
        .extend(again.iter().map(|[a, b, c]| [*b, *a, *c]));
    mesh.triangles.push([3, 3, 4]);
    let mended = mend(&mesh, Closing::Refuse).unwrap();
    assert_eq!(mended.mesh.triangles.len(), 12);
}

#[test]
fn what_cannot_be_mended_says_why() {
    let mut sheet = unit_box();
    sheet.triangles.truncate(2);
    let refused = mend(&sheet, Closing::Auto).unwrap_err();
    assert!(matches!(refused, MeshProblem::NoVolume { .. }), "{refused}");

    let mut broken = unit_box();
    broken.vertices[3].y = f64::NAN;
    assert_eq!(
        mend(&broken, Closing::Auto).unwrap_err(),
        MeshProblem::NotFinite { index: 3 }
    );

    let mut broken = unit_box();
    broken.triangles[7][1] = 99;
    let expected = MeshProblem::IndexOutOfRange {
        triangle: 7,
        vertex: 99,
        vertices: 8,
    };
    assert_eq!(mend(&broken, Closing::Auto).unwrap_err(), expected);

    assert_eq!(
        mend(&Mesh::default(), Closing::Auto).unwrap_err(),
        MeshProblem::NoTriangles
    );

    let millimetres = cuboid([0.0; 3], [100.0; 3]);
    let message = mend(&millimetres, Closing::Auto).unwrap_err().to_string();
    for part in [
        "is 100.0000 m across; allowed: 0.002 to 2 m",
        "look like millimetres",
        "set `unit`",
        "--unit",
    ] {
        assert!(message.contains(part), "{message}");
    }
    let metres = cuboid([0.0; 3], [1e-4; 3]);
    let message = mend(&metres, Closing::Auto).unwrap_err().to_string();
    assert!(message.contains("is 0.0001 m across"), "{message}");
    assert!(
        message.contains("metres that were read as millimetres"),
        "{message}"
    );

    // A Moebius band.
    let count = 24;
    let mut band = Mesh::default();
    for i in 0..count {
        let turn = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
        let across = Vec3::new(
            libm::cos(turn / 2.0) * libm::cos(turn),
            libm::cos(turn / 2.0) * libm::sin(turn),
            libm::sin(turn / 2.0),
        );
        let middle = Vec3::new(libm::cos(turn), libm::sin(turn), 0.0) * 0.1;
        band.vertices
            .extend([middle - across * 0.02, middle + across * 0.02]);
    }
    let count = count as u32;
    for i in 0..count {
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < count {
            (a + 2, b + 2)
        } else {
            (1, 0)
        };
        band.triangles.extend([[a, b, d], [a, d, c]]);
    }
    assert_eq!(
        mend(&band, Closing::Auto).unwrap_err(),
        MeshProblem::NotOrientable
    );
}

/// Of two nested shells, whichever way each faces, the outer one is the body.
#[test]
fn nested_shells_of_any_winding_are_the_outer_one() {
    for turned in 0..4 {
        let mut mesh = unit_box();
        mesh.append(&cuboid([0.02; 3], [0.06; 3]));
        for (i, t) in mesh.triangles.iter_mut().enumerate() {
            if turned >> (i / 12) & 1 == 1 {
                t.swap(1, 2);
            }
        }
        let mended = mend(&mesh, Closing::Auto).unwrap();
        assert!((mended.volume_m3 - 1e-3).abs() < 1e-9, "{turned}: {mended}");
    }
}

/// A figure of eight, swept around a circle with half a turn on the way: a closed surface without
/// an inside.
fn klein_bottle() -> Mesh {
    let (around, across) = (60u32, 31u32);
    let mut mesh = Mesh::default();
    for i in 0..around {
        let u = f64::from(i) / f64::from(around) * std::f64::consts::TAU;
        for j in 0..across {
            let v = f64::from(j) / f64::from(across) * std::f64::consts::TAU;
            let (sin, cos) = libm::sincos(u / 2.0);
            let out = 0.1 + 0.04 * (cos * libm::sin(v) - sin * libm::sin(2.0 * v));
            let up = 0.04 * (sin * libm::sin(v) + cos * libm::sin(2.0 * v));
            mesh.vertices
                .push(Vec3::new(out * libm::cos(u), out * libm::sin(u), up));
        }
    }
    let at = |i: u32, j: u32| {
        let j = j % across;
        if i < around {
            i * across + j
        } else {
            (across - j) % across
        }
    };
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

#[test]
fn closed_surface_without_sides_is_refused_and_its_remedy_works() {
    let bottle = klein_bottle();
    for closing in [Closing::Auto, Closing::Fill, Closing::Wrap, Closing::Refuse] {
        let refused = mend(&bottle, closing).unwrap_err();
        assert_eq!(refused, MeshProblem::NotOrientable);
        assert!(refused.to_string().contains("closing = \"solid\""));
    }
    let solid = mend(&bottle, Closing::Solid).unwrap();
    assert!(solid.mesh.is_closed() && solid.volume_m3 > 1e-4, "{solid}");
}

/// An extruded bow tie: whichever way its surface is oriented, half of the body is inside out.
#[test]
fn body_whose_halves_contradict_each_other_is_refused_and_its_remedy_works() {
    let mut mesh = cuboid([0.0; 3], [0.1; 3]);
    for i in [2, 6] {
        let (a, b) = (mesh.vertices[i], mesh.vertices[i + 1]);
        (mesh.vertices[i], mesh.vertices[i + 1]) = (b, a);
    }
    assert!(mesh.is_closed() && mesh.volume().abs() < 1e-9);
    let refused = mend(&mesh, Closing::Refuse).unwrap_err();
    assert!(matches!(refused, MeshProblem::NoVolume { .. }), "{refused}");
    assert!(refused.to_string().contains("closing = \"solid\""));
    let solid = mend(&mesh, Closing::Solid).unwrap();
    assert!(
        (0.4e-3..0.65e-3).contains(&solid.volume_m3),
        "{}",
        solid.volume_m3
    );
}

#[test]
fn thousands_of_pieces_are_refused_at_once_and_specks_are_not() {
    let mut many = Mesh::default();
    for i in 0..5_000u32 {
        let at = [i % 30, i / 30 % 30, i / 900].map(|k| 0.02 * f64::from(k));
        many.append(&cuboid(at, [0.01; 3]));
    }
    let refused = mend(&many, Closing::Auto).unwrap_err();
    let expected = MeshProblem::ManyPieces {
        count: 5_000,
        max: 256,
    };
    assert_eq!(refused, expected);
    many.append(&cuboid([-0.5; 3], [0.4; 3]));
    let mended = mend(&many, Closing::Auto).unwrap();
    assert!((mended.volume_m3 - 0.064).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    /// A ball with triangles deleted, repeated and turned and vertices moved is mended into a
    /// closed surface with a volume, or refused. It never panics.
    #[test]
    fn mutilated_balls_never_panic(
        edits in prop::collection::vec((0usize..4, 0usize..10_000, -0.004f64..0.004), 0..60),
        closing in prop::sample::select(vec![Closing::Auto, Closing::Fill, Closing::Solid]),
    ) {
        let mut mesh = ball(0.03, 0.006);
        for (what, at, by) in edits {
            let at_triangle = at % mesh.triangles.len();
            match what {
                0 => { mesh.triangles.swap_remove(at_triangle); }
                1 => mesh.triangles.push(mesh.triangles[at_triangle]),
                2 => mesh.triangles[at_triangle].swap(0, 2),
                _ => {
                    let i = at % mesh.vertices.len();
                    mesh.vertices[i].x += by;
                }
            }
        }
        if let Ok(mended) = mend(&mesh, closing) {
            prop_assert!(mended.mesh.is_closed());
            let full = 4.0 / 3.0 * std::f64::consts::PI * 0.03f64.powi(3);
            prop_assert!((0.5..1.3).contains(&(mended.volume_m3 / full)), "{}", mended.volume_m3 / full);
        }
    }
}
