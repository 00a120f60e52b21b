//! Random numbers that are the same everywhere.

/// `SplitMix64` (Steele, Lea and Flood 2014): the same seed gives the same numbers.
#[derive(Debug, Clone)]
pub(super) struct Random(u64);

impl Random {
    pub(super) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number from 0 to below 1.
    pub(super) fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }

    /// One of the choices, each as often as its weight says.
    pub(super) fn choose<T: Copy>(&mut self, choices: &[(T, f64)]) -> Option<T> {
        let mut left = self.share() * choices.iter().map(|(_, weight)| weight).sum::<f64>();
        let found = choices.iter().find(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        found.or(choices.last()).map(|(choice, _)| *choice)
    }
}
