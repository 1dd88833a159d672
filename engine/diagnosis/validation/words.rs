//! The comparison in plain words.

use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::{Quantity, fixed, significant};
use veloid_report::diagnosis::Predicted;
use veloid_report::model_on_ride::{AxleOnRide, ParameterOnRide};

/// Times the sensor's noise up to which what is left passes for it: noise floors are measured to within a third.
const NOISE: f64 = 1.3;

/// The sentences of all axles.
pub fn all(axles: &PerAxle<AxleOnRide>) -> String {
    let sentences = axles.iter().map(|(_, axle)| axle.sentence.as_str());
    sentences.collect::<Vec<_>>().join(" ")
}

/// How well one axle is predicted, and what differs.
pub fn axle(axle: Axle, found: &AxleOnRide) -> String {
    format!(
        "{} axle: the model {} (fit {} %); {}. {}{}",
        axle.title(),
        explained(found),
        percent(found.model.fit_percent),
        left(found),
        numbers(found),
        missing(found)
    )
}

fn explained(found: &AxleOnRide) -> String {
    let what = match found.predicted {
        Predicted::Force => "force",
        _ => "motion",
    };
    match found.model.explained_percent {
        share if share > 0.0 => format!("explains {} % of the {what}", percent(share)),
        _ => format!("explains none of the {what}"),
    }
}

/// A percentage with two digits of what is missing to 100.
pub fn percent(share: f64) -> String {
    let missing = (100.0 - share).abs();
    match missing > 0.0 {
        true => fixed(
            share,
            (1.0 - missing.log10().floor()).clamp(0.0, 6.0) as i32,
        ),
        false => "100".to_owned(),
    }
}

fn left(found: &AxleOnRide) -> String {
    let rms = found.model.rms;
    let size = Quantity::rough(rms, 3, found.predicted.unit());
    match found.noise.filter(|noise| *noise > 0.0) {
        Some(noise) if rms < NOISE * noise => {
            format!("what is left, {size}, is the sensor's noise")
        }
        Some(noise) => format!(
            "what is left, {size}, is {} times the sensor's noise{}",
            significant(rms / noise, 2),
            bands(found)
        ),
        None => format!(
            "what is left is {size} (the sensor's noise could not be measured here){}",
            bands(found)
        ),
    }
}

/// Where the model leaves more than one fitted to the ride.
fn bands(found: &AxleOnRide) -> String {
    let band = |[low, high]: &[f64; 2]| {
        format!("{} to {} Hz", significant(*low, 2), significant(*high, 2))
    };
    let bands: Vec<String> = found.bands_hz.iter().map(band).collect();
    let bands = match bands.split_last() {
        None => return String::new(),
        Some((last, [])) => last.clone(),
        Some((last, before)) => format!("{} and {last}", before.join(", ")),
    };
    format!(", more than a fit to this ride would leave at {bands}")
}

/// A number of the model: `coulomb_friction.friction` as "coulomb friction".
pub fn quantity(name: &str) -> String {
    let words = |text: &str| text.replace('_', " ");
    match name.split_once('.') {
        Some((effect, number)) if words(effect).contains(&words(number)) => words(effect),
        Some((effect, number)) => format!("{} of the {}", words(number), words(effect)),
        None => name.to_owned(),
    }
}

/// Which numbers differ by more than their intervals allow.
fn numbers(found: &AxleOnRide) -> String {
    let one = |p: &ParameterOnRide| {
        format!(
            "{} is {} here and {} in the model",
            quantity(&p.name),
            Quantity::new(p.ride, p.ride_std_error, &p.unit),
            Quantity::new(p.model, p.model_std_error, &p.unit)
        )
    };
    let differing = found.parameters.iter().filter(|p| p.differs == Some(true));
    let differing: Vec<String> = differing.map(one).collect();
    let more = found.refitted.map(|fit| found.model.rms / fit.rms);
    match found.differs {
        None if found.refitted.is_none() => {
            "No fit of it to this ride leaves less, so that its numbers are not compared."
                .to_owned()
        }
        None => "Whether its numbers hold here cannot be said without intervals.".to_owned(),
        Some(false) => match more.filter(|more| *more > NOISE) {
            Some(more) => format!(
                "Its numbers hold here within their intervals, though a fit to this ride would leave {} times less.",
                significant(more, 2)
            ),
            None => "Its numbers hold here within their intervals.".to_owned(),
        },
        Some(true) => format!(
            "This differs by more than the intervals allow: {}.",
            differing.join("; ")
        ),
    }
}

/// That no numbers of this model explain the ride.
fn missing(found: &AxleOnRide) -> String {
    let Some((noise, fit)) = found.noise.zip(found.refitted) else {
        return String::new();
    };
    match fit.rms > NOISE * noise && noise > 0.0 {
        true => format!(
            " Fitted to this ride it would still leave {}, {} times the noise: something acts here that is not in the model.",
            Quantity::rough(fit.rms, 3, found.predicted.unit()),
            significant(fit.rms / noise, 2)
        ),
        false => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_report::model_on_ride::FitOnRide;

    #[test]
    fn shares_have_two_digits_of_what_is_missing() {
        for (share, text) in [
            (99.99824, "99.9982"),
            (98.52, "98.5"),
            (42.0, "42"),
            (100.0, "100"),
        ] {
            assert_eq!(percent(share), text);
        }
    }

    #[test]
    fn noise_passes_for_noise_up_to_its_uncertainty() {
        let of = |rms: f64| {
            let fit = FitOnRide {
                rms,
                largest: 3.0 * rms,
                fit_percent: 99.0,
                explained_percent: 99.99,
            };
            AxleOnRide {
                model: fit,
                refitted: Some(fit),
                noise: Some(1e-4),
                bands_hz: vec![[8.0, 11.0]],
                ..AxleOnRide::default()
            }
        };
        let said = axle(Axle::Front, &of(0.99 * NOISE * 1e-4));
        assert!(
            said.contains("is the sensor's noise") && !said.contains("Hz"),
            "{said}"
        );
        assert!(!said.contains("something acts"), "{said}");
        let said = axle(Axle::Front, &of(1.01 * NOISE * 1e-4));
        assert!(said.contains("1.3 times the sensor's noise"), "{said}");
        assert!(
            said.contains("8.0 to 11 Hz") && said.contains("something acts"),
            "{said}"
        );
    }
}
