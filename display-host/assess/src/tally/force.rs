//! Distribution of the force on the hand over time.

/// Width of a bin of the force histogram, N.
pub const BIN_N: f64 = 0.05;
/// Number of bins. The last one takes all greater forces.
const BINS: usize = 240;
/// Share of a device's greatest force from which on the device counts as saturated.
const SATURATED: f64 = 0.97;

/// Time at each force while the instrument touched something, and other sums of the force.
#[derive(Debug, Clone)]
pub(crate) struct Force {
    seconds: [f64; BINS],
    pub(crate) max_n: f64,
    impulse_ns: f64,
    pub(crate) saturated_s: f64,
    /// Greatest force of the device, N; 0: unknown.
    device_n: f64,
}

impl Default for Force {
    fn default() -> Self {
        Self {
            seconds: [0.0; BINS],
            max_n: 0.0,
            impulse_ns: 0.0,
            saturated_s: 0.0,
            device_n: 0.0,
        }
    }
}

impl Force {
    pub(crate) fn device(&mut self, force_max_n: f64) {
        self.device_n = force_max_n;
    }

    pub(crate) fn step(&mut self, force_n: f64, touches: bool, seconds: f64) {
        self.max_n = self.max_n.max(force_n);
        if self.device_n > 0.0 && force_n >= SATURATED * self.device_n {
            self.saturated_s += seconds;
        }
        if touches {
            let bin = ((force_n / BIN_N) as usize).min(BINS - 1);
            if let Some(bin) = self.seconds.get_mut(bin) {
                *bin += seconds;
            }
            self.impulse_ns += force_n * seconds;
        }
    }

    fn touched_s(&self) -> f64 {
        self.seconds.iter().sum()
    }

    pub(crate) fn mean_n(&self) -> f64 {
        self.impulse_ns / self.touched_s()
    }

    /// Upper end of the bin that contains this quantile of the time, but not above the greatest
    /// force, N.
    pub(crate) fn quantile_n(&self, share: f64) -> f64 {
        let wanted_s = share * self.touched_s();
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

    /// Starts over for a new attempt on the same device.
    pub(crate) fn again(&self) -> Self {
        Self {
            device_n: self.device_n,
            ..Self::default()
        }
    }
}
