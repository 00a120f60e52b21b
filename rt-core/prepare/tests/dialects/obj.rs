//! Dialects of OBJ.

use super::{CORNERS, SIDES, assert_is_cube, assert_refused, measured, read_as, read_parts};

fn vertices(tail: &str) -> String {
    let line = |[x, y, z]: &[i32; 3]| format!("v {x}.0 {y} {z}{tail}\n");
    CORNERS.iter().map(line).collect()
}

fn faces(corner: impl Fn(u32) -> String) -> String {
    let line = |side: &[u32; 4]| format!("f {}\n", side.map(&corner).join(" "));
    SIDES.iter().map(line).collect()
}

fn cube() -> String {
    vertices("") + &faces(|i| (i + 1).to_string())
}

#[test]
fn text_of_every_program_is_read() {
    let negative = vertices("") + &faces(|i| (i64::from(i) - 8).to_string());
    let turns: String = SIDES
        .iter()
        .map(|side| {
            let corners = side.map(|i| CORNERS[i as usize]);
            let lines = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
            lines.concat() + "f -4 -3 -2 -1\n"
        })
        .collect();
    for text in [
        cube(),
        cube().replace('\n', "\r\n"),
        cube().replace('\n', "\r"),
        format!("\u{feff}{}", cube()),
        format!("\u{feff}{negative}v 90 90 90\n"),
        negative,
        turns,
        faces(|i| (i + 1).to_string()) + &vertices(""),
        vertices(" 1.0") + &faces(|i| (i + 1).to_string()),
        vertices(" 0.5 0.5 0.5") + &faces(|i| format!("{}//7", i + 1)),
        vertices(" 0.5 0.5 0.5 1") + &faces(|i| format!("{}/9/9", i + 1)),
        vertices("\t# a corner") + &faces(|i| format!("{}/", i + 1)),
        cube().replace("f ", "usemtl\nf "),
        cube().replace("f ", "mtllib not there.mtl\nusemtl a b\ns off\nf "),
        cube().replace("f ", "f \\\n").replace(".0 ", ".0 \\ \r\n"),
        format!("# C:\\scans\\\n{}", cube()),
        cube() + "p 1 2\nl 1 2 3 7\nl 1 7\ng\ng empty\no\n",
    ] {
        assert_is_cube("text.obj", text.as_bytes());
    }
    let latin1 = [b"# M\xfcller\no L\xe4ber\n", cube().as_bytes()].concat();
    assert_is_cube("latin1.obj", &latin1);
}

/// A vertex that no face uses must not count for the size of the organ.
#[test]
fn unused_vertices_are_left_out() {
    let text = cube() + "v 9000 9000 9000\n";
    let mesh = read_as("unused.obj", text.as_bytes()).unwrap();
    assert_eq!(mesh.vertices.len(), 8);
}

#[test]
fn parts_are_objects_and_groups() {
    let second = cube().replace("v ", "v 1").replace("f ", "g shell\nf ");
    let text = format!("o first\n{}o second\n{}", cube(), second);
    for part in ["first", "second", "shell"] {
        let mesh = read_parts("parts.obj", text.as_bytes(), &[part.into()]).unwrap();
        assert_eq!(measured(&mesh), [64_000, 9_600], "{part}");
    }
    let missing = read_parts("parts.obj", text.as_bytes(), &["third".into()]).unwrap_err();
    assert!(
        missing
            .to_string()
            .ends_with("has no part named 'third'; its parts are: first, second, shell"),
        "{missing}"
    );
}

#[test]
fn damaged_files_are_refused_with_the_line() {
    for (from, to, words) in [
        ("v 40.0 40 0\n", "v 40,0 40,0 0,0\n", ["line 3", "comma"]),
        ("v 40.0 40 0\n", "v 40.0 40\n", ["line 3", "three numbers"]),
        (
            "v 40.0 40 0\n",
            "v 40.0 1e999 0\n",
            ["line 3", "not finite"],
        ),
        ("f 5 6 7 8", "f 5 6 7 99", ["line 10", "no vertex 99"]),
        ("f 5 6 7 8", "f 5 6 7 0", ["line 10", "no vertex 0"]),
        ("f 5 6 7 8", "f -9 6 7 8", ["line 10", "no vertex -9"]),
        ("f 5 6 7 8", "f 5 x 7 8", ["line 10", "'x'"]),
    ] {
        let text = cube();
        assert!(text.contains(from), "{from}");
        assert_refused("bad.obj", text.replace(from, to).as_bytes(), &words);
    }
    assert_refused("points.obj", vertices("").as_bytes(), &["8 points"]);
    assert_refused("wide.obj", b"\xff\xfev\0 \0", &["UTF-16"]);
}
