//! The realtime process with a complete set of emulated devices behind pseudo-terminals.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;
use std::sync::Arc;
use std::thread;

use bytemuck::Zeroable;
use shared_mem::message::{DeviceHealth, TickRecord, ToolFrame};
use shared_mem::words::Switches;

mod support;
use support::{Bench, Emulated, host};

#[test]
fn devices_are_read_force_is_sent_and_an_unplugged_one_is_used_again() {
    let bench = Bench::new();
    let devices = Emulated::start(&bench);
    let config = devices.config(&bench);
    let host = host(&bench);
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let controller = thread::spawn(move || rt_process::run(&config, &flag, |_| ()));

    // Live: the hand starts to move with the first force that reaches the device.
    let mut records: Vec<TickRecord> = Vec::new();
    let mut tools = ToolFrame::zeroed();
    let (mut lowest, mut highest) = ([f32::MAX; 3], [f32::MIN; 3]);
    let mut all_live = false;
    for _ in 0..12_000 {
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
    assert!(fresh > 100, "{fresh} of {} ticks", records.len());
    // A sample that arrives after a tick has read the devices waits for the next tick. So the
    // sample is no older than the beginning of the tick before.
    let in_next_tick = records.windows(2).filter(|pair| {
        let begun_ns = |r: &TickRecord| r.scheduled_ns + u64::from(r.wake_latency_ns);
        let ended_ns = begun_ns(&pair[1]) + u64::from(pair[1].tick_ns);
        let since_ns = ended_ns - begun_ns(&pair[0]);
        (1..=since_ns).contains(&pair[1].motion_to_force_ns.into())
    });
    let in_next_tick = in_next_tick.count();
    assert!(in_next_tick * 2 > fresh, "{in_next_tick} of {fresh}");

    // The device echoes the forces. By its clock, which is this computer's, hand to force takes
    // longer than motion to force: it includes the way over the line and through the device. A tick
    // that is interrupted between writing the force and reading the clock ends after the device got
    // the force. That is rare.
    let echoed: Vec<_> = records.iter().filter(|r| r.echoed_ns > 0).collect();
    assert!(echoed.len() * 4 > fresh, "{} of {fresh}", echoed.len());
    let is_longer = |r: &&&TickRecord| r.hand_to_force_ns + 1000 > r.echoed_ns;
    let longer = echoed.iter().filter(is_longer).count();
    assert!(
        longer * 10 > echoed.len() * 9,
        "{longer} of {}",
        echoed.len()
    );

    // Unplugged: the devices are lost, the force is zero, and the tick goes on.
    devices.unplug();
    for _ in 0..12_000 {
        let fresh = host.newest_tools(&mut tools);
        if fresh && tools.health.iter().all(|h| h.status == DeviceHealth::LOST) {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(tools.health.map(|h| h.status), [DeviceHealth::LOST; 3]);
    assert!(tools.force_n.iter().all(|f| f.abs() < f32::MIN_POSITIVE));
    let heard = tools.health.map(|h| h.frames);

    // Plugged in again: the same run continues with them.
    let devices = Emulated::start(&bench);
    for _ in 0..12_000 {
        let fresh = host.newest_tools(&mut tools);
        if fresh && tools.health.iter().all(|h| h.status == DeviceHealth::LIVE) {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(tools.health.map(|h| h.status), [DeviceHealth::LIVE; 3]);
    for (health, before) in tools.health.iter().zip(heard) {
        assert!(health.frames > before, "counters go on");
    }
    stop.store(true, Relaxed);
    let summary = controller.join().unwrap().unwrap();
    devices.unplug();
    assert!(summary.faults.contains_key("lost_device"), "{summary:?}");
    assert_eq!(summary.allocations_after_start, Some(0));
    if summary.realtime {
        assert_eq!(summary.page_faults_after_start, 0);
    }
}

#[test]
fn a_station_file_names_the_devices_and_where_they_stand() {
    let bench = Bench::new();
    let devices = Emulated::start(&bench);
    let mut config = bench.config();
    config.station_file = Some(devices.station_file(&bench));
    let host = host(&bench);
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let controller = thread::spawn(move || rt_process::run(&config, &flag, |_| ()));
    let mut tools = ToolFrame::zeroed();
    let is_live = |health: &DeviceHealth| health.status == DeviceHealth::LIVE;
    for _ in 0..12_000 {
        if host.newest_tools(&mut tools) && tools.health[..2].iter().all(is_live) {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert!(tools.health[..2].iter().all(is_live), "{:?}", tools.health);
    assert_eq!(tools.health[2].status, DeviceHealth::ABSENT);
    // This station file makes the handle's first button a switch for coagulation, like that of the
    // pedal. The emulated hand presses the button.
    for _ in 0..12_000 {
        host.newest_tools(&mut tools);
        if tools.switches().contains(Switches::COAGULATE) {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(
        (
            tools.switches().bits() & Switches::PEDALS.bits(),
            tools.buttons
        ),
        (Switches::COAGULATE.bits(), 0)
    );
    stop.store(true, Relaxed);
    controller.join().unwrap().unwrap();

    let mut config = bench.config();
    let broken = bench.folder.path().join("broken.toml");
    std::fs::write(&broken, "[haptic]\ndriver = \"telepathy\"\n").unwrap();
    config.station_file = Some(broken);
    let error = rt_process::run(&config, &AtomicBool::new(false), |_| ()).unwrap_err();
    assert!(error.to_string().contains("broken.toml"), "{error}");
    devices.unplug();
}
