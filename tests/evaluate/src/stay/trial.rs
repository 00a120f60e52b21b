//! A hand works at one place of an organ and leaves. Then everything is measured.

use std::cell::RefCell;

use glam::{Quat, Vec3};
use rt_process::rehearsal::{Rehearsal, rehearse};
use shared_mem::message::{SphereState, StateFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::{EventKind, Instrument};

use super::snapshot::{Snapshot, Worst};
use crate::seeded_hand::{Manner, Place, Seeded, SeededHand, place};

/// Ticks from loading to the first work.
const LOAD_TICKS: u64 = 2000;
/// Time after a hand has left in which everything must rest, ticks.
const REST_TICKS: u64 = 2000;
/// Ticks at the end of the rest in which speeds are measured.
const LOOK_TICKS: u64 = 100;
/// Ticks between two frames.
const LOOK_EVERY: u64 = 4;
/// Distance of the tip from the place before and after the work, towards the port, m.
const AWAY_M: f32 = 0.025;
/// Way towards the port before the tip moves aside, m.
const OUT_M: f32 = 0.060;
/// Distance of a place's line to the port from every other organ, m: a shaft of 5 mm and some room.
const FREE_M: f32 = 0.004;
/// Places that are tried until one can be reached.
const TRIES: usize = 200;
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

    fn act(self, hand: &mut SeededHand<'_, '_>, port_m: Vec3, at: &Place, seeded: &mut Seeded) {
        let into = |deep_m: f32| at.at_m + at.inwards * deep_m;
        let back_m = |from_m: Vec3, way_m: f32| {
            let to_port = (port_m - from_m).normalize_or_zero();
            from_m + to_port * way_m
        };
        let start_m = hand.tip_m();
        hand.go(back_m(start_m, OUT_M));
        hand.go(back_m(at.at_m, OUT_M));
        hand.go(back_m(at.at_m, AWAY_M));
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
            }
        }
        hand.wait(200);
        hand.go(back_m(at.at_m, OUT_M));
        hand.go(back_m(start_m, OUT_M));
        hand.leave();
    }
}

/// State of all organs 2 s after the hand has left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Largest speed of a sphere, m/s.
    pub(super) speed_m_s: Worst,
    /// Largest depth in another organ that was not there before, m.
    pub(super) inside_m: Worst,
    /// Largest growth of an attachment, m.
    pub(super) loose_m: Worst,
    /// Largest distance of a sphere from where it lay, m.
    pub(super) moved_m: Worst,
    /// True if tissue was cut, torn or removed.
    pub(super) is_torn: bool,
    /// True if the product itself reported that an organ left its place.
    pub(super) is_told: bool,
    /// True if the jaws held tissue.
    pub(super) is_held: bool,
    /// True if the tool still touches tissue: other organs caught it on its way out.
    pub(super) is_touched: bool,
}

/// Speeds from the places in frames, and what events tell.
#[derive(Default)]
struct Watch {
    before_m: Vec<[f32; 3]>,
    before_tick: u64,
    /// Largest speed, m/s, and its sphere.
    fastest: (f32, usize),
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
            for (i, (sphere, before)) in spheres.iter().zip(&self.before_m).enumerate() {
                let way_m = Vec3::from(sphere.center_m).distance(Vec3::from(*before));
                if way_m / dt_s > self.fastest.0 {
                    self.fastest = (way_m / dt_s, i);
                }
            }
        }
        self.before_m.clear();
        self.before_m.extend(spheres.iter().map(|it| it.center_m));
        self.before_tick = state.tick;
    }
}

/// True if no other organ lies between a place and the instrument's port.
fn is_reached(scene: &SceneFile, organ: usize, at: &Place) -> bool {
    let port_m = Vec3::from(scene.room().instrument_port_m);
    let [first, count] = scene.organs()[organ].spheres.map(|x| x as usize);
    let others = scene.spheres().iter().enumerate();
    let mut others = others.filter(|(i, _)| !(first..first + count).contains(i));
    let way_m = at.at_m - port_m;
    others.all(|(_, sphere)| {
        let center_m = Vec3::from(sphere.center_m);
        let share = (center_m - port_m).dot(way_m) / way_m.length_squared();
        let nearest_m = port_m + way_m * share.clamp(0.0, 1.0);
        nearest_m.distance(center_m) > sphere.radius_m + FREE_M
    })
}

/// Works at a place of an organ; `None` if the instrument can reach no place of it from the port.
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
    let mut places = (0..TRIES).filter_map(|_| place(scene, organ, &mut seeded));
    let Some(at) = places.find(|it| is_reached(scene, organ, it)) else {
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
        newest
            .borrow_mut()
            .clone_from(&Box::new(*rehearsal.state()));
    };
    let mut hand = SeededHand::new(rehearsal, manner, LOOK_EVERY, &mut see);
    hand.wait(LOAD_TICKS);
    let before = Snapshot::new(scene, &newest.borrow());
    let port_m = Vec3::from(scene.room().instrument_port_m);
    work.act(&mut hand, port_m, at, seeded);
    hand.wait(REST_TICKS - LOOK_TICKS);
    watch.borrow_mut().is_looking = true;
    hand.wait(LOOK_TICKS);
    let after = Snapshot::new(scene, &newest.borrow());
    let newest = newest.borrow();
    let mut spheres = newest.spheres().unwrap_or(&[]).iter();
    let is_touched = spheres.any(|it| it.bits & SphereState::CONTACT != 0);
    let watch = watch.borrow();
    Found {
        speed_m_s: after.of_sphere(watch.fastest),
        inside_m: after.inside_m(&before),
        loose_m: after.loosened_m(&before),
        moved_m: after.moved_m(&before),
        is_torn: watch.is_torn,
        is_told: watch.is_told,
        is_held: watch.is_held,
        is_touched,
    }
}
