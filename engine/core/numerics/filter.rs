//! Filters without phase, by Fourier transform.

/// How a record goes on beyond its ends, so that they ring less.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// Reflected in its end points: keeps the slope. For displacements.
    Points,
    /// Mirrored: keeps the mean. For accelerations, whose integral must not run away.
    Mirror,
}

/// Sample `j`, continued beyond the ends by point reflection.
pub fn mirrored(values: &[f64], j: isize) -> f64 {
    let last = values.len() as isize - 1;
    if j < 0 {
        2.0 * values[0] - values[(-j).min(last) as usize]
    } else if j > last {
        2.0 * values[last as usize] - values[(2 * last - j).max(0) as usize]
    } else {
        values[j as usize]
    }
}

/// Shortest stretch (samples) that is transformed at once.
const BLOCK: usize = 1 << 15;

/// `values` (sampled at `rate_hz`) with every frequency (Hz) multiplied by `gain`, whose answer to
/// an impulse must have died away after `reach_s` seconds. Block by block, so that memory does not
/// grow with the record.
pub fn filter(
    values: &[f64],
    rate_hz: f64,
    reach_s: f64,
    beyond: Beyond,
    gain: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let n = values.len();
    let reach = ((reach_s * rate_hz).ceil() as usize).min(n);
    let length = (n + 2 * reach)
        .min(BLOCK.max(4 * reach))
        .next_power_of_two();
    let at = |j: isize| match beyond {
        Beyond::Points => mirrored(values, j),
        Beyond::Mirror => {
            let last = n as isize - 1;
            let inside = if j > last { 2 * last - j } else { j.abs() };
            values[inside.clamp(0, last) as usize]
        }
    };
    let (forward, inverse) = (
        veloid_fourier::forward(length),
        veloid_fourier::inverse(length),
    );
    let mut record = forward.make_input_vec();
    let mut spectrum = forward.make_output_vec();
    let gains: Vec<f64> = (0..spectrum.len())
        .map(|i| gain(i as f64 * rate_hz / length as f64) / length as f64)
        .collect();
    let whole = length - 2 * reach;
    let mut out = Vec::with_capacity(n);
    while out.len() < n {
        let first = out.len() as isize - reach as isize;
        for (i, sample) in record.iter_mut().enumerate() {
            *sample = at(first + i as isize);
        }
        // Both fail only on lengths other than planned.
        let _ = forward.process(&mut record, &mut spectrum);
        for (bin, gain) in spectrum.iter_mut().zip(&gains) {
            *bin *= gain;
        }
        let _ = inverse.process(&mut spectrum, &mut record);
        let take = whole.min(n - out.len());
        out.extend_from_slice(&record[reach..reach + take]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_join_without_a_seam() {
        let values: Vec<f64> = (0..100_000).map(|i| (i as f64 * 0.37).sin()).collect();
        let same = filter(&values, 100.0, 5.0, Beyond::Points, |_| 1.0);
        assert!(values.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-12));
        let low = |hz: f64| 1.0 / (1.0 + (hz / 2.0).powi(4));
        let hz = 0.37 * 100.0 / std::f64::consts::TAU;
        let out = filter(&values, 100.0, 5.0, Beyond::Points, low);
        let off = |i: usize| (out[i] - low(hz) * values[i]).abs();
        assert!((2000..98_000).all(|i| off(i) < 1e-7));
    }

    #[test]
    fn short_records_pass_too() {
        for n in [1, 2, 3, 70] {
            let values = vec![1.5; n];
            let same = filter(&values, 100.0, 100.0, Beyond::Mirror, |_| 1.0);
            assert!(same.len() == n && same.iter().all(|v| (v - 1.5).abs() < 1e-12));
        }
    }
}
