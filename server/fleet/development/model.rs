use super::sums::{Levels, Sums};

/// Parameters: a level, a drift, and three for each step, one of them its place, which is searched for (Zhang and Siegmund 2007,
/// doi:10.1111/j.1541-0420.2006.00662.x).
const LEVEL: f64 = 1.0;
const DRIFT: f64 = 1.0;
const STEP: f64 = 3.0;

/// A number and its standard error.
#[derive(Clone, Copy, Default)]
pub struct Estimate {
    pub value: f64,
    pub std_error: f64,
}

/// A fitted model.
pub struct Model {
    pub bic: f64,
    pub drifts: bool,
    pub slope: Estimate,
    /// The first ride after each step, and the steps' heights.
    pub splits: Vec<usize>,
    pub steps: Vec<Estimate>,
    /// Degrees of freedom that are left.
    pub freedom: f64,
}

impl Model {
    /// The model of these groups of rides, which begin with a ride of `splits` each; `total` is what a level alone leaves.
    pub fn of(groups: &[Sums], splits: Vec<usize>, drifts: bool, rides: usize, total: f64) -> Self {
        let levels = Levels::of(groups.iter().copied(), drifts);
        let n = rides as f64;
        let freedom = n - groups.len() as f64 - f64::from(u8::from(drifts));
        // A fit that leaves nothing is not infinitely good.
        let share = (levels.left / total).max(1e-12);
        let variance = share * total / freedom;
        let along = |t: f64| match levels.spread > 0.0 {
            true => t * t / levels.spread,
            false => 0.0,
        };
        let step = |pair: &[Sums]| {
            let [a, b] = [pair[0], pair[1]];
            let apart = b.t / b.w - a.t / a.w;
            Estimate {
                value: b.y / b.w - a.y / a.w - levels.slope * apart,
                std_error: (variance * (a.w.recip() + b.w.recip() + along(apart))).sqrt(),
            }
        };
        Self {
            bic: n * share.ln() + parameters(splits.len(), drifts) * n.ln(),
            drifts,
            slope: Estimate {
                value: levels.slope,
                std_error: (variance * along(1.0)).sqrt(),
            },
            steps: groups.windows(2).map(step).collect(),
            splits,
            freedom,
        }
    }
}

fn parameters(steps: usize, drifts: bool) -> f64 {
    LEVEL + if drifts { DRIFT } else { 0.0 } + STEP * steps as f64
}
