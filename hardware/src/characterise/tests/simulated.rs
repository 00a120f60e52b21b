//! A device in simulated time: the emulated one behind its driver, or with an error in between.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use rt_core::math::Vec3;
use rt_core::port::{
    DeviceCapabilities, DeviceSample, Findings, ForceCommand, Freedom, HapticDevice, LineCounters,
    Polled,
};
use rt_core::time::TimeNs;

use crate::characterise::Clock;
use crate::emulate::{HapticModel, Played, PlayedBody};

/// Movement of the hand: time in s to its target in m.
pub(super) type HandLaw = Box<dyn FnMut(f64) -> Vec3>;

/// Called each millisecond of simulated time; false ends it.
pub(super) type Watch = Box<dyn FnMut(f64, &Played) -> bool>;

/// Time that advances the played device, and ends when a test wants it to.
pub(super) struct PlayedClock {
    pub(super) played: Rc<Played>,
    hand: HandLaw,
    start_ns: TimeNs,
    /// True if this computer stands still for 30 ms in each second.
    pub(super) stalls: bool,
    /// Called after each millisecond; false ends the time.
    pub(super) watch: Watch,
}

impl Clock for PlayedClock {
    fn next(&mut self) -> Option<TimeNs> {
        let now_ns = self.played.now_ns();
        let at_s = now_ns.saturating_sub(self.start_ns) as f64 * 1e-9;
        let stands = self.stalls && at_s.fract() < 0.0005;
        for _ in 0..if stands { 30 } else { 1 } {
            self.played.move_on((self.hand)(at_s));
        }
        (self.watch)(at_s, &self.played).then(|| self.played.now_ns())
    }
}

/// An emulated device, free or in a hand, and its clock.
pub(super) fn simulated(
    model: HapticModel,
    of: PlayedBody,
    hand: HandLaw,
) -> (Box<dyn HapticDevice + Send>, PlayedClock) {
    let (driver, played) = Played::open_as(model, of).unwrap();
    let played = Rc::new(played);
    let start_ns = played.now_ns();
    let clock = PlayedClock {
        played,
        hand,
        start_ns,
        stalls: false,
        watch: Box::new(|_, _| true),
    };
    (driver, clock)
}

/// Nobody's hand.
pub(super) fn nobody() -> HandLaw {
    Box::new(|_| Vec3::zeros())
}

/// Largest force that was sent, N, and the last one.
pub(super) type Sent = Rc<RefCell<(f32, f32)>>;

/// A driver between the experiments and the device.
pub(super) struct Between {
    pub(super) device: Box<dyn HapticDevice + Send>,
    /// Forces on their way, of which the oldest leaves next.
    late: VecDeque<ForceCommand>,
    /// Factors of the force's parts.
    pub(super) factors: Vec3,
    /// True if x and y of the force are exchanged.
    pub(super) swaps_xy: bool,
    pub(super) findings: Findings,
    /// Polls that still bring samples.
    pub(super) polls_left: u64,
    pub(super) sent: Sent,
}

impl Between {
    /// A device whose commands come `late_ms` later.
    pub(super) fn new(device: Box<dyn HapticDevice + Send>, late_ms: usize) -> Self {
        Self {
            device,
            late: VecDeque::from(vec![ForceCommand::default(); late_ms]),
            factors: Vec3::repeat(1.0),
            swaps_xy: false,
            findings: Findings::default(),
            polls_left: u64::MAX,
            sent: Sent::default(),
        }
    }
}

impl HapticDevice for Between {
    fn capabilities(&self) -> DeviceCapabilities {
        self.device.capabilities()
    }

    fn freedom(&self) -> Freedom {
        self.device.freedom()
    }

    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        match (self.device.poll(now_ns), self.polls_left) {
            (Polled::Fresh(_), 0) => Polled::Nothing,
            (polled, _) => {
                self.polls_left -= 1;
                polled
            }
        }
    }

    fn findings(&self) -> Findings {
        Findings {
            faults: self.findings.faults.with(self.device.findings().faults),
            ..self.findings
        }
    }

    fn send(&mut self, mut command: ForceCommand, now_ns: TimeNs) {
        let norm = command.force_n.norm();
        let mut sent = self.sent.borrow_mut();
        *sent = (sent.0.max(norm), norm);
        command.force_n.component_mul_assign(&self.factors);
        if self.swaps_xy {
            command.force_n.swap_rows(0, 1);
        }
        self.late.push_back(command);
        if let Some(command) = self.late.pop_front() {
            self.device.send(command, now_ns);
        }
    }

    fn counters(&self) -> LineCounters {
        self.device.counters()
    }
}
