//! Results along the opening of a handle, and their comparison with what the device declares.

use rt_core::port::DeviceCapabilities;

use super::along::{Axis, rendered_n_m};

/// Distance of an end from 0 or 1 above which the verdict says that the handle does not use its
/// declared travel. The test by hand (`feel`) allows 0.2, because there fingers move the handle.
const END: f64 = 0.05;
/// Largest difference between the ratios of a large and of a small force that counts as no
/// difference: the accuracy of the measurement.
const RATIO_NOISE: f64 = 0.1;

/// Results along the opening.
#[derive(Debug, Clone, PartialEq)]
pub struct Opened {
    /// Results as along the other axes. Positions are in m from half open.
    pub axis: Axis,
    /// Opening at both ends, 0 to 1: shut and wide open.
    pub range: [f64; 2],
    /// Pairs of a commanded force, N, and the ratio of the rendered to the commanded force, from
    /// small to large forces. The ratios are relative to the model, which fits all forces together.
    pub given: Vec<[f64; 2]>,
}

impl Opened {
    /// Ratio of the largest force divided by the ratio of the smallest force; and the largest
    /// force, N.
    #[must_use]
    pub fn largest(&self) -> Option<(f64, f64)> {
        let (small, large) = (self.given.first()?, self.given.last()?);
        (large[0] > small[0]).then(|| (large[1] / small[1], large[0]))
    }

    /// Comparisons with the declared values, in words.
    pub(super) fn verdicts(&self, declared: &DeviceCapabilities) -> Vec<String> {
        let mut said = vec![self.range_verdict(declared)];
        said.extend(self.force_verdict(declared));
        said.push(self.stiffness_verdict(declared));
        said.extend(self.axis.sticking_verdict("opening"));
        said
    }

    fn range_verdict(&self, declared: &DeviceCapabilities) -> String {
        let [shut, open] = self.range;
        let travel_mm = f64::from(declared.opening.travel_m) * 1e3;
        let said = format!(
            "opening: reports {shut:.2} shut and {open:.2} wide open, {:.1} mm of the declared \
             {travel_mm:.1} mm",
            (open - shut) * travel_mm
        );
        if shut > END || open < 1.0 - END {
            format!(
                "{said}: ends or travel are wrong, or the handle binds. The jaws will not shut or open fully"
            )
        } else {
            said
        }
    }

    fn force_verdict(&self, declared: &DeviceCapabilities) -> Option<String> {
        let (share, largest_n) = self.largest()?;
        let peak_n = declared.opening.force_max_n;
        let rest = "Movements do not show absolute forces: a scale or a sensor does, in `calot devices feel`";
        Some(if share < 1.0 - RATIO_NOISE {
            format!(
                "opening: of {largest_n:.2} N the motor renders only {share:.2} times what small forces promise: \
                 the motor does not reach the declared {peak_n:.1} N. Measure again with a smaller --force, \
                 because this force spoils mass and damping"
            )
        } else {
            format!(
                "opening: forces up to {largest_n:.2} N are as large as small ones promise ({share:.2} \
                 times), of {peak_n:.1} N declared. {rest}"
            )
        })
    }

    fn stiffness_verdict(&self, declared: &DeviceCapabilities) -> String {
        let bears_n_m = rendered_n_m(
            self.axis.tremor_damping_n_s_m().value,
            self.axis.delay_s.value,
            declared.rate_hz,
        );
        let said_n_m = f64::from(declared.opening.stiffness_max_n_m);
        let said = format!(
            "opening: declares {said_n_m:.0} N/m, its own damping and delay allow {bears_n_m:.0} N/m"
        );
        if said_n_m > bears_n_m {
            format!("{said}: fingers must damp the rest. Test it with --wall")
        } else {
            format!("{said}: that holds")
        }
    }
}
