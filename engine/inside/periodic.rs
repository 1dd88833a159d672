//! What a periodic input brings about at frequencies that it does not hold (Pintelon & Schoukens 2012, System Identification, 3.4).

use veloid_core::numerics::statistics::variance;
use veloid_report::validation::Distortion;

use crate::record::short;

/// Mean square of the difference between an input and itself one period later, over that of the input, below which it repeats: a
/// signal to noise ratio of 30 dB.
const REPEATS: f64 = 2e-3;
/// Power of a line of the input, of the largest, from which on the input holds it: what noise at 30 dB leaves is below.
const HELD: f64 = 1e-4;

/// The levels, or why there are none.
pub fn distortion(
    input: &[f64],
    output: &[f64],
    valid: &[bool],
    step: f64,
) -> Result<Distortion, String> {
    let period = period(input).ok_or("the input does not repeat itself at least once")?;
    let whole = input.len() / period;
    // The first period holds the start, which has not settled.
    let first = usize::from(whole > 2);
    let periods: Vec<usize> = (first..whole)
        .filter(|p| valid[p * period..(p + 1) * period].iter().all(|v| *v))
        .collect();
    if periods.len() < 2 {
        return Err("fewer than two periods of the input have only valid samples".to_owned());
    }
    let mean = |x: &[f64]| -> Vec<f64> {
        let at = |i: usize| periods.iter().map(|p| x[p * period + i]).sum::<f64>();
        (0..period).map(|i| at(i) / periods.len() as f64).collect()
    };
    let held_by = powers(&mean(input));
    let answer = powers(&mean(output));
    let scatter = scatter(output, &periods, period);
    let most = held_by.iter().skip(1).copied().fold(0.0, f64::max);
    let held: Vec<usize> = (1..held_by.len())
        .filter(|line| held_by[*line] > HELD * most)
        .collect();
    let lowest = held.iter().copied().fold(0, greatest_common_divisor);
    let at_held: f64 = held.iter().map(|line| answer[*line]).sum();
    if lowest == 0 || !(at_held > 0.0) {
        return Err("the output does not answer the input".to_owned());
    }
    let free = |parity: usize| -> Option<Vec<usize>> {
        let multiples = (1..=(answer.len() - 1) / lowest).filter(|n| n % 2 == parity);
        let lines = multiples
            .map(|n| n * lowest)
            .filter(|line| !held.contains(line));
        let lines: Vec<usize> = lines.collect();
        (!lines.is_empty()).then_some(lines)
    };
    let level = |of: &[f64], lines: &[usize]| {
        (lines.iter().map(|line| of[*line]).sum::<f64>() / at_held).sqrt()
    };
    let (odd, even) = (free(1), free(0));
    let both = [odd.as_deref(), even.as_deref()];
    let both: Vec<usize> = both.into_iter().flatten().flatten().copied().collect();
    if both.is_empty() {
        return Err("the input holds every multiple of its lowest frequency".to_owned());
    }
    Ok(Distortion {
        period_s: period as f64 * step,
        periods: periods.len(),
        odd: odd.map(|lines| short(level(&answer, &lines))),
        even: even.map(|lines| short(level(&answer, &lines))),
        noise: short(level(&scatter, &both)),
    })
}

/// The shortest period (samples) with which a record repeats itself at least once.
fn period(x: &[f64]) -> Option<usize> {
    let n = x.len();
    let spread = variance(x);
    let similar = similar(x)?;
    // What is smooth is like itself a moment later; a period comes after it was unlike itself.
    let unlike = similar.iter().position(|r| *r < 0.5)?;
    let candidates = (unlike..=n / 2).filter(|lag| {
        let near = |i: usize| similar.get(i).copied().unwrap_or(f64::NEG_INFINITY);
        near(*lag) > 0.9 && near(*lag) >= near(lag - 1) && near(*lag) >= near(lag + 1)
    });
    let repeats = |lag: &usize| {
        let differences = x.iter().zip(&x[*lag..]).map(|(a, b)| (a - b).powi(2));
        differences.sum::<f64>() / ((n - lag) as f64) < REPEATS * spread
    };
    // No more are looked at than a record of noise could have by chance.
    candidates.take(50).find(repeats)
}

/// Correlation of a record with itself up to half its length, by Fourier transform.
fn similar(x: &[f64]) -> Option<Vec<f64>> {
    let n = x.len();
    let length = (2 * n).next_power_of_two();
    let mean = x.iter().sum::<f64>() / n.max(1) as f64;
    let (forward, inverse) = (
        veloid_fourier::forward(length),
        veloid_fourier::inverse(length),
    );
    let mut record = forward.make_input_vec();
    record.iter_mut().zip(x).for_each(|(r, x)| *r = x - mean);
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut record, &mut spectrum).ok()?;
    spectrum
        .iter_mut()
        .for_each(|bin| *bin = bin.norm_sqr().into());
    inverse.process(&mut spectrum, &mut record).ok()?;
    let whole = record[0] / n as f64;
    let at = |lag: usize| record[lag] / (n - lag) as f64 / whole;
    (whole > 0.0).then(|| (0..=n / 2).map(at).collect())
}

/// Squared amplitudes of one period's lines.
fn powers(x: &[f64]) -> Vec<f64> {
    let fourier = veloid_fourier::forward(x.len());
    let mut part = x.to_vec();
    let mut out = fourier.make_output_vec();
    // Fails only on lengths other than planned.
    let _ = fourier.process(&mut part, &mut out);
    out.iter().map(|line| line.norm_sqr()).collect()
}

/// Squared amplitudes that noise leaves in the mean of the periods, by how they differ from it.
fn scatter(output: &[f64], periods: &[usize], period: usize) -> Vec<f64> {
    let count = periods.len() as f64;
    let of = |p: &usize| &output[p * period..(p + 1) * period];
    let mean = |i: usize| periods.iter().map(|p| of(p)[i]).sum::<f64>() / count;
    let mean: Vec<f64> = (0..period).map(mean).collect();
    let mut sum = vec![0.0; period / 2 + 1];
    for p in periods {
        let off: Vec<f64> = of(p).iter().zip(&mean).map(|(y, mean)| y - mean).collect();
        let squares = powers(&off);
        sum.iter_mut()
            .zip(&squares)
            .for_each(|(sum, s)| *sum += s / (count * (count - 1.0)));
    }
    sum
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    match a {
        0 => b,
        _ => greatest_common_divisor(b % a, a),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_core::numerics::example::white;

    /// Three tones of odd multiples, five periods of 4 s.
    fn input() -> Vec<f64> {
        let tone = |i: usize, n: f64| (std::f64::consts::TAU * n * i as f64 / 400.0 + n * n).sin();
        (0..2000)
            .map(|i| tone(i, 3.0) + tone(i, 7.0) + tone(i, 11.0))
            .collect()
    }

    fn of(output: Vec<f64>) -> Distortion {
        distortion(&input(), &output, &[true; 2000], 0.01).unwrap()
    }

    #[test]
    fn squares_are_even_and_cubes_odd() {
        let noise = white(2000, 3);
        let of = |power: i32| {
            let made = |(x, noise): (&f64, &f64)| x + 0.1 * x.powi(power) + 1e-3 * noise;
            of(input().iter().zip(&noise).map(made).collect())
        };
        let (square, cube) = (of(2), of(3));
        assert_eq!((square.period_s, square.periods), (4.0, 4));
        assert!(
            square.even.unwrap() > 0.03 && square.odd.unwrap() < 0.003,
            "{square:?}"
        );
        assert!(
            cube.odd.unwrap() > 0.03 && cube.even.unwrap() < 0.003,
            "{cube:?}"
        );
        assert!(square.noise < 0.003 && square.noise > 1e-4, "{square:?}");
    }

    #[test]
    fn a_sine_whose_period_is_no_whole_number_of_samples_repeats_after_several() {
        let sine = |i: usize| (std::f64::consts::TAU * 3.0 * i as f64 / 100.0).sin();
        let x: Vec<f64> = (0..2000).map(sine).collect();
        let y: Vec<f64> = x.iter().map(|x| x + 0.1 * x * x).collect();
        let found = distortion(&x, &y, &[true; 2000], 0.01).unwrap();
        assert_eq!(found.period_s, 1.0);
        // 0.1 sin^2 = 0.05 - 0.05 cos 2: a twentieth of the output.
        assert!((found.even.unwrap() - 0.05).abs() < 1e-3, "{found:?}");
        assert!(found.odd.unwrap() < 1e-9);
    }

    #[test]
    fn what_repeats_worse_than_its_noise_allows_is_not_periodic() {
        let noise = white(2000, 8);
        let with = |ratio: f64| {
            // The difference of two periods has the noise twice; the input's variance is 1.5.
            let size = (0.5 * 1.5 * ratio * REPEATS).sqrt();
            let x: Vec<f64> = input()
                .iter()
                .zip(&noise)
                .map(|(x, n)| x + size * n)
                .collect();
            period(&x)
        };
        assert_eq!((with(0.8), with(1.25)), (Some(400), None));
        assert_eq!(period(&white(2000, 1)), None);
        assert_eq!(period(&[1.0; 100]), None);
    }
}
