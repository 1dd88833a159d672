//! Steps that single bicycles show beside the facts, as a new tyre makes one. Left out, one is taken for whatever fact
//! goes with the season, and no standard error shows it.

use nalgebra::DVector;

use super::Data;
use super::fit::{Fit, standardised};
use super::reml::{Problem, State};

/// Most steps of all bicycles.
const MOST: usize = 20;
/// Fewest rides on each side of a step.
const SIDE: usize = 3;
/// Twice the gain in log likelihood that strong evidence for a step has (Kass and Raftery 1995) beyond its three parameters, its place
/// among them (Zhang and Siegmund 2007).
const STRONG: f64 = 6.0;
const PARAMETERS: f64 = 3.0;

/// A step of one bicycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    pub bike: usize,
    /// The first ride after it.
    pub ride: usize,
}

/// The data with a column more for each step that is found, the clearest one first. Rides stand in the order of their dates.
pub fn with_steps(mut data: Data) -> (Data, Vec<Step>) {
    let mut steps: Vec<Step> = Vec::new();
    while steps.len() < MOST {
        let Some(step) = clearest(&data, &steps) else {
            break;
        };
        let place = data.facts.ncols();
        let column = column(&data, &step);
        data.facts = data.facts.insert_column(place, 0.0);
        data.facts.set_column(place, &column);
        if Fit::of(&data).is_none() {
            data.facts = data.facts.remove_column(place);
            break;
        }
        steps.push(step);
    }
    (data, steps)
}

/// Rides of the bicycle from the step on.
fn column(data: &Data, step: &Step) -> DVector<f64> {
    let after =
        |(i, bike): (usize, &usize)| f64::from(u8::from(*bike == step.bike && i >= step.ride));
    DVector::from_iterator(data.rides(), data.bikes.iter().enumerate().map(after))
}

/// The step that a fit gains most by, if that is enough, of the bicycles that have none.
fn clearest(data: &Data, steps: &[Step]) -> Option<Step> {
    let (problem, _) = standardised(data)?;
    let state = problem.solve()?;
    let mut rides: Vec<Vec<usize>> = vec![Vec::new(); data.bicycles()];
    for (i, bike) in data.bikes.iter().enumerate() {
        rides[*bike].push(i);
    }
    let free = |bike: &usize| steps.iter().all(|step| step.bike != *bike);
    let of_bike = |bike: usize| {
        let own = &rides[bike];
        let (gain, ride) = best(&problem, &state, own, &data.dates)?;
        let enough = PARAMETERS * (own.len() as f64).ln() + STRONG;
        (gain > enough).then_some((gain - enough, Step { bike, ride }))
    };
    let found = (0..rides.len()).filter(free).filter_map(of_bike);
    found
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, step)| step)
}

/// Twice the gain in log likelihood of the best step among a bicycle's rides, and the first ride after it; nothing where a drift says as
/// much.
fn best(problem: &Problem, state: &State, rides: &[usize], dates: &[f64]) -> Option<(f64, usize)> {
    if rides.len() < 2 * SIDE {
        return None;
    }
    let shape = Shape::of(problem, state, rides);
    let mut sums = Sums::new(problem.design.ncols());
    let mut found: Option<(f64, usize)> = None;
    for (after, i) in (1..).zip(rides.iter().rev()) {
        sums.add(problem, state, *i, 1.0);
        if after < SIDE || after > rides.len() - SIDE {
            continue;
        }
        let gain = shape.gain(&sums);
        if found.is_none_or(|(most, _)| gain > most) {
            found = Some((gain, *i));
        }
    }
    let mut drift = Sums::new(problem.design.ncols());
    let middle = rides.iter().map(|i| dates[*i]).sum::<f64>() / rides.len() as f64;
    rides
        .iter()
        .for_each(|i| drift.add(problem, state, *i, dates[*i] - middle));
    let more = (PARAMETERS - 1.0) * (rides.len() as f64).ln();
    found.filter(|(gain, _)| *gain > shape.gain(&drift) + more)
}

/// Sums over rides of a column of numbers, weighed: its square, itself, what the fit leaves, and the design beside it.
struct Sums {
    square: f64,
    weight: f64,
    left: f64,
    design: DVector<f64>,
}

impl Sums {
    fn new(columns: usize) -> Self {
        let design = DVector::zeros(columns);
        Self {
            square: 0.0,
            weight: 0.0,
            left: 0.0,
            design,
        }
    }

    fn add(&mut self, problem: &Problem, state: &State, ride: usize, x: f64) {
        let weight = state.precisions[ride] * x;
        self.square += weight * x;
        self.weight += weight;
        self.left += state.weighted[ride] * x;
        self.design += problem.design.row(ride).transpose() * weight;
    }
}

/// What a bicycle's own level takes of a column of its rides.
struct Shape<'a> {
    state: &'a State,
    all: DVector<f64>,
    shrunk: f64,
}

impl<'a> Shape<'a> {
    fn of(problem: &Problem, state: &'a State, rides: &[usize]) -> Self {
        let mut all = Sums::new(problem.design.ncols());
        rides.iter().for_each(|i| all.add(problem, state, *i, 1.0));
        let shrunk = state.variances[1] / (1.0 + state.variances[1] * all.weight);
        Self {
            state,
            all: all.design,
            shrunk,
        }
    }

    /// Twice the gain in log likelihood of a column beside the fit.
    fn gain(&self, sums: &Sums) -> f64 {
        let across = &sums.design - &self.all * (self.shrunk * sums.weight);
        let own = sums.square - self.shrunk * sums.weight * sums.weight;
        let free = own - across.dot(&self.state.information.solve(&across));
        if free > 1e-9 * own {
            sums.left * sums.left / free
        } else {
            0.0
        }
    }
}
