//! Results of a characterisation, their comparison with what the device declares, and the lines of
//! a station file.

use rt_core::haptics::output_limit::OutputLimit;
use rt_core::port::DeviceCapabilities;

use super::wall::Wall;

/// Directions along the axes.
pub(super) const AXES: [[&str; 2]; 3] = [["+x", "-x"], ["+y", "-y"], ["+z", "-z"]];
/// Speed of the tremor for which dry friction is counted as damping, m/s (PROTOCOL.md).
pub const TREMOR_M_S: f64 = 0.2;
/// Relative difference up to which a measured and a declared value count as equal.
const DIFFERS: f64 = 0.1;
/// Difference up to which two delays count as equal, s.
const DELAY_DIFFERS_S: f64 = 0.2e-3;
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
    /// A slow and a fast part of a chirp.
    pub chirp: [Trace; 2],
    /// A handle that runs out after a push.
    pub run_out: Trace,
}

impl Axis {
    /// Damping as our serial protocol defines it: viscous damping plus a share of the dry friction.
    #[must_use]
    pub fn tremor_damping_n_s_m(&self) -> Estimate {
        let share = 4.0 / (std::f64::consts::PI * TREMOR_M_S);
        let (viscous, dry) = (self.damping_n_s_m, self.friction_n);
        // An error in one of them changes the other in the opposite direction, so this bound is
        // generous.
        Estimate {
            value: viscous.value + share * dry.value,
            error: viscous.error.hypot(share * dry.error),
        }
    }
}

/// Results of all axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Characterised {
    /// Capabilities that the device declares.
    pub declared: DeviceCapabilities,
    /// Largest force that was used, N.
    pub force_n: f64,
    /// Results of the axes x, y, z. `None`: the axis was not asked for. A text: the reason for
    /// which nothing could be measured.
    pub axes: [Option<Result<Axis, String>>; 3],
    /// Time from a command to the sample that confirms the command, s, if the device's protocol has
    /// such samples.
    pub echo_s: Option<f64>,
    /// Result of the virtual wall.
    pub wall: Option<Wall>,
}

impl Characterised {
    /// Axes that were measured, with their indices.
    pub fn measured(&self) -> impl Iterator<Item = (usize, &Axis)> {
        let measured = |axis: &'_ Option<Result<Axis, String>>| matches!(axis, Some(Ok(_)));
        let axes = self
            .axes
            .iter()
            .enumerate()
            .filter(move |it| measured(it.1));
        axes.filter_map(|(at, axis)| Some((at, axis.as_ref()?.as_ref().ok()?)))
    }

    /// Least damping of all axes, which limits the stiffness.
    #[must_use]
    pub fn damping_n_s_m(&self) -> Option<Estimate> {
        let dampings = self.measured().map(|(_, axis)| axis.tremor_damping_n_s_m());
        dampings.min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Longest delay of all axes.
    #[must_use]
    pub fn delay_s(&self) -> Option<Estimate> {
        let delays = self.measured().map(|(_, axis)| axis.delay_s);
        delays.max_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Stiffest contact that Calot renders by the measured values, N/m.
    #[must_use]
    pub fn rendered_n_m(&self) -> Option<f64> {
        let (damping, delay) = (self.damping_n_s_m()?, self.delay_s()?);
        Some(rendered_n_m(
            damping.value,
            delay.value,
            self.declared.rate_hz,
        ))
    }

    /// Comparisons with the declared values, in words.
    #[must_use]
    pub fn verdicts(&self) -> Vec<String> {
        let mut said = Vec::new();
        said.extend(self.delay_verdict());
        said.extend(self.damping_verdict());
        said.extend(self.echo_verdict());
        said.extend(self.wall_verdict());
        for (at, axis) in self.measured() {
            let (breaks, runs) = (axis.break_away_n.value, axis.friction_n.value);
            if breaks > STICKS * runs + 0.02 {
                said.push(format!(
                    "{}: it sticks. {breaks:.2} N move it, {runs:.2} N keep it moving: slow movements will \
                     jerk. Look for a hinge or a capstan that binds",
                    ["x", "y", "z"][at]
                ));
            }
        }
        said
    }

    fn delay_verdict(&self) -> Option<String> {
        let delay = self.delay_s()?;
        let (measured, declared) = (delay.value, f64::from(self.declared.delay_s));
        let noise_s = (DIFFERS * declared)
            .max(DELAY_DIFFERS_S)
            .max(2.0 * delay.error);
        let (said, measured_ms) = (declared * 1e3, measured * 1e3);
        Some(if measured > declared + noise_s {
            format!(
                "declares {said:.1} ms delay, measured {measured_ms:.1} ms: contacts will be rendered too \
                 stiff and may buzz"
            )
        } else if measured < declared - noise_s {
            format!(
                "declares {said:.1} ms delay, measured {measured_ms:.1} ms: safe, but contacts are rendered \
                 softer than they could be"
            )
        } else {
            format!("declares {said:.1} ms delay, measured {measured_ms:.1} ms: they agree")
        })
    }

    fn damping_verdict(&self) -> Option<String> {
        let damping = self.damping_n_s_m()?;
        let (measured, declared) = (damping.value, f64::from(self.declared.damping_n_s_m));
        let noise = (DIFFERS * declared).max(2.0 * damping.error);
        let said = format!("declares {declared:.2} N s/m damping, measured {measured:.2} N s/m");
        Some(if measured < declared - noise {
            format!("{said}: contacts will be rendered too stiff and may buzz")
        } else if measured > declared + noise {
            format!("{said}: safe, but contacts are rendered softer than they could be")
        } else {
            format!("{said}: they agree")
        })
    }

    fn echo_verdict(&self) -> Option<String> {
        let echo_s = self.echo_s?;
        let declared = f64::from(self.declared.delay_s);
        // A delay of less than half of the round-trip time is not possible.
        (declared < 0.5 * echo_s).then(|| {
            format!(
                "declares {:.1} ms delay, but a command is confirmed only after {:.1} ms: the declared \
                 delay cannot be true",
                declared * 1e3,
                echo_s * 1e3
            )
        })
    }

    fn wall_verdict(&self) -> Option<String> {
        let wall = self.wall.as_ref()?;
        let declared = f64::from(self.declared.stiffness_max_n_m);
        match (wall.still_n_m, wall.buzzes_n_m) {
            (Some(still), None) if wall.was_left => Some(format!(
                "walls are still up to {still:.0} N/m; stiffer ones were not pressed"
            )),
            (None, None) => Some("the wall was not pressed: no stiffness was measured".to_owned()),
            (None, Some(buzzes)) => Some(format!("even a wall of {buzzes:.0} N/m buzzes")),
            (Some(still), None) => Some(format!("no wall buzzed, up to {still:.0} N/m")),
            (Some(still), Some(buzzes)) if declared > still => Some(format!(
                "declares {declared:.0} N/m, a wall of {buzzes:.0} N/m buzzes and one of {still:.0} N/m is \
                 still: declare less"
            )),
            (Some(still), Some(_)) => Some(format!(
                "declares {declared:.0} N/m, walls are still up to {still:.0} N/m: that holds"
            )),
        }
    }

    /// Lines for the section `[haptic]` of the station file: measured values with a margin of two
    /// standard errors.
    #[must_use]
    pub fn station_lines(&self) -> String {
        let mut lines = String::new();
        if let (Some(damping), Some(delay)) = (self.damping_n_s_m(), self.delay_s()) {
            let damping = (damping.value - 2.0 * damping.error).max(0.0);
            let delay_s = (delay.value + 2.0 * delay.error).min(0.05);
            lines += &format!("damping_n_s_m = {damping:.3}\ndelay_s = {delay_s:.5}\n");
        }
        // A wall that did not buzz says nothing about stiffer ones.
        let buzzing = self.wall.as_ref().filter(|it| it.buzzes_n_m.is_some());
        let still = buzzing.and_then(|it| it.still_n_m);
        if let Some(still) = still.filter(|it| *it < f64::from(self.declared.stiffness_max_n_m)) {
            lines += &format!("stiffness_max_n_m = {still:.0}\n");
        }
        lines
    }
}

/// Stiffest contact that Calot renders on a device of this damping, delay and rate, N/m: a share of
/// `K = b / (T/2 + delay)`. The output limit of `rt-core` itself computes it.
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
