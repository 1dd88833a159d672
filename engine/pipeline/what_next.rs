//! How well each quantity is known, and which ride would halve its interval.

use veloid_core::bicycle::Axle;
use veloid_core::document::format_number::{WIDE, significant};
use veloid_report::{AxleResult, Parameters, Report};
use veloid_ride::{AxleRecord, Ride};

/// Share of a quantity's variance from which one cause counts as its limit: more than all others together.
const MAIN: f64 = 0.5;

/// What to do next, one sentence for each axle with an interval, after what would distinguish tied explanations.
pub fn what_next(ride: &Ride, report: &Report) -> Vec<String> {
    let planned = report.diagnosis.as_ref().and_then(|d| d.next_ride.as_ref());
    let planned = planned.map(|ride| {
        format!(
            "As {}, {} (predicted gain in log likelihood {}).",
            ride.why,
            ride.what.trim_end_matches('.'),
            significant(ride.predicted_separation, 2)
        )
    });
    let axles = report.result.iter();
    planned
        .into_iter()
        .chain(axles.flat_map(|(axle, result)| of_axle(ride, report, axle, result)))
        .collect()
}

/// A quantity with an interval.
struct Known {
    name: &'static str,
    /// Half the 95 % interval as a share of the value (%).
    percent: f64,
    /// What most of its error comes from, and what to do about it; nothing where it is the fit's own.
    limit: Option<[&'static str; 2]>,
}

fn of_axle(ride: &Ride, report: &Report, axle: Axle, result: &AxleResult) -> Vec<String> {
    let known: Vec<Known> = (["k", "B"].into_iter())
        .filter_map(|name| known(report, axle, result, name))
        .collect();
    let title = axle.title();
    let listed = |of: &[&Known]| -> String {
        let each = of.iter().enumerate().map(|(i, k)| {
            let is = if i == 0 { "is known " } else { "" };
            format!("{} {is}to {} %", k.name, significant(k.percent, 2))
        });
        each.collect::<Vec<_>>().join(" and ")
    };
    let by_fit: Vec<&Known> = known.iter().filter(|k| k.limit.is_none()).collect();
    let mut sentences = Vec::new();
    if !by_fit.is_empty() {
        sentences.push(format!(
            "{title} axle: {}; {} halves {}.",
            listed(&by_fit),
            longer(ride.axles.get(axle), ride.duration_s()),
            if by_fit.len() > 1 {
                "both intervals"
            } else {
                "the interval"
            }
        ));
    }
    sentences.extend(known.iter().filter_map(|k| {
        let [cause, cure] = k.limit?;
        Some(format!(
            "{title} axle: {}, limited by {cause}; {cure}.",
            listed(&[k])
        ))
    }));
    sentences
}

fn known(report: &Report, axle: Axle, result: &AxleResult, name: &'static str) -> Option<Known> {
    let quantity = result.get(name)?;
    let (value, error) = (quantity.value?, quantity.std_error?);
    let causes = [
        (
            &report.mass_error,
            [
                "the mass's standard deviation",
                "weigh what the wheel carries more precisely",
            ],
        ),
        (
            &report.road_noise_error,
            [
                "noise in the road channel",
                "record the road with a better sensor, or ride over a rougher one",
            ],
        ),
        (
            &report.laser_error,
            [
                "the laser's clock and noise",
                "log the laser and the accelerometer on one clock",
            ],
        ),
        (
            &report.interpolation_error,
            ["the road between its samples", "log at twice the rate"],
        ),
    ];
    let of = |by: &Parameters| match name {
        "k" => by.k_n_m,
        _ => by.b_n_s_m,
    };
    let main = |(errors, words): (
        &veloid_core::bicycle::PerAxle<Parameters>,
        [&'static str; 2],
    )| {
        let share = (of(errors.get(axle)?) / error).powi(2);
        (share > MAIN).then_some(words)
    };
    Some(Known {
        name,
        percent: 100.0 * WIDE * error / value.abs(),
        limit: causes.into_iter().find_map(main),
    })
}

/// A ride like this one that brings four times as much.
fn longer(record: Option<&AxleRecord>, duration_s: f64) -> String {
    let seconds = significant(4.0 * duration_s, 2);
    let has_force = record.is_some_and(|record| record.force.is_some());
    match record.is_none_or(AxleRecord::has_road) {
        true => {
            format!("a ride four times as long ({seconds} s), or one over a road twice as rough,")
        }
        false if has_force => {
            format!("a record four times as long ({seconds} s), or twice the force,")
        }
        false => "four releases, or one from twice the height,".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::pipeline::identify::identify;
    use veloid_core::Silent;
    use veloid_core::bicycle::{Bike, PerAxle};
    use veloid_core::settings::Settings;
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    fn ride_and_report() -> (Ride, Report) {
        let simulated = SimulatedRide {
            duration_s: 10.0,
            noise_displacement_m: 5e-5,
            rear: None,
            ..SimulatedRide::default()
        };
        let bike = Bike {
            mass_front_kg: simulated.front.map(|spring| spring.mass_kg),
            ..Bike::default()
        };
        let settings = Settings {
            trials: 1,
            diagnosis: false,
            ..Settings::default()
        };
        let ride = simulated.ride();
        let report = identify(&ride, &bike, &settings, &Silent).unwrap();
        (ride, report)
    }

    #[test]
    fn an_interval_by_the_fit_asks_for_a_longer_ride_and_one_by_a_cause_for_its_cure() {
        let (ride, mut report) = ride_and_report();
        assert_eq!(report.what_next, what_next(&ride, &report));
        let [one] = &report.what_next[..] else {
            panic!("{:?}", report.what_next)
        };
        assert!(
            one.starts_with("Front axle: k is known to ") && one.contains(" and B to "),
            "{one}"
        );
        assert!(one.contains("four times as long (40 s)"), "{one}");

        let error = report
            .result
            .front
            .as_ref()
            .unwrap()
            .get("k")
            .unwrap()
            .std_error
            .unwrap();
        for (share, limited) in [(0.99 * MAIN, false), (1.01 * MAIN, true)] {
            report.mass_error = PerAxle {
                front: Some(Parameters {
                    k_n_m: share.sqrt() * error,
                    b_n_s_m: 0.0,
                }),
                rear: None,
            };
            let next = what_next(&ride, &report).join(" ");
            assert_eq!(
                next.contains("weigh what the wheel carries"),
                limited,
                "{next}"
            );
        }
    }

    #[test]
    fn what_has_no_interval_is_left_to_its_reason() {
        let (ride, mut report) = ride_and_report();
        report.result = PerAxle::default();
        assert!(what_next(&ride, &report).is_empty());
    }
}
