//! Pictures of a run as an animated GIF, for pages that cannot show video.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use color_quant::NeuQuant;
use gif::{AnyExtension, DisposalMethod, Encoder, Frame, Repeat};

use crate::DisplayError;

/// Pictures per second.
const RATE: u16 = 10;
/// Number of colours of the palette, without the entry for an unchanged pixel.
const COLOURS: usize = 128;
/// Largest change of a channel (0 to 255) at which a pixel counts as unchanged. Film grain changes
/// less.
const SAME_MAX: u8 = 12;
/// Spacing of the pixels from which the palette is made, pixels. For more than
/// [`DENSE_PICTURES_MAX`] pictures the spacing is a multiple of this, so the number of samples
/// hardly grows.
const SAMPLE_STEP_PX: usize = 7;
/// Number of pictures above which the samples are farther apart.
const DENSE_PICTURES_MAX: usize = 64;
/// Number of samples that good colours need.
const SAMPLES_MIN: usize = 100_000;
/// Label of the GIF extension block that holds a comment.
const COMMENT: u8 = 0xfe;
/// Bits of each channel that are used to look up the nearest colour.
const LOOKUP_BITS: u32 = 5;

/// Writes the pictures in this order into a file that only its owner can read. All pictures must
/// have one size. They are decoded one at a time.
///
/// # Errors
/// There is no picture, one cannot be read or has another size, or the file cannot be written.
pub fn write_gif(pictures: &[PathBuf], path: &Path) -> Result<(), DisplayError> {
    let refused = |detail: String| DisplayError::Animation {
        path: path.to_owned(),
        detail,
    };
    let read = |picture: &PathBuf| {
        let read = image::open(picture).map(|it| it.to_rgb8());
        read.map_err(|error| refused(format!("{}: {error}", picture.display())))
    };
    let every = SAMPLE_STEP_PX * pictures.len().div_ceil(DENSE_PICTURES_MAX).max(1);
    let (mut size, mut samples) = (None, Vec::new());
    for picture in pictures {
        let picture = read(picture)?;
        if *size.get_or_insert(picture.dimensions()) != picture.dimensions() {
            return Err(refused("the pictures differ in size".to_owned()));
        }
        let looked_at = picture.pixels().step_by(every);
        samples.extend(looked_at.flat_map(|it| [it.0[0], it.0[1], it.0[2], 255]));
    }
    let (width, height) =
        size.ok_or_else(|| refused("there is no picture; request some with --frames".to_owned()))?;
    let sides = [width, height].map(u16::try_from);
    let [Ok(wide), Ok(high)] = sides else {
        return Err(refused(format!(
            "{width}×{height} pixels are too many, a side has at most 65535"
        )));
    };
    // The quantiser learns once from each sample. If there are too few samples, they are repeated.
    let times = (4 * SAMPLES_MIN).div_ceil(samples.len().max(1));
    let colours = Colours::of(&samples.repeat(times.max(1)));
    let file = session::create_private(path).map_err(|error| refused(error.to_string()))?;
    let failed = |error: gif::EncodingError| refused(error.to_string());
    let mut animation = Animation::begin(file, [wide, high], &colours).map_err(failed)?;
    for picture in pictures {
        let picture = read(picture)?;
        if picture.dimensions() != (width, height) {
            return Err(refused("the pictures differ in size".to_owned()));
        }
        animation.add(&picture).map_err(failed)?;
    }
    Ok(())
}

/// An animation being written.
struct Animation<'a> {
    encoder: Encoder<BufWriter<File>>,
    size: [u16; 2],
    colours: &'a Colours,
    /// The picture that a viewer sees after the frames so far. Its colours are those before the
    /// reduction to the palette.
    shown: Vec<[u8; 3]>,
}

impl<'a> Animation<'a> {
    fn begin(
        file: File,
        [width, height]: [u16; 2],
        colours: &'a Colours,
    ) -> Result<Self, gif::EncodingError> {
        let mut encoder = Encoder::new(BufWriter::new(file), width, height, &colours.palette)?;
        encoder.set_repeat(Repeat::Infinite)?;
        encoder.write_raw_extension(AnyExtension(COMMENT), &[b"Calot"])?;
        Ok(Self {
            encoder,
            size: [width, height],
            colours,
            shown: Vec::new(),
        })
    }

    fn add(&mut self, picture: &image::RgbImage) -> Result<(), gif::EncodingError> {
        let as_before = COLOURS as u8;
        let (colours, shown) = (self.colours, &mut self.shown);
        let [width, height] = self.size;
        let pixels: Vec<[u8; 3]> = picture.pixels().map(|it| it.0).collect();
        let mut indices = Vec::with_capacity(pixels.len());
        for (place, pixel) in pixels.iter().enumerate() {
            let same = shown
                .get(place)
                .is_some_and(|before| is_same(*before, *pixel));
            indices.push(if same {
                as_before
            } else {
                colours.nearest(*pixel)
            });
        }
        match shown.is_empty() {
            true => *shown = pixels,
            false => {
                for ((before, now), index) in shown.iter_mut().zip(pixels).zip(&indices) {
                    if *index != as_before {
                        *before = now;
                    }
                }
            }
        }
        self.encoder.write_frame(&Frame {
            delay: 100 / RATE,
            dispose: DisposalMethod::Keep,
            transparent: Some(as_before),
            width,
            height,
            buffer: indices.into(),
            ..Frame::default()
        })
    }
}

fn is_same(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= SAME_MAX)
}

/// The common palette, and the nearest colour for any pixel.
struct Colours {
    /// Red, green and blue of each colour; the last one means "unchanged".
    palette: Vec<u8>,
    nearest: Vec<u8>,
}

impl Colours {
    /// Makes the palette from samples. Each sample has four bytes: red, green, blue and 255.
    fn of(samples: &[u8]) -> Self {
        let quantiser = NeuQuant::new(10, COLOURS, samples);
        let mut palette = quantiser.color_map_rgb();
        let (colours, _) = palette.as_chunks::<3>();
        let colours = colours.to_vec();
        palette.resize(3 * (COLOURS + 1), 0);
        let side = 1usize << LOOKUP_BITS;
        let middle = |step: usize| ((step << (8 - LOOKUP_BITS)) | (1 << (7 - LOOKUP_BITS))) as u8;
        let nearest = (0..side * side * side).map(|at| {
            let [r, g, b] = [at / side / side, at / side % side, at % side].map(middle);
            let off = |it: &[u8]| -> u32 {
                let parts = it.iter().zip([r, g, b]);
                parts.map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
            };
            let all = colours.iter().zip(0u8..);
            let nearest = all.min_by_key(|(colour, _)| off(&colour[..]));
            nearest.map_or(0, |(_, index)| index)
        });
        Self {
            palette,
            nearest: nearest.collect(),
        }
    }

    fn nearest(&self, [r, g, b]: [u8; 3]) -> u8 {
        let [r, g, b] = [r, g, b].map(|it| usize::from(it >> (8 - LOOKUP_BITS)));
        let at = ((r << LOOKUP_BITS | g) << LOOKUP_BITS) | b;
        self.nearest.get(at).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    fn picture(folder: &Path, number: u8, side: u32) -> PathBuf {
        let path = folder.join(format!("{number}.png"));
        let paint = |x: u32, _| image::Rgb([if x < 8 { 200 } else { 20 * number }, 40, 10]);
        image::RgbImage::from_fn(side, side, paint)
            .save(&path)
            .unwrap();
        path
    }

    #[test]
    fn pictures_become_one_animation_with_their_colours() {
        let folder = tempfile::tempdir().unwrap();
        let pictures: Vec<_> = (0..3).map(|it| picture(folder.path(), it, 24)).collect();
        let path = folder.path().join("all.gif");
        write_gif(&pictures, &path).unwrap();
        let mode = path.metadata().unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut read = options.read_info(File::open(&path).unwrap()).unwrap();
        let mut frames = Vec::new();
        while let Some(frame) = read.read_next_frame().unwrap() {
            frames.push((frame.delay, frame.buffer.to_vec()));
        }
        assert_eq!(frames.len(), 3);
        assert!(frames.iter().all(|(delay, _)| *delay == 10));
        let pixel = |frame: usize, x: usize| &frames[frame].1[4 * x..4 * x + 4];
        // All pictures share one palette.
        let first = pixel(0, 2);
        assert!(first[0].abs_diff(200) < 40 && first[3] == 255, "{first:?}");
        // Unchanged pixels are left transparent, changed ones are drawn.
        assert_eq!(pixel(1, 2)[3], 0);
        let last = pixel(2, 20);
        assert!(last[0].abs_diff(40) < 40 && last[3] == 255, "{last:?}");
    }

    #[test]
    fn pictures_that_cannot_be_animated_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all.gif");
        let two = [picture(folder.path(), 1, 24), picture(folder.path(), 2, 16)];
        for (pictures, why) in [
            (&[][..], "cannot write the animation: there is no picture"),
            (&two[..], "differ in size"),
            (&[folder.path().join("none.png")][..], "none.png"),
        ] {
            let error = write_gif(pictures, &path).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
