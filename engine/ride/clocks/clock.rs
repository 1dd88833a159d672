//! From time stamps to a uniform clock: rate, gaps, and how evenly the stamps run.

/// Largest deviation from even stamps, in steps, that is taken for print or rounding.
const EVEN: f64 = 1e-4;

/// Largest deviation, in units of the last printed digit, of rounded even stamps from their
/// least-squares line: half a digit, and 5/6 by which roundings may raise an end of that line.
const ROUNDED: f64 = 4.0 / 3.0;

/// How far (steps) from its even place a stamp may lie and still be that place's own: half a step, and a sixth for what
/// the clock that follows the stamps is off itself when they jitter by nearly half a step.
const REACH: f64 = 2.0 / 3.0;
/// How much of a stamp's deviation the clock follows: a time constant of 20 samples, in which jitter averages out and
/// the quartz of a logger does not drift.
const FOLLOW: f64 = 0.05;
/// After a longer pause (steps) the clock starts again with the stamp that ends it.
const LONG_PAUSE: f64 = 4.0;

/// Uniform instants start + k step, k below count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
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
pub struct Gap {
    /// The samples before and after it (s).
    pub from_s: f64,
    pub to_s: f64,
    pub missing: usize,
}

/// How evenly the stamps run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Within a ten-thousandth of a step, or no further off than the last printed digit rounds.
    Even,
    Jitter {
        rms_s: f64,
    },
}

/// The uniform clock that fits a channel's stamps best.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    pub grid: Grid,
    pub gaps: Vec<Gap>,
    pub pace: Pace,
    /// Where each sample lies on the grid, in steps; `None`: sample k lies at k.
    pub knots: Option<Vec<f64>>,
    /// The same if the samples were taken evenly and only their stamps jitter.
    pub even_knots: Option<Vec<f64>>,
}

impl From<Clock> for Fit {
    fn from(clock: Clock) -> Self {
        Self {
            clock,
            repeats: Vec::new(),
        }
    }
}

/// A clock, and the stamps that it has no place for.
pub struct Fit {
    pub clock: Clock,
    /// Places of stamps that repeat another one or nearly do, increasing.
    pub repeats: Vec<usize>,
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

    /// Fits a clock to `times` (s) that do not fall, at least one.
    pub fn fit(times: &[f64]) -> Fit {
        let Some(typical) = typical_step(times) else {
            return Fit {
                clock: Self::instant(times[0]),
                repeats: (1..times.len()).collect(),
            };
        };
        let seats = seat(times, refined_step(times, typical));
        let clock = match seats.repeats.as_slice() {
            [] => Self::through(times, &seats),
            repeats => {
                let mut kept = times.to_vec();
                drop_at(&mut kept, repeats);
                Self::through(&kept, &seats)
            }
        };
        Fit {
            clock,
            repeats: seats.repeats,
        }
    }

    /// The clock of stamps of which each has a seat of its own.
    fn through(times: &[f64], seats: &Seats) -> Self {
        let n = times.len();
        let index = |i: usize| seats.indices.get(i).copied().unwrap_or(i) as f64;
        if n < 2 {
            return Self::instant(times[0]);
        }
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
        let k = index(n - 1) as usize;
        let (start_s, step_s) = match pace {
            Pace::Even => rounded((start_s, step_s), times[0], k),
            Pace::Jitter { .. } => (start_s, step_s),
        };
        let grid = Grid {
            start_s,
            step_s,
            count: k + 1,
        };
        let even_knots: Option<Vec<f64>> =
            (!seats.gaps.is_empty()).then(|| (0..n).map(index).collect());
        let knots = match pace {
            Pace::Even => even_knots.clone(),
            Pace::Jitter { .. } => Some(times.iter().map(|t| (t - start_s) / step_s).collect()),
        };
        Self {
            grid,
            gaps: seats.gaps.clone(),
            pace,
            knots,
            even_knots,
        }
    }

    pub fn missing(&self) -> usize {
        self.gaps.iter().map(|g| g.missing).sum()
    }
}

/// Median of the steps between stamps that differ, from at most some thousand of them.
fn typical_step(times: &[f64]) -> Option<f64> {
    let stride = (times.len() / 4000).max(1);
    let mut steps: Vec<f64> = (times.windows(2).step_by(stride))
        .map(|p| p[1] - p[0])
        .filter(|step| *step > 0.0)
        .collect();
    let middle = steps.len() / 2;
    (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Mean of the steps that are near the typical one: free of rounding, blind to gaps.
fn refined_step(times: &[f64], typical: f64) -> f64 {
    let near = |p: &&[f64]| (p[1] - p[0] - typical).abs() < 0.5 * typical;
    let (sum, n) =
        (times.windows(2).filter(near)).fold((0.0, 0usize), |(s, n), p| (s + p[1] - p[0], n + 1));
    if n == 0 { typical } else { sum / n as f64 }
}

/// Where stamps sit on an even clock.
struct Seats {
    /// Seats of the stamps that are kept; empty if stamp i sits at i.
    indices: Vec<usize>,
    gaps: Vec<Gap>,
    /// Stamps whose seat another one has.
    repeats: Vec<usize>,
}

/// Gives every stamp the next seat of an even clock that follows them slowly, leaves out seats where none comes near
/// ([`REACH`]), and of several stamps that come for one seat keeps the nearest.
fn seat(times: &[f64], step_s: f64) -> Seats {
    let mut out = Seats {
        indices: Vec::new(),
        gaps: Vec::new(),
        repeats: Vec::new(),
    };
    let (mut seat_s, mut step) = (first_seat(times, step_s), step_s);
    let (mut last, mut index) = (0, 0usize);
    for (i, time) in times.iter().copied().enumerate().skip(1) {
        let steps = (time - seat_s) / step;
        if steps < 1.0 - REACH {
            let nearer = (time - seat_s).abs() < (times[last] - seat_s).abs();
            if nearer && let Some(gap) = out.gaps.last_mut().filter(|g| g.to_s == times[last]) {
                gap.to_s = time;
            }
            out.repeats.push(if nearer { last } else { i });
            last = if nearer { i } else { last };
            continue;
        }
        let whole = if steps <= 1.0 + REACH {
            1.0
        } else {
            steps.round().min(1e9)
        };
        let whole_steps = whole as usize;
        let kept = i - out.repeats.len();
        if whole_steps > 1 {
            if out.indices.is_empty() {
                out.indices.extend(0..kept);
            }
            out.gaps.push(Gap {
                from_s: times[last],
                to_s: time,
                missing: whole_steps - 1,
            });
        }
        index += whole_steps;
        if !out.indices.is_empty() {
            out.indices.push(index);
        }
        last = i;
        let off = steps - whole;
        if whole > LONG_PAUSE {
            seat_s = time;
        } else {
            seat_s += (whole + FOLLOW * off) * step;
            step *= 1.0 + 0.5 * FOLLOW * FOLLOW * off;
        }
    }
    out.repeats.sort_unstable();
    out
}

/// Time of the seat that the first stamp has: where the first stamps lie on average, less those that lie elsewhere.
fn first_seat(times: &[f64], step: f64) -> f64 {
    let mut seats = 0.0;
    let mut early: Vec<f64> = (times.windows(2).take(31))
        .map(|p| {
            seats += ((p[1] - p[0]) / step).round().max(1.0);
            (p[1] - times[0]) / step - seats
        })
        .collect();
    early.push(0.0);
    let middle = early.len() / 2;
    let median = *early.select_nth_unstable_by(middle, f64::total_cmp).1;
    let near: Vec<f64> = (early.into_iter())
        .filter(|off| (off - median).abs() < REACH)
        .collect();
    let mean = near.iter().sum::<f64>() / near.len() as f64;
    times[0] + (mean - mean.round()) * step
}

/// Takes the entries at the increasing places `at` out.
pub fn drop_at(values: &mut Vec<f64>, at: &[usize]) {
    let (mut place, mut next) = (0, 0);
    values.retain(|_| {
        let dropped = at.get(next) == Some(&place);
        next += usize::from(dropped);
        place += 1;
        !dropped
    });
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
        let clock = Clock::fit(&times).clock;
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
        let clock = Clock::fit(&times).clock;
        assert_eq!(clock.pace, Pace::Even);
        near(clock.grid.step_s, 0.033_366_7, 1e-6);
    }

    #[test]
    fn one_stamp_rounded_the_other_way_is_even() {
        let mut times: Vec<f64> = (0..102).map(|i| i as f64 * 0.003_457 - 219.0).collect();
        times[101] -= 1e-6;
        assert_eq!(Clock::fit(&times).clock.pace, Pace::Even);
    }

    #[test]
    fn gaps_are_counted_through() {
        let kept = |i: &usize| !(200..300).contains(i) && *i != 700;
        let times: Vec<f64> = (0..1000).filter(kept).map(|i| i as f64 * 0.01).collect();
        let clock = Clock::fit(&times).clock;
        let missing: Vec<usize> = clock.gaps.iter().map(|g| g.missing).collect();
        assert_eq!(
            (missing, clock.grid.count, clock.pace),
            (vec![100, 1], 1000, Pace::Even)
        );
        near(clock.gaps[0].from_s, 1.99, 1e-9);
        assert_eq!(clock.knots.unwrap()[200], 300.0);
    }

    #[test]
    fn jitter_is_reported_from_gaps() {
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
            let clock = Clock::fit(&times).clock;
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

    /// 2000 stamps at 100 Hz.
    fn even() -> Vec<f64> {
        (0..2000).map(|i| f64::from(i) * 0.01).collect()
    }

    #[test]
    fn near_repeats_have_no_place_of_their_own() {
        for apart in [0.0, 1e-13, 1e-9, 1e-6, 1e-4, 1e-3] {
            for at in [1000, 2000] {
                let mut times = even();
                let burst = (1..=300).map(|i| 0.01 * (at - 1) as f64 + apart * f64::from(i));
                let later = times.split_off(at);
                times.extend(burst);
                let end = times[times.len() - 1];
                times.extend(later.iter().filter(|t| **t > end));
                let fit = Clock::fit(&times);
                assert!(fit.repeats.len() >= 260, "{apart}: {}", fit.repeats.len());
                near(fit.clock.grid.step_s, 0.01, 2e-5);
                assert!(fit.clock.grid.count.abs_diff(2000) <= 32);
            }
        }
    }

    /// How far off a stamp may be before it loses its place moves with REACH.
    #[test]
    fn one_bad_stamp_costs_at_most_one_sample() {
        for off in [-0.99, -0.7, -0.6, -0.3, -0.01, 0.01, 0.3, 0.6, 0.7, 0.99] {
            for at in [1, 2, 1000, 1998] {
                let mut times = even();
                times[at] += 0.01 * off;
                let Fit { clock, repeats } = Clock::fit(&times);
                let lost = usize::from(f64::abs(off) > REACH);
                assert_eq!((clock.missing(), repeats.len()), (lost, lost), "{off} {at}");
                assert_eq!(clock.grid.count, 2000, "{off} {at}");
                near(clock.grid.step_s, 0.01, 1e-8);
                let last = clock.knots.map_or(1999.0, |knots| knots[knots.len() - 1]);
                near(last, 1999.0, 0.02);
            }
        }
    }

    #[test]
    fn a_clock_that_wanders_keeps_its_samples() {
        let mut time = 0.0;
        let times: Vec<f64> = (0..20_000)
            .map(|i| {
                time += 0.01 * (1.0 + 0.03 * (f64::from(i) * 0.005).sin());
                time
            })
            .collect();
        let Fit { clock, repeats } = Clock::fit(&times);
        assert_eq!((clock.missing(), repeats.len()), (0, 0));
    }
}
