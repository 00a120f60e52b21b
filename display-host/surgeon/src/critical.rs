//! Showing the critical view of safety, or an organ that other tissue hides: finds a pose of the
//! endoscope from which it is seen, goes there, and holds still. The surgeon judges the picture as
//! the assessment does, in identity images of the present view.

use assess::{Least, Rules, ShowRule, ViewRule, ViewSide};
use session::identity::{Identity, Seen};

use crate::field::Field;
use crate::scope::{Aim, Scope};
use crate::vector::{Vec3, wide};
use crate::work::{BACK_M, Work};

/// Value of a picture: 1 if it shows what the rules ask.
type Judge<'a> = &'a dyn Fn(&Seen) -> f64;

/// The search around the best aim of the grid: its first step, the ratio of a step to the one
/// before, and the number of steps.
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
/// Share of the fat in front of duct and artery that is removed before the view is tried again.
const BARED: f64 = 0.85;
/// Longest time before the view is tried again, s, and the number of times.
const BARING_S: f64 = 30.0;
const BARINGS: usize = 4;
/// Time for which a view is held longer than the rules ask, s.
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
        let shown = self.find_and_hold(judge, hold_s, true);
        self.shows = false;
        self.take_scope(Scope::Straight);
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
            // Tissue out of reach stays. The view is judged again in any case.
            self.goes_on()?;
            self.theatre.tell(&format!("baring duct and artery: {why}"));
        }
        Ok(hides)
    }

    /// Shows an organ as well as the scene allows, and holds it for this time, s.
    pub(crate) fn show_beside(&mut self, organ: usize, hold_s: f64) -> Result<(), String> {
        let rules = Rules::default();
        self.find_and_hold(&|seen| value_of(seen, organ, rules.show()), hold_s, false)
    }

    /// True if the endoscope shows an organ as the rules ask.
    pub(crate) fn is_shown(&self, organ: usize) -> bool {
        let rules = Rules::default();
        let mut identity = Identity::of(self.sight.scene());
        let seen = identity.look([0.0; 2], &self.seen.state, &self.seen.tools);
        seen.is_some_and(|seen| value_of(&seen, organ, rules.show()) >= 1.0)
    }

    /// Finds an aim whose picture this judge accepts, goes there, and holds it for this time, s. If
    /// the straight endoscope has no such aim, the surgeon may take an angled one.
    fn find_and_hold(
        &mut self,
        judge: Judge<'_>,
        hold_s: f64,
        may_change: bool,
    ) -> Result<(), String> {
        let mut identity = Identity::of(self.sight.scene());
        // The tissue settles after the instrument has left it.
        self.wait(SETTLE_S)?;
        let mut scope = Scope::Straight;
        let mut best = self.find_aim(&mut identity, judge, scope)?;
        let angled = Scope::Towards(self.middle_of_two());
        if may_change && best.0 < 1.0 && self.take_scope(angled) {
            let other = self.find_aim(&mut identity, judge, angled)?;
            if other.0 > best.0 {
                (scope, best) = (angled, other);
            }
            self.take_scope(scope);
        }
        for _ in 0..CORRECTIONS {
            self.aim(best.1)?;
            self.take_scope(scope);
            let tools = &self.seen.tools;
            let sight_rad = scope.sight_rad(&tools.world_from_camera);
            let seen = identity.look(sight_rad, &self.seen.state, tools);
            if seen.is_some_and(|seen| judge(&seen) >= 1.0) {
                return self.wait(hold_s);
            }
            // It has moved on meanwhile, or the aim was missed.
            best.0 = f64::MIN;
            self.refine(&mut identity, judge, scope, &mut best)?;
        }
        Err("the view does not open".to_owned())
    }

    /// Present middle of cystic duct and artery, m.
    fn middle_of_two(&self) -> Vec3 {
        let organs: Vec<usize> = self.sight.two().into_iter().flatten().collect();
        let state = &self.seen.state;
        let middles = organs.iter().map(|organ| self.sight.middle(*organ, state));
        middles.sum::<Vec3>() / organs.len().max(1) as f64
    }

    /// The best aim of this endoscope for a view, and its value.
    fn find_aim(
        &mut self,
        identity: &mut Identity,
        judge: Judge<'_>,
        scope: Scope,
    ) -> Result<(f64, Aim), String> {
        let mut best = (f64::MIN, [0.0; 3]);
        self.try_aims(scope.aims(), identity, judge, scope, &mut best)?;
        self.refine(identity, judge, scope, &mut best)?;
        Ok(best)
    }

    /// Searches around the best aim so far, in shrinking steps.
    fn refine(
        &mut self,
        identity: &mut Identity,
        judge: Judge<'_>,
        scope: Scope,
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
            let aims = [from].into_iter().chain(around);
            self.try_aims(aims, identity, judge, scope, best)?;
            step = step.map(|it| SHRINK * it);
        }
        Ok(())
    }

    fn try_aims(
        &mut self,
        aims: impl Iterator<Item = Aim>,
        identity: &mut Identity,
        judge: Judge<'_>,
        scope: Scope,
        best: &mut (f64, Aim),
    ) -> Result<(), String> {
        let mut drawn = 0;
        for aim in aims {
            let mut tools = *self.seen.tools;
            tools.world_from_camera = self.camera_at(aim);
            if !self.may_hold(scope, &tools.world_from_camera) {
                continue;
            }
            let sight_rad = scope.sight_rad(&tools.world_from_camera);
            let seen = identity.look(sight_rad, &self.seen.state, &tools);
            let value = seen.map_or(f64::MIN, |seen| judge(&seen));
            if value > best.0 {
                *best = (value, aim);
            }
            if drawn % AT_ONCE == 0 {
                self.look_for(1e-3, |_| false);
                self.goes_on()?;
            }
            drawn += 1;
        }
        Ok(())
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
