//! The only way out for force. What the simulation wants passes every gate, in this order:
//! finite, enable and ramp (stale, lost, paused and tripped included), stiffness, clamp with
//! thermal limit, slew, finite again.
//!
//! Trips latch until a person enables the force again. Every gate that acts raises its fault.

use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::port::{DeviceCapabilities, ForceCommand};
use crate::sim::{Status, TICK_S};

/// Largest change of force in a tick, N. A Touch reaches its peak in 3.3 ms.
const SLEW_N: f32 = 1.0;
/// Largest change of torque in a tick, as a share of the peak: as quick as force is.
const TORQUE_SLEW: f32 = 0.3;
/// Fastest handle that force is rendered for, m/s.
const SPEED_TRIP_M_S: f32 = 1.2;
/// Time constant of the motors' heat, s. Assumed: makers do not publish it. 4 s at the peak of
/// a Touch reach its limit.
const HEAT_TIME_S: f32 = 60.0;
/// Share of the continuous limit's heat at which the peak begins to come down.
const WARM: f32 = 0.8;
/// Time in which force falls from full to nothing when the sample is stale or the simulation
/// pauses, s.
const FALL_S: f32 = 0.02;

/// What the simulation wants the hand to feel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Force on the handle, N, in any one frame.
    pub force_n: Vec3,
    /// Torque on the handle, N m, in the same frame.
    pub torque_n_m: Vec3,
    /// Stiffness behind it at the handle, N/m.
    pub stiffness_n_m: f32,
    /// Speed of the handle, m/s.
    pub speed_m_s: f32,
    /// Whether the device can be relied on.
    pub device: Status,
    /// The simulation stands still.
    pub paused: bool,
}

/// The gates and what they remember.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputLimit {
    peak_n: f32,
    continuous_n: f32,
    torque_max_n_m: f32,
    stiffness_max_n_m: f32,
    ramp_s: f32,
    enabled: bool,
    tripped: bool,
    /// Rises to 1 over the ramp.
    gain: f32,
    /// Running mean of the squared force, N².
    heat_n2: f32,
    /// What left in the last tick.
    last: ForceCommand,
}

/// Limits below this (N, N/m, s) are 0: squares of smaller forces lose their digits.
const LIMIT_MIN: f32 = 1.0e-9;

/// A limit that is not a positive number lets nothing through.
fn safe(limit: f32) -> f32 {
    if limit.is_finite() && limit >= LIMIT_MIN {
        limit
    } else {
        0.0
    }
}

impl OutputLimit {
    /// Gates for a device. `ramp_s` is the time over which force rises after each enable.
    #[must_use]
    pub fn new(device: &DeviceCapabilities, ramp_s: f32) -> Self {
        let peak_n = safe(device.force_max_n);
        Self {
            peak_n,
            continuous_n: safe(device.force_continuous_n).min(peak_n),
            torque_max_n_m: safe(device.torque_max_n_m),
            stiffness_max_n_m: safe(device.stiffness_max_n_m),
            ramp_s: safe(ramp_s).max(TICK_S),
            enabled: false,
            tripped: false,
            gain: 0.0,
            heat_n2: 0.0,
            last: ForceCommand::default(),
        }
    }

    /// A person lets force through (this also clears a trip) or cuts it.
    pub fn enable(&mut self, enabled: bool) {
        self.enabled = enabled;
        self.tripped = false;
        self.gain = 0.0;
    }

    /// Whether force may leave: enabled and not tripped.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.enabled && !self.tripped
    }

    /// No tick ran for so long that nobody answered for the force: it rises from nothing again.
    pub fn restart(&mut self) {
        self.gain = 0.0;
        self.last = ForceCommand::default();
    }

    /// What may leave in this tick, in the demand's frame. Never more than the device's peaks,
    /// always finite.
    pub fn apply(&mut self, demand: &Demand, faults: &mut FaultSet) -> ForceCommand {
        faults.raise_if(demand.device == Status::Stale, Fault::StaleDevice);
        faults.raise_if(demand.device == Status::Lost, Fault::LostDevice);
        self.trip(demand, faults);
        let is_finite = is_sound(demand);
        faults.raise_if(!is_finite, Fault::BadForce);
        let out = if is_finite && self.is_open() && demand.device != Status::Lost {
            self.ramp(demand);
            let share = self.gain * self.cap_stiffness(demand.stiffness_n_m, faults);
            ForceCommand {
                force_n: self.limit_force(&(demand.force_n * share), faults),
                torque_n_m: self.limit_torque(&(demand.torque_n_m * share), faults),
            }
        } else {
            // Cut at once: a force that nobody can answer for does not fade.
            self.gain = 0.0;
            ForceCommand::default()
        };
        let or_none = |v: Vec3| {
            if math::is_finite(&v) {
                v
            } else {
                Vec3::zeros()
            }
        };
        let out = ForceCommand {
            force_n: or_none(out.force_n),
            torque_n_m: or_none(out.torque_n_m),
        };
        self.heat_n2 += (out.force_n.norm_squared() - self.heat_n2) * (TICK_S / HEAT_TIME_S);
        self.last = out;
        out
    }

    fn trip(&mut self, demand: &Demand, faults: &mut FaultSet) {
        // Written so that a speed that is not a number trips.
        let is_slow = demand.speed_m_s <= SPEED_TRIP_M_S;
        if self.is_open() && !is_slow {
            self.tripped = true;
            faults.raise(Fault::SpeedTrip);
        }
    }

    fn ramp(&mut self, demand: &Demand) {
        let step = if demand.device == Status::Live && !demand.paused {
            TICK_S / self.ramp_s
        } else {
            -TICK_S / FALL_S
        };
        self.gain = (self.gain + step).clamp(0.0, 1.0);
    }

    /// What share of the force keeps the stiffness within the device's.
    fn cap_stiffness(&self, stiffness: f32, faults: &mut FaultSet) -> f32 {
        if stiffness <= self.stiffness_max_n_m {
            return 1.0;
        }
        faults.raise(Fault::StiffnessCapped);
        self.stiffness_max_n_m / stiffness
    }

    fn limit_force(&self, force: &Vec3, faults: &mut FaultSet) -> Vec3 {
        let limit = self.limit_n();
        let warm = limit < self.peak_n;
        let fault = if warm {
            Fault::ThermalLimited
        } else {
            Fault::Clamped
        };
        let force = clamp(force, limit, fault, faults);
        slew(&self.last.force_n, &force, SLEW_N, faults)
    }

    fn limit_torque(&self, torque: &Vec3, faults: &mut FaultSet) -> Vec3 {
        let peak = self.torque_max_n_m;
        let torque = clamp(torque, peak, Fault::Clamped, faults);
        slew(&self.last.torque_n_m, &torque, TORQUE_SLEW * peak, faults)
    }

    /// The peak while the motors are cold; comes down to the continuous force as their heat
    /// reaches what that force would make.
    fn limit_n(&self) -> f32 {
        let full = self.continuous_n * self.continuous_n;
        let excess = self.heat_n2 - WARM * full;
        if excess <= 0.0 {
            return self.peak_n;
        }
        let share = (excess / ((1.0 - WARM) * full)).min(1.0);
        self.peak_n + (self.continuous_n - self.peak_n) * share
    }
}

fn is_sound(demand: &Demand) -> bool {
    let finite = math::is_finite(&demand.force_n) && math::is_finite(&demand.torque_n_m);
    finite && !demand.stiffness_n_m.is_nan()
}

/// `wanted`, no longer than `limit`.
fn clamp(wanted: &Vec3, limit: f32, fault: Fault, faults: &mut FaultSet) -> Vec3 {
    if math::norm(wanted) <= limit {
        return *wanted;
    }
    faults.raise(fault);
    match math::unit(wanted) {
        Some(direction) => direction * limit,
        None => Vec3::zeros(), // longer than f32 can square
    }
}

/// `wanted`, no further from `last` than `step_max`.
fn slew(last: &Vec3, wanted: &Vec3, step_max: f32, faults: &mut FaultSet) -> Vec3 {
    let step = wanted - last;
    let length = math::norm(&step);
    if length <= step_max {
        return *wanted;
    }
    faults.raise(Fault::Slewed);
    last + step * (step_max / length)
}
