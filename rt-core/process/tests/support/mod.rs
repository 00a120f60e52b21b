//! A small scene and a station of its own for each test.
#![allow(dead_code, missing_docs, unreachable_pub)] // each test file uses its part

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering, Ordering::Relaxed};
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};

use hardware::emulate::{EmulateConfig, HandScript, LineFaults, Lines};
use rt_core::math::{Pose, Quat, Vec3};
use rt_process::alloc_counter::CountingAllocator;
use rt_process::realtime;
use rt_process::{AdmissionPolicy, RtConfig};
use shared_mem::message::PoseMsg;
use shared_mem::scene::{
    LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord, SceneData, SceneFile,
    SphereRecord, name_from_str,
};
use shared_mem::service::{Host, Station};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator::new();

/// Spheres of the test scene: a 5 × 5 × 5 block of tissue whose bottom is held.
pub const SPHERES: usize = 125;

/// A folder with a compiled scene, and a unique station name.
pub struct Bench {
    pub folder: tempfile::TempDir,
    pub station: String,
}

impl Bench {
    pub fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = tempfile::tempdir().expect("the test's own set-up");
        block(5)
            .write(&folder.path().join("block.calot"))
            .expect("the test's own set-up");
        block(2)
            .write(&folder.path().join("coarse.calot"))
            .expect("the test's own set-up");
        Self {
            folder,
            station: format!("rt-test-{}-{n}", std::process::id()),
        }
    }

    pub fn scene(&self) -> PathBuf {
        self.folder.path().join("block.calot")
    }

    /// The scene with 8 spheres.
    pub fn coarse_scene(&self) -> PathBuf {
        self.folder.path().join("coarse.calot")
    }

    /// Settings without admission, which takes a second.
    pub fn config(&self) -> RtConfig {
        RtConfig {
            admission: AdmissionPolicy::Skip,
            ..RtConfig::new(&self.station, self.scene())
        }
    }
}

impl Drop for Bench {
    /// Removes what iceoryx2 leaves of the station in shared memory, because the station is never
    /// used again.
    fn drop(&mut self) {
        let station = Station::new(&self.station).expect("the test's own set-up");
        let own = station.file_prefix();
        for entry in std::fs::read_dir("/dev/shm")
            .into_iter()
            .flatten()
            .flatten()
        {
            if entry.file_name().to_string_lossy().starts_with(own) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// A display's host of the bench's station.
pub fn host(bench: &Bench) -> Host {
    Host::open(&Station::new(&bench.station).expect("the test's own set-up"))
        .expect("the test's own set-up")
}

/// Gives the calling thread a processor of its own, if possible, as a real device has.
pub fn have_own_processor() {
    let cores = realtime::allowed_cores();
    let tick_core = cores.last().copied().unwrap_or(0);
    let _ = realtime::work_beside_tick(&cores, tick_core, 70);
}

/// Emulated devices in a thread; they end when `stop` is set.
pub struct Emulated {
    pub stop: Arc<AtomicBool>,
    pub thread: JoinHandle<()>,
    pub lines: Lines,
}

impl Emulated {
    pub fn start(bench: &Bench) -> Self {
        let scene = SceneFile::open(&bench.scene()).expect("the test's own set-up");
        let room = scene.room();
        let config = EmulateConfig {
            directory: bench.folder.path().join("devices"),
            script: HandScript {
                instrument_port_m: room.instrument_port_m.into(),
                instrument_length_m: room.instrument_length_m,
                world_from_device: pose(&room.world_from_device),
                world_from_tracker: pose(&room.world_from_tracker),
                world_from_camera: pose(&room.world_from_camera),
                endoscope_port_m: room.endoscope_port_m.into(),
                target_m: room.target_m.into(),
                target_normal: room.target_normal.into(),
            },
            seed: 1,
            haptic: hardware::emulate::HapticModel::default(),
            mistake: None,
            holding: hardware::emulate::Holding::default(),
            faults: LineFaults::default(),
        };
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let (tell, told) = mpsc::channel();
        let thread = thread::spawn(move || {
            have_own_processor();
            hardware::emulate::run(&config, &flag, &mut |lines| {
                tell.send(lines.clone()).expect("the test's own set-up");
            })
            .expect("the test's own set-up");
        });
        let lines = told.recv().expect("the test's own set-up");
        Self {
            stop,
            thread,
            lines,
        }
    }

    pub fn unplug(self) {
        self.stop.store(true, Relaxed);
        self.thread.join().expect("the test's own set-up");
    }

    /// Writes a station file that names the haptic device and the tracker with their drivers, makes
    /// a button of the handle a pedal, and moves the haptic device's base.
    pub fn station_file(&self, bench: &Bench) -> PathBuf {
        let Lines {
            haptic, tracker, ..
        } = &self.lines;
        let text = format!(
            "[haptic]\ndriver = \"rig\"\npath = {haptic:?}\nforce_max_n = 2.0\n\
             [handle_buttons]\ncoagulate = 1\n\
             [tracker]\ndriver = \"bird\"\npath = {tracker:?}\n\
             [frames.world_from_device]\nposition_m = [0.0, 0.0, 0.25]\n\
             rotation_xyzw = [0.0, 0.0, 0.0, 1.0]\n"
        );
        let path = bench.folder.path().join("station.toml");
        std::fs::write(&path, text).expect("the test's own set-up");
        path
    }

    pub fn config(&self, bench: &Bench) -> RtConfig {
        RtConfig {
            haptic: Some(self.lines.haptic.clone()),
            tracker: Some(self.lines.tracker.clone()),
            pedal: Some(self.lines.pedal.clone()),
            ..bench.config()
        }
    }
}

fn pose(message: &PoseMsg) -> Pose {
    let [x, y, z, w] = message.orientation;
    let rotation = Quat::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    Pose::from_parts(Vec3::from(message.position_m).into(), rotation)
}

/// A block of `n`³ spheres, 8 cm wide, 10 cm below the port.
fn block(n: usize) -> SceneData {
    let step_m = 0.08 / (n - 1) as f32;
    let mut spheres = Vec::new();
    let mut links = Vec::new();
    let index = |x: usize, y: usize, z: usize| ((z * n + y) * n + x) as u32;
    for (z, y, x) in (0..n * n * n).map(|i| (i / (n * n), i / n % n, i % n)) {
        let at = |i: usize| i as f32 * step_m - 0.04;
        spheres.push(SphereRecord {
            center_m: [at(x), at(y), at(z) - 0.1],
            radius_m: step_m / 2.0,
            mass_kg: 0.5 / (n * n * n) as f32,
            held: u32::from(z == 0),
        });
        // Links along the edges and the diagonals of the faces. Without the diagonals the block
        // would not resist shear.
        for (dx, dy, dz) in [
            (1, 0, 0),
            (0, 1, 0),
            (0, 0, 1),
            (1, 1, 0),
            (1, 0, 1),
            (0, 1, 1),
        ] {
            if x + dx < n && y + dy < n && z + dz < n {
                let steps = (dx + dy + dz) as f32;
                links.push(LinkRecord {
                    a: index(x, y, z),
                    b: index(x + dx, y + dy, z + dz),
                    rest_length_m: step_m * steps.sqrt(),
                    compliance_m_n: 0.01,
                });
            }
        }
    }
    let organ = OrganRecord {
        name: name_from_str("block"),
        kind: OrganKind::Liver as u32,
        spheres: [0, spheres.len() as u32],
        links: [0, links.len() as u32],
        elastic_links: links.len() as u32,
        substeps: 1,
        vertices: [0, 0],
        triangles: [0, 0],
        tetrahedra: [0, 0],
        gravity_share: 1.0,
        breath_m: [0.0; 3],
        volume_m3: 0.0005,
        material: MaterialRecord {
            density_kg_m3: 1060.0,
            young_pa: 5000.0,
            poisson: 0.45,
            stretch_stiffness: 0.5,
            laplacian_stiffness: 0.1,
            damping_per_s: 2.0,
            contact_stiffness_n_m: 200.0,
            retardation_s: 0.002,
            friction: 0.1,
            toughness_j_m2: 100.0,
        },
    };
    let lifted = |z| PoseMsg {
        position_m: [0.0, 0.0, z],
        ..PoseMsg::IDENTITY
    };
    SceneData {
        room: Some(RoomRecord {
            name: name_from_str(if n == 5 { "block" } else { "coarse block" }),
            gravity_m_s2: [0.0, 0.0, -9.81],
            world_from_device: lifted(0.2),
            world_from_tracker: PoseMsg {
                position_m: [-0.3, 0.0, 0.4],
                ..PoseMsg::IDENTITY
            },
            instrument_port_m: [0.0, 0.0, 0.05],
            instrument_length_m: 0.3,
            endoscope_port_m: [0.05, 0.0, 0.05],
            world_from_camera: lifted(0.05),
            target_m: [0.0, 0.0, -0.05],
            target_normal: [0.0, 0.0, 1.0],
            target_organ: 0,
            breath_s: 0.0,
        }),
        organs: vec![organ],
        spheres,
        links,
        vertices: Vec::new(),
        triangles: Vec::new(),
        tetrahedra: Vec::new(),
        attachments: Vec::new(),
        contact_vertices: Vec::new(),
        contact_fans: Vec::new(),
        contact_nearest: Vec::new(),
        ..SceneData::default()
    }
}
