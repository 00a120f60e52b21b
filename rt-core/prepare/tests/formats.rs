//! Every mesh format that preparation reads, in tiny files that the tests write.

use std::path::{Path, PathBuf};

use scene_prepare::error::MeshProblem;
use scene_prepare::mesh::{Mesh, mend, read};
use scene_prepare::recipe::Closing;

/// Corners of a box of 0.1 × 0.2 × 0.3 m (6 L) at the origin, m.
const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [0.1, 0.0, 0.0],
    [0.1, 0.2, 0.0],
    [0.0, 0.2, 0.0],
    [0.0, 0.0, 0.3],
    [0.1, 0.0, 0.3],
    [0.1, 0.2, 0.3],
    [0.0, 0.2, 0.3],
];
/// Sides of the box, anticlockwise seen from outside.
const SIDES: [[u32; 4]; 6] = [
    [0, 3, 2, 1],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];

fn triangles() -> Vec<[u32; 3]> {
    SIDES
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect()
}

fn file(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("written");
    (folder, path)
}

fn read_bytes(name: &str, content: &[u8]) -> Result<Mesh, MeshProblem> {
    let (_folder, path) = file(name, content);
    read(&path, &[])
}

fn assert_is_box(mesh: &Mesh) {
    let mended = mend(mesh, Closing::Refuse).expect("closed");
    assert_eq!(
        (mended.mesh.vertices.len(), mended.mesh.triangles.len()),
        (8, 12)
    );
    assert!(mended.mesh.is_closed());
    assert!(
        (mended.volume_m3 - 0.006).abs() < 1e-8,
        "{}",
        mended.volume_m3
    );
}

fn obj() -> String {
    let mut text = String::from("# a box\no box\n");
    for [x, y, z] in CORNERS {
        text.push_str(&format!("v {x} {y} {z}\n"));
    }
    for side in SIDES {
        let [a, b, c, d] = side.map(|i| i + 1);
        text.push_str(&format!("f {a} {b} {c} {d}\n"));
    }
    text
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    let all = triangles();
    bytes.extend((all.len() as u32).to_le_bytes());
    for t in all {
        bytes.extend([0u8; 12]);
        for corner in t {
            bytes.extend(
                CORNERS[corner as usize]
                    .iter()
                    .flat_map(|x| x.to_le_bytes()),
            );
        }
        bytes.extend([0u8; 2]);
    }
    bytes
}

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex 8\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face 6\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

/// Name, corners and indices of a part of a GLB.
type Part<'a> = (&'a str, &'a [[f32; 3]], &'a [u32]);

/// A GLB with one node for each part.
fn glb(nodes: &[Part<'_>], translation: [f32; 3]) -> Vec<u8> {
    let mut data: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut meshes, mut list) = (vec![], vec![], vec![], vec![]);
    for (i, (name, corners, indices)) in nodes.iter().enumerate() {
        let start = data.len();
        data.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        let middle = data.len();
        data.extend(indices.iter().flat_map(|x| x.to_le_bytes()));
        let (vertex_bytes, index_bytes) = (middle - start, data.len() - middle);
        views.push(format!(
            r#"{{"buffer":0,"byteOffset":{start},"byteLength":{vertex_bytes}}}"#
        ));
        views.push(format!(
            r#"{{"buffer":0,"byteOffset":{middle},"byteLength":{index_bytes}}}"#
        ));
        accessors.push(format!(
            r#"{{"bufferView":{},"componentType":5126,"count":{},"type":"VEC3","min":[0,0,0],"max":[1,1,1]}}"#,
            2 * i,
            corners.len()
        ));
        accessors.push(format!(
            r#"{{"bufferView":{},"componentType":5125,"count":{},"type":"SCALAR"}}"#,
            2 * i + 1,
            indices.len()
        ));
        meshes.push(format!(
            r#"{{"primitives":[{{"attributes":{{"POSITION":{}}},"indices":{}}}]}}"#,
            2 * i,
            2 * i + 1
        ));
        let [x, y, z] = translation;
        list.push(format!(
            r#"{{"name":"{name}","mesh":{i},"translation":[{x},{y},{z}]}}"#
        ));
    }
    let roots: Vec<String> = (0..nodes.len()).map(|i| i.to_string()).collect();
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],"nodes":[{}],"meshes":[{}],"accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
        roots.join(","),
        list.join(","),
        meshes.join(","),
        accessors.join(","),
        views.join(","),
        data.len()
    );
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut bytes = Vec::from(*b"glTF");
    let total = 12 + 8 + json.len() + 8 + data.len();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((total as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    bytes
}

#[test]
fn obj_with_quadrilaterals() {
    assert_is_box(&read_bytes("box.obj", obj().as_bytes()).unwrap());
}

#[test]
fn stl_binary_and_text() {
    assert_is_box(&read_bytes("box.stl", &binary_stl()).unwrap());
    let mut text = String::from("solid box\n");
    for t in triangles() {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for corner in t {
            let [x, y, z] = CORNERS[corner as usize];
            text.push_str(&format!("vertex {x} {y} {z}\n"));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid box\n");
    assert_is_box(&read_bytes("BOX.STL", text.as_bytes()).unwrap());
}

#[test]
fn ply_text_and_binary_of_both_byte_orders() {
    let mut text = ply_header("ascii");
    for [x, y, z] in CORNERS {
        text.push_str(&format!("{x} {y} {z} 255\n"));
    }
    for [a, b, c, d] in SIDES {
        text.push_str(&format!("4 {a} {b} {c} {d}\n"));
    }
    assert_is_box(&read_bytes("box.ply", text.as_bytes()).unwrap());
    for little in [true, false] {
        let format = if little {
            "binary_little_endian"
        } else {
            "binary_big_endian"
        };
        let mut bytes = ply_header(format).into_bytes();
        let put = |bytes: &mut Vec<u8>, word: u32| {
            bytes.extend(if little {
                word.to_le_bytes()
            } else {
                word.to_be_bytes()
            });
        };
        for corner in CORNERS {
            for x in corner {
                put(&mut bytes, x.to_bits());
            }
            bytes.push(255);
        }
        for side in SIDES {
            bytes.push(4);
            for i in side {
                put(&mut bytes, i);
            }
        }
        assert_is_box(&read_bytes("box.ply", &bytes).unwrap());
    }
}

#[test]
fn glb_by_node_name_with_its_transform() {
    let all = triangles();
    let indices = all.as_flattened();
    let bytes = glb(
        &[
            ("box", &CORNERS, indices),
            ("other", &CORNERS[..3], &[0, 1, 2]),
        ],
        [1.0, 0.0, 0.0],
    );
    let (_folder, path) = file("two.glb", &bytes);
    let only_box = read(&path, &["box".into()]).unwrap();
    assert_is_box(&only_box);
    assert!(
        (only_box.bounds()[0].x - 1.0).abs() < 1e-6,
        "the node's translation counts"
    );
    assert_eq!(
        read(&path, &[]).unwrap().triangles.len(),
        13,
        "without names all parts are taken"
    );
    let missing = read(&path, &["liver".into()]).unwrap_err().to_string();
    assert!(
        missing.contains("'liver'") && missing.contains("box, other"),
        "{missing}"
    );
}

#[test]
fn glb_split_along_seams_is_closed_after_welding() {
    // Every triangle has corners of its own, as in the files of exporters.
    let mut corners = Vec::new();
    for t in triangles() {
        corners.extend(t.map(|i| CORNERS[i as usize]));
    }
    let indices: Vec<u32> = (0..corners.len() as u32).collect();
    let bytes = glb(&[("box", &corners, &indices)], [0.0; 3]);
    assert_is_box(&read_bytes("seams.glb", &bytes).unwrap());
}

#[test]
fn damaged_files_are_refused_with_a_remedy() {
    let indices: Vec<u32> = triangles().into_flattened();
    let good_glb = glb(&[("box", &CORNERS, &indices)], [0.0; 3]);
    let stl = binary_stl();
    let mut billion = stl.clone();
    billion[80..84].copy_from_slice(&1_000_000_000u32.to_le_bytes());
    let billion_ply = ply_header("ascii").replace("element face 6", "element face 1000000000");
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty.obj", vec![], "no triangles"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n".to_vec(), "no triangles"),
        (
            "range.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n".to_vec(),
            "OBJ",
        ),
        ("words.obj", b"v zero 0 0\nf 1 2 3\n".to_vec(), "OBJ"),
        ("cut.stl", stl[..stl.len() - 20].to_vec(), "truncated"),
        ("short.stl", vec![1, 2, 3], "shorter than its header"),
        ("billion.stl", billion, "1000000000 triangles"),
        (
            "billion.ply",
            billion_ply.into_bytes(),
            "1000000000 triangles",
        ),
        (
            "cut.ply",
            ply_header("binary_little_endian").into_bytes(),
            "PLY",
        ),
        ("noise.ply", vec![0xfe; 300], "PLY"),
        ("cut.glb", good_glb[..good_glb.len() - 30].to_vec(), "glTF"),
        ("noise.glb", vec![7; 300], "glTF"),
        ("text.gltf", b"{}".to_vec(), "glTF"),
        ("picture.png", vec![0; 10], "unknown mesh format"),
    ];
    for (name, content, expected) in cases {
        let outcome = read_bytes(name, &content).and_then(|mesh| mend(&mesh, Closing::Auto));
        let message = outcome.expect_err(name).to_string();
        assert!(message.contains(expected), "{name}: {message}");
    }
    let missing = read(Path::new("does-not-exist.obj"), &[])
        .unwrap_err()
        .to_string();
    assert!(missing.contains("--meshes"), "{missing}");
}

/// A GLB of one box. Each edit replaces a text in its JSON.
fn lying_glb(edits: &[(&str, &str)]) -> Vec<u8> {
    let indices: Vec<u32> = triangles().into_flattened();
    let bytes = glb(&[("box", &CORNERS, &indices)], [0.0; 3]);
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("4 bytes")) as usize;
    let (json, data) = bytes[20..].split_at(length);
    let mut json = String::from_utf8(json.to_vec()).expect("text");
    for (from, to) in edits {
        assert!(json.contains(from), "{from}");
        json = json.replace(from, to);
    }
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut edited = Vec::from(*b"glTF\x02\0\0\0");
    edited.extend((20 + json.len() as u32 + data.len() as u32).to_le_bytes());
    edited.extend((json.len() as u32).to_le_bytes());
    edited.extend(b"JSON");
    edited.extend(json.as_bytes());
    edited.extend(data);
    edited
}

/// Largest memory that this process has had so far, bytes.
fn memory_peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1));
    kib.and_then(|kib| kib.parse::<u64>().ok())
        .expect("a number")
        * 1024
}

/// Short files announce a billion of something. Each is refused with the number or the place, and
/// before memory is taken.
#[test]
fn a_billion_of_anything_is_refused_at_once() {
    let many = "1000000000";
    let ply = |elements: &str| {
        format!("ply\nformat binary_little_endian 1.0\n{elements}end_header\n").into_bytes()
    };
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let list = "property list uint int vertex_indices\n";
    let mut long_list = ply(&format!("element vertex 1\n{xyz}element face 1\n{list}"));
    long_list.extend([0; 12]);
    long_list.extend(1_000_000_000u32.to_le_bytes());
    let mut stl = binary_stl();
    stl[80..84].copy_from_slice(&1_000_000_000u32.to_le_bytes());
    let paths: Vec<String> = (1..60)
        .map(|i| format!(r#"{{"children":[{i},{i}]}}"#))
        .collect();
    let paths = format!(r#""nodes":[{},{{"name""#, paths.join(","));
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("faces.stl", stl, many),
        (
            "faces.ply",
            ply(&format!("element face {many}\n{list}")),
            many,
        ),
        (
            "vertices.ply",
            ply(&format!("element vertex {many}\n{xyz}")),
            many,
        ),
        (
            "nothings.ply",
            ply(&format!("element nothing {many}\n")),
            many,
        ),
        (
            "other.ply",
            ply(&format!("element other {many}\nproperty uchar a\n")),
            many,
        ),
        ("list.ply", long_list, "PLY"),
        (
            "vertices.glb",
            lying_glb(&[(r#""count":8,"#, r#""count":1000000000,"#)]),
            "triangles",
        ),
        (
            "indices.glb",
            lying_glb(&[(r#""count":36,"#, r#""count":1000000000,"#)]),
            "333333333 triangles",
        ),
        (
            "data.glb",
            lying_glb(&[(
                r#""buffers":[{"byteLength":"#,
                r#""buffers":[{"byteLength":1000000000000},{"byteLength":"#,
            )]),
            "bytes of data",
        ),
        (
            "paths.glb",
            lying_glb(&[(r#""nodes":[{"name""#, &paths)]),
            "more than one parent",
        ),
        (
            "index.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 1000000000\n".to_vec(),
            "line 4, 'f 1 2 1000000000'",
        ),
        (
            "overflow.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 99999999999999999999999\n".to_vec(),
            "line 5",
        ),
        (
            "number.obj",
            b"v 0 0 0\nv 1 zero 0\n".to_vec(),
            "line 2, 'v 1 zero 0'",
        ),
    ];
    for (name, content, expected) in cases {
        assert!(content.len() < 5000);
        let message = read_bytes(name, &content).expect_err(name).to_string();
        assert!(message.contains(expected), "{name}: {message}");
    }
    assert!(memory_peak() < 1 << 29, "{} bytes", memory_peak());
}

#[test]
fn glb_with_elements_of_another_kind_is_refused() {
    let index_type = r#""componentType":5125"#;
    let cases = [
        (index_type, r#""componentType":5126"#),
        (r#""type":"SCALAR""#, r#""type":"VEC3""#),
        (r#""type":"VEC3""#, r#""type":"VEC2""#),
        (r#""componentType":5126"#, r#""componentType":5121"#),
    ];
    for (from, to) in cases {
        let message = read_bytes("kind.glb", &lying_glb(&[(from, to)])).unwrap_err();
        let message = message.to_string();
        assert!(message.contains("it must be"), "{from} {to}: {message}");
    }
}

/// Pipes and devices may have no end, so only plain files are read.
#[test]
fn what_is_no_plain_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let device = folder.path().join("zero.stl");
    std::os::unix::fs::symlink("/dev/zero", &device).unwrap();
    let buffer = lying_glb(&[(r#""buffers":[{"#, r#""buffers":[{"uri":"zero.stl","#)]);
    let lying = folder.path().join("lying.glb");
    std::fs::write(&lying, buffer).unwrap();
    for path in [folder.path().join("zero.stl"), lying] {
        let message = read(&path, &[]).unwrap_err().to_string();
        assert!(message.contains("not a plain file"), "{message}");
    }
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.toml")).unwrap();
    let recipe = scene_prepare::Recipe::load(&folder.path().join("zero.toml"), None);
    let message = recipe.unwrap_err().to_string();
    assert!(message.contains("not a plain file"), "{message}");
}

#[test]
fn glb_whose_numbers_lie_is_refused() {
    let indices: Vec<u32> = triangles().into_flattened();
    let text = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let mut bytes = glb(&[("box", &CORNERS, &indices)], [0.0; 3]);
        let at = bytes
            .windows(from.len())
            .position(|w| w == from.as_bytes())
            .unwrap();
        bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
        read_bytes("lies.glb", &bytes).and_then(|mesh| mend(&mesh, Closing::Auto))
    };
    assert!(
        text(r#""count":36"#, r#""count":99"#).is_err(),
        "more indices than data"
    );
    assert!(
        text(r#""count":8,"#, r#""count":9,"#).is_err(),
        "more vertices than data"
    );
    let mut out_of_range = indices.clone();
    out_of_range[5] = 4000;
    let bytes = glb(&[("box", &CORNERS, &out_of_range)], [0.0; 3]);
    let outcome = read_bytes("range.glb", &bytes).and_then(|mesh| mend(&mesh, Closing::Auto));
    let message = outcome.unwrap_err().to_string();
    assert!(
        message.contains("4000") && message.contains("there are only 8"),
        "{message}"
    );
}
