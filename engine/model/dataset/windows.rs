//! Short windows of a record, from which models are judged where one simulation of all of it would only show its drift: where a
//! mass is damped lightly or no spring holds it, the error of a long simulation is one of phase.

use std::ops::Range;

use super::track::Track;
use crate::policy;
use veloid_core::numerics::spectrum::median_frequency;
use veloid_core::numerics::statistics::variance;

/// Samples that a window has at least.
const LEAST: usize = 16;
/// Samples in windows at most, so that a long record costs no more than its physics need; windows are then left out evenly.
const MOST: usize = 6000;
/// Share of a window's samples that are valid at least.
const VALID: f64 = 0.9;

/// Windows of one axle's record, one after the other.
#[derive(Clone, Debug)]
pub struct Windows {
    /// Period (s) below and above which half of the motion's power lies: of the swing in a free decay, of the rate of the
    /// deflection where something drives the axle.
    pub period: f64,
    pub spans: Vec<Range<usize>>,
}

impl Windows {
    /// Windows `times` as long as ordinary ones; none where the record has too few of a sensible length.
    pub fn of(track: &Track, samples: usize, times: f64) -> Option<Self> {
        let step = track.input.step;
        let driven = track.has_road || track.input.force.is_some();
        let period = dominant_period(track)?;
        let natural = match track.swings() {
            true => track.scale.period(),
            false => 0.0,
        };
        let wanted = times
            * (policy::DOMINANT_PERIODS * period).max(policy::NATURAL_PERIODS * natural)
            / step;
        // What no fit looks at at a ride's start is no loss here, where every window has a start of its own.
        let first = track.valid.iter().position(|valid| *valid)?;
        let samples = samples - first;
        let length = length(wanted as usize, samples);
        if is_too_short((length as f64) * step, period) {
            return None;
        }
        let starts = (first..first + samples).step_by(length);
        let all = starts.map(|start| start..start + length);
        let all = all.take_while(|span| span.end <= first + samples);
        let valid = |span: &Range<usize>| {
            let valid = track.valid[span.clone()].iter().filter(|v| **v).count();
            valid as f64 >= VALID * length as f64
        };
        let mut spans: Vec<Range<usize>> = all.filter(valid).collect();
        if !driven {
            spans = swinging(track, spans);
        }
        let spans = thinned(spans, MOST / length);
        (spans.len() >= policy::FEWEST_WINDOWS).then_some(Self { period, spans })
    }

    /// Windows of the same length that begin in the middle of these.
    pub fn between(&self, samples: usize) -> Option<Self> {
        let half = self.length() / 2;
        let shifted = self.spans.iter().map(|s| s.start + half..s.end + half);
        let spans: Vec<Range<usize>> = shifted.filter(|s| s.end <= samples).collect();
        (spans.len() + 1 >= policy::FEWEST_WINDOWS).then_some(Self { spans, ..*self })
    }

    /// Samples in each window.
    pub fn length(&self) -> usize {
        self.spans.first().map_or(0, Range::len)
    }
}

/// Samples in a window: as many as are wanted, as long as there is room for [`policy::FEWEST_WINDOWS`].
fn length(wanted: usize, samples: usize) -> usize {
    wanted.clamp(LEAST, (samples / policy::FEWEST_WINDOWS).max(LEAST))
}

/// Whether a window of so many seconds shows too little of a motion of that dominant period (s).
fn is_too_short(seconds: f64, period: f64) -> bool {
    seconds < policy::SHORTEST_PERIODS * period
}

/// The period (s) below and above which half of the motion's power lies; nothing where a record is too short to show.
pub fn dominant_period(track: &Track) -> Option<f64> {
    let driven = track.has_road || track.input.force.is_some();
    let moved: Vec<f64> = match (track.input.prescribed, driven) {
        (true, _) => track.input.road.clone(),
        (false, true) => (track.input.road.iter().zip(&track.measured))
            .map(|(u, z)| u - z)
            .collect(),
        (false, false) => track.measured.clone(),
    };
    Some(median_frequency(&moved, driven, track.input.step)?.recip())
}

/// The windows of a free decay in which something swings.
fn swinging(track: &Track, spans: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let deviation = |span: &Range<usize>| variance(&track.measured[span.clone()]).sqrt();
    let loudest = spans.iter().map(deviation).fold(0.0, f64::max);
    let swings = |span: &Range<usize>| deviation(span) >= policy::SWINGS * loudest;
    let some: Vec<Range<usize>> = spans.iter().filter(|s| swings(s)).cloned().collect();
    match some.len() >= policy::FEWEST_WINDOWS {
        true => some,
        false => spans.into_iter().take(policy::FEWEST_WINDOWS).collect(),
    }
}

/// At most so many windows (and [`policy::FEWEST_WINDOWS`] at least), spread evenly.
fn thinned(spans: Vec<Range<usize>>, most: usize) -> Vec<Range<usize>> {
    let (all, most) = (spans.len(), most.max(policy::FEWEST_WINDOWS));
    if all <= most {
        return spans;
    }
    (0..most).map(|w| spans[w * all / most].clone()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn windows_are_shorter_where_there_is_no_room_for_enough() {
        assert_eq!(length(320, 100 * policy::FEWEST_WINDOWS), 100);
        assert_eq!(length(40, 100 * policy::FEWEST_WINDOWS), 40);
        assert_eq!(length(320, 60), LEAST);
    }

    #[test]
    fn windows_are_left_out_evenly_and_never_below_the_fewest() {
        let spans: Vec<Range<usize>> = (0..100).map(|w| 10 * w..10 * w + 10).collect();
        let some = thinned(spans.clone(), 20);
        assert_eq!(some.len(), 20);
        assert!(some.windows(2).all(|w| w[1].start - w[0].start == 50));
        assert_eq!(thinned(spans, 3).len(), policy::FEWEST_WINDOWS);
    }

    const STEP: f64 = 0.01;

    /// A mass on no spring that moves so, let go.
    fn free(samples: usize, height: impl Fn(f64) -> f64) -> Track {
        let mut track = crate::example::dataset().tracks[0].clone();
        assert_eq!(track.input.step, STEP);
        track.set_road(&vec![0.0; samples]);
        track.has_road = false;
        track.plant = &veloid_core::plant::Damper::MOVING;
        track.measured = (0..samples).map(|i| height(STEP * i as f64)).collect();
        track.valid = vec![true; samples];
        track
    }

    #[test]
    fn an_ordinary_window_holds_so_many_dominant_or_natural_periods() {
        let samples = 12000;
        let mut track = free(samples, |t| (std::f64::consts::TAU * t / 0.5).sin());
        let seconds = |track: &Track| {
            let windows = Windows::of(track, samples, 1.0).unwrap();
            STEP * windows.length() as f64
        };
        let period = dominant_period(&track).unwrap();
        assert!((period / 0.5 - 1.0).abs() < 0.1, "{period}");
        let dominant = policy::DOMINANT_PERIODS * period;
        assert!((seconds(&track) - dominant).abs() <= STEP);
        // A spring on which the mass would swing so slowly, and which is felt.
        let mut sprung = |natural: f64| {
            track.plant = &veloid_core::plant::Axle::MOVING;
            track.scale.k = track.scale.mass * (std::f64::consts::TAU / natural).powi(2);
            track.scale.a_rms = 1e-9;
            track.scale.train_s = 100.0;
            seconds(&track)
        };
        let longer = 1.5 * dominant / policy::NATURAL_PERIODS;
        assert!((sprung(longer) - policy::NATURAL_PERIODS * longer).abs() <= STEP);
        let shorter = 0.5 * dominant / policy::NATURAL_PERIODS;
        assert!((sprung(shorter) - dominant).abs() <= STEP);
    }

    #[test]
    fn a_window_holds_a_period_at_least() {
        let least = policy::SHORTEST_PERIODS * 0.7;
        assert!(is_too_short(0.99 * least, 0.7) && !is_too_short(1.01 * least, 0.7));
        // In a record of some periods as many windows as are needed hold none of them.
        let swing = |t: f64| (std::f64::consts::TAU * t).sin();
        assert!(Windows::of(&free(200, swing), 200, 1.0).is_none());
        assert!(Windows::of(&free(1200, swing), 1200, 1.0).is_some());
    }

    #[test]
    fn what_has_died_away_does_not_swing() {
        let long = policy::FEWEST_WINDOWS;
        let spans: Vec<Range<usize>> = (0..long + 4).map(|w| 100 * w..100 * w + 100).collect();
        // Whole swings, loud up to a window, then quiet ones.
        let swinging = |loud: usize, quiet: f64| {
            let size = |t: f64| if t < loud as f64 - 1e-9 { 1.0 } else { quiet };
            let swing = |t: f64| size(t) * (std::f64::consts::TAU * t / 0.2).sin();
            super::swinging(&free(100 * (long + 4), swing), spans.clone()).len()
        };
        assert_eq!(swinging(long, 1.01 * policy::SWINGS), long + 4);
        assert_eq!(swinging(long, 0.99 * policy::SWINGS), long);
        // Of a decay that dies before there are enough, the first are taken.
        assert_eq!(swinging(2, 0.99 * policy::SWINGS), policy::FEWEST_WINDOWS);
    }
}
