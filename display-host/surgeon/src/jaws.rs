//! Work with scissors and clip applier: finds a place along a vessel with room to get there and
//! back.

use shared_mem::message::CapsuleMsg;
use shared_mem::scene::OrganKind;
use shared_mem::words::{CapsuleRole, Instrument};

use crate::plan::{Act, CUT};
use crate::sight::{Bar, Place, between};
use crate::vector::{Vec3, wide};
use crate::work::{BACK_M, JAW_M, Work};

/// Radius of a jaw, m (`rt_core::tool`).
const JAW_RADIUS_M: f64 = 0.0015;
/// Largest number of attempts at a vessel.
const ATTEMPTS: u32 = 4;
/// Largest number of clips at a place: the one that was meant, and another if it leaves the vessel
/// open.
const CLIPS_MAX: usize = 2;
/// A clip that closes less than this share of a vessel leaves it open.
const CLOSED: f32 = 0.99;
/// Number of steps along a vessel at which a careful surgeon looks for another place than the
/// intended one.
const STEPS: u32 = 25;
/// Least distance between a clip and the cut, as a share of the vessel's length. A clip stays on
/// its own side of the cut.
const CLIP_APART: f64 = 0.12;
/// Largest distance between a cut and its intended place, as a share of the vessel's length.
const CUT_ASIDE: f64 = 0.1;
/// Least distance between two attempts, as a share of the vessel's length. Another attempt follows
/// a clip that does not close, a cut without effect, or another tube between the jaws.
const BITTEN_APART: f64 = 0.035;
/// Least distance between a cut and any clip, m. Scissors do not cut a vessel under a clip.
const GUARDED_M: f64 = 0.0035;
/// Length of the approach that is checked for room, m.
const WAY_M: f64 = 0.05;
/// Room on the approach that is enough, m. More room makes a place no better.
const ROOM_M: f64 = 0.008;
/// Room that a place loses in the comparison for each vessel length between it and the intended
/// place, m.
const ASIDE_M: f64 = 0.01;
/// A tube farther than this from the axis midway between the jaws stays outside the jaws, m. It is
/// half of the jaws' opening plus the error of aim.
const ALONE_M: f64 = 0.006;
/// A place that moves by this distance during the approach counts as pushed, m. Each further
/// attempt allows half as much more.
const PUSHED_M: f64 = 0.008;
/// Largest distance between the place and the jaws' biting point at which the jaws are closed, m.
/// Beyond it they would close on nothing.
const MISSED_M: f64 = 0.004;

impl Work<'_> {
    /// Clips or cuts at a share of the way along an organ. After a failure, tries again beside that
    /// place, `ATTEMPTS` times in all.
    pub(crate) fn bite(&mut self, kind: OrganKind, share: f64) -> Result<(), String> {
        if self.sight.along(kind, share, &self.seen.state).is_none() {
            return Err("the scene has no such vessel".to_owned());
        }
        let before = match self.seen.tools.instrument() {
            // Both vessels may have been between the blades, so that an earlier cut has divided
            // this one.
            Ok(Instrument::Scissors) if self.worked(kind) > 0 => return Ok(()),
            _ => self.worked(kind),
        };
        if self.is_cut_unclipped(kind) {
            return Err("not clipped on both sides: not cut".to_owned());
        }
        let mut bitten = Vec::new();
        for attempt in 0..ATTEMPTS {
            let at = self.attempted(kind, share, attempt, &bitten);
            let missed = self.approach(kind, at, attempt).err();
            self.goes_on()?;
            // The last attempt closes the jaws even if another tube lies between them.
            let is_last = attempt + 1 == ATTEMPTS;
            let is_there = self.is_worth_closing(kind, at);
            let takes_another = is_there && self.takes_another(kind);
            let closes = is_there && (is_last || !takes_another);
            if closes {
                self.act(Act::Close)?;
            }
            let done = self.worked(kind) > before;
            let is_tried = done || takes_another || closes && self.has_scissors();
            bitten.extend(is_tried.then_some(at));
            self.retreat(BACK_M)?;
            match (done, missed) {
                (true, _)
                    if self.worked(kind) < before + CLIPS_MAX
                        && self.is_open_behind_its_clip(kind) =>
                {
                    self.theatre
                        .tell("the clip does not close the vessel: another goes beside it");
                }
                (true, _) => {
                    self.closed.push((kind, share < CUT));
                    return Ok(());
                }
                (false, Some(why)) => self.theatre.tell(&why),
                (false, None) => {}
            }
        }
        Err(format!("{ATTEMPTS} attempts failed"))
    }

    /// Moves to a share of the way along a tube, or to the near side of another organ.
    pub(crate) fn approach(
        &mut self,
        kind: OrganKind,
        share: f64,
        attempt: u32,
    ) -> Result<(), String> {
        let solid = self.sight.organ(kind).filter(|it| !self.sight.is_tube(*it));
        let sphere = solid.and_then(|it| self.sight.nearest(it, self.tip(), &self.seen.state));
        let place = |work: &Self| match sphere {
            Some(sphere) => Some(Place {
                at: work.sight.now(sphere, &work.seen.state),
                along: None,
            }),
            None => work.sight.along(kind, share, &work.seen.state),
        };
        // The jaws first go to a point in front of the place, so that they sweep nothing along on
        // the way.
        self.reach(&place, BACK_M, true)?;
        let Some(before) = place(self).filter(|_| self.looks_first()) else {
            return self.reach(&place, 0.0, false);
        };
        let most_m = PUSHED_M * (1.0 + 0.5 * f64::from(attempt));
        // A place that the jaws push ahead is never reached, and its tissue tears.
        let unless_pushed = |work: &Self| {
            let stays = |now: &Place| (now.at - before.at).norm() < most_m;
            place(work).filter(stays)
        };
        self.reach(&unless_pushed, 0.0, false)
    }

    /// Place for this attempt, as a share of the way. It may differ from the intended place,
    /// because tissue gives way, and other tubes may lie in front of a place or next to it.
    fn attempted(&self, kind: OrganKind, share: f64, attempt: u32, bitten: &[f64]) -> f64 {
        if !self.looks_first() {
            let side = if attempt.is_multiple_of(2) {
                0.02
            } else {
                -0.02
            };
            return share + side * f64::from(attempt);
        }
        let is_cut = self.has_scissors();
        let is_guarded = |place: f64| is_cut && self.clip_m(kind, place) < GUARDED_M;
        // The first attempt takes the intended place, if nothing else lies there. Other attempts
        // take the place with the most room.
        if attempt == 0 && self.alone_m(kind, share) > ALONE_M && !is_guarded(share) {
            return share;
        }
        roomiest(share, is_cut, bitten, |place| {
            let alone_m = self.alone_m(kind, place).min(ALONE_M);
            let room_m = self.room_on_the_way(kind, place).min(ROOM_M);
            if is_guarded(place) {
                return -ROOM_M;
            }
            alone_m + room_m
        })
    }

    /// Distance between a place along an organ and the nearest clip, m.
    fn clip_m(&self, kind: OrganKind, share: f64) -> f64 {
        let state = &self.seen.state;
        let Some(Place { at, .. }) = self.sight.along(kind, share, state) else {
            return 0.0;
        };
        let clips = self.sight.clips(state);
        let away_m = clips.iter().map(|clip| (clip - at).norm());
        away_m.fold(f64::MAX, f64::min)
    }

    /// Distance between the nearest other tube and the axis midway between jaws at this place, m.
    fn alone_m(&self, kind: OrganKind, share: f64) -> f64 {
        let state = &self.seen.state;
        let Some(Place { at, .. }) = self.sight.along(kind, share, state) else {
            return 0.0;
        };
        let along = (at - self.sight.port()).try_normalize(1e-9);
        let taken = jaws_at(at, along.unwrap_or_default(), self.bite_share());
        let others = self.sight.tubes_beside(kind, state);
        let room_m = others.iter();
        let room_m = room_m.map(|bar| between(taken, bar.ends).norm() - bar.radius_m);
        room_m.fold(f64::MAX, f64::min)
    }

    /// Room between the last `WAY_M` of the straight path from the port to a place and structures
    /// that must not be touched, m.
    fn room_on_the_way(&self, kind: OrganKind, share: f64) -> f64 {
        let state = &self.seen.state;
        let Some(Place { at, .. }) = self.sight.along(kind, share, state) else {
            return 0.0;
        };
        let out = (self.sight.port() - at).normalize();
        let bars = self.sight.touchy(at, WAY_M, state);
        let room_m = bars.iter().map(|bar| {
            let away = between([at + out * WAY_M, at], bar.ends);
            away.norm() - bar.radius_m
        });
        room_m.fold(f64::MAX, f64::min)
    }

    /// True if a careful surgeon would be cutting a vessel that clips do not close on both sides.
    fn is_cut_unclipped(&self, kind: OrganKind) -> bool {
        let is_cut = self.has_scissors();
        // The surgeon does not know of clips that were placed before the task began.
        let has_clipped = self.clipped.iter().any(|organ| *organ != u32::MAX);
        let is_closed = [true, false].map(|side| self.closed.contains(&(kind, side)));
        self.looks_first() && is_cut && has_clipped && is_closed != [true; 2]
    }

    fn has_scissors(&self) -> bool {
        self.seen.tools.has(Instrument::Scissors)
    }

    fn looks_first(&self) -> bool {
        self.surgeon.is_careful() && self.has_jaws()
    }

    /// True if the place is near the jaws' biting point, or if the surgeon does not look first.
    fn is_worth_closing(&self, kind: OrganKind, share: f64) -> bool {
        let place = self.sight.along(kind, share, &self.seen.state);
        let is_near = |place: Place| (place.at - self.bite_at()).norm() < MISSED_M;
        !self.looks_first() || place.is_some_and(is_near)
    }

    /// True if a careful surgeon sees another tube between the jaws.
    fn takes_another(&self, kind: OrganKind) -> bool {
        let tools = &self.seen.tools;
        let jaws: Vec<&CapsuleMsg> = (tools.capsules.iter().take(tools.capsule_count as usize))
            .filter(|part| part.is(CapsuleRole::UpperJaw) || part.is(CapsuleRole::LowerJaw))
            .collect();
        let &[upper, lower] = jaws.as_slice() else {
            return false;
        };
        let others = self.sight.tubes_beside(kind, &self.seen.state);
        let jaws = [upper, lower].map(|jaw| [jaw.a_m, jaw.b_m].map(wide));
        self.looks_first() && others.iter().any(|bar| lies_between(jaws, bar))
    }

    /// True if a careful surgeon sees that the last clip leaves the vessel open.
    fn is_open_behind_its_clip(&self, kind: OrganKind) -> bool {
        let closes = self.sight.last_clip_closes(kind, &self.seen.state);
        self.surgeon.is_careful()
            && self.seen.tools.has(Instrument::ClipApplier)
            && closes.is_some_and(|share| share < CLOSED)
    }

    /// Number of times that an organ was clipped or, with scissors in hand, divided.
    fn worked(&self, kind: OrganKind) -> usize {
        let organ = self.sight.organ(kind);
        let of = |index: &&u32| Some(**index as usize) == organ;
        let done = match self.seen.tools.instrument() {
            Ok(Instrument::Scissors) => &self.divided,
            _ => &self.clipped,
        };
        done.iter().filter(of).count()
    }
}

/// Place along a vessel with the most room, as `room_m` gives it, among those allowed for a clip or
/// cut meant for `share`. Places near those in `bitten` are left out.
fn roomiest(share: f64, is_cut: bool, bitten: &[f64], room_m: impl Fn(f64) -> f64) -> f64 {
    let fits = |place: f64| match is_cut {
        true => (place - share).abs() < CUT_ASIDE,
        false => (place - CUT).abs() > CLIP_APART && (place < CUT) == (share < CUT),
    };
    let is_new = |place: f64| bitten.iter().all(|it| (it - place).abs() > BITTEN_APART);
    let places = (2..STEPS).map(|step| f64::from(step) / f64::from(STEPS));
    let rated = places
        .filter(|place| fits(*place) && is_new(*place))
        .map(|place| (room_m(place) - ASIDE_M * (place - share).abs(), place));
    let best = rated.max_by(|one, other| one.0.total_cmp(&other.0));
    best.map_or(share, |best| best.1)
}

/// Axis midway between jaws, from hinge to end, when they have come along `along` and take a vessel
/// at this place, at this share of their length.
fn jaws_at(place: Vec3, along: Vec3, bite: f64) -> [Vec3; 2] {
    [-bite, 1.0 - bite].map(|share| place + along * (share * JAW_M))
}

/// True if part of the bar lies between open jaws, each given from hinge to end.
fn lies_between([upper, lower]: [[Vec3; 2]; 2], bar: &Bar) -> bool {
    let ends = [upper[1], lower[1]];
    let hinge = (upper[0] + lower[0]) * 0.5;
    let (middle, across) = (ends[0].lerp(&ends[1], 0.5), ends[0] - ends[1]);
    let off = between([hinge, middle], bar.ends);
    let aside = across.try_normalize(1e-9).unwrap_or_default();
    // Offsets from the axis: along the opening, and out of the plane of closing.
    let opened_m = off.dot(&aside).abs();
    let out_m = (off - aside * off.dot(&aside)).norm();
    opened_m < 0.5 * across.norm() && out_m < JAW_RADIUS_M + bar.radius_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::BITE;

    const WIDE: [[Vec3; 2]; 2] = [
        [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.0, 0.004, -0.014)],
        [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.0, -0.004, -0.014)],
    ];

    fn tube(at: [f64; 3]) -> Bar {
        let (at, half) = (Vec3::from(at), Vec3::x() * 0.01);
        Bar {
            ends: [at - half, at + half],
            radius_m: 0.001,
            is_touchy: false,
            tube: None,
            rise_k: 0.0,
        }
    }

    #[test]
    fn jaws_take_what_lies_between_them_and_nothing_else() {
        for (at, is_taken) in [
            ([0.0, 0.0, -0.010], true),
            ([0.0, 0.003, -0.012], true),
            // Beside a jaw, in front of their ends, behind the hinge, beside both.
            ([0.0, 0.006, -0.010], false),
            ([0.0, 0.0, -0.020], false),
            ([0.0, 0.0, 0.005], false),
            ([0.015, 0.0, -0.010], false),
        ] {
            assert_eq!(lies_between(WIDE, &tube(at)), is_taken, "{at:?}");
        }
        let closed = WIDE.map(|[hinge, end]| [hinge, Vec3::new(0.0, 0.0, end.z)]);
        assert!(!lies_between(closed, &tube([0.0, 0.0, -0.010])));
    }

    #[test]
    fn a_clip_comes_where_there_is_room_on_its_own_side_of_the_cut() {
        let everywhere = |_: f64| 0.0;
        assert!((roomiest(0.45, false, &[], everywhere) - 0.45).abs() < 0.02);
        // All the room is at the far end: each stays on its own side of the cut.
        let far = |place: f64| place;
        let body = roomiest(0.45, false, &[], far);
        assert!(body > 0.45 && body < CUT - CLIP_APART, "{body}");
        let near = |place: f64| -place;
        let bag = roomiest(0.8, false, &[], near);
        assert!(bag > CUT + CLIP_APART && bag < 0.8 + 0.04, "{bag}");
        // The cut stays near the intended place, whatever the room.
        let cut = roomiest(CUT, true, &[], far);
        assert!(cut > CUT && cut < CUT + CUT_ASIDE, "{cut}");
    }

    #[test]
    fn another_clip_comes_beside_those_that_are_there() {
        let everywhere = |_: f64| 0.0;
        let mut bitten = Vec::new();
        for _ in 0..4 {
            let place = roomiest(0.45, false, &bitten, everywhere);
            let apart = bitten.iter().map(|it: &f64| (it - place).abs());
            assert!(apart.fold(f64::MAX, f64::min) > BITTEN_APART, "{place}");
            bitten.push(place);
        }
        // If no place is left, the intended one is taken.
        let all: Vec<f64> = (0..100).map(|it| 0.01 * f64::from(it)).collect();
        let last = roomiest(0.45, false, &all, everywhere);
        assert!((last - 0.45).abs() < 1.0e-9, "{last}");
    }

    #[test]
    fn jaws_reach_over_the_place_from_both_sides() {
        let [hinge, end] = jaws_at(Vec3::zeros(), -Vec3::z(), BITE);
        assert!(hinge.z > 0.0 && end.z < 0.0, "{hinge} {end}");
        assert!(((hinge - end).norm() - JAW_M).abs() < 1.0e-9);
    }
}
