//! Results along one axis.

use rt_core::haptics::output_limit::OutputLimit;
use rt_core::port::DeviceCapabilities;

/// Directions along the axes and the opening.
pub(super) const AXES: [[&str; 2]; 4] =
    [["+x", "-x"], ["+y", "-y"], ["+z", "-z"], ["open", "shut"]];
/// Speed of the tremor for which dry friction is counted as damping, m/s (PROTOCOL.md).
pub const TREMOR_M_S: f64 = 0.2;
/// Ratio of break-away friction to running friction above which the handle is said to stick.
const STICKS: f64 = 1.3;

/// A measured value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// Positions over time, as measured and as computed with the fitted model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Times, s.
    pub at_s: Vec<f64>,
    /// Measured positions, m.
    pub measured_m: Vec<f64>,
    /// Positions of the model, m.
    pub fitted_m: Vec<f64>,
}

/// Results along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Apparent mass, kg.
    pub mass_kg: Estimate,
    /// Viscous damping, N s/m.
    pub damping_n_s_m: Estimate,
    /// Dry friction while the handle moves, N.
    pub friction_n: Estimate,
    /// Dry friction at which the handle begins to move, N.
    pub break_away_n: Estimate,
    /// Force that holds the handle against its weight or a bias of the motors, N.
    pub carries_n: Estimate,
    /// Delay from a command to the sample that shows the command's effect, s, without the time for
    /// which a command is held.
    pub delay_s: Estimate,
    /// Root mean square distance between model and measurement, m.
    pub rms_m: f64,
    /// Friction over speed: pairs of speed, m/s, and force, N.
    pub friction_curve: Vec<[f64; 2]>,
    /// Responses to a slow and a fast part of a chirp.
    pub chirp: [Trace; 2],
    /// Run-out of the handle after a push.
    pub run_out: Trace,
}

impl Axis {
    /// Damping as our serial protocol defines it: viscous damping plus a share of the dry friction.
    #[must_use]
    pub fn tremor_damping_n_s_m(&self) -> Estimate {
        let share = 4.0 / (std::f64::consts::PI * TREMOR_M_S);
        let (viscous, dry) = (self.damping_n_s_m, self.friction_n);
        // The errors of the two are correlated negatively, so this sum overestimates the error.
        Estimate {
            value: viscous.value + share * dry.value,
            error: viscous.error.hypot(share * dry.error),
        }
    }

    /// Sentence that compares both frictions, if the handle sticks.
    pub(super) fn sticking_verdict(&self, name: &str) -> Option<String> {
        let (breaks, runs) = (self.break_away_n.value, self.friction_n.value);
        (breaks > STICKS * runs + 0.02).then(|| {
            format!(
                "{name}: the handle sticks. {breaks:.2} N start its movement, {runs:.2} N keep it moving: slow \
                 movements will jerk. Look for a hinge or a capstan that binds"
            )
        })
    }
}

/// Stiffest contact that Calot renders on a device of this damping, delay and rate, N/m: a share of
/// `K = b / (T/2 + delay)`. `rt-core`'s own output limit computes the value.
#[must_use]
pub fn rendered_n_m(damping_n_s_m: f64, delay_s: f64, rate_hz: f32) -> f64 {
    let device = DeviceCapabilities {
        stiffness_max_n_m: 1e9,
        damping_n_s_m: damping_n_s_m as f32,
        delay_s: delay_s as f32,
        rate_hz,
        ..DeviceCapabilities::TOUCH
    };
    f64::from(OutputLimit::new(&device, 0.0).stiffness_max_n_m())
}
