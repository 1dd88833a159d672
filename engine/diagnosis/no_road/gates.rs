//! Rides of which nothing can be said.

use super::fit::Fit;
use crate::policy;

/// Why axles that are alike say nothing: what one does to the road the other undoes.
pub fn alike(plain: &Fit) -> Option<String> {
    let error = |slot: usize| plain.covariance[(slot, slot)].max(0.0).sqrt();
    tracing::debug!(front = error(0), rear = error(2), "relative errors of k");
    too_similar(error(0).max(error(2)))
}

/// By the larger of the relative standard errors of k.
fn too_similar(worst: f64) -> Option<String> {
    (worst > policy::ALIKE).then(|| {
        format!(
            "k/m and B/m of the axles are too similar: what one axle does to the road the other undoes (k is determined to {} % only)",
            percent(worst)
        )
    })
}

/// Why wheels that do not share their road say nothing.
pub fn own_road(left: f64) -> Option<String> {
    (left > policy::OWN_ROAD).then(|| {
        format!(
            "the rear wheel's acceleration has {} % of its power from a road that the front wheel did not ride on; ride straight, on a road \
             that is even across the track",
            percent(left)
        )
    })
}

fn percent(share: f64) -> String {
    match share.is_finite() {
        true => format!("{:.0}", 100.0 * share),
        false => "100".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_k_and_power_of_the_own_road_close_the_gates() {
        assert_eq!(too_similar(0.99 * policy::ALIKE), None);
        assert!(too_similar(1.01 * policy::ALIKE).is_some_and(|why| why.contains("5 %")));
        assert!(too_similar(f64::INFINITY).is_some());
        assert_eq!(own_road(0.99 * policy::OWN_ROAD), None);
        assert!(own_road(1.01 * policy::OWN_ROAD).is_some_and(|why| why.contains("30 %")));
    }
}
