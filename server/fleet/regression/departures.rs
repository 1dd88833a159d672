//! What single bicycles do that the others do not: steps, as a new tyre makes one, and slopes of their own, as a tyre that leaks has one.
//! Left out, a step is taken for whatever fact goes with the season, and one bicycle's slope for the fleet's; no standard error
//! shows it.

use nalgebra::DVector;

use super::Data;
use super::fit::{Fit, standardised};
use super::gain::{Shape, Sums};
use super::reml::{Problem, State};

/// Most departures of all bicycles.
const MOST: usize = 20;
/// Fewest rides on each side of a step, and of a slope.
const SIDE: usize = 3;
const RIDES: usize = 5;
/// Most steps of a bicycle.
const STEPS: usize = 4;
/// Fewest bicycles of which one can differ from the others.
const BICYCLES: usize = 2;
/// Twice the gain in log likelihood that strong evidence has (Kass and Raftery 1995) beyond the parameters, three for a step, its place
/// among them (Zhang and Siegmund 2007), and one for a slope; both are looked for on every bicycle, slopes for every fact, which counts twice
/// the logarithm of their number.
const STRONG: f64 = 6.0;
const STEP: f64 = 3.0;
const SLOPE: f64 = 1.0;

/// What one bicycle does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Departure {
    /// A step before this ride.
    Step { bike: usize, ride: usize },
    /// A slope of its own with the fact of this column.
    Slope { bike: usize, fact: usize },
}

/// The data with a column more for each departure that is found, the clearest one first; the columns `facts` may have slopes
/// that differ. Rides stand in the order of their dates.
pub fn with_departures(mut data: Data, facts: &[usize]) -> (Data, Vec<Departure>) {
    let mut found: Vec<Departure> = Vec::new();
    while found.len() < MOST {
        let Some(departure) = clearest(&data, facts, &found) else {
            break;
        };
        let more = with(&data, departure);
        if Fit::of(&more).is_none() {
            break;
        }
        data = more;
        found.push(departure);
    }
    (data, found)
}

fn with(data: &Data, departure: Departure) -> Data {
    let place = data.facts.ncols();
    let mut facts = data.facts.clone().insert_column(place, 0.0);
    match departure {
        Departure::Step { bike, ride } => {
            let after = |(i, own): (usize, &usize)| f64::from(u8::from(*own == bike && i >= ride));
            let column = data.bikes.iter().enumerate().map(after);
            facts.set_column(place, &DVector::from_iterator(data.rides(), column));
        }
        Departure::Slope { bike, fact } => {
            // The bicycle's part of the fact's own column is its mean, so that this one's slope is that of the others.
            let rides = rides_of(data, bike);
            let mean = mean(data, fact, &rides);
            for i in rides {
                facts[(i, place)] = data.facts[(i, fact)] - mean;
                facts[(i, fact)] = mean;
            }
        }
    }
    Data {
        bikes: data.bikes.clone(),
        values: data.values.clone(),
        errors: data.errors.clone(),
        dates: data.dates.clone(),
        facts,
    }
}

fn rides_of(data: &Data, bike: usize) -> Vec<usize> {
    let rides = data.bikes.iter().enumerate();
    rides
        .filter(|(_, own)| **own == bike)
        .map(|(i, _)| i)
        .collect()
}

fn mean(data: &Data, fact: usize, rides: &[usize]) -> f64 {
    rides.iter().map(|i| data.facts[(*i, fact)]).sum::<f64>() / rides.len() as f64
}

/// The departure that a fit gains most by beyond what is asked of it.
fn clearest(data: &Data, facts: &[usize], found: &[Departure]) -> Option<Departure> {
    let (problem, _) = standardised(data)?;
    let state = problem.solve()?;
    let bicycles = data.bicycles();
    let candidates = (0..bicycles).flat_map(|bike| {
        let rides = rides_of(data, bike);
        let own = found.iter().filter_map(|departure| match departure {
            Departure::Step { bike: own, ride } if *own == bike => Some(*ride),
            _ => None,
        });
        let own: Vec<usize> = own.collect();
        let step = step((&problem, &state), (bike, &rides), &own, &data.dates);
        let step =
            step.map(|(beyond, departure)| (beyond - 2.0 * (bicycles as f64).ln(), departure));
        let slopes = facts.iter().filter_map(|fact| {
            let fact = *fact;
            let departure = Departure::Slope { bike, fact };
            let free = bicycles >= BICYCLES && rides.len() >= RIDES && !found.contains(&departure);
            let gain = free.then(|| slope(data, (&problem, &state), &rides, fact))?;
            let looks = 2.0 * ((bicycles * facts.len()) as f64).ln();
            let asked = SLOPE * (rides.len() as f64).ln() + STRONG + looks;
            Some((gain - asked, departure))
        });
        step.into_iter().chain(slopes).collect::<Vec<_>>()
    });
    let found: Vec<(f64, Departure)> = candidates.filter(|(beyond, _)| *beyond > 0.0).collect();
    // A step that a drift does not explain comes first: while one is left out, it passes for slopes of the other bicycles.
    let best = |is_step: bool| {
        let of = found
            .iter()
            .filter(|(_, d)| matches!(d, Departure::Step { .. }) == is_step);
        of.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    best(true)
        .or_else(|| best(false))
        .map(|(_, departure)| *departure)
}

/// Twice the gain in log likelihood of a slope of a bicycle's own.
fn slope(data: &Data, (problem, state): (&Problem, &State), rides: &[usize], fact: usize) -> f64 {
    let mean = mean(data, fact, rides);
    let shape = Shape::of(problem, state, rides);
    let mut sums = Sums::new(problem.design.ncols());
    for i in rides {
        sums.add(problem, state, *i, data.facts[(*i, fact)] - mean);
    }
    shape.gain(&sums)
}

/// The best step among a bicycle's rides beside the `steps` that it has, and what it gains beyond what is asked of it; nothing where a
/// drift says as much.
fn step(
    (problem, state): (&Problem, &State),
    (bike, rides): (usize, &[usize]),
    steps: &[usize],
    dates: &[f64],
) -> Option<(f64, Departure)> {
    if rides.len() < 2 * SIDE || steps.len() == STEPS {
        return None;
    }
    let places = || (0..rides.len()).filter(|place| steps.contains(&rides[*place]));
    let near = |place: usize| places().any(|step| step.abs_diff(place) < SIDE);
    let shape = Shape::of(problem, state, rides);
    let mut sums = Sums::new(problem.design.ncols());
    let mut found: Option<(f64, usize)> = None;
    for (after, i) in (1..).zip(rides.iter().rev()) {
        sums.add(problem, state, *i, 1.0);
        if after < SIDE || after > rides.len() - SIDE || near(rides.len() - after) {
            continue;
        }
        let gain = shape.gain(&sums);
        if found.is_none_or(|(most, _)| gain > most) {
            found = Some((gain, *i));
        }
    }
    let (gain, ride) = found?;
    let mut drift = Sums::new(problem.design.ncols());
    let middle = rides.iter().map(|i| dates[*i]).sum::<f64>() / rides.len() as f64;
    for i in rides {
        drift.add(problem, state, *i, dates[*i] - middle);
    }
    let size = (rides.len() as f64).ln();
    let beyond_drift = gain - shape.gain(&drift) - (STEP - 1.0) * size;
    (beyond_drift > 0.0).then_some((gain - STEP * size - STRONG, Departure::Step { bike, ride }))
}
