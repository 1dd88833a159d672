//! The verdict in plain words.

use crate::bicycle::Axle;

use super::{Diagnosis, EffectName, Place, Verdict};

fn at(place: Place) -> &'static str {
    match place {
        Place::Front => "front",
        Place::Rear => "rear",
        Place::Both => "both axles",
    }
}

/// A value with its 95 % interval, to two digits of that.
pub fn with_margin(value: f64, std_error: Option<f64>) -> String {
    let Some(margin) = std_error.map(|e| 1.96 * e).filter(|m| *m > 0.0) else {
        return format!("{value:.4}");
    };
    let decimals = (1.0 - margin.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$} ± {margin:.decimals$}")
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
            format!("The plain model leaves something out: {}. {gains}", parts.join("; "))
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
    [Axle::Front, Axle::Rear]
        .into_iter()
        .filter_map(|a| {
            let h = d.held_out.get(a)?;
            let (plain, extended) = (h.plain_rms_m?, h.extended_rms_m?);
            let noise = (h.noise_floor_m).map_or(String::new(), |floor| {
                format!(" (the sensor's noise is {:.4} mm)", 1e3 * floor)
            });
            (extended < 0.999 * plain).then(|| {
                format!(
                    "On the held-out part the {a} error falls from {:.4} mm to {:.4} mm{noise}.",
                    1e3 * plain,
                    1e3 * extended
                )
            })
        })
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::with_margin;

    #[test]
    fn no_digit_is_told_that_the_interval_does_not_hold() {
        assert_eq!(with_margin(19.8696, Some(0.107)), "19.87 ± 0.21");
        assert_eq!(with_margin(0.012_341, Some(1.3e-4)), "0.01234 ± 0.00025");
        assert_eq!(with_margin(61_234.6, Some(640.0)), "61235 ± 1254");
        assert_eq!(with_margin(1.5, None), "1.5000");
    }
}
