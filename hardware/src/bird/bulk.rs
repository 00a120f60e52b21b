//! The bird protocol in USB packets. A thread sends commands, asks for records and stores the
//! answers for the tick.

use core::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::transport::Transport;
use crate::HardwareError;
use crate::line::{InputRing, Read, Written, now_ns};

/// The two USB pipes of a device, one in each direction. Each call moves one packet.
pub trait BulkPipe: Send {
    /// Sends one packet and waits until the device has taken the packet.
    fn write(&mut self, packet: &[u8]) -> io::Result<()>;
    /// Waits at most `wait` for a packet; returns 0 when none came.
    fn read(&mut self, packet: &mut [u8; PACKET_BYTES], wait: Duration) -> io::Result<usize>;
}

/// Largest number of bytes of a packet.
pub const PACKET_BYTES: usize = 64;
/// Interval between two requests for a record. The unit measures at the same interval.
const REQUEST_INTERVAL: Duration = Duration::from_millis(10);
/// Time without an answer after which a request is repeated. An earlier repetition would disturb
/// the unit.
const REPEAT_AFTER: Duration = Duration::from_millis(100);
/// Longest wait for a packet before the next command is sent.
const PACKET_WAIT: Duration = Duration::from_millis(2);
/// Largest number of commands queued for the thread.
const QUEUE_MAX: usize = 64;
/// Longest command, bytes.
const COMMAND_BYTES: usize = 16;

/// A command queued for the thread.
#[derive(Debug, Clone, Copy)]
struct Command {
    bytes: [u8; COMMAND_BYTES],
    len: usize,
    /// True if the command requests a record. The thread repeats such a command.
    is_point: bool,
}

impl Command {
    fn new(bytes: &[u8], is_point: bool) -> Self {
        let mut command = Self {
            bytes: [0; COMMAND_BYTES],
            len: bytes.len().min(COMMAND_BYTES),
            is_point,
        };
        for (slot, &byte) in command.bytes.iter_mut().zip(bytes) {
            *slot = byte;
        }
        command
    }

    fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }
}

/// A device's pipes and the thread that serves them. Dropping a `Bulk` sends the queued commands
/// and ends the thread.
pub(super) struct Bulk {
    path: PathBuf,
    input: Arc<InputRing>,
    commands: Option<SyncSender<Command>>,
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for Bulk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bulk")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Bulk {
    /// Starts the thread. `path` appears in messages only.
    pub(super) fn start(path: &Path, mut pipe: Box<dyn BulkPipe>) -> Result<Self, HardwareError> {
        let (commands, to_send) = sync_channel(QUEUE_MAX);
        let input = Arc::new(InputRing::new());
        let into = Arc::clone(&input);
        let thread = thread::Builder::new()
            .name("calot-bulk".to_owned())
            .stack_size(256 << 10)
            .spawn(move || {
                let _ = serve(&mut *pipe, &to_send, &into);
                into.mark_lost();
            })
            .map_err(|error| HardwareError::Line {
                path: path.to_path_buf(),
                doing: "starting its thread",
                what: error.to_string(),
            })?;
        Ok(Self {
            path: path.to_path_buf(),
            input,
            commands: Some(commands),
            thread: Some(thread),
        })
    }

    fn send(&self, command: Command) -> Written {
        match &self.commands {
            Some(commands) if !self.is_lost() && commands.try_send(command).is_ok() => Written::All,
            _ => Written::Nothing,
        }
    }
}

impl Transport for Bulk {
    fn path(&self) -> &Path {
        &self.path
    }

    fn is_lost(&self) -> bool {
        self.input.is_lost()
    }

    fn read(&mut self, buffer: &mut [u8]) -> Read {
        self.input.read(buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> Written {
        self.send(Command::new(bytes, false))
    }

    fn begin(&mut self, point: &[u8]) -> Written {
        self.send(Command::new(point, true))
    }

    fn is_addressed(&self) -> bool {
        true
    }
}

impl Drop for Bulk {
    fn drop(&mut self) {
        self.commands = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Sends and receives until the pipe breaks or all senders are gone.
fn serve(pipe: &mut dyn BulkPipe, to_send: &Receiver<Command>, into: &InputRing) -> io::Result<()> {
    let mut point: Option<Command> = None;
    let mut requested: Option<Instant> = None;
    let mut due = Instant::now();
    let mut packet = [0; PACKET_BYTES];
    loop {
        match to_send.try_recv() {
            Ok(command) if command.is_point => point = Some(command),
            Ok(command) => {
                // Any other command ends the repeated requests, just as it ends a stream on a
                // serial line.
                point = None;
                pipe.write(command.as_bytes())?;
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        let may_ask = requested.is_none_or(|requested| requested.elapsed() > REPEAT_AFTER);
        if let Some(point) = point.filter(|_| may_ask && Instant::now() >= due) {
            pipe.write(point.as_bytes())?;
            requested = Some(Instant::now());
            due = (due + REQUEST_INTERVAL).max(Instant::now());
        }
        let count = pipe.read(&mut packet, PACKET_WAIT)?;
        if count > 0 {
            requested = None;
            into.put(packet.get(..count).unwrap_or(&[]), now_ns());
        }
    }
}
