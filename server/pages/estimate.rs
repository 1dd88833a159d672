//! The estimates that pages go by.

use veloid_engine::bicycle::PerAxle;
use veloid_engine::report::diagnosis::Verdict;
use veloid_engine::report::{Estimate, Report};

const NO_VERDICT: &str = "the record carries no verdict on what is missing beside it";

/// With the effects in the model where there are any, else by output error; without intervals where the record carries no
/// verdict.
pub fn best(report: &Report) -> PerAxle<Estimate> {
    match &report.diagnosis {
        Some(d) if d.verdict == Verdict::CannotTell => {
            report.output_error.map(|_, e| unsure(e.clone()))
        }
        Some(d) if !d.effects.is_empty() => d.extended.clone(),
        _ => report.output_error.clone(),
    }
}

fn unsure(estimate: Estimate) -> Estimate {
    let why = || Some(NO_VERDICT.to_owned());
    Estimate {
        k_std_n_m: None,
        b_std_n_s_m: None,
        k_not_identifiable: estimate.k_not_identifiable.or_else(why),
        b_not_identifiable: estimate.b_not_identifiable.or_else(why),
        ..estimate
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
