//! Results of a characterisation, their comparison with what the device declares, and the lines of
//! a station file.

use rt_core::port::DeviceCapabilities;

use super::along::{Axis, Estimate, rendered_n_m};
use super::opened::Opened;
use super::wall::Wall;

/// Relative difference up to which a measured and a declared value count as equal.
const DIFFERS: f64 = 0.1;
/// Difference up to which two delays count as equal, s.
const DELAY_DIFFERS_S: f64 = 0.2e-3;

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
    /// Time from a command to the sample that confirms the command, s. `None` if the device's
    /// protocol has no such samples.
    pub echo_s: Option<f64>,
    /// Result of the virtual wall.
    pub wall: Option<Wall>,
    /// Result along the opening. `None`: it was not asked for, or the handle does not open. A text:
    /// the reason for which nothing could be measured.
    pub opening: Option<Result<Opened, String>>,
    /// Result of the virtual wall along the opening.
    pub opening_wall: Option<Wall>,
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

    /// Stiffest contact that Calot renders with the measured values, N/m.
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
        let most_n_m = f64::from(self.declared.stiffness_max_n_m);
        said.extend(self.wall.as_ref().map(|it| wall_verdict(it, most_n_m)));
        for (at, axis) in self.measured() {
            said.extend(axis.sticking_verdict(["x", "y", "z"][at]));
        }
        if let Some(Ok(opened)) = &self.opening {
            said.extend(opened.verdicts(&self.declared));
        }
        let wall = self.opening_wall.as_ref();
        let most_n_m = f64::from(self.declared.opening.stiffness_max_n_m);
        said.extend(wall.map(|it| format!("opening: {}", wall_verdict(it, most_n_m))));
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

/// Comparison of the stiffness that a device declares, N/m, with the walls, in words.
fn wall_verdict(wall: &Wall, declared: f64) -> String {
    match (wall.still_n_m, wall.buzzes_n_m) {
        (Some(still), None) if wall.was_left => {
            format!("no wall buzzed, up to {still:.0} N/m; stiffer walls were not pressed")
        }
        (None, None) => "the wall was not pressed: no stiffness was measured".to_owned(),
        (None, Some(buzzes)) => format!("even a wall of {buzzes:.0} N/m buzzes"),
        (Some(still), None) => format!("no wall buzzed, up to {still:.0} N/m"),
        (Some(still), Some(buzzes)) if declared > still => format!(
            "declares {declared:.0} N/m, a wall of {buzzes:.0} N/m buzzes and one of {still:.0} N/m does \
             not: declare less"
        ),
        (Some(still), Some(_)) => {
            format!("declares {declared:.0} N/m, no wall buzzes up to {still:.0} N/m: that holds")
        }
    }
}
