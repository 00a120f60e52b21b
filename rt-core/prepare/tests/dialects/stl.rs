//! Dialects of STL.

use super::{CORNERS, assert_is_cube, assert_refused, measured, read_as, read_parts, triangles};

/// The facets of some triangles of the cube, shifted along x, mm.
fn facets(which: std::ops::Range<usize>, shift: i32, normal: &str) -> String {
    let mut text = String::new();
    for t in &triangles()[which] {
        text += &format!("  facet normal {normal}\n    outer loop\n");
        for [x, y, z] in t.map(|i| CORNERS[i as usize]) {
            text += &format!("      vertex {}.0e0 {y} {z}\n", x + shift);
        }
        text += "    endloop\n  endfacet\n";
    }
    text
}

fn solid(name: &str) -> String {
    let facets = facets(0..12, 0, "0 0 0");
    format!("solid{name}\n{facets}endsolid{name}\n")
}

fn binary(header: &[u8], count: u32) -> Vec<u8> {
    let mut bytes = [header, &[0; 80]].concat()[..80].to_vec();
    bytes.extend(count.to_le_bytes());
    for t in triangles() {
        bytes.extend([0; 12]);
        for x in t.map(|i| CORNERS[i as usize]).as_flattened() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn text_of_every_program_is_read() {
    let with_nan = facets(0..12, 0, "nan -nan(ind) 1.#QNAN");
    let colour = facets(0..12, 0, "0 0 1\ncolor 1 0 0");
    for text in [
        solid(" organ"),
        solid(""),
        solid(" "),
        solid(" Leber Übung facet loop 3"),
        solid(" organ").to_uppercase(),
        solid(" organ").replace('\n', "\r\n").replace("  ", "\t"),
        solid(" organ").replace('\n', "\r"),
        solid(" organ").replace('\n', " "),
        solid(" organ").replace("endsolid organ\n", ""),
        solid(" organ").replace("endsolid", "end solid"),
        format!("\u{feff}{}", solid(" organ")),
        format!("\n\n  {}", solid(" organ")),
        format!("solid\n{with_nan}endsolid"),
        format!("solid\n{colour}endsolid"),
    ] {
        assert_is_cube("text.stl", text.as_bytes());
    }
    let latin1 = solid(" Leber").replace("Leber", "L\u{1}ber").into_bytes();
    let latin1: Vec<u8> = latin1
        .into_iter()
        .map(|b| if b == 1 { 0xe4 } else { b })
        .collect();
    assert_is_cube("latin1.stl", &latin1);
}

/// A reader that stopped at the first `endsolid` would get half an organ.
#[test]
fn every_solid_is_read() {
    let (a, b) = (facets(0..5, 0, "0 0 1"), facets(5..12, 0, "0 0 1"));
    let halves = format!("solid a\n{a}endsolid a\nsolid b\n{b}endsolid b\n");
    assert_is_cube("halves.stl", halves.as_bytes());
    let empty_first = format!("solid none\nendsolid none\n{}", solid(" organ"));
    assert_is_cube("empty.stl", empty_first.as_bytes());
    let far = facets(0..12, 100, "0 0 1");
    let two = format!("{}solid far\n{far}endsolid far\n", solid(" near"));
    assert_eq!(
        measured(&read_as("two.stl", two.as_bytes()).unwrap()),
        [128_000, 19_200]
    );
    let one = read_parts("two.stl", two.as_bytes(), &["far".into()]).unwrap();
    assert_eq!(one.bounds()[0].x as i32, 100);
    let missing = read_parts("two.stl", two.as_bytes(), &["third".into()]);
    assert!(missing.unwrap_err().to_string().contains("near, far"));
}

#[test]
fn binary_is_told_by_its_length() {
    for header in [
        &b""[..],
        b"solid",
        b"solid organ\n",
        b"solid facet normal\nendsolid",
    ] {
        assert_is_cube("binary.stl", &binary(header, 12));
    }
    assert_is_cube("unwritten.stl", &binary(b"", 0));
    assert_is_cube("unwritten.stl", &binary(b"", u32::MAX));
    let mut padded = binary(b"", 12);
    padded.extend(b"\0\r\n");
    assert_is_cube("padded.stl", &padded);
}

/// A count of 266 triangles has the byte 0A, which a reader could take for the end of a line.
#[test]
fn count_with_a_line_end_in_it_is_read() {
    let mut bytes = binary(b"solid", 266);
    bytes.resize(84 + 266 * 50, 0);
    assert_is_cube("count.stl", &bytes);
}

#[test]
fn damaged_files_are_refused_with_the_place() {
    let cut = solid(" organ");
    let cut = &cut[..cut.rfind("vertex").unwrap()];
    assert_refused("cut.stl", cut.as_bytes(), &["truncated", "within a facet"]);
    let comma = solid(" organ").replacen("0.0e0", "0,5", 1);
    assert_refused("comma.stl", comma.as_bytes(), &["line 4", "'0,5'", "comma"]);
    let word = solid(" organ").replacen("vertex", "vortex", 1);
    assert_refused("word.stl", word.as_bytes(), &["line 4", "vortex"]);
    let nan = solid(" organ").replacen("0.0e0", "nan", 1);
    assert_refused(
        "nan.stl",
        nan.as_bytes(),
        &["is not a valid STL file (", "line 4", "not finite"],
    );
    assert_refused(
        "more.stl",
        &binary(b"", 7),
        &["announces 7", "250 bytes follow"],
    );
    let wide: Vec<u8> = solid("").bytes().flat_map(|b| [b, 0]).collect();
    assert_refused("wide.stl", &[&b"\xff\xfe"[..], &wide].concat(), &["UTF-16"]);
}
