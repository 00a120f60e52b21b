//! Vectors of eight numbers: in plain arrays, and in AVX registers. Both do equal operations in
//! equal order and never fuse two of them, so they give equal bits.

use crate::scene::LANES;
use crate::tissue::lanes::Lanes;

/// Eight `f32`, lane by lane.
pub(super) trait Wide: Copy {
    /// One value in every lane.
    fn splat(x: f32) -> Self;
    /// Reads from memory.
    fn load(x: &[f32; LANES]) -> Self;
    /// Writes to memory.
    fn store(self) -> [f32; LANES];
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    /// True if any lane is below the lane of `other`.
    fn any_below(self, other: Self) -> bool;
    /// Transposes eight rows of four into four columns of eight.
    fn columns(rows: [&Lanes; LANES]) -> [Self; 4];
    /// Transposes three columns of eight, and a column of zeros, into eight rows of four.
    fn rows(columns: [Self; 3]) -> [Lanes; LANES];
}

/// Plain arrays, which every processor has.
#[derive(Clone, Copy)]
pub(super) struct Plain([f32; LANES]);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let [a, b, c, d, e, g, h, i] = self.0;
        let [j, k, l, m, n, o, p, q] = other.0;
        Self([
            f(a, j),
            f(b, k),
            f(c, l),
            f(d, m),
            f(e, n),
            f(g, o),
            f(h, p),
            f(i, q),
        ])
    }
}

impl Wide for Plain {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn load(x: &[f32; LANES]) -> Self {
        Self(*x)
    }

    #[inline(always)]
    fn store(self) -> [f32; LANES] {
        self.0
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }

    /// As the processor's instruction: takes `other` if either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn any_below(self, other: Self) -> bool {
        self.0.iter().zip(&other.0).any(|(a, b)| a < b)
    }

    #[inline(always)]
    fn columns(rows: [&Lanes; LANES]) -> [Self; 4] {
        let rows = rows.map(|row| row.to_array());
        [
            Self(rows.map(|[x, ..]| x)),
            Self(rows.map(|[_, y, ..]| y)),
            Self(rows.map(|[_, _, z, _]| z)),
            Self(rows.map(|[.., w]| w)),
        ]
    }

    #[inline(always)]
    fn rows([x, y, z]: [Self; 3]) -> [Lanes; LANES] {
        let mut rows = [Lanes::ZERO; LANES];
        let columns = x.0.into_iter().zip(y.0).zip(z.0);
        for (row, ((x, y), z)) in rows.iter_mut().zip(columns) {
            *row = Lanes::from_array([x, y, z, 0.0]);
        }
        rows
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx::Avx;

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)] // the processor's own instructions; each block says why it may
mod avx {
    use core::arch::x86_64::*;

    use super::Wide;
    use crate::scene::LANES;
    use crate::tissue::lanes::Lanes;

    /// One register. Only code that runs after AVX has been found creates values of this type: see
    /// `kernel::project_avx`.
    #[derive(Clone, Copy)]
    pub(in crate::tissue::neo_hookean) struct Avx(__m256);

    impl Wide for Avx {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: runs only where AVX has been found (type's promise).
            Self(unsafe { _mm256_set1_ps(x) })
        }

        #[inline(always)]
        fn load(x: &[f32; LANES]) -> Self {
            // SAFETY: AVX as above; reads exactly the eight numbers behind the reference,
            // unaligned.
            Self(unsafe { _mm256_loadu_ps(x.as_ptr()) })
        }

        #[inline(always)]
        fn store(self) -> [f32; LANES] {
            let mut x = [0.0; LANES];
            // SAFETY: AVX as above; writes exactly the eight numbers of the array, unaligned.
            unsafe { _mm256_storeu_ps(x.as_mut_ptr(), self.0) };
            x
        }

        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: AVX as above.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: AVX as above.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: AVX as above.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn div(self, other: Self) -> Self {
            // SAFETY: AVX as above.
            Self(unsafe { _mm256_div_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: AVX as above.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn any_below(self, other: Self) -> bool {
            // SAFETY: AVX as above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) != 0 }
        }

        #[inline(always)]
        fn columns(rows: [&Lanes; LANES]) -> [Self; 4] {
            let [a, b, c, d, e, f, g, h] = rows;
            let (ae, bf) = (pair(a, e), pair(b, f));
            let (cg, dh) = (pair(c, g), pair(d, h));
            // SAFETY: AVX as above.
            unsafe {
                let (xy_low, zw_low) = (_mm256_unpacklo_ps(ae, bf), _mm256_unpackhi_ps(ae, bf));
                let (xy_high, zw_high) = (_mm256_unpacklo_ps(cg, dh), _mm256_unpackhi_ps(cg, dh));
                [
                    Self(_mm256_shuffle_ps::<0b01_00_01_00>(xy_low, xy_high)),
                    Self(_mm256_shuffle_ps::<0b11_10_11_10>(xy_low, xy_high)),
                    Self(_mm256_shuffle_ps::<0b01_00_01_00>(zw_low, zw_high)),
                    Self(_mm256_shuffle_ps::<0b11_10_11_10>(zw_low, zw_high)),
                ]
            }
        }

        #[inline(always)]
        fn rows([x, y, z]: [Self; 3]) -> [Lanes; LANES] {
            // SAFETY: AVX as above.
            unsafe {
                let w = _mm256_setzero_ps();
                let (xy_low, xy_high) =
                    (_mm256_unpacklo_ps(x.0, y.0), _mm256_unpackhi_ps(x.0, y.0));
                let (zw_low, zw_high) = (_mm256_unpacklo_ps(z.0, w), _mm256_unpackhi_ps(z.0, w));
                let [a, e] = split(_mm256_shuffle_ps::<0b01_00_01_00>(xy_low, zw_low));
                let [b, f] = split(_mm256_shuffle_ps::<0b11_10_11_10>(xy_low, zw_low));
                let [c, g] = split(_mm256_shuffle_ps::<0b01_00_01_00>(xy_high, zw_high));
                let [d, h] = split(_mm256_shuffle_ps::<0b11_10_11_10>(xy_high, zw_high));
                [a, b, c, d, e, f, g, h]
            }
        }
    }

    #[inline(always)]
    fn pair(low: &Lanes, high: &Lanes) -> __m256 {
        // SAFETY: AVX as above; reads the four numbers of each, unaligned.
        unsafe { _mm256_loadu2_m128(high.as_array().as_ptr(), low.as_array().as_ptr()) }
    }

    #[inline(always)]
    fn split(both: __m256) -> [Lanes; 2] {
        let (mut low, mut high) = ([0.0; 4], [0.0; 4]);
        // SAFETY: AVX as above; writes the four numbers of each, unaligned.
        unsafe { _mm256_storeu2_m128(high.as_mut_ptr(), low.as_mut_ptr(), both) };
        [Lanes::from_array(low), Lanes::from_array(high)]
    }
}
