//! Showing organs with the endoscope, and keeping the work in the picture.

use shared_mem::scene::OrganKind;

use crate::plan::Surgeon;
use crate::vector::{Vec3, wide};
use crate::work::{LOOK_MAX_S, Work, rotation};

/// Angle from the middle of the picture within which an organ is shown, rad: less than half of
/// what the endoscope drill allows.
const MIDDLE_RAD: f64 = 0.12;
/// Angle within which a novice shows an organ, rad. The picture sways by 0.1 rad, and the drill
/// allows 0.3.
const NOVICE_RAD: f64 = 0.24;
/// Rate of turn per remaining angle, 1/s.
const TURN_SHARE: f64 = 1.5;
/// Fastest turn, rad/s.
const TURN_RAD_S: f64 = 0.3;
/// The endoscope is drawn back from an organ that is nearer than this, m.
const NEAR_M: f64 = 0.05;
/// The endoscope is moved towards an organ that is farther than this, m.
const FAR_M: f64 = 0.2;
/// Speed of the endoscope along its axis, m/s.
const ADVANCE_M_S: f64 = 0.02;
/// Time for which an organ is held in the middle, s. The drill asks for 1.5 s, and looks five times
/// a second.
const HOLD_S: f64 = 2.5;
/// Time for which a novice holds an organ, s: sway pauses the hold now and then.
const NOVICE_HOLD_S: f64 = 6.0;
/// An organ that is not in the middle after this time is left out, s.
const GIVE_UP_S: f64 = 20.0;
/// Angle from the middle of the picture beyond which a cell is too near the rim to be burnt, rad.
/// What lies beyond 0.61 rad counts as outside the picture, and the tip works up to 5 mm beside the
/// cell: 0.1 rad at 5 cm.
const RIM_RAD: f64 = 0.5;
/// Angle to which the endoscope brings such a cell, rad.
const INSIDE_RAD: f64 = 0.3;
/// A cell that is not that far inside after this time is burnt where it is, s.
const FOLLOWS_S: f64 = 3.0;

impl Work<'_> {
    /// Turns the endoscope to a place of work near the rim of the picture, or outside it. The hand
    /// rests meanwhile.
    pub(crate) fn keep_in_picture(&mut self, place: &dyn Fn(&Self) -> Vec3) -> Result<(), String> {
        if self.off_rad(place(self)) < RIM_RAD {
            return Ok(());
        }
        self.asked.switches = 0;
        let mut before_s = self.seen.at_s;
        self.look_for(FOLLOWS_S, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, LOOK_MAX_S);
            before_s = work.seen.at_s;
            let at = place(work);
            work.turn_towards(at, seconds);
            work.off_rad(at) < INSIDE_RAD
        });
        self.goes_on()
    }

    /// Turns the endoscope to the first organ of this kind and holds it in the middle of the
    /// picture. A scene without such an organ leaves nothing to do.
    pub(crate) fn show(&mut self, kind: OrganKind) -> Result<(), String> {
        let Some(organ) = self.sight.organ(kind) else {
            return Ok(());
        };
        let (middle_rad, hold_s) = match self.surgeon {
            Surgeon::Novice => (NOVICE_RAD, NOVICE_HOLD_S),
            _ => (MIDDLE_RAD, HOLD_S),
        };
        self.shows = true;
        let mut before_s = self.seen.at_s;
        let mut held_s = 0.0;
        let shown = self.look_for(GIVE_UP_S, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, LOOK_MAX_S);
            before_s = work.seen.at_s;
            let off_rad = work.turn_to(work.sight.middle(organ, &work.seen.state), seconds);
            held_s = if off_rad < middle_rad {
                held_s + seconds
            } else {
                0.0
            };
            held_s >= hold_s
        });
        self.goes_on()?;
        // What lies in the middle may still be hidden.
        let shown = match shown && self.is_shown(organ) {
            true => Ok(()),
            false => self.show_beside(organ, hold_s),
        };
        self.shows = false;
        shown
    }

    /// Turns and moves the endoscope towards a place for this time. Returns how far the place is
    /// from the middle of the picture, rad.
    fn turn_to(&mut self, place_m: Vec3, seconds: f64) -> f64 {
        self.turn_towards(place_m, seconds);
        self.asked.scope_advanced_m += match self.in_camera_m(place_m).norm() {
            far if far > FAR_M => ADVANCE_M_S * seconds,
            near if near < NEAR_M => -ADVANCE_M_S * seconds,
            _ => 0.0,
        };
        self.off_rad(place_m)
    }

    /// Turns the endoscope towards a place for this time.
    fn turn_towards(&mut self, place_m: Vec3, seconds: f64) {
        let [right, up] = self.off_each_rad(place_m).map(|off| {
            let most = TURN_RAD_S * seconds;
            (TURN_SHARE * seconds * off).clamp(-most, most)
        });
        let [left_sum, up_sum] = &mut self.asked.scope_turned_rad;
        *left_sum -= right;
        *up_sum += up;
    }

    /// Angle between a place and the middle of the picture, rad.
    fn off_rad(&self, place_m: Vec3) -> f64 {
        let [right, up] = self.off_each_rad(place_m);
        (right * right + up * up).sqrt()
    }

    /// Angles between a place and the middle of the picture: to the right and upwards, rad.
    fn off_each_rad(&self, place_m: Vec3) -> [f64; 2] {
        let to = self.in_camera_m(place_m);
        [to.x, to.y].map(|aside| aside.atan2(-to.z))
    }

    /// A place in the camera's frame, m.
    fn in_camera_m(&self, place_m: Vec3) -> Vec3 {
        let camera = &self.seen.tools.world_from_camera;
        rotation(camera).inverse() * (place_m - wide(camera.position_m))
    }
}
