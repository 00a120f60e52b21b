//! Support of the tests: a station whose one organ is not simulated, watchers, proxies and keys.
#![allow(dead_code)] // each test file uses its part

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use link::wire::{Ask, LOOK};
use link::{Address, Keys, Seen, WatchConfig, Watched, serve, watch};
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use shared_mem::message::{
    EventMsg, MAX_CELLS, MAX_SPHERES, PoseMsg, StateFrame, TimingBatch, ToolFrame,
};
use shared_mem::scene::{
    LinkRecord, MaterialRecord, OrganKind, OrganRecord, RoomRecord, SceneData, SceneFile,
    SphereRecord, VertexRecord, name_from_str,
};
use shared_mem::service::{Controller, Host, Station};
use shared_mem::words::EventKind;

/// Longest wait of a test.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Sets the flag when dropped, so that other threads stop waiting.
pub(crate) struct AtEnd<'a>(pub(crate) &'a AtomicBool);

impl Drop for AtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

pub(crate) fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub(crate) fn scene() -> SceneFile {
    scene_of(3)
}

/// A scene with this number of vertices, which sets its size.
pub(crate) fn scene_of(vertices: u32) -> SceneFile {
    let sphere = |x: f32| SphereRecord {
        center_m: [x, 0.0, 0.0],
        radius_m: 0.01,
        mass_kg: 0.01,
        held: 0,
    };
    let vertex = |x: f32| VertexRecord {
        position_m: [x, 0.01, 0.0],
        normal: [0.0, 1.0, 0.0],
        spheres: [0; 8],
        weights: [65_535, 0, 0, 0, 0, 0, 0, 0],
    };
    let room = RoomRecord {
        name: name_from_str("two spheres"),
        world_from_device: PoseMsg::IDENTITY,
        world_from_tracker: PoseMsg::IDENTITY,
        world_from_camera: PoseMsg::IDENTITY,
        instrument_length_m: 0.33,
        ..RoomRecord::zeroed()
    };
    let organ = OrganRecord {
        name: name_from_str("liver"),
        kind: OrganKind::Liver as u32,
        spheres: [0, 2],
        links: [0, 1],
        elastic_links: 1,
        substeps: 1,
        gravity_share: 1.0,
        vertices: [0, vertices],
        triangles: [0, 1],
        volume_m3: 1e-5,
        material: MaterialRecord {
            density_kg_m3: 1060.0,
            young_pa: 5000.0,
            poisson: 0.45,
            contact_stiffness_n_m: 200.0,
            toughness_j_m2: 100.0,
            ..MaterialRecord::zeroed()
        },
        ..OrganRecord::zeroed()
    };
    let data = SceneData {
        room: Some(room),
        organs: vec![organ],
        spheres: vec![sphere(0.0), sphere(0.01)],
        links: vec![LinkRecord {
            a: 0,
            b: 1,
            rest_length_m: 0.01,
            compliance_m_n: 1e-3,
        }],
        vertices: (0..vertices)
            .map(|i| vertex(0.01 * i as f32 / 3.0))
            .collect(),
        triangles: vec![[0, 1, 2]],
        ..SceneData::default()
    };
    SceneFile::from_bytes(&data.to_bytes().expect("a scene")).expect("a scene")
}

pub(crate) fn state(tick: u64, at_ns: u64, scene_id: [u8; 16]) -> Box<StateFrame> {
    let mut frame: Box<StateFrame> = bytemuck::zeroed_box();
    (frame.tick, frame.at_ns, frame.sample_ns) = (tick, at_ns, at_ns - 100);
    frame.scene_id = scene_id;
    frame.sphere_count = 2;
    frame.cell_count = 3;
    frame.cells[..3].copy_from_slice(&[1, 2, 255]);
    frame.link_count = 11;
    frame.parted[..2].copy_from_slice(&[0b1000_0001, 0b100]);
    frame.spheres[1].center_m = [tick as f32 * 1e-6, 0.5, 0.25];
    frame
}

pub(crate) fn tools(tick: u64, at_ns: u64, scene_id: [u8; 16]) -> ToolFrame {
    let mut frame = ToolFrame::zeroed();
    (frame.tick, frame.at_ns, frame.scene_id) = (tick, at_ns, scene_id);
    frame.world_from_handle = PoseMsg::IDENTITY;
    frame.world_from_instrument = PoseMsg::IDENTITY;
    frame.world_from_camera = PoseMsg::IDENTITY;
    frame.capsule_count = 1;
    frame
}

pub(crate) fn event(sequence: u64) -> EventMsg {
    EventMsg {
        sequence,
        at_ns: 1_000_000 + sequence,
        kind: EventKind::Contact.number(),
        ..EventMsg::zeroed()
    }
}

pub(crate) fn batch(sequence: u64) -> TimingBatch {
    let mut batch = TimingBatch::zeroed();
    (batch.sequence, batch.count) = (sequence, 5);
    batch.records[4].tick = sequence * 5 + 4;
    batch
}

/// Runs the script that `calot link keys` prints.
pub(crate) fn make_keys(folder: &Path, words: &[&str]) {
    let script = folder.join("make_keys.sh");
    std::fs::write(&script, link::MAKE_KEYS).expect("written");
    let made = Command::new("sh")
        .arg(&script)
        .args(words)
        .current_dir(folder)
        .output()
        .expect("sh runs");
    let said = String::from_utf8_lossy(&made.stderr);
    assert!(
        made.status.success(),
        "{words:?} (openssl 3 is needed): {said}"
    );
}

/// The keys of `name` in a folder.
pub(crate) fn keys(folder: &Path, name: &str) -> Keys {
    let path = |file: String| -> PathBuf { folder.join(file) };
    Keys {
        certificate: path(format!("{name}.pem")),
        key: path(format!("{name}.key")),
        authority: path("ca.pem".into()),
    }
}

pub(crate) fn station(name: &str) -> Station {
    Station::new(&format!("l{}-{name}", std::process::id())).expect("a plain name")
}

/// A free port.
pub(crate) fn port() -> u16 {
    let free = TcpListener::bind("127.0.0.1:0").expect("a port");
    free.local_addr().expect("a port").port()
}

/// A station (theatre) and a watcher (desk) with keys of one authority.
pub(crate) struct Proven {
    pub(crate) theatre: Keys,
    pub(crate) desk: Keys,
    /// Address at which the theatre listens.
    pub(crate) listen: String,
    /// Address and keys with which the desk connects.
    pub(crate) address: Address,
}

impl Proven {
    /// Makes the keys in `folder`.
    pub(crate) fn in_folder(folder: &Path) -> Self {
        make_keys(folder, &["authority"]);
        make_keys(folder, &["station", "theatre", "IP:127.0.0.1"]);
        make_keys(folder, &["watcher", "desk"]);
        let listen = format!("127.0.0.1:{}", port());
        let desk = keys(folder, "desk");
        Self {
            theatre: keys(folder, "theatre"),
            address: Address::new(&listen, Some(desk.clone()), false).expect("keys"),
            desk,
            listen,
        }
    }
}

/// The listening end of a proxy to which a watcher connects without keys, and its address.
pub(crate) fn halfway() -> (TcpListener, Address) {
    let between = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = between.local_addr().expect("a port").to_string();
    (
        between,
        Address::new(&address, None, true).expect("this computer"),
    )
}

pub(crate) fn now_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Runs a station whose state changes, and its `serve`, while `watcher` runs.
pub(crate) fn beside_a_station<T>(
    name: &str,
    listen: (&str, Option<Keys>),
    place: &Path,
    watcher: impl FnOnce(&AtomicU64) -> T,
) -> T {
    beside(name, listen, place, (&scene(), state), watcher)
}

/// State of a station for a tick, a time and a scene.
pub(crate) type Shows = fn(u64, u64, [u8; 16]) -> Box<StateFrame>;

/// Like [`beside_a_station`], with a given scene and given states.
pub(crate) fn beside<T>(
    name: &str,
    (listen, keys): (&str, Option<Keys>),
    place: &Path,
    (scene, state): (&SceneFile, Shows),
    watcher: impl FnOnce(&AtomicU64) -> T,
) -> T {
    let there = station(name);
    std::fs::write(place.join("scene.calot"), scene.bytes()).expect("written");
    let insecure = keys.is_none();
    let address = Address::new(listen, keys, insecure).expect("an address");
    let (stop, ready) = (AtomicBool::new(false), AtomicBool::new(false));
    let ticks = AtomicU64::new(0);
    let places = [place.to_owned()];
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let controller = Controller::open(&there).expect("nobody else has it");
            for tick in 1.. {
                if stop.load(Relaxed) {
                    break;
                }
                let at = now_ns();
                let _ = controller
                    .state
                    .send_copy(*state(tick, at, scene.short_id()));
                let _ = controller
                    .tools
                    .send_copy(tools(tick, at, scene.short_id()));
                let _ = controller.events.send_copy(event(tick));
                let _ = controller.timing.send_copy(batch(tick));
                ticks.store(tick, Relaxed);
                std::thread::sleep(Duration::from_millis(4));
            }
        });
        let server = scope.spawn(|| {
            serve(&there, &address, &places, None, &stop, || {
                ready.store(true, Relaxed);
            })
        });
        wait_until("it listens", || ready.load(Relaxed) || server.is_finished());
        let end = AtEnd(&stop);
        let result = watcher(&ticks);
        drop(end);
        let served = server.join().expect("no panic").expect("it served");
        assert_eq!(served.malformed, 0);
        result
    })
}

/// Watches until `enough` returns. `enough` gets the station and a list of all that was seen.
pub(crate) fn watched(
    name: &str,
    address: &Address,
    scene: PathBuf,
    enough: impl FnOnce(&Station, &Mutex<Vec<String>>),
) -> Watched {
    let here = station(name);
    let config = WatchConfig {
        station: here.clone(),
        address: address.clone(),
        rate_hz: 60.0,
        scene,
        seconds: None,
    };
    let (stop, seen) = (AtomicBool::new(false), Mutex::new(Vec::new()));
    let note = |it: Seen<'_>| seen.lock().expect("no panic").push(format!("{it:?}"));
    std::thread::scope(|scope| {
        let watcher = scope.spawn(|| watch(&config, &stop, note));
        let end = AtEnd(&stop);
        enough(&here, &seen);
        drop(end);
        watcher.join().expect("no panic").expect("it watched")
    })
}

/// The largest state.
pub(crate) fn full_state(tick: u64, at_ns: u64, scene_id: [u8; 16]) -> Box<StateFrame> {
    let mut frame = state(tick, at_ns, scene_id);
    (frame.sphere_count, frame.cell_count) = (MAX_SPHERES as u32, MAX_CELLS as u32);
    frame
}

/// A display of this computer: the newest tick, and the numbers of all events.
pub(crate) struct Display {
    host: Host,
    state: Box<StateFrame>,
    pub(crate) events: Vec<u64>,
}

impl Display {
    pub(crate) fn of(station: &Station) -> Self {
        Self {
            host: Host::open(station).expect("a host"),
            state: bytemuck::zeroed_box(),
            events: Vec::new(),
        }
    }

    /// Waits for `states` more states.
    pub(crate) fn see(&mut self, states: u32) {
        let mut seen = 0;
        wait_until("states come", || {
            seen += u32::from(self.host.newest_state(&mut self.state));
            let events = &mut self.events;
            self.host.drain_events(|event| events.push(event.sequence));
            seen >= states
        });
    }
}

/// The bytes of a question for all data, from a watcher that has none.
pub(crate) fn question() -> Vec<u8> {
    let ask = Ask {
        magic: link::wire::MAGIC,
        ..Ask::zeroed()
    };
    let mut bytes = (size_of::<Ask>() as u32).to_le_bytes().to_vec();
    bytes.push(LOOK);
    bytes.extend(bytemuck::bytes_of(&ask));
    bytes
}

/// Reads the kind and content of a message.
pub(crate) fn message(line: &mut impl Read) -> std::io::Result<(u8, Vec<u8>)> {
    let mut head = [0; 5];
    line.read_exact(&mut head)?;
    let [a, b, c, d, kind] = head;
    let mut content = vec![0; u32::from_le_bytes([a, b, c, d]) as usize];
    line.read_exact(&mut content)?;
    Ok((kind, content))
}

/// A TLS connection without the link's protocol.
pub(crate) fn tls(
    listen: &str,
    keys: &Keys,
) -> rustls::StreamOwned<rustls::ClientConnection, TcpStream> {
    let mut roots = rustls::RootCertStore::empty();
    for authority in CertificateDer::pem_file_iter(&keys.authority).expect("keys") {
        roots.add(authority.expect("keys")).expect("keys");
    }
    let own = CertificateDer::pem_file_iter(&keys.certificate).expect("keys");
    let own = own.collect::<Result<Vec<_>, _>>().expect("keys");
    let key = PrivateKeyDer::from_pem_file(&keys.key).expect("keys");
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = rustls::ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .expect("versions")
        .with_root_certificates(roots)
        .with_client_auth_cert(own, key)
        .expect("keys");
    let name = "127.0.0.1".try_into().expect("a name");
    let tls = rustls::ClientConnection::new(Arc::new(config), name).expect("a connection");
    rustls::StreamOwned::new(tls, TcpStream::connect(listen).expect("it listens"))
}

/// A proxy between watcher and station, without TLS. `passes` receives the number of the connection
/// and each question; `false` breaks the line. Ends when `over` is set.
pub(crate) fn way(
    listener: &TcpListener,
    to: &str,
    over: &AtomicBool,
    passes: impl Fn(usize, u8, &[u8]) -> bool + Sync,
) {
    listener.set_nonblocking(true).expect("set");
    std::thread::scope(|scope| {
        let mut connection = 0;
        while !over.load(Relaxed) {
            let Ok((mut near, _)) = listener.accept() else {
                std::thread::sleep(Duration::from_millis(2));
                continue;
            };
            near.set_nonblocking(false).expect("set");
            let mut far = TcpStream::connect(to).expect("it listens");
            let mut back = (
                far.try_clone().expect("a copy"),
                near.try_clone().expect("a copy"),
            );
            scope.spawn(move || {
                let _ = std::io::copy(&mut back.0, &mut back.1);
                let _ = back.1.shutdown(Shutdown::Both);
            });
            let (number, passes) = (connection, &passes);
            connection += 1;
            scope.spawn(move || {
                while let Ok((kind, content)) = message(&mut near) {
                    let mut bytes = (content.len() as u32).to_le_bytes().to_vec();
                    bytes.push(kind);
                    bytes.extend(&content);
                    if !passes(number, kind, &content) || far.write_all(&bytes).is_err() {
                        break;
                    }
                }
                let _ = near.shutdown(Shutdown::Both);
                let _ = far.shutdown(Shutdown::Both);
            });
        }
    });
}
