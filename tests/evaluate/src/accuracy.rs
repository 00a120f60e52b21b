//! `evaluate accuracy`: the error of every method in every case, against its time.

use std::collections::BTreeMap;

mod judged;
mod kept;

use rustix::time::{ClockId, clock_gettime};
use scene_prepare::mesh::Mesh;
use scene_prepare::skin::ContactSkin;

use crate::body::{Body, V3};
use crate::case::Case;
use crate::methods::{Ball, Env, Method, Parts, State, Surroundings, Way};
use crate::peers::{self, Peer, Peers, Trial};
use crate::prepared::prepared;
use crate::scene::{Held, Kind, Scene};
use crate::solved::{self, Answer, tell};

use judged::{judge, judge_peer};
pub(crate) use kept::with_kept;

/// Length of a tick, s.
const TICK_S: f32 = 1e-3;
/// Ticks in which the load grows.
const RAMP_TICKS: usize = 800;
/// Largest number of further ticks in which the body settles.
const SETTLE_TICKS: usize = 6000;
/// Ticks per step of an implicit method while the body settles.
const IMPLICIT_TICKS: usize = 8;
/// A body whose spheres are all slower than this has settled, m/s.
const STILL_M_S: f32 = 2e-4;
/// Number of timing rounds. In each round all methods take turns.
const ROUNDS: usize = 9;
/// Ticks per turn of a method.
const TURN_TICKS: usize = 6;

/// One line of `accuracy.csv`.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Name of the case.
    pub(crate) scene: String,
    /// Name of the method; of a competitor, with its version.
    pub(crate) method: String,
    /// Fitted setting of the method; empty without one.
    pub(crate) setting: String,
    /// Number of spheres or, for hexahedra, of nodes.
    pub(crate) spheres: usize,
    /// Median processor time of a tick, µs.
    pub(crate) us_per_tick: f64,
    /// Root mean square of the displacement error of the free spheres, mm; infinite if the method
    /// blew up.
    pub(crate) rms_mm: f64,
    /// Largest displacement error, mm.
    pub(crate) max_mm: f64,
    /// Error of the force or torque, %; NaN if it was not measured.
    pub(crate) force_error_pct: f64,
    /// Error of the volume, % of the volume at rest.
    pub(crate) volume_error_pct: f64,
}

/// Extent of a run.
#[derive(Debug, Clone)]
pub(crate) struct Ask {
    /// Cases. The methods are calibrated on the first case.
    pub(crate) cases: Vec<Case>,
    /// Sphere counts.
    pub(crate) spheres: Vec<usize>,
    /// Further sphere counts, for the first three cases.
    pub(crate) many: Vec<usize>,
    /// Cube counts of the hexahedra.
    pub(crate) cubes: Vec<usize>,
    /// Layers of the reference's elements between the scene's planes.
    pub(crate) layers: usize,
    /// Competitors that take turns with the methods.
    pub(crate) peers: Option<Peers>,
}

impl Ask {
    /// Calot alone, beside competitors, in the first three cases.
    pub(crate) fn beside(peers: Peers, quick: bool) -> Self {
        Self {
            cases: Case::few(),
            spheres: match quick {
                true => vec![250],
                false => vec![100, 250, 581, 1200],
            },
            many: Vec::new(),
            cubes: Vec::new(),
            peers: Some(peers),
            ..Self::new(quick)
        }
    }

    /// All cases and counts, or few of them for a quick run.
    pub(crate) fn new(quick: bool) -> Self {
        if quick {
            return Self {
                cases: Case::few(),
                spheres: vec![150],
                many: Vec::new(),
                cubes: vec![250],
                layers: 8,
                peers: None,
            };
        }
        Self {
            cases: Case::all(),
            spheres: vec![250, 581, 1200],
            many: vec![100, 2500, 4000],
            cubes: vec![250, 967, 2500],
            layers: 18,
            peers: None,
        }
    }
}

/// Layers of the coarse mesh with which competitors fill their grids of cells.
const FILLED_LAYERS: usize = 6;
/// Name of Calot's rows that took turns with competitors.
pub(crate) const BESIDE: &str = "Calot, beside competitors";

/// Fitted stiffnesses of the paper's method and of the method with stretch and volume constraints,
/// by sphere count.
type Fits = BTreeMap<usize, [f32; 2]>;

/// Runs all cases. Progress goes to standard error. `keep` receives all rows so far after each
/// case, so that an aborted run keeps its results.
///
/// # Errors
/// When the first case has no reference, or `keep` fails. The error gives the reason in words.
pub(crate) fn run(
    ask: &Ask,
    keep: &mut dyn FnMut(&[Row]) -> Result<(), String>,
) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    let mut fits = Fits::new();
    for (i, case) in ask.cases.iter().enumerate() {
        eprintln!("[{}/{}] {}", i + 1, ask.cases.len(), case.name());
        let surface = match case.organ.mesh() {
            Ok(surface) => surface,
            Err(why) => {
                eprintln!("  skipped: {why}");
                continue;
            }
        };
        let mut counts = ask.spheres.clone();
        if i < 3 {
            counts.extend(&ask.many);
            counts.sort_unstable();
        }
        match one(ask, &counts, case, &surface, &mut fits) {
            Ok(more) => {
                rows.extend(more);
                keep(&rows)?;
            }
            Err(why) if i > 0 => eprintln!("  no reference: {why}"),
            Err(why) => return Err(why),
        }
    }
    Ok(rows)
}

fn one(
    ask: &Ask,
    counts: &[usize],
    case: &Case,
    surface: &Mesh,
    fits: &mut Fits,
) -> Result<Vec<Row>, String> {
    let scene = Scene::new(case.kind, surface);
    // The reference of a twist takes many load steps, and coarser meshes suffice for it.
    let layers = match case.kind {
        Kind::Twist(_) => ask.layers * 3 / 4,
        // Elements under a tool are already small where it matters.
        Kind::Press(..) => ask.layers / 2,
        _ => ask.layers,
    };
    let solved = solved::solve(surface, &scene, &case.tissue, layers, &mut tell)
        .map_err(|e| e.to_string())?;
    let mut rows = Vec::new();
    for &count in counts {
        let (body, skin) = match prepared(surface, count, case.tissue, &scene.planes()) {
            Ok(prepared) => prepared,
            Err(why) => {
                eprintln!("  {count} spheres: {why}");
                continue;
            }
        };
        let stage = Stage {
            skin: scene.press.map(|_| &skin),
            ..Stage::new(&body, &scene, solved.at(&body))
        };
        if let Some(peers) = &ask.peers {
            let filled = solved::mesh(surface, &scene, FILLED_LAYERS).map_err(|e| e.to_string())?;
            let peers = Some((peers, &filled));
            rows.extend(measure(case, &stage, &[Way::Ours], peers));
            continue;
        }
        let fit = *fits.entry(count).or_insert_with(|| {
            let paper = calibrate(&stage, |k| Way::Paper(k, 1));
            [paper, calibrate(&stage, Way::StretchVolume)]
        });
        let ways = [
            Way::ExplicitSprings,
            Way::Springs,
            Way::Paper(1.0, 1),
            Way::Paper(fit[0], 1),
            Way::StretchVolume(fit[1]),
            Way::XpbdSprings,
            Way::FromZero,
            Way::Ours,
        ];
        rows.extend(measure(case, &stage, &ways, None));
    }
    // A body of cubes has a stepped surface, against which no tool can be pressed.
    for &count in ask.cubes.iter().filter(|_| scene.press.is_none()) {
        let body = Body::of_cubes(surface, &scene, count, case.tissue);
        let stage = Stage::new(&body, &scene, solved.at(&body));
        rows.extend(measure(case, &stage, &[Way::Hexahedra], None));
    }
    Ok(rows)
}

/// A body in a scene, with the reference's solution.
struct Stage<'a> {
    body: &'a Body,
    scene: &'a Scene,
    answer: Answer,
    held: Vec<Held>,
    /// Contact skin, for Calot's method in cases with a tool.
    skin: Option<&'a ContactSkin>,
}

impl<'a> Stage<'a> {
    fn new(body: &'a Body, scene: &'a Scene, answer: Answer) -> Self {
        Self {
            skin: None,
            body,
            scene,
            answer,
            held: body.held(scene),
        }
    }

    fn around(&self) -> Surroundings {
        Surroundings {
            gravity_m_s2: self.scene.gravity().cast(),
            damping_per_s: self.body.tissue.damping_per_s() as f32,
        }
    }

    /// Displacement of a held sphere at a share of the load.
    fn target(&self, i: usize, share: f64) -> V3 {
        match self.held[i] {
            Held::Moved => self.scene.motion(&self.body.rest_m[i].cast(), share).cast(),
            Held::Fixed | Held::Free => V3::zeros(),
        }
    }
}

fn seconds() -> f64 {
    let t = clock_gettime(ClockId::ThreadCPUTime);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

fn is_lost(state: &State) -> bool {
    state.u_m.iter().any(|u| !u.iter().all(|c| c.abs() < 10.0))
}

/// Advances a method from tick `span[0]` to `span[1]`. The tick determines the share of the load.
fn tick(stage: &Stage<'_>, way: Way, method: &mut dyn Method, state: &mut State, span: [f64; 2]) {
    let substeps = way.substeps();
    let around = stage.around();
    let dt_s = TICK_S * (span[1] - span[0]) as f32 / substeps as f32;
    for sub in 1..=substeps {
        let at = span[0] + (span[1] - span[0]) * sub as f64 / substeps as f64;
        let share = (at / RAMP_TICKS as f64).min(1.0);
        for i in (0..stage.held.len()).filter(|&i| stage.held[i] != Held::Free) {
            state.target_m[i] = stage.target(i, share);
        }
        let env = Env {
            dt_s,
            gravity_m_s2: around.gravity_m_s2 * share as f32,
            damping_per_s: around.damping_per_s,
        };
        state.ball = stage.scene.press.map(|press| Ball {
            center_m: press.center_m(share).cast(),
            radius_m: press.radius_m as f32,
        });
        method.step(stage.body, state, &env);
        if !way.touches() {
            state.touch(stage.body, dt_s);
        }
    }
}

/// Loads the body and lets it settle.
fn settle(stage: &Stage<'_>, way: Way, method: &mut dyn Method) -> State {
    let held: Vec<bool> = stage.held.iter().map(|h| *h != Held::Free).collect();
    let mut state = State::at_rest(stage.body, &held);
    let stride = if way == Way::Hexahedra {
        IMPLICIT_TICKS
    } else {
        1
    };
    for i in (0..RAMP_TICKS + SETTLE_TICKS).step_by(stride) {
        tick(
            stage,
            way,
            method,
            &mut state,
            [i as f64, (i + stride) as f64],
        );
        if i % 48 == 0 {
            let speeds = state.v_m_s.iter().map(|v| v.norm_squared());
            let fastest = speeds.fold(0.0, f32::max).sqrt();
            if is_lost(&state) || (i > RAMP_TICKS + 100 && fastest < STILL_M_S) {
                break;
            }
        }
    }
    state
}

/// Finds the stiffness at which the mean displacement equals the reference's. The mean falls as the
/// stiffness rises.
fn calibrate(stage: &Stage<'_>, way: impl Fn(f32) -> Way) -> f32 {
    let reference = stage.answer.displacement_m.iter().flatten();
    let wanted: f64 = reference.map(nalgebra::Vector3::norm).sum();
    let (mut low, mut high) = (1e-4_f32.ln(), 1.0_f32.ln());
    for _ in 0..8 {
        let middle = (low + high) / 2.0;
        let way = way(middle.exp());
        let Ok(mut parts) = way.parts(stage.body, stage.skin, &stage.around()) else {
            break;
        };
        let Ok(mut method) = way.method(stage.body, &mut parts) else {
            break;
        };
        let state = settle(stage, way, method.as_mut());
        let reached: f64 = state.u_m.iter().map(|u| f64::from(u.norm())).sum();
        // A sum that is not finite counts as too soft.
        if reached < wanted {
            high = middle;
        } else {
            low = middle;
        }
    }
    ((low + high) / 2.0).exp()
}

/// Stiffnesses of the paper's method and of the method with stretch and volume constraints, both
/// fitted to the sag.
///
/// # Errors
/// When the sag has no reference. The error gives the reason in words.
pub(crate) fn fits(surface: &Mesh, body: &Body, layers: usize) -> Result<[f32; 2], String> {
    let scene = Scene::new(Kind::Sag, surface);
    let solved = solved::solve(surface, &scene, &body.tissue, layers, &mut tell)
        .map_err(|e| e.to_string())?;
    let stage = Stage::new(body, &scene, solved.at(body));
    let paper = calibrate(&stage, |k| Way::Paper(k, 1));
    Ok([paper, calibrate(&stage, Way::StretchVolume)])
}

/// A method with its state after the load.
type Run<'a> = (Way, Box<dyn Method + 'a>, State);

/// Settles every method and every competitor, then times them in turns.
fn measure(
    case: &Case,
    stage: &Stage<'_>,
    ways: &[Way],
    peers: Option<(&Peers, &fem_reference::Mesh)>,
) -> Vec<Row> {
    let mut parts: Vec<(Way, Option<Parts>)> = Vec::new();
    for &way in ways {
        match way.parts(stage.body, stage.skin, &stage.around()) {
            Ok(made) => parts.push((way, made)),
            Err(why) => eprintln!("  {}: {why}", way.name()),
        }
    }
    let mut runs: Vec<Run<'_>> = Vec::new();
    for (way, parts) in &mut parts {
        match way.method(stage.body, parts) {
            Ok(mut method) => {
                let state = settle(stage, *way, method.as_mut());
                runs.push((*way, method, state));
            }
            Err(why) => eprintln!("  {}: {why}", way.name()),
        }
    }
    let is_beside = peers.is_some();
    let mut peers = peers.map_or_else(Vec::new, |(peers, filled)| {
        peers.start(&trial(case, stage, filled))
    });
    let mut rows: Vec<Row> = runs
        .iter()
        .map(|(way, _, state)| judge(case, stage, *way, state))
        .collect();
    if is_beside {
        // Times of another session would not compare with those of the competitors.
        rows.iter_mut()
            .for_each(|row| row.method = BESIDE.to_owned());
    }
    rows.extend(peers.iter().map(|peer| judge_peer(case, stage, peer)));
    let times = take_turns(stage, &mut runs, &mut peers);
    for (row, mut times) in rows.iter_mut().zip(times) {
        times.sort_by(f64::total_cmp);
        row.us_per_tick = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
        eprintln!(
            "  {:5} {:42} {:8.0} µs  rms {:7.3} mm  max {:7.2} mm  force {:+6.1} %  volume {:+5.2} %",
            row.spheres,
            row.method,
            row.us_per_tick,
            row.rms_mm,
            row.max_mm,
            row.force_error_pct,
            row.volume_error_pct
        );
    }
    rows
}

/// Times of a tick in each round, µs: of every method, then of every competitor.
fn take_turns(stage: &Stage<'_>, runs: &mut [Run<'_>], peers: &mut [Peer]) -> Vec<Vec<f64>> {
    let mut times = vec![Vec::new(); runs.len() + peers.len()];
    for _ in 0..ROUNDS {
        let (ours, theirs) = times.split_at_mut(runs.len());
        for ((way, method, state), times) in runs.iter_mut().zip(ours) {
            let start = seconds();
            for i in 0..TURN_TICKS {
                let at = (RAMP_TICKS + i) as f64;
                tick(stage, *way, method.as_mut(), state, [at, at + 1.0]);
            }
            times.push((seconds() - start) * 1e6 / TURN_TICKS as f64);
        }
        for (peer, times) in peers.iter_mut().zip(theirs) {
            match peer.turn_us() {
                Ok(us) => times.push(us),
                Err(why) => eprintln!("  {}: {why}", peer.method),
            }
        }
    }
    times
}

/// The scene as competitors get it.
fn trial<'a>(case: &Case, stage: &'a Stage<'_>, filled: &'a fem_reference::Mesh) -> Trial<'a> {
    Trial {
        filled,
        name: case.name(),
        body: stage.body,
        scene: stage.scene,
        held: &stage.held,
        reference_m: &stage.answer.displacement_m,
        course: peers::Course {
            tick_s: TICK_S,
            ramp_ticks: RAMP_TICKS,
            settle_ticks: SETTLE_TICKS,
            still_m_s: STILL_M_S,
            turn_ticks: TURN_TICKS,
        },
    }
}

/// The rows as `accuracy.csv`.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,method,spheres,us_per_tick,rms_mm,max_mm,force_error_pct,volume_error_pct,setting\n",
    );
    for r in rows {
        text += &format!(
            "\"{}\",\"{}\",{},{:.1},{:.3},{:.3},{},{:.3},\"{}\"\n",
            r.scene,
            r.method,
            r.spheres,
            r.us_per_tick,
            r.rms_mm,
            r.max_mm,
            measured(r.force_error_pct),
            r.volume_error_pct,
            r.setting
        );
    }
    text
}

/// A value with two digits; empty if it was not measured.
fn measured(value: f64) -> String {
    match value.is_nan() {
        true => String::new(),
        false => format!("{value:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The quick run has three cases without a ball, and few spheres.
    #[test]
    fn ours_is_nearest_to_the_reference() {
        let rows = run(&Ask::new(true), &mut |_| Ok(())).expect("a run");
        let find = |scene: &str, way: Way| {
            let same = |r: &&Row| r.scene.ends_with(scene) && r.method == way.name();
            rows.iter().find(same).expect("a row").clone()
        };
        for scene in ["sag", "pull 30 mm", "twist 90°"] {
            let (ours, from_zero) = (find(scene, Way::Ours), find(scene, Way::FromZero));
            let apart_mm = (ours.rms_mm - from_zero.rms_mm).abs();
            assert!(apart_mm < 0.5, "{ours:?} {from_zero:?}");
            for paper in [Way::Paper(1.0, 1), Way::Paper(0.5, 1)] {
                let paper = find(scene, paper);
                assert!(ours.rms_mm < paper.rms_mm, "{ours:?} {paper:?}");
            }
            assert!(find(scene, Way::Hexahedra).rms_mm < 6.0);
        }
        assert_eq!(csv(&rows).lines().count(), rows.len() + 1);
    }
}
