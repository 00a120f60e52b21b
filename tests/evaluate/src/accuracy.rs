//! `evaluate accuracy`: every method in every scene, its error against its time.

use std::path::Path;

use rustix::time::{ClockId, clock_gettime};

use crate::body::{Body, Held, Tissue, V3};
use crate::methods::{
    Env, MassSpring, Method, NeoHookean, PaperPbd, State, StretchVolume, XpbdSprings,
};
use crate::organ::Organ;
use crate::reference::{self, Answer};
use crate::scene::{Kind, Scene};

/// Length of a tick, s.
const TICK_S: f32 = 1e-3;
/// Load grows for this long, ticks; then the body may settle for up to [`SETTLE_TICKS`].
const RAMP_TICKS: usize = 800;
const SETTLE_TICKS: usize = 4000;
/// Settled: no sphere faster than this, m/s.
const STILL_M_S: f32 = 2e-4;

/// One line of `accuracy.csv`.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Scene.
    pub(crate) scene: String,
    /// Method.
    pub(crate) method: String,
    /// How many spheres.
    pub(crate) spheres: usize,
    /// Processor time of a tick, µs.
    pub(crate) us_per_tick: f64,
    /// Root mean square of the displacement error of the free spheres, mm; infinite: blew up.
    pub(crate) rms_mm: f64,
    /// The largest, mm.
    pub(crate) max_mm: f64,
    /// Error of the force (or torque), %.
    pub(crate) force_error_pct: f64,
    /// Error of the volume, % of the volume.
    pub(crate) volume_error_pct: f64,
}

/// What is asked on the command line.
#[derive(Debug, Clone)]
pub(crate) struct Ask {
    /// Sphere counts.
    pub(crate) spheres: Vec<usize>,
    /// Layers of elements of the reference between the scene's planes.
    pub(crate) layers: usize,
    /// Scenes.
    pub(crate) kinds: Vec<Kind>,
}

/// A method as the chart names it, and its steps a tick.
struct Entry {
    name: String,
    method: Box<dyn Method>,
    substeps: usize,
}

/// Runs everything; tells on standard error how far it is.
///
/// # Errors
/// What went wrong, in words.
pub(crate) fn run(ask: &Ask) -> Result<Vec<Row>, String> {
    let tissue = Tissue {
        young_pa: 5000.0,
        poisson: 0.45,
        density_kg_m3: 1060.0,
    };
    let surface = Organ::Liver.mesh()?;
    let bodies: Vec<Body> = ask
        .spheres
        .iter()
        .map(|&n| Body::packed(&surface, n, tissue).ok_or(format!("{n} spheres cannot be packed")))
        .collect::<Result<_, _>>()?;
    let mut rows = Vec::new();
    let mut calibrated: Vec<Vec<Entry>> = Vec::new();
    for &kind in &ask.kinds {
        let scene = Scene::new(kind, &surface);
        let solved = reference::solve(&surface, &scene, &tissue, ask.layers, &mut |share| {
            eprintln!("reference, {}: {:.0} %", kind.name(), share * 100.0);
        })
        .map_err(|e| e.to_string())?;
        for (i, body) in bodies.iter().enumerate() {
            let answer = solved.at(body);
            if calibrated.len() <= i {
                calibrated.push(entries(body, &scene, &answer));
            }
            for entry in &calibrated[i] {
                let row = measure(body, &scene, entry, &answer);
                eprintln!("{row:?}");
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// Every method, dimensionless settings calibrated on `scene` (the first: sag) by the mean
/// displacement.
fn entries(body: &Body, scene: &Scene, answer: &Answer) -> Vec<Entry> {
    let entry = |name: &str, method: Box<dyn Method>, substeps| Entry {
        name: name.to_owned(),
        method,
        substeps,
    };
    let paper = |stiffness| PaperPbd {
        stiffness,
        iterations: 1,
    };
    let k_paper = calibrate(body, scene, answer, |k| Box::new(paper(k)));
    let k_volume = calibrate(body, scene, answer, |stiffness| {
        Box::new(StretchVolume { stiffness })
    });
    vec![
        entry(
            "mass-spring, explicit Euler",
            Box::new(MassSpring { explicit: true }),
            4,
        ),
        entry(
            "mass-spring, semi-implicit",
            Box::new(MassSpring { explicit: false }),
            4,
        ),
        entry("paper's PBD, k = 1", Box::new(paper(1.0)), 1),
        entry(
            &format!("paper's PBD, k = {k_paper:.4} (fitted)"),
            Box::new(paper(k_paper)),
            1,
        ),
        entry(
            &format!("PBD stretch + volume, k = {k_volume:.4} (fitted)"),
            Box::new(StretchVolume {
                stiffness: k_volume,
            }),
            1,
        ),
        entry("XPBD springs + volume", Box::new(XpbdSprings), 1),
        entry("XPBD neo-Hookean", Box::new(NeoHookean), 1),
    ]
}

/// The stiffness whose mean displacement is the reference's; the mean falls with stiffness.
fn calibrate(
    body: &Body,
    scene: &Scene,
    answer: &Answer,
    method: impl Fn(f32) -> Box<dyn Method>,
) -> f32 {
    let wanted: f64 = answer.displacement_m.iter().map(|u| u.norm()).sum();
    let (mut low, mut high) = (1e-4_f32.ln(), 1.0_f32.ln());
    for _ in 0..8 {
        let middle = (low + high) / 2.0;
        let entry = Entry {
            name: String::new(),
            method: method(middle.exp()),
            substeps: 1,
        };
        let (state, _) = simulate(body, scene, &entry);
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

fn seconds() -> f64 {
    let t = clock_gettime(ClockId::ThreadCPUTime);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// Loads the body and lets it settle; returns its end and the median time of a tick, µs.
fn simulate(body: &Body, scene: &Scene, entry: &Entry) -> (State, f64) {
    let rest: Vec<nalgebra::Vector3<f64>> = body.rest_m.iter().map(|x| x.cast()).collect();
    let held: Vec<bool> = body.held(scene).iter().map(|h| *h != Held::Free).collect();
    let moved: Vec<bool> = body.held(scene).iter().map(|h| *h == Held::Moved).collect();
    let mut state = State::at_rest(body, &held);
    let dt_s = TICK_S / entry.substeps as f32;
    let gravity: V3 = scene.gravity().cast();
    let mut times = Vec::new();
    for tick in 0..RAMP_TICKS + SETTLE_TICKS {
        let mut spent = 0.0;
        for sub in 1..=entry.substeps {
            let at = tick as f64 + sub as f64 / entry.substeps as f64;
            let share = (at / RAMP_TICKS as f64).min(1.0);
            for (i, x) in rest.iter().enumerate().filter(|(i, _)| moved[*i]) {
                state.target_m[i] = scene.motion(x, share).cast();
            }
            let env = Env {
                dt_s,
                gravity_m_s2: gravity * share as f32,
                damping_per_s: 8.0,
            };
            let start = seconds();
            entry.method.step(body, &mut state, &env);
            spent += seconds() - start;
        }
        times.push(spent * 1e6);
        if tick % 50 == 49 {
            let fastest = state
                .v_m_s
                .iter()
                .map(|v| v.norm_squared())
                .fold(0.0, f32::max)
                .sqrt();
            let lost = state.u_m.iter().any(|u| !u.iter().all(|c| c.abs() < 10.0));
            if lost || (tick > RAMP_TICKS && fastest < STILL_M_S) {
                break;
            }
        }
    }
    times.sort_by(f64::total_cmp);
    (state, times[times.len() / 2])
}

fn measure(body: &Body, scene: &Scene, entry: &Entry, answer: &Answer) -> Row {
    let (state, us_per_tick) = simulate(body, scene, entry);
    let mut row = Row {
        scene: scene.kind.name(),
        method: entry.name.clone(),
        spheres: body.rest_m.len(),
        us_per_tick,
        rms_mm: f64::INFINITY,
        max_mm: f64::INFINITY,
        force_error_pct: f64::INFINITY,
        volume_error_pct: f64::INFINITY,
    };
    if state.u_m.iter().any(|u| !u.iter().all(|c| c.abs() < 10.0)) {
        return row;
    }
    let (mut squares, mut count) = (0.0, 0);
    row.max_mm = 0.0;
    for (i, u) in state
        .u_m
        .iter()
        .enumerate()
        .filter(|(i, _)| state.w_per_kg[*i] > 0.0)
    {
        let error = (u.cast::<f64>() - answer.displacement_m[i]).norm() * 1e3;
        squares += error * error;
        row.max_mm = row.max_mm.max(error);
        count += 1;
    }
    row.rms_mm = (squares / f64::from(count.max(1))).sqrt();
    let pulls = (0..state.u_m.len()).filter(|&i| state.w_per_kg[i] <= 0.0);
    let held = body.held(scene);
    let load = scene.load(pulls.map(|i| {
        // Held tissue hangs from the hold too.
        let weight = scene.gravity() * f64::from(body.mass_kg[i]);
        let pull: nalgebra::Vector3<f64> = state.pull_n[i].cast();
        (held[i] == Held::Moved, body.rest_m[i].cast(), state.u_m[i].cast(), pull + weight)
    }));
    let sum = |u: f64, v: f64| if v > 0.0 { u / v } else { 0.0 };
    let (a, b) = answer.displacement_m.iter().zip(&state.u_m).fold((0.0, 0.0), |(a, b), (r, u)| (a + u.cast::<f64>().norm(), b + r.norm()));
    eprintln!("ratio {}", sum(a, b));
    row.force_error_pct = (load / answer.load - 1.0) * 100.0;
    row.volume_error_pct = (body.growth(&state.u_m) - answer.growth) * 100.0;
    row
}

/// Writes `accuracy.csv`.
///
/// # Errors
/// As the file system says.
pub(crate) fn write_csv(rows: &[Row], path: &Path) -> std::io::Result<()> {
    let mut text = String::from(
        "scene,method,spheres,us_per_tick,rms_mm,max_mm,force_error_pct,volume_error_pct\n",
    );
    for r in rows {
        text += &format!(
            "{},\"{}\",{},{:.1},{:.3},{:.3},{:.2},{:.3}\n",
            r.scene,
            r.method,
            r.spheres,
            r.us_per_tick,
            r.rms_mm,
            r.max_mm,
            r.force_error_pct,
            r.volume_error_pct
        );
    }
    std::fs::write(path, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reduced run: coarse, one scene, but the whole way.
    #[test]
    fn neo_hookean_is_nearer_to_the_reference_than_the_papers_method() {
        let ask = Ask {
            spheres: vec![120],
            layers: 6,
            kinds: vec![Kind::Sag, Kind::Twist(90)],
        };
        let rows = run(&ask).expect("a run");
        let find = |scene: &str, method: &str| {
            let same = |r: &&Row| r.scene == scene && r.method.starts_with(method);
            rows.iter().find(same).expect("a row").clone()
        };
        let (ours, fitted) = (
            find("twist 90°", "XPBD neo"),
            find("twist 90°", "paper's PBD, k = 0"),
        );
        assert!(ours.rms_mm < 4.0, "{ours:?}");
        assert!(fitted.rms_mm > 1.5 * ours.rms_mm, "{fitted:?} {ours:?}");
        let (ours, fitted) = (find("sag", "XPBD neo"), find("sag", "paper's PBD, k = 0"));
        assert!(ours.rms_mm < fitted.rms_mm, "{fitted:?} {ours:?}");
        assert!(ours.force_error_pct.abs() < 10.0, "{ours:?}");
        let csv = std::env::temp_dir().join(format!("evaluate-{}.csv", std::process::id()));
        write_csv(&rows, &csv).expect("written");
        let text = std::fs::read_to_string(&csv).expect("read");
        std::fs::remove_file(&csv).expect("removed");
        assert_eq!(text.lines().count(), rows.len() + 1);
        assert!(crate::chart::svg(&rows).expect("drawn").contains("</svg>"));
    }
}
