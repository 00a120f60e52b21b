//! The fuzz targets' bodies on bytes that proptest makes up: random bytes, and small files with
//! random damage.

use proptest::prelude::*;
use scene_prepare::recipe::{BUILT_IN, TRIANGLE};

#[path = "../fuzz/bodies/mesh.rs"]
mod mesh;
#[path = "../fuzz/bodies/recipe.rs"]
mod recipe;

const OBJ: &str = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const STL: &str = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex .1 0 0\n\
    vertex 0 .1 0\nendloop\nendfacet\nendsolid x\n";
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],
    "max":[1,1,1]}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]}"#;

/// A long run of the fuzzer found this case: the glTF crate indexed an empty list of accessors.
#[test]
fn positions_that_do_not_exist_are_refused() {
    let text = GLTF.replace("\"accessors\":[{", "\"accesors\":[{");
    assert_ne!(text, GLTF);
    mesh::read(&[&[3], text.as_bytes()].concat());
}

/// The text with bytes overwritten, inserted or removed, or with its end cut off.
fn damaged(text: &str, edits: &[(usize, u8, u8)]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for &(at, kind, value) in edits {
        let at = at % (bytes.len() + 1);
        match kind % 4 {
            0 if at < bytes.len() => bytes[at] = value,
            1 => bytes.insert(at, value),
            2 if at < bytes.len() => drop(bytes.remove(at)),
            3 if value < 16 => bytes.truncate(at),
            // Insert a digit, because it may change a count.
            _ => bytes.insert(at, b'0' + value % 10),
        }
    }
    bytes
}

fn edits() -> impl Strategy<Value = Vec<(usize, u8, u8)>> {
    prop::collection::vec((any::<usize>(), any::<u8>(), any::<u8>()), 0..12)
}

proptest! {
    #[test]
    fn recipe_of_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        recipe::read(&bytes);
    }

    #[test]
    fn recipe_with_damage(edits in edits(), triangle in any::<bool>()) {
        recipe::read(&damaged(if triangle { TRIANGLE } else { BUILT_IN }, &edits));
    }

    #[test]
    fn mesh_of_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        mesh::read(&bytes);
    }

    #[test]
    fn mesh_with_damage(edits in edits(), format in 0usize..4) {
        let text = [OBJ, STL, PLY, GLTF][format];
        mesh::read(&[&[format as u8], damaged(text, &edits).as_slice()].concat());
    }
}

/// Reads the files that the fuzzer kept because they reached new code.
#[test]
fn the_corpus_is_read_or_refused() {
    for (target, read) in [("mesh", mesh::read as fn(&[u8])), ("recipe", recipe::read)] {
        let folder = format!("{}/fuzz/seeds/{target}", env!("CARGO_MANIFEST_DIR"));
        let files = std::fs::read_dir(folder).unwrap();
        let count = files
            .map(|file| read(&std::fs::read(file.unwrap().path()).unwrap()))
            .count();
        assert!(count > 5, "{count} {target} files");
    }
}
