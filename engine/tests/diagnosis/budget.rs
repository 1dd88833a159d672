//! The search's budget, in counted work.

use super::*;

#[test]
#[ignore = "slow"]
fn a_spent_budget_ends_the_search_the_same_way_each_time_and_says_so() {
    // A law that the library does not hold, so that the search goes on.
    let strange = ride(|_, d, w| 2e4 * d * (3.0 * w).tanh() + 40.0 * (2000.0 * d).sin());
    let with = |search_budget: f64| {
        let settings = Settings {
            trials: 1,
            iterations: 2,
            search_budget,
            ..Settings::default()
        };
        let report = veloid_engine::identify(&strange, &bike(), &settings, &Silent).unwrap();
        report.diagnosis.unwrap()
    };
    let said = |d: &Diagnosis| d.warnings.iter().any(|w| w.contains("search_budget"));
    let (all, cut) = (with(1e6), with(100.0));
    assert!(!all.search_cost.is_spent && !said(&all));
    assert!(cut.search_cost.is_spent && said(&cut));
    let [most, least] = [&all, &cut].map(|d| d.search_cost.steps);
    assert!(least < most / 2, "{least} of {most}");
    assert!(cut.verdict != Verdict::NothingMissing);
    assert_eq!(cut, with(100.0));
}
