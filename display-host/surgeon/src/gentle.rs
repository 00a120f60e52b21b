//! With the hook among what must not be touched: slower the nearer it comes, and back out again.

use crate::hold::{Hook, WORKS};
use crate::sight::Bar;
use crate::work::{Vec3, Work};

/// The hook is not held nearer than this to what it must not touch, m; it turns more slowly within the
/// other, and comes nearer by no more than so much of the room that is left in a quarter of a second.
pub(crate) const ROOM_M: f64 = 0.0007;
const SHY_M: f64 = 0.0015;
const SLOWS: f64 = 3.0;
/// It turns no faster than this, rad/s.
const TURN_RAD_S: f64 = 1.9;
/// A cell that does not get nearer or warmer for so long is left, s; so is a way.
pub(crate) const STUCK_S: f64 = 0.7;
/// Less than this is not nearer, m.
pub(crate) const CLOSER_M: f64 = 0.0002;
/// Where it is caught it goes in by so much, m, and turns a quarter; so often.
const UNHOOK_M: f64 = 0.005;
const UNHOOKS: u32 = 5;
/// A way out is over within so much, m, or so long, s.
const OUT_ENOUGH_M: f64 = 0.006;
const LONG_WAY_S: f64 = 6.0;
/// A duct or vessel that is as near to the hook as this may hang on it, m; if it has come along by so much it does, m.
const HANGS_M: f64 = 0.0012;
const COMES_ALONG_M: f64 = 0.004;

impl Work<'_> {
    /// Where the hook works.
    pub(crate) fn works(&self) -> Vec3 {
        match self.electrode() {
            Some([heel, end]) => heel.lerp(&end, WORKS),
            None => self.tip(),
        }
    }

    /// How far the hook is off a way to turn, about the shaft, rad.
    fn turned_off(&self, bend: Vec3) -> f64 {
        let local = self.to_instrument(bend);
        local.x.atan2(-local.y)
    }

    /// Back along the shaft, without current.
    pub(crate) fn withdraw(&mut self, by_m: f64) -> Result<(), String> {
        self.asked.switches = 0;
        let out = -self.along();
        let to = self.works() + out * by_m;
        for _ in 0..UNHOOKS {
            let Some([heel, end]) = self.electrode() else {
                return Ok(());
            };
            let bend = (end - heel).normalize();
            if !self.travel(&|_| to, bend, 1.0)? {
                return Ok(());
            }
            self.unhook(out, bend)?;
        }
        Ok(())
    }

    /// In again, and a quarter round, where something hangs on the hook that came out this way.
    fn unhook(&mut self, out: Vec3, bend: Vec3) -> Result<(), String> {
        let (caught, turned) = (self.works(), out.cross(&bend));
        self.travel(&|_| caught - out * UNHOOK_M, bend, 1.0)?;
        self.travel(&|_| caught - out * UNHOOK_M, turned, 1.5)?;
        Ok(())
    }

    /// Far back along the shaft. Where its bent end is caught behind a tube, to pull would tear that: it goes in
    /// again, turns, and tries anew.
    pub(crate) fn come_out(&mut self, by_m: f64) -> Result<(), String> {
        self.asked.switches = 0;
        let out = -self.along();
        let to = self.works() + out * by_m;
        for _ in 0..UNHOOKS {
            let Some([heel, end]) = self.electrode() else {
                return Ok(());
            };
            let bend = (end - heel).normalize();
            let hangs = self.travel(&|_| to, bend, LONG_WAY_S)?;
            if !hangs && (to - self.works()).dot(&out) < OUT_ENOUGH_M {
                return Ok(());
            }
            self.unhook(out, bend)?;
        }
        Err("the hook is caught".to_owned())
    }

    /// The hook goes to a place, as far as there is room, and turns; for so long at most. Whether it stopped for
    /// something that came along.
    pub(crate) fn travel(
        &mut self,
        to: &dyn Fn(&Self) -> Vec3,
        bend: Vec3,
        seconds: f64,
    ) -> Result<bool, String> {
        let mut before_s = self.seen.at_s;
        let (mut hanging, mut hangs) = (None, false);
        let (mut nearest_m, mut nearer_s) = (f64::MAX, before_s);
        self.look_for(seconds, |work| {
            let passed_s = (work.seen.at_s - before_s).clamp(0.0, 0.05);
            before_s = work.seen.at_s;
            let way = to(work) - work.works();
            if way.norm() < nearest_m - CLOSER_M {
                (nearest_m, nearer_s) = (way.norm(), work.seen.at_s);
            }
            hangs = work.comes_along(&mut hanging);
            if hangs {
                return true;
            }
            // What it must not touch is in the way, or it is there.
            if work.seen.at_s - nearer_s > STUCK_S {
                return true;
            }
            work.go_gently(way * 2.5, bend, passed_s);
            let off = work.turned_off(bend);
            way.norm() < 0.002 && off.abs() < 1.0
        });
        self.goes_on()?;
        Ok(hangs)
    }

    /// Whether the duct or vessel that is nearest to the hook has come along with it: `hanging` keeps its sphere, and
    /// where that was when the hook came to it.
    fn comes_along(&self, hanging: &mut Option<(usize, Vec3)>) -> bool {
        let (Some(electrode), state) = (self.electrode(), &self.seen.state) else {
            return false;
        };
        let hook = Hook::seen(electrode, self.sight.port());
        let tubes = self.sight.delicate(self.works(), 0.03, state);
        let tubes = tubes.iter().filter(|bar| bar.tube.is_some());
        let room_m = |bar: &&Bar| hook.room([*bar]).0;
        let nearest = tubes.min_by(|a, b| room_m(a).total_cmp(&room_m(b)));
        let near = nearest.filter(|bar| room_m(bar) < HANGS_M);
        let near = near.and_then(|bar| bar.tube.map(|sphere| (sphere, bar.ends[0])));
        hangs(hanging, near, |sphere| self.sight.now(sphere, state))
    }

    /// How much room the hook has to what it must not touch, m, and the way from there.
    fn room(&self) -> (f64, Vec3) {
        let Some(electrode) = self.electrode() else {
            return (f64::MAX, Vec3::zeros());
        };
        let hook = Hook::seen(electrode, self.sight.port());
        hook.room(&self.sight.touchy(self.works(), 0.07, &self.seen.state))
    }

    /// Moves and turns for so long, the slower the nearer it comes to what it must not touch.
    pub(crate) fn go_gently(&mut self, way: Vec3, bend: Vec3, seconds: f64) {
        let (room_m, away) = self.room();
        let room_m = self.nearing.soon(room_m, seconds);
        let towards_m = (-way.dot(&away)).max(0.0);
        let most_m = SLOWS * (room_m - ROOM_M);
        let way = way + away * (towards_m - most_m).max(0.0);
        self.go(way, seconds);
        let share = ((room_m - ROOM_M) / SHY_M).clamp(0.1, 1.0);
        let off = self.turned_off(bend);
        self.turn_within(off, seconds * share, TURN_RAD_S);
    }
}

/// Whether what was near first, and something has been since, has gone far from where it was then: `near` is a sphere
/// that is near now, if one is, and where it is.
fn hangs(
    hanging: &mut Option<(usize, Vec3)>,
    near: Option<(usize, Vec3)>,
    now: impl Fn(usize) -> Vec3,
) -> bool {
    *hanging = near.map(|near| hanging.unwrap_or(near));
    hanging.is_some_and(|(sphere, was)| (now(sphere) - was).norm() > COMES_ALONG_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duct_hangs_on_the_hook_once_it_has_come_along() {
        let at = |mm: f64| Vec3::x() * (mm * 1e-3);
        let mut hanging = None;
        let mut look = |sphere: Option<usize>, moved_mm: f64| {
            hangs(&mut hanging, sphere.map(|it| (it, at(moved_mm))), |_| {
                at(moved_mm)
            })
        };
        // It came near at 2 mm; another sphere of it may be the nearest later.
        assert!(!look(Some(7), 2.0) && !look(Some(8), 5.0));
        assert!(look(Some(8), 6.5));
        // What the hook has left hangs no more, however far it goes.
        assert!(!look(None, 20.0) && !look(Some(7), 20.0) && !look(Some(7), 17.0));
        assert!(look(Some(7), 15.5));
    }
}
