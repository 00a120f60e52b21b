//! The device's side of the rig protocol, for firmware: bytes in, frames out.
//!
//! `no_std`, no `alloc`, no clock of its own. A firmware loop does four things: it passes received
//! bytes to [`Device::receive`], sends the result of [`Device::answer`], applies [`Device::force`]
//! to the motors, and sends a [`Device::state`] per sample. The emulator in this package runs this
//! code.
//!
//! ```
//! use hardware::rig::device::{Device, Motion};
//! use hardware::rig::wire::Capabilities;
//!
//! let mut device = Device::new(Capabilities::touch_class());
//! let now_us = 0; // the firmware's own microsecond counter
//! device.receive(&[], now_us); // what the UART has
//! if let Some(frame) = device.answer() {
//!     let _ = frame.as_bytes(); // to the UART
//! }
//! let motors = device.force(now_us); // newtons; zero when the host is silent
//! assert_eq!(motors.force_n, [0.0; 3]);
//! assert!(device.state(&Motion::default(), now_us).is_none()); // nobody said hello
//! ```

use super::frame::{Frame, FrameReader};
use super::wire::{Capabilities, DeviceKind, Force, Hello, Kind, Message, State, Status, Switches};

/// Longest time for which a device may render a force without a new `FORCE`, ms.
pub const WATCHDOG_LIMIT_MS: u8 = 100;

/// One sample's measurements, in the device's base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Position of the handle, m.
    pub position_m: [f32; 3],
    /// Velocity of the handle, m/s.
    pub velocity_m_s: [f32; 3],
    /// Rotation of the handle: unit quaternion x y z w.
    pub rotation_xyzw: [f32; 4],
    /// Buttons pressed, one bit each.
    pub buttons: u8,
    /// Opening of the handle, 0 shut to 1 wide open. It is sent only if the device declares an
    /// opening and the host speaks version 2.
    pub opening: f32,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            velocity_m_s: [0.0; 3],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            buttons: 0,
            opening: 1.0,
        }
    }
}

impl Motion {
    fn is_finite(&self) -> bool {
        let parts = self.position_m.iter().chain(&self.velocity_m_s);
        parts
            .chain(&self.rotation_xyzw)
            .all(|part| part.is_finite())
    }
}

/// Counters of the device. They wrap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DeviceCounters {
    /// Messages understood.
    pub messages: u32,
    /// Frames or messages rejected.
    pub bad: u32,
    /// Number of times that the watchdog dropped a force.
    pub watchdog_trips: u32,
}

/// State of one device.
#[derive(Debug, Clone)]
pub struct Device {
    capabilities: Capabilities,
    /// True if the host speaks version 2 and the device has an opening. Messages then carry the
    /// opening.
    sends_opening: bool,
    reader: FrameReader,
    answer_due: bool,
    streaming: bool,
    sequence: u16,
    force: Option<Rendered>,
    /// Number of the newest `FORCE` since the greeting. It is kept when the force is dropped, so
    /// that a repeated `FORCE` is recognised even after the watchdog has acted.
    last_force_sequence: Option<u16>,
    tripped: bool,
    limited: bool,
    fault: bool,
    counters: DeviceCounters,
}

/// Force in effect, its sequence number and the time of its arrival.
#[derive(Debug, Clone, Copy)]
struct Rendered {
    command: Force,
    sequence: u16,
    at_us: u32,
}

impl Device {
    /// A device that no host has greeted. A haptic device whose watchdog is 0 or longer than
    /// [`WATCHDOG_LIMIT_MS`] gets that limit.
    #[must_use]
    pub fn new(mut capabilities: Capabilities) -> Self {
        if capabilities.kind == DeviceKind::Haptic
            && !(1..=WATCHDOG_LIMIT_MS).contains(&capabilities.watchdog_ms)
        {
            capabilities.watchdog_ms = WATCHDOG_LIMIT_MS;
        }
        Self {
            capabilities,
            sends_opening: false,
            reader: FrameReader::new(),
            answer_due: false,
            streaming: false,
            sequence: 0,
            force: None,
            last_force_sequence: None,
            tripped: false,
            limited: false,
            fault: false,
            counters: DeviceCounters::default(),
        }
    }

    /// Takes bytes from the host. `now_us` may wrap.
    pub fn receive(&mut self, bytes: &[u8], now_us: u32) {
        for &byte in bytes {
            let Some(read) = self.reader.push(byte) else {
                continue;
            };
            let message = read
                .ok()
                .and_then(|payload| Message::new(payload).ok())
                .and_then(HostMessage::new);
            match message {
                Some(message) if self.is_of_version(&message) => {
                    self.counters.messages = self.counters.messages.wrapping_add(1);
                    self.handle(message, now_us);
                }
                _ => self.counters.bad = self.counters.bad.wrapping_add(1),
            }
        }
    }

    /// False for a `FORCE` with the length of the other protocol version.
    fn is_of_version(&self, message: &HostMessage) -> bool {
        match message {
            HostMessage::Force(command, _) => command.opening_n.is_some() == self.sends_opening,
            HostMessage::Hello(_) | HostMessage::Stop => true,
        }
    }

    fn handle(&mut self, message: HostMessage, now_us: u32) {
        match message {
            HostMessage::Hello(version) => {
                self.sends_opening = version >= 2 && self.capabilities.opening.is_some();
                // A new host starts without the force of an earlier host.
                self.force = None;
                self.last_force_sequence = None;
                self.tripped = false;
                self.answer_due = true;
                self.streaming = true;
            }
            HostMessage::Stop => {
                self.force = None;
                self.streaming = false;
            }
            HostMessage::Force(command, sequence) if self.streaming => {
                // A repeated or older number shows a stuck or reordering line, not a running host.
                // So it must not keep the watchdog from acting.
                let newer = self
                    .last_force_sequence
                    .is_none_or(|last| (1..0x8000).contains(&sequence.wrapping_sub(last)));
                if newer {
                    self.last_force_sequence = Some(sequence);
                }
                if newer && !self.fault {
                    self.force = Some(Rendered {
                        command,
                        sequence,
                        at_us: now_us,
                    });
                    self.tripped = false;
                }
            }
            HostMessage::Force(..) => {}
        }
    }

    /// Answer to a greeting, if one is due.
    pub fn answer(&mut self) -> Option<Frame> {
        core::mem::take(&mut self.answer_due).then(|| {
            let sequence = self.next_sequence();
            let opening = self.capabilities.opening.filter(|_| self.sends_opening);
            Capabilities {
                version: if opening.is_some() { 2 } else { 1 },
                opening,
                ..self.capabilities
            }
            .frame(sequence)
        })
    }

    /// Force for the motors now: the force in effect, clamped to the device's peak. Zero if none is
    /// in effect: before a greeting, after a stop, at a fault, and after a watchdog's time without
    /// a new `FORCE`.
    pub fn force(&mut self, now_us: u32) -> Force {
        self.check_watchdog(now_us);
        let Some(rendered) = self.force else {
            return Force::default();
        };
        let can = &self.capabilities;
        Force {
            force_n: shorten(rendered.command.force_n, can.force_max_n),
            torque_nm: shorten(rendered.command.torque_nm, can.torque_max_nm),
            opening_n: rendered
                .command
                .opening_n
                .zip(can.opening)
                .map(|(newtons, it)| newtons.min(it.force_max_n).max(-it.force_max_n)),
        }
    }

    /// Drops a force that is too old. It is dropped for good, because after a wrap of the clock it
    /// would look new again.
    fn check_watchdog(&mut self, now_us: u32) {
        let limit_us = u32::from(self.capabilities.watchdog_ms) * 1000;
        let is_old = |force: Rendered| now_us.wrapping_sub(force.at_us) > limit_us;
        if self.force.is_some_and(is_old) {
            self.force = None;
            self.tripped = true;
            self.counters.watchdog_trips = self.counters.watchdog_trips.wrapping_add(1);
        }
    }

    /// One sample for the host; `None` before a greeting and after a stop. Also `None` for a motion
    /// with a NaN or an infinity: the host counts the skipped sequence number as a lost sample.
    pub fn state(&mut self, motion: &Motion, now_us: u32) -> Option<Frame> {
        if !self.streaming {
            return None;
        }
        self.check_watchdog(now_us);
        let mut status = 0;
        if self.force.is_some() {
            status |= Status::FORCE_ON.0;
        }
        if self.tripped {
            status |= Status::WATCHDOG.0;
        }
        if self.limited {
            status |= Status::LIMITED.0;
        }
        if self.fault {
            status |= Status::FAULT.0;
        }
        let state = State {
            status: Status(status),
            buttons: motion.buttons,
            applied_force: self.force.map_or(0, |force| force.sequence),
            device_time_us: now_us,
            position_m: motion.position_m,
            velocity_m_s: motion.velocity_m_s,
            rotation_xyzw: motion.rotation_xyzw,
            opening: self.sends_opening.then_some(motion.opening),
        };
        let sequence = self.next_sequence();
        let is_finite = motion.is_finite() && state.opening.is_none_or(f32::is_finite);
        is_finite.then(|| state.frame(sequence))
    }

    /// One report of a pedal's switches; `None` before a greeting and after a stop.
    pub fn switches(&mut self, switches: Switches) -> Option<Frame> {
        if !self.streaming {
            return None;
        }
        let sequence = self.next_sequence();
        Some(switches.frame(sequence))
    }

    /// Reports, from the next sample on, that heat or current limits the force.
    pub fn set_limited(&mut self, limited: bool) {
        self.limited = limited;
    }

    /// Reports a fault that a person must repair, and drops the force for as long as the fault
    /// stays.
    pub const fn set_fault(&mut self, fault: bool) {
        self.fault = fault;
        if fault {
            self.force = None;
        }
    }

    /// True if a `FORCE` is in effect, even one that asks for zero.
    #[must_use]
    pub const fn is_commanded(&self) -> bool {
        self.force.is_some()
    }

    /// True from a greeting to a stop.
    #[must_use]
    pub const fn is_streaming(&self) -> bool {
        self.streaming
    }

    /// Counters of the device.
    #[must_use]
    pub const fn counters(&self) -> DeviceCounters {
        self.counters
    }

    fn next_sequence(&mut self) -> u16 {
        self.sequence = self.sequence.wrapping_add(1);
        self.sequence
    }
}

/// Messages from a host.
#[derive(Clone, Copy)]
enum HostMessage {
    Hello(u8),
    Force(Force, u16),
    Stop,
}

impl HostMessage {
    fn new(message: Message<'_>) -> Option<Self> {
        match message.kind() {
            Kind::Hello => Hello::parse(&message)
                .ok()
                .map(|hello| Self::Hello(hello.version)),
            Kind::Force => Force::parse(&message)
                .ok()
                .map(|force| Self::Force(force, message.sequence())),
            Kind::Stop => Some(Self::Stop),
            _ => None,
        }
    }
}

/// `vector`, shortened to at most `max`, which may be zero.
fn shorten(vector: [f32; 3], max: f32) -> [f32; 3] {
    let squared: f32 = vector.iter().map(|x| x * x).sum();
    let limit = max * max;
    if squared <= limit {
        return vector;
    }
    // 1/√x by Newton's method from the classic bit-level estimate. Four steps reach the precision
    // of f32.
    let ratio = squared / limit;
    if !ratio.is_finite() {
        return [0.0; 3];
    }
    let mut scale = f32::from_bits(0x5f37_59df - (ratio.to_bits() >> 1));
    for _ in 0..4 {
        scale *= 1.5 - 0.5 * ratio * scale * scale;
    }
    vector.map(|x| x * scale)
}

#[cfg(test)]
mod tests {
    use super::super::wire::{payload, stop_frame};
    use super::*;
    use proptest::prelude::*;

    fn greeted() -> Device {
        let mut device = Device::new(Capabilities::touch_class());
        device.receive(Hello { version: 1 }.frame(0).as_bytes(), 0);
        assert!(device.answer().is_some());
        device
    }

    fn push(newtons: f32, sequence: u16) -> Frame {
        Force {
            force_n: [newtons, 0.0, 0.0],
            torque_nm: [0.0; 3],
            opening_n: None,
        }
        .frame(sequence)
    }

    fn norm(force: Force) -> f32 {
        force.force_n.iter().map(|x| x * x).sum::<f32>().sqrt()
    }

    #[test]
    fn silent_until_greeted_and_after_a_stop() {
        let mut device = Device::new(Capabilities::touch_class());
        device.receive(push(1.0, 1).as_bytes(), 0);
        assert_eq!(device.force(0), Force::default());
        assert!(device.state(&Motion::default(), 0).is_none());
        device.receive(Hello { version: 1 }.frame(0).as_bytes(), 0);
        assert!(device.state(&Motion::default(), 0).is_some());
        device.receive(stop_frame(0).as_bytes(), 0);
        assert!(device.state(&Motion::default(), 0).is_none());
    }

    #[test]
    fn the_watchdog_drops_the_force_and_a_new_command_restores_it() {
        let mut device = greeted();
        device.receive(push(1.0, 1).as_bytes(), 1_000);
        assert!((norm(device.force(51_000)) - 1.0).abs() < 1e-6);
        assert_eq!(device.force(51_001), Force::default());
        assert_eq!(device.counters().watchdog_trips, 1);
        let bytes = payload(&device.state(&Motion::default(), 51_001).unwrap());
        let state = State::parse(&Message::new(&bytes).unwrap()).unwrap();
        assert_eq!(state.status, Status::WATCHDOG);
        device.receive(push(0.5, 2).as_bytes(), 60_000);
        assert!((norm(device.force(60_000)) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn a_force_stays_dropped_when_the_clock_has_wrapped() {
        let mut device = greeted();
        device.receive(push(1.0, 1).as_bytes(), 0);
        assert_eq!(device.force(60_000), Force::default());
        assert_eq!(device.force(0), Force::default());
    }

    #[test]
    fn repeated_bytes_of_a_stuck_line_do_not_reset_the_watchdog() {
        let mut device = greeted();
        for ms in 0..1000 {
            device.receive(push(1.0, 7).as_bytes(), ms * 1000);
            let rendered = device.force(ms * 1000);
            assert_eq!(rendered == Force::default(), ms > 50, "at {ms} ms");
        }
        assert_eq!(device.counters().watchdog_trips, 1);
    }

    #[test]
    fn a_new_host_starts_without_force() {
        let mut device = greeted();
        device.receive(push(1.0, 9).as_bytes(), 0);
        device.receive(Hello { version: 1 }.frame(0).as_bytes(), 10);
        assert_eq!(device.force(10), Force::default());
        device.receive(push(1.0, 1).as_bytes(), 20);
        assert!(norm(device.force(20)) > 0.9);
    }

    #[test]
    fn sampling_alone_finds_that_the_force_is_too_old() {
        let mut device = greeted();
        device.receive(push(1.0, 1).as_bytes(), 0);
        assert!(device.state(&Motion::default(), 50_001).is_some());
        assert!(!device.is_commanded());
    }

    #[test]
    fn a_fault_drops_the_force_until_it_is_repaired() {
        let mut device = greeted();
        device.receive(push(1.0, 1).as_bytes(), 0);
        device.set_fault(true);
        assert_eq!(device.force(0), Force::default());
        device.receive(push(1.0, 2).as_bytes(), 1);
        assert_eq!(device.force(1), Force::default());
        let bytes = payload(&device.state(&Motion::default(), 1).unwrap());
        let state = State::parse(&Message::new(&bytes).unwrap()).unwrap();
        assert_eq!((state.status, state.applied_force), (Status::FAULT, 0));
        device.set_fault(false);
        device.receive(push(1.0, 3).as_bytes(), 2);
        assert!(norm(device.force(2)) > 0.9);
    }

    #[test]
    fn a_motion_that_is_not_a_number_is_a_lost_sample() {
        let mut device = greeted();
        let motion = Motion {
            position_m: [0.0, f32::NAN, 0.0],
            ..Motion::default()
        };
        let number = |frame: &Frame| Message::new(&payload(frame)).unwrap().sequence();
        let before = number(&device.state(&Motion::default(), 0).unwrap());
        assert!(device.state(&motion, 1).is_none());
        let after = number(&device.state(&Motion::default(), 2).unwrap());
        assert_eq!(after, before + 2);
    }

    #[test]
    fn a_watchdog_that_is_too_long_is_shortened() {
        let careless = Capabilities {
            watchdog_ms: 0,
            ..Capabilities::touch_class()
        };
        assert_eq!(
            Device::new(careless).capabilities.watchdog_ms,
            WATCHDOG_LIMIT_MS
        );
    }

    proptest! {
        #[test]
        fn no_bytes_make_a_rig_exceed_its_force_or_its_watchdog(
            noise in prop::collection::vec(any::<u8>(), 0..256),
            force_n in prop::array::uniform3(-40.0..40.0f32),
        ) {
            let mut device = greeted();
            device.receive(&noise, 0);
            device.receive(&[0], 0);
            device.receive(Force { force_n, ..Force::default() }.frame(1).as_bytes(), 0);
            prop_assert!(norm(device.force(0)) <= 3.3 * 1.0001);
            prop_assert_eq!(device.force(50_001), Force::default());
        }
    }
}
