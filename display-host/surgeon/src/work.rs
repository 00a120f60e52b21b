//! Hand movements: reach a place, close the jaws, exchange the instrument.

use assess::Task;
use bytemuck::Zeroable as _;
use nalgebra::{Quaternion, UnitQuaternion};
use shared_mem::message::{CommandMsg, DeviceHealth, Event, HandMsg, PoseMsg};
use shared_mem::scene::{OrganKind, SceneFile};
use shared_mem::words::{Buttons, CapsuleRole, Instrument};

use crate::field::Field;
use crate::nearing::Nearing;
use crate::plan::{Act, COAGULATE, Surgeon, THROUGH_S};
use crate::sight::{Place, Sight};
use crate::vector::Vec3;
use crate::{Seen, Theatre};

/// Length of the jaws, m, about that of scissors (16 mm) and clip applier (14 mm) in
/// `rt_core::tool::Instrument`.
pub(crate) const JAW_M: f64 = 0.015;
/// Place of the vessel in the jaws, as a share of their length from the hinge.
pub(crate) const BITE: f64 = 0.7;
/// Place of the vessel in the clip applier: the middle of the clip, which is the last 9 mm of jaws
/// of 14 mm (`rt_core::procedure`). So both edges of the flattened vessel lie in the clip although
/// the hand is off by `THERE_M`.
const CLIP_BITE: f64 = 0.0095 / JAW_M;
/// Withdrawal along the shaft before moving to another place, m.
pub(crate) const BACK_M: f64 = 0.03;
/// Withdrawal after which a hurried surgeon opens the jaws, m.
const AWAY_M: f64 = 0.12;
/// Distance before an organ from which the tip goes straight to it, m.
const FRONT_M: f64 = 0.012;
/// Withdrawal before an exchange of instruments, m.
const OUT_M: f64 = 0.05;
/// Distance within which a movement has arrived, m.
const THERE_M: f64 = 0.0015;
/// Angle within which the jaws are lined up, rad.
const ALIGNED_RAD: f64 = 0.12;
/// A movement is given up after this time, s.
const GIVE_UP_S: f64 = 8.0;
/// Time to close or open the jaws, s.
const JAWS_S: f64 = 0.9;
/// Largest rate of turn about the shaft, rad/s.
const TURN_RAD_S: f64 = 1.5;
/// Longest wait for a controller, s.
const PATIENCE_S: f64 = 64.0;
/// Longest time counted between two looks, s.
pub(crate) const LOOK_MAX_S: f64 = 0.05;

/// Lets `surgeon` perform `task` in `theatre` until the operation is over.
///
/// # Errors
/// There is no controller.
pub fn operate(
    surgeon: Surgeon,
    task: Task,
    scene: SceneFile,
    theatre: &mut dyn Theatre,
) -> Result<(), String> {
    let mut work = Work {
        surgeon,
        field: Field::new(&scene),
        sight: Sight::new(scene),
        theatre,
        asked: HandMsg::zeroed(),
        seen: Seen::nothing(),
        clipped: Vec::new(),
        divided: Vec::new(),
        closed: Vec::new(),
        is_over: false,
        shows: false,
        heats: None,
        flaw: [0.0; 2],
        nearing: Nearing::default(),
    };
    let is_there =
        |work: &mut Work<'_>| work.seen.state.sphere_count > 0 && work.seen.tools.capsule_count > 0;
    if !work.look_for(PATIENCE_S, is_there) {
        return match work.is_over {
            true => Ok(()),
            false => Err("no controller".to_owned()),
        };
    }
    let mut missed = Vec::new();
    let operates = surgeon.is_careful() || surgeon == Surgeon::Hurried;
    let hangs = work.must_hang() && operates;
    let first = hangs.then_some(Act::Hang);
    for act in first.into_iter().chain(surgeon.plan(task)) {
        // Before the next exchange, the missed acts are tried again with the same instrument,
        // because the tissue has moved by now.
        let again = match act {
            Act::Take(_) if surgeon.is_careful() => std::mem::take(&mut missed),
            _ => Vec::new(),
        };
        for (act, is_again) in again
            .into_iter()
            .map(|act| (act, true))
            .chain([(act, false)])
        {
            let done = work.act(act);
            if work.is_over {
                return Ok(());
            }
            if let Err(why) = done {
                work.theatre.tell(&format!("{act:?}: {why}"));
                if matches!(act, Act::Work(..)) && !is_again {
                    missed.push(act);
                }
            }
        }
    }
    // The hand stays still until the run ends.
    work.look_for(f64::MAX, |_| false);
    Ok(())
}

pub(crate) struct Work<'a> {
    pub(crate) surgeon: Surgeon,
    pub(crate) sight: Sight,
    pub(crate) field: Field,
    pub(crate) theatre: &'a mut dyn Theatre,
    pub(crate) asked: HandMsg,
    pub(crate) seen: Seen,
    /// Organs that were clipped, one entry for each event.
    pub(crate) clipped: Vec<u32>,
    /// Organs that were completely divided, one entry for each event.
    pub(crate) divided: Vec<u32>,
    /// Vessels that the surgeon has closed with a clip, each with true for the body's side of the
    /// cut.
    pub(crate) closed: Vec<(OrganKind, bool)>,
    pub(crate) is_over: bool,
    /// True while the surgeon shows an organ with the endoscope.
    pub(crate) shows: bool,
    /// Organ that the surgeon burns, and the heat that it takes until the pedal is released, J.
    heats: Option<(usize, f64)>,
    /// Offset that a flaw has added: of the hand, m, or of the endoscope, rad.
    pub(crate) flaw: [f64; 2],
    /// Predicted room to structures that must not be touched.
    pub(crate) nearing: Nearing,
}

/// Reason that an act returns when the run was ended from outside.
const OVER: &str = "the operation is over";

impl Work<'_> {
    pub(crate) fn act(&mut self, act: Act) -> Result<(), String> {
        match act {
            Act::Hang => self.hang(),
            Act::Take(instrument) => self.take(instrument),
            Act::Reach(kind, share) => self.approach(kind, share, 0),
            Act::Work(kind, share) => self.bite(kind, share),
            Act::Close => {
                self.asked.buttons = Buttons::GRASP.bits();
                self.wait(JAWS_S)?;
                if self.surgeon == Surgeon::Hurried {
                    // The surgeon withdraws before the jaws have opened, and the tissue that they
                    // hold comes along.
                    self.retreat(AWAY_M)?;
                }
                self.asked.buttons = Buttons::NONE.bits();
                self.wait(JAWS_S)
            }
            Act::Scorch(kind, heat_j) => {
                self.heats = self.sight.organ(kind).map(|organ| (organ, heat_j));
                self.act(Act::BurnThrough(kind, COAGULATE, THROUGH_S))
            }
            Act::BurnThrough(kind, pedal, seconds) => {
                self.asked.switches = pedal;
                let until_s = self.seen.at_s + seconds;
                while !self.is_over && self.seen.at_s < until_s && self.asked.switches != 0 {
                    // A failure to arrive does not matter: the loop moves on.
                    let _ = self.approach(kind, 0.4, 0);
                }
                self.asked.switches = 0;
                self.heats = None;
                self.goes_on()
            }
            Act::Pull(by_m) => {
                self.asked.buttons = Buttons::GRASP.bits();
                self.wait(JAWS_S)?;
                let pulled = self.retreat(by_m);
                self.asked.buttons = Buttons::NONE.bits();
                self.goes_on()?;
                pulled
            }
            Act::Touch(name) => self.touch(name),
            Act::Carry(name) => {
                self.asked.buttons = Buttons::GRASP.bits();
                self.wait(JAWS_S)?;
                let carried = self.touch(name);
                self.asked.buttons = Buttons::NONE.bits();
                self.wait(JAWS_S)?;
                carried
            }
            Act::PickStone => self.pick_stone(),
            Act::Retreat => self.retreat(BACK_M),
            Act::Show(kind) => self.show(kind),
            Act::ShowView(side) => self.show_view(side),
            Act::LookBack => self.look_back(),
            Act::Dissect(regions, share) => self.dissect(regions, share, f64::MAX),
        }
    }

    /// Looks and moves until `done`, for at most this time, s, without the rests of a pausing hand.
    /// Returns true if it was done in time.
    pub(crate) fn look_for(
        &mut self,
        seconds: f64,
        mut done: impl FnMut(&mut Self) -> bool,
    ) -> bool {
        let mut start_s = self.seen.at_s;
        while !self.is_over && self.seen.at_s - start_s < seconds {
            let before_s = self.seen.at_s;
            let rests = self.rests();
            if !rests && done(self) {
                return true;
            }
            self.look();
            if rests {
                start_s += self.seen.at_s - before_s;
            }
        }
        false
    }

    /// Lets the theatre go on for one look, with the flaws of the hand.
    fn look(&mut self) {
        self.stumble();
        self.seen.events.clear();
        let at_s = self.seen.at_s;
        self.is_over = !self.theatre.look(&self.asked, &mut self.seen);
        // An instrument that no longer follows is not moved on: the hand would leap when its device
        // returns.
        while !self.is_over && self.is_device_silent() {
            self.seen.at_s = at_s;
            self.is_over = !self.theatre.look(&self.asked, &mut self.seen);
        }
        for event in &self.seen.events {
            match event.decode() {
                Ok(Event::Clip { .. }) => self.clipped.push(event.organ),
                Ok(Event::Divided { .. }) => self.divided.push(event.organ),
                Ok(Event::Burn { energy_j }) => {
                    if let Some((organ, left_j)) = &mut self.heats
                        && *organ == event.organ as usize
                    {
                        *left_j -= f64::from(energy_j);
                        if *left_j <= 0.0 {
                            self.asked.switches = 0;
                        }
                    }
                }
                _ => {}
            }
        }
    }

    fn is_device_silent(&self) -> bool {
        let [haptic, ..] = self.seen.tools.health;
        [DeviceHealth::STALE, DeviceHealth::LOST].contains(&haptic.status)
    }

    pub(crate) fn goes_on(&self) -> Result<(), String> {
        match self.is_over {
            true => Err(OVER.to_owned()),
            false => Ok(()),
        }
    }

    pub(crate) fn wait(&mut self, seconds: f64) -> Result<(), String> {
        self.look_for(seconds, |_| false);
        self.goes_on()
    }

    /// Takes an instrument. Withdraws first: the next one has another shape and comes from the
    /// port.
    pub(crate) fn take(&mut self, instrument: Instrument) -> Result<(), String> {
        // It does not matter how far the withdrawal gets.
        let _ = self.retreat(OUT_M);
        self.goes_on()?;
        self.theatre.command(CommandMsg {
            kind: CommandMsg::INSTRUMENT,
            argument: instrument.number(),
        })?;
        let taken = self.look_for(GIVE_UP_S, |work| work.seen.tools.has(instrument));
        self.goes_on()?;
        match taken {
            true => Ok(()),
            false => Err(format!("the {} did not come", instrument.name())),
        }
    }

    /// Brings the tip to the side of an organ that is nearest to it: first in front of it, then to
    /// it.
    fn touch(&mut self, name: &str) -> Result<(), String> {
        let organ = self.sight.named(name);
        let organ = organ.ok_or_else(|| format!("the scene has no {name}"))?;
        let sphere = self.sight.nearest(organ, self.tip(), &self.seen.state);
        let place = |work: &Self| {
            let at = work.sight.now(sphere?, &work.seen.state);
            Some(Place { at, along: None })
        };
        self.reach(&place, FRONT_M, false)?;
        self.reach(&place, 0.0, false)
    }

    /// Withdraws along the shaft.
    pub(crate) fn retreat(&mut self, by_m: f64) -> Result<(), String> {
        if self.surgeon.is_careful() && self.seen.tools.has(Instrument::Hook) {
            return self.come_out(by_m);
        }
        let to = self.tip() - self.along() * by_m;
        let place = Place {
            at: to,
            along: None,
        };
        self.reach(&|_| Some(place), 0.0, false)
    }

    /// Moves to `before_m` in front of a place: with the biting point of the jaws on a vessel,
    /// otherwise with the tip. Lines the jaws up with the vessel if asked.
    pub(crate) fn reach(
        &mut self,
        place: &dyn Fn(&Self) -> Option<Place>,
        before_m: f64,
        line_up: bool,
    ) -> Result<(), String> {
        let line_up = line_up && self.surgeon != Surgeon::Hurried;
        let mut before_s = self.seen.at_s;
        let mut is_there = false;
        self.look_for(GIVE_UP_S, |work| {
            let seconds = (work.seen.at_s - before_s).clamp(0.0, LOOK_MAX_S);
            before_s = work.seen.at_s;
            let Some(Place { at, along: runs }) = place(work) else {
                return true;
            };
            // A place with a direction is taken between the jaws. The tip goes to any other place.
            let from = match runs.is_some() && work.has_jaws() {
                true => work.bite_at(),
                false => work.tip(),
            };
            let way = at - work.along() * before_m - from;
            work.go(way, seconds);
            let off = match runs.filter(|_| line_up) {
                Some(runs) => work.off(runs),
                None => 0.0,
            };
            work.turn(off, seconds);
            is_there = way.norm() < THERE_M && off.abs() < ALIGNED_RAD;
            is_there
        });
        self.goes_on()?;
        match place(self) {
            _ if is_there => Ok(()),
            Some(place) => Err(format!(
                "{:.1} mm from where it wanted to be",
                (place.at - self.tip()).norm() * 1e3
            )),
            None => Err("the place is missing or is pushed away".to_owned()),
        }
    }

    /// Moves the hand for this time towards a place that is off by `way`.
    pub(crate) fn go(&mut self, way: Vec3, seconds: f64) {
        let step = way * (4.0 * seconds);
        let step = step.cap_magnitude(self.surgeon.speed_m_s() * seconds);
        let local = rotation(&self.seen.tools.world_from_camera).inverse() * step;
        for (sum, part) in self.asked.moved_m.iter_mut().zip(local.iter()) {
            *sum += part;
        }
    }

    /// Turns the instrument about its shaft to reduce this error.
    fn turn(&mut self, off_rad: f64, seconds: f64) {
        self.turn_within(off_rad, seconds, TURN_RAD_S);
    }

    /// Turns as [`Self::turn`], at most at this rate, rad/s.
    pub(crate) fn turn_within(&mut self, off_rad: f64, seconds: f64, most_rad_s: f64) {
        let most = most_rad_s * seconds;
        self.asked.rolled_rad += (4.0 * off_rad * seconds).clamp(-most, most);
    }

    /// Angle about the shaft between the jaws' hinge and a tube's direction, rad. The jaws take a
    /// tube that runs along the axis of the hinge (x).
    pub(crate) fn off(&self, runs: Vec3) -> f64 {
        let turned = self.to_instrument(runs);
        let angle = turned.y.atan2(turned.x);
        // A tube may run in either direction, so the angle is brought within a quarter turn.
        let half = std::f64::consts::FRAC_PI_2;
        match angle {
            angle if angle > half => angle - 2.0 * half,
            angle if angle < -half => angle + 2.0 * half,
            angle => angle,
        }
    }

    /// A direction in the instrument's frame.
    pub(crate) fn to_instrument(&self, way: Vec3) -> Vec3 {
        rotation(&self.seen.tools.world_from_instrument).inverse() * way
    }

    pub(crate) fn has_jaws(&self) -> bool {
        matches!(
            self.seen.tools.instrument(),
            Ok(Instrument::Scissors | Instrument::ClipApplier)
        )
    }

    /// Unit vector from the port to the tip.
    pub(crate) fn along(&self) -> Vec3 {
        rotation(&self.seen.tools.world_from_instrument) * -Vec3::z()
    }

    /// End of the closed jaws, or the middle of the hook's bent end, m.
    pub(crate) fn tip(&self) -> Vec3 {
        if self.seen.tools.has(Instrument::Hook)
            && let Some([heel, end]) = self.electrode()
        {
            return heel.lerp(&end, 0.5);
        }
        let joint = Vec3::from(
            self.seen
                .tools
                .world_from_instrument
                .position_m
                .map(f64::from),
        );
        joint + self.along() * JAW_M
    }

    /// Place of a vessel in the present jaws, as a share of their length from the hinge.
    pub(crate) fn bite_share(&self) -> f64 {
        match self.seen.tools.has(Instrument::ClipApplier) {
            true => CLIP_BITE,
            false => BITE,
        }
    }

    /// Point of the jaws that takes a vessel, m.
    pub(crate) fn bite_at(&self) -> Vec3 {
        self.tip() - self.along() * ((1.0 - self.bite_share()) * JAW_M)
    }

    /// The hook's bent end, from heel to end, m.
    pub(crate) fn electrode(&self) -> Option<[Vec3; 2]> {
        let tools = &self.seen.tools;
        let parts = tools.capsules.iter().take(tools.capsule_count as usize);
        let bare = parts.into_iter().find(|part| part.is(CapsuleRole::Tip))?;
        Some([bare.a_m, bare.b_m].map(|end| Vec3::from(end.map(f64::from))))
    }
}

pub(crate) fn rotation(pose: &PoseMsg) -> UnitQuaternion<f64> {
    let [x, y, z, w] = pose.orientation.map(f64::from);
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}
