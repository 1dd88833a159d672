//! The estimates that pages go by.

use veloid_engine::bicycle::PerAxle;
use veloid_engine::report::diagnosis::Verdict;
use veloid_engine::report::{Estimate, LatentRoad, Report};
use veloid_engine::uncertainty::identifiable::NO_VERDICT;
use veloid_engine::uncertainty::laser::misleading;

/// Without a road by the only method that needs none; else with the effects in the model where there are any, or by output
/// error; without intervals where the record carries no verdict.
pub fn best(report: &Report) -> PerAxle<Estimate> {
    if let Some(latent) = without_road(report) {
        return latent.axles();
    }
    match &report.diagnosis {
        Some(d) if d.verdict == Verdict::CannotTell => {
            report.output_error.map(|_, e| unsure(e.clone()))
        }
        Some(d) if !d.effects.is_empty() => d.extended.clone(),
        _ => report.output_error.clone(),
    }
}

/// The method that needs no road, where all others have nothing or a road that misleads.
pub fn without_road(report: &Report) -> Option<&LatentRoad> {
    (report.latent_road.as_ref()).filter(|found| {
        report.has_no_road() || found.reason.is_none() && has_misleading_laser(report)
    })
}

/// Whether the road may be off by too much, because of the clock or the noise of the laser that it was made from.
fn has_misleading_laser(report: &Report) -> bool {
    misleading(
        &report.ride.clocks,
        &report.output_error,
        &report.laser_error,
    )
    .is_some()
}

fn unsure(estimate: Estimate) -> Estimate {
    let (k, b) = (
        estimate.k_not_identifiable.clone(),
        estimate.b_not_identifiable.clone(),
    );
    let withheld = estimate.withheld(NO_VERDICT);
    Estimate {
        k_not_identifiable: k.or(withheld.k_not_identifiable),
        b_not_identifiable: b.or(withheld.b_not_identifiable),
        ..withheld
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_verdict_there_are_no_intervals() {
        let known = Estimate {
            k_n_m: 6e4,
            k_std_n_m: Some(100.0),
            b_n_s_m: 500.0,
            b_std_n_s_m: Some(5.0),
            ..Estimate::default()
        };
        let unsure = unsure(known);
        assert_eq!(
            (unsure.k_n_m, unsure.k_std_n_m, unsure.b_std_n_s_m),
            (6e4, None, None)
        );
        assert_eq!(unsure.k_not_identifiable.as_deref(), Some(NO_VERDICT));
    }
}
