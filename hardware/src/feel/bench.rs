//! Runs the device under test, one millisecond at a time, within the limits of the test.

use rt_core::fault::Fault;
use rt_core::math::Vec3;
use rt_core::port::{DeviceCapabilities, ForceCommand, HapticDevice, Polled};
use rt_core::time::TimeNs;

use super::{Answer, Guide, Left, Live, Question, Squeezed, Step};

/// Largest distance that the handle may move during a push, m. Even a loosely held handle moves
/// less.
const TRAVEL_MAX_M: f32 = 0.04;
/// Largest speed of the handle during a push, m/s.
const SPEED_MAX_M_S: f32 = 0.6;
/// Time after which a step that nobody ends is given up, ms.
const TIMEOUT_MS: u32 = 300_000;
/// Time without a sample after which the test ends, ms.
const SILENT_MS: u32 = 1000;

/// Reason for which the test ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// The person stopped the test, or no longer answered.
    Stopped,
    /// The line was lost.
    Lost,
    /// No valid sample came for a second.
    Silent,
    /// The driver or the device reported this fault.
    Fault(Fault),
    /// The handle moved too far or too fast under a small force.
    MovedTooFar,
}

impl EndReason {
    /// The reason with its remedy.
    pub(super) fn words(self) -> String {
        match self {
            Self::Stopped => "the test was stopped before its end".into(),
            Self::Lost => "the line was lost. Plug the device in and test again".into(),
            Self::Silent => {
                "no valid sample came for a second. Test the device with `calot devices conformance`".into()
            }
            Self::Fault(fault) => format!(
                "the driver or the device found a fault ({}). Test the device with `calot devices conformance`",
                fault.name()
            ),
            Self::MovedTooFar => format!(
                "the handle ran off under a small force, farther than {:.0} mm or faster than {SPEED_MAX_M_S} m/s. \
                 Hold the handle loosely; if it runs off again, the force grows with the motion",
                TRAVEL_MAX_M * 1e3
            ),
        }
    }
}

/// A sample of the handle.
#[derive(Debug, Clone, Copy)]
pub(super) struct HandleSample {
    pub(super) at_ns: TimeNs,
    /// The device's clock, µs; wraps. `None` if it has none.
    pub(super) device_time_us: Option<u32>,
    pub(super) at_m: Vec3,
    /// Velocity as the device reports it, m/s.
    pub(super) reported_m_s: Option<Vec3>,
    /// Opening of the handle, 0 to 1.
    pub(super) opening: Option<f32>,
}

/// The device under test, and the guide that talks to the person.
pub(super) struct Bench<'a> {
    device: &'a mut dyn HapticDevice,
    guide: &'a mut dyn Guide,
    silent_ms: u32,
    before: Option<HandleSample>,
    live: Live,
}

impl<'a> Bench<'a> {
    pub(super) fn new(device: &'a mut dyn HapticDevice, guide: &'a mut dyn Guide) -> Self {
        Self {
            device,
            guide,
            silent_ms: 0,
            before: None,
            live: Live::default(),
        }
    }

    pub(super) fn capabilities(&self) -> DeviceCapabilities {
        self.device.capabilities()
    }

    pub(super) fn guide(&mut self) -> &mut dyn Guide {
        self.guide
    }

    /// `wanted_n`, limited to half of the peak force and to the continuous force.
    pub(super) fn permitted_n(&self, wanted_n: f32) -> f32 {
        let can = self.capabilities();
        wanted_n
            .min(0.5 * can.force_max_n)
            .min(can.force_continuous_n)
    }

    /// Time after which the device itself drops a force, ms, if the driver knows it.
    pub(super) fn watchdog_ms(&self) -> Option<u16> {
        self.device.watchdog_ms()
    }

    /// Runs one millisecond with this force. Returns the new sample, if one came.
    pub(super) fn tick(&mut self, force_n: Vec3) -> Result<Option<HandleSample>, EndReason> {
        self.run(Some(force_n))
    }

    /// Runs one millisecond with this force, or without any command. Returns the new sample, if
    /// one came.
    fn run(&mut self, force_n: Option<Vec3>) -> Result<Option<HandleSample>, EndReason> {
        let now_ns = self.guide.wait();
        if self.guide.is_stopped() {
            return Err(EndReason::Stopped);
        }
        let mut device_time_us = None;
        let polled = self.device.poll_each(now_ns, &mut |reading| {
            device_time_us = reading.device_time_us;
        });
        if let Some(force_n) = force_n {
            let command = ForceCommand {
                opening_n: self.live.opening_n,
                force_n,
                torque_nm: Vec3::zeros(),
            };
            self.device.send(command, now_ns);
        }
        self.live.force_n = force_n.unwrap_or_default();
        if let Polled::Fresh(sample) = &polled {
            self.live.at_m = Some(sample.device_from_handle.translation.vector);
            self.live.opening = sample.opening;
            self.live.velocity_m_s = self.device.reported_velocity_m_s();
        }
        self.guide.live(&self.live);
        // A device that only answers commands sends no samples while it gets no commands.
        self.silent_ms = match force_n {
            Some(_) => self.silent_ms + 1,
            None => 0,
        };
        let faults = self.device.findings().faults;
        let grave = [Fault::DeviceFault, Fault::FrozenDevice, Fault::DeviceClock];
        if let Some(fault) = grave.into_iter().find(|it| faults.contains(*it)) {
            return Err(EndReason::Fault(fault));
        }
        match polled {
            Polled::Lost => Err(EndReason::Lost),
            Polled::Nothing if self.silent_ms > SILENT_MS => Err(EndReason::Silent),
            Polled::Nothing => Ok(None),
            Polled::Fresh(sample) => {
                self.silent_ms = 0;
                let seen = HandleSample {
                    at_ns: sample.at_ns,
                    device_time_us,
                    at_m: sample.device_from_handle.translation.vector,
                    reported_m_s: self.live.velocity_m_s,
                    opening: sample.opening,
                };
                self.before = Some(seen);
                Ok(Some(seen))
            }
        }
    }

    /// Shows the person a step and applies this force until the step is done. `each` gets the
    /// samples.
    pub(super) fn until_done(
        &mut self,
        step: &Step,
        force_n: Vec3,
        mut each: impl FnMut(HandleSample),
    ) -> Result<(), EndReason> {
        self.guide.tell(step);
        let start = self.before;
        for _ in 0..TIMEOUT_MS {
            let earlier = self.before;
            if let Some(seen) = self.tick(force_n)? {
                if force_n != Vec3::zeros() && exceeds_limits(start, earlier, seen) {
                    return Err(EndReason::MovedTooFar);
                }
                each(seen);
            }
            if self.guide.is_done() {
                return Ok(());
            }
        }
        Err(EndReason::Stopped)
    }

    /// Runs `ms` milliseconds with the force that `force_n` gives for each of them. `each` gets the
    /// samples.
    pub(super) fn push(
        &mut self,
        ms: u32,
        force_n: impl Fn(u32) -> Vec3,
        mut each: impl FnMut(u32, HandleSample),
    ) -> Result<(), EndReason> {
        let start = self.before;
        for at_ms in 0..ms {
            let earlier = self.before;
            let Some(seen) = self.tick(force_n(at_ms))? else {
                continue;
            };
            if exceeds_limits(start, earlier, seen) {
                return Err(EndReason::MovedTooFar);
            }
            each(at_ms, seen);
        }
        Ok(())
    }

    /// Shows the person a step and waits without force until the step is done.
    pub(super) fn until_done_without_force(&mut self, step: &Step) -> Result<(), EndReason> {
        self.until_done(step, Vec3::zeros(), |_| {})
    }

    /// Sends nothing for `ms` milliseconds. Then asks the guide whether the handle still pushes,
    /// and sends nothing until the answer comes. Ends early if the handle runs off.
    pub(super) fn stay_silent(&mut self, ms: u32) -> Result<Option<Left>, EndReason> {
        let start = self.before;
        for at_ms in 0..TIMEOUT_MS {
            if at_ms == ms {
                self.guide.ask(Question::Left);
            }
            if at_ms >= ms && self.guide.has_answer() {
                return Ok(self.guide.left());
            }
            let earlier = self.before;
            if let Some(seen) = self.run(None)?
                && exceeds_limits(start, earlier, seen)
            {
                return Err(EndReason::MovedTooFar);
            }
        }
        Err(EndReason::Stopped)
    }

    /// Runs `ms` milliseconds with the force along the opening that `opening_n` gives for each of
    /// them.
    pub(super) fn push_fingers(
        &mut self,
        ms: u32,
        opening_n: impl Fn(u32) -> f32,
    ) -> Result<(), EndReason> {
        let ticked = (0..ms).try_for_each(|at_ms| {
            self.live.opening_n = opening_n(at_ms);
            self.tick(Vec3::zeros()).map(drop)
        });
        self.live.opening_n = 0.0;
        ticked
    }

    /// Asks which way the handle pushed the fingers.
    pub(super) fn squeezed_which_way(&mut self) -> Result<Squeezed, EndReason> {
        self.until_answered(Question::Squeezed)?;
        Ok(self.guide.squeezed())
    }

    /// Asks which way the handle pushed.
    pub(super) fn pushed_which_way(&mut self) -> Result<Answer, EndReason> {
        self.until_answered(Question::Pushed)?;
        Ok(self.guide.pushed())
    }

    /// Asks whether there is a scale.
    pub(super) fn has_scale(&mut self) -> Result<bool, EndReason> {
        self.until_answered(Question::HasScale)?;
        Ok(self.guide.has_scale())
    }

    /// Asks for the reading of the scale, N.
    pub(super) fn pressed_n(&mut self) -> Result<Option<f32>, EndReason> {
        self.until_answered(Question::Pressed)?;
        Ok(self.guide.pressed_n())
    }

    /// Shows a question and goes on without force until the guide has the answer.
    fn until_answered(&mut self, question: Question) -> Result<(), EndReason> {
        self.guide.ask(question);
        for _ in 0..TIMEOUT_MS {
            if self.guide.has_answer() {
                return Ok(());
            }
            self.tick(Vec3::zeros())?;
        }
        Err(EndReason::Stopped)
    }

    /// Ends every force.
    pub(super) fn rest(&mut self) {
        for _ in 0..3 {
            let now_ns = self.guide.wait();
            self.device.send(ForceCommand::default(), now_ns);
        }
        self.live.force_n = Vec3::zeros();
        self.live.opening_n = 0.0;
        self.guide.live(&self.live);
    }
}

/// True if the handle has gone too far since `start`, or too fast since `earlier`.
fn exceeds_limits(
    start: Option<HandleSample>,
    earlier: Option<HandleSample>,
    now: HandleSample,
) -> bool {
    let moved_m = start.map_or(0.0, |start| (now.at_m - start.at_m).norm());
    let speed_m_s = earlier.map_or(0.0, |earlier| {
        let passed_s = now.at_ns.saturating_sub(earlier.at_ns) as f32 * 1.0e-9;
        (now.at_m - earlier.at_m).norm() / passed_s.max(5.0e-3)
    });
    moved_m > TRAVEL_MAX_M || speed_m_s > SPEED_MAX_M_S
}
