//! Driver of an Inverse3 behind its service.

use std::io::ErrorKind;
use std::net::{Shutdown, SocketAddr, TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rt_core::math::{Pose, Quat, Vec3};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, Findings, ForceCommand, Freedom, HapticDevice,
    LineCounters, Opening, Polled,
};
use rt_core::time::TimeNs;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message as Frame, WebSocket};

use super::stream::TimedStream;
use super::wire::{ForceKey, Message, Sample, command};
use crate::HardwareError;
use crate::line::now_ns;
use crate::motion::Motion;
use crate::slot::Slot;

/// Port of the service for the messages of this driver.
const PORT: u16 = 10_001;
/// Longest handshake; a running service answers at once.
const HANDSHAKE: Duration = Duration::from_secs(2);
/// Silence of the service after which the driver commands zero force.
const ZERO_AFTER: Duration = Duration::from_millis(30);
/// Silence after which the service counts as lost.
const ANSWER: Duration = Duration::from_millis(100);
/// Longest time for reading a backlog up to its newest message.
const CATCH_UP: Duration = Duration::from_millis(20);
/// Time limit for the thread's last command, after which the socket is closed.
const LAST_COMMAND_LIMIT: Duration = Duration::from_millis(50);
/// Interval between two commands.
const PERIOD: Duration = Duration::from_millis(1);
/// Age of a force above which the thread commands zero force, ns. The thread goes on when the tick
/// hangs.
const WATCHDOG_NS: u64 = 50_000_000;
/// Longest message, bytes.
const MESSAGE_BYTES: usize = 1 << 20;
/// Farthest plausible position from the middle, in workspace radii.
const REACH: f32 = 3.0;

/// Capabilities of an Inverse3. The maker states a peak of 10 N; this driver uses half of it. The
/// continuous force is not published.
const CAPABILITIES: DeviceCapabilities = DeviceCapabilities {
    opening: Opening::NONE,
    force_max_n: 5.0,
    force_continuous_n: 1.0,
    torque_max_nm: 0.0,
    stiffness_max_n_m: 800.0,
    damping_max_n_s_m: 5.0,
    damping_n_s_m: 0.5,
    delay_s: 0.003,
    workspace_radius_m: 0.12,
    rate_hz: 1000.0,
};

/// An open Inverse3, and the thread that exchanges messages with its service.
#[derive(Debug)]
pub struct Inverse3Haptic {
    path: PathBuf,
    shared: Arc<Shared>,
    /// Second handle of the socket, with which `drop` closes it while the thread waits for data.
    socket: TcpStream,
    thread: Option<JoinHandle<()>>,
    last_version: u32,
    motion: Motion,
    counters: LineCounters,
}

/// State shared by the thread and the tick.
#[derive(Debug)]
struct Shared {
    running: AtomicBool,
    is_lost: AtomicBool,
    bad_messages: AtomicU64,
    /// Samples that were skipped because a newer one had arrived.
    skipped: AtomicU64,
    /// Position (3), quaternion x y z w (4), velocity (3) as bits of f32; buttons; count; time as
    /// two words.
    sample: Slot<14>,
    /// Force (3) as bits of f32; time as two words.
    force: Slot<5>,
}

impl Inverse3Haptic {
    /// Opens the device with this number (`None`: the first) through the service at `address`, a
    /// host of this computer with or without a port, usually `localhost`. Force is not sent over a
    /// network. Waits up to 2 s, so the tick must not call it.
    pub fn open(address: &Path, device: Option<&str>) -> Result<Self, HardwareError> {
        let service = |what: String| HardwareError::Service {
            path: address.to_path_buf(),
            what,
        };
        let name = address.to_str().unwrap_or_default();
        let mut socket = connect(name).map_err(service)?;
        socket.get_mut().limit(HANDSHAKE, HANDSHAKE);
        let inventory = receive(&mut socket)
            .map_err(|error| service(format!("the service does not answer ({error})")))?
            .and_then(|text| Message::parse(&text))
            .ok_or_else(|| service("another program answers, not the Haply service".into()))?;
        let id = inventory
            .device_id(device)
            .ok_or_else(|| service("the service has no such Inverse3".into()))?
            .to_owned();
        if inventory.is_uncalibrated(&id) {
            return Err(HardwareError::Calibration {
                path: address.to_path_buf(),
                remedy: "Rest the handle in its inkwell until the light is steady",
            });
        }
        let closing_handle = socket
            .get_ref()
            .try_clone()
            .map_err(|error| service(error.to_string()))?;
        let shared = Arc::new(Shared {
            running: AtomicBool::new(true),
            is_lost: AtomicBool::new(false),
            bad_messages: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
            sample: Slot::new(),
            force: Slot::new(),
        });
        let key = inventory.force_key();
        let with = Arc::clone(&shared);
        let thread = thread::Builder::new()
            .name("calot-inverse3".to_owned())
            .stack_size(512 << 10)
            .spawn(move || {
                let lost = LostAtEnd(&with);
                let _ = exchange(&mut socket, &id, key, &with);
                drop(lost);
                // Send a last command, if the service is still there.
                socket
                    .get_mut()
                    .limit(LAST_COMMAND_LIMIT, LAST_COMMAND_LIMIT);
                let _ = socket.send(Frame::text(command(&id, key, Vec3::zeros())));
                let _ = socket.close(None);
                let _ = socket.flush();
                socket.get_ref().hang_up();
            })
            .map_err(|error| service(error.to_string()))?;
        Ok(Self {
            path: address.to_path_buf(),
            shared,
            socket: closing_handle,
            thread: Some(thread),
            last_version: 0,
            motion: Motion::default(),
            counters: LineCounters::default(),
        })
    }

    /// Address of the service.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True if the service is lost; see [`crate::rig::RigHaptic::is_lost`].
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.shared.is_lost.load(Ordering::Acquire)
    }
}

/// Connects to a service on this computer.
fn connect(name: &str) -> Result<WebSocket<TimedStream>, String> {
    let name = name.strip_prefix("ws://").unwrap_or(name);
    let with_port = match name.contains(':') {
        true => name.to_owned(),
        false => format!("{name}:{PORT}"),
    };
    let addresses: Vec<SocketAddr> = with_port
        .to_socket_addrs()
        .map_err(|error| format!("{with_port} is no address: {error}"))?
        .collect();
    if addresses.iter().any(|address| !address.ip().is_loopback()) {
        return Err("the service must be on this computer: name localhost".into());
    }
    let stream = addresses
        .iter()
        .find_map(|address| TcpStream::connect_timeout(address, HANDSHAKE).ok())
        .ok_or("nobody listens there")?;
    let mut stream = TimedStream::new(stream).map_err(|error| error.to_string())?;
    stream.limit(HANDSHAKE, HANDSHAKE);
    let config = WebSocketConfig::default()
        .read_buffer_size(64 << 10)
        .write_buffer_size(0)
        .max_message_size(Some(MESSAGE_BYTES))
        .max_frame_size(Some(MESSAGE_BYTES));
    let request = format!("ws://{with_port}/");
    tungstenite::client::client_with_config(request, stream, Some(config))
        .map(|(socket, _)| socket)
        .map_err(|error| format!("no WebSocket service listens there: {error}"))
}

/// Next text message; `None` if it is binary. Fails at the socket's time limit.
fn receive(socket: &mut WebSocket<TimedStream>) -> Result<Option<String>, Error> {
    loop {
        match socket.read()? {
            Frame::Text(text) => return Ok(Some(text.as_str().to_owned())),
            Frame::Binary(_) => return Ok(None),
            _ => {}
        }
    }
}

/// True if the error only means that nothing arrived in time.
fn is_late(error: &Error) -> bool {
    matches!(error, Error::Io(error)
        if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut))
}

/// Newest of all texts that have arrived. Waits for the first one, and sends `zero_command` if that
/// takes longer than [`ZERO_AFTER`]. A service may send more than one answer per command, so
/// reading one text per command would fall ever further behind. `None` if the newest message is not
/// text, or if the backlog has no end.
fn newest(
    socket: &mut WebSocket<TimedStream>,
    zero_command: impl Fn() -> Frame,
    shared: &Shared,
) -> Result<Option<String>, Error> {
    socket.get_mut().limit(ZERO_AFTER, ZERO_AFTER);
    let first = match receive(socket) {
        Err(error) if is_late(&error) => {
            socket
                .get_mut()
                .limit(ANSWER - ZERO_AFTER, ANSWER - ZERO_AFTER);
            socket.send(zero_command())?;
            receive(socket)?
        }
        heard => heard?,
    };
    let mut newest = first;
    socket.get_mut().limit(Duration::ZERO, CATCH_UP);
    loop {
        match receive(socket) {
            Ok(later) => {
                newest = later;
                shared.skipped.fetch_add(1, Ordering::Relaxed);
            }
            Err(Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => return Ok(newest),
            // The backlog has no end, so no message is known to be the newest.
            Err(error) if is_late(&error) => return Ok(None),
            Err(error) => return Err(error),
        }
    }
}

/// Reports the end of the thread to the tick, however it ends.
struct LostAtEnd<'a>(&'a Shared);

impl Drop for LostAtEnd<'_> {
    fn drop(&mut self) {
        self.0.is_lost.store(true, Ordering::Release);
    }
}

/// Sends commands and reads states until the driver or the service ends.
fn exchange(
    socket: &mut WebSocket<TimedStream>,
    id: &str,
    key: ForceKey,
    shared: &Shared,
) -> Result<(), Error> {
    let mut due = Instant::now();
    let mut count = 0u32;
    while shared.running.load(Ordering::Acquire) {
        if let Some(early) = due.checked_duration_since(Instant::now()) {
            thread::sleep(early);
        }
        // Missed periods are skipped.
        due = (due + PERIOD).max(Instant::now());
        socket.get_mut().limit(Duration::ZERO, ZERO_AFTER);
        socket.send(Frame::text(command(id, key, shared.wanted_force_n())))?;
        let zero_command = || Frame::text(command(id, key, Vec3::zeros()));
        let text = newest(socket, zero_command, shared)?;
        let sample = text
            .and_then(|text| Message::parse(&text))
            .and_then(|message| message.sample(id))
            .filter(|sample| sample.position_m.norm() <= CAPABILITIES.workspace_radius_m * REACH);
        match sample {
            Some(sample) => {
                count = count.wrapping_add(1);
                shared.sample.write(words(&sample, count, now_ns()));
            }
            None => {
                shared.bad_messages.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
    Ok(())
}

impl Shared {
    /// Newest force, clamped to the device's peak. Zero if it is older than the watchdog's limit.
    fn wanted_force_n(&self) -> Vec3 {
        let Some((_, [x, y, z, low, high])) = self.force.read() else {
            return Vec3::zeros();
        };
        let sent_ns = u64::from(low) | u64::from(high) << 32;
        let force_n = Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z));
        let norm = force_n.norm();
        if now_ns().saturating_sub(sent_ns) > WATCHDOG_NS || !norm.is_finite() {
            return Vec3::zeros();
        }
        force_n * (CAPABILITIES.force_max_n / norm.max(CAPABILITIES.force_max_n))
    }
}

fn words(sample: &Sample, count: u32, at_ns: TimeNs) -> [u32; 14] {
    let [x, y, z] = <[f32; 3]>::from(sample.position_m).map(f32::to_bits);
    let [vx, vy, vz] = <[f32; 3]>::from(sample.velocity_m_s).map(f32::to_bits);
    let q = sample.rotation;
    let [qx, qy, qz, qw] = [q.i, q.j, q.k, q.w].map(f32::to_bits);
    let (low, high) = (at_ns as u32, (at_ns >> 32) as u32);
    let buttons = sample.buttons.into();
    [
        x, y, z, qx, qy, qz, qw, vx, vy, vz, buttons, count, low, high,
    ]
}

impl HapticDevice for Inverse3Haptic {
    fn capabilities(&self) -> DeviceCapabilities {
        CAPABILITIES
    }

    /// A grip measures the rotation. It is not always connected.
    fn freedom(&self) -> Freedom {
        Freedom {
            measured: 6,
            rendered: 3,
        }
    }

    fn poll(&mut self, _now_ns: TimeNs) -> Polled<DeviceSample> {
        self.motion.begin();
        if self.is_lost() {
            return Polled::Lost;
        }
        let Some((version, words)) = self.shared.sample.read() else {
            return Polled::Nothing;
        };
        if version == self.last_version {
            return Polled::Nothing;
        }
        // A sample replaced before the tick polled it is not lost on the line.
        self.last_version = version;
        self.counters.frames += 1;
        let [x, y, z, qx, qy, qz, qw, vx, vy, vz, ..] = words.map(f32::from_bits);
        let [.., buttons, count, low, high] = words;
        let at_ns = u64::from(low) | u64::from(high) << 32;
        let (at_m, reported_m_s) = (Vec3::new(x, y, z), Vec3::new(vx, vy, vz));
        let Some(velocity_m_s) = self.motion.take(at_m, reported_m_s, at_ns) else {
            return Polled::Nothing;
        };
        let rotation = Quat::new_unchecked(nalgebra::Quaternion::new(qw, qx, qy, qz));
        Polled::Fresh(DeviceSample {
            opening: None,
            device_from_handle: Pose::from_parts(at_m.into(), rotation),
            velocity_m_s: Some(velocity_m_s),
            buttons: Buttons(buttons as u8),
            sequence: count as u16,
            at_ns,
        })
    }

    fn findings(&self) -> Findings {
        self.motion.findings()
    }

    fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        let [x, y, z] = <[f32; 3]>::from(command.force_n).map(f32::to_bits);
        self.shared
            .force
            .write([x, y, z, now_ns as u32, (now_ns >> 32) as u32]);
    }

    fn counters(&self) -> LineCounters {
        LineCounters {
            bad_frames: self.shared.bad_messages.load(Ordering::Relaxed) + self.motion.leaps(),
            lost_frames: self.shared.skipped.load(Ordering::Relaxed),
            ..self.counters
        }
    }
}

impl Drop for Inverse3Haptic {
    /// Ends the thread, whose last command has zero force. The thread ends soon, because each of
    /// its waits has a limit or is cut off.
    fn drop(&mut self) {
        self.shared.running.store(false, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let start = Instant::now();
            while !thread.is_finished() && start.elapsed() < LAST_COMMAND_LIMIT {
                thread::sleep(PERIOD);
            }
            let _ = self.socket.shutdown(Shutdown::Both);
            let _ = thread.join();
        }
    }
}
