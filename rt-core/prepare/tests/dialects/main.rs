//! Mesh files in the dialects of real programs, written by the tests. Every dialect gives the right
//! surface, or is refused with the cause.

mod gltf;
mod obj;
mod ply;
mod polygons;
mod stl;

use scene_prepare::error::MeshProblem;
use scene_prepare::mesh::{Mesh, mend, read};
use scene_prepare::recipe::Closing;

/// Corners of a cube of 40 mm, in millimetres: 64 mL.
const CORNERS: [[i32; 3]; 8] = [
    [0, 0, 0],
    [40, 0, 0],
    [40, 40, 0],
    [0, 40, 0],
    [0, 0, 40],
    [40, 0, 40],
    [40, 40, 40],
    [0, 40, 40],
];

/// Sides of the cube, anticlockwise seen from outside.
const SIDES: [[u32; 4]; 6] = [
    [0, 3, 2, 1],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

fn triangles() -> Vec<[u32; 3]> {
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]];
    SIDES.iter().flat_map(halves).collect()
}

fn read_as(name: &str, content: &[u8]) -> Result<Mesh, MeshProblem> {
    read_parts(name, content, &[])
}

fn read_parts(name: &str, content: &[u8], parts: &[String]) -> Result<Mesh, MeshProblem> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("written");
    read(&path, parts)
}

/// Volume, mm³, and area, mm², of a mesh in millimetres, which must be closed.
fn measured(mesh: &Mesh) -> [i64; 2] {
    let mut metres = mesh.clone();
    for p in &mut metres.vertices {
        *p *= 1e-3;
    }
    let mended = mend(&metres, Closing::Refuse).expect("closed");
    [1e9 * mended.volume_m3, 1e6 * mended.mesh.area()].map(|x| x.round() as i64)
}

fn assert_is_cube(name: &str, content: &[u8]) {
    let mesh = read_as(name, content).unwrap_or_else(|problem| panic!("{name}: {problem}"));
    assert_eq!(measured(&mesh), [64_000, 9_600], "{name}");
    assert!(mesh.volume() > 0.0, "{name} keeps its winding");
}

/// Asserts that the file is refused with a message that has all of these words.
fn assert_refused(name: &str, content: &[u8], words: &[&str]) {
    let message = read_as(name, content).expect_err(name).to_string();
    for word in words {
        assert!(message.contains(word), "{name}: {message}");
    }
}
