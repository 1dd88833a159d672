//! Does a residual come and go? Noise of the sensors is Gaussian and goes on as it is, but for that of a jittering
//! clock, which grows with the rate of the motion. What a force leaves that acts at times is neither, whatever its
//! spectrum: a rider's hands push far below the axle's resonance, and look like coloured noise there.

/// Length (s) over which the residual is smoothed: less than a push of the hands, more than most noise.
const LENGTH_S: f64 = 0.1;
/// Samples that span a length: above 10 kHz means over several samples stand for them, so that the work for
/// each does not grow with the rate.
const FINEST: usize = 1000;
/// A mean over so many lengths is taken off: slow noise has few independent values.
const TREND: usize = 4;
/// Start of a ride (s) that is not looked at.
const SETTLING_S: f64 = 1.0;
/// Independent values that say something.
const ENOUGH: f64 = 100.0;
/// Turns in which the variance is fitted, and its least constant part over its mean.
const TURNS: usize = 5;
const LEAST: f64 = 1e-3;

/// Excess kurtosis of the smoothed residual (m), over what a variance that grows with the square of the displacement's
/// `rate` (m/s) brings, as a normal deviate; minus infinity where the record is too short to show.
pub fn score(residual: &[f64], rate: &[f64], valid: &[bool], step: f64) -> f64 {
    let together = (LENGTH_S / step / FINEST as f64)
        .floor()
        .min(residual.len() as f64) as usize;
    if together > 1 {
        let mean = |x: &[f64]| -> Vec<f64> {
            let means = x.chunks_exact(together);
            means
                .map(|x| x.iter().sum::<f64>() / together as f64)
                .collect()
        };
        let valid: Vec<bool> = valid
            .chunks_exact(together)
            .map(|v| v.iter().all(|v| *v))
            .collect();
        return score(&mean(residual), &mean(rate), &valid, step * together as f64);
    }
    let from = ((SETTLING_S / step) as usize).min(residual.len());
    let length = ((LENGTH_S / step).round() as usize).max(2);
    let smooth = smoothed(&residual[from..], length);
    let squares: Vec<f64> = rate[from..].iter().map(|v| v * v).collect();
    let known = |x: Vec<f64>| -> Vec<f64> {
        let known = x
            .into_iter()
            .zip(&valid[from..])
            .filter(|(_, valid)| **valid);
        known.map(|(x, _)| x).collect()
    };
    let (smooth, loud) = (known(smooth), known(mean_near(&squares, length)));
    let independent = smooth.len() as f64 / length as f64;
    if independent < ENOUGH {
        return f64::NEG_INFINITY;
    }
    let powers: Vec<f64> = smooth.iter().map(|x| x * x).collect();
    let variances = variances(&powers, &loud);
    let even: Vec<f64> = powers.iter().zip(variances).map(|(p, v)| p / v).collect();
    let n = even.len() as f64;
    let (second, fourth) = (
        even.iter().sum::<f64>() / n,
        even.iter().map(|x| x * x).sum::<f64>() / n,
    );
    normal_score(fourth / (second * second), independent)
}

/// A Hann-weighted mean over about so many samples.
fn mean_near(x: &[f64], length: usize) -> Vec<f64> {
    let half = length / 2;
    let weight = |k: usize| {
        (std::f64::consts::FRAC_PI_2 * k as f64 / (half + 1) as f64)
            .cos()
            .powi(2)
    };
    let weights: Vec<f64> = (0..=half).map(weight).collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    (0..x.len())
        .map(|i| {
            let beside = (1..=half).map(|k| {
                let before = i.checked_sub(k).map_or(0.0, |i| x[i]);
                weights[k] * (before + x.get(i + k).copied().unwrap_or(0.0))
            });
            (weights[0] * x[i] + beside.sum::<f64>()) / total
        })
        .collect()
}

/// Such a mean, less the plain one over `TREND` times as many samples.
fn smoothed(x: &[f64], length: usize) -> Vec<f64> {
    let near = mean_near(x, length);
    let mut sums = vec![0.0];
    for x in &near {
        sums.push(sums[sums.len() - 1] + x);
    }
    let wide = TREND * length / 2;
    (0..x.len())
        .map(|i| {
            let (from, to) = (i.saturating_sub(wide), (i + wide + 1).min(x.len()));
            near[i] - (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// Variances of the form a + b `loud`, neither part negative, by weighted least squares on the `powers`.
fn variances(powers: &[f64], loud: &[f64]) -> Vec<f64> {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (power, level) = (mean(powers), mean(loud).max(f64::MIN_POSITIVE));
    let (mut a, mut b) = (power, 0.0);
    for _ in 0..TURNS {
        let (mut s, mut sx, mut sxx, mut sy, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (y, x) in powers.iter().zip(loud) {
            let x = x / level;
            let weight = (a + b * x).powi(-2);
            s += weight;
            sx += weight * x;
            sxx += weight * x * x;
            sy += weight * y;
            sxy += weight * x * y;
        }
        let size = s * sxx - sx * sx;
        let slope = (s * sxy - sx * sy) / size;
        (a, b) = if slope > 0.0 && slope.is_finite() {
            (((sy - slope * sx) / s).max(LEAST * power), slope)
        } else {
            (power, 0.0)
        };
    }
    loud.iter().map(|x| a + b * x / level).collect()
}

/// A sample kurtosis of `n` independent normal values as a standard normal deviate
/// (Anscombe & Glynn 1983, doi:10.1093/biomet/70.1.227).
fn normal_score(kurtosis: f64, n: f64) -> f64 {
    let mean = 3.0 * (n - 1.0) / (n + 1.0);
    let variance = 24.0 * n * (n - 2.0) * (n - 3.0) / ((n + 1.0).powi(2) * (n + 3.0) * (n + 5.0));
    let x = (kurtosis - mean) / variance.sqrt();
    let skewness = 6.0 * (n * n - 5.0 * n + 2.0) / ((n + 7.0) * (n + 9.0))
        * (6.0 * (n + 3.0) * (n + 5.0) / (n * (n - 2.0) * (n - 3.0))).sqrt();
    let a = 6.0 + 8.0 / skewness * (2.0 / skewness + (1.0 + 4.0 / (skewness * skewness)).sqrt());
    // Far below, where two values alternate, the cube root would change its sign.
    let below = (1.0 + x * (2.0 / (a - 4.0)).sqrt()).max(1e-3);
    let spread = 2.0 / (9.0 * a);
    (1.0 - spread - ((1.0 - 2.0 / a) / below).cbrt()) / spread.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use veloid_core::numerics::autoregressive::NoiseModel;
    use veloid_core::numerics::random::normal;

    const STEP: f64 = 0.01;
    static ALL: [bool; 6000] = [true; 6000];
    static STILL: [f64; 6000] = [0.0; 6000];

    fn noise(n: usize, correlation: f64, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let white: Vec<f64> = (0..n).map(|_| normal(&mut rng)).collect();
        let red = NoiseModel {
            a: vec![-correlation],
            variance: 1.0,
        };
        red.noise_model(&white)
    }

    #[test]
    fn noise_of_any_colour_goes_on_as_it_is() {
        for correlation in [0.0, 0.7, 0.95, 0.99] {
            let scores =
                (0..60).map(|seed| score(&noise(6000, correlation, seed), &STILL, &ALL, STEP));
            let most = scores.fold(f64::NEG_INFINITY, f64::max);
            assert!(most < 4.0, "{correlation}: {most}");
        }
    }

    #[test]
    fn shoves_do_not() {
        let mut shoved = noise(6000, 0.0, 1);
        for start in (250..5900).step_by(230) {
            let sign = if start % 460 == 20 { 1.0 } else { -1.0 };
            for k in 0..20 {
                shoved[start + k] += sign * 3.0 * (std::f64::consts::PI * k as f64 / 20.0).sin();
            }
        }
        let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        assert!(rms(&shoved) < 1.25, "{}", rms(&shoved));
        let score = score(&shoved, &STILL, &ALL, STEP);
        assert!(score > 6.0, "{score}");
    }

    #[test]
    fn noise_of_a_clock_grows_with_the_rate() {
        let white = noise(6000, 0.0, 3);
        let rate: Vec<f64> = (0..6000)
            .map(|i| (0.003 * i as f64).sin().powi(6) * (0.2 * i as f64).sin())
            .collect();
        let slipped: Vec<f64> = white
            .iter()
            .zip(&rate)
            .map(|(x, v)| x * (0.1 + v))
            .collect();
        let score = |rate| score(&slipped, rate, &ALL, STEP);
        assert!(score(&STILL[..]) > 6.0, "{}", score(&STILL[..]));
        assert!(score(&rate[..]) < 4.0, "{}", score(&rate[..]));
    }

    #[test]
    fn what_is_not_known_is_not_counted() {
        let mut clipped = noise(6000, 0.0, 2);
        let mut valid = vec![true; 6000];
        for i in 3000..3050 {
            clipped[i] = 0.0;
            valid[i] = false;
        }
        assert!(score(&clipped, &STILL, &valid, STEP) < 4.0);
        let short = score(&clipped[..500], &STILL[..500], &valid[..500], STEP);
        assert_eq!(short, f64::NEG_INFINITY);
    }
}
