//! Poses of the endoscope, and an endoscope that looks off its shaft.
//!
<<<<<<< ours
//! Through a fixed port, a straight endoscope sees duct and artery from few sides. In the course
//! with a low union it gets 4° behind their plane at most. An endoscope that looks 30° off its
//! shaft has them in its picture from beside the duodenum, too, 16° and more behind. Where the
//! artery lies in front or the hepatic artery is humped, bowel is in the way of every pose behind
//! the plane. There a surgeon flips the gallbladder with a second instrument, which this operation
//! lacks.
=======
//! Through a fixed port, a straight endoscope sees the triangle from few sides. In some courses of duct
//! and artery it never gets behind their plane. An endoscope that looks 30° off its shaft sees the
//! triangle from places where the straight one has it out of the picture, so it gets at least 15°
//! behind the plane in every course.
>>>>>>> theirs

use nalgebra::UnitQuaternion;
use shared_mem::message::PoseMsg;

use crate::vector::{Vec3, wide};
use crate::work::{LOOK_MAX_S, Work, rotation};

/// Turn of the endoscope to the left and up, rad, and its advance, m, from its pose in the scene.
pub(crate) type Aim = [f64; 3];

/// Angle between the shaft and the view of the angled endoscope, rad (30°).
<<<<<<< ours
const OFF_RAD: f64 = core::f64::consts::FRAC_PI_6;
=======
const OFF_RAD: f64 = 0.5236;
>>>>>>> theirs
/// Turns and advances that are tried first: of a straight endoscope, and of an angled one.
const TURNS_RAD: [f64; 7] = [-0.24, -0.16, -0.08, 0.0, 0.08, 0.16, 0.24];
const TURNS_OFF_RAD: [f64; 7] = [-0.39, -0.26, -0.13, 0.0, 0.13, 0.26, 0.39];
const ADVANCES_M: [f64; 5] = [-0.05, -0.025, 0.0, 0.025, 0.05];
/// Radius of an endoscope and the room around it, m. The usual endoscope is 10 mm wide.
const CLEAR_M: f64 = 0.006;
/// Length of the shaft behind the lens that must be clear of organs, m.
const SHAFT_M: f64 = 0.04;
/// Largest tilt of the horizon, as a sine: the rules allow 20°.
const TILT: f64 = 0.26;
/// Fastest turn of the endoscope, rad/s, and fastest advance, m/s.
const SPEED: Aim = [0.25, 0.25, 0.02];
/// Distance from the aim that counts as reached.
const NEAR: Aim = [0.004, 0.004, 0.001];
/// An aim is given up after this time, s.
const GIVE_UP_S: f64 = 15.0;

/// An endoscope, and how its view lies to its shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Scope {
    /// Looks along its shaft.
    Straight,
    /// Looks off its shaft, always towards this place, m.
    Towards(Vec3),
}

impl Scope {
    /// Aims that are tried first.
    pub(crate) fn aims(self) -> impl Iterator<Item = Aim> {
        let turns = match self {
            Self::Straight => TURNS_RAD,
            Self::Towards(_) => TURNS_OFF_RAD,
        };
        turns.into_iter().flat_map(move |left| {
            let turns = turns.into_iter().map(move |up| [left, up]);
            turns.flat_map(|[left, up]| ADVANCES_M.map(|advance| [left, up, advance]))
        })
    }

    /// Angle between view and shaft, and the view's turn about the shaft (0: down), rad, while the
    /// shaft lies so.
    pub(crate) fn sight_rad(self, shaft: &PoseMsg) -> [f32; 2] {
        let Self::Towards(place_m) = self else {
            return [0.0; 2];
        };
        let to = rotation(shaft).inverse() * (place_m - wide(shaft.position_m));
        [OFF_RAD, to.x.atan2(-to.y)].map(|it| it as f32)
    }
}

impl Work<'_> {
    /// Pose of the endoscope's shaft at an aim. It turns about its port.
    pub(crate) fn camera_at(&self, [left, up, advance_m]: Aim) -> PoseMsg {
        let room = self.sight.scene().room();
        let start = &room.world_from_camera;
        let port = wide(room.endoscope_port_m);
        let rest = rotation(start);
        let turn = UnitQuaternion::from_scaled_axis(rest * Vec3::new(up, left, 0.0));
        let ahead = rest * Vec3::new(0.0, 0.0, -advance_m);
        let at = port + turn * (wide(start.position_m) + ahead - port);
        let turned = turn * rest;
        let [x, y, z, w] = [turned.i, turned.j, turned.k, turned.w];
        PoseMsg {
            position_m: [at.x, at.y, at.z].map(|it| it as f32),
            orientation: [x, y, z, w].map(|it| it as f32),
        }
    }

    /// Looks as this endoscope does from the present pose. Returns false if the theatre has no such
    /// endoscope.
    pub(crate) fn take_scope(&mut self, scope: Scope) -> bool {
        let sight_rad = scope.sight_rad(&self.seen.tools.world_from_camera);
        self.theatre.look_off(sight_rad)
    }

    /// True if a pose is one in which this endoscope may be held. An angled one leaves the usual
    /// poses, so it must not tilt the horizon or run into an organ.
    pub(crate) fn may_hold(&self, scope: Scope, shaft: &PoseMsg) -> bool {
        let Scope::Towards(_) = scope else {
            return true;
        };
        let [off, turned] = scope.sight_rad(shaft).map(f64::from);
        let axis = Vec3::new(turned.cos(), turned.sin(), 0.0) * -off;
        let turn = rotation(shaft);
        let view = turn * UnitQuaternion::from_scaled_axis(axis);
        let gravity = wide(self.sight.scene().room().gravity_m_s2);
        let tilt = (view * Vec3::x()).dot(&gravity) / gravity.norm().max(1e-9);
        let lens = wide(shaft.position_m);
        let behind = [lens, lens + turn * Vec3::z() * SHAFT_M];
        tilt.abs() < TILT && self.sight.is_clear(behind, CLEAR_M, &self.seen.state)
    }

    /// Turns the endoscope back to its pose in the scene, and looks along its shaft.
    pub(crate) fn look_back(&mut self) -> Result<(), String> {
        self.take_scope(Scope::Straight);
        self.aim([0.0; 3])
    }

    /// Moves the endoscope to an aim.
    pub(crate) fn aim(&mut self, aim: Aim) -> Result<(), String> {
        let mut before_s = self.seen.at_s;
        let there = self.look_for(GIVE_UP_S, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, LOOK_MAX_S);
            before_s = work.seen.at_s;
            let asked = &mut work.asked;
            let [left, up] = &mut asked.scope_turned_rad;
            let sums = [left, up, &mut asked.scope_advanced_m];
            let mut is_there = true;
            for (((sum, to), speed), near) in sums.into_iter().zip(aim).zip(SPEED).zip(NEAR) {
                let most = speed * seconds;
                let way = to - *sum;
                is_there &= way.abs() < near;
                *sum += way.clamp(-most, most);
            }
            is_there
        });
        self.goes_on()?;
        match there {
            true => Ok(()),
            false => Err("the endoscope does not come to rest".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Direction of the view in the shaft's frame, as `session::identity` and `assess` turn it.
    fn view(sight_rad: [f32; 2]) -> Vec3 {
        let [off, turned] = sight_rad.map(f64::from);
        let axis = Vec3::new(turned.cos(), turned.sin(), 0.0) * -off;
        UnitQuaternion::from_scaled_axis(axis) * -Vec3::z()
    }

    #[test]
    fn an_angled_view_turns_to_the_place_and_a_straight_one_stays() {
        for [x, y] in [[0.0, -0.05], [0.05, 0.0], [-0.03, 0.04], [0.02, 0.06]] {
            let scope = Scope::Towards(Vec3::new(x, y, -0.08));
            let view = view(scope.sight_rad(&PoseMsg::IDENTITY));
            assert!((view.angle(&-Vec3::z()) - OFF_RAD).abs() < 1e-4);
            // The view leaves the shaft towards the place.
            let [aside, to] = [view.xy(), nalgebra::Vector2::new(x, y)];
            assert!(aside.normalize().dot(&to.normalize()) > 0.9999, "{x} {y}");
        }
        let straight = view(Scope::Straight.sight_rad(&PoseMsg::IDENTITY));
        assert!((straight + Vec3::z()).norm() < 1e-9);
    }
}
