//! Organs that fall or shake, which is a sign of a faulty scene.
//!
//! An organ falls when its middle stays farther from its initial place than the diagonal of its
//! bounding box. An organ shakes when no tool moves it, and its speed neither falls below a limit
//! nor decays. Both are reported once, and again after a reset. Shaking is also reported again if
//! the organ came to rest in between.
//!
//! Tissue that the trainee works on may move. So an organ that a tool moves, or has moved in the
//! last two seconds, is not reported as falling, nor are the organs next to it. The endoscope is
//! such a tool, too ([`super::lens`]). Such an organ is
//! reported as shaking only if it is faster than the hand explains ([`super::shaking`]). An organ
//! is freed, and may fall or dangle, once it was grasped, or once something was cut, burnt away or
//! torn at it while a tool worked. All organs that attachments join to it are freed with it, up to
//! organs with held spheres.
//!
//! Nothing here feeds back into the simulation.

use crate::capacity::MAX_ORGANS;
use crate::math::{self, Vec3};
use crate::procedure::lens::Lens;
use crate::procedure::shaking::Shaking;
use crate::scene::{Anchor, Scene};
use crate::tissue::Bounds;

/// Time for which an organ still counts as moved after a tool moved it, ticks. A liver that was
/// pressed has returned to its place within a second.
const DISTURBED_TICKS: u16 = 2000;
/// Time for which an organ must be away from its place to count as fallen, ticks. In this time an
/// organ falls freely by 0.2 m.
const DISPLACED_TICKS: u16 = 200;
/// Speed above which an organ shakes, m/s. In 32 ticks a sphere at this speed moves by 0.1 mm,
/// which is one pixel if 1000 pixels show 10 cm.
const SHAKE_SPEED_M_S: f32 = 0.003;
/// Factor on `SHAKE_SPEED_M_S` for an organ that touches a tool at rest, because pressed tissue
/// alternates between places.
const TOUCHED_FACTOR: f32 = 10.0;
/// Length of a window in which the largest speed is measured, ticks: several oscillations of any
/// organ.
const WINDOW_TICKS: u16 = 2000;
/// Number of windows without rest after which an organ counts as shaking.
const WINDOWS: u8 = 3;
/// Share of its speed that an organ must keep from window to window to count as shaking. The
/// oscillation of an organ that keeps less decays: its speed falls to a tenth within 9 s.
const PERSISTENCE_SHARE: f32 = 0.6;

/// A finding about an organ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum UnrestKind {
    /// Distance of the organ's middle from its place, m.
    Falls(f32),
    /// Speed of its fastest sphere, m/s.
    Shakes(f32),
}

/// One organ.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OrganWatch {
    place_m: Vec3,
    /// Distance from its place beyond which it counts as falling, m.
    displacement_max_m: f32,
    /// Ticks for which the organ still counts as moved by a tool.
    disturbed_ticks: u16,
    /// Ticks for which the organ still counts as touched by a tool at rest.
    touched_ticks: u16,
    displaced_ticks: u16,
    window_ticks: u16,
    /// Largest speed in this window, m/s.
    peak_m_s: f32,
    /// Largest speed in the last window, m/s.
    last_peak_m_s: f32,
    windows: u8,
    is_freed: bool,
    has_fallen: bool,
    is_shaking: bool,
}

impl OrganWatch {
    const NONE: Self = Self {
        place_m: Vec3::new(0.0, 0.0, 0.0),
        displacement_max_m: f32::MAX,
        disturbed_ticks: 0,
        touched_ticks: 0,
        displaced_ticks: 0,
        window_ticks: 0,
        peak_m_s: 0.0,
        last_peak_m_s: 0.0,
        windows: 0,
        is_freed: false,
        has_fallen: false,
        is_shaking: false,
    };

    fn falls(&mut self, bounds: &Bounds) -> Option<UnrestKind> {
        let displacement_m = math::norm(&(middle(bounds) - self.place_m));
        let is_displaced = displacement_m > self.displacement_max_m && self.disturbed_ticks == 0;
        self.displaced_ticks = if is_displaced {
            self.displaced_ticks.saturating_add(1)
        } else {
            0
        };
        // The counter stops at `DISPLACED_TICKS`, so it does not overflow.
        if self.displaced_ticks < DISPLACED_TICKS || self.has_fallen {
            self.displaced_ticks = self.displaced_ticks.min(DISPLACED_TICKS);
            return None;
        }
        self.has_fallen = true;
        Some(UnrestKind::Falls(displacement_m))
    }

    fn shakes(&mut self, speed_min_m_s: f32) -> Option<UnrestKind> {
        if self.disturbed_ticks > 0 || self.has_fallen {
            (self.window_ticks, self.windows) = (0, 0);
            (self.peak_m_s, self.last_peak_m_s) = (0.0, 0.0);
            return None;
        }
        self.window_ticks = self.window_ticks.saturating_add(1);
        if self.window_ticks < WINDOW_TICKS {
            return None;
        }
        let factor = if self.touched_ticks > 0 {
            TOUCHED_FACTOR
        } else {
            1.0
        };
        let (peak_m_s, moves) = (self.peak_m_s, self.peak_m_s > speed_min_m_s * factor);
        let persists = peak_m_s >= PERSISTENCE_SHARE * self.last_peak_m_s;
        self.windows = match (moves, persists) {
            (true, true) => self.windows.saturating_add(1),
            (true, false) => 1,
            (false, _) => 0,
        };
        (self.last_peak_m_s, self.peak_m_s, self.window_ticks) = (peak_m_s, 0.0, 0);
        let must_report = self.windows >= WINDOWS && !self.is_shaking;
        self.is_shaking = moves && (self.is_shaking || must_report);
        must_report.then_some(UnrestKind::Shakes(peak_m_s))
    }
}

/// Watches all organs.
#[derive(Debug, Clone)]
pub(crate) struct Unrest {
    organs: [OrganWatch; MAX_ORGANS],
    /// Group of each organ. Attachments join the organs of a group. An organ with held spheres is
    /// alone in its group.
    group: [u8; MAX_ORGANS],
    /// Speed with which breathing may move an organ, m/s.
    breath_m_s: f32,
    /// Organs that shake while a tool moves them.
    shaking: Shaking,
    /// Motion of the endoscope.
    lens: Lens,
}

impl Unrest {
    /// Watches nothing.
    pub(crate) const NONE: Self = Self {
        organs: [OrganWatch::NONE; MAX_ORGANS],
        group: [0; MAX_ORGANS],
        breath_m_s: 0.0,
        shaking: Shaking::NONE,
        lens: Lens::AWAY,
    };

    /// Starts over with every organ at its place.
    pub(crate) fn start(&mut self, scene: &Scene<'_>, bounds: &[Bounds; MAX_ORGANS]) {
        let breaths = scene.organs.iter().map(|it| math::norm(&it.breath_m));
        let breath_m = match scene.room.breath_s {
            period_s if period_s > 0.0 => breaths.fold(0.0, f32::max),
            _ => 0.0,
        };
        // The raised cosine of a breath reaches the speed π · breath / period. The far end of an
        // organ may move twice as fast.
        let per_s = 2.0 * core::f32::consts::PI / scene.room.breath_s.max(0.1);
        self.breath_m_s = breath_m * per_s;
        self.shaking = Shaking::NONE;
        for (watched, bounds) in self.organs.iter_mut().zip(bounds) {
            *watched = OrganWatch {
                place_m: middle(bounds),
                displacement_max_m: math::norm(&(bounds.high_m - bounds.low_m)) + breath_m,
                ..OrganWatch::NONE
            };
        }
    }

    /// Numbers the groups of organs that attachments join. Groups do not extend across an organ
    /// with held spheres. `organ_of` gives the organ of a sphere.
    pub(crate) fn load(&mut self, scene: &Scene<'_>, organ_of: impl Fn(u32) -> u8) {
        for (number, group) in (0u8..).zip(&mut self.group) {
            *group = number;
        }
        let mut is_held = [false; MAX_ORGANS];
        for (organ, held) in scene.organs.iter().zip(&mut is_held) {
            let spheres = scene.spheres.iter().skip(organ.sphere_start as usize);
            *held = spheres.take(organ.sphere_count as usize).any(|it| it.held);
        }
        // Every organ of a group adopts the smallest number in the group, in fewer rounds than
        // there are organs.
        for _ in 0..MAX_ORGANS {
            for tie in scene.attachments {
                let Anchor::Sphere(other) = tie.to else {
                    continue;
                };
                let ends = [organ_of(tie.sphere), organ_of(other)].map(usize::from);
                if ends.iter().any(|end| is_held.get(*end) != Some(&false)) {
                    continue;
                }
                let numbers = ends.map(|end| self.group.get(end).copied().unwrap_or(0));
                for end in ends {
                    if let Some(group) = self.group.get_mut(end) {
                        *group = numbers.into_iter().fold(u8::MAX, u8::min);
                    }
                }
            }
        }
    }

    /// Records the speed of an organ in a tick in which it was simulated.
    pub(crate) fn record_speed(&mut self, organ: usize, speed_m_s: f32) {
        if let Some(watched) = self.organs.get_mut(organ) {
            watched.peak_m_s = watched.peak_m_s.max(speed_m_s);
        }
        self.shaking.record_speed(organ, speed_m_s);
    }

    /// Records the velocities of the watched spheres. `velocity_m_s` gives the velocity of a sphere
    /// over its last ticks.
    pub(crate) fn note_velocities(&mut self, organs: usize, velocity_m_s: impl Fn(u32) -> Vec3) {
        let speed_min_m_s = self.touched_speed_min_m_s();
        for organ in 0..organs {
            if let Some(sphere) = self.shaking.watched(organ) {
                let velocity_m_s = velocity_m_s(sphere);
                self.shaking
                    .note_velocity(organ, &velocity_m_s, speed_min_m_s);
            }
        }
    }

    /// Takes the place of the endoscope's lens in this tick, m; `None` while it is outside the
    /// body. Returns its speed, m/s; 0 in a tick in which no movement shows.
    pub(crate) fn follow_lens(&mut self, lens_m: Option<Vec3>) -> f32 {
        self.lens.follow(lens_m)
    }

    /// Speed above which an organ that a tool touches counts as shaking, m/s.
    fn touched_speed_min_m_s(&self) -> f32 {
        (SHAKE_SPEED_M_S + self.breath_m_s) * TOUCHED_FACTOR
    }

    /// Records that a tool moves the organ.
    pub(crate) fn disturb(&mut self, organ: usize) {
        if let Some(watched) = self.organs.get_mut(organ) {
            watched.disturbed_ticks = DISTURBED_TICKS;
        }
    }

    /// Records that a tool at rest touches the organ.
    pub(crate) fn touch(&mut self, organ: usize) {
        if let Some(watched) = self.organs.get_mut(organ) {
            watched.touched_ticks = DISTURBED_TICKS;
        }
    }

    /// True while a tool moves an organ, or did a moment ago.
    pub(crate) fn is_worked_on(&self) -> bool {
        self.organs.iter().any(|it| it.disturbed_ticks > 0)
    }

    /// Marks the organs within `margin_m` of an organ that a tool moves as moved by the tool too.
    pub(crate) fn spread_disturbance(&mut self, bounds: &[Bounds], margin_m: f32) {
        let before = self.organs;
        let moved = || {
            before
                .iter()
                .zip(bounds)
                .filter(|(it, _)| it.disturbed_ticks > 0)
        };
        for (watched, own) in self.organs.iter_mut().zip(bounds) {
            for (other, next_to) in moved() {
                if other.disturbed_ticks > watched.disturbed_ticks && own.is_near(next_to, margin_m)
                {
                    watched.disturbed_ticks = other.disturbed_ticks;
                }
            }
        }
    }

    /// Records that the trainee freed the organ, and with it all organs of its group.
    pub(crate) fn mark_freed(&mut self, organ: usize) {
        let Some(own) = self.group.get(organ).copied() else {
            return;
        };
        for (watched, group) in self.organs.iter_mut().zip(self.group) {
            watched.is_freed |= group == own;
        }
    }

    /// Ends a tick in which the faster hand had this speed: calls `report` with each organ that a
    /// tool moves and that shakes. `fastest` gives the fastest sphere of an organ.
    pub(crate) fn end_tick_of_worked_organs(
        &mut self,
        hand_m_s: f32,
        bounds: &[Bounds],
        fastest: impl Fn(usize) -> Option<u32>,
        mut report: impl FnMut(u32, Vec3, UnrestKind),
    ) {
        let (speed_min_m_s, organs) = (self.touched_speed_min_m_s(), &mut self.organs);
        let found = |organ: usize, peak_m_s: f32| {
            let (Some(watched), Some(bounds)) = (organs.get_mut(organ), bounds.get(organ)) else {
                return;
            };
            let may_move = watched.is_freed || watched.has_fallen || watched.disturbed_ticks == 0;
            if may_move || watched.is_shaking {
                return;
            }
            watched.is_shaking = true;
            report(organ as u32, middle(bounds), UnrestKind::Shakes(peak_m_s));
        };
        self.shaking
            .end_tick(hand_m_s, speed_min_m_s, fastest, found);
    }

    /// Ends a tick: calls `report` with each new finding about an organ that nobody freed.
    pub(crate) fn end_tick(
        &mut self,
        bounds: &[Bounds],
        mut report: impl FnMut(u32, Vec3, UnrestKind),
    ) {
        let speed_min_m_s = SHAKE_SPEED_M_S + self.breath_m_s;
        for ((organ, watched), bounds) in (0u32..).zip(&mut self.organs).zip(bounds) {
            let falls = watched.falls(bounds);
            let shakes = watched.shakes(speed_min_m_s);
            watched.disturbed_ticks = watched.disturbed_ticks.saturating_sub(1);
            watched.touched_ticks = watched.touched_ticks.saturating_sub(1);
            let found = falls.or(shakes).filter(|_| !watched.is_freed);
            if let Some(found) = found {
                report(organ, middle(bounds), found);
            }
        }
    }
}

fn middle(bounds: &Bounds) -> Vec3 {
    (bounds.low_m + bounds.high_m) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::Vec;

    const BALL: Bounds = Bounds {
        low_m: Vec3::new(-0.05, -0.05, -0.05),
        high_m: Vec3::new(0.05, 0.05, 0.05),
    };

    fn moved(by_m: f32) -> Bounds {
        let by_m = Vec3::new(0.0, 0.0, -by_m);
        Bounds {
            low_m: BALL.low_m + by_m,
            high_m: BALL.high_m + by_m,
        }
    }

    /// One organ at its place, 0.1 m wide.
    fn at_rest() -> Unrest {
        let mut unrest = Unrest::NONE;
        unrest.organs[0] = OrganWatch {
            displacement_max_m: 0.1733,
            ..OrganWatch::NONE
        };
        unrest
    }

    fn run(
        unrest: &mut Unrest,
        ticks: u32,
        mut course: impl FnMut(&mut Unrest, u32) -> (Bounds, f32),
    ) -> Vec<(u32, UnrestKind), 8> {
        let mut reported = Vec::new();
        for tick in 0..ticks {
            let (bounds, speed_m_s) = course(unrest, tick);
            unrest.record_speed(0, speed_m_s);
            unrest.end_tick(&[bounds], |_, _, found| {
                reported
                    .push((tick, found))
                    .expect("room for eight findings");
            });
        }
        reported
    }

    #[test]
    fn falling_organ_is_reported_once_and_returning_organ_is_not() {
        let fall = |_: &mut Unrest, tick: u32| {
            let s = tick as f32 * 0.001;
            (moved((4.9 * s * s).min(10.0)), 9.8 * s)
        };
        let reported = run(&mut at_rest(), 10_000, fall);
        assert!(
            matches!(reported[..], [(300..600, UnrestKind::Falls(m))] if m > 0.17),
            "{reported:?}"
        );
        let swings =
            |_: &mut Unrest, tick: u32| (moved(if tick % 300 < 150 { 0.3 } else { 0.0 }), 0.0);
        assert_eq!(run(&mut at_rest(), 10_000, swings), []);
    }

    #[test]
    fn freed_organ_and_organ_moved_by_a_tool_may_leave_their_places() {
        let mut freed = at_rest();
        freed.mark_freed(0);
        assert_eq!(run(&mut freed, 9_000, |_, _| (moved(5.0), 0.5)), []);
        let led = |unrest: &mut Unrest, _| {
            unrest.disturb(0);
            (moved(0.4), 0.2)
        };
        assert_eq!(run(&mut at_rest(), 9_000, led), []);
    }

    #[test]
    fn shaking_is_reported_once_and_again_after_rest() {
        let shakes = |_: &mut Unrest, _| (BALL, 0.02);
        let mut unrest = at_rest();
        let reported = run(&mut unrest, 60_000, shakes);
        assert_eq!(reported[..], [(5_999, UnrestKind::Shakes(0.02))]);
        assert_eq!(run(&mut unrest, 4_000, |_, _| (BALL, 0.0)), []);
        assert_eq!(run(&mut unrest, 20_000, shakes).len(), 1);
    }

    #[test]
    fn decaying_slow_or_worked_organs_do_not_shake() {
        // An oscillation that loses half of its speed in each second.
        let swings = |_: &mut Unrest, tick: u32| {
            let mut speed_m_s = 1.0;
            for _ in 0..tick / 1000 {
                speed_m_s *= 0.5;
            }
            (BALL, speed_m_s)
        };
        assert_eq!(run(&mut at_rest(), 60_000, swings), []);
        assert_eq!(run(&mut at_rest(), 60_000, |_, _| (BALL, 0.002)), []);
        let worked = |unrest: &mut Unrest, tick: u32| {
            if tick.is_multiple_of(5_000) {
                unrest.disturb(0);
            }
            (BALL, 0.5)
        };
        assert_eq!(run(&mut at_rest(), 60_000, worked), []);
        let pressed = |unrest: &mut Unrest, _| {
            unrest.touch(0);
            (BALL, 0.02)
        };
        assert_eq!(run(&mut at_rest(), 60_000, pressed), []);
    }

    #[test]
    fn disturbance_spreads_to_near_organs_and_no_farther() {
        let mut unrest = at_rest();
        unrest.disturb(0);
        let bounds = [BALL, moved(0.1), moved(0.5)];
        unrest.spread_disturbance(&bounds, 0.002);
        let disturbed_ticks = unrest.organs.map(|it| it.disturbed_ticks > 0);
        assert_eq!(disturbed_ticks[..3], [true, true, false]);
    }
}
