//! Dialects of PLY.

use super::{CORNERS, SIDES, assert_is_cube, assert_refused};

fn header(format: &str, body: &str) -> String {
    format!("ply\nformat {format} 1.0\n{body}end_header\n")
}

const VERTEX: &str = "element vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
const FACE: &str = "element face 6\nproperty list uchar int vertex_indices\n";

fn vertices() -> String {
    let line = |[x, y, z]: &[i32; 3]| format!("{x} {y} {z}\n");
    CORNERS.iter().map(line).collect()
}

fn faces() -> String {
    let line = |[a, b, c, d]: &[u32; 4]| format!("4 {a} {b} {c} {d}\n");
    SIDES.iter().map(line).collect()
}

fn text() -> String {
    header("ascii", &format!("{VERTEX}{FACE}")) + &vertices() + &faces()
}

#[test]
fn text_of_every_program_is_read() {
    let colour = "comment Übung\nobj_info\nelement";
    let odd = "property list uchar int vertex_index\nproperty list uchar float a.b(c)#2\n";
    let odd = format!("{VERTEX}element face 6\n{odd}");
    let odd_faces = faces().replace('\n', " 2 0.5 0.5\n");
    for text in [
        text(),
        text().replace('\n', "\r\n"),
        text().replace('\n', "\r"),
        text().replacen("element", colour, 1),
        text()
            .replace("float", "float64")
            .replace("uchar int", "uint8 int32"),
        format!("\u{feff}{}", text()),
        header("ascii", &odd) + &vertices() + &odd_faces,
        header("ascii", &format!("{FACE}{VERTEX}")) + &faces() + &vertices(),
    ] {
        assert_is_cube("text.ply", text.as_bytes());
    }
    let latin1 = text()
        .replacen("element", "comment M\u{1}ller\nelement", 1)
        .into_bytes();
    let latin1: Vec<u8> = latin1
        .into_iter()
        .map(|b| if b == 1 { 0xfc } else { b })
        .collect();
    assert_is_cube("latin1.ply", &latin1);
}

/// Several types of numbers, in both byte orders, after headers with each line end.
#[test]
fn binary_of_every_program_is_read() {
    for (big, line_end) in [(false, "\n"), (true, "\n"), (false, "\r\n"), (true, "\r")] {
        let body = "element vertex 8\nproperty double x\nproperty short y\nproperty uchar z\n\
                    element face 6\nproperty list ushort uint vertex_index\n";
        let order = if big { "big" } else { "little" };
        let header = header(&format!("binary_{order}_endian"), body);
        let mut bytes = header.replace('\n', line_end).into_bytes();
        let mut put = |number: &[u8]| {
            let mut number = number.to_vec();
            if big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for [x, y, z] in CORNERS {
            put(&f64::from(x).to_le_bytes());
            put(&(y as i16).to_le_bytes());
            put(&[z as u8]);
        }
        for side in SIDES {
            put(&4u16.to_le_bytes());
            side.iter().for_each(|i| put(&i.to_le_bytes()));
        }
        assert_is_cube("binary.ply", &bytes);
    }
}

/// Strips as in the files of the Stanford scans: −1 separates strips.
#[test]
fn triangle_strips_are_read() {
    let strips = SIDES.map(|[a, b, c, d]| format!("{a} {b} {d} {c}"));
    let head = format!("{VERTEX}element tristrips 1\nproperty list int int vertex_indices\n");
    let list = strips.join(" -1 ");
    let text = format!("{}{}29 {list}\n", header("ascii", &head), vertices());
    assert_is_cube("strips.ply", text.as_bytes());
}

#[test]
fn what_has_no_faces_is_refused() {
    let points = header("ascii", VERTEX) + &vertices();
    assert_refused(
        "points.ply",
        points.as_bytes(),
        &["8 points", "no triangles"],
    );
    let unnamed = text().replace("vertex_indices", "corners");
    assert_refused(
        "unnamed.ply",
        unnamed.as_bytes(),
        &["'face'", "vertex_indices"],
    );
    assert_refused("endless.ply", b"ply\nformat ascii 1.0\n", &["end_header"]);
}
