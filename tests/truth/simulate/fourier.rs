//! The fast Fourier transform of Cooley and Tukey (1965), of lengths that are powers of two.

use std::f64::consts::TAU;

use nalgebra::Complex;

/// Replaces every x_k by the sum over i of x_i exp(2 pi j i k / n).
pub fn sum_lines(x: &mut [Complex<f64>]) {
    let n = x.len();
    assert!(n.is_power_of_two(), "{n} is no power of two");
    if n == 1 {
        return;
    }
    let unused = usize::BITS - n.trailing_zeros();
    for i in 0..n {
        let other = i.reverse_bits() >> unused;
        if i < other {
            x.swap(i, other);
        }
    }
    let turns: Vec<Complex<f64>> = (0..n / 2)
        .map(|i| Complex::cis(TAU * i as f64 / n as f64))
        .collect();
    let mut half = 1;
    while half < n {
        let apart = n / (2 * half);
        for block in x.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (i, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turned = *b * turns[i * apart];
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    #[test]
    fn it_is_the_sum_of_its_lines() {
        let chance = &mut Chance::new(1, 0);
        for n in [1, 2, 8, 64] {
            let lines: Vec<_> = (0..n)
                .map(|_| Complex::new(chance.normal(), chance.normal()))
                .collect();
            let mut sums = lines.clone();
            sum_lines(&mut sums);
            for (k, sum) in sums.iter().enumerate() {
                let line = |(i, x): (usize, &Complex<f64>)| {
                    x * Complex::cis(TAU * (i * k) as f64 / n as f64)
                };
                let slow: Complex<f64> = lines.iter().enumerate().map(line).sum();
                assert!((sum - slow).norm() < 1e-11, "{n}: {sum} and {slow}");
            }
        }
    }
}
