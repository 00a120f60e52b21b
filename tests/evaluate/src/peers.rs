//! Competitors: solvers by others, which the Python programs of `tests/evaluate/peers` run.
//!
//! Each competitor is a process of its own. It gets the scene as a JSON file, loads the body and
//! lets it settle. Then it answers each line `turn` with the processor time of a few ticks, so that
//! it takes turns with the methods of this program.

use std::io::{BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use rt_core::tissue::neo_hookean::STIFFNESS_SHARE;

use crate::body::{Body, V3};
use crate::scene::{Held, Scene};

/// Program that runs one competitor.
const PROGRAM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/serve.py");

/// Python in which the competitors are installed, and the folder of the scenes' files.
#[derive(Debug, Clone)]
pub(crate) struct Peers {
    pub(crate) python: PathBuf,
    pub(crate) folder: PathBuf,
}

/// A scene for competitors.
pub(crate) struct Trial<'a> {
    /// Name of the case.
    pub(crate) name: String,
    pub(crate) body: &'a Body,
    pub(crate) scene: &'a Scene,
    pub(crate) held: &'a [Held],
    /// The organ filled with coarse elements, for grids of cells. Its corners alone are given.
    pub(crate) filled: &'a fem_reference::Mesh,
    /// Displacement of each sphere by the reference, m: for fitting settings, not for solving.
    pub(crate) reference_m: &'a [Option<nalgebra::Vector3<f64>>],
    pub(crate) course: Course,
}

/// Length of the ticks, and number of ticks of each part of a trial.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course {
    pub(crate) tick_s: f32,
    pub(crate) ramp_ticks: usize,
    pub(crate) settle_ticks: usize,
    pub(crate) still_m_s: f32,
    pub(crate) turn_ticks: usize,
}

/// A competitor that has settled.
pub(crate) struct Peer {
    /// Its name, version and method.
    pub(crate) method: String,
    /// Its settings in words.
    pub(crate) setting: String,
    /// Number of its nodes.
    pub(crate) nodes: usize,
    /// Displacement of each sphere of the body, m.
    pub(crate) u_m: Vec<V3>,
    child: Child,
    asks: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Peers {
    /// Starts every competitor that is installed and takes this scene. The others are named on
    /// standard error.
    pub(crate) fn start(&self, trial: &Trial<'_>) -> Vec<Peer> {
        let (file, names) = match self.prepare(trial) {
            Ok(made) => made,
            Err(why) => {
                eprintln!("  competitors: {why}");
                return Vec::new();
            }
        };
        let mut peers = Vec::new();
        for name in names {
            match self.begin(&file, &name, trial.body.rest_m.len()) {
                Ok(peer) => peers.push(peer),
                Err(why) => eprintln!("  {name}: {why}"),
            }
        }
        peers
    }

    /// Writes the scene's file and asks for the names of the competitors.
    fn prepare(&self, trial: &Trial<'_>) -> Result<(PathBuf, Vec<String>), String> {
        std::fs::create_dir_all(&self.folder).map_err(|e| told(&self.folder, &e))?;
        let name = format!("{}-{}", trial.name, trial.body.rest_m.len());
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name: String = name.chars().map(plain).collect();
        let file = self.folder.join(name + ".json");
        std::fs::write(&file, json(trial)).map_err(|e| told(&file, &e))?;
        let listed = Command::new(&self.python)
            .args([PROGRAM, "--list"])
            .output()
            .map_err(|e| told(&self.python, &e))?;
        if !listed.status.success() {
            return Err(String::from_utf8_lossy(&listed.stderr).trim().to_owned());
        }
        let text = String::from_utf8_lossy(&listed.stdout);
        Ok((file, text.lines().map(str::to_owned).collect()))
    }

    fn begin(&self, scene: &Path, name: &str, spheres: usize) -> Result<Peer, String> {
        let mut child = Command::new(&self.python)
            .arg(PROGRAM)
            .arg(scene)
            .arg(name)
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| told(&self.python, &e))?;
        let (asks, answers) = (child.stdin.take(), child.stdout.take());
        let answers = answers.ok_or("no output")?;
        let mut peer = Peer {
            method: String::new(),
            setting: String::new(),
            nodes: 0,
            u_m: Vec::new(),
            child,
            asks,
            answers: BufReader::new(answers),
        };
        peer.hear(spheres)?;
        Ok(peer)
    }
}

impl Peer {
    /// Reads the first answer: a line with name, settings and number of nodes, and a line for each
    /// sphere with its displacement.
    fn hear(&mut self, spheres: usize) -> Result<(), String> {
        let line = self.line()?;
        let cells: Vec<&str> = line.split('\t').collect();
        let &["ready", method, setting, nodes] = cells.as_slice() else {
            return Err(line);
        };
        (self.method, self.setting) = (method.to_owned(), setting.replace('"', "'"));
        self.nodes = nodes.parse().map_err(|_| format!("nodes: {nodes}"))?;
        for _ in 0..spheres {
            let line = self.line()?;
            let u: Vec<f32> = line
                .split(' ')
                .map(|c| c.parse().unwrap_or(f32::NAN))
                .collect();
            let &[x, y, z] = u.as_slice() else {
                return Err(format!("displacement: {line}"));
            };
            self.u_m.push(V3::new(x, y, z));
        }
        Ok(())
    }

    /// Mean processor time of a tick over a few ticks, µs.
    ///
    /// # Errors
    /// The program's last words.
    pub(crate) fn turn_us(&mut self) -> Result<f64, String> {
        let asks = self.asks.as_mut().ok_or("no input")?;
        let asked = asks.write_all(b"turn\n").and_then(|()| asks.flush());
        asked.map_err(|e| e.to_string())?;
        let line = self.line()?;
        line.parse().map_err(|_| line)
    }

    fn line(&mut self) -> Result<String, String> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(0) => Err("it ended without an answer".to_owned()),
            Ok(_) => Ok(line.trim_end().to_owned()),
            Err(e) => Err(e.to_string()),
        }
    }
}

impl Drop for Peer {
    /// Without input the program ends.
    fn drop(&mut self) {
        drop(self.asks.take());
        let _ = self.child.wait(); // its results are here already
    }
}

fn told(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}

/// The scene as JSON: lists of numbers, SI.
fn json(trial: &Trial<'_>) -> String {
    let (body, scene, course) = (trial.body, trial.scene, &trial.course);
    let rows = |points: &[V3]| -> Vec<[f32; 3]> { points.iter().map(|p| (*p).into()).collect() };
    let held = |h: &Held| match h {
        Held::Free => 0,
        Held::Fixed => 1,
        Held::Moved => 2,
    };
    let point = |p: nalgebra::Vector3<f64>| -> [f64; 3] { p.into() };
    let [shift_m, turn_rad, pivot_m] = scene.course().map(point);
    let numbers = [
        ("young_pa", body.tissue.young_pa),
        ("poisson", body.tissue.poisson),
        ("stiffness_share", f64::from(STIFFNESS_SHARE)),
        ("density_kg_m3", body.tissue.density_kg_m3),
        ("damping_per_s", body.tissue.damping_per_s()),
        ("tick_s", f64::from(course.tick_s)),
        ("still_m_s", f64::from(course.still_m_s)),
        ("fixed_below_m", scene.fixed_below_m),
        ("free_below_m", scene.free_below_m),
        ("ramp_ticks", course.ramp_ticks as f64),
        ("settle_ticks", course.settle_ticks as f64),
        ("turn_ticks", course.turn_ticks as f64),
        ("springs", body.springs.len() as f64),
        ("axis", scene.axis as f64),
    ];
    let mut text = format!("{{\"name\": {:?}", trial.name);
    for (key, value) in numbers {
        text += &format!(",\n\"{key}\": {value:?}");
    }
    let reference = |u: &Option<nalgebra::Vector3<f64>>| match u {
        Some(u) => format!("{:?}", point(*u)),
        None => "null".to_owned(),
    };
    let references: Vec<_> = trial.reference_m.iter().map(reference).collect();
    let filled: Vec<[f64; 3]> = trial.filled.nodes.iter().map(|p| (*p).into()).collect();
    let corners = |t: &[u32; 10]| [t[0], t[1], t[2], t[3]];
    let corners: Vec<_> = trial.filled.tets.iter().map(corners).collect();
    let lists = [
        ("filled_nodes_m", format!("{filled:?}")),
        ("filled_tetrahedra", format!("{corners:?}")),
        ("reference_m", format!("[{}]", references.join(", "))),
        ("gravity_m_s2", format!("{:?}", point(scene.gravity()))),
        ("shift_m", format!("{shift_m:?}")),
        ("turn_rad", format!("{turn_rad:?}")),
        ("pivot_m", format!("{pivot_m:?}")),
        ("nodes_m", format!("{:?}", rows(&body.rest_m))),
        ("mass_kg", format!("{:?}", body.mass_kg)),
        (
            "held",
            format!("{:?}", trial.held.iter().map(held).collect::<Vec<_>>()),
        ),
        (
            "tetrahedra",
            format!(
                "{:?}",
                body.tets.iter().map(|t| t.nodes).collect::<Vec<_>>()
            ),
        ),
        (
            "volumes_m3",
            format!(
                "{:?}",
                body.tets.iter().map(|t| t.volume_m3).collect::<Vec<_>>()
            ),
        ),
    ];
    for (key, list) in lists {
        text += &format!(",\n\"{key}\": {list}");
    }
    text + "\n}\n"
}
