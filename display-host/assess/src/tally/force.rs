//! Histogram of the force on the hand: how long each force acted.

/// Width of a bin of the force histogram, N.
pub const BIN_N: f64 = 0.05;
/// Number of bins. The last bin also takes every greater force.
const BINS: usize = 240;
/// A device counts as saturated at this share of its greatest force, or more.
const SATURATED: f64 = 0.97;

/// Statistics of the force on the hand. Histogram and mean count the time in contact only; the
/// greatest force and the saturated time always count.
#[derive(Debug, Clone)]
pub(crate) struct Force {
    seconds: [f64; BINS],
    pub(crate) max_n: f64,
    impulse_n_s: f64,
    pub(crate) saturated_s: f64,
    /// Greatest force of the device, N; 0: unknown.
    device_n: f64,
}

impl Default for Force {
    fn default() -> Self {
        Self {
            seconds: [0.0; BINS],
            max_n: 0.0,
            impulse_n_s: 0.0,
            saturated_s: 0.0,
            device_n: 0.0,
        }
    }
}

impl Force {
    pub(crate) fn device(&mut self, force_max_n: f64) {
        self.device_n = force_max_n;
    }

    /// Counts `seconds` at this force.
    pub(crate) fn step(&mut self, force_n: f64, is_in_contact: bool, seconds: f64) {
        self.max_n = self.max_n.max(force_n);
        if self.device_n > 0.0 && force_n >= SATURATED * self.device_n {
            self.saturated_s += seconds;
        }
        if is_in_contact {
            let bin = ((force_n / BIN_N) as usize).min(BINS - 1);
            if let Some(bin) = self.seconds.get_mut(bin) {
                *bin += seconds;
            }
            self.impulse_n_s += force_n * seconds;
        }
    }

    /// Time in contact, s.
    fn contact_s(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Mean force in contact, N; NaN without contact.
    pub(crate) fn mean_n(&self) -> f64 {
        self.impulse_n_s / self.contact_s()
    }

    /// Quantile of the force, weighted by the time in contact and rounded up to the end of its bin,
    /// but not above the greatest force, N. NaN without contact.
    pub(crate) fn quantile_n(&self, share: f64) -> f64 {
        let wanted_s = share * self.contact_s();
        let mut sum_s = 0.0;
        let bin = self.seconds.iter().position(|seconds| {
            sum_s += seconds;
            sum_s >= wanted_s && sum_s > 0.0
        });
        bin.map_or(f64::NAN, |bin| ((bin + 1) as f64 * BIN_N).min(self.max_n))
    }

    /// Time in each bin, without the empty bins at the end, s.
    pub(crate) fn histogram(&self) -> Vec<f64> {
        let used = self.seconds.iter().rposition(|s| *s > 0.0);
        self.seconds
            .get(..used.map_or(0, |last| last + 1))
            .unwrap_or_default()
            .to_vec()
    }

    /// An empty tally for the next attempt with the same device.
    pub(crate) fn again(&self) -> Self {
        Self {
            device_n: self.device_n,
            ..Self::default()
        }
    }
}
