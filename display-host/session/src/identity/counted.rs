//! Numbers of pixels of each organ.

/// Number of organs, in the scene's order, whose measures are kept. Further organs are drawn and
/// hide others, and have no measures.
pub const ORGANS_MAX: usize = 16;

/// Pixels of each organ.
pub(super) struct Counted {
    /// Pixels that show the organ, and pixels that it would fill if nothing hid it.
    pub(super) organs: [[u32; 2]; ORGANS_MAX],
    /// Sum of the places of the pixels that show the organ, from the middle, as shares of the
    /// radius.
    pub(super) places: [[f32; 2]; ORGANS_MAX],
    /// Pixels of the picture.
    pub(super) all: u32,
}

impl Counted {
    pub(super) fn pixels_of(&self, organ: usize) -> [u32; 2] {
        self.organs.get(organ).copied().unwrap_or_default()
    }

    /// Distance of an organ's visible middle from the picture's middle, as a share of the radius.
    pub(super) fn off(&self, organ: usize) -> f32 {
        let [x, y] = self.places.get(organ).copied().unwrap_or_default();
        let [shown, _] = self.pixels_of(organ);
        x.hypot(y) / shown.max(1) as f32
    }
}
