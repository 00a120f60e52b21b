//! The window of the field follows the fluid.
//!
//! The window is 12 cm wide. While all fluid lies in it, it stays. When fluid lies outside, the
//! window moves to the middle of the box around all fluid. If the box is wider than the window, the
//! window moves to the middle of the volume.

use glam::Vec3;

use super::super::stain::Skin;
use super::Fluids;
use super::field::Field;
use super::surface::Surface;

impl Fluids {
    /// Opens the window around the first place at which fluid lies.
    pub(super) fn open_window(&mut self, at_m: Vec3, vertex: usize, skin: &Skin<'_>) {
        if self.field.is_none() {
            let middle_m = skin.at_rest(vertex);
            // Fluid runs down, so the window reaches farther down than up.
            self.middle_m = at_m - self.up * 0.02;
            self.field = Some(Field::around(middle_m - self.up * 0.02));
        }
    }

    /// Moves the window if fluid lies outside of it.
    pub(super) fn move_window(&mut self, surface: &mut Surface, skin: &Skin<'_>) {
        let Some(field) = &mut self.field else {
            return;
        };
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (mut at_rest, mut now, mut sum) = (Vec3::ZERO, Vec3::ZERO, 0.0f32);
        for it in &self.lying {
            let rest_m = Surface::at_rest(&it.place, skin);
            (low, high) = (low.min(rest_m), high.max(rest_m));
            let volume = it.total_m3() as f32;
            at_rest += rest_m * volume;
            now += surface.position(&it.place, skin) * volume;
            sum += volume;
        }
        if sum <= 0.0 || field.covers(low, high) {
            return;
        }
        let is_wider = (high - low).cmpgt(Field::extent_m()).any();
        let middle_m = match is_wider {
            true => at_rest / sum,
            false => 0.5 * (low + high),
        };
        self.middle_m = now / sum;
        field.move_to(middle_m);
    }
}
