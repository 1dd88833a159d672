//! The verdict in plain words.

use crate::bicycle::{Axle, PerAxle};
use crate::document::format_number::Quantity;
use crate::report::diagnosis::{Base, Diagnosis, HeldOut, Place, Verdict};

fn at(place: Place) -> &'static str {
    match place {
        Place::Front => "front",
        Place::Rear => "rear",
        Place::Both => "both axles",
    }
}

fn set<'a>(effects: impl Iterator<Item = (&'a String, Place)>) -> String {
    effects
        .map(|(id, place)| format!("{} ({})", id.replace('_', " "), at(place)))
        .collect::<Vec<_>>()
        .join(" with ")
}

fn size(rms: f64, unit: &str) -> Quantity {
    Quantity::rough(rms, 3, unit)
}

/// Times the sensor's noise that what is left may be and still pass for it: noise floors are measured to within a third.
const NOISE: f64 = 1.3;

/// That nothing was found, and what that is worth.
fn nothing_missing(held_out: &PerAxle<HeldOut>) -> String {
    let louder = |(axle, held): (Axle, &HeldOut)| {
        let ([plain, _, floor], unit) = held.errors();
        let (rms, floor) = (plain?, floor?);
        (rms > NOISE * floor).then_some((axle, rms, floor, unit))
    };
    match held_out.iter().find_map(louder) {
        Some((axle, rms, floor, unit)) => format!(
            "Nothing that this ride could show is missing beside the plain spring and damper, but on the {axle} axle they leave {}, \
             and the sensor's noise is {}.",
            size(rms, unit),
            size(floor, unit)
        ),
        None => "The plain spring and damper explain this ride to within its noise; nothing that this ride could show is missing."
            .to_owned(),
    }
}

/// One to three sentences for a person who has not read the report. Why a record carries no verdict stands in it already.
pub fn sentence(d: &Diagnosis) -> String {
    let base = match d.base {
        Base::SpringAndDamper => "",
        Base::Damper => "No spring brings this mass back, so the plain model is a damper alone. ",
    };
    base.to_owned() + &said(d)
}

fn said(d: &Diagnosis) -> String {
    let gains = gains(d);
    let found = set(d.effects.iter().map(|e| (&e.id, e.axle)));
    match d.verdict {
        Verdict::NothingMissing => nothing_missing(&d.held_out),
        Verdict::Named => {
            let parts: Vec<&str> = d.effects.iter().map(|e| e.sentence.as_str()).collect();
            let parts = parts.join("; ");
            let margins = if parts.contains('±') {
                " (intervals of 95 %)"
            } else {
                ""
            };
            format!("The plain model leaves something out: {parts}{margins}. {gains}")
        }
        Verdict::NamedInPart => in_part(d) + &gains,
        Verdict::CannotTell => d.sentence.clone(),
        Verdict::Ambiguous => {
            let others = d.alternatives.iter();
            let others: Vec<String> = others
                .map(|names| set(names.iter().map(|n| (&n.id, n.axle))))
                .collect();
            let next = d.next_ride.as_ref().map_or(
                " None of the rides that were tried in simulation would tell them apart."
                    .to_owned(),
                |n| format!(" To tell them apart: {}.", n.what),
            );
            format!(
                "The plain model leaves something out, and this ride cannot tell {found} from {}.{next} {gains}",
                others.join(" or ")
            )
        }
        Verdict::Unnamed => {
            let places: Vec<String> = [Axle::Front, Axle::Rear]
                .into_iter()
                .filter_map(|a| {
                    let l = d.location.get(a).filter(|l| l.mismatch)?;
                    let state = l
                        .states
                        .first()
                        .map_or(String::new(), |s| format!(" ({s})"));
                    Some(format!("the {a} axle{state}"))
                })
                .collect();
            let near = if found.is_empty() {
                String::new()
            } else {
                format!(" The nearest shape is {found}, but it does not explain the ride.")
            };
            format!(
                "Something is left out on {}, and it is none of the effects in the library.{near} {gains}",
                places.join(" and on ")
            )
        }
    }
}

/// What acts, and how much is left beside it.
fn in_part(d: &Diagnosis) -> String {
    let affirmed = d.effects.iter().filter(|e| e.affirmed);
    let parts: Vec<String> = affirmed
        .map(|e| match &e.support {
            Some(s) => format!(
                "{} (it takes {:.0} % off the square of the held-out error{}, and leads in {} of {} blocks of the ride)",
                e.sentence,
                100.0 * s.removed_share,
                s.window_s.map_or(String::new(), |window| {
                    format!(" in windows of {}", Quantity::rough(window, 2, "s"))
                }),
                s.blocks_led,
                s.blocks
            ),
            None => e.sentence.clone(),
        })
        .collect();
    let left = d
        .rest
        .iter()
        .flat_map(PerAxle::iter)
        .filter_map(|(axle, rest)| {
            let state = rest
                .states
                .first()
                .map_or(String::new(), |s| format!(" ({s})"));
            Some(format!(
                "{:.2} % of it on the {axle} axle{state}",
                100.0 * rest.share?
            ))
        });
    let left: Vec<String> = left.collect();
    let left = match left.is_empty() {
        true => String::new(),
        false => format!(
            " Something else is left that has no name here: {}.",
            left.join(" and ")
        ),
    };
    format!(
        "The plain model leaves something out: {}.{left} ",
        parts.join("; ")
    )
}

fn gains(d: &Diagnosis) -> String {
    [Axle::Front, Axle::Rear]
        .into_iter()
        .filter_map(|a| {
            let h = d.held_out.get(a)?;
            let ([plain, extended, floor], unit) = h.errors();
            let (plain, extended) = (plain?, extended?);
            let noise = floor.map_or(String::new(), |floor| {
                format!(" (the sensor's noise is {})", size(floor, unit))
            });
            (extended < 0.999 * plain).then(|| {
                let part = h
                    .horizon_s
                    .map_or("On the held-out part".to_owned(), |horizon| {
                        format!("Predicted {} ahead", Quantity::rough(horizon, 2, "s"))
                    });
                format!(
                    "{part} the {a} error falls from {} to {}{noise}.",
                    size(plain, unit),
                    size(extended, unit)
                )
            })
        })
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reported(left: f64, floor: Option<f64>) -> String {
        let held = HeldOut {
            plain_rms_m: Some(left),
            extended_rms_m: Some(left),
            noise_floor_m: floor,
            ..HeldOut::default()
        };
        let held_out = PerAxle {
            front: Some(held),
            rear: None,
        };
        nothing_missing(&held_out).replace('\u{a0}', " ")
    }

    #[test]
    fn noise_is_only_what_the_sensor_may_have() {
        assert!(reported(5e-5, Some(5e-5)).contains("to within its noise"));
        assert!(reported(5e-5, None).contains("to within its noise"));
        assert!(reported(NOISE * 1.01e-6, Some(1e-6)).contains("the sensor's noise is 0.001 mm"));
    }
}
