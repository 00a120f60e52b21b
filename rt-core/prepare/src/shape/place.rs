//! Places of the organs' bodies in an anatomy.

use super::anatomy::{Anatomy, middle};
use super::bodies::Bodies;
use super::primitive::{Through, Tube};
use super::{fat, gallbladder, intestine, stomach, vessel};
use crate::Vec3;

pub(super) fn bodies(anatomy: &Anatomy) -> Bodies {
    let a = anatomy;
    let usual = gallbladder::LINE;
    let line = a.gallbladder.line(usual);
    let end = |line: &[Through]| line.last().map_or(Vec3::zeros(), |(p, _)| Vec3::from(*p));
    let neck = end(&line) - end(usual);
    let pouch = a
        .gallbladder
        .place(&Vec3::from(gallbladder::POUCH.0), &middle(usual));
    let duct = vessel::cystic_duct(a.course);
    let artery = vessel::cystic_artery(a.course);
    let hepatic_artery = vessel::hepatic_artery(a.course, a.runs_on);
    let (bile, hepatic) = (a.bile_duct.shift_m(), a.hepatic_artery.shift_m());
    let artery = a.cystic_artery.line_between(artery, hepatic, neck);
    Bodies {
        anatomy: *a,
        origin: artery
            .first()
            .map_or(Vec3::zeros(), |(p, _)| Vec3::from(*p)),
        gallbladder: Tube::new(&line, 8),
        pouch: (
            pouch,
            gallbladder::POUCH.1 * a.gallbladder.size * a.gallbladder.width,
        ),
        stomach: Tube::new(&a.stomach.line(stomach::LINE), 6),
        duodenum: Tube::new(&a.duodenum.line(stomach::DUODENUM), 6),
        intestine: Tube::new(&a.intestine.line(&intestine::line()), 4),
        cystic_duct: Tube::new(&a.cystic_duct.line_between(duct, neck, bile), 6),
        bile_duct: Tube::new(&a.bile_duct.line(vessel::BILE_DUCT), 6),
        hepatic_artery: Tube::new(&a.hepatic_artery.line(&hepatic_artery), 6),
        cystic_artery: Tube::new(&artery, 6),
        accessory_artery: Tube::new(vessel::ACCESSORY_ARTERY, 6),
        fat: Tube::new(&a.fat.line(fat::LINE), 4),
        cloak: (a.cover_mm > 0.0).then(|| Tube::new(&fat::cloak(&line, a), 4)),
    }
}
