//! Prediction of the room between the hook and a structure. When tissue gives way, the room shrinks
//! faster than the surgeon sees the picture and moves the hand.

/// Delay of picture and hand together, s.
const LATE_S: f64 = 0.05;
/// Largest assumed speed of approach, m/s.
const SPEED_MAX_M_S: f64 = 0.15;
/// A larger room counts as this, m.
const FAR_M: f64 = 0.1;
/// Weight of a new sample in the smoothed speed.
const BELIEVED: f64 = 0.7;

/// Estimate of the rate at which the room changes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Nearing {
    last_m: Option<f64>,
    speed_m_s: f64,
}

impl Nearing {
    /// Predicted room at the time when the hand can react, m. `seconds` is the time since the
    /// previous call.
    pub(crate) fn soon(&mut self, room_m: f64, seconds: f64) -> f64 {
        let room_m = room_m.min(FAR_M);
        if let Some(last_m) = self.last_m.filter(|_| seconds > 0.0) {
            let speed_m_s = (room_m - last_m) / seconds;
            self.speed_m_s += BELIEVED * (speed_m_s - self.speed_m_s);
        }
        self.last_m = Some(room_m);
        room_m + self.speed_m_s.clamp(-SPEED_MAX_M_S, 0.0) * LATE_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn approach_is_foreseen_and_retreat_is_not() {
        let mut nearing = Nearing::default();
        let mut soon_m = 0.0;
        for look in 0..20 {
            soon_m = nearing.soon(0.01 - 0.0001 * f64::from(look), 0.005);
        }
        assert!(
            (soon_m - (0.0081 - 0.02 * LATE_S)).abs() < 1.0e-5,
            "{soon_m}"
        );
        for look in 0..20 {
            soon_m = nearing.soon(0.01 + 0.0001 * f64::from(look), 0.005);
        }
        assert!((soon_m - 0.0119).abs() < 1.0e-9, "{soon_m}");
        assert!(nearing.soon(f64::MAX, 0.005).is_finite());
    }
}
