//! Clips on cystic duct and artery, and their division.

use shared_mem::message::Event;

use crate::vector::{Vec3, distance, dot, sub};

/// Leaks within this distance of each other are one, m.
const SAME_LEAK_M: f64 = 0.000_1;
/// Largest number of leaks that are kept for a vessel.
const LEAKS_MAX: usize = 64;

/// A clip on a vessel.
#[derive(Debug, Clone, Copy)]
struct Clip {
    number: u32,
    /// The tip of the applier, m.
    at_m: Vec3,
    lies: Lies,
}

/// Seat of a clip. Older sessions do not say it.
#[derive(Debug, Clone, Copy, Default)]
struct Lies {
    /// Place along the vessel at rest, m.
    along_m: Option<f64>,
    /// It leaves a part of the vessel open.
    is_open: bool,
}

/// State of one of the two vessels.
#[derive(Debug, Clone, Default)]
pub(crate) struct Vessel {
    clips: Vec<Clip>,
    /// Seat of the next clip.
    next: Lies,
    /// Clips present when the task began.
    pub(crate) given: usize,
    /// Time of the vessel's first division, s, and the number of clips on it at that time.
    pub(crate) divided: Option<(f64, usize)>,
    /// The vessel was divided with clips on it that do not close both sides.
    pub(crate) one_sided: bool,
    /// Positions of the vessel's leaks, m, and their flows. All events of a leak have one position.
    leaking: Vec<(Vec3, f64)>,
    /// An instructor opened the vessel. What stops its bleeding then is no error.
    pub(crate) opened: bool,
    /// An instructor took a clip off the vessel.
    unclipped: bool,
    /// The trainee put a clip on the vessel while no instructor had opened it.
    pub(crate) touched: bool,
    /// The vessel was perforated or torn.
    pub(crate) injured: bool,
}

impl Vessel {
    /// Takes a clip. Returns true if it leaves a part of the vessel open.
    pub(crate) fn clip(&mut self, number: u32, at_m: Vec3) -> bool {
        self.touched |= !self.opened;
        let lies = core::mem::take(&mut self.next);
        if !self.has_clip(number) {
            self.clips.push(Clip { number, at_m, lies });
        }
        lies.is_open
    }

    /// True if this clip is on the vessel.
    pub(crate) fn has_clip(&self, number: u32) -> bool {
        self.clips.iter().any(|clip| clip.number == number)
    }

    /// Takes what an event says about the next clip.
    pub(crate) fn clip_will(&mut self, seat: &Event, leak: f64) {
        match *seat {
            Event::ClipCloses { share } => self.next.is_open = 1.0 - f64::from(share) > leak,
            Event::ClipAlong { along_m } => self.next.along_m = Some(along_m.into()),
            _ => {}
        }
    }

    /// Takes an instructor's complication: an opened wall, or a clip that slipped off.
    pub(crate) fn complicate(&mut self, event: &Event) {
        match event {
            Event::Opened { .. } => self.opened = true,
            Event::Unclipped { number } => {
                self.unclipped = true;
                match self.clips.iter().position(|clip| clip.number == *number) {
                    Some(at) => drop(self.clips.swap_remove(at)),
                    None => self.given = self.given.saturating_sub(1),
                }
            }
            _ => {}
        }
    }

    /// True if an instructor opened the vessel or took a clip off, so that its leaks are no error.
    pub(crate) fn is_excused(&self) -> bool {
        self.opened || self.unclipped
    }

    /// Number of clips that close the vessel.
    pub(crate) fn clips(&self) -> usize {
        self.given + self.clips.iter().filter(|clip| !clip.lies.is_open).count()
    }

    /// Records a division. `is_closed` is true if clips close both sides.
    pub(crate) fn divide(&mut self, at_s: f64, is_closed: bool) {
        let clips = self.clips();
        if self.divided.is_none() {
            self.divided = Some((at_s, clips));
            self.one_sided = clips > 0 && !is_closed;
        }
    }

    /// Sets the flow of a leak at this position.
    pub(crate) fn leak(&mut self, at_m: Vec3, flow: f64) {
        let same = |it: &&mut (Vec3, f64)| distance(it.0, at_m) < SAME_LEAK_M;
        if let Some(leak) = self.leaking.iter_mut().find(same) {
            leak.1 = flow;
        } else if self.leaking.len() < LEAKS_MAX {
            self.leaking.push((at_m, flow));
        }
    }

    /// True if any leak exceeds `least`.
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

    /// Room for the cut: largest distance between neighbouring clips along the vessel at rest, m.
    /// Clips that close one side may lie close together. Older sessions have the applier's places
    /// alone: there it is the distance along the line through the farthest two.
    pub(crate) fn room_m(&self) -> Option<f64> {
        let closed = self.clips.iter().filter(|clip| !clip.lies.is_open);
        let places: Option<Vec<f64>> = closed.map(|clip| clip.lies.along_m).collect();
        match places {
            Some(places) => widest_gap(places),
            None => self.room_of_applier_m(),
        }
    }

    fn room_of_applier_m(&self) -> Option<f64> {
        let pairs = self.clips.iter().enumerate().flat_map(|(number, a)| {
            let others = self.clips.iter().skip(number + 1);
            others.map(move |b| (distance(a.at_m, b.at_m), a, b))
        });
        let (length_m, from, to) = pairs.max_by(|one, other| one.0.total_cmp(&other.0))?;
        let along = sub(to.at_m, from.at_m).map(|x| x / length_m.max(1e-9));
        let places = self.clips.iter();
        widest_gap(
            places
                .map(|clip| dot(sub(clip.at_m, from.at_m), along))
                .collect(),
        )
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.divided.is_none() && !self.injured
    }
}

/// Largest gap between neighbours of these places.
fn widest_gap(mut places: Vec<f64>) -> Option<f64> {
    places.sort_by(f64::total_cmp);
    let gaps = places.iter().zip(places.iter().skip(1));
    gaps.map(|(one, next)| next - one).max_by(f64::total_cmp)
}
