//! Frames on a serial line and the handshake. The drivers of rigs and of their pedals share them.

use std::io::Write as _;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::port::LineCounters;
use rt_core::time::TimeNs;

use crate::HardwareError;
use crate::line::{Line, Read, Written};

use super::frame::{Frame, FrameError, FrameReader};
use super::handshake_log::HandshakeLog;
use super::wire::{Capabilities, DeviceKind, Hello, Message, VERSION, stop_frame};

/// Bit rate of the line, bit/s. Boards with native USB ignore it. On a UART, `STATE` at 1 kHz fills
/// about half of it.
pub(crate) const BAUD: u32 = 1_000_000;
/// Longest wait for the device's answer. Opening the line resets many boards, whose loaders take
/// up to 3 s before the firmware runs (serialport-rs issue 251).
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Time without an answer after which a message says that the program waits.
const REPORT_AFTER: Duration = Duration::from_secs(1);
/// Interval between two greetings.
const GREETING_INTERVAL: Duration = Duration::from_millis(100);
/// Interval between two reads of the line during the greeting.
const LOOK_INTERVAL: Duration = Duration::from_millis(1);
/// Largest number of bytes that one poll reads, about 20 frames. So a flooded line cannot delay the
/// tick.
const BYTES_PER_POLL: usize = 1024;

/// This computer's end of a line to a rig: frames, sequence numbers and counters.
#[derive(Debug)]
pub(super) struct Host {
    line: Line,
    reader: FrameReader,
    counters: LineCounters,
    last_sequence: Option<u16>,
    send_sequence: u16,
    /// True if the device may hold a part of a frame: at the start, and after a write that broke
    /// off. The next frame then begins with a zero byte.
    torn: bool,
    /// Bytes received during the handshake, for the error's message; `None` after it.
    handshake_log: Option<Box<HandshakeLog>>,
    bad: [u64; BadReason::COUNT],
}

/// Reasons for which a frame or a message counts as bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BadReason {
    /// The frame's checksum is wrong.
    Checksum,
    /// The frame's stuffing or length is wrong.
    Frame,
    /// The driver expects no such kind of message, or its length does not fit the kind or the
    /// declared version.
    Message,
    /// The message repeats the last message's number.
    Repeated,
    /// A field of a message other than STATE is outside its range.
    Range,
    /// The position is farther out than twice the workspace's radius.
    Reach,
    /// The check of plausibility dropped the sample.
    Judged,
    /// The sample's position is outside its range.
    Position,
    /// The sample's velocity is outside its range.
    Velocity,
    /// The sample's rotation is no unit quaternion.
    Rotation,
}

impl BadReason {
    /// Number of reasons.
    pub(super) const COUNT: usize = 10;
    /// Reasons that refuse a sample. The others refuse bytes that may be no sample.
    pub(super) const OF_SAMPLES: [Self; 5] = [
        Self::Reach,
        Self::Judged,
        Self::Position,
        Self::Velocity,
        Self::Rotation,
    ];

    /// Text for each reason, in the order of the variants. It follows a number, as in "3 frames
    /// with a wrong checksum".
    pub(super) const NAMES: [&str; Self::COUNT] = [
        "with a wrong checksum",
        "with wrong stuffing or length",
        "of an unknown or unexpected kind, or of a wrong length",
        "with the same number as the frame before",
        "outside the allowed ranges",
        "farther out than twice the workspace's radius",
        "that contradict earlier ones",
        "with a coordinate of the position beyond 1.6 m (a step is 0.1 µm)",
        "with a component of the velocity beyond 20 m/s (a step is 1 µm/s)",
        "with a rotation that is no unit quaternion (send 0, 0, 0, 32767 where there is none)",
    ];
}

impl Host {
    /// Opens the line and greets the device. Waits up to 5 s for the answer, so the tick must not
    /// call it.
    pub(super) fn open(
        path: &Path,
        kind: DeviceKind,
    ) -> Result<(Self, Capabilities), HardwareError> {
        Self::on(Line::open(path, BAUD)?, kind)
    }

    /// Greets the device on an open line, and checks its capabilities.
    pub(super) fn on(line: Line, kind: DeviceKind) -> Result<(Self, Capabilities), HardwareError> {
        let path = line.path().to_path_buf();
        let mut host = Self {
            line,
            reader: FrameReader::new(),
            counters: LineCounters::default(),
            last_sequence: None,
            send_sequence: 0,
            // The device may hold half a frame of an earlier host.
            torn: true,
            handshake_log: Some(Box::default()),
            bad: [0; BadReason::COUNT],
        };
        let capabilities = host.greet(kind)?;
        check(&path, kind, &capabilities)?;
        host.handshake_log = None;
        host.bad = [0; BadReason::COUNT];
        host.counters = LineCounters {
            unread_bytes: host.counters.unread_bytes,
            ..LineCounters::default()
        };
        Ok((host, capabilities))
    }

    fn greet(&mut self, kind: DeviceKind) -> Result<Capabilities, HardwareError> {
        let path = self.line.path().to_path_buf();
        let start = Instant::now();
        let mut next_greeting = start;
        let mut answer = None;
        let mut is_reported = false;
        while start.elapsed() < HANDSHAKE {
            if !is_reported && start.elapsed() >= REPORT_AFTER {
                is_reported = true;
                report_waiting(&path);
            }
            if Instant::now() >= next_greeting {
                let sequence = self.next_sequence();
                self.send(&Hello { version: VERSION }.frame(sequence));
                next_greeting += GREETING_INTERVAL;
            }
            let read = self.receive(|message, _| {
                if let Ok(capabilities) = Capabilities::parse(message) {
                    answer = Some(capabilities);
                }
            });
            if let Some(capabilities) = answer {
                return Ok(capabilities);
            }
            if read.is_none() {
                return Err(HardwareError::Missing { path });
            }
            thread::sleep(LOOK_INTERVAL);
        }
        let expected = kind.name();
        let waited_ms = HANDSHAKE.as_millis() as u64;
        Err(match &self.handshake_log {
            Some(handshake_log) if handshake_log.bytes() > 0 => HardwareError::Garbled {
                path,
                expected,
                waited_ms,
                heard: handshake_log.in_words(),
            },
            _ => HardwareError::Silent {
                path,
                expected,
                waited_ms,
                heard: 0,
            },
        })
    }

    /// Reads the available bytes, up to [`BYTES_PER_POLL`], and passes every good, new message to
    /// `take`, with the arrival time of the bytes. Returns the number of bytes; `None` when the
    /// line is lost.
    pub(super) fn receive(&mut self, mut take: impl FnMut(&Message<'_>, TimeNs)) -> Option<usize> {
        let mut bytes = [0; BYTES_PER_POLL];
        let (count, at_ns) = match self.line.read(&mut bytes) {
            Read::Bytes(count, at_ns) => (count, at_ns),
            Read::Empty => return Some(0),
            Read::Lost => return None,
        };
        // Bytes that this computer itself dropped are not the device's fault. They make no frame
        // bad or lost.
        let discarded = self.line.discarded();
        if discarded != self.counters.unread_bytes {
            self.counters.unread_bytes = discarded;
            self.reader = FrameReader::midway();
            self.last_sequence = None;
        }
        for &byte in bytes.iter().take(count) {
            let read = self.reader.push(byte);
            if let Some(handshake_log) = &mut self.handshake_log {
                handshake_log.take(byte, read);
            }
            let message = match read {
                None => continue,
                Some(Ok(payload)) => Message::new(payload).map_err(|_| BadReason::Message),
                Some(Err(FrameError::Checksum)) => Err(BadReason::Checksum),
                Some(Err(_)) => Err(BadReason::Frame),
            };
            let message = match message {
                Ok(message) => message,
                Err(why) => {
                    count_bad(&mut self.counters, &mut self.bad, why);
                    continue;
                }
            };
            let sequence = message.sequence();
            match self
                .last_sequence
                .replace(sequence)
                .map(|last| sequence.wrapping_sub(last))
            {
                // A repeated number means that the device or the line sent a frame twice.
                Some(0) => count_bad(&mut self.counters, &mut self.bad, BadReason::Repeated),
                Some(step) => {
                    self.counters.frames += 1;
                    // A step backwards shows a restarted device, not 60 000 lost frames.
                    if step < 0x8000 {
                        self.counters.lost_frames += u64::from(step - 1);
                    }
                    take(&message, at_ns);
                }
                None => {
                    self.counters.frames += 1;
                    take(&message, at_ns);
                }
            }
        }
        Some(count)
    }

    /// Counts good messages as bad after all. `rejected` has their number by reason.
    pub(super) fn reject(&mut self, rejected: &[u64; BadReason::COUNT]) {
        for (sum, &count) in self.bad.iter_mut().zip(rejected) {
            *sum += count;
            self.counters.frames -= count;
            self.counters.bad_frames += count;
        }
    }

    /// Number of bad frames by reason, in the order of [`BadReason::NAMES`].
    pub(super) const fn bad(&self) -> [u64; BadReason::COUNT] {
        self.bad
    }

    /// Sends a frame, or counts it as dropped.
    pub(super) fn send(&mut self, frame: &Frame) {
        if self.torn {
            match self.line.write(&[0]) {
                Written::All => self.torn = false,
                Written::Part(_) | Written::Nothing => {
                    self.counters.dropped_writes += 1;
                    return;
                }
            }
        }
        match self.line.write(frame.as_bytes()) {
            Written::All => {}
            Written::Part(_) => {
                self.torn = true;
                self.counters.dropped_writes += 1;
            }
            Written::Nothing => self.counters.dropped_writes += 1,
        }
    }

    /// Takes a new number for the next message to send.
    pub(super) fn next_sequence(&mut self) -> u16 {
        self.send_sequence = self.send_sequence.wrapping_add(1);
        self.send_sequence
    }

    /// The number of the last message that was sent or refused.
    pub(super) fn sent_sequence(&self) -> u16 {
        self.send_sequence
    }

    pub(super) fn counters(&self) -> LineCounters {
        self.counters
    }

    pub(super) fn path(&self) -> &Path {
        self.line.path()
    }

    pub(super) fn is_lost(&self) -> bool {
        self.line.is_lost()
    }
}

fn count_bad(counters: &mut LineCounters, bad: &mut [u64; BadReason::COUNT], why: BadReason) {
    counters.bad_frames += 1;
    if let Some(count) = bad.get_mut(why as usize) {
        *count += 1;
    }
}

/// Tells the user that the program waits for the device. Unlike `eprintln!` this does not panic
/// when standard error is closed.
fn report_waiting(path: &Path) {
    let path = path.display();
    let _ = writeln!(
        std::io::stderr(),
        "{path}: waiting up to 5 s for the device's answer; it may still be starting"
    );
}

impl Drop for Host {
    /// Tells the device to end its force and its stream of samples.
    fn drop(&mut self) {
        let sequence = self.next_sequence();
        self.send(&stop_frame(sequence));
    }
}

impl DeviceKind {
    const fn name(self) -> &'static str {
        match self {
            Self::Haptic => "haptic device",
            Self::Pedal => "foot pedal",
        }
    }
}

fn check(path: &Path, kind: DeviceKind, found: &Capabilities) -> Result<(), HardwareError> {
    let path = || path.to_path_buf();
    if !(1..=VERSION).contains(&found.version) {
        return Err(HardwareError::Version {
            path: path(),
            expected: VERSION,
            found: found.version,
            older: if found.version == 0 {
                "device's firmware"
            } else {
                "driver"
            },
        });
    }
    if found.kind != kind {
        return Err(HardwareError::WrongDevice {
            path: path(),
            expected: kind.name(),
            found: format!("a {}", found.kind.name()),
        });
    }
    let capability = |what, value: f32, allowed| HardwareError::Capability {
        path: path(),
        what,
        value,
        allowed,
    };
    if !(10..=8000).contains(&found.rate_hz) {
        return Err(capability("rate_hz", found.rate_hz.into(), "10 to 8000"));
    }
    if kind == DeviceKind::Pedal {
        return Ok(());
    }
    if !(1..=super::device::WATCHDOG_LIMIT_MS).contains(&found.watchdog_ms) {
        return Err(capability(
            "watchdog_ms",
            found.watchdog_ms.into(),
            "1 to 100",
        ));
    }
    let opening = found.opening.unwrap_or(super::wire::Opening {
        travel_m: TRAVEL_M.1,
        force_max_n: 0.0,
        stiffness_max_n_m: 0.0,
    });
    // Without a force along the opening, the stiffness there may be 0. A range excludes its lower
    // end, so that end must lie below 0.
    let least_n_m = if opening.force_max_n > 0.0 { 0.0 } else { -1.0 };
    let limits = [
        Limit {
            what: "force_max_n",
            value: found.force_max_n,
            range: FORCE_MAX_N,
            allowed: "more than 0, at most 32.767: a FORCE message carries no more",
        },
        Limit {
            what: "force_continuous_n",
            value: found.force_continuous_n,
            range: (0.0, found.force_max_n),
            allowed: "more than 0, at most force_max_n",
        },
        Limit {
            what: "stiffness_max_n_m",
            value: found.stiffness_max_n_m,
            range: STIFFNESS_N_M,
            allowed: "more than 0, at most 50000",
        },
        Limit {
            what: "damping_n_s_m",
            value: found.damping_n_s_m,
            range: DAMPING_N_S_M,
            allowed: "more than 0, at most 10. Measure it with `calot devices characterise`",
        },
        Limit {
            what: "delay_s",
            value: found.delay_s,
            range: (-1.0, 0.05),
            allowed: "0 to 0.05",
        },
        Limit {
            what: "workspace_radius_m",
            value: found.workspace_radius_m,
            range: (0.009_99, 1.5),
            allowed: "0.01 to 1.5",
        },
        Limit {
            what: "opening.travel_m",
            value: opening.travel_m,
            range: TRAVEL_M,
            allowed: "0.001 to 0.3. A device whose handle does not open declares version 1",
        },
        Limit {
            what: "opening.force_max_n",
            value: opening.force_max_n,
            range: (-1.0, FORCE_MAX_N.1),
            allowed: "0 to 32.767: a FORCE message carries no more",
        },
        Limit {
            what: "opening.stiffness_max_n_m",
            value: opening.stiffness_max_n_m,
            range: (least_n_m, STIFFNESS_N_M.1),
            allowed: "more than 0 (or 0 without a force along the opening), at most 50000",
        },
    ];
    let wrong = |it: &&Limit| !(it.value > it.range.0 && it.value <= it.range.1);
    limits
        .iter()
        .find(wrong)
        .map_or(Ok(()), |it| Err(capability(it.what, it.value, it.allowed)))
}

/// A declared value and its range.
struct Limit {
    what: &'static str,
    value: f32,
    /// Allowed range: more than the first value, at most the second.
    range: (f32, f32),
    allowed: &'static str,
}

/// Range of a peak force, N. An axis of a `FORCE` holds at most 32.767 N; the bound adds half a
/// step for rounding.
const FORCE_MAX_N: (f32, f32) = (0.0, 32.767_5);
/// Range of the travel of a handle's opening, m. Below 1 mm, a handle is only a switch. No hand
/// opens wider than 0.3 m.
const TRAVEL_M: (f32, f32) = (0.000_999, 0.3);
/// Range of a stiffness, N/m. The stiffest desktop devices render some kN/m.
const STIFFNESS_N_M: (f32, f32) = (0.0, 50_000.0);
/// Range of the device's own damping, N s/m. No hand-held device absorbs more. The largest
/// stiffness that keeps contacts stable grows with this damping; a larger damping would make that
/// limit useless.
const DAMPING_N_S_M: (f32, f32) = (0.0, 10.0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_for_another_version_names_the_part_to_update() {
        let check = |version| {
            let found = Capabilities {
                version,
                ..Capabilities::touch_class()
            };
            check(Path::new("/dev/rig"), DeviceKind::Haptic, &found)
        };
        check(1).unwrap();
        for (version, older) in [(VERSION + 1, "driver"), (0, "device's firmware")] {
            let said = check(version).unwrap_err().to_string();
            assert!(said.contains("speaks protocol version"), "{said}");
            assert!(said.ends_with(&format!("Update the {older}")), "{said}");
        }
    }
}
