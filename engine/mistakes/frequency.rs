//! Natural frequencies that no axle has: sqrt(k/m)/(2 pi) and the sag g m/k do not depend on the size of the bicycle, but on the unit of the
//! times.

use std::f64::consts::TAU;

use veloid_core::bicycle::{Axle, Bike, GRAVITY, Kind, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_methods::output_error::AxleFit;
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::Ride;

/// Natural frequencies (Hz) that an axle may have: at 0.2 Hz it sags 6 m under its load, and the lightest mass of a bike file (0.1 kg) on a
/// tyre of 300 kN/m swings at 280 Hz.
const AXLES_HZ: std::ops::Range<f64> = 0.2..300.0;
/// Those that bicycles with riders have (Hz): 2.5 Hz of a soft fork to 20 Hz of a hard tyre, and a factor beyond.
const USUAL_HZ: std::ops::Range<f64> = 1.0..40.0;
/// Units (s) that times may be in instead, and how the header says so.
const UNITS: [(f64, &str, &str); 5] = [
    (1e-3, "milliseconds", "state it in the header, as in t [ms]"),
    (1e-6, "microseconds", "state it in the header, as in t [us]"),
    (60.0, "minutes", "state it in the header, as in t [min]"),
    (
        1e-2,
        "hundredths of a second",
        "give the rate with rate_hz (--rate HZ)",
    ),
    (
        1e3,
        "units a thousand times larger",
        "the header's unit is too small",
    ),
];

/// Axles on a road whose natural frequency is none; a bench may have any.
pub fn mistakes(ride: &Ride, bike: &Bike, fitted: &PerAxle<AxleFit>) -> Vec<Mistake> {
    if bike.kind == Some(Kind::Bench) {
        return Vec::new();
    }
    let of_axle = |(axle, fit): (Axle, &AxleFit)| {
        let record = ride.axles.get(axle)?;
        let is_ridden = record.has_road() && record.force.is_none() && !record.prescribed;
        let kappa = fit.plain.kappa;
        let is_shown = fit.estimate(true).reportable().k_std_n_m.is_some();
        let frequency = kappa.max(0.0).sqrt() / TAU;
        let is_odd = kappa > 0.0 && !AXLES_HZ.contains(&frequency);
        (is_ridden && is_shown && is_odd).then(|| mistake(axle, frequency, GRAVITY / kappa))
    };
    fitted.iter().filter_map(of_axle).collect()
}

fn mistake(axle: Axle, frequency: f64, sag: f64) -> Mistake {
    let cures: Vec<String> = (UNITS.iter())
        .filter(|(unit, ..)| USUAL_HZ.contains(&(frequency / unit)))
        .map(|(unit, name, cure)| {
            let plausible = significant(frequency / unit, 2);
            format!("With times in {name} it would be {plausible} Hz: {cure}.")
        })
        .collect();
    let cure = match cures.is_empty() {
        true => "Check the units of times, displacements and masses.".to_owned(),
        false => cures.join(" "),
    };
    let [frequency, sag] = [frequency, sag].map(|x| significant(x, 2));
    let [least, most] = [AXLES_HZ.start, AXLES_HZ.end];
    Mistake {
        kind: MistakeKind::WrongUnit,
        sentence: format!(
            "By this ride the {axle} axle swings at {frequency} Hz and sags {sag} m under its load; axles lie between {least} and {most} Hz. \
             {cure} If this is a bench with such numbers, say so in the bike file: \"kind\": \"bench\"."
        ),
        takes_the_verdict: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::settings::Settings;
    use veloid_methods::output_error::{self, start::Start};
    use veloid_methods::simulate::simulated_ride::SimulatedRide;

    /// What is said of a ride whose times read so many times too long.
    fn found(longer: f64, kind: Option<Kind>) -> Vec<String> {
        let mut ride = SimulatedRide::default().ride();
        let bike = Bike {
            mass_front_kg: Some(23.0),
            mass_rear_kg: Some(63.0),
            kind,
            ..Bike::default()
        };
        let truth = output_error::fit(&ride, &bike, &Settings::default(), &[]);
        let start = truth.map_or_else(
            |_| PerAxle::default(),
            |fits| {
                fits.map(|_, fit| Start {
                    kappa: fit.plain.kappa / longer.powi(2),
                    beta: fit.plain.beta / longer,
                    per_mass: fit.plain.per_mass,
                })
            },
        );
        ride.step_s *= longer;
        let fits = output_error::fit(&ride, &bike, &Settings::default(), &[start]);
        let fits = fits.unwrap_or_else(|fault| panic!("{fault}"));
        let said = mistakes(&ride, &bike, &fits);
        said.into_iter().map(|mistake| mistake.sentence).collect()
    }

    #[test]
    fn the_unit_that_would_make_an_axle_of_it_is_named() {
        assert_eq!(found(1.0, None), Vec::<String>::new());
        let said = found(1e3, None);
        assert!(said[0].contains("as in t [ms]"), "{said:?}");
        assert!(found(100.0, None)[0].contains("hundredths"));
        assert!(found(1e3, Some(Kind::Bench)).is_empty());
    }
}
