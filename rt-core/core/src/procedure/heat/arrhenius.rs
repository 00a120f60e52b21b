//! Thermal damage: the Arrhenius sum of Henriques and Moritz.
//!
//! `Ω = ∫ A exp(−E / (R T)) dt` with `A = 3.1e98 1/s` and `E = 628 kJ/mol` (F. C. Henriques, Arch
//! Pathol 43, 1947). At `Ω = 1` proteins of 63 % of the tissue are denatured. Tissue at 60 °C
//! reaches `Ω = 1` in about a second, at 55 °C in half a minute, at 50 °C in a quarter of an hour.

/// Natural logarithm of `A`, 1/s.
const LN_RATE: f32 = 226.782;
/// `E / R`, K.
const ACTIVATION_K: f32 = 75_535.0;
/// Temperature of the body, K.
const BODY_K: f32 = 310.15;
/// Largest sum that is kept. Tissue is destroyed long before.
const SUM_MAX: f32 = 1.0e4;
/// Largest exponent of a rate. Above it, tissue is destroyed within a millisecond.
const EXPONENT_MAX: f32 = 8.0;

/// Sum after `seconds` at `rise_k` above the temperature of the body.
pub(super) fn sum_after(sum: f32, rise_k: f32, seconds: f32) -> f32 {
    let exponent = LN_RATE - ACTIVATION_K / (BODY_K + rise_k.max(0.0));
    (sum + exp(exponent.min(EXPONENT_MAX)) * seconds).min(SUM_MAX)
}

/// `e` to the power `x`, for `x` up to 80. The core calls no maths library, so that every build
/// gives the same bits.
fn exp(x: f32) -> f32 {
    if x < -80.0 {
        return 0.0;
    }
    let twos = x.min(80.0) * core::f32::consts::LOG2_E;
    let whole = (twos + if twos < 0.0 { -0.5 } else { 0.5 }) as i32; // `as` truncates
    let rest = (twos - whole as f32) * core::f32::consts::LN_2;
    // Taylor's series up to the sixth power. `rest` lies within 0.35 of 0.
    let series = [720.0, 120.0, 24.0, 6.0, 2.0, 1.0]
        .iter()
        .fold(0.0, |sum, factorial| sum * rest + 1.0 / factorial);
    // The fold ends with the coefficient of `rest`. The last line adds the constant of the series.
    let power_of_two = f32::from_bits(((whole + 127).clamp(1, 254) as u32) << 23);
    (series * rest + 1.0) * power_of_two
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn exponential_is_accurate_to_one_in_100_000() {
        for step in -790..=790 {
            let x = step as f32 * 0.1;
            let exact = f64::from(x).exp();
            let relative = (f64::from(exp(x)) - exact).abs() / exact;
            // The rounding of `x / ln 2` alone costs 80 parts in 2^24.
            assert!(relative < 1.0e-5, "{x}: {relative}");
        }
        assert!(exp(-200.0) <= 0.0);
    }

    #[test]
    fn times_to_destroy_tissue_are_those_of_the_law() {
        let seconds_to_destroy = |celsius: f32| {
            let rate = sum_after(0.0, celsius - 37.0, 1.0);
            1.0 / rate
        };
        assert!((0.5..2.0).contains(&seconds_to_destroy(60.0)));
        assert!((15.0..60.0).contains(&seconds_to_destroy(55.0)));
        assert!((500.0..1800.0).contains(&seconds_to_destroy(50.0)));
        assert!(seconds_to_destroy(37.0) > 1.0e6);
        assert!(sum_after(0.0, 1.0e9, 1.0e9) <= SUM_MAX);
    }
}
