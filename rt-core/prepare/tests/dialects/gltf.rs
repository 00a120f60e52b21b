//! Dialects of glTF.

use base64::Engine;
use scene_prepare::mesh::read;

use super::{CORNERS, assert_is_cube, assert_refused, measured, read_as, triangles};

/// Bytes of the cube's corners, in millimetres, then of its indices of 16 bits.
fn data() -> Vec<u8> {
    let corners = CORNERS.iter().flatten().map(|x| *x as f32);
    let mut bytes: Vec<u8> = corners.flat_map(f32::to_le_bytes).collect();
    let indices = triangles().into_flattened();
    bytes.extend(indices.iter().flat_map(|i| (*i as u16).to_le_bytes()));
    bytes
}

/// A glTF file with its data at `uri`. `positions` has fields of the positions' accessor, `root`
/// fields of the root.
fn file(uri: &str, positions: &str, root: &str) -> String {
    let length = data().len();
    format!(
        r#"{{"asset":{{"version":"2.0"}},{root},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{{positions},"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[40,40,40]}},
        {{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":96}},{{"buffer":0,"byteOffset":96,"byteLength":72}}],
        "buffers":[{{"byteLength":{length},"uri":"{uri}"}}]}}"#
    )
}

const SCENE: &str = r#""scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#;
const PLAIN: &str = r#""bufferView":0"#;

fn embedded() -> String {
    let text = base64::engine::general_purpose::STANDARD.encode(data());
    format!("data:application/octet-stream;base64,{text}")
}

#[test]
fn data_are_found_wherever_they_are() {
    assert_is_cube("plain.gltf", file(&embedded(), PLAIN, SCENE).as_bytes());
    let marked = format!("\u{feff}{}", file(&embedded(), PLAIN, SCENE));
    assert_is_cube("marked.gltf", marked.as_bytes());
    let percent: String = data().iter().map(|b| format!("%{b:02X}")).collect();
    let percent = format!("data:,{percent}");
    assert_is_cube("percent.gltf", file(&percent, PLAIN, SCENE).as_bytes());
    for (uri, name) in [
        ("my%20liver%20%C3%9C.bin", "my liver Ü.bin"),
        ("my liver.bin", "my liver.bin"),
        ("100%25.bin", "100%25.bin"),
        ("data/liver.bin", "data/liver.bin"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("data")).unwrap();
        std::fs::write(folder.path().join(name), data()).unwrap();
        let path = folder.path().join("liver.gltf");
        std::fs::write(&path, file(uri, PLAIN, SCENE)).unwrap();
        let mesh = read(&path, &[]).unwrap_or_else(|problem| panic!("{uri}: {problem}"));
        assert_eq!(measured(&mesh), [64_000, 9_600], "{uri}");
    }
    for uri in [
        "../liver.bin",
        "/etc/passwd",
        "%2e%2e/liver.bin",
        "a%5Cb.bin",
    ] {
        assert_refused("away.gltf", file(uri, PLAIN, SCENE).as_bytes(), &["folder"]);
    }
    let cut = embedded();
    let cut = file(&cut[..cut.len() - 8], PLAIN, SCENE);
    assert_refused("cut.gltf", cut.as_bytes(), &["truncated"]);
}

#[test]
fn files_without_a_scene_are_read() {
    for root in [
        r#""nodes":[{"mesh":0}]"#,
        r#""nodes":[{"children":[1]},{"mesh":0}]"#,
        r#""nodes":[]"#,
    ] {
        let root = root.replace(r#""nodes":[]"#, r#""extras":{}"#);
        assert_is_cube("library.gltf", file(&embedded(), PLAIN, &root).as_bytes());
    }
}

/// The fifth corner comes from a sparse list. Without a base, all other corners are zero.
#[test]
fn sparse_accessors_are_read() {
    let sparse = |place: u8, base: &str| {
        let mut bytes = data();
        for x in CORNERS[4] {
            bytes.extend((x as f32).to_le_bytes());
        }
        bytes.push(place);
        bytes[48..60].fill(0x55);
        let text = base64::engine::general_purpose::STANDARD.encode(&bytes);
        let positions = format!(
            r#"{base}"sparse":{{"count":1,"indices":{{"bufferView":3,"componentType":5121}},"values":{{"bufferView":2}}}}"#
        );
        let views = r#","byteLength":72},{"buffer":0,"byteOffset":168,"byteLength":12},{"buffer":0,"byteOffset":180,"byteLength":1}"#;
        file(&format!("data:;base64,{text}"), &positions, SCENE)
            .replace(r#","byteLength":72}"#, views)
            .replace(r#""byteLength":168"#, r#""byteLength":181"#)
    };
    let base = format!("{PLAIN},");
    assert_is_cube("sparse.gltf", sparse(4, &base).as_bytes());
    assert_refused(
        "outside.gltf",
        sparse(8, &base).as_bytes(),
        &["beyond its data"],
    );
    let zeros = read_as("zeros.gltf", sparse(4, "").as_bytes()).unwrap();
    let [low, high] = zeros.bounds();
    assert_eq!((low, high), ([0.0; 3].into(), [0.0, 0.0, 40.0].into()));
}

#[test]
fn extensions_about_pictures_are_no_obstacle_and_others_are_named() {
    let requiring = |name: &str| {
        let root =
            format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"],{SCENE}"#);
        file(&embedded(), PLAIN, &root)
    };
    for name in [
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "KHR_materials_unlit",
        "KHR_texture_transform",
    ] {
        assert_is_cube("texture.gltf", requiring(name).as_bytes());
    }
    for (name, option) in [
        ("KHR_draco_mesh_compression", "Data > Compression"),
        ("EXT_meshopt_compression", "-noq"),
        ("KHR_mesh_quantization", "-noq"),
        ("EXT_mesh_gpu_instancing", "gltfpack without -mi"),
        ("ACME_bent_triangles", "unknown here"),
    ] {
        assert_refused(
            "geometry.gltf",
            requiring(name).as_bytes(),
            &["uses the glTF extension", name, option],
        );
    }
    // The file does not list the extension as required, but has no data without it.
    let used = requiring("EXT_meshopt_compression")
        .replace(r#""extensionsRequired":["EXT_meshopt_compression"],"#, "")
        .replace(&format!(r#","uri":"{}""#, embedded()), "");
    assert_refused(
        "fallback.gltf",
        used.as_bytes(),
        &["EXT_meshopt_compression", "-noq"],
    );
}

/// The triangles of a mirrored node are turned, so that the surface faces outward.
#[test]
fn mirrored_nodes_keep_their_winding() {
    let root = SCENE.replace(r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[-1,1,1]}"#);
    let mesh = read_as("mirror.gltf", file(&embedded(), PLAIN, &root).as_bytes()).unwrap();
    assert_eq!(mesh.bounds()[0].x as i32, -40);
    assert!(mesh.volume() > 0.0);
    assert_eq!(measured(&mesh), [64_000, 9_600]);
}

/// A side of the cube has two triangles as a list, as a strip and as a fan.
#[test]
fn strips_and_fans_are_read() {
    for (mode, order, count) in [
        (4, [0, 1, 2, 2, 3, 0], 6),
        (5, [0, 1, 3, 2, 0, 0], 4),
        (6, [0, 1, 2, 3, 0, 0], 4),
    ] {
        let mut bytes = data()[..96].to_vec();
        bytes.extend(order.iter().flat_map(|i: &u16| i.to_le_bytes()));
        bytes.resize(168, 0);
        let text = base64::engine::general_purpose::STANDARD.encode(&bytes);
        let text = file(&format!("data:;base64,{text}"), PLAIN, SCENE)
            .replace(r#""indices":1"#, &format!(r#""indices":1,"mode":{mode}"#))
            .replace(r#""count":36"#, &format!(r#""count":{count}"#));
        let mesh = read_as("modes.gltf", text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles.len(), 2, "mode {mode}");
        assert!((mesh.area() - 1600.0).abs() < 1e-6, "mode {mode}");
        let normals = mesh.vertex_normals();
        assert!(normals.iter().all(|n| n.z > 0.99), "mode {mode}");
    }
}
