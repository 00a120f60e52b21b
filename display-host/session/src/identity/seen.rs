//! Measures of an identity image, and their form in the course.

use super::counted::{Counted, ORGANS_MAX};

/// Steps of a share as it is kept.
const STEPS: f32 = 255.0;

/// Measures of an identity image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Angle between the line of sight to Calot's triangle and the plane of cystic duct and artery,
    /// rad: positive on the side of the endoscope's port, negative behind.
    pub side_rad: f32,
    /// Share of the triangle's tissue, by volume, that is gone and whose place nothing hides.
    pub triangle: f32,
    /// Share of the tissue in the lower third of the gallbladder's bed, by volume, that is gone and
    /// whose place nothing hides.
    pub lower_bed: f32,
    /// Each organ, in the scene's order.
    pub organs: [OrganSeen; ORGANS_MAX],
}

impl Seen {
    pub(crate) fn is_sane(&self) -> bool {
        let is_share = |share: f32| (0.0..=1.0).contains(&share);
        let side = self.side_rad.abs();
        side <= core::f32::consts::FRAC_PI_2 && is_share(self.triangle) && is_share(self.lower_bed)
    }
}

/// View of an organ. Shares, and the root of the size, are kept in steps of 1/255. So an assessment
/// of the recording reads exactly the numbers of the running assessment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OrganSeen(pub(crate) [u8; 4]);

impl OrganSeen {
    /// A view of an organ. `in_view` is the share of the organ's surface that lies within the
    /// picture, and `clear` the share of this part that nothing hides. `size` is the share of the
    /// picture that the visible part fills, and `off` the distance of its middle from the picture's
    /// middle, as a share of the picture's radius.
    #[must_use]
    pub fn new(in_view: f32, clear: f32, size: f32, off: f32) -> Self {
        // The root gives small organs finer steps.
        let size = size.max(0.0).sqrt();
        Self([in_view, clear, size, off].map(|it| (it.clamp(0.0, 1.0) * STEPS).round() as u8))
    }

    pub(super) fn of(in_view: f32, counted: &Counted, organ: usize) -> Self {
        let [shown, covered] = counted.pixels_of(organ);
        if shown == 0 {
            return Self::new(in_view, 0.0, 0.0, 1.0);
        }
        let clear = shown as f32 / covered.max(1) as f32;
        let size = shown as f32 / counted.all.max(1) as f32;
        Self::new(in_view, clear, size, counted.off(organ))
    }

    fn share(self, which: usize) -> f64 {
        f64::from(self.0[which]) / f64::from(STEPS)
    }

    /// Share of the organ's surface that lies within the picture, hidden or not.
    #[must_use]
    pub fn in_view(self) -> f64 {
        self.share(0)
    }

    /// Share of the part within the picture that nothing hides.
    #[must_use]
    pub fn clear(self) -> f64 {
        self.share(1)
    }

    /// Share of the picture that its visible part fills.
    #[must_use]
    pub fn size(self) -> f64 {
        self.share(2).powi(2)
    }

    /// Distance of the middle of its visible part from the middle of the picture, as a share of the
    /// picture's radius.
    #[must_use]
    pub fn off(self) -> f64 {
        self.share(3)
    }

    /// Visible share of the organ.
    #[must_use]
    pub fn visible(self) -> f64 {
        self.in_view() * self.clear()
    }
}
