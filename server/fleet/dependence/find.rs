use std::collections::{BTreeMap, HashMap};

use nalgebra::{DMatrix, DVector};

use super::variables::{DATE, label, unit};
use super::view::{Dependence, Influence, Known, Place, Point, Predicted, Step};
use super::{sentence, variables};
use crate::fleet::development::Development;
use crate::fleet::regression::{
    self, Coefficient, Confounding, Data, Fit, Prediction, Refusal, with_steps,
};
use crate::store::dependence::RideRow;
use crate::time;

/// Rides that the points of an answer show at most.
const POINTS: usize = 1000;
/// Of so many rides a fact has to be known to be taken by itself, as a share.
const USUAL: f64 = 0.75;
/// Places at which a progress line is written.
const PLACES: usize = 21;

/// What is asked: facts, or those that most rides have, and where to predict.
pub struct Question<'a> {
    pub axle: &'a str,
    pub name: &'a str,
    pub on: Option<&'a [String]>,
    pub at: &'a BTreeMap<String, f64>,
}

/// A ride with its facts.
struct SimulatedRide<'a> {
    row: &'a RideRow,
    std_error: f64,
    facts: BTreeMap<String, f64>,
}

impl Dependence {
    pub fn of(question: &Question, rows: &[RideRow]) -> Self {
        let mut simulated_rides: Vec<SimulatedRide> =
            rows.iter().filter_map(SimulatedRide::of).collect();
        simulated_rides
            .sort_by_key(|simulated_ride| (simulated_ride.row.dated_at, simulated_ride.row.job_id));
        let known = known(&simulated_rides);
        let usual = |known: &&Known| known.rides as f64 >= USUAL * simulated_rides.len() as f64;
        let usual = || {
            known
                .iter()
                .filter(usual)
                .map(|known| known.name.clone())
                .collect()
        };
        let asked: Vec<String> = question.on.map_or_else(usual, <[String]>::to_vec);
        let all = simulated_rides.len();
        simulated_rides.retain(|simulated_ride| {
            asked
                .iter()
                .all(|name| simulated_ride.facts.contains_key(name))
        });
        let mut found = Self {
            axle: question.axle.to_owned(),
            name: question.name.to_owned(),
            unit: rows
                .first()
                .map_or_else(String::new, |row| row.unit.clone()),
            summary: String::new(),
            rides: simulated_rides.len(),
            bikes: 0,
            left_out: all - simulated_rides.len(),
            level: None,
            between_rides: None,
            between_bikes: None,
            facts: Vec::new(),
            steps: Vec::new(),
            prediction: None,
            development: None,
            known,
            points: Vec::new(),
        };
        found.fit(&asked, &simulated_rides, question.at);
        found.summary = sentence::of(&found);
        found
    }

    fn fit(
        &mut self,
        asked: &[String],
        simulated_rides: &[SimulatedRide],
        at: &BTreeMap<String, f64>,
    ) {
        if simulated_rides.is_empty() {
            return;
        }
        let data = data(asked, simulated_rides);
        self.bikes = data.bicycles();
        let confounded = Confounding::of(&data);
        self.facts = asked
            .iter()
            .enumerate()
            .map(|(i, name)| {
                Influence::new(
                    name,
                    &data.facts.column(i).into_owned(),
                    &confounded[i],
                    asked,
                )
            })
            .collect();
        let fitted: Vec<usize> = (0..asked.len())
            .filter(|i| confounded[*i].refused.is_none())
            .collect();
        let data = Data {
            facts: data.facts.select_columns(&fitted),
            ..data
        };
        let (data, steps) = with_steps(data);
        let Some(fit) = Fit::of(&data) else { return };
        for (place, i) in fitted.iter().enumerate() {
            self.facts[*i].slope = Some(fit.slopes[place]);
            self.facts[*i].line = line(&fit, place, &self.facts[*i]);
        }
        self.level = Some(fit.level);
        self.between_rides = Some(fit.between_rides);
        self.between_bikes = fit.between_bikes;
        let sizes = steps.iter().zip(&fit.slopes[fitted.len()..]);
        self.steps = sizes
            .map(|(step, size)| stepped(step, *size, simulated_rides))
            .collect();
        self.predict(&fit, &fitted, at);
        if self.bikes == 1 && !fitted.iter().any(|i| asked[*i] == DATE) {
            let left = simulated_rides.iter().zip(&fit.residuals);
            let deviation =
                |simulated_ride: &SimulatedRide| simulated_ride.std_error.hypot(fit.between_rides);
            let left: Vec<_> = left
                .map(|(o, r)| (o.row.dated_at, *r, deviation(o)))
                .collect();
            self.development = Development::of(&left);
        }
        self.points = points(simulated_rides, &data, &fit, fitted.len());
    }

    fn predict(&mut self, fit: &Fit, fitted: &[usize], at: &BTreeMap<String, f64>) {
        let facts: Vec<&Influence> = fitted.iter().map(|i| &self.facts[*i]).collect();
        let asked: Vec<&Influence> = facts
            .iter()
            .copied()
            .filter(|fact| at.contains_key(&fact.name))
            .collect();
        if asked.is_empty() {
            return;
        }
        let mut place = fit.means.clone();
        for (x, fact) in place.iter_mut().zip(&facts) {
            *x = at.get(&fact.name).copied().unwrap_or(*x);
        }
        if self.bikes == 1 {
            // As the bicycle is now, after its steps.
            place[fitted.len()..].fill(1.0);
        }
        let prediction = fit.at(&place);
        let outside = |fact: &&&Influence| !(fact.least..=fact.most).contains(&at[&fact.name]);
        let beyond: Vec<String> = asked
            .iter()
            .filter(outside)
            .map(|fact| fact.name.clone())
            .collect();
        let at: BTreeMap<String, f64> = asked
            .iter()
            .map(|fact| (fact.name.clone(), at[&fact.name]))
            .collect();
        let summary = sentence::predicted(self, &at, &prediction, &beyond);
        self.prediction = Some(Predicted {
            at,
            prediction,
            summary,
            beyond,
        });
    }
}

fn stepped(step: &regression::Step, size: Coefficient, simulated_rides: &[SimulatedRide]) -> Step {
    let first = simulated_rides[step.ride].row;
    Step {
        bike: first.bike.clone(),
        at: time::text(first.dated_at),
        size,
    }
}

/// The fitted rides with their first columns, which are the facts.
fn points(simulated_rides: &[SimulatedRide], data: &Data, fit: &Fit, facts: usize) -> Vec<Point> {
    let point = |(i, simulated_ride): (usize, &SimulatedRide)| Point {
        job: simulated_ride.row.job_id,
        bike: simulated_ride.row.bike.clone(),
        dated_at: time::text(simulated_ride.row.dated_at),
        facts: data.facts.row(i).iter().copied().take(facts).collect(),
        value: simulated_ride.row.value,
        std_error: simulated_ride.std_error,
        residual: fit.residuals[i],
    };
    let step = simulated_rides.len().div_ceil(POINTS).max(1);
    simulated_rides
        .iter()
        .enumerate()
        .step_by(step)
        .map(point)
        .collect()
}

impl<'a> SimulatedRide<'a> {
    fn of(row: &'a RideRow) -> Option<Self> {
        let std_error = row.std_error.filter(|e| e.powi(-2).is_normal())?;
        Some(Self {
            row,
            std_error,
            facts: variables::of(row),
        })
    }
}

impl Influence {
    fn new(name: &str, column: &DVector<f64>, confounding: &Confounding, asked: &[String]) -> Self {
        let goes_with = confounding.with.map(|(i, _)| asked[i].clone());
        Self {
            reason: confounding
                .refused
                .map(|refusal| reason(refusal, goes_with.as_deref())),
            name: name.to_owned(),
            unit: unit(name).to_owned(),
            mean: column.mean(),
            least: column.min(),
            most: column.max(),
            slope: None,
            shared: confounding.shared,
            goes_with,
            correlation: confounding.with.map(|(_, correlation)| correlation),
            between_bikes: confounding.between_bikes,
            line: Vec::new(),
        }
    }
}

fn reason(refusal: Refusal, with: Option<&str>) -> String {
    match (refusal, with) {
        (Refusal::Constant, _) => "it is the same on all of these rides".to_owned(),
        (Refusal::Shared, Some(with)) => {
            format!("it goes with {}: their influences cannot be told apart", label(with))
        }
        (Refusal::Shared, None) => "it goes with the other facts".to_owned(),
        (Refusal::FewBikes, _) => {
            "it differs between bicycles only, and these are too few to tell it from what else they differ by".to_owned()
        }
    }
}

fn data(asked: &[String], simulated_rides: &[SimulatedRide]) -> Data {
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let bikes = simulated_rides.iter().map(|simulated_ride| {
        let next = numbers.len();
        *numbers.entry(&simulated_ride.row.bike).or_insert(next)
    });
    Data {
        bikes: bikes.collect(),
        values: DVector::from_iterator(
            simulated_rides.len(),
            simulated_rides.iter().map(|o| o.row.value),
        ),
        errors: DVector::from_iterator(
            simulated_rides.len(),
            simulated_rides.iter().map(|o| o.std_error),
        ),
        dates: simulated_rides.iter().map(|o| o.facts[DATE]).collect(),
        facts: DMatrix::from_fn(simulated_rides.len(), asked.len(), |i, j| {
            simulated_rides[i].facts[&asked[j]]
        }),
    }
}

fn line(fit: &Fit, place: usize, fact: &Influence) -> Vec<Place> {
    let at = |i: usize| {
        let x = fact.least + (fact.most - fact.least) * i as f64 / (PLACES - 1) as f64;
        let mut facts = fit.means.clone();
        facts[place] = x;
        let Prediction {
            value, low, high, ..
        } = fit.at(&facts);
        Place {
            x,
            value,
            low,
            high,
        }
    };
    (0..PLACES).map(at).collect()
}

fn known(simulated_rides: &[SimulatedRide]) -> Vec<Known> {
    let mut known: BTreeMap<&str, Known> = BTreeMap::new();
    for (name, value) in simulated_rides
        .iter()
        .flat_map(|simulated_ride| &simulated_ride.facts)
    {
        let fact = known.entry(name).or_insert_with(|| Known {
            name: name.clone(),
            unit: unit(name).to_owned(),
            rides: 0,
            least: *value,
            most: *value,
        });
        fact.rides += 1;
        fact.least = fact.least.min(*value);
        fact.most = fact.most.max(*value);
    }
    known.into_values().collect()
}
