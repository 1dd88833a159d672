//! Vectors of particles: one trait, one type per instruction set.
//!
//! The kernels are written once over [`Lanes`] and compiled once per instruction set, inside
//! functions that enable it; `dispatch` calls only those that the processor has. That is what makes
//! the intrinsics below sound.

/// A vector of f64, one particle per lane.
pub trait Lanes: Copy {
    const WIDTH: usize;
    fn splat(x: f64) -> Self;
    /// The first [`Self::WIDTH`] numbers of `x`.
    fn load(x: &[f64]) -> Self;
    fn store(self, x: &mut [f64]);
    fn sub(self, b: Self) -> Self;
    fn add(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    /// self * b + c, rounded once where the processor can.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// c - self * b.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
}

/// One particle at a time, for processors without any of the others.
impl Lanes for f64 {
    const WIDTH: usize = 1;
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn load(x: &[f64]) -> Self {
        x[0]
    }
    #[inline(always)]
    fn store(self, x: &mut [f64]) {
        x[0] = self;
    }
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self - b
    }
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        self + b
    }
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        self * b
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        c - self * b
    }
}

/// Implements [`Lanes`] by intrinsics.
macro_rules! by_intrinsics {
    ($type:ident, $width:literal, $splat:ident, $load:ident, $store:ident, $sub:ident, $add:ident,
     $mul:ident, $mul_add:expr, $neg_mul_add:expr) => {
        impl Lanes for $type {
            const WIDTH: usize = $width;
            #[inline(always)]
            fn splat(x: f64) -> Self {
                // SAFETY: as said at the head of this file, for all of these.
                unsafe { $splat(x) }
            }
            #[inline(always)]
            fn load(x: &[f64]) -> Self {
                let x = &x[..$width];
                // SAFETY: and `x` has that many numbers.
                unsafe { $load(x.as_ptr()) }
            }
            #[inline(always)]
            fn store(self, x: &mut [f64]) {
                let x = &mut x[..$width];
                // SAFETY: and `x` has room for that many numbers.
                unsafe { $store(x.as_mut_ptr(), self) }
            }
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                // SAFETY: see splat.
                unsafe { $sub(self, b) }
            }
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                // SAFETY: see splat.
                unsafe { $add(self, b) }
            }
            #[inline(always)]
            fn mul(self, b: Self) -> Self {
                // SAFETY: see splat.
                unsafe { $mul(self, b) }
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                // SAFETY: see splat.
                unsafe { $mul_add(self, b, c) }
            }
            #[inline(always)]
            fn neg_mul_add(self, b: Self, c: Self) -> Self {
                // SAFETY: see splat.
                unsafe { $neg_mul_add(self, b, c) }
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Lanes;
    use std::arch::x86_64::*;

    by_intrinsics!(
        __m256d,
        4,
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_sub_pd,
        _mm256_add_pd,
        _mm256_mul_pd,
        _mm256_fmadd_pd,
        _mm256_fnmadd_pd
    );
    by_intrinsics!(
        __m512d,
        8,
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_sub_pd,
        _mm512_add_pd,
        _mm512_mul_pd,
        _mm512_fmadd_pd,
        _mm512_fnmadd_pd
    );
}

#[cfg(target_arch = "aarch64")]
mod arm {
    use super::Lanes;
    use std::arch::aarch64::*;

    by_intrinsics!(
        float64x2_t,
        2,
        vdupq_n_f64,
        vld1q_f64,
        vst1q_f64,
        vsubq_f64,
        vaddq_f64,
        vmulq_f64,
        |a, b, c| vfmaq_f64(c, a, b),
        |a, b, c| vfmsq_f64(c, a, b)
    );
}
