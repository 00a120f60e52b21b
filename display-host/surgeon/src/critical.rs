//! Showing the critical view of safety, or an organ that other tissue hides: finds a pose of the
//! endoscope from which it is seen, goes there, and holds still. The surgeon judges the picture as
//! the assessment does, in identity images of what is seen now.

use assess::{Least, Rules, ShowRule, ViewRule, ViewSide};
use nalgebra::UnitQuaternion;
use session::identity::{Identity, Seen};
use shared_mem::message::PoseMsg;

use crate::field::Field;
use crate::vector::{Vec3, wide};
use crate::work::{BACK_M, LOOK_MAX_S, Work, rotation};

/// Turn of the endoscope to the left and up, rad, and its advance, m, from its pose in the scene.
type Aim = [f64; 3];

/// Value of a picture: 1 if it shows what the rules ask.
type Judge<'a> = &'a dyn Fn(&Seen) -> f64;

/// Turns and advances that are tried first.
const TURNS_RAD: [f64; 7] = [-0.24, -0.16, -0.08, 0.0, 0.08, 0.16, 0.24];
const ADVANCES_M: [f64; 5] = [-0.05, -0.025, 0.0, 0.025, 0.05];
/// First step of the search around the best of them, the share of a step that the next one has, and
/// the number of steps.
const STEP: Aim = [0.04, 0.04, 0.012];
const SHRINK: f64 = 0.6;
const STEPS: usize = 5;
/// Time for which the tissue settles before the search, s.
const SETTLE_S: f64 = 1.0;
/// Largest number of corrections of an aim that shows too little.
const CORRECTIONS: usize = 5;
/// Images drawn between two looks, so that the hand is never left alone for long.
const AT_ONCE: usize = 2;
/// Value of a view that shows a little more than the rules ask.
const ENOUGH: f64 = 1.1;
/// Weight of what a view shows besides its worst criterion.
const REST: f64 = 1e-3;
/// Angle beyond the least one off the plane that counts as enough, degrees.
const BESIDE_DEG: f64 = 2.0;
/// Fastest turn of the endoscope, rad/s, and fastest advance, m/s.
const SPEED: Aim = [0.25, 0.25, 0.02];
/// Distance from the aim that counts as reached.
const NEAR: Aim = [0.004, 0.004, 0.001];
/// An aim is given up after this time, s.
const GIVE_UP_S: f64 = 15.0;
/// Share of the fat in front of duct and artery that is removed before the view is tried again.
const BARED: f64 = 0.85;
/// Longest time before the view is tried again, s, and the number of times.
const BARING_S: f64 = 30.0;
const BARINGS: usize = 4;
/// Time beyond that of the rules for which a view is held, s.
const LONGER_S: f64 = 1.5;

impl Work<'_> {
    /// Shows the critical view from this side and holds it.
    pub(crate) fn show_view(&mut self, side: ViewSide) -> Result<(), String> {
        let rules = Rules::default();
        let Some(rule) = rules.view() else {
            return Ok(());
        };
        let two = self.sight.two();
        let hold_s = rule.hold_s + LONGER_S;
        let judge = |seen: &Seen| value(seen, two, side, rule);
        let shown = self.show_by(&judge, hold_s);
        if shown.is_ok() || self.is_over {
            return shown;
        }
        // Fat that does not count as the triangle's may still hide duct and artery. The view is
        // tried again after a while, because it may open before all of that fat is gone.
        for _ in 0..BARINGS {
            if !self.bare()? {
                break;
            }
            self.retreat(BACK_M)?;
            let shown = self.show_by(&judge, hold_s);
            if shown.is_ok() || self.is_over {
                return shown;
            }
        }
        shown
    }

    fn show_by(&mut self, judge: Judge<'_>, hold_s: f64) -> Result<(), String> {
        self.shows = true;
        let shown = self.find_and_hold(judge, hold_s);
        self.shows = false;
        shown
    }

    /// Removes fat that hides cystic duct and artery from the endoscope's present pose. Returns
    /// false if there is none.
    fn bare(&mut self) -> Result<bool, String> {
        let camera = wide(self.seen.tools.world_from_camera.position_m);
        let state = &self.seen.state;
        let tubes = self.sight.two().into_iter().flatten();
        let places = tubes.flat_map(|organ| self.sight.spheres_of(organ));
        let places: Vec<Vec3> = places.map(|it| self.sight.now(it, state)).collect();
        let hides = self.field.mark_hiding(&places, camera, &self.sight, state);
        if hides && let Err(why) = self.dissect(&[Field::HIDES], BARED, BARING_S) {
            // What is out of reach stays: the view is judged again in any case.
            self.goes_on()?;
            self.theatre.tell(&format!("baring duct and artery: {why}"));
        }
        Ok(hides)
    }

    /// Shows an organ as well as the scene allows, and holds it for this time, s.
    pub(crate) fn show_beside(&mut self, organ: usize, hold_s: f64) -> Result<(), String> {
        let rules = Rules::default();
        self.find_and_hold(&|seen| value_of(seen, organ, rules.show()), hold_s)
    }

    /// True if the endoscope shows an organ as the rules ask.
    pub(crate) fn is_shown(&self, organ: usize) -> bool {
        let rules = Rules::default();
        let mut identity = Identity::of(self.sight.scene());
        let seen = identity.look([0.0; 2], &self.seen.state, &self.seen.tools);
        seen.is_some_and(|seen| value_of(&seen, organ, rules.show()) >= 1.0)
    }

    fn find_and_hold(&mut self, judge: Judge<'_>, hold_s: f64) -> Result<(), String> {
        let mut identity = Identity::of(self.sight.scene());
        // The tissue settles after the instrument has left it.
        self.wait(SETTLE_S)?;
        let mut aim = self.find_aim(&mut identity, judge)?;
        for _ in 0..CORRECTIONS {
            self.aim(aim)?;
            let seen = identity.look([0.0; 2], &self.seen.state, &self.seen.tools);
            if seen.is_some_and(|seen| judge(&seen) >= 1.0) {
                return self.wait(hold_s);
            }
            // It has moved on meanwhile, or the aim was missed.
            let mut best = (f64::MIN, aim);
            self.refine(&mut identity, judge, &mut best)?;
            aim = best.1;
        }
        Err("the view does not open".to_owned())
    }

    /// Turns the endoscope back to its pose in the scene.
    pub(crate) fn look_back(&mut self) -> Result<(), String> {
        self.aim([0.0; 3])
    }

    /// The best aim for a view.
    fn find_aim(&mut self, identity: &mut Identity, judge: Judge<'_>) -> Result<Aim, String> {
        let mut best = (f64::MIN, [0.0; 3]);
        let grid = TURNS_RAD.iter().flat_map(|left| {
            let turns = TURNS_RAD.iter().map(move |up| [*left, *up]);
            turns.flat_map(|[left, up]| ADVANCES_M.map(|advance| [left, up, advance]))
        });
        self.try_aims(grid, identity, judge, &mut best)?;
        self.refine(identity, judge, &mut best)?;
        Ok(best.1)
    }

    /// Searches around the best aim so far, in shrinking steps.
    fn refine(
        &mut self,
        identity: &mut Identity,
        judge: Judge<'_>,
        best: &mut (f64, Aim),
    ) -> Result<(), String> {
        let mut step = STEP;
        for _ in 0..STEPS {
            let (_, from) = *best;
            let around = (0..6).map(|way| {
                let mut aim = from;
                if let (Some(part), Some(by)) = (aim.get_mut(way / 2), step.get(way / 2)) {
                    *part += if way % 2 == 0 { *by } else { -by };
                }
                aim
            });
            self.try_aims([from].into_iter().chain(around), identity, judge, best)?;
            step = step.map(|it| SHRINK * it);
        }
        Ok(())
    }

    fn try_aims(
        &mut self,
        aims: impl Iterator<Item = Aim>,
        identity: &mut Identity,
        judge: Judge<'_>,
        best: &mut (f64, Aim),
    ) -> Result<(), String> {
        for (number, aim) in aims.enumerate() {
            let mut tools = *self.seen.tools;
            tools.world_from_camera = self.camera_at(aim);
            let seen = identity.look([0.0; 2], &self.seen.state, &tools);
            let value = seen.map_or(f64::MIN, |seen| judge(&seen));
            if value > best.0 {
                *best = (value, aim);
            }
            if number % AT_ONCE == 0 {
                self.look_for(1e-3, |_| false);
                self.goes_on()?;
            }
        }
        Ok(())
    }

    /// Pose of the endoscope at an aim. It turns about its port.
    fn camera_at(&self, [left, up, advance_m]: Aim) -> PoseMsg {
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

    /// Moves the endoscope to an aim.
    fn aim(&mut self, aim: Aim) -> Result<(), String> {
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

/// Value of a critical view: the share of what the rules ask that its worst criterion shows.
fn value(seen: &Seen, two: [Option<usize>; 2], side: ViewSide, rule: &ViewRule) -> f64 {
    let side_deg = f64::from(seen.side_rad).to_degrees();
    let (towards_deg, least) = match side {
        ViewSide::Front => (side_deg, &rule.front),
        ViewSide::Behind => (-side_deg, &rule.behind),
    };
    let Least {
        triangle,
        lower_bed,
        two: of_tube,
    } = *least;
    let [duct, artery] = two.map(|organ| {
        let organ = organ.and_then(|it| seen.organs.get(it));
        organ.map_or(0.0, |it| it.visible())
    });
    let shares = [
        (f64::from(seen.triangle), triangle),
        (f64::from(seen.lower_bed), lower_bed),
        (duct, of_tube),
        (artery, of_tube),
    ];
    // Among pictures that lack as much, the one that shows more of the rest is better.
    let rest: f64 = shares.iter().map(|(share, _)| share - 1.0).sum();
    let beside = 1.0 + (towards_deg - rule.side_deg - BESIDE_DEG).min(0.0) / BESIDE_DEG;
    let asked = shares.into_iter().filter(|(_, least)| *least > 0.0);
    let worst = asked
        .map(|(share, least)| share / least)
        .chain([beside * ENOUGH])
        .fold(f64::MAX, f64::min);
    worst + REST * rest
}

/// Value of a picture of an organ.
fn value_of(seen: &Seen, organ: usize, rule: &ShowRule) -> f64 {
    let Some(organ) = seen.organs.get(organ) else {
        return 0.0;
    };
    let share = (organ.visible() / rule.visible).max(organ.size() / rule.large);
    let size = organ.size() / rule.small;
    share.min(size).min(rule.off / organ.off().max(0.01))
}
