//! Copies finished pictures from the graphics device.

use super::Renderer;
use super::gpu::Gpu;
use crate::DisplayError;

impl Renderer {
    /// Waits for the last frame and copies the distance of each pixel's surface before the camera,
    /// m, row by row from the upper left; 0 where nothing is.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn distances(&self, gpu: &Gpu) -> Result<Vec<f32>, DisplayError> {
        let texels = gpu.read_texture(self.targets.light.texture())?;
        let alpha = texels.chunks_exact(8).map(|texel| [texel[6], texel[7]]);
        Ok(alpha.map(|it| half(u16::from_le_bytes(it))).collect())
    }

    /// Waits for the last frame and copies it as RGBA.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn read(&self, gpu: &Gpu) -> Result<image::RgbaImage, DisplayError> {
        let [width, height] = self.quality.size;
        let pixels = gpu.read_texture(&self.targets.picture)?;
        image::RgbaImage::from_raw(width, height, pixels).ok_or(DisplayError::Device {
            doing: "reading a picture back",
            detail: "picture of the wrong size".into(),
        })
    }
}

/// A number of half precision.
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => fraction / 1024.0 * 2f32.powi(-14),
        31 => f32::INFINITY,
        _ => (1.0 + fraction / 1024.0) * 2f32.powi(exponent - 15),
    };
    if bits >> 15 == 0 { size } else { -size }
}
