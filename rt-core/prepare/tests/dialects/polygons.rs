//! Faces with many corners: concave, with a hole, with corners in a straight line.

use proptest::prelude::*;

use super::{measured, read_as};

/// A prism of 10 mm over a polygon, as an OBJ and a PLY file. Each cap is one face.
fn prism(rim: &[[f64; 2]]) -> [(&'static str, String); 2] {
    let count = rim.len();
    let vertices: Vec<String> = [0, 10]
        .iter()
        .flat_map(|z| rim.iter().map(move |[x, y]| format!("{x} {y} {z}")))
        .collect();
    let mut faces: Vec<Vec<usize>> = vec![(0..count).rev().collect(), (count..2 * count).collect()];
    for i in 0..count {
        let j = (i + 1) % count;
        faces.push(vec![i, j, j + count, i + count]);
    }
    let list = |face: &[usize], from: usize| {
        let numbers = face.iter().map(|i| (i + from).to_string());
        numbers.collect::<Vec<_>>().join(" ")
    };
    let mut obj: String = vertices.iter().map(|v| format!("v {v}\n")).collect();
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list int int vertex_indices\nend_header\n{}\n",
        vertices.len(),
        faces.len(),
        vertices.join("\n")
    );
    for face in &faces {
        obj += &format!("f {}\n", list(face, 1));
        ply += &format!("{} {}\n", face.len(), list(face, 0));
    }
    [("prism.obj", obj), ("prism.ply", ply)]
}

/// Volume, mm³, and area, mm², of the prism over a polygon in millimetres.
fn expected(rim: &[[f64; 2]]) -> [f64; 2] {
    let next = |i: usize| rim[(i + 1) % rim.len()];
    let (mut area, mut length) = (0.0, 0.0);
    for (i, [x, y]) in rim.iter().enumerate() {
        let [u, v] = next(i);
        area += (x * v - u * y) / 2.0;
        length += libm::hypot(u - x, v - y);
    }
    [area * 10.0, 2.0 * area + 10.0 * length]
}

fn assert_is_exact(rim: &[[f64; 2]]) {
    let [volume, surface] = expected(rim);
    for (name, text) in prism(rim) {
        let mesh = read_as(name, text.as_bytes()).expect(name);
        assert_eq!(
            mesh.triangles.len(),
            4 * rim.len() - 4,
            "every corner is used"
        );
        let [v, s] = measured(&mesh);
        let close = (v as f64 - volume).abs() < 1.0 && (s as f64 - surface).abs() < 1.0;
        assert!(close, "{name}: {v} of {volume} mm3, {s} of {surface} mm2");
    }
}

#[test]
fn letters_keep_their_gaps() {
    let c = [
        [0.0, 0.0],
        [60.0, 0.0],
        [60.0, 20.0],
        [20.0, 20.0],
        [20.0, 40.0],
        [60.0, 40.0],
        [60.0, 60.0],
        [0.0, 60.0],
    ];
    assert_is_exact(&c);
    // A face may begin with any of its corners.
    for first in 0..c.len() {
        assert_is_exact(&[&c[first..], &c[..first]].concat());
    }
    let arrow = [[0.0, 0.0], [40.0, 20.0], [0.0, 40.0], [10.0, 20.0]];
    assert_is_exact(&arrow);
    assert_is_exact(&[arrow[3], arrow[0], arrow[1], arrow[2]]);
}

/// A corner in a straight line with its neighbours stays, because an edge of the next face ends
/// there.
#[test]
fn corners_in_a_straight_line_stay() {
    let side = |from: [f64; 2], to: [f64; 2]| {
        (0..4).map(move |i| {
            let share = f64::from(i) / 4.0;
            [0, 1].map(|k| from[k] + share * (to[k] - from[k]))
        })
    };
    let square = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]];
    let rim: Vec<[f64; 2]> = (0..4)
        .flat_map(|i| side(square[i], square[(i + 1) % 4]))
        .collect();
    assert_is_exact(&rim);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn stars_of_any_shape_are_exact(radii in prop::collection::vec(5.0f64..40.0, 4..40)) {
        let turn = std::f64::consts::TAU / radii.len() as f64;
        let rim: Vec<[f64; 2]> = radii
            .iter()
            .enumerate()
            .map(|(i, r)| [r * libm::cos(i as f64 * turn), r * libm::sin(i as f64 * turn)])
            .collect();
        assert_is_exact(&rim);
    }
}

/// A bridge cuts a face with a hole open. The bridge's corners occur twice.
#[test]
fn a_hole_cut_in_by_a_bridge_stays_a_hole() {
    let outer = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]];
    let inner = [[10.0, 10.0], [10.0, 30.0], [30.0, 30.0], [30.0, 10.0]];
    let mut text = String::new();
    for z in [0, 10] {
        for [x, y] in outer.iter().chain(&inner) {
            text += &format!("v {x} {y} {z}\n");
        }
    }
    text += "f 1 5 8 7 6 5 1 4 3 2\nf 9 10 11 12 9 13 14 15 16 13\n";
    for [a, b] in [
        [1, 2],
        [2, 3],
        [3, 4],
        [4, 1],
        [5, 6],
        [6, 7],
        [7, 8],
        [8, 5],
    ] {
        text += &format!("f {a} {b} {} {}\n", b + 8, a + 8);
    }
    let mesh = read_as("hole.obj", text.as_bytes()).unwrap();
    assert_eq!(measured(&mesh), [12_000, 4_800]);
}
