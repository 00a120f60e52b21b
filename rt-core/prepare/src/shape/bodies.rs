//! Bodies of the built-in organs.

use super::anatomy::Anatomy;
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
    pub(super) fat: Tube,
}
