//! The realtime process with a whole emulated station of devices behind ptys.
#![allow(clippy::unwrap_used)] // a panic is how a test fails

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};

use bytemuck::Zeroable;
use hardware::emulate::{EmulateConfig, HandScript, LineFaults, Lines};
use rt_core::math::{Pose, Quat, Vec3};
use rt_process::RtConfig;
use shared_mem::message::{DeviceHealth, PoseMsg, TickRecord, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::{Host, Station};

mod support;
use support::Bench;

/// Emulated devices in a thread; they go away when `stop` is set.
struct Emulated {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<()>,
    lines: Lines,
}

impl Emulated {
    fn start(bench: &Bench) -> Self {
        let scene = SceneFile::open(&bench.scene()).unwrap();
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
            faults: LineFaults::default(),
        };
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let (tell, told) = mpsc::channel();
        let thread = thread::spawn(move || {
            hardware::emulate::run(&config, &flag, &mut |lines| {
                tell.send(lines.clone()).unwrap();
            })
            .unwrap();
        });
        let lines = told.recv().unwrap();
        Self {
            stop,
            thread,
            lines,
        }
    }

    fn unplug(self) {
        self.stop.store(true, Relaxed);
        self.thread.join().unwrap();
    }

    fn config(&self, bench: &Bench) -> RtConfig {
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

#[test]
fn devices_are_read_force_is_sent_and_unplugging_is_survived() {
    let bench = Bench::new();
    let devices = Emulated::start(&bench);
    let config = devices.config(&bench);
    let host = Host::open(&Station::new(&bench.station).unwrap()).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let controller = thread::spawn(move || rt_process::run(&config, &flag, |_| ()));

    // Live: the hand begins to move with the first force that reaches the device.
    let mut records: Vec<TickRecord> = Vec::new();
    let mut tools = ToolFrame::zeroed();
    let (mut lowest, mut highest) = ([f32::MAX; 3], [f32::MIN; 3]);
    let mut all_live = false;
    for _ in 0..2000 {
        host.drain_timing(|batch| records.extend(&batch.records[..batch.count as usize]));
        if host.newest_tools(&mut tools) && tools.health[0].status == DeviceHealth::LIVE {
            for (axis, x) in tools.world_from_handle.position_m.into_iter().enumerate() {
                lowest[axis] = lowest[axis].min(x);
                highest[axis] = highest[axis].max(x);
            }
        }
        all_live = tools.health.iter().all(|h| h.status == DeviceHealth::LIVE);
        let moved = highest
            .iter()
            .zip(lowest)
            .any(|(high, low)| high - low > 0.01);
        if (all_live && moved && records.len() > 1000) || controller.is_finished() {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert!(all_live, "{:?}", tools.health);
    assert!(
        highest
            .iter()
            .zip(lowest)
            .any(|(high, low)| high - low > 0.01)
    );
    assert!(tools.health.iter().all(|h| h.frames > 10));
    let fresh = records.iter().filter(|r| r.motion_to_force_ns > 0).count();
    assert!(
        fresh * 4 > records.len(),
        "{fresh} of {} ticks",
        records.len()
    );
    let in_tick = records
        .iter()
        .all(|r| r.motion_to_force_ns <= r.tick_ns.max(1));
    assert!(in_tick, "force leaves within the tick that read the motion");

    // Unplugged: lost, zero force, and the tick goes on.
    devices.unplug();
    for _ in 0..2000 {
        let fresh = host.newest_tools(&mut tools);
        if fresh && tools.health.iter().all(|h| h.status == DeviceHealth::LOST) {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(tools.health.map(|h| h.status), [DeviceHealth::LOST; 3]);
    assert_eq!(tools.force_n, [0.0; 3]);
    stop.store(true, Relaxed);
    let summary = controller.join().unwrap().unwrap();
    assert!(summary.faults.contains_key("lost_device"), "{summary:?}");
    assert_eq!(summary.allocations_after_start, Some(0));
    if summary.realtime {
        assert_eq!(summary.page_faults_after_start, 0);
    }
}
