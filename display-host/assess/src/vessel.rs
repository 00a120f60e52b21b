//! Cystic duct and artery: clips, and how they were divided.

use crate::vector::{Vec3, distance};

/// Leaks as near as this to each other are one, m; so many are remembered.
const SAME_LEAK_M: f64 = 0.000_1;
const LEAKS_MAX: usize = 64;

/// A clip on a vessel.
#[derive(Debug, Clone, Copy)]
struct Clip {
    number: u32,
    at_m: Vec3,
}

/// What became of one of the two vessels.
#[derive(Debug, Clone, Default)]
pub(crate) struct Vessel {
    clips: Vec<Clip>,
    /// Clips that were there when the task began.
    pub(crate) given: usize,
    /// When it was first divided, s, and with how many clips on it.
    pub(crate) divided: Option<(f64, usize)>,
    /// It was divided with clips on it, but none that closes one of the sides.
    pub(crate) one_sided: bool,
    /// That was told.
    is_judged: bool,
    /// Where it leaks, m, and how much: every event of one leak has one place.
    leaking: Vec<(Vec3, f64)>,
    /// It was perforated or torn.
    pub(crate) injured: bool,
}

impl Vessel {
    pub(crate) fn clip(&mut self, number: u32, at_m: Vec3) {
        if self.clips.iter().all(|clip| clip.number != number) {
            self.clips.push(Clip { number, at_m });
        }
    }

    pub(crate) fn clips(&self) -> usize {
        self.given + self.clips.len()
    }

    /// It is divided, and this says whether clips close both sides; of a tear that is told later.
    pub(crate) fn divide(&mut self, at_s: f64, is_closed: Option<bool>) {
        let clips = self.clips();
        let (_, clips) = *self.divided.get_or_insert((at_s, clips));
        if let (Some(is_closed), false) = (is_closed, self.is_judged) {
            self.is_judged = true;
            self.one_sided = clips > 0 && !is_closed;
        }
    }

    /// It leaks so much here from now on.
    pub(crate) fn leak(&mut self, at_m: Vec3, flow: f64) {
        let same = |it: &&mut (Vec3, f64)| distance(it.0, at_m) < SAME_LEAK_M;
        if let Some(leak) = self.leaking.iter_mut().find(same) {
            leak.1 = flow;
        } else if self.leaking.len() < LEAKS_MAX {
            self.leaking.push((at_m, flow));
        }
    }

    /// Whether more than `least` comes out anywhere.
    pub(crate) fn leaks(&self, least: f64) -> bool {
        self.leaking.iter().any(|(_, flow)| *flow > least)
    }

    /// Least distance between two of its clips, m.
    pub(crate) fn spacing_m(&self) -> Option<f64> {
        let pairs = self.clips.iter().enumerate().flat_map(|(i, a)| {
            let others = self.clips.iter().skip(i + 1);
            others.map(|b| distance(a.at_m, b.at_m))
        });
        pairs.min_by(f64::total_cmp)
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.divided.is_none() && !self.injured
    }
}
