//! With scissors and clip applier: where along a vessel there is a way to it, there and back.

use shared_mem::scene::OrganKind;

use crate::plan::{Act, CLIPS, CUT, SCISSORS, Surgeon};
use crate::sight::{Place, between};
use crate::work::{BACK_M, Work};

/// How often a vessel that was missed is tried.
const ATTEMPTS: u32 = 4;
/// A clip that closes less of a vessel does not close it.
const CLOSED: f32 = 0.99;
/// A careful surgeon may take a vessel beside the place meant, in so many steps along it: clips stay on their side
/// of the cut and so far from it, the cut nearer to where it was meant, as shares of its length.
const STEPS: u32 = 25;
const CLIP_APART: f64 = 0.12;
const CUT_ASIDE: f64 = 0.06;
/// A clip that does not close gets another so far beside it.
const BITTEN_APART: f64 = 0.035;
/// The way there is looked at for so long, m; more room than this is enough.
const WAY_M: f64 = 0.05;
const ROOM_M: f64 = 0.008;
/// What is beside the place by a whole length counts as so much less room, m.
const ASIDE_M: f64 = 0.01;
/// A place that goes away by so much while one comes near it is pushed, m; each time more is borne.
const PUSHED_M: f64 = 0.008;
/// Farther off than this jaws would close on nothing, m.
const MISSED_M: f64 = 0.004;

impl Work<'_> {
    /// Clips or cuts at a share of the way along an organ; again, beside it, until something came of it.
    pub(crate) fn bite(&mut self, kind: OrganKind, share: f64) -> Result<(), String> {
        let before = match self.seen.tools.instrument {
            // Both vessels may have lain between the blades.
            SCISSORS if self.worked(kind) > 0 => return Ok(()),
            _ => self.worked(kind),
        };
        if self.is_cut_unclipped(kind) {
            return Err("it is not closed on both sides: left".to_owned());
        }
        let mut bitten = Vec::new();
        for attempt in 0..ATTEMPTS {
            let at = self.attempted(kind, share, attempt, &bitten);
            let missed = self.approach(kind, at, attempt).err();
            self.goes_on()?;
            if self.is_worth_closing(kind, at) {
                self.act(Act::Close)?;
            }
            let done = self.worked(kind) > before;
            bitten.extend(done.then_some(at));
            self.retreat(BACK_M)?;
            match (done, missed) {
                (true, _) if self.is_open_behind_its_clip(kind) => {
                    self.theatre
                        .tell("the clip does not close it: another beside it");
                }
                (true, _) => {
                    self.closed.push((kind, share < CUT));
                    return Ok(());
                }
                (false, Some(why)) => self.theatre.tell(&why),
                (false, None) => {}
            }
        }
        Err(format!("nothing came of {ATTEMPTS} attempts"))
    }

    /// Goes to a share of the way along an organ.
    pub(crate) fn approach(
        &mut self,
        kind: OrganKind,
        share: f64,
        attempt: u32,
    ) -> Result<(), String> {
        let place = |work: &Self| work.sight.along(kind, share, &work.seen.state);
        // Beside it first, so that nothing is swept along on the way.
        self.reach(&place, BACK_M, true)?;
        let Some(before) = place(self).filter(|_| self.looks_first()) else {
            return self.reach(&place, 0.0, false);
        };
        let most_m = PUSHED_M * (1.0 + 0.5 * f64::from(attempt));
        // What one pushes before one is never reached, and tears.
        let unless_pushed = |work: &Self| {
            let stays = |now: &Place| (now.at - before.at).norm() < most_m;
            place(work).filter(stays)
        };
        self.reach(&unless_pushed, 0.0, false)
    }

    /// Where it is tried this time: tissue gives way, and other tubes may lie before a place.
    fn attempted(&self, kind: OrganKind, share: f64, attempt: u32, bitten: &[f64]) -> f64 {
        if !self.looks_first() {
            let side = if attempt.is_multiple_of(2) {
                0.02
            } else {
                -0.02
            };
            return share + side * f64::from(attempt);
        }
        // First where it was meant, then where there is most room.
        let is_cut = self.seen.tools.instrument == SCISSORS;
        let fits = |place: f64| match is_cut {
            true => (place - share).abs() < CUT_ASIDE,
            false => (place - CUT).abs() > CLIP_APART && (place < CUT) == (share < CUT),
        };
        let places = (2..STEPS).map(|step| f64::from(step) / f64::from(STEPS));
        let is_new = |place: f64| bitten.iter().all(|it| (it - place).abs() > BITTEN_APART);
        let fitting = places.filter(|it| attempt > 0 && fits(*it) && is_new(*it));
        let rated = fitting.map(|place| {
            let room_m = self.room_on_the_way(kind, place).min(ROOM_M);
            (room_m - ASIDE_M * (place - share).abs(), place)
        });
        let best = rated.max_by(|one, other| one.0.total_cmp(&other.0));
        best.map_or(share, |best| best.1)
    }

    /// How far what must not be touched is from the straight way between port and place, m.
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

    /// Whether a careful surgeon would cut what its clips do not close on both sides.
    fn is_cut_unclipped(&self, kind: OrganKind) -> bool {
        let is_cut = self.seen.tools.instrument == SCISSORS;
        // Of clips that were there before it came it knows nothing.
        let has_clipped = !self.clipped.is_empty();
        let is_closed = [true, false].map(|side| self.closed.contains(&(kind, side)));
        self.looks_first() && is_cut && has_clipped && is_closed != [true; 2]
    }

    fn looks_first(&self) -> bool {
        self.surgeon == Surgeon::Careful && self.has_jaws()
    }

    /// Whether a careful surgeon sees the vessel between the jaws.
    fn is_worth_closing(&self, kind: OrganKind, share: f64) -> bool {
        let place = self.sight.along(kind, share, &self.seen.state);
        let is_near = |place: Place| (place.at - self.bite_at()).norm() < MISSED_M;
        !self.looks_first() || place.is_some_and(is_near)
    }

    /// Whether a careful surgeon sees that what it clipped last is not closed by that clip.
    fn is_open_behind_its_clip(&self, kind: OrganKind) -> bool {
        let closes = self.sight.last_clip_closes(kind, &self.seen.state);
        self.surgeon == Surgeon::Careful
            && self.seen.tools.instrument == CLIPS
            && closes.is_some_and(|share| share < CLOSED)
    }

    /// How often an organ was clipped, or with scissors in hand: divided.
    fn worked(&self, kind: OrganKind) -> usize {
        let organ = self.sight.organ(kind);
        let of = |index: &&u32| Some(**index as usize) == organ;
        let done = match self.seen.tools.instrument {
            SCISSORS => &self.divided,
            _ => &self.clipped,
        };
        done.iter().filter(of).count()
    }
}
