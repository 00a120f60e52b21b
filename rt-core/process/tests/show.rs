//! Tests seeking in a session that displays watch: at every moment exactly the right places leak.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;
use std::collections::BTreeMap;
use std::time::Instant;

use bytemuck::Zeroable as _;
use rt_core::math::Vec3;
use rt_core::tool::Kinematics;
use rt_process::replay::{Pace, Replay, show};
use shared_mem::inputs::{InputRecord, RunSetup};
use shared_mem::message::{CommandMsg, EventMsg, PoseMsg, ReplyMsg, StateFrame};
use shared_mem::scene::{
    AttachmentRecord, LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord, SceneData,
    SceneFile, SphereRecord, WORLD, name_from_str,
};
use shared_mem::service::{Host, Station};
use shared_mem::words::EventKind;

/// Longest wait of a test.
const PATIENCE: Duration = Duration::from_secs(300);
const PORT_M: [f32; 3] = [0.0, 0.0, 0.18];
const LENGTH_M: f32 = 0.33;
/// Handle button that closes the jaws.
const GRASP: u8 = rt_core::port::Buttons::GRASP.0;
const SCISSORS: u8 = 2;

/// An artery along x, 2.4 mm wide, held at its left end and tied at its right.
fn artery() -> SceneFile {
    let at = |i: u32| [0.003 * (i as f32 - 10.0), 0.0, 0.0];
    let (young_pa, area_m2) = (2.0e5, 4.5e-6);
    let organ = OrganRecord {
        name: name_from_str("artery"),
        kind: OrganKind::CysticArtery as u32,
        spheres: [0, 21],
        links: [0, 20],
        elastic_links: 20,
        substeps: 1,
        gravity_share: 0.0,
        volume_m3: 1e-6,
        material: MaterialRecord {
            density_kg_m3: 1060.0,
            young_pa,
            poisson: 0.45,
            retardation_s: 0.002,
            stretch_stiffness: 0.02,
            laplacian_stiffness: 0.005,
            damping_per_s: 60.0,
            contact_stiffness_n_m: 400.0,
            friction: 0.1,
            toughness_j_m2: 0.0,
        },
        ..OrganRecord::zeroed()
    };
    let data = SceneData {
        room: Some(RoomRecord {
            name: name_from_str("artery"),
            gravity_m_s2: [0.0, 0.0, -9.81],
            world_from_device: PoseMsg::IDENTITY,
            world_from_tracker: PoseMsg::IDENTITY,
            world_from_camera: PoseMsg::IDENTITY,
            instrument_port_m: PORT_M,
            instrument_length_m: LENGTH_M,
            endoscope_port_m: [0.05, 0.0, 0.18],
            target_normal: [0.0, 0.0, 1.0],
            ..RoomRecord::zeroed()
        }),
        organs: vec![organ],
        spheres: (0..21)
            .map(|i| SphereRecord {
                center_m: at(i),
                radius_m: 0.001_2,
                mass_kg: 0.001,
                held: u32::from(i == 0),
            })
            .collect(),
        links: (0..20)
            .map(|a| LinkRecord {
                a,
                b: a + 1,
                rest_length_m: 0.002_97,
                compliance_m_n: 0.003 / (young_pa * area_m2),
            })
            .collect(),
        attachments: vec![AttachmentRecord {
            a: 20,
            b: WORLD,
            anchor_m: at(20),
            compliance_m_n: 1.0e-4,
            ..AttachmentRecord::zeroed()
        }],
        ..SceneData::default()
    };
    SceneFile::from_bytes(&data.to_bytes().expect("a scene")).expect("a scene")
}

fn setup(scene: &SceneFile) -> RunSetup {
    RunSetup {
        scene_id: scene.short_id(),
        period_ns: 1_000_000,
        world_from_device: PoseMsg::IDENTITY,
        world_from_tracker: PoseMsg::IDENTITY,
        instrument_port_m: PORT_M,
        endoscope_port_m: [0.05, 0.0, 0.18],
        device: [3.3, 0.88, 0.0, 1000.0, 5.0, 1.8, 0.001, 0.2, 1000.0],
        force_ramp_s: 0.01,
        force_enabled: 1,
        ..RunSetup::zeroed()
    }
}

/// Inputs of a hand that cuts the artery far from its source, and then nearer to it. Then
/// everything is reset.
fn session() -> Vec<InputRecord> {
    let kinematics = Kinematics {
        port_m: Vec3::from(PORT_M),
        length_m: LENGTH_M,
    };
    let mut records: Vec<InputRecord> = Vec::new();
    let mut go = |from: Vec3, to: Vec3, ticks: u32, buttons: u8| {
        for step in 1..=ticks {
            let tip_m = from + (to - from) * (step as f32 / ticks as f32);
            let handle = kinematics.handle_from_tip(&tip_m, &Vec3::new(0.0, 1.0, 0.0));
            let turn = handle.rotation.coords;
            let tick = records.len() as u64;
            let now_ns = (tick + 1) * 1_000_000;
            records.push(InputRecord {
                tick,
                now_ns,
                device_at_ns: now_ns,
                device_from_handle: PoseMsg {
                    position_m: handle.translation.vector.into(),
                    orientation: [turn.x, turn.y, turn.z, turn.w],
                },
                bits: InputRecord::DEVICE_FRESH,
                sequence: tick as u16,
                buttons,
                ..InputRecord::zeroed()
            });
        }
    };
    let away = Vec3::new(0.0, 0.0, 0.15);
    for x_m in [0.0105, -0.0105] {
        let at = Vec3::new(x_m, 0.0, -0.006);
        go(away, at, 800, 0);
        go(at, at, 100, 0);
        go(at, at, 300, GRASP);
        go(at, at, 300, 0);
        go(at, away, 500, 0);
        go(away, away, 300, 0);
    }
    go(away, away, 600, 0);
    records[0].command = CommandMsg::INSTRUMENT as u8 | SCISSORS << 4;
    records[4700].command = CommandMsg::RESET as u8;
    records
}

/// Open leaks by place.
type Open = BTreeMap<[u32; 3], f32>;

/// A display that keeps each leak until an event closes it or, if it `forgets`, until it notices a
/// jump back.
struct Display {
    host: Host,
    state: Box<StateFrame>,
    tick: u64,
    open: Open,
    forgets: bool,
}

impl Display {
    fn join(station: &Station, forgets: bool) -> Self {
        Self {
            host: Host::open(station).expect("a host"),
            state: bytemuck::zeroed_box(),
            tick: 0,
            open: Open::new(),
            forgets,
        }
    }

    fn look(&mut self) {
        if self.host.newest_state(&mut self.state) {
            if self.state.tick < self.tick && self.forgets {
                self.open.clear();
            }
            self.tick = self.state.tick;
        }
    }

    fn hear(&mut self) {
        let open = &mut self.open;
        self.host.drain_events(|event| take(open, event));
    }

    fn ask(&self, kind: u32, argument: u32) {
        let reply = self.host.command(CommandMsg { kind, argument }, PATIENCE);
        assert_eq!(reply.expect("an answer").outcome, ReplyMsg::DONE);
    }
}

fn take(open: &mut Open, event: &EventMsg) {
    if event.is(EventKind::Leak) {
        let place = event.at_m.map(f32::to_bits);
        match event.value > 0.0 {
            true => open.insert(place, event.value),
            false => open.remove(&place),
        };
    }
}

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Ends the show when dropped.
struct AtEnd<'a>(&'a AtomicBool);

impl Drop for AtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

/// Shows the session on a station while `watch` runs. `watch` gets the station, and a function that
/// returns the open leaks at a tick.
fn shown(name: &str, watch: impl FnOnce(&Station, &dyn Fn(u64) -> Open)) {
    let scene = artery();
    let replay = Replay::new(&scene, &setup(&scene)).expect("a scene");
    let records = session();
    let station = Station::new(&format!("show-{}-{name}", std::process::id())).expect("a name");
    let (begun, stop) = (AtomicBool::new(true), AtomicBool::new(false));
    let big = || std::thread::Builder::new().stack_size(16 << 20);
    std::thread::scope(|scope| {
        let told = big().spawn_scoped(scope, || {
            let mut told: Vec<EventMsg> = Vec::new();
            let run = replay.run(records.iter().copied(), |tick| {
                told.extend(tick.events());
                true
            });
            run.expect("a scene");
            told
        });
        let told = told.expect("a thread").join().expect("no panic");
        // Leaks known to a display that has seen everything from the start.
        let open_at = |tick: u64| {
            let mut open = Open::new();
            let past = told.iter().filter(|event| event.tick <= tick);
            past.for_each(|event| take(&mut open, event));
            match tick < 4700 {
                true => open,
                false => Open::new(),
            }
        };
        let counts = [500, 2000, 4500, 4800].map(|tick| open_at(tick).len());
        assert_eq!(counts, [0, 1, 1, 0], "{told:?}");
        assert_ne!(open_at(2000), open_at(4500), "at another place");
        let player = big().spawn_scoped(scope, || {
            let pace = Pace {
                speed: 1.0,
                from_s: 0.0,
            };
            let open = || Some(records.iter().copied());
            show(&replay, &station, pace, &begun, &stop, open, |_| (), |_| ())
        });
        let end = AtEnd(&stop);
        watch(&station, &open_at);
        drop(end);
        let ended = player.expect("a thread").join().expect("no panic");
        ended.expect("it was shown");
    });
}

#[test]
fn leaks_shown_at_any_moment_are_those_of_that_moment() {
    shown("seek", |station, open_at| {
        // One display forgets its leaks on a jump back, as windows do; the other only listens.
        let mut displays = [true, false].map(|forgets| Display::join(station, forgets));
        displays[0].ask(CommandMsg::PAUSE, 1);
        for at_ms in [500, 4500, 2000, 4500, 500, 2000, 4800, 4500, 500] {
            displays[0].ask(CommandMsg::SEEK, at_ms);
            let wanted = open_at(at_ms.into());
            for display in &mut displays {
                wait_until("it stands there", || {
                    display.look();
                    display.hear();
                    display.tick.abs_diff(at_ms.into()) < 10 && display.open == wanted
                });
            }
            // A new display first receives earlier events, even if nothing more is sent.
            std::thread::sleep(Duration::from_millis(200));
            let mut late = Display::join(station, true);
            wait_until("who joins sees the same", || {
                late.look();
                late.hear();
                late.tick.abs_diff(at_ms.into()) < 10 && late.open == wanted
            });
        }
    });
}

#[test]
fn display_that_hears_of_leaks_before_the_jump_back_hears_again() {
    shown("again", |station, open_at| {
        let mut display = Display::join(station, true);
        display.ask(CommandMsg::PAUSE, 1);
        let mut told = 0;
        // On a busy machine both may arrive together; then try again.
        while told != 1 {
            display.ask(CommandMsg::SEEK, 4500);
            wait_until("it is there", || {
                display.look();
                display.hear();
                display.tick > 4400 && display.open == open_at(4500)
            });
            display.ask(CommandMsg::SEEK, 2000);
            told = 0;
            let open = &mut display.open;
            wait_until("the events are there", || {
                display.host.drain_events(|event| {
                    take(open, event);
                    told += u32::from(event.is(EventKind::Leak) && event.value > 0.0);
                });
                *open == open_at(2000)
            });
        }
        wait_until("and then the state", || {
            display.look();
            display.tick < 2100
        });
        assert!(display.open.is_empty(), "the display forgot");
        wait_until("it hears again", || {
            display.hear();
            display.open == open_at(2000)
        });
    });
}

#[test]
fn organ_put_back_to_rest_while_shown_leaks_no_more() {
    shown("rest", |station, open_at| {
        let mut display = Display::join(station, true);
        display.ask(CommandMsg::SEEK, 4500);
        wait_until("it bleeds", || {
            display.look();
            display.hear();
            display.open == open_at(4500)
        });
        wait_until("it does not", || {
            display.look();
            display.hear();
            display.tick > 4700 && display.open.is_empty()
        });
    });
}
