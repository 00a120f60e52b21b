//! Errors of a method against the reference.

use super::{RAMP_TICKS, Row, Stage, is_lost, tick};
use crate::body::V3;
use crate::case::Case;
use crate::methods::{State, Way};
use crate::peers::Peer;
use crate::scene::Held;

/// Row of a method, without its time.
pub(super) fn judge(case: &Case, stage: &Stage<'_>, way: Way, state: &State) -> Row {
    let (body, scene) = (stage.body, stage.scene);
    let mut row = Row {
        scene: case.name(),
        method: way.name().to_owned(),
        setting: way.setting(),
        spheres: body.rest_m.len(),
        us_per_tick: 0.0,
        rms_mm: f64::INFINITY,
        max_mm: f64::INFINITY,
        force_error_pct: f64::INFINITY,
        volume_error_pct: f64::INFINITY,
    };
    if is_lost(state) {
        return row;
    }
    row.compare(stage, &state.u_m);
    let pull_n = pull_n(stage, way, state);
    let pulls = (0..state.u_m.len()).filter(|&i| stage.held[i] != Held::Free);
    let mut load = scene.load(pulls.map(|i| {
        // The hold carries the weight of held tissue too.
        let weight = scene.gravity() * f64::from(body.mass_kg[i]);
        let pull: nalgebra::Vector3<f64> = pull_n[i].cast();
        let is_moved = stage.held[i] == Held::Moved;
        (
            is_moved,
            body.rest_m[i].cast(),
            state.u_m[i].cast(),
            pull + weight,
        )
    }));
    if scene.press.is_some() {
        load = f64::from(state.ball_force_n.norm());
    }
    row.force_error_pct = (load / stage.answer.load - 1.0) * 100.0;
    row
}

/// A competitor's row. Its forces are not read.
pub(super) fn judge_peer(case: &Case, stage: &Stage<'_>, peer: &Peer) -> Row {
    let mut row = Row {
        scene: case.name(),
        method: peer.method.clone(),
        setting: peer.setting.clone(),
        spheres: peer.nodes,
        us_per_tick: 0.0,
        rms_mm: f64::INFINITY,
        max_mm: f64::INFINITY,
        force_error_pct: f64::NAN,
        volume_error_pct: f64::INFINITY,
    };
    if peer.u_m.iter().all(|u| u.iter().all(|c| c.abs() < 10.0)) {
        row.compare(stage, &peer.u_m);
    }
    row
}

impl Row {
    /// Compares displacements of the spheres with the reference's, and the volumes.
    fn compare(&mut self, stage: &Stage<'_>, u_m: &[V3]) {
        let answer = &stage.answer;
        let free = (0..u_m.len()).filter(|&i| stage.held[i] == Held::Free);
        let errors: Vec<f64> = free
            .filter_map(|i| Some((u_m[i].cast::<f64>() - answer.displacement_m[i]?).norm() * 1e3))
            .collect();
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        self.rms_mm = (squares / errors.len().max(1) as f64).sqrt();
        self.max_mm = errors.iter().copied().fold(0.0, f64::max);
        self.volume_error_pct = (stage.body.growth(u_m) - answer.growth) * 100.0;
    }
}

/// Force of the tissue on each sphere, N. Calot does not report these forces. For Calot's solid
/// they are computed from the displacements. For the paper's method they come from one step of this
/// program's own version of that method (the twin).
fn pull_n(stage: &Stage<'_>, way: Way, state: &State) -> Vec<V3> {
    match way {
        Way::Ours => stage.body.pull_n(&state.u_m),
        Way::Paper(..) => {
            let mut after = state.clone();
            if let Ok(mut twin) = way.method(stage.body, &mut None) {
                let at = RAMP_TICKS as f64;
                tick(stage, way, twin.as_mut(), &mut after, [at, at + 1.0]);
            }
            after.pull_n
        }
        _ => state.pull_n.clone(),
    }
}
