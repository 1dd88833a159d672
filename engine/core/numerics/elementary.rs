//! Elementary functions of eight numbers at once. The standard library's take one number at a time, and crates for vectors choose
//! theirs when they are compiled, not by the processor that runs them as [`widest`](super::lanes::widest) does.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI, LN_2, LOG2_E};

use super::lanes::Lanes;

impl Lanes {
    /// Natural logarithm of positive normal numbers, right to 2e-15 or that share of it.
    #[inline(always)]
    pub fn ln(self) -> Self {
        const MANTISSA: u64 = (1 << 52) - 1;
        const ROOT: u64 = FRAC_1_SQRT_2.to_bits();
        // x = 2^e m with m from 1/sqrt(2) to sqrt(2): bits counted from those of 1/sqrt(2).
        let above = |x: f64| x.to_bits().wrapping_sub(ROOT);
        let e = self.map(|x| (above(x) as i64 >> 52) as f64);
        let m = self.map(|x| f64::from_bits((above(x) & MANTISSA) + ROOT));
        // ln m = 2 artanh((m - 1)/(m + 1)).
        let s = (m - 1.0) / (m + 1.0);
        let q = s * s;
        let mut sum = Self::all(1.0 / 19.0);
        for n in (0..9).rev() {
            sum = sum * q + 1.0 / f64::from(2 * n + 1);
        }
        s * sum * 2.0 + e * LN_2
    }

    /// Exponential, right to 1e-14 of itself from -700 to 700 and held there beyond.
    #[inline(always)]
    pub fn exp(self) -> Self {
        let x = self.max(Self::all(-700.0)).min(Self::all(700.0));
        let n = x.map(|x| (x * LOG2_E).round_ties_even());
        // ln 2 in two parts, the first of which times n is exact.
        let r = x - n * LN_2_HIGH - n * LN_2_LOW;
        let mut sum = Self::all(1.0);
        for k in (1..14).rev() {
            sum = sum * r * (1.0 / f64::from(k)) + 1.0;
        }
        sum.zip(n, |sum, n| {
            sum * f64::from_bits(((n as i64 + 1023) as u64) << 52)
        })
    }

    /// Positive normal numbers to some power.
    #[inline(always)]
    pub fn powf(self, power: Self) -> Self {
        (self.ln() * power).exp()
    }

    /// Sine and cosine of angles (rad) up to 1e6 in size, right to 1e-14.
    #[inline(always)]
    pub fn sin_cos(self) -> [Self; 2] {
        let n = self.map(|x| (x * FRAC_2_PI).round_ties_even());
        let r = self - n * HALF_PI_HIGH - n * HALF_PI_LOW;
        let q = r * r;
        let series = |first: i32| {
            let mut sum = Self::all(1.0);
            for k in (0..7).rev() {
                let k = f64::from(2 * k + first);
                sum = Self::all(1.0) - sum * q * (1.0 / ((k + 1.0) * (k + 2.0)));
            }
            sum
        };
        let (sin, cos) = (r * series(1), series(0));
        // Quarter turns swap the two and change their signs.
        let odd = n.map(|n| f64::from(n as i64 & 1 == 1));
        let pick = |a: Self, b: Self| a + (b - a) * odd;
        let sign = |at: i64| n.map(|n| 1.0 - ((n as i64).wrapping_add(at) & 2) as f64);
        [pick(sin, cos) * sign(0), pick(cos, sin) * sign(1)]
    }
}

/// ln 2 and pi/2 to twice the digits; the first parts have 32 bits, so that whole multiples of them are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
const HALF_PI_LOW: f64 = 6.077_100_506_506_192e-11;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lanes::LANES;

    /// Compares with the standard library at many places between two numbers.
    fn agree(
        from: f64,
        to: f64,
        of: impl Fn(Lanes) -> Lanes,
        standard: impl Fn(f64) -> f64,
        off: f64,
    ) {
        for i in 0..5000 {
            let at = |lane: usize| {
                from + (to - from) * (i * LANES + lane) as f64 / (5000 * LANES - 1) as f64
            };
            let x = Lanes(std::array::from_fn(at));
            for (x, y) in x.0.into_iter().zip(of(x).0) {
                let expected = standard(x);
                let error = (y - expected).abs() / expected.abs().max(1.0);
                assert!(error < off, "at {x}: {y} instead of {expected}");
            }
        }
    }

    #[test]
    fn val_they_agree_with_the_standard_library() {
        agree(1e-300, 1e-290, Lanes::ln, f64::ln, 1e-14);
        agree(1e-3, 3.0, Lanes::ln, f64::ln, 2e-15);
        agree(3.0, 1e9, Lanes::ln, f64::ln, 2e-15);
        agree(-3.0, 3.0, Lanes::exp, f64::exp, 1e-15);
        agree(-700.0, 700.0, Lanes::exp, f64::exp, 1e-14);
        for power in [-2.5, 0.3, 1.7] {
            let powf = |x: Lanes| x.powf(Lanes::all(power));
            agree(1e-6, 50.0, powf, |x| x.powf(power), 1e-13);
        }
        agree(-10.0, 10.0, |x| x.sin_cos()[0], f64::sin, 3e-15);
        agree(-10.0, 10.0, |x| x.sin_cos()[1], f64::cos, 3e-15);
        agree(-1e6, 1e6, |x| x.sin_cos()[0], f64::sin, 1e-14);
        agree(-1e6, 1e6, |x| x.sin_cos()[1], f64::cos, 1e-14);
    }
}
