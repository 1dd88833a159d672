use super::{Deflection, Found, Record, Theta, solve, usable};
use crate::simulate::linear::{Input, simulate};
use crate::simulate::start::start;
use veloid_core::numerics::spline::slopes;

/// Most regressions, each with filter and instruments from the one before, and the relative change of
/// k and B at which they end.
const MOST_ROUNDS: usize = 6;
const SETTLED: f64 = 1e-4;
/// The filter's damping ratio.
const DAMPING: f64 = 0.7;
/// The filter has forgotten its start, and what is not valid, after this many time constants.
const FORGOTTEN: f64 = 10.0;

/// Instrumental variables: eq. (21) on filtered signals, with the simulated model's deflections as
/// instruments.
///
/// Every signal x passes the same filter w^2 / (s^2 + 2 d w s + w^2), w = sqrt(k/m), d = 0.7, whose
/// states are x, x' and x'' exactly, filtered alike, so that eq. (1) holds between them without an
/// observer and its lag. The measurement's noise does not touch the instruments, so it does not bias
/// the estimate (Young, "Recursive Estimation and Time-Series Analysis", 2011, ch. 8).
pub fn instrumental(record: &Record, begin: Theta) -> Option<Found> {
    let mut found = round(record, begin)?;
    for _ in 1..MOST_ROUNDS {
        let before = found.theta;
        found = round(record, before)?;
        let moved = |q: usize| (found.theta[q] / before[q] - 1.0).abs();
        if moved(0).max(moved(1)) < SETTLED {
            break;
        }
    }
    Some(found)
}

fn round(record: &Record, theta: Theta) -> Option<Found> {
    let theta = physical(theta, record.step_s);
    let [kappa, beta, per_mass] = theta;
    let input = &record.input;
    let from = start(
        input,
        theta,
        record.displacement,
        record.valid,
        record.rest_point,
    );
    let model = simulate(input, kappa, beta, per_mass, from.constant, from.initial).0;

    let filter = Filter {
        w: kappa.sqrt(),
        step: record.step_s,
    };
    let [_, _, acceleration] = filter.pass(record.displacement);
    let force = input.force.as_ref().map(|(f, _)| filter.pass(f)[0].clone());
    let deflection = |z: &[f64]| {
        let [value, rate, _] = filter.pass(&minus(&input.road, z));
        Deflection {
            value,
            rate,
            force: force.as_deref(),
        }
    };
    let memory = (FORGOTTEN / (DAMPING * filter.w * record.step_s)).ceil() as usize;
    let n = record.displacement.len();
    let usable = usable(record.valid, memory.min(n / 4), 0, memory);
    solve(
        record,
        &deflection(record.displacement),
        &deflection(&model),
        &acceleration,
        &usable,
    )
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Most phase (rad) per sample interval, and least damping ratio, of a model to simulate.
const MOST_PHASE: f64 = 2.0;
const LEAST_DAMPING: f64 = 0.01;

/// The nearest parameters of a stable, visible oscillator.
fn physical([kappa, beta, per_mass]: Theta, step: f64) -> Theta {
    let kappa = if kappa > 0.0 {
        kappa.min((MOST_PHASE / step).powi(2))
    } else {
        (0.1 * MOST_PHASE / step).powi(2)
    };
    let beta = beta.clamp(2.0 * LEAST_DAMPING * kappa.sqrt(), MOST_PHASE / step);
    let per_mass = if per_mass.is_finite() { per_mass } else { 1.0 };
    [kappa, beta, per_mass]
}

struct Filter {
    w: f64,
    step: f64,
}

impl Filter {
    /// x, x' and x'' of the cubic spline through `x`, filtered.
    fn pass(&self, x: &[f64]) -> [Vec<f64>; 3] {
        let rest = vec![0.0; x.len()];
        let slope = slopes(x, self.step);
        let from = [x[0], slope[0]];
        let input = Input {
            step: self.step,
            road: rest.clone(),
            road_slope: rest,
            force: Some((x.to_vec(), slope)),
            prescribed: false,
        };
        let (kappa, beta) = (self.w * self.w, 2.0 * DAMPING * self.w);
        let (value, rate) = simulate(&input, kappa, beta, kappa, 0.0, from);
        let second = (0..x.len())
            .map(|i| kappa * (x[i] - value[i]) - beta * rate[i])
            .collect();
        [value, rate, second]
    }
}
