//! Pulls with a grasper at an organ of the built-in scene, in the whole simulation.

use glam::{Quat, Vec3};
use rt_process::rehearsal::{Rehearsal, rehearse};
use scene_prepare::{Recipe, prepare};
use shared_mem::message::{CommandMsg, HandMsg};
use shared_mem::scene::{OrganRecord, RelaxationRecord, SceneFile, str_from_name};
use shared_mem::words::{EventKind, Instrument};

use crate::seeded_hand::{self, Place, Seeded, tip_m};

/// Speed of the hand, m/s.
const SPEED_M_S: f32 = 0.03;
/// Distance from the organ at which the hand starts, and depth of the jaws when they close, m.
const AWAY_M: f32 = 0.025;
const DEPTH_M: f32 = 0.003;
/// Length of the pull, m.
const PULL_M: f32 = 0.030;
/// Ticks in which the jaws close.
const CLOSE_TICKS: u64 = 500;
/// Ticks between two frames of the tools.
const FRAME: u64 = 4;
/// Button that closes the jaws.
const CLOSE: u32 = 1;

/// Forces of one pull, as the device renders them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pull {
    /// Largest force, N.
    pub(super) largest_n: f64,
    /// Force at the end of the hold divided by the force at its start; `None` if the tissue
    /// slipped.
    pub(super) left: Option<f64>,
}

/// Pulls at one place of an organ for each seed, and holds for `hold_s`. The organ relaxes by the
/// shares and times of `relaxation`, if there is one.
///
/// # Errors
/// The reason why the scene or the organ cannot be used, in words.
pub(super) fn pulls(
    organ: &str,
    seeds: u64,
    hold_s: f64,
    relaxation: Option<([f32; 2], [f32; 2])>,
) -> Result<Vec<Pull>, String> {
    let recipe = Recipe::built_in().map_err(|e| e.to_string())?;
    let mut prepared = prepare(&recipe, &mut |_| {}).map_err(|e| e.to_string())?;
    let is_named = |it: &OrganRecord| str_from_name(&it.name) == Some(organ);
    let place = prepared.scene.organs.iter().position(is_named);
    if let (Some((shares, times_s)), Some(place)) = (relaxation, place) {
        prepared.scene.relaxations = vec![RelaxationRecord {
            organ: place as u32,
            shares,
            times_s,
        }];
    }
    let bytes = prepared.scene.to_bytes().map_err(|e| e.to_string())?;
    let scene = SceneFile::from_bytes(&bytes).map_err(|e| e.to_string())?;
    let number = place.ok_or_else(|| format!("the built-in scene has no {organ}"))?;
    let one = |seed: u64| {
        let at = seeded_hand::place(&scene, number, &mut Seeded::new(seed))
            .ok_or_else(|| format!("no place of the {organ} faces the port"))?;
        rehearse(&scene, |rehearsal| Hand::new(rehearsal).pull(&at, hold_s))
            .map_err(|e| e.to_string())
    };
    (1..=seeds).map(one).collect()
}

struct Hand<'a, 'b> {
    rehearsal: &'a mut Rehearsal<'b>,
    asked: HandMsg,
    from_m: Vec3,
    at_m: Vec3,
    /// Forces of the frames since the pull began, N.
    forces_n: Vec<f64>,
    has_slipped: bool,
}

impl<'a, 'b> Hand<'a, 'b> {
    fn new(rehearsal: &'a mut Rehearsal<'b>) -> Self {
        let asked: HandMsg = bytemuck::Zeroable::zeroed();
        for _ in 0..10 * FRAME {
            rehearsal.tick(&asked, None);
        }
        let from_m = tip_m(rehearsal.tools());
        Self {
            rehearsal,
            asked,
            from_m,
            at_m: from_m,
            forces_n: Vec::new(),
            has_slipped: false,
        }
    }

    fn tick(&mut self, command: Option<CommandMsg>) {
        self.rehearsal.tick(&self.asked, command);
        let events = self.rehearsal.events();
        let slip = EventKind::Slip.number();
        self.has_slipped |= events.iter().any(|it| it.kind == slip);
        if self.rehearsal.ticks().is_multiple_of(FRAME) {
            let force_n = Vec3::from(self.rehearsal.tools().force_n);
            self.forces_n.push(f64::from(force_n.length()));
        }
    }

    fn wait(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.tick(None);
        }
    }

    fn go(&mut self, to_m: Vec3) {
        let picture = Quat::from_array(self.rehearsal.tools().world_from_camera.orientation);
        let step_m = SPEED_M_S * 1e-3;
        while self.at_m.distance(to_m) > step_m {
            self.at_m += (to_m - self.at_m).normalize_or_zero() * step_m;
            let moved = picture.inverse() * (self.at_m - self.from_m);
            self.asked.moved_m = moved.to_array().map(f64::from);
            self.tick(None);
        }
    }

    fn pull(mut self, at: &Place, hold_s: f64) -> Pull {
        self.go(at.at_m - at.inwards * AWAY_M);
        self.tick(Some(CommandMsg {
            kind: CommandMsg::INSTRUMENT,
            argument: Instrument::Grasper.number(),
        }));
        self.go(at.at_m + at.inwards * DEPTH_M);
        self.wait(CLOSE_TICKS);
        self.asked.buttons = CLOSE;
        self.wait(CLOSE_TICKS);
        self.forces_n.clear();
        self.has_slipped = false;
        self.go(at.at_m - at.inwards * PULL_M);
        let begin = self.forces_n.len();
        self.wait((hold_s * 1e3) as u64);
        let largest_n = self.forces_n.iter().copied().fold(0.0, f64::max);
        // After a tenth of the hold, the organ no longer swings.
        let hold = &self.forces_n[begin..];
        let (first, last) = (hold.get(hold.len() / 10), hold.last());
        let left = first.zip(last).map(|(first, last)| last / first);
        Pull {
            largest_n,
            left: left.filter(|_| !self.has_slipped),
        }
    }
}
