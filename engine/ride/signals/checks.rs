//! What is doubtful about a channel: clipping, odd sizes, aliasing, nothing but noise.

use crate::channels::channel::Channel;
use crate::channels::values::{is_constant, size};
use crate::recording::{Recording, Track};
use veloid_core::document::format_number::significant;
use veloid_core::numerics::statistics::variance;

/// Fewest equal samples at an extreme that count as clipped.
const FLAT_RUN: usize = 3;

/// Stretches (first and last sample) where `values` lie at an extreme that they are clipped at.
///
/// Clipping shows in runs of three or more samples at exactly the largest or smallest value that
/// are entered and left by jumps no smooth peak of that width could make: more than six times the
/// finest step seen in the record and a tenth of the usual one. Two such runs, or one of five
/// samples, and every sample at that value is taken for clipped.
pub fn clipped(values: &[f64]) -> Vec<(usize, usize)> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut finest, mut squares) = (f64::INFINITY, 0.0);
    for (i, v) in values.iter().enumerate() {
        (low, high) = (low.min(*v), high.max(*v));
        if i > 0 && *v != values[i - 1] {
            let d = (v - values[i - 1]).abs();
            finest = finest.min(d);
            squares += d * d;
        }
    }
    if low >= high {
        return Vec::new();
    }
    let usual = (squares / values.len() as f64).sqrt();
    let jump = (6.0 * finest).max(0.1 * usual);
    let clips = |runs: &Vec<(usize, usize)>| {
        let flat = runs.iter().filter(|run| is_cut(values, **run, jump));
        let lengths: Vec<usize> = flat.map(|(a, b)| b - a + 1).collect();
        lengths.len() > 1 || lengths.iter().any(|n| *n >= FLAT_RUN + 2)
    };
    let runs = [high, low].map(|extreme| runs_at(values, extreme));
    runs.into_iter().filter(clips).flatten().collect()
}

/// Share of a record that a drive spends at its limits; a sensor whose range is left that long is not used.
const SATURATED: f64 = 0.1;

/// Whether both limits are alike and a good part of the record lies at them: so does a saturated drive.
fn is_at_its_limits(values: &[f64], runs: &[(usize, usize)]) -> bool {
    let at = |above: bool| runs.iter().any(|(a, _)| (values[*a] > 0.0) == above);
    let (low, high) = (values.iter()).fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    let samples: usize = runs.iter().map(|(a, b)| b - a + 1).sum();
    at(true)
        && at(false)
        && (high + low).abs() <= 0.02 * high
        && samples as f64 > SATURATED * values.len() as f64
}

fn runs_at(values: &[f64], extreme: f64) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for i in (0..values.len()).filter(|i| values[*i] == extreme) {
        if let Some((_, last)) = runs.last_mut().filter(|(_, last)| last + 1 == i) {
            *last = i;
            continue;
        }
        // A value met that often is no limit that is hit now and then.
        if runs.len() > values.len() / 6 {
            return Vec::new();
        }
        runs.push((i, i));
    }
    runs
}

/// Whether a peak was cut off here. The steps right beside the run are cut short themselves: those
/// beyond them count.
fn is_cut(values: &[f64], (first, last): (usize, usize), jump: f64) -> bool {
    let into = (first >= 2).then(|| (values[first - 1] - values[first - 2]).abs());
    let out = (last + 2 < values.len()).then(|| (values[last + 2] - values[last + 1]).abs());
    last - first + 1 >= FLAT_RUN
        && into.is_none_or(|d| d > jump)
        && out.is_none_or(|d| d > jump)
        && (into.is_some() || out.is_some())
}

/// Half the span of the values.
pub fn amplitude(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(*v), h.max(*v))
        });
    0.5 * (high - low)
}

/// Whether an unexcited displacement shows a free motion rather than noise: somewhere smoother than
/// white noise, and either dying away or swinging at a steady pace.
pub fn is_free_motion(values: &[f64]) -> bool {
    let blocks = (values.len() / 32).clamp(1, 8);
    let blocks: Vec<&[f64]> = values
        .chunks_exact((values.len() / blocks).max(1))
        .collect();
    let strongest = blocks.iter().map(|b| variance(b)).fold(0.0, f64::max);
    let last = blocks.last().map_or(0.0, |b| variance(b));
    let dying = strongest > 10.0 * last;
    blocks.iter().any(|b| von_neumann(b) < 0.5) && (dying || swings(values).is_some())
}

/// Half the mean square of differences over the variance: 1 for white noise, 0 for slow motion.
fn von_neumann(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|p| (p[1] - p[0]).powi(2)).sum();
    let spread = variance(values) * values.len() as f64;
    if spread > 0.0 {
        0.5 * squares / spread
    } else {
        1.0
    }
}

/// Part of the standard deviation by which a swing must pass the mean to count: noise at the crossing does not.
const PASSED: f64 = 0.3;

/// Samples of half a swing, where most intervals between crossings of the mean are alike.
pub fn swings(values: &[f64]) -> Option<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let beyond = PASSED * variance(values).sqrt();
    let mut above = None;
    let mut crossings = Vec::new();
    for (i, value) in values.iter().enumerate() {
        if (value - mean).abs() <= beyond {
            continue;
        }
        let now = *value > mean;
        if above.is_some_and(|above| above != now) {
            crossings.push(i);
        }
        above = Some(now);
    }
    let mut intervals: Vec<f64> = crossings.windows(2).map(|p| (p[1] - p[0]) as f64).collect();
    if intervals.len() < 4 {
        return None;
    }
    let median = middle(&mut intervals);
    let mut off: Vec<f64> = intervals.iter().map(|i| (i - median).abs()).collect();
    (median >= 2.0 && middle(&mut off) < 0.3 * median).then_some(median)
}

fn middle(values: &mut [f64]) -> f64 {
    let at = values.len() / 2;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Whether most of a channel's movement lies above a quarter of its sampling rate.
fn is_restless(values: &[f64]) -> bool {
    let curvature: f64 = values
        .windows(3)
        .map(|w| (w[2] - 2.0 * w[1] + w[0]).powi(2))
        .sum();
    curvature > 4.0 * variance(values) * values.len() as f64
}

/// Warnings about single channels, and the stretches (s) where each is clipped.
pub fn examine(recording: &mut Recording) -> Vec<(Channel, Vec<(f64, f64)>)> {
    let mut warnings = Vec::new();
    let mut stretches = Vec::new();
    for (channel, track) in &recording.tracks {
        let grid = recording.clocks[track.clock].grid;
        odd_size(*channel, track, &mut warnings);
        let moves = matches!(channel, Channel::Displacement(_) | Channel::Road(_));
        if moves && !is_constant(&track.values) && is_restless(&track.values) {
            warnings.push(format!(
                "most of the signal in {} is above {:.4} Hz, a quarter of its sampling rate: aliasing or noise",
                channel.name(),
                0.25 * grid.rate_hz()
            ));
        }
        if !channel.is_essential() {
            continue;
        }
        let runs = clipped(&track.values);
        if runs.is_empty() {
            continue;
        }
        let samples: usize = runs.iter().map(|(a, b)| b - a + 1).sum();
        let values = |i: usize| track.values[i];
        if matches!(channel, Channel::Force(_)) && is_at_its_limits(&track.values, &runs) {
            warnings.push(format!(
                "{} stays at its limits of ±{} for {:.3} s: interpreted as a saturated drive and trusted; if the sensor saturates \
                 instead, k and B are wrong",
                channel.name(),
                size(*channel, amplitude(&track.values)),
                samples as f64 * grid.step_s
            ));
            continue;
        }
        let at = runs
            .iter()
            .map(|(a, _)| values(*a))
            .fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m });
        warnings.push(format!(
            "{} is clipped at {} for {:.3} s in {} stretch(es); they are not trusted",
            channel.name(),
            size(*channel, at),
            samples as f64 * grid.step_s,
            runs.len()
        ));
        let knots = recording.clocks[track.clock].knots.as_deref();
        let time = |i: usize| grid.start_s + knots.map_or(i as f64, |k| k[i]) * grid.step_s;
        let times = runs.iter().map(|(a, b)| (time(*a), time(*b))).collect();
        stretches.push((*channel, times));
    }
    recording.warnings.append(&mut warnings);
    stretches
}

fn odd_size(channel: Channel, track: &Track, warnings: &mut Vec<String>) {
    let amplitude = amplitude(&track.values);
    let (least, most) = match channel {
        Channel::Displacement(_) | Channel::Road(_) | Channel::Deflection(_) => (1e-6, 1.0),
        Channel::Acceleration(_) => (1e-3, 1e3),
        Channel::Force(_) => (0.0, 1e5),
        Channel::Speed | Channel::LateralSpeed => (0.0, 40.0),
        Channel::Cadence => (0.0, 250.0),
        Channel::Roll | Channel::Steer => (0.0, std::f64::consts::PI),
        Channel::YawRate => (0.0, 20.0),
        Channel::Time => return,
    };
    if amplitude > most || amplitude > 0.0 && amplitude < least {
        warnings.push(format!(
            "{} moves by ±{} {}, unusual for a bicycle: is the unit ({}) right?",
            channel.name(),
            significant(amplitude, 4),
            channel.dimension().si_name(),
            track.spec.unit.name
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 7u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        (0..n).map(|_| uniform() + uniform() + uniform()).collect()
    }

    #[test]
    fn clipped_peaks_are_found() {
        let sine: Vec<f64> = (0..1000).map(|i| (i as f64 * 0.13).sin()).collect();
        assert_eq!(clipped(&sine), []);
        let cut: Vec<f64> = sine.iter().map(|v| v.min(0.8)).collect();
        let runs = clipped(&cut);
        assert!(
            runs.len() > 15 && runs.iter().all(|(a, b)| b - a > 5),
            "{runs:?}"
        );
        let both: Vec<f64> = sine.iter().map(|v| v.clamp(-0.9, 0.8)).collect();
        assert!(clipped(&both).len() > 2 * runs.len() - 3);
    }

    #[test]
    fn quantised_peaks_and_rest_are_not_clipped() {
        let coarse: Vec<f64> = (0..1000)
            .map(|i| (20.0 * (i as f64 * 0.1).sin()).round())
            .collect();
        assert_eq!(clipped(&coarse), []);
        let rest: Vec<f64> = (0..500)
            .map(|i| {
                if i < 200 {
                    0.0
                } else {
                    (i as f64 - 200.0).powi(3)
                }
            })
            .collect();
        assert_eq!(clipped(&rest), []);
        assert_eq!(clipped(&[1.0; 50]), []);
    }

    #[test]
    fn a_drive_at_its_limits_is_reported_from_a_sensor_that_reads_no_more() {
        let sine = |i: usize| (i as f64 * 0.13).sin();
        let saturated: Vec<f64> = (0..1000)
            .map(|i| (2.0 * sine(i)).clamp(-0.5, 0.5))
            .collect();
        assert!(is_at_its_limits(&saturated, &clipped(&saturated)));
        let now_and_then: Vec<f64> = (0..1000).map(|i| sine(i).clamp(-0.995, 0.995)).collect();
        assert!(!is_at_its_limits(&now_and_then, &clipped(&now_and_then)));
        let one_sided: Vec<f64> = (0..1000).map(|i| sine(i).min(0.5)).collect();
        assert!(!is_at_its_limits(&one_sided, &clipped(&one_sided)));
    }

    #[test]
    fn noise_at_the_crossings_hides_no_swing() {
        let n = noise(20_000);
        let swing = |i: usize| (1.0 - i as f64 / 30_000.0) * (i as f64 * 4e-3).sin();
        let noisy: Vec<f64> = (0..20_000).map(|i| swing(i) + 0.05 * n[i]).collect();
        assert!(is_free_motion(&noisy));
    }

    #[test]
    fn free_motion_is_reported_from_noise() {
        let n = noise(2000);
        assert!(!is_free_motion(&n));
        let decay = |i: usize| 20.0 * (-(i as f64) / 200.0).exp() * (i as f64 * 0.3).cos();
        let decaying: Vec<f64> = (0..2000).map(|i| decay(i) + n[i]).collect();
        assert!(is_free_motion(&decaying));
        let late: Vec<f64> = (0..2000)
            .map(|i| n[i] + if i < 700 { 20.0 } else { decay(i - 700) })
            .collect();
        assert!(is_free_motion(&late));
        let steady: Vec<f64> = (0..2000)
            .map(|i| 20.0 * (i as f64 * 0.3).cos() + n[i])
            .collect();
        assert!(is_free_motion(&steady));
        let mut slow = 0.0;
        let coloured: Vec<f64> = n
            .iter()
            .map(|e| {
                slow = 0.98 * slow + e;
                slow
            })
            .collect();
        assert!(!is_free_motion(&coloured));
        assert!(is_restless(&n) && !is_restless(&decaying));
    }
}
