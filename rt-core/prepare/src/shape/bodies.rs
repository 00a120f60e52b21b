//! Bodies of the built-in organs.

use super::anatomy::{Anatomy, Course};
use super::primitive::Tube;
use crate::Vec3;

/// Bodies of the built-in organs in one anatomy, to which distances are measured.
pub(super) struct Bodies {
    pub(super) anatomy: Anatomy,
    pub(super) gallbladder: Tube,
    pub(super) pouch: (Vec3, f64),
    pub(super) stomach: Tube,
    pub(super) duodenum: Tube,
    pub(super) intestine: Tube,
    pub(super) cystic_duct: Tube,
    pub(super) bile_duct: Tube,
    pub(super) hepatic_artery: Tube,
    pub(super) cystic_artery: Tube,
    /// In courses without an accessory artery, this tube exists but is not used.
    pub(super) accessory_artery: Tube,
    pub(super) fat: Tube,
    /// Part of the gallbladder over which the cover of duct and artery reaches, as thick as the
    /// cover's outside; `None` without a cover.
    pub(super) cloak: Option<Tube>,
    /// Origin of the cystic artery, m.
    pub(super) origin: Vec3,
}

impl Bodies {
    /// Distance to the accessory artery; infinite in courses without one.
    pub(super) fn accessory(&self, p: &Vec3) -> f64 {
        match self.anatomy.course {
            Course::AccessoryArtery => self.accessory_artery.distance(p),
            _ => f64::INFINITY,
        }
    }
}
