//! A device in simulated time: an emulated device with its driver, and errors inserted between the
//! experiments and the driver.

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
use crate::emulate::{HapticModel, SimulatedBody, SimulatedDevice};

/// Movement of the hand: a function from the time, s, to the hand's target, m.
pub(super) type HandLaw = Box<dyn FnMut(f64) -> Vec3>;

/// Called after each millisecond; false ends the time.
pub(super) type Watch = dyn FnMut(f64, &SimulatedDevice) -> bool;

/// Clock that advances the emulated device and ends when the test's watch function returns false.
pub(super) struct SimulatedClock {
    pub(super) simulated: Rc<SimulatedDevice>,
    hand: HandLaw,
    start_ns: TimeNs,
    /// True to simulate a computer that pauses for 30 ms in each second.
    pub(super) stalls: bool,
    /// Called after each millisecond; false ends the time.
    pub(super) watch: Box<Watch>,
    /// True if fingers in a handle that opens follow the hand's y.
    pub(super) squeezes: bool,
}

impl Clock for SimulatedClock {
    fn next(&mut self) -> Option<TimeNs> {
        let now_ns = self.simulated.now_ns();
        let at_s = now_ns.saturating_sub(self.start_ns) as f64 * 1e-9;
        let stands = self.stalls && at_s.fract() < 0.0005;
        for _ in 0..if stands { 30 } else { 1 } {
            let target_m = (self.hand)(at_s);
            if self.squeezes {
                self.simulated.squeeze_to(target_m.y);
            }
            self.simulated.advance(target_m);
        }
        (self.watch)(at_s, &self.simulated).then(|| self.simulated.now_ns())
    }
}

/// An emulated device, free or in a hand, and its clock.
pub(super) fn simulated(
    model: HapticModel,
    of: SimulatedBody,
    hand: HandLaw,
) -> (Box<dyn HapticDevice + Send>, SimulatedClock) {
    let (driver, simulated) = SimulatedDevice::open_with_body(model, of).unwrap();
    let simulated = Rc::new(simulated);
    let start_ns = simulated.now_ns();
    let clock = SimulatedClock {
        simulated,
        hand,
        start_ns,
        stalls: false,
        watch: Box::new(|_, _| true),
        squeezes: false,
    };
    (driver, clock)
}

/// Hand law for a device that nobody holds.
pub(super) fn nobody() -> HandLaw {
    Box::new(|_| Vec3::zeros())
}

/// Largest force that was sent, N, and the last one.
pub(super) type Sent = Rc<RefCell<(f32, f32)>>;

/// A driver between the experiments and the device, which inserts the errors of a test.
pub(super) struct FaultyDriver {
    pub(super) device: Box<dyn HapticDevice + Send>,
    /// Delayed forces, of which the oldest is sent next.
    late: VecDeque<ForceCommand>,
    /// Factors for the x, y and z parts of the force.
    pub(super) factors: Vec3,
    /// Factor for the force along the opening.
    pub(super) opens_by: f32,
    /// Force along the opening at which its motor saturates, N.
    pub(super) opens_most_n: f32,
    /// Opening that the device reports, as a function of the true opening.
    pub(super) opening: fn(f32) -> f32,
    /// True if x and y of the force are exchanged.
    pub(super) swaps_xy: bool,
    pub(super) findings: Findings,
    /// Number of polls that still return samples.
    pub(super) polls_left: u64,
    pub(super) sent: Sent,
}

impl FaultyDriver {
    /// A device that receives its commands `late_ms` late.
    pub(super) fn new(device: Box<dyn HapticDevice + Send>, late_ms: usize) -> Self {
        Self {
            device,
            late: VecDeque::from(vec![ForceCommand::default(); late_ms]),
            factors: Vec3::repeat(1.0),
            opens_by: 1.0,
            opens_most_n: f32::MAX,
            opening: |it| it,
            swaps_xy: false,
            findings: Findings::default(),
            polls_left: u64::MAX,
            sent: Sent::default(),
        }
    }
}

impl HapticDevice for FaultyDriver {
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
                let mut polled = polled;
                if let Polled::Fresh(sample) = &mut polled {
                    sample.opening = sample.opening.map(self.opening);
                }
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
        let most_n = self.opens_most_n;
        command.opening_n = (self.opens_by * command.opening_n).clamp(-most_n, most_n);
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
