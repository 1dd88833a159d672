//! The best of several climbs, begun on a part of the windows.

use super::bins::Bins;
use super::fit::{Fit, fit};
use super::likelihood::Likelihood;
use super::parameters::Layout;
use super::record::Sensor;

/// Natural frequencies (rad/s, squared) of the axles, front and rear, where climbs begin.
const STARTS: [[f64; 2]; 4] = [
    [4000.0, 1500.0],
    [1500.0, 4000.0],
    [7000.0, 5000.0],
    [1200.0, 800.0],
];
/// Damping ratio at the starts.
const DAMPED: f64 = 0.25;
/// Windows that the climbs begin on, about.
const FEW: usize = 8;
/// Steps of a first climb, and of the last one over all windows.
const STEPS: [usize; 2] = [30, 60];

/// The most likely unknowns; nothing where the likelihood is none from any start.
pub fn search(bins: &Bins, sensors: &[Sensor], layout: &Layout) -> Option<Fit> {
    let best = climbed(&bins.thinned(bins.groups.len() / FEW), sensors, layout)?;
    let all = Likelihood {
        bins,
        sensors,
        layout,
        any_road: false,
    };
    fit(
        &all,
        best.theta,
        vec![[0.0; 2]; bins.groups.len()],
        STEPS[1],
    )
}

/// The best of the first climbs.
pub fn climbed(bins: &Bins, sensors: &[Sensor], layout: &Layout) -> Option<Fit> {
    let few = Likelihood {
        bins,
        sensors,
        layout,
        any_road: false,
    };
    let climb = |kappas: &[f64; 2]| {
        let mut theta = layout.start();
        for (at, kappa) in layout.axles.iter().zip(kappas) {
            if let Some(at) = at {
                theta[*at] = kappa.ln();
                theta[at + 1] = (2.0 * DAMPED * kappa.sqrt()).ln();
            }
        }
        fit(&few, theta, vec![[0.0; 2]; bins.groups.len()], STEPS[0])
    };
    let found = STARTS.iter().filter_map(climb);
    found.min_by(|a, b| a.at.value.total_cmp(&b.at.value))
}
