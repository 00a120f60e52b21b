//! A hand that works at one place of an organ, and where everything lies afterwards.

use std::cell::RefCell;

use glam::{Quat, Vec3};
use rt_process::rehearsal::{Rehearsal, rehearse};
use shared_mem::message::StateFrame;
use shared_mem::scene::SceneFile;
use shared_mem::words::{EventKind, Instrument};

use super::lie::{Lie, Worst};
use crate::seeded_hand::{Manner, Place, Seeded, SeededHand, place};

/// Ticks from loading to the first work.
const LOAD_TICKS: u64 = 2000;
/// Time after a hand has left in which everything must rest, ticks.
const REST_TICKS: u64 = 2000;
/// Ticks at the end of the rest in which speeds are measured.
const LOOK_TICKS: u64 = 100;
/// Ticks between two frames.
const LOOK_EVERY: u64 = 4;
/// Distance from the skin at which a tool touches nothing, m.
const AWAY_M: f32 = 0.025;
/// Depth of a press, m.
const PRESS_M: f32 = 0.008;
/// Depth of a sweep and its length along the skin, m.
const SWEEP_M: [f32; 2] = [0.004, 0.030];
/// Depth of a bite, and length of the pull, m.
const BITE_M: f32 = 0.003;
const PULL_M: f32 = 0.030;

/// Work at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Work {
    /// Closed jaws press 8 mm deep.
    Press,
    /// The jaws grasp a fold and pull it by 30 mm.
    Pull,
    /// Closed jaws sweep along the skin by 30 mm.
    Sweep,
}

impl Work {
    pub(super) const ALL: [Self; 3] = [Self::Press, Self::Pull, Self::Sweep];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Press => "press",
            Self::Pull => "pull",
            Self::Sweep => "sweep",
        }
    }

    fn act(self, hand: &mut SeededHand<'_, '_>, at: &Place, seeded: &mut Seeded) {
        let into = |deep_m: f32| at.at_m + at.inwards * deep_m;
        hand.go(into(-AWAY_M));
        hand.take_up(Instrument::Grasper);
        hand.wait(100);
        match self {
            Self::Press => hand.go(into(PRESS_M)),
            Self::Pull => {
                hand.go(into(BITE_M));
                hand.close(true);
                hand.go(into(BITE_M - PULL_M));
                hand.wait(200);
                hand.close(false);
            }
            Self::Sweep => {
                let turn = std::f32::consts::TAU * seeded.share();
                let aside = at.inwards.any_orthonormal_vector();
                let along = Quat::from_axis_angle(at.inwards, turn) * aside;
                let [deep_m, long_m] = SWEEP_M;
                hand.go(into(deep_m));
                hand.go(into(deep_m) + along * long_m);
                hand.go(into(-AWAY_M) + along * long_m);
            }
        }
        hand.wait(200);
        hand.go(into(-AWAY_M));
    }
}

/// Where everything lies 2 s after the hand has left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Largest speed of a sphere, m/s.
    pub(super) speed_m_s: f32,
    /// Largest depth in another organ that was not there before, m.
    pub(super) inside_m: Worst,
    /// Largest growth of an attachment, m.
    pub(super) loose_m: Worst,
    /// Largest distance of a sphere from where it lay, m.
    pub(super) moved_m: Worst,
    /// True if tissue was cut, torn or removed.
    pub(super) is_torn: bool,
    /// True if the product itself told that an organ left its place.
    pub(super) is_told: bool,
    /// True if the jaws held tissue.
    pub(super) is_held: bool,
}

/// Speeds from the places in frames, and what events tell.
#[derive(Default)]
struct Watch {
    before_m: Vec<[f32; 3]>,
    before_tick: u64,
    speed_m_s: f32,
    is_looking: bool,
    is_torn: bool,
    is_told: bool,
    is_held: bool,
}

impl Watch {
    fn see(&mut self, rehearsal: &mut Rehearsal<'_>) {
        let events = rehearsal.events();
        drop(rehearsal.records());
        let is = |kinds: &[EventKind]| {
            let numbers: Vec<u32> = kinds.iter().map(|kind| kind.number()).collect();
            events.iter().any(|it| numbers.contains(&it.kind))
        };
        self.is_torn |= is(&[
            EventKind::Tear,
            EventKind::Cut,
            EventKind::Divided,
            EventKind::Perforation,
            EventKind::Removed,
        ]);
        self.is_told |= is(&[EventKind::Fall]);
        self.is_held |= is(&[EventKind::Grasp]);
        self.measure(rehearsal.state());
    }

    fn measure(&mut self, state: &StateFrame) {
        let spheres = state.spheres().unwrap_or(&[]);
        if self.is_looking && state.tick > self.before_tick {
            let dt_s = (state.tick - self.before_tick) as f32 * 1e-3;
            for (sphere, before) in spheres.iter().zip(&self.before_m) {
                let way_m = Vec3::from(sphere.center_m).distance(Vec3::from(*before));
                self.speed_m_s = self.speed_m_s.max(way_m / dt_s);
            }
        }
        self.before_m.clear();
        self.before_m.extend(spheres.iter().map(|it| it.center_m));
        self.before_tick = state.tick;
    }
}

/// Works at a place of an organ; `None` if no place of the organ faces the instrument's port.
///
/// # Errors
/// When the scene cannot be run, in words.
pub(super) fn run(
    scene: &SceneFile,
    organ: usize,
    work: Work,
    seed: u64,
) -> Result<Option<Found>, String> {
    let mut seeded = Seeded::new(seed);
    let Some(at) = place(scene, organ, &mut seeded) else {
        return Ok(None);
    };
    let manner = Manner::ALL[usize::from(seeded.share() < 0.5)];
    rehearse(scene, |rehearsal| {
        Some(worked(scene, rehearsal, work, manner, &at, &mut seeded))
    })
    .map_err(|error| error.to_string())
}

fn worked(
    scene: &SceneFile,
    rehearsal: &mut Rehearsal<'_>,
    work: Work,
    manner: Manner,
    at: &Place,
    seeded: &mut Seeded,
) -> Found {
    let watch = RefCell::new(Watch::default());
    let newest = RefCell::new(bytemuck::zeroed_box::<StateFrame>());
    let mut see = |rehearsal: &mut Rehearsal<'_>| {
        watch.borrow_mut().see(rehearsal);
        newest.borrow_mut().clone_from(&Box::new(*rehearsal.state()));
    };
    let mut hand = SeededHand::new(rehearsal, manner, LOOK_EVERY, &mut see);
    hand.wait(LOAD_TICKS);
    let before = Lie::new(scene, &newest.borrow());
    work.act(&mut hand, at, seeded);
    hand.wait(REST_TICKS - LOOK_TICKS);
    watch.borrow_mut().is_looking = true;
    hand.wait(LOOK_TICKS);
    let after = Lie::new(scene, &newest.borrow());
    let watch = watch.borrow();
    Found {
        speed_m_s: watch.speed_m_s,
        inside_m: after.inside_m(&before),
        loose_m: after.loosened_m(&before),
        moved_m: after.moved_m(&before),
        is_torn: watch.is_torn,
        is_told: watch.is_told,
        is_held: watch.is_held,
    }
}
