//! Output error: the plain model's parameters that bring the simulated displacement nearest to the
//! measured one, min over p of sum (z_n - z(t_n; p))^2, by Levenberg-Marquardt on exact
//! sensitivities. Unlike regressions on differentiated records it has no bias from noise on z, so
//! it is the reference by which the other methods are judged.
//!
//! Besides k/m and B/m the initial state is unknown; on rides with an applied force and on free
//! decays also a rest point (a constant force), and 1/m where the bike's mass is null.

mod global;
pub mod minima;
pub mod problem;
mod split;
pub mod start;

use nalgebra::{DMatrix, DVector};

use crate::simulate::sensitivity::PARAMETERS;
pub use problem::AxleFit;
use problem::{LocalMatrix, Problem};
pub use problem::{most, rms_valid, spread_valid};
pub use split::Split;
pub use start::Start;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::numerics::levenberg_marquardt::{Damping, Descent, minimise};
use veloid_core::plant::Coefficients;
use veloid_core::settings::Settings;
use veloid_core::{Divergence, EngineError};
use veloid_ride::Ride;

const STAGE: &str = "output error";
const MAX_ITERATIONS: usize = 200;
const DAMPING: Damping = Damping {
    first: 1e-3,
    least: 1e-12,
    after_failure: 0.0,
    most: 1e11,
};

/// Fits the plain model to every axle of the ride, from the best of `starts`.
///
/// # Errors
/// A null mass without a force channel; a cost that is not finite from any start.
pub fn fit(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    starts: &[PerAxle<Start>],
) -> Result<PerAxle<AxleFit>, EngineError> {
    fitted(ride, bike, settings, starts, globally_best)
}

/// The same fit once more, from where it ended: without a look elsewhere.
///
/// # Errors
/// As [`fit`].
pub fn refit(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    from: PerAxle<Start>,
) -> Result<PerAxle<AxleFit>, EngineError> {
    fitted(ride, bike, settings, &[from], |problem, split, starts| {
        let one = [problem];
        let from = from_starts(&one, starts);
        Ok(best_of(&one, false, split, from)?.remove(0))
    })
}

fn fitted(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    starts: &[PerAxle<Start>],
    alone: impl Fn(&Problem, &Split, &[PerAxle<Start>]) -> Result<AxleFit, EngineError>,
) -> Result<PerAxle<AxleFit>, EngineError> {
    let split = Split::of(ride, settings);
    let problems = ride
        .axles
        .iter()
        .map(|(axle, record)| Problem::new(axle, record, bike, ride.step_s))
        .collect::<Result<Vec<_>, _>>()?;
    let both_weighed = problems.len() == 2 && problems.iter().all(|p| p.mass.is_some());
    let mut fits = PerAxle::default();
    if bike.equal_axles && both_weighed {
        let all: Vec<&Problem> = problems.iter().collect();
        let from = from_starts(&all, starts);
        for (problem, fit) in problems.iter().zip(best_of(&all, true, &split, from)?) {
            fits.set(problem.axle, fit);
        }
    } else {
        for problem in problems {
            let axle = problem.axle;
            fits.set(axle, within_limits(problem, |p| alone(p, &split, starts))?);
        }
    }
    Ok(fits)
}

/// Fits a mass on a damper to every axle of the ride: what a force moves and no spring brings back.
///
/// # Errors
/// A null mass without a force channel; a cost that is not finite from any start.
pub fn fit_without_spring(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
) -> Result<PerAxle<AxleFit>, EngineError> {
    let split = Split::of(ride, settings);
    let mut fits = PerAxle::default();
    for (axle, record) in ride.axles.iter() {
        let mut problem = Problem::new(axle, record, bike, ride.step_s)?;
        problem.free[0] = false;
        fits.set(axle, within_limits(problem, |p| from_grid(p, &split))?);
    }
    Ok(fits)
}

/// The best fit within the user's limits: where k or B leaves them it is held at the nearest, and the rest is fitted again.
fn within_limits(
    mut problem: Problem,
    best: impl Fn(&Problem) -> Result<AxleFit, EngineError>,
) -> Result<AxleFit, EngineError> {
    loop {
        let fit = best(&problem)?;
        if !problem.holds(&fit.plain) {
            return Ok(fit);
        }
    }
}

/// Part of the motion's squares that a fit may leave and be taken for the best one without a look elsewhere.
const EXPLAINED: f64 = 0.1;

/// The best fit of one axle: from the starts, and where these leave much of the motion from a grid that knows no basin too.
fn globally_best(
    problem: &Problem,
    split: &Split,
    starts: &[PerAxle<Start>],
) -> Result<AxleFit, EngineError> {
    let one = [problem];
    let near =
        best_of(&one, false, split, from_starts(&one, starts)).map(|mut fits| fits.remove(0));
    let record = problem.record;
    let moves = spread_valid(record.output(), &record.valid, 0..split.train.end);
    let explains = |fit: &AxleFit| fit.train_rms.powi(2) < EXPLAINED * moves.powi(2);
    if problem.record.prescribed || near.as_ref().is_ok_and(explains) {
        return near;
    }
    match (near, from_grid(problem, split)) {
        (Ok(near), Ok(far)) => {
            let (best, other) = match far.train_rms < near.train_rms {
                true => (far, near),
                false => (near, far),
            };
            Ok(problem.alone(best, &[other.plain], split))
        }
        (Err(_), Ok(far)) => Ok(far),
        (near, _) => near,
    }
}

/// The best fit of one axle from a grid of starts.
fn from_grid(problem: &Problem, split: &Split) -> Result<AxleFit, EngineError> {
    let asked = global::Query {
        input: &problem.input,
        record: problem.record,
        mass: problem.mass,
        free: problem.free,
    };
    let grid = global::starts(&asked, split.train.end);
    let starts = grid.into_iter().map(|plain| vec![plain]).collect();
    Ok(best_of(&[problem], false, split, starts)?.remove(0))
}

/// The plain models of all axles at each start.
fn from_starts(problems: &[&Problem], starts: &[PerAxle<Start>]) -> Vec<Vec<Coefficients>> {
    let at = |s: &PerAxle<Start>| problems.iter().map(|p| p.start(s.get(p.axle))).collect();
    starts.iter().filter_map(at).collect()
}

/// The lowest of the minima to which the three starts with the least cost lead.
fn best_of(
    problems: &[&Problem],
    equal: bool,
    split: &Split,
    starts: Vec<Vec<Coefficients>>,
) -> Result<Vec<AxleFit>, EngineError> {
    let layout = Layout::new(problems, equal);
    let tried = starts.len();
    let mut ranked: Vec<(f64, Vec<Coefficients>)> = starts
        .into_iter()
        .filter_map(|plains| {
            let mut plains = layout.consistent(plains);
            for (p, problem) in plains.iter_mut().zip(problems) {
                p.kappa = p.kappa.max(0.0);
                *p = problem.within(*p);
            }
            let cost: f64 = problems
                .iter()
                .zip(&plains)
                .map(|(p, x)| p.normal(x, split.train.end).0)
                .sum();
            cost.is_finite().then_some((cost, plains))
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let descended = ranked.into_iter().take(3);
    let mut minima: Vec<Minimum> = descended
        .filter_map(|(_, plains)| descend(problems, &layout, split, plains))
        .collect();
    minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let (best, others) = minima.split_first().ok_or(EngineError::Diverged {
        stage: STAGE,
        problem: Divergence::NoStart { starts: tried },
    })?;
    let finished = problems.iter().enumerate().map(|(i, p)| {
        let t = &layout.to_local[i];
        let local = t * &best.bread * t.transpose();
        let bread = LocalMatrix::from_fn(|a, b| local[(a, b)]);
        let fit = AxleFit {
            undetermined: best.unsettled.clone(),
            ..p.finish(best.plains[i], split, &bread)
        };
        let others: Vec<Coefficients> = others.iter().map(|other| other.plains[i]).collect();
        p.alone(fit, &others, split)
    });
    Ok(finished.collect())
}

/// How the unknowns of the fit map to each axle's parameters: d(local)/d(unknown), constant.
struct Layout {
    to_local: Vec<DMatrix<f64>>,
    unknowns: usize,
    equal: bool,
}

impl Layout {
    fn new(problems: &[&Problem], equal: bool) -> Self {
        let shared = if equal { 2 } else { 0 };
        let own = |p: &Problem| (shared..PARAMETERS).filter(|q| p.free[*q]).count();
        let unknowns = shared + problems.iter().map(|p| own(p)).sum::<usize>();
        let mut next = shared;
        let to_local = problems
            .iter()
            .map(|p| {
                let mut t = DMatrix::zeros(PARAMETERS, unknowns);
                for (q, free) in p.free.iter().enumerate() {
                    if q < shared {
                        t[(q, q)] = 1.0 / p.mass.unwrap_or(1.0);
                    } else if *free {
                        t[(q, next)] = 1.0;
                        next += 1;
                    }
                }
                t
            })
            .collect();
        Self {
            to_local,
            unknowns,
            equal,
        }
    }

    /// With equal axles one k and one B: the mean of the starts'.
    fn consistent(&self, mut plains: Vec<Coefficients>) -> Vec<Coefficients> {
        if self.equal {
            let n = plains.len() as f64;
            let k = plains.iter().map(|p| p.kappa / p.per_mass).sum::<f64>() / n;
            let b = plains.iter().map(|p| p.beta / p.per_mass).sum::<f64>() / n;
            for p in &mut plains {
                p.kappa = k * p.per_mass;
                p.beta = b * p.per_mass;
            }
        }
        plains
    }
}

/// Axles fitted together.
struct Together<'a> {
    problems: &'a [&'a Problem<'a>],
    layout: &'a Layout,
    samples: usize,
    /// Least k/m (1/s^2).
    floor: f64,
}

/// Coefficients, and the normal equations there.
struct At {
    plains: Vec<Coefficients>,
    cost: f64,
    gradient: DVector<f64>,
    matrix: DMatrix<f64>,
}

impl Together<'_> {
    fn at(&self, plains: Vec<Coefficients>) -> At {
        let n = self.layout.unknowns;
        let (mut cost, mut gradient, mut matrix) = (0.0, DVector::zeros(n), DMatrix::zeros(n, n));
        for ((p, x), t) in (self.problems.iter().zip(&plains)).zip(&self.layout.to_local) {
            let (c, g, h) = p.normal(x, self.samples);
            cost += c;
            gradient += t.tr_mul(&g);
            matrix += t.tr_mul(&h) * t;
        }
        At {
            plains,
            cost,
            gradient,
            matrix,
        }
    }
}

impl Descent for Together<'_> {
    type Point = At;

    fn cost(&self, at: &At) -> f64 {
        at.cost
    }

    fn equations(&self, at: &At) -> (DMatrix<f64>, DVector<f64>) {
        (at.matrix.clone(), at.gradient.clone())
    }

    fn moved(&self, at: &At, step: DVector<f64>) -> Option<At> {
        let moved = at.plains.iter().zip(&self.layout.to_local);
        let tried: Vec<Coefficients> = moved.map(|(p, t)| moved_by(p, &(t * &step))).collect();
        let mut pairs = self.problems.iter().zip(&tried);
        let can_show = pairs.all(|(problem, p)| problem.can_show(p, self.floor));
        can_show
            .then(|| self.at(tried))
            .filter(|at| at.cost.is_finite())
    }

    fn is_settled(&self, gained: f64, _predicted: f64, cost: f64) -> bool {
        gained <= 1e-14 * cost
    }
}

/// Where a descent ends.
struct Minimum {
    cost: f64,
    plains: Vec<Coefficients>,
    /// Inverse of the Gauss-Newton matrix.
    bread: DMatrix<f64>,
    /// Why it is no minimum.
    unsettled: Option<String>,
}

/// Where a descent ends, or nothing when it leaves the numbers' range.
fn descend(
    problems: &[&Problem],
    layout: &Layout,
    split: &Split,
    plains: Vec<Coefficients>,
) -> Option<Minimum> {
    let step = problems.first().map_or(1.0, |p| p.input.step);
    let together = Together {
        problems,
        layout,
        samples: split.train.end,
        floor: least_kappa(step, split),
    };
    let start = together.at(plains);
    let At {
        plains,
        cost,
        matrix: h,
        gradient,
    } = minimise(&together, start, DAMPING, MAX_ITERATIONS)?;
    cost.is_finite().then_some(())?;
    let scale = DVector::from_fn(layout.unknowns, |q, _| {
        h[(q, q)].max(f64::MIN_POSITIVE).sqrt().recip()
    });
    let scaled = DMatrix::from_diagonal(&scale) * &h * DMatrix::from_diagonal(&scale);
    let inverse = scaled.cholesky()?.inverse();
    let bread = DMatrix::from_diagonal(&scale) * inverse * DMatrix::from_diagonal(&scale);
    let samples = split.train.len() * problems.len();
    let measured = |p: &&Problem| -> f64 {
        let output = &p.record.output()[..split.train.end];
        output.iter().map(|z| z * z).sum()
    };
    let measured = problems.iter().map(measured).sum();
    let gain = (gradient.transpose() * &bread * &gradient)[0];
    Some(Minimum {
        unsettled: minima::not_at_rest(gain, cost, samples, measured),
        cost,
        plains,
        bread,
    })
}

/// Least k/m (1/s^2). A drive without a spring is fitted with a k around zero, on either side: below
/// it the free motion grows, here at most a hundredfold over the fitted part.
fn least_kappa(step: f64, split: &Split) -> f64 {
    let fitted_s = split.train.len().max(1) as f64 * step;
    -(100.0_f64.ln() / fitted_s).powi(2)
}

fn moved_by(p: &Coefficients, step: &DVector<f64>) -> Coefficients {
    Coefficients {
        kappa: p.kappa + step[0],
        beta: p.beta + step[1],
        per_mass: p.per_mass + step[2],
        constant: p.constant + step[3],
        height: p.height + step[4],
        velocity: p.velocity + step[5],
    }
}
