//! The only exit of force: every force to the device passes these gates.
//!
//! 1. Cut: the force is zero at once. Causes: the speed trip, a demand that is not finite, a force
//!    that nobody has enabled, a device that is lost or fails.
//! 2. Ramp: the force rises after an enable or a cut. It falls while the sample is stale or the
//!    simulation is paused.
//! 3. Stiffness: the force is scaled down.
//! 4. Passivity: damping is added.
//! 5. Clamp: to the peak, or to less while the motors are warm.
//! 6. Slew: the change within a tick is limited.
//! 7. Finite test: a part that is not finite becomes zero.
//!
//! Torque skips gate 4. The force that opens the handle skips gates 3 and 4. So does the force of
//! the trocar: the trocar's law bounds its stiffness, and gate 3 leaves the rest of the device's
//! stiffness to tissue.
//!
//! A cut skips the other gates, so that the force does not fade. The ramp comes before passivity,
//! because damping that takes energy out must not fade with the ramp. Clamp and slew come last, so
//! that they bound everything that leaves. The clamp precedes slew, so a constant demand above the
//! peak raises `Clamped`, and no `Slewed`.
//!
//! A trip latches until a person enables the force again. A stale or lost device does not latch:
//! when samples come again, the force rises by the ramp.
//!
//! A gate raises its fault in each tick in which it acts, with these exceptions:
//!
//! - A trip raises `SpeedTrip` once, when it begins.
//! - The driver of a device that fails raises the fault ([`crate::port::Findings`]).
//! - A stale device raises no `StaleDevice` if another fault explains its silence.
//! - The stiffness gate raises no fault while its scale returns to 1.
//! - The final finite test raises no fault.

use crate::fault::{Fault, FaultSet};
use crate::haptics::passivity::Passivity;
use crate::math::{self, Vec3};
use crate::port::{DeviceCapabilities, ForceCommand};
use crate::time::TICK_S;
use crate::words::Status;

/// Largest change of force in a tick, N. At this rate a Touch reaches its peak in 3.3 ms.
const SLEW_N: f32 = 1.0;
/// Largest rendered stiffness, as a share of the stiffness `K = b / (T/2 + delay)` at which a loop
/// with the device's damping b and its delay begins to oscillate (Colgate and Schenkel 1997, with
/// delay). A larger share renders stiffer contact with less margin. With this share, `evaluate
/// haptics` finds every wall stable while a hand holds the device.
const STABLE_SHARE: f32 = 0.7;
/// Largest step of force in a tick from a change of the stiffness scale, N; half of the demand's
/// own change is added to it. A hand does not feel a step of this size. It feels a larger step as a
/// knock.
const SCALE_STEP_N: f32 = 0.001;
/// Ticks for which the gate holds the largest recent stiffness before it fades. If the stiffness
/// flickers, as with spheres that stick and slip, the gate uses the maximum, so the force is
/// steady.
const STIFFNESS_HOLD_TICKS: u32 = 50;
/// Upper bound of the remembered stiffness, N/m. An infinite stiffness would never fade.
const REMEMBERED_MAX_N_M: f32 = 1.0e6;
/// Factor by which a remembered stiffness fades in a tick. With a larger factor it fades more
/// slowly.
const STIFFNESS_FADE: f32 = 0.98;
/// Lower bound of the stiffness scale as a divisor. The scale has this value if a device renders a
/// wall of 20 kN/m with 2 N/m.
const SCALE_MIN: f32 = 1.0e-4;
/// Longest delay of a device for which a stiffness is computed, s.
const DELAY_MAX_S: f32 = 0.1;
/// Largest change of torque and of the opening force in a tick, as a share of the peak: as fast as
/// the force of a Touch.
const SLEW_SHARE: f32 = 0.3;
/// Speed of the handle above which the force trips, m/s.
const SPEED_TRIP_M_S: f32 = 1.2;
/// Time constant of the motors' heating, s. The value is assumed, because makers do not publish it.
/// A Touch then reaches its thermal limit after 4 s at the peak.
const HEAT_TIME_S: f32 = 60.0;
/// Heat at which the limit begins to fall from the peak, as a share of the heat of the continuous
/// force. A larger share makes the fall shorter and steeper.
const WARM_SHARE: f32 = 0.8;
/// Time in which force falls from full to zero after the sample became stale or the simulation
/// paused, s.
const RAMP_DOWN_S: f32 = 0.02;

/// Force that the simulation asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Force on the handle, N, in any frame.
    pub force_n: Vec3,
    /// Torque on the handle, N m, in the frame of the force.
    pub torque_nm: Vec3,
    /// Force that opens the handle, N.
    pub opening_n: f32,
    /// Stiffness of the contact at the handle, N/m.
    pub stiffness_n_m: f32,
    /// Force of the trocar on the handle, N, in the frame of the force; not part of `force_n`.
    pub trocar_n: Vec3,
    /// Stiffness of the trocar at the handle, N/m.
    pub trocar_n_m: f32,
    /// Position of the handle, m, in the frame of the force, if this tick brought a sample.
    pub handle_m: Option<Vec3>,
    /// Speed of the handle, m/s.
    pub speed_m_s: f32,
    /// Status of the device.
    pub device: Status,
    /// True while the device reports a fault of its own.
    pub device_fails: bool,
    /// True while the simulation is paused.
    pub paused: bool,
}

/// The gates and their state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputLimit {
    peak_n: f32,
    continuous_n: f32,
    torque_max_nm: f32,
    opening_max_n: f32,
    stiffness_max_n_m: f32,
    passivity: Passivity,
    ramp_s: f32,
    enabled: bool,
    tripped: bool,
    /// Share of the force that the ramp lets through, 0 to 1.
    gain: f32,
    /// Largest recent stiffness of the contact, N/m.
    stiffness_n_m: f32,
    /// Ticks since `stiffness_n_m` was measured, counted up to `STIFFNESS_HOLD_TICKS`.
    stiffness_age_ticks: u32,
    /// Stiffness scale: share of the force that the stiffness gate lets through.
    stiffness_scale: f32,
    /// Size of the force demanded in the last tick, N. It is 0 after a cut or a restart, so that
    /// the next force starts with a fresh stiffness scale.
    last_demand_n: f32,
    /// Running mean of the squared force, N².
    heat_n2: f32,
    /// Share of the trocar in the last command, N.
    trocar_n: Vec3,
    /// Command of the last tick.
    last: ForceCommand,
}

/// A limit below this (in its SI unit) counts as 0, because squares of smaller forces underflow.
const LIMIT_MIN: f32 = 1.0e-9;

/// The limit, or 0 if it is not finite or below `LIMIT_MIN`.
fn valid_limit(limit: f32) -> f32 {
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
        let peak_n = valid_limit(device.force_max_n);
        Self {
            peak_n,
            continuous_n: valid_limit(device.force_continuous_n).min(peak_n),
            torque_max_nm: valid_limit(device.torque_max_nm),
            opening_max_n: if device.opening.is_rendered() {
                valid_limit(device.opening.force_max_n)
            } else {
                0.0
            },
            stiffness_max_n_m: stiffness_max_n_m(device),
            passivity: Passivity::new(device),
            ramp_s: valid_limit(ramp_s).max(TICK_S),
            enabled: false,
            tripped: false,
            gain: 0.0,
            stiffness_n_m: 0.0,
            stiffness_age_ticks: 0,
            stiffness_scale: 1.0,
            last_demand_n: 0.0,
            heat_n2: 0.0,
            trocar_n: Vec3::zeros(),
            last: ForceCommand::default(),
        }
    }

    /// Enables the force by a person's command, or cuts it. Also clears a trip.
    pub fn enable(&mut self, enabled: bool) {
        self.enabled = enabled;
        self.tripped = false;
        self.gain = 0.0;
        self.last_demand_n = 0.0;
    }

    /// True if force may leave: enabled and not tripped.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.enabled && !self.tripped
    }

    /// Share of the demanded force that the ramp lets through; 0 while force is cut.
    #[must_use]
    pub const fn share(&self) -> f32 {
        self.gain
    }

    /// Starts the force from zero again, after a time without ticks.
    pub fn restart(&mut self) {
        self.gain = 0.0;
        self.last_demand_n = 0.0;
        self.last = ForceCommand::default();
        self.passivity.reset();
    }

    /// Stiffest contact that is rendered unscaled, N/m: as the device states, or as its damping
    /// allows at its delay.
    #[must_use]
    pub const fn stiffness_max_n_m(&self) -> f32 {
        self.stiffness_max_n_m
    }

    /// Largest demand that can be rendered fully now, N: the present limit of the force divided by
    /// the stiffness scale. `None` for a device without motors.
    pub(crate) fn rendered_n(&self) -> Option<f32> {
        (self.peak_n > 0.0).then(|| self.limit_n() / self.stiffness_scale.max(SCALE_MIN))
    }

    /// Share of the trocar in the last command, N, in the demand's frame.
    pub(crate) const fn trocar_n(&self) -> Vec3 {
        self.trocar_n
    }

    /// Energy that the hand put into contact and into the device's damping, and did not get back,
    /// J. If it is below zero, the loop has generated energy and is damped.
    #[must_use]
    pub const fn energy_j(&self) -> f32 {
        self.passivity.energy_j()
    }

    /// Passes a demand through all gates. The result is in the demand's frame, finite, and never
    /// above the device's peaks.
    pub fn apply(&mut self, demand: &Demand, faults: &mut FaultSet) -> ForceCommand {
        // A known fault of the device already explains that samples are late.
        let is_late = demand.device == Status::Stale && !faults.explains_silence();
        faults.raise_if(is_late, Fault::StaleDevice);
        faults.raise_if(demand.device == Status::Lost, Fault::LostDevice);
        self.trip(demand, faults);
        let is_finite = is_sound(demand);
        faults.raise_if(!is_finite, Fault::BadForce);
        let is_demanded = demand.force_n != Vec3::zeros()
            || demand.torque_nm != Vec3::zeros()
            || demand.opening_n.abs() > 0.0;
        faults.raise_if(is_demanded && !self.enabled, Fault::NotEnabled);
        self.passivity
            .observe(demand.handle_m.filter(math::is_finite));
        self.trocar_n = Vec3::zeros();
        let is_connected = demand.device != Status::Lost && !demand.device_fails;
        let out = if is_finite && self.is_open() && is_connected {
            self.ramp(demand);
            faults.raise_if(is_demanded && self.gain < 1.0, Fault::Ramped);
            let share = self.gain * self.cap_stiffness(demand, faults);
            let (force_n, damped) = self.passivity.damp(&(demand.force_n * share));
            faults.raise_if(damped, Fault::Damped);
            let trocar_n = demand.trocar_n * self.gain;
            ForceCommand {
                force_n: self.limit_force(&force_n, &trocar_n, faults),
                torque_nm: self.limit_torque(&(demand.torque_nm * share), faults),
                opening_n: self.limit_opening(demand.opening_n * self.gain, faults),
            }
        } else {
            // Cut at once: a force that is not safe must not fade.
            self.gain = 0.0;
            self.last_demand_n = 0.0;
            ForceCommand::default()
        };
        let finite_or_zero = |v: Vec3| {
            if math::is_finite(&v) {
                v
            } else {
                Vec3::zeros()
            }
        };
        let out = ForceCommand {
            force_n: finite_or_zero(out.force_n),
            torque_nm: finite_or_zero(out.torque_nm),
            opening_n: if out.opening_n.is_finite() {
                out.opening_n
            } else {
                0.0
            },
        };
        self.heat_n2 += (out.force_n.norm_squared() - self.heat_n2) * (TICK_S / HEAT_TIME_S);
        self.passivity.record_sent(&(out.force_n - self.trocar_n));
        self.last = out;
        out
    }

    fn trip(&mut self, demand: &Demand, faults: &mut FaultSet) {
        // The comparison is written so that a NaN speed trips.
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
            -TICK_S / RAMP_DOWN_S
        };
        self.gain = (self.gain + step).clamp(0.0, 1.0);
    }

    /// Stiffness scale that keeps the stiffness within the device's limit. It changes in small
    /// steps of force, so that a contact that begins or ends under load is not felt as a knock.
    fn cap_stiffness(&mut self, demand: &Demand, faults: &mut FaultSet) -> f32 {
        self.remember_stiffness(demand.stiffness_n_m);
        // The trocar's law uses a part of the device's stiffness; tissue has the rest.
        let most_n_m = (self.stiffness_max_n_m - demand.trocar_n_m).max(0.0);
        let too_stiff = self.stiffness_n_m > most_n_m;
        faults.raise_if(too_stiff, Fault::StiffnessCapped);
        let target_scale = if too_stiff {
            most_n_m / self.stiffness_n_m
        } else {
            1.0
        };
        // While the demand rises, the output must not fall; while the demand falls, the output must
        // not rise. An output that falls while the hand goes deeper would be unstable.
        let wanted_n = math::norm(&demand.force_n);
        let steady_scale = self.stiffness_scale * self.last_demand_n / wanted_n.max(LIMIT_MIN);
        let target_scale = if wanted_n > self.last_demand_n {
            target_scale.max(steady_scale)
        } else if wanted_n < self.last_demand_n {
            target_scale.min(steady_scale)
        } else {
            target_scale
        };
        // A new force takes its scale at once. A continuing force changes its scale in small steps.
        let step_n = SCALE_STEP_N + 0.5 * (wanted_n - self.last_demand_n).abs();
        let step = step_n / self.last_demand_n.max(step_n);
        self.stiffness_scale += (target_scale - self.stiffness_scale).max(-step).min(step);
        self.last_demand_n = wanted_n;
        self.stiffness_scale
    }

    fn remember_stiffness(&mut self, present_n_m: f32) {
        let present_n_m = present_n_m.min(REMEMBERED_MAX_N_M);
        if self.last_demand_n <= 0.0 || present_n_m >= self.stiffness_n_m {
            self.stiffness_n_m = present_n_m;
            self.stiffness_age_ticks = 0;
        } else if self.stiffness_age_ticks < STIFFNESS_HOLD_TICKS {
            self.stiffness_age_ticks += 1;
        } else {
            self.stiffness_n_m = present_n_m.max(self.stiffness_n_m * STIFFNESS_FADE);
        }
    }

    fn limit_force(&mut self, force: &Vec3, trocar_n: &Vec3, faults: &mut FaultSet) -> Vec3 {
        let limit = self.limit_n();
        let warm = limit < self.peak_n;
        let fault = if warm {
            Fault::ThermalLimited
        } else {
            Fault::Clamped
        };
        let mut force = clamp(force, limit, fault, faults);
        if *trocar_n != Vec3::zeros() {
            let tissue_n = force;
            force = clamp(&(tissue_n + trocar_n), limit, fault, faults);
            self.trocar_n = force - tissue_n;
        }
        slew(&self.last.force_n, &force, SLEW_N, faults)
    }

    fn limit_torque(&self, torque: &Vec3, faults: &mut FaultSet) -> Vec3 {
        let peak = self.torque_max_nm;
        if peak <= 0.0 {
            return Vec3::zeros(); // the device renders no torque, so no fault is raised
        }
        let torque = clamp(torque, peak, Fault::Clamped, faults);
        slew(&self.last.torque_nm, &torque, SLEW_SHARE * peak, faults)
    }

    /// Limits the opening force. The stiffness gate of the contact does not act on it, because the
    /// stiffness of the opening already bounds the demand.
    fn limit_opening(&self, opening_n: f32, faults: &mut FaultSet) -> f32 {
        let peak = self.opening_max_n;
        if peak <= 0.0 {
            return 0.0; // the device renders no opening force, so no fault is raised
        }
        let as_vector = |newtons: f32| Vec3::new(newtons, 0.0, 0.0);
        let force = clamp(&as_vector(opening_n), peak, Fault::Clamped, faults);
        slew(
            &as_vector(self.last.opening_n),
            &force,
            SLEW_SHARE * peak,
            faults,
        )
        .x
    }

    /// Present limit of the force, N: the peak while the motors are cold. As they warm, the limit
    /// falls; at the heat of the continuous force, it equals the continuous force.
    fn limit_n(&self) -> f32 {
        let continuous_n2 = self.continuous_n * self.continuous_n;
        let excess = self.heat_n2 - WARM_SHARE * continuous_n2;
        if excess <= 0.0 {
            return self.peak_n;
        }
        let share = (excess / ((1.0 - WARM_SHARE) * continuous_n2)).min(1.0);
        self.peak_n + (self.continuous_n - self.peak_n) * share
    }
}

/// Stiffest contact that is rendered unscaled, N/m; 0 if the device's rate or delay is implausible.
fn stiffness_max_n_m(device: &DeviceCapabilities) -> f32 {
    let period_s = if device.rate_hz >= 1.0 {
        device.rate_hz.recip().max(TICK_S)
    } else {
        return 0.0;
    };
    if !(0.0..=DELAY_MAX_S).contains(&device.delay_s) {
        return 0.0;
    }
    let stable_n_m = valid_limit(device.damping_n_s_m) / (0.5 * period_s + device.delay_s);
    valid_limit(device.stiffness_max_n_m).min(STABLE_SHARE * stable_n_m)
}

fn is_sound(demand: &Demand) -> bool {
    let finite = math::is_finite(&demand.force_n)
        && math::is_finite(&demand.torque_nm)
        && math::is_finite(&demand.trocar_n)
        && demand.trocar_n_m.is_finite();
    let handle = demand.handle_m.is_none_or(|at_m| math::is_finite(&at_m));
    finite && handle && demand.opening_n.is_finite() && !demand.stiffness_n_m.is_nan()
}

/// `wanted`, shortened to `limit`.
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

/// `wanted`, moved to within `step_max` of `last`.
fn slew(last: &Vec3, wanted: &Vec3, step_max: f32, faults: &mut FaultSet) -> Vec3 {
    let step = wanted - last;
    let length = math::norm(&step);
    if length <= step_max {
        return *wanted;
    }
    faults.raise(Fault::Slewed);
    last + step * (step_max / length)
}
