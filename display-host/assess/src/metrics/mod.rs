//! Metrics of an operation ([`Metric`] defines them), and a set of their values.

mod definition;

use serde::ser::SerializeMap as _;

pub use self::definition::Metric;

/// A value for each metric; NaN for a metric that was not measured.
#[derive(Debug, Clone, Copy)]
pub struct Values([f64; Metric::ALL.len()]);

impl Values {
    pub(crate) fn none() -> Self {
        Self([f64::NAN; Metric::ALL.len()])
    }

    /// Value of a metric, or NaN.
    #[must_use]
    pub fn get(&self, metric: Metric) -> f64 {
        self.0.get(metric as usize).copied().unwrap_or(f64::NAN)
    }

    pub(crate) fn set(&mut self, metric: Metric, value: f64) {
        if let Some(slot) = self.0.get_mut(metric as usize) {
            *slot = value;
        }
    }
}

impl PartialEq for Values {
    /// Compares bits, so a NaN equals a NaN with the same bits.
    fn eq(&self, other: &Self) -> bool {
        self.0.map(f64::to_bits) == other.0.map(f64::to_bits)
    }
}

impl serde::Serialize for Values {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(Metric::ALL.len()))?;
        for metric in Metric::ALL {
            let value = Some(self.get(metric)).filter(|value| value.is_finite());
            map.serialize_entry(metric.name(), &value)?;
        }
        map.end()
    }
}
