//! Intervals and verdicts of rides whose road was made from a laser: its clock and its noise are in question.

use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_core::numerics::statistics::normal_tail;
use veloid_report::{Estimate, LatentRoad, Parameters};
use veloid_ride::SensorClock;

/// Largest shares of k and of B that a laser's clock (by one standard error) and noise may move them by in a ride that carries a
/// verdict: what is predicted of a bench whose clocks were set right (issue 20: k within 1 %, B within 3 %).
const MOST: Parameters = Parameters {
    k_n_m: 0.01,
    b_n_s_m: 0.03,
};

/// Estimates whose intervals bear the laser's errors too.
pub fn widened(estimates: &PerAxle<Estimate>, by: &PerAxle<Parameters>) -> PerAxle<Estimate> {
    estimates.map(|axle, e| match by.get(axle) {
        Some(by) => e.clone().widened(by),
        None => e.clone(),
    })
}

/// What something makes of the intervals, in words: `what` it is, and what is meant by it.
pub fn notes(
    found: &PerAxle<Estimate>,
    by: &PerAxle<Parameters>,
    what: &str,
    meant: &str,
) -> Vec<String> {
    let note = |(axle, by): (Axle, &Parameters)| {
        let e = found.get(axle)?;
        let [k, b] = by.shares_of(e).map(|share| significant(100.0 * share, 2));
        Some(format!(
            "{axle} axle: {what} moves k by {k} % and B by {b} % ({meant}); included in the intervals"
        ))
    };
    by.iter().filter_map(note).collect()
}

/// Whether there are files whose clocks nobody knows, and k and B rest on them.
pub fn are_unplaced(clocks: &[SensorClock]) -> bool {
    let unknown = |clock: &SensorClock| clock.found.is_none() && clock.file.is_some();
    clocks.iter().any(unknown)
}

/// Why a ride's laser lets nobody say what is missing.
pub fn misleading(
    clocks: &[SensorClock],
    found: &PerAxle<Estimate>,
    by: &PerAxle<Parameters>,
) -> Option<String> {
    let unknown = clocks.iter().find(|c| c.found.is_none());
    if let Some(clock) = unknown {
        let rests = match are_unplaced(clocks) {
            true => "Both determine k and B",
            false => "The road is computed from both",
        };
        return Some(format!(
            "No verdict: {}. {rests}. Record both on one logger, or shake both at the start and at the end so that their clocks \
             can be compared.",
            clock.summary()
        ));
    }
    let wide = |(axle, by): (Axle, &Parameters)| {
        let e = found.get(axle)?;
        let [k, b] = by.shares_of(e);
        (k > MOST.k_n_m || b > MOST.b_n_s_m).then(|| {
            format!(
                "No verdict: the laser from which the road was computed moves k of the {axle} axle by {} % and B by {} % (its clock \
                 error and noise), more than the limits of {} % and {} %. Use a faster or finer laser on the accelerometers' logger, a \
                 longer ride or a rougher road.",
                significant(100.0 * k, 2),
                significant(100.0 * b, 2),
                significant(100.0 * MOST.k_n_m, 2),
                significant(100.0 * MOST.b_n_s_m, 2),
            )
        })
    };
    by.iter().find_map(wide)
}

/// Why a clock that was set right may be physics that is missing: what delays a force (a viscoelastic tyre, mass below the sensor)
/// passes for a clock. Where both axles determine k and B without the road, they show which: these and output error then agree, at the
/// family-wise significance level `alpha` or to within what is believed.
pub fn unconfirmed(
    clocks: &[SensorClock],
    found: &PerAxle<Estimate>,
    latent: Option<&LatentRoad>,
    alpha: f64,
) -> Option<String> {
    let clock = clocks.iter().find(|c| c.applied)?;
    let latent = latent.map(LatentRoad::axles).unwrap_or_default();
    let pairs: Vec<Pair> = (found.iter())
        .filter_map(|(axle, e)| Pair::of(axle, e, latent.get(axle)?))
        .collect();
    let summary = clock.summary();
    if pairs.is_empty() {
        return Some(format!(
            "No verdict: {summary}, and an effect that delays a force looks the same as a late clock. k and B are valid if nothing is \
             missing. Record both sensors on one logger, or add an accelerometer on the other axle and the speed."
        ));
    }
    let rate = alpha / (2 * pairs.len()) as f64;
    let axle = pairs.iter().find(|pair| pair.parts(rate))?.axle;
    Some(format!(
        "No verdict: {summary}, but k and B of the {axle} axle then differ from those of the accelerometers alone (`latent_road`). \
         Either the clocks run differently, or missing physics looks like a late clock. Record all sensors on one logger."
    ))
}

/// k and B of one axle by two methods: by what share they differ, and how likely they would by chance.
struct Pair {
    axle: Axle,
    shares: [f64; 2],
    p_values: [f64; 2],
}

impl Pair {
    /// Nothing where one of them has no interval.
    fn of(axle: Axle, one: &Estimate, other: &Estimate) -> Option<Self> {
        let off = [one.k_n_m - other.k_n_m, one.b_n_s_m - other.b_n_s_m].map(f64::abs);
        let k_std = one.k_std_n_m?.hypot(other.k_std_n_m?);
        let b_std = one.b_std_n_s_m?.hypot(other.b_std_n_s_m?);
        Some(Self {
            axle,
            shares: [off[0] / other.k_n_m.abs(), off[1] / other.b_n_s_m.abs()],
            p_values: [off[0] / k_std, off[1] / b_std].map(|z| 2.0 * normal_tail(z)),
        })
    }

    /// Whether k or B differs by more than what is believed, and than chance would at this rate.
    fn parts(&self, rate: f64) -> bool {
        let most = [MOST.k_n_m, MOST.b_n_s_m];
        (0..2).any(|q| self.shares[q] > most[q] && self.p_values[q] < rate)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_ride::ClockOffset;

    fn front<T>(value: T) -> PerAxle<T> {
        PerAxle {
            front: Some(value),
            rear: None,
        }
    }

    fn found() -> PerAxle<Estimate> {
        front(Estimate {
            k_n_m: 1e5,
            b_n_s_m: 1e3,
            k_std_n_m: Some(300.0),
            b_std_n_s_m: Some(4.0),
            mass_kg: 23.0,
            ..Estimate::default()
        })
    }

    #[test]
    fn intervals_bear_the_lasers_errors() {
        let by = front(Parameters {
            k_n_m: 400.0,
            b_n_s_m: 3.0,
        });
        let wide = widened(&found(), &by).front.unwrap();
        assert_eq!((wide.k_std_n_m, wide.b_std_n_s_m), (Some(500.0), Some(5.0)));
        assert_eq!(widened(&found(), &PerAxle::default()), found());
        let notes = notes(&found(), &by, "the laser", "its noise");
        assert!(
            notes[0].contains("k by 0.40 % and B by 0.30 %"),
            "{notes:?}"
        );
    }

    #[test]
    fn a_laser_misleads_that_moves_k_or_b_too_far_or_whose_clock_is_not_known() {
        let said = |k: f64, b: f64, known: bool| {
            let clock = SensorClock {
                found: known.then(ClockOffset::default),
                ..SensorClock::default()
            };
            let by = front(Parameters {
                k_n_m: 1e5 * k * MOST.k_n_m,
                b_n_s_m: 1e3 * b * MOST.b_n_s_m,
            });
            misleading(&[clock], &found(), &by)
        };
        assert_eq!(said(0.99, 0.99, true), None);
        for (k, b, known) in [(1.01, 0.1, true), (0.1, 1.01, true), (0.0, 0.0, false)] {
            let said = said(k, b, known).unwrap();
            assert!(said.starts_with("No verdict: "), "{said}");
        }
        assert_eq!(misleading(&[], &found(), &PerAxle::default()), None);
    }

    #[test]
    fn a_clock_is_confirmed_by_the_accelerometers_alone() {
        let applied = SensorClock {
            found: Some(ClockOffset::default()),
            applied: true,
            ..SensorClock::default()
        };
        let asked = |clock: &SensorClock, k: f64, k_std_n_m: Option<f64>| {
            let latent = LatentRoad {
                front: found().front.map(|e| Estimate {
                    k_n_m: k * e.k_n_m,
                    k_std_n_m,
                    ..e
                }),
                ..LatentRoad::default()
            };
            unconfirmed(std::slice::from_ref(clock), &found(), Some(&latent), 0.01)
        };
        let sure = Some(100.0);
        assert_eq!(asked(&applied, 1.0, sure), None);
        // 1.1 % are 3.5 standard errors, and more than what is believed.
        assert!(
            asked(&applied, 1.0 + 1.1 * MOST.k_n_m, sure)
                .unwrap()
                .contains("accelerometers alone")
        );
        assert_eq!(asked(&applied, 1.0 + 0.9 * MOST.k_n_m, sure), None);
        assert_eq!(asked(&applied, 1.0 + 1.1 * MOST.k_n_m, Some(1000.0)), None);
        assert!(
            asked(&applied, 1.0, None)
                .unwrap()
                .contains("looks the same as a late clock")
        );
        assert_eq!(asked(&SensorClock::default(), 2.0, sure), None);
    }
}
