//! How well the windows determine the unknowns.

use nalgebra::{DMatrix, DVector};

use super::bins::Bins;
use super::fit::{Fit, reduced};
use super::likelihood::Likelihood;
use super::parameters::Layout;
use super::record::Sensor;

/// Times that an interval may widen when the road's density is unknown at each frequency of each window; where it does more, it rests on the road.
pub const RESTS_ON_ROAD: f64 = 2.0;

/// Variances of the unknowns.
pub struct Spread {
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Standard errors.
    pub std_error: Vec<f64>,
    /// How many times wider each would be with a road of any spectrum; none where it would show nothing.
    pub widens: Vec<Option<f64>>,
}

/// Standard errors from the likelihood's expected curvature and from how the windows' gradients scatter (sandwich, Huber 1967;
/// neighbours overlap and are taken together), half of each: the one trusts the model, the other has few windows to count.
/// Nothing where the curvature has no inverse.
pub fn spread(fit: &Fit, bins: &Bins, sensors: &[Sensor], layout: &Layout) -> Option<Spread> {
    let model = fit.curvature.clone().cholesky()?.inverse();
    let scattered = &model * scatter(fit, layout) * &model;
    let covariance = 0.5 * (&model + &scattered);
    let std_error: Vec<f64> = (0..layout.count())
        .map(|i| covariance[(i, i)].sqrt())
        .collect();
    let free = freed(fit, bins, sensors, layout);
    let widens = (0..layout.knots).map(|i| {
        let wide = free.as_ref().map(|f| (f[i] / model[(i, i)]).sqrt());
        wide.filter(|w| w.is_finite())
    });
    (std_error.iter().all(|s| s.is_finite())).then(|| Spread {
        widens: widens.collect(),
        std_error,
        covariance,
    })
}

/// Outer products of the windows' gradients, with half of those of neighbours.
fn scatter(fit: &Fit, layout: &Layout) -> DMatrix<f64> {
    let windows = fit.at.windows.iter();
    let scores: Vec<DVector<f64>> = windows
        .map(|part| &part.score - part.projected(&part.gradient))
        .collect();
    let mut sum = DMatrix::zeros(layout.count(), layout.count());
    for (i, score) in scores.iter().enumerate() {
        sum.ger(1.0, score, score, 1.0);
        if i > 0 {
            sum.ger(0.5, score, &scores[i - 1], 1.0);
            sum.ger(0.5, &scores[i - 1], score, 1.0);
        }
    }
    for (i, prior) in layout.priors.iter().enumerate() {
        sum[(i, i)] += prior.deviation.powi(-2);
    }
    sum
}

/// Variances without any knowledge of the road's spectrum, which may differ from window to window, nor of the little by which one wheel is
/// faster than the other over the same road: within a window the speed changes by more.
fn freed(fit: &Fit, bins: &Bins, sensors: &[Sensor], layout: &Layout) -> Option<Vec<f64>> {
    let mut level = bins.clone();
    level
        .groups
        .iter_mut()
        .for_each(|group| group.stretch = 1.0);
    let problem = Likelihood {
        bins: &level,
        sensors,
        layout,
        any_road: true,
    };
    let (curvature, _) = reduced(&problem.evaluate(&fit.theta, &fit.own)?);
    let inverse = curvature.cholesky()?.inverse();
    Some((0..layout.knots).map(|i| inverse[(i, i)]).collect())
}
