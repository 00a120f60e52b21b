//! Three coordinates and a spare lane, which compilers keep in one vector register.

use core::ops::{Add, Mul, Sub};

use crate::math::Vec3;

/// x, y, z and a spare lane. Adds, subtracts and multiplies lane by lane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(16))]
pub struct Lanes([f32; 4]);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; 4]);

    /// `v`, with `spare` in the fourth lane.
    #[must_use]
    #[inline(always)]
    pub const fn new(v: &Vec3, spare: f32) -> Self {
        let [x, y, z] = v.data.0[0];
        Self([x, y, z, spare])
    }

    /// From x, y, z and the spare lane.
    #[inline(always)]
    pub(crate) const fn from_array(lanes: [f32; 4]) -> Self {
        Self(lanes)
    }

    /// x, y, z and the spare lane, by reference.
    #[inline(always)]
    pub(crate) const fn as_array(&self) -> &[f32; 4] {
        &self.0
    }

    /// x, y, z and the spare lane.
    #[inline(always)]
    pub(crate) const fn to_array(self) -> [f32; 4] {
        self.0
    }

    /// Bits of the four lanes, two in each word.
    #[inline(always)]
    pub(crate) const fn to_bits(self) -> [u64; 2] {
        let [x, y, z, spare] = self.0;
        [pair(x, y), pair(z, spare)]
    }

    /// `x` in all four lanes.
    #[must_use]
    #[inline(always)]
    pub const fn splat(x: f32) -> Self {
        Self([x; 4])
    }

    /// x, y and z.
    #[must_use]
    #[inline(always)]
    pub const fn vec3(self) -> Vec3 {
        let [x, y, z, _] = self.0;
        Vec3::new(x, y, z)
    }

    /// The spare lane.
    #[must_use]
    #[inline(always)]
    pub const fn spare(self) -> f32 {
        let [.., spare] = self.0;
        spare
    }

    /// Replaces the spare lane.
    #[must_use]
    #[inline(always)]
    pub const fn with_spare(self, spare: f32) -> Self {
        let [x, y, z, _] = self.0;
        Self([x, y, z, spare])
    }

    /// x, y and z times `factor`; a finite spare lane becomes zero.
    #[must_use]
    #[inline(always)]
    pub fn scaled(self, factor: f32) -> Self {
        self * Self([factor, factor, factor, 0.0])
    }

    /// Lane-wise minimum; the lane of `other` if either lane is NaN.
    #[must_use]
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        let min = |x: f32, y: f32| if x < y { x } else { y };
        Self([min(a, e), min(b, f), min(c, g), min(d, h)])
    }

    /// Lane-wise maximum; the lane of `other` if either lane is NaN.
    #[must_use]
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        let max = |x: f32, y: f32| if x > y { x } else { y };
        Self([max(a, e), max(b, f), max(c, g), max(d, h)])
    }

    /// Squared length of x, y, z.
    #[must_use]
    #[inline(always)]
    pub fn norm_squared(self) -> f32 {
        let [x, y, z, _] = (self * self).0;
        x + y + z
    }
}

#[inline(always)]
const fn pair(a: f32, b: f32) -> u64 {
    a.to_bits() as u64 | (b.to_bits() as u64) << 32
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a + e, b + f, c + g, d + h])
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a - e, b - f, c - g, d - h])
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a * e, b * f, c * g, d * h])
    }
}
