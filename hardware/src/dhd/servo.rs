//! The thread that serves the device.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use rt_core::math::Vec3;
use rt_core::port::{Buttons, DeviceCapabilities};
use rt_core::time::TimeNs;

use super::axes;
use super::gripper::Gripper;
use super::library::{Handle, Parts};
use super::shared::{Command, Sample, Shared, ZERO_COMMAND};
use crate::gate::Gate;
use crate::line::now_ns;

/// Interval between two cycles of the thread. Each cycle takes a sample and sends a force.
const PERIOD: Duration = Duration::from_millis(1);
/// Number of cycles between two reads of the status of the device's controller.
const STATUS_CYCLES: u32 = 100;
/// Time without a single answer after which the device counts as lost.
const LOST_AFTER: Duration = Duration::from_millis(100);
/// Fastest plausible movement of the handle, m/s.
const SPEED_LIMIT_M_S: f32 = 5.0;
/// Noise of a position, m, allowed on top of that movement.
const NOISE_M: f32 = 0.002;
/// Farthest plausible position from the middle, in workspace radii.
const REACH: f32 = 3.0;
/// Number of cycles over which the force rises again after the device had removed it.
const RISE_CYCLES: f64 = 500.0;

/// `wanted`, shortened to at most `most`. Zero if `wanted` is not finite.
fn clamp(wanted: Vec3, most: f32) -> Vec3 {
    let norm = wanted.norm();
    if !norm.is_finite() {
        return Vec3::zeros();
    }
    if norm <= most {
        return wanted;
    }
    wanted * (most / norm)
}

/// The device and the state of its thread. However the thread ends, dropping the `Servo` brakes the
/// motors and marks the device as lost.
#[derive(Debug)]
pub(super) struct Servo {
    handle: Handle,
    parts: Parts,
    limits: DeviceCapabilities,
    shared: Arc<Shared>,
    gate: Gate<3>,
    admitted_ns: TimeNs,
    gripper: Gripper,
    count: u32,
    jumps: u32,
    cycles: u32,
    is_reset: bool,
    /// Share of the force that is rendered, 0 to 1.
    force_share: f64,
    failing_since: Option<Instant>,
}

impl Servo {
    pub(super) fn new(
        handle: Handle,
        parts: Parts,
        limits: DeviceCapabilities,
        shared: Arc<Shared>,
    ) -> Self {
        Self {
            handle,
            parts,
            limits,
            shared,
            gate: Gate::new(SPEED_LIMIT_M_S, NOISE_M),
            admitted_ns: 0,
            gripper: Gripper::new(parts.is_left_handed),
            count: 0,
            jumps: 0,
            // Not 0, so that the status is first read after 99 cycles: the controller needs some
            // time to enable the force.
            cycles: 1,
            is_reset: false,
            force_share: 1.0,
            failing_since: None,
        }
    }

    /// Serves the device until the driver ends or the device is lost.
    pub(super) fn serve(mut self) {
        let mut due = Instant::now();
        while self.shared.running.load(Ordering::Acquire) && self.cycle() {
            // Missed periods are skipped.
            due = (due + PERIOD).max(Instant::now());
            thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }

    /// One sample and one force. False when the device is lost.
    fn cycle(&mut self) -> bool {
        if self.cycles.is_multiple_of(STATUS_CYCLES) {
            self.read_controller_status();
        }
        self.cycles = self.cycles.wrapping_add(1);
        let read = self.read();
        if let Some((position, rows)) = &read {
            self.failing_since = None;
            self.take(*position, rows);
        } else {
            self.shared.bad_samples.fetch_add(1, Ordering::Relaxed);
        }
        // A single failed read does not change the force, because the tick itself lets its force
        // fade when samples are missing.
        let command = self.shared.command();
        self.render(&command);
        if read.is_some() {
            return true;
        }
        let since = *self.failing_since.get_or_insert_with(Instant::now);
        since.elapsed() <= LOST_AFTER
    }

    fn read_controller_status(&mut self) {
        let Some(status) = self.handle.status() else {
            return;
        };
        self.is_reset = status.is_reset;
        self.shared
            .is_forceless
            .store(status.is_forceless, Ordering::Release);
        if status.is_forceless {
            self.force_share = 0.0;
        }
    }

    fn read(&self) -> Option<([f64; 3], [f64; 9])> {
        const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        match self.parts.has_wrist {
            true => self.handle.pose(),
            false => Some((self.handle.position()?, IDENTITY)),
        }
    }

    /// Publishes a pose if it is plausible.
    fn take(&mut self, position: [f64; 3], rows: &[f64; 9]) {
        let at_ns = now_ns();
        let position_m = axes::ours(position);
        let is_near = position_m.norm() <= self.limits.workspace_radius_m * REACH;
        let rotation = axes::rotation(rows).filter(|_| is_near && !self.is_reset);
        let Some(rotation) = rotation else {
            self.shared.bad_samples.fetch_add(1, Ordering::Relaxed);
            return;
        };
        let before = self.gate.last();
        let is_gap = self.gate.is_gap(at_ns);
        if !self.gate.admit(position_m.into(), at_ns) {
            self.shared
                .leaps
                .fetch_add(u32::from(!is_gap), Ordering::Relaxed);
            return;
        }
        if before.is_some_and(|before| self.has_jumped(before.into(), position_m, at_ns)) {
            self.jumps = self.jumps.wrapping_add(1);
        }
        self.admitted_ns = at_ns;
        self.count = self.count.wrapping_add(1);
        let opening = self.opening();
        let closed = match self.gripper.is_closed() {
            true => Buttons::GRASP.0,
            false => 0,
        };
        let buttons = Buttons(self.handle.buttons().unwrap_or(0) as u8 | closed);
        let velocity = self.handle.velocity().unwrap_or([f64::NAN; 3]);
        self.shared.publish(&Sample {
            position_m,
            rotation,
            velocity_m_s: axes::ours(velocity),
            opening: opening.unwrap_or(f32::NAN),
            buttons,
            count: self.count,
            at_ns,
            jumps: self.jumps,
        });
    }

    /// True if the gate admitted a position to which no hand can move from the previous one.
    fn has_jumped(&self, before: Vec3, now: Vec3, at_ns: TimeNs) -> bool {
        let passed_s = at_ns.saturating_sub(self.admitted_ns) as f32 * 1e-9;
        (now - before).amax() > NOISE_M + SPEED_LIMIT_M_S * passed_s
    }

    fn opening(&mut self) -> Option<f32> {
        if !self.parts.has_gripper {
            return None;
        }
        let angle_deg = self.handle.gripper_deg()?;
        self.gripper.take(angle_deg)
    }

    /// Sends the commanded force within the device's limits. Zero force is sent too, because the
    /// library adds gravity compensation to every force that it is sent.
    fn render(&mut self, command: &Command) {
        if self.shared.is_forceless.load(Ordering::Acquire) {
            self.force_share = 0.0;
        }
        let force_share = self.force_share;
        self.force_share = (force_share + 1.0 / RISE_CYCLES).min(1.0);
        let scaled =
            |wanted: Vec3, most: f32| axes::theirs(&clamp(wanted, most)).map(|x| x * force_share);
        let force = scaled(command.force_n, self.limits.force_max_n);
        let torque = scaled(command.torque_nm, self.limits.torque_max_nm);
        let gripper = match self.parts.has_active_gripper {
            true => self.gripper.force_n(command.opening_n) * force_share,
            false => 0.0,
        };
        if !self.handle.set_force(force, torque, gripper) {
            self.shared.refusals.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Drop for Servo {
    fn drop(&mut self) {
        self.shared.is_lost.store(true, Ordering::Release);
        self.render(&ZERO_COMMAND);
        self.handle.stop();
    }
}
