//! Reading of a kitchen scale, as a person types it.

/// Weight of a gram, N.
const GRAM_N: f32 = 9.81e-3;

/// Weight of the grams that were typed, N. `None`: the text is no number.
pub(super) fn weight_n(grams: &str) -> Option<f32> {
    let grams: f32 = grams.trim().replace(',', ".").parse().ok()?;
    grams.is_finite().then_some(grams * GRAM_N)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grams_are_typed_with_a_comma_or_a_point() {
        for (typed, newton) in [("51", 0.50031), ("51,5 ", 0.505_215), ("51.5", 0.505_215)] {
            let weight_n = weight_n(typed).expect(typed);
            assert!((weight_n - newton).abs() < 1e-6, "{typed}: {weight_n}");
        }
        for wrong in ["", "heavy", "nan", "inf", "51 g"] {
            assert_eq!(weight_n(wrong), None, "{wrong}");
        }
    }
}
