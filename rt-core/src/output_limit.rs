//! The only way out for force. What the simulation wants passes every gate, in this order:
//! finite, enable and ramp (stale, lost, paused and tripped included), stiffness, clamp with
//! thermal limit, slew, finite again.
//!
//! Trips latch until a person enables the force again. Every gate that acts raises its fault.

use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::port::DeviceCapabilities;
use crate::sim::{Status, TICK_S};

/// Largest change of force in a tick, N. A Touch reaches its peak in 3.3 ms.
const SLEW_N: f32 = 1.0;
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
    stiffness_max_n_m: f32,
    ramp_s: f32,
    enabled: bool,
    tripped: bool,
    /// Rises to 1 over the ramp.
    gain: f32,
    /// Running mean of the squared force, N².
    heat_n2: f32,
    /// Force of the last tick, N.
    last_n: Vec3,
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
            stiffness_max_n_m: safe(device.stiffness_max_n_m),
            ramp_s: safe(ramp_s).max(TICK_S),
            enabled: false,
            tripped: false,
            gain: 0.0,
            heat_n2: 0.0,
            last_n: Vec3::zeros(),
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
        self.last_n = Vec3::zeros();
    }

    /// The force that may leave in this tick, N, in the demand's frame. Never longer than the
    /// device's peak, always finite.
    pub fn apply(&mut self, demand: &Demand, faults: &mut FaultSet) -> Vec3 {
        faults.raise_if(demand.device == Status::Stale, Fault::StaleDevice);
        faults.raise_if(demand.device == Status::Lost, Fault::LostDevice);
        self.trip(demand, faults);
        let force = match self.finite(demand, faults) {
            Some(wanted) if self.is_open() && demand.device != Status::Lost => {
                self.ramp(demand);
                let force = self.cap_stiffness(&wanted, demand.stiffness_n_m, faults) * self.gain;
                let force = self.clamp(&force, faults);
                self.slew(&force, faults)
            }
            // Cut at once: a force that nobody can answer for does not fade.
            _ => {
                self.gain = 0.0;
                Vec3::zeros()
            }
        };
        let force = if math::is_finite(&force) {
            force
        } else {
            Vec3::zeros()
        };
        self.heat_n2 += (force.norm_squared() - self.heat_n2) * (TICK_S / HEAT_TIME_S);
        self.last_n = force;
        force
    }

    fn trip(&mut self, demand: &Demand, faults: &mut FaultSet) {
        // Written so that a speed that is not a number trips.
        let is_slow = demand.speed_m_s <= SPEED_TRIP_M_S;
        if self.is_open() && !is_slow {
            self.tripped = true;
            faults.raise(Fault::SpeedTrip);
        }
    }

    fn finite(&self, demand: &Demand, faults: &mut FaultSet) -> Option<Vec3> {
        let finite = math::is_finite(&demand.force_n) && !demand.stiffness_n_m.is_nan();
        faults.raise_if(!finite, Fault::BadForce);
        finite.then_some(demand.force_n)
    }

    fn ramp(&mut self, demand: &Demand) {
        let step = if demand.device == Status::Live && !demand.paused {
            TICK_S / self.ramp_s
        } else {
            -TICK_S / FALL_S
        };
        self.gain = (self.gain + step).clamp(0.0, 1.0);
    }

    fn cap_stiffness(&self, force: &Vec3, stiffness: f32, faults: &mut FaultSet) -> Vec3 {
        if stiffness <= self.stiffness_max_n_m {
            return *force;
        }
        faults.raise(Fault::StiffnessCapped);
        force * (self.stiffness_max_n_m / stiffness)
    }

    fn clamp(&self, force: &Vec3, faults: &mut FaultSet) -> Vec3 {
        let limit = self.limit_n();
        let length = math::norm(force);
        if length <= limit {
            return *force;
        }
        let warm = limit < self.peak_n;
        faults.raise(if warm {
            Fault::ThermalLimited
        } else {
            Fault::Clamped
        });
        match math::unit(force) {
            Some(direction) => direction * limit,
            None => Vec3::zeros(), // longer than f32 can square
        }
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

    fn slew(&self, force: &Vec3, faults: &mut FaultSet) -> Vec3 {
        let step = force - self.last_n;
        let length = math::norm(&step);
        if length <= SLEW_N {
            return *force;
        }
        faults.raise(Fault::Slewed);
        self.last_n + step * (SLEW_N / length)
    }
}
