//! Emulated service of the Inverse3 on a loopback socket, with the device in a resting hand.

use std::io::{self, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rt_core::math::Vec3;
use serde_json::{Value, json};
use tungstenite::{Error, Message as Frame, WebSocket, accept};

use super::touch::{Body, Grip, Touch};

/// Time without a command after which the service drops the force.
const IDLE: Duration = Duration::from_millis(100);
/// Longest time that is simulated at once, ms.
const CATCH_UP_MS: u128 = 50;
/// Interval at which the thread checks for its end.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Body of the device. The values are the maker's where it publishes them.
const BODY: Body = Body {
    mass_kg: 0.1,
    friction_n: 0.1,
    damping_n_s_m: 0.5,
    encoder_step_m: 1e-5,
    workspace_radius_m: 0.12,
    force_max_n: 10.0,
    force_continuous_n: 3.0,
};

/// Faults of the service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ServiceFault {
    /// Works correctly.
    None,
    /// Sends text that is not JSON.
    Garbage,
    /// Sends numbers beyond the range of f32.
    Boundless,
    /// Repeats its last message.
    Stuck,
    /// Sends nothing.
    Silent,
    /// Closes the connection.
    HangUp,
    /// Sends every message five times.
    Flood,
    /// Sends an endless message one byte at a time.
    Drip,
}

const ALL: [ServiceFault; 8] = [
    ServiceFault::None,
    ServiceFault::Garbage,
    ServiceFault::Boundless,
    ServiceFault::Stuck,
    ServiceFault::Silent,
    ServiceFault::HangUp,
    ServiceFault::Flood,
    ServiceFault::Drip,
];
/// Header of a WebSocket text message of a million bytes.
const LONG_TEXT: [u8; 10] = [0x81, 0x7F, 0, 0, 0, 0, 0, 0x0F, 0x42, 0x40];

/// A running service for one client at a time. Dropping it ends the service.
#[derive(Debug)]
pub struct EmulatedInverse3 {
    address: SocketAddr,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    end: AtomicBool,
    fault: AtomicU8,
    device: Mutex<Device>,
}

#[derive(Debug)]
struct Device {
    touch: Touch,
    force_n: Vec3,
    commanded: Instant,
    stepped: Instant,
}

impl Device {
    /// Simulates the device up to the present.
    fn live(&mut self) {
        if self.commanded.elapsed() > IDLE {
            self.force_n = Vec3::zeros();
        }
        let elapsed_ms = self.stepped.elapsed().as_millis().min(CATCH_UP_MS);
        if elapsed_ms > 0 {
            self.stepped = Instant::now();
        }
        for _ in 0..elapsed_ms {
            self.touch.step(Vec3::zeros(), Vec3::zeros(), self.force_n);
        }
    }
}

impl EmulatedInverse3 {
    /// Starts a service on a free port.
    pub fn start() -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let shared = Arc::new(Shared {
            end: AtomicBool::new(false),
            fault: AtomicU8::new(0),
            device: Mutex::new(Device {
                touch: Touch::new(BODY, Grip::STYLUS, Vec3::zeros()),
                force_n: Vec3::zeros(),
                commanded: Instant::now(),
                stepped: Instant::now(),
            }),
        });
        let serving = Arc::clone(&shared);
        let thread = thread::spawn(move || {
            while !serving.end.load(Ordering::Relaxed) {
                match listener.accept() {
                    Ok((stream, _)) => {
                        let _ = serving.serve(stream);
                    }
                    Err(_) => thread::sleep(LOOK_EVERY),
                }
            }
        });
        Ok(Self {
            address,
            shared,
            thread: Some(thread),
        })
    }

    /// Address of the service: open it with [`crate::inverse3::Inverse3Haptic`].
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Force that the device renders now, in Calot's frame, N.
    #[must_use]
    pub fn force_n(&self) -> Vec3 {
        let mut device = self.shared.device();
        device.live();
        device.force_n
    }

    /// Starts this fault.
    pub fn set_fault(&self, how: ServiceFault) {
        self.shared.fault.store(how as u8, Ordering::Relaxed);
    }
}

impl Drop for EmulatedInverse3 {
    fn drop(&mut self) {
        self.shared.end.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn device(&self) -> std::sync::MutexGuard<'_, Device> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn fault(&self) -> ServiceFault {
        let now = self.fault.load(Ordering::Relaxed);
        ALL.into_iter()
            .find(|how| *how as u8 == now)
            .unwrap_or(ServiceFault::None)
    }

    fn serve(&self, stream: TcpStream) -> Result<(), Error> {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(LOOK_EVERY))?;
        let mut socket = accept(stream).map_err(|_| Error::ConnectionClosed)?;
        let mut last = self.state().to_string();
        socket.send(Frame::text(last.clone()))?;
        let mut is_dripping = false;
        while !self.end.load(Ordering::Relaxed) {
            let heard = hear(&mut socket)?;
            if is_dripping {
                socket.get_mut().write_all(b" ")?;
            }
            let Some(text) = heard else {
                continue;
            };
            if let Some(force_n) = force_of(&text) {
                let mut device = self.device();
                device.live();
                device.force_n = force_n;
                device.commanded = Instant::now();
            }
            match self.fault() {
                ServiceFault::None => last = self.state().to_string(),
                ServiceFault::Garbage => last = "[no json".to_owned(),
                ServiceFault::Boundless => {
                    last = self
                        .state()
                        .to_string()
                        .replace("\"x\":", "\"x\":1e300,\"x0\":");
                }
                ServiceFault::Stuck => {}
                ServiceFault::Silent => continue,
                ServiceFault::Drip => {
                    if !is_dripping {
                        socket.get_mut().write_all(&LONG_TEXT)?;
                        is_dripping = true;
                    }
                    continue;
                }
                ServiceFault::Flood => {
                    last = self.state().to_string();
                    for _ in 0..4 {
                        socket.send(Frame::text(last.clone()))?;
                    }
                }
                ServiceFault::HangUp => return Ok(()),
            }
            socket.send(Frame::text(last.clone()))?;
        }
        Ok(())
    }

    /// State message of the service.
    fn state(&self) -> Value {
        let mut device = self.device();
        device.live();
        let at = device.touch.measured_m();
        let velocity = device.touch.measured_velocity_m_s();
        let vector = |x: f32, y: f32, z: f32| json!({ "x": x, "y": y, "z": z });
        json!({
            "session_id": 1,
            "inverse3": [{
                "device_id": "049D",
                "state": {
                    "cursor_position": vector(at.x, -at.z - 0.12, at.y + 0.15),
                    "cursor_velocity": vector(velocity.x, -velocity.z, velocity.y),
                },
                "status": { "calibrated": true },
            }],
            "wireless_verse_grip": [{
                "state": {
                    "orientation": { "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 },
                    "buttons": { "a": false, "b": false, "c": false },
                },
            }],
        })
    }
}

/// Next text message of the client, if one has arrived.
fn hear(socket: &mut WebSocket<TcpStream>) -> Result<Option<String>, Error> {
    match socket.read() {
        Ok(Frame::Text(text)) => Ok(Some(text.as_str().to_owned())),
        Ok(_) => Ok(None),
        Err(Error::Io(error))
            if matches!(
                error.kind(),
                io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
            ) =>
        {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// Force that a command asks for, in Calot's frame, N.
fn force_of(text: &str) -> Option<Vec3> {
    let json: Value = serde_json::from_str(text).ok()?;
    let force = &json["inverse3"][0]["commands"]["set_cursor_force"]["vector"];
    let [x, y, z] = ["x", "y", "z"].map(|axis| force[axis].as_f64());
    Some(Vec3::new(x? as f32, z? as f32, -y? as f32))
}
