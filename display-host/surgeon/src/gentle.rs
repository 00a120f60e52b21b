//! Gentle motion of the hook among structures that must not be touched. The hook slows as it comes
//! nearer to one, and finds its way back out.

use crate::hold::{Hook, WORKS};
use crate::sight::Bar;
use crate::vector::{Vec3, wide};
use crate::work::Work;

/// Least distance between the hook and a structure that it must not touch, m.
pub(crate) const ROOM_M: f64 = 0.0007;
/// Room beyond `ROOM_M` below which the hook turns more slowly, m.
const SHY_M: f64 = 0.0015;
/// Largest approach in a quarter of a second, as a multiple of the room beyond `ROOM_M`.
const SLOWS: f64 = 3.0;
/// Largest rate of turn, rad/s.
const TURN_RAD_S: f64 = 1.9;
/// A cell or a path is given up after this time without getting nearer or warmer, s.
pub(crate) const STUCK_S: f64 = 0.7;
/// Smallest approach that counts as getting nearer, m.
pub(crate) const CLOSER_M: f64 = 0.0002;
/// Distance that the surgeon moves in to free a caught hook, m.
const UNHOOK_M: f64 = 0.005;
/// Largest distance that the surgeon carries the caught tube back towards its place, m.
const HOME_M: f64 = 0.02;
/// Largest number of attempts to free a caught hook. Each turns the hook by a quarter.
const UNHOOKS: u32 = 5;
/// Distance within which a movement has arrived, m.
const THERE_M: f64 = 0.0015;
/// Angle within which a turn has arrived, rad.
const TURNED_RAD: f64 = 0.3;
/// Longest time for a short movement, s.
const SHORT_WAY_S: f64 = 1.0;
/// Longest time for a turn, s.
const TURN_WAY_S: f64 = 1.5;
/// A far withdrawal is done when less than this is left of it, m.
const OUT_ENOUGH_M: f64 = 0.006;
/// Longest time for one attempt at a far withdrawal, s.
const LONG_WAY_S: f64 = 6.0;
/// A duct or vessel within this distance of the hook may hang on the hook, m.
const HANGS_M: f64 = 0.0012;
/// A duct or vessel that has moved along with the hook by this distance hangs on the hook, m.
const COMES_ALONG_M: f64 = 0.004;

/// Force on the hand below which the surgeon moves on though a tube comes along, N. Loose fat and
/// the ducts in it follow a hook at less force, and slip off it. If the hand stopped for them, it
/// would not get out of the fat of some patients
/// (`patients::careful_surgeon_opens_the_cover_without_injury`).
const HANGS_N: f64 = 0.05;

/// A sphere of a duct or vessel that may hang on the hook, and its position when the hook came
/// near.
pub(crate) type Hanging = (usize, Vec3);

impl Work<'_> {
    /// The working point of the hook, m.
    pub(crate) fn works(&self) -> Vec3 {
        match self.electrode() {
            Some([heel, end]) => heel.lerp(&end, WORKS),
            None => self.tip(),
        }
    }

    /// Angle about the shaft between the hook and a direction, rad.
    fn turned_off(&self, bend: Vec3) -> f64 {
        let local = self.to_instrument(bend);
        local.x.atan2(-local.y)
    }

    /// Withdraws along the shaft, without current.
    pub(crate) fn withdraw(&mut self, by_m: f64) -> Result<(), String> {
        self.back(by_m, f64::MAX, SHORT_WAY_S).map(|_| ())
    }

    /// Withdraws far along the shaft.
    pub(crate) fn come_out(&mut self, by_m: f64) -> Result<(), String> {
        match self.back(by_m, OUT_ENOUGH_M, LONG_WAY_S)? {
            true => Ok(()),
            false => Err("the hook is caught".to_owned()),
        }
    }

    /// Withdraws along the shaft to within `enough_m` of the whole way; returns true if it came
    /// out. A bent end that is caught behind a tube is freed first, because pulling would tear the
    /// tube.
    fn back(&mut self, by_m: f64, enough_m: f64, seconds: f64) -> Result<bool, String> {
        self.asked.switches = 0;
        let out = -self.along();
        let to = self.works() + out * by_m;
        let mut free = None;
        for _ in 0..UNHOOKS {
            let Some([heel, end]) = self.electrode() else {
                return Ok(true);
            };
            let bend = (end - heel).normalize();
            let hanging = self.travel(&|_| to, bend, seconds)?;
            if hanging.is_none() && (to - self.works()).dot(&out) < enough_m {
                return Ok(true);
            }
            // Each attempt goes to the same position and turns the hook farther. New positions
            // would lead the caught tube away step by step.
            let free = *free.get_or_insert_with(|| self.loose(hanging) - out * UNHOOK_M);
            self.steer(free, bend, SHORT_WAY_S)?;
            self.steer(free, out.cross(&bend), TURN_WAY_S)?;
        }
        Ok(false)
    }

    /// Working point at which the tube that hangs on the hook is back in place, m.
    fn loose(&self, hanging: Option<Hanging>) -> Vec3 {
        let home = hanging.map(|(sphere, was)| was - self.sight.now(sphere, &self.seen.state));
        self.works() + home.unwrap_or_default().cap_magnitude(HOME_M)
    }

    /// Moves and turns the hook for at most this time, whatever it touches. If the hook kept clear
    /// of a duct in its crook, it would drag the duct along.
    fn steer(&mut self, to: Vec3, bend: Vec3, seconds: f64) -> Result<(), String> {
        let mut before_s = self.seen.at_s;
        self.look_for(seconds, |work| {
            let passed_s = (work.seen.at_s - before_s).clamp(0.0, 0.05);
            before_s = work.seen.at_s;
            let (way, off) = (to - work.works(), work.turned_off(bend));
            work.go(way * 2.5, passed_s);
            work.turn_within(off, passed_s, TURN_RAD_S);
            way.norm() < THERE_M && off.abs() < TURNED_RAD
        });
        self.goes_on()
    }

    /// Moves the hook to a place as far as there is room, and turns it, for at most this time. If a
    /// tube comes along, the hook stops, and the tube is returned.
    pub(crate) fn travel(
        &mut self,
        to: &dyn Fn(&Self) -> Vec3,
        bend: Vec3,
        seconds: f64,
    ) -> Result<Option<Hanging>, String> {
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
            let is_felt = wide(work.seen.tools.force_n).norm() >= HANGS_N;
            hangs = work.comes_along(&mut hanging) && is_felt;
            if hangs {
                return true;
            }
            // A structure that the hook must not touch is in the way, or the hook has arrived.
            if work.seen.at_s - nearer_s > STUCK_S {
                return true;
            }
            work.go_gently(way * 2.5, bend, passed_s);
            let off = work.turned_off(bend);
            way.norm() < 0.002 && off.abs() < 1.0
        });
        self.goes_on()?;
        Ok(hanging.filter(|_| hangs))
    }

    /// True if the duct or vessel nearest to the hook has come along with it.
    pub(crate) fn comes_along(&self, hanging: &mut Option<Hanging>) -> bool {
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

    /// Room between the hook and structures that it must not touch, m, and the direction away from
    /// them.
    fn room(&self) -> (f64, Vec3) {
        let Some(electrode) = self.electrode() else {
            return (f64::MAX, Vec3::zeros());
        };
        let hook = Hook::seen(electrode, self.sight.port());
        hook.room(&self.sight.touchy(self.works(), 0.07, &self.seen.state))
    }

    /// Moves and turns for this time, slowing as the hook nears structures that it must not touch.
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

/// True if the sphere that first came near has moved by more than `COMES_ALONG_M`, and a tube has
/// been near ever since. `near` is the sphere now near, if any, and its position.
fn hangs(
    hanging: &mut Option<Hanging>,
    near: Option<Hanging>,
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
        // The tube came near at 2 mm. Later another of its spheres may be the nearest.
        assert!(!look(Some(7), 2.0) && !look(Some(8), 5.0));
        assert!(look(Some(8), 6.5));
        // A tube that the hook has left no longer hangs, however far it goes.
        assert!(!look(None, 20.0) && !look(Some(7), 20.0) && !look(Some(7), 17.0));
        assert!(look(Some(7), 15.5));
    }
}
