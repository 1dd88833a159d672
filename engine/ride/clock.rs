//! From time stamps to a uniform clock: rate, gaps, and how evenly the stamps run.

/// Largest deviation from even stamps, in steps, that is taken for print or rounding.
const EVEN: f64 = 1e-4;

/// Largest deviation, in units of the last printed digit, of rounded even stamps from their
/// least-squares line: half a digit, and 5/6 by which roundings may raise an end of that line.
const ROUNDED: f64 = 4.0 / 3.0;

/// Uniform instants start + k step, k below count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    pub start_s: f64,
    pub step_s: f64,
    pub count: usize,
}

impl Grid {
    pub fn at(&self, k: usize) -> f64 {
        self.start_s + k as f64 * self.step_s
    }

    pub fn end_s(&self) -> f64 {
        self.at(self.count.saturating_sub(1))
    }

    pub fn rate_hz(&self) -> f64 {
        1.0 / self.step_s
    }
}

/// Missing samples between two that are there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    /// The samples before and after it (s).
    pub from_s: f64,
    pub to_s: f64,
    pub missing: usize,
}

/// How evenly the stamps run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pace {
    /// Within a ten-thousandth of a step, or no further off than the last printed digit rounds.
    Even,
    Jitter {
        rms_s: f64,
    },
}

/// The uniform clock that fits a channel's stamps best.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clock {
    pub grid: Grid,
    pub gaps: Vec<Gap>,
    pub pace: Pace,
    /// Where each sample lies on the grid, in steps; `None`: sample k lies at k.
    pub knots: Option<Vec<f64>>,
    /// The same if the samples were taken evenly and only their stamps jitter.
    pub even_knots: Option<Vec<f64>>,
}

impl Clock {
    /// A clock without stamps.
    pub fn regular(rate_hz: f64, count: usize) -> Self {
        Self {
            grid: Grid {
                start_s: 0.0,
                step_s: 1.0 / rate_hz,
                count,
            },
            gaps: Vec::new(),
            pace: Pace::Even,
            knots: None,
            even_knots: None,
        }
    }

    /// A single sample.
    pub fn instant(time_s: f64) -> Self {
        let mut clock = Self::regular(1.0, 1);
        clock.grid.start_s = time_s;
        clock
    }

    /// Fits a clock to strictly increasing `times` (s), at least two.
    pub fn fit(times: &[f64]) -> Self {
        let n = times.len();
        let typical = typical_step(times);
        let step = refined_step(times, typical);
        let jittery = off_step(times, step) > 0.25;
        let mut indices = Vec::new();
        let mut gaps = Vec::new();
        let mut k = 0usize;
        for (i, pair) in times.windows(2).enumerate() {
            let steps = (pair[1] - pair[0]) / step;
            let whole = if steps < if jittery { 2.5 } else { 1.5 } {
                1
            } else {
                steps.round().min(1e9) as usize
            };
            if whole > 1 {
                if indices.is_empty() {
                    indices.extend(0..=i);
                }
                gaps.push(Gap {
                    from_s: pair[0],
                    to_s: pair[1],
                    missing: whole - 1,
                });
            }
            k += whole;
            if !indices.is_empty() {
                indices.push(k);
            }
        }
        let index = |i: usize| indices.get(i).copied().unwrap_or(i) as f64;
        let (start_s, step_s) = line(times, index);
        let residual = |i: usize| times[i] - start_s - index(i) * step_s;
        let (mut most, mut square) = (0.0f64, 0.0);
        for i in 0..n {
            let r = residual(i);
            most = most.max(r.abs());
            square += r * r;
        }
        let digit = last_digit(times);
        let even = most <= EVEN * step_s || most <= ROUNDED * digit && digit < 0.5 * step_s;
        let pace = if even {
            Pace::Even
        } else {
            Pace::Jitter {
                rms_s: (square / n as f64).sqrt(),
            }
        };
        let (start_s, step_s) = match pace {
            Pace::Even => rounded((start_s, step_s), times[0], k),
            Pace::Jitter { .. } => (start_s, step_s),
        };
        let grid = Grid {
            start_s,
            step_s,
            count: k + 1,
        };
        let even_knots: Option<Vec<f64>> = (!gaps.is_empty()).then(|| (0..n).map(index).collect());
        let knots = match pace {
            Pace::Even => even_knots.clone(),
            Pace::Jitter { .. } => Some(times.iter().map(|t| (t - start_s) / step_s).collect()),
        };
        Self {
            grid,
            gaps,
            pace,
            knots,
            even_knots,
        }
    }

    pub fn missing(&self) -> usize {
        self.gaps.iter().map(|g| g.missing).sum()
    }
}

/// Median of the steps, from at most some thousand of them.
fn typical_step(times: &[f64]) -> f64 {
    let stride = (times.len() / 4000).max(1);
    let mut steps: Vec<f64> = (times.windows(2).step_by(stride))
        .map(|p| p[1] - p[0])
        .collect();
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Mean of the steps that are near the typical one: free of rounding, blind to gaps.
fn refined_step(times: &[f64], typical: f64) -> f64 {
    let near = |p: &&[f64]| (p[1] - p[0] - typical).abs() < 0.5 * typical;
    let (sum, n) =
        (times.windows(2).filter(near)).fold((0.0, 0usize), |(s, n), p| (s + p[1] - p[0], n + 1));
    if n == 0 { typical } else { sum / n as f64 }
}

/// How far off a step the worst tenth of the steps is, in steps.
fn off_step(times: &[f64], step: f64) -> f64 {
    let stride = (times.len() / 4000).max(1);
    let mut off: Vec<f64> = (times.windows(2).step_by(stride))
        .map(|p| ((p[1] - p[0]) / step - 1.0).abs())
        .collect();
    let worst = (off.len() - 1) * 9 / 10;
    *off.select_nth_unstable_by(worst, f64::total_cmp).1
}

/// Least-squares line through (index, time).
fn line(times: &[f64], index: impl Fn(usize) -> f64) -> (f64, f64) {
    let n = times.len() as f64;
    let first = times[0];
    let (mut k_mean, mut t_mean) = (0.0, 0.0);
    for (i, t) in times.iter().enumerate() {
        k_mean += index(i) / n;
        t_mean += (t - first) / n;
    }
    let (mut kt, mut kk) = (0.0, 0.0);
    for (i, t) in times.iter().enumerate() {
        let k = index(i) - k_mean;
        kt += k * (t - first - t_mean);
        kk += k * k;
    }
    let step = kt / kk;
    (first + t_mean - step * k_mean, step)
}

/// The line (start, step) at a rate of at most three decimals and from the first stamp, if over `k`
/// steps that makes no difference.
fn rounded((start, step): (f64, f64), first: f64, k: usize) -> (f64, f64) {
    let simple = 1e3 / (1e3 / step).round();
    let drift = (simple - step) * k as f64;
    if drift.is_finite() && drift.abs() + (start - first).abs() < EVEN * step {
        (first, simple)
    } else {
        (start, step)
    }
}

/// The decimal place (s) that the stamps were printed to; 0 if they use all digits.
fn last_digit(times: &[f64]) -> f64 {
    let stride = (times.len() / 2000).max(1);
    let whole = |scale: f64| {
        let off = |t: &f64| (t * scale - (t * scale).round()).abs();
        times.iter().step_by(stride).all(|t| off(t) < 1e-3)
    };
    let places = (0..=6).find(|d| whole(10f64.powi(*d)));
    places.map_or(0.0, |d| 10f64.powi(-d))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn near(a: f64, b: f64, by: f64) {
        assert!((a - b).abs() < by, "{a} is not {b}");
    }

    #[test]
    fn even_stamps_anywhere() {
        let times: Vec<f64> = (0..1000).map(|i| 1.7e9 + i as f64 * 0.01).collect();
        let clock = Clock::fit(&times);
        assert_eq!(
            (clock.pace, clock.knots, clock.grid.count),
            (Pace::Even, None, 1000)
        );
        assert_eq!(clock.grid.step_s, 0.01);
        near(clock.grid.start_s, 1.7e9, 1e-6);
    }

    #[test]
    fn stamps_rounded_to_milliseconds_are_even() {
        let times: Vec<f64> = (0..870)
            .map(|i| ((i as f64 * 0.033_366_7 + 0.033) * 1e3).round() / 1e3)
            .collect();
        let clock = Clock::fit(&times);
        assert_eq!(clock.pace, Pace::Even);
        near(clock.grid.step_s, 0.033_366_7, 1e-6);
    }

    #[test]
    fn one_stamp_rounded_the_other_way_is_even() {
        let mut times: Vec<f64> = (0..102).map(|i| i as f64 * 0.003_457 - 219.0).collect();
        times[101] -= 1e-6;
        assert_eq!(Clock::fit(&times).pace, Pace::Even);
    }

    #[test]
    fn gaps_are_counted_through() {
        let kept = |i: &usize| !(200..300).contains(i) && *i != 700;
        let times: Vec<f64> = (0..1000).filter(kept).map(|i| i as f64 * 0.01).collect();
        let clock = Clock::fit(&times);
        let missing: Vec<usize> = clock.gaps.iter().map(|g| g.missing).collect();
        assert_eq!(
            (missing, clock.grid.count, clock.pace),
            (vec![100, 1], 1000, Pace::Even)
        );
        near(clock.gaps[0].from_s, 1.99, 1e-9);
        assert_eq!(clock.knots.unwrap()[200], 300.0);
    }

    #[test]
    fn jitter_is_told_from_gaps() {
        for (rate, missing) in [(100.0, 0), (250.0, 0), (100.0, 30)] {
            let mut state = 1u64;
            let mut jitter = || {
                state = state
                    .wrapping_mul(6364136223846793005)
                    .wrapping_add(1442695040888963407);
                ((state >> 40) as f64 / (1u64 << 24) as f64 - 0.5) * 0.0038
            };
            let mut times: Vec<f64> = (0..2000).map(|i| i as f64 / rate + jitter()).collect();
            times.sort_by(f64::total_cmp);
            times.drain(500..500 + missing);
            let clock = Clock::fit(&times);
            assert_eq!(
                (clock.missing(), clock.grid.count),
                (missing, 2000),
                "{rate}"
            );
            near(clock.grid.step_s * rate, 1.0, 1e-4);
            assert!(
                matches!(clock.pace, Pace::Jitter { rms_s } if (0.0009..0.0012).contains(&rms_s))
            );
        }
    }
}
