//! Eight numbers that are computed with at once: one for each of eight parameter sets. Plain arrays
//! that the compiler turns into vector instructions where the enclosing function allows them.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Parameter sets simulated together.
pub const LANES: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    pub const ZERO: Lanes = Lanes([0.0; LANES]);

    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Lanes([value; LANES])
    }

    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for x in &mut out.0 {
            *x = f(*x);
        }
        out
    }

    #[inline(always)]
    pub fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = f(self.0[i], other.0[i]);
        }
        out
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        self.map(f64::recip)
    }

    /// x / sqrt(x^2 + width^2): a sign that is smooth over `width`.
    #[inline(always)]
    pub fn soft_sign(self, width: Self) -> Self {
        self / (self * self + width * width).sqrt()
    }
}

macro_rules! operator {
    ($trait:ident $method:ident $op:tt) => {
        impl $trait for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $method(self, other: Lanes) -> Lanes {
                self.zip(other, |a, b| a $op b)
            }
        }
        impl $trait<f64> for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $method(self, other: f64) -> Lanes {
                self.map(|a| a $op other)
            }
        }
    };
}

operator!(Add add +);
operator!(Sub sub -);
operator!(Mul mul *);
operator!(Div div /);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Lanes) {
        *self = *self + other;
    }
}

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        self.map(|x| -x)
    }
}

/// Runs `work` compiled for the widest vectors that this processor has.
#[inline(always)]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    vectors(work).unwrap_or_else(
        #[inline(always)]
        |work| work(),
    )
}

/// The same, but not compiled for a processor of x86 without AVX2: there it gives the work back.
#[inline(always)]
pub fn vectors<R, W: FnOnce() -> R>(work: W) -> Result<R, W> {
    #[cfg(target_arch = "x86_64")]
    {
        // Results are the same, and a build for tests is done sooner without.
        #[cfg(not(debug_assertions))]
        if is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
        {
            // SAFETY: the processor has the features that the function is compiled for.
            return Ok(unsafe { avx512(work) });
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            return Ok(unsafe { avx2(work) });
        }
        Err(work)
    }
    #[cfg(not(target_arch = "x86_64"))]
    Ok(work())
}

#[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
fn avx512<R>(work: impl FnOnce() -> R) -> R {
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<R>(work: impl FnOnce() -> R) -> R {
    work()
}
