//! Pictures as PNG files that name Calot as their program.

use std::io::{self, Cursor, Write};

use image::{DynamicImage, ImageFormat};

/// Length of a PNG's signature with its first block, which describes the picture.
const HEAD_BYTES: usize = 33;
/// Text block with the standard keyword `Software`: length, kind, text, checksum.
const PROGRAM: [u8; 26] = *b"\0\0\0\x0etEXtSoftware\0Calot\xc0\x5b\x58\x74";

/// Writes a picture as PNG.
///
/// # Errors
/// The file cannot be written.
pub fn write_png(
    picture: &(impl Clone + Into<DynamicImage>),
    mut file: impl Write,
) -> io::Result<()> {
    let mut png = Cursor::new(Vec::new());
    let picture: DynamicImage = picture.clone().into();
    picture
        .write_to(&mut png, ImageFormat::Png)
        .map_err(io::Error::other)?;
    let png = png.into_inner();
    let (head, rest) = png.split_at(HEAD_BYTES.min(png.len()));
    for part in [head, &PROGRAM, rest] {
        file.write_all(part)?;
    }
    file.flush()
}
