//! What dry friction that a ride could not have shown may have done to its damping.

use std::f64::consts::PI;

use veloid_core::document::format_number::{WIDE, significant};
use veloid_model::dataset::{Dataset, Track};
use veloid_model::effects::Kind;
use veloid_report::Estimate;
use veloid_report::diagnosis::{Diagnosis, Verdict};

/// Damping (N s/m) that answers like dry friction (N) to a rate of this RMS (m/s), by statistical linearisation for a normal rate
/// (Roberts & Spanos 1990, Random Vibration and Statistical Linearization).
fn damping_of(friction: f64, rate: f64) -> f64 {
    (2.0 / PI).sqrt() * friction / rate
}

/// A sentence on the axles at which friction below the detectable size would raise B by more than its interval holds; empty unless
/// nothing is missing.
pub fn sentence(record: &Dataset, d: &Diagnosis) -> String {
    if d.verdict != Verdict::NothingMissing {
        return String::new();
    }
    let of_track = |track: &Track| {
        let estimate = d.extended.get(track.axle)?;
        let friction = (d.detectable.iter())
            .find(|s| s.id == Kind::CoulombFriction.id() && s.axle.acts_on(track.axle))?
            .smallest_detectable?;
        let more = damping_of(friction, track.scale.w_rms);
        exceeds(more, estimate).then(|| {
            let below = format!("{} N at the {} axle", significant(friction, 2), track.axle);
            (below, significant(more, 2))
        })
    };
    let (below, more): (Vec<_>, Vec<_>) = record.tracks.iter().filter_map(of_track).unzip();
    match below.is_empty() {
        true => String::new(),
        false => format!(
            " Dry friction of less than {} would not show, and would make B up to {} N s/m too high.",
            below.join(" or "),
            more.join(" or ")
        ),
    }
}

fn exceeds(more: f64, estimate: &Estimate) -> bool {
    estimate.b_std_n_s_m.is_some_and(|std| more > WIDE * std)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_takes_as_much_power_as_the_damping_in_its_place() {
        // Mean of |w| of a normal rate is sqrt(2 / pi) of its RMS.
        let (friction, rate) = (3.0, 0.015);
        let power = damping_of(friction, rate) * rate * rate;
        assert!((power / (friction * rate * (2.0 / PI).sqrt()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_the_interval_holds_is_not_mentioned() {
        let estimate = Estimate {
            b_std_n_s_m: Some(10.0),
            ..Estimate::default()
        };
        assert!(exceeds(1.01 * WIDE * 10.0, &estimate) && !exceeds(0.99 * WIDE * 10.0, &estimate));
        assert!(!exceeds(1.0, &Estimate::default()));
    }
}
