//! The verdict in plain words.

use crate::bicycle::Axle;
use crate::number::Quantity;

use super::{Diagnosis, EffectName, Place, Verdict};

fn at(place: Place) -> &'static str {
    match place {
        Place::Front => "front",
        Place::Rear => "rear",
        Place::Both => "both axles",
    }
}

fn set(names: &[EffectName]) -> String {
    names
        .iter()
        .map(|n| format!("{} ({})", n.id.replace('_', " "), at(n.axle)))
        .collect::<Vec<_>>()
        .join(" with ")
}

/// One or two sentences for a person who has not read the report.
pub fn sentence(d: &Diagnosis) -> String {
    let gains = gains(d);
    match d.verdict {
        Verdict::NothingMissing => {
            "The plain spring and damper explain this ride to within its noise; nothing that this ride could show is missing."
                .to_owned()
        }
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
        Verdict::Ambiguous => {
            let own: Vec<EffectName> =
                d.effects.iter().map(|e| EffectName { id: e.id.clone(), axle: e.axle }).collect();
            let others: Vec<String> = d.alternatives.iter().map(|a| set(a)).collect();
            let next = d.next_ride.as_ref().map_or(String::new(), |n| format!(" To tell them apart: {}.", n.what));
            format!(
                "The plain model leaves something out, and this ride cannot tell {} from {}.{next} {gains}",
                set(&own),
                others.join(" or ")
            )
        }
        Verdict::Unnamed => {
            let places: Vec<String> = [Axle::Front, Axle::Rear]
                .into_iter()
                .filter_map(|a| {
                    let l = d.location.get(a).filter(|l| l.mismatch)?;
                    let state = l.states.first().map_or(String::new(), |s| format!(" ({s})"));
                    Some(format!("the {a} axle{state}"))
                })
                .collect();
            let nearest: Vec<EffectName> =
                d.effects.iter().map(|e| EffectName { id: e.id.clone(), axle: e.axle }).collect();
            let near = if nearest.is_empty() {
                String::new()
            } else {
                format!(" The nearest shape is {}, but it does not explain the ride.", set(&nearest))
            };
            format!(
                "Something is left out on {}, and it is none of the effects in the library.{near} {gains}",
                places.join(" and on ")
            )
        }
    }
}

fn gains(d: &Diagnosis) -> String {
    let length = |rms_m: f64| Quantity::rough(rms_m, 3, "m");
    [Axle::Front, Axle::Rear]
        .into_iter()
        .filter_map(|a| {
            let h = d.held_out.get(a)?;
            let (plain, extended) = (h.plain_rms_m?, h.extended_rms_m?);
            let noise = (h.noise_floor_m).map_or(String::new(), |floor| {
                format!(" (the sensor's noise is {})", length(floor))
            });
            (extended < 0.999 * plain).then(|| {
                format!(
                    "On the held-out part the {a} error falls from {} to {}{noise}.",
                    length(plain),
                    length(extended)
                )
            })
        })
        .collect::<Vec<_>>()
        .join(" ")
}
