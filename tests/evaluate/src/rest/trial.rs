//! One trial: prepares a recipe as the product does, lets a hand work on it, and measures its speed
//! at rest.

use glam::Vec3;
use rt_process::rehearsal::{Rehearsal, rehearse};
use scene_prepare::{Recipe, prepare};
use shared_mem::message::{EventMsg, StateFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::{EventKind, Instrument};

use crate::seeded_hand::{Manner, Place, Seeded, SeededHand, place};

/// Time in which tissue must come to rest, ticks.
const REST_TICKS: u64 = 5000;
/// Time at the end of a rest in which speeds are measured, ticks.
const LOOK_TICKS: u64 = 400;
/// Ticks between two frames.
const LOOK_EVERY: u64 = 4;
/// Depth of the press, m.
const PRESS_M: f32 = 0.005;
/// Depth of the bite, and length of the pull, m.
const BITE_M: f32 = 0.003;
const PULL_M: f32 = 0.015;
/// Seed that chooses the place at which the hand works.
const SEED: u64 = 1;

/// A state in which the tissue must rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum After {
    /// The scene was loaded.
    Load,
    /// A tool presses and is held still.
    Press,
    /// The tool has left.
    Release,
    /// Jaws hold a pulled fold and are held still.
    Pull,
    /// The fold was let go.
    Drop,
}

impl After {
    /// All states, in the order of the trial.
    pub(super) const ALL: [Self; 5] = [
        Self::Load,
        Self::Press,
        Self::Release,
        Self::Pull,
        Self::Drop,
    ];

    /// Name in the table.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Press => "press",
            Self::Release => "release",
            Self::Pull => "pull",
            Self::Drop => "drop",
        }
    }
}

/// Result of a trial.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Found {
    /// Preparation refused the recipe with this message.
    Refused(String),
    /// Largest speeds of the tissue after 5 s.
    Moved(Speeds),
}

/// Largest speeds of any sphere at the end of each rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Speeds {
    /// In the order of [`After::ALL`], m/s.
    pub(super) after_m_s: [f32; 5],
    /// Largest speed of the handle at the end of each rest, m/s. A moving hand also moves the
    /// tissue.
    pub(super) hand_m_s: [f32; 5],
    /// Warnings of the preparation.
    pub(super) warnings: Vec<String>,
    /// True if the product itself reported that an organ shakes.
    pub(super) told: bool,
    /// True if the jaws held tissue.
    pub(super) held: bool,
    /// Number of spheres.
    pub(super) spheres: usize,
}

/// Measures the speeds of the spheres from their positions in consecutive frames.
struct Watch {
    before: Vec<[f32; 3]>,
    before_tick: u64,
    largest_m_s: f32,
    handle_before_m: [f32; 3],
    handle_m_s: f32,
    is_looking: bool,
    told: bool,
    held: bool,
}

impl Watch {
    fn see(&mut self, rehearsal: &mut Rehearsal<'_>) {
        self.listen(&rehearsal.events());
        drop(rehearsal.records());
        let state = rehearsal.state();
        if self.is_looking && state.tick > self.before_tick {
            let dt_s = (state.tick - self.before_tick) as f32 * 1e-3;
            let spheres = state.spheres().unwrap_or(&[]);
            for (sphere, before) in spheres.iter().zip(&self.before) {
                let speed_m_s = way_m(before, &sphere.center_m) / dt_s;
                self.largest_m_s = self.largest_m_s.max(speed_m_s);
            }
            let handle_m = rehearsal.tools().world_from_handle.position_m;
            let speed_m_s = way_m(&self.handle_before_m, &handle_m) / dt_s;
            self.handle_m_s = self.handle_m_s.max(speed_m_s);
            if state.spheres().is_none() {
                self.largest_m_s = f32::INFINITY;
            }
        }
        self.handle_before_m = rehearsal.tools().world_from_handle.position_m;
        self.keep(state);
    }

    fn keep(&mut self, state: &StateFrame) {
        let spheres = state.spheres().unwrap_or(&[]);
        self.before.clear();
        self.before.extend(spheres.iter().map(|it| it.center_m));
        self.before_tick = state.tick;
    }

    fn listen(&mut self, events: &[EventMsg]) {
        let is = |kind: EventKind| events.iter().any(|it| it.kind == kind.number());
        self.told |= is(EventKind::Shake);
        self.held |= is(EventKind::Grasp);
    }
}

/// Distance between two places, m.
fn way_m(from_m: &[f32; 3], to_m: &[f32; 3]) -> f32 {
    Vec3::from(*from_m).distance(Vec3::from(*to_m))
}

/// Prepares the recipe and measures the speeds.
///
/// # Errors
/// When the scene cannot be run, in words.
pub(super) fn run(recipe: &Recipe) -> Result<Found, String> {
    let prepared = match prepare(recipe, &mut |_| {}) {
        Ok(prepared) => prepared,
        Err(error) => return Ok(Found::Refused(error.to_string())),
    };
    let warnings = prepared.report.warnings.clone();
    let bytes = prepared.scene.to_bytes().map_err(|e| e.to_string())?;
    let scene = SceneFile::from_bytes(&bytes).map_err(|e| e.to_string())?;
    let (speeds, watch) = rehearse(&scene, |rehearsal| worked(&scene, rehearsal))
        .map_err(|error| error.to_string())?;
    Ok(Found::Moved(Speeds {
        after_m_s: speeds.map(|[tissue_m_s, _]| tissue_m_s),
        hand_m_s: speeds.map(|[_, hand_m_s]| hand_m_s),
        warnings,
        told: watch.told,
        held: watch.held,
        spheres: watch.before.len(),
    }))
}

fn worked(scene: &SceneFile, rehearsal: &mut Rehearsal<'_>) -> ([[f32; 2]; 5], Watch) {
    let watch = std::cell::RefCell::new(Watch {
        before: Vec::new(),
        before_tick: 0,
        largest_m_s: 0.0,
        handle_before_m: [0.0; 3],
        handle_m_s: 0.0,
        is_looking: false,
        told: false,
        held: false,
    });
    let target = scene.room().target_organ as usize;
    let place = place(scene, target, &mut Seeded::new(SEED));
    let mut see = |rehearsal: &mut Rehearsal<'_>| watch.borrow_mut().see(rehearsal);
    let mut hand = SeededHand::new(rehearsal, Manner::Gentle, LOOK_EVERY, &mut see);
    let speeds = After::ALL.map(|after| {
        if let Some(place) = place {
            after.act(&mut hand, &place);
        }
        hand.wait(REST_TICKS - LOOK_TICKS);
        {
            let mut watch = watch.borrow_mut();
            watch.is_looking = true;
            watch.largest_m_s = 0.0;
            watch.handle_m_s = 0.0;
        }
        hand.wait(LOOK_TICKS);
        let mut watch = watch.borrow_mut();
        watch.is_looking = false;
        [watch.largest_m_s, watch.handle_m_s]
    });
    (speeds, watch.into_inner())
}

impl After {
    /// Moves the hand from the previous state to this one.
    fn act(self, hand: &mut SeededHand<'_, '_>, place: &Place) {
        let out = -place.inwards;
        match self {
            Self::Load => {}
            Self::Press => {
                hand.take_up(Instrument::Grasper);
                hand.go(place.at_m + out * 0.025);
                hand.go(place.at_m - out * PRESS_M);
            }
            Self::Release => hand.go(place.at_m + out * 0.025),
            Self::Pull => {
                hand.go(place.at_m - out * BITE_M);
                hand.close(true);
                hand.wait(1000);
                hand.go(place.at_m + out * PULL_M);
            }
            Self::Drop => hand.close(false),
        }
    }
}
