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
/// Places at which a line is told.
const PLACES: usize = 21;

/// What is asked: facts, or those that most rides have, and where to predict.
pub struct Question<'a> {
    pub axle: &'a str,
    pub name: &'a str,
    pub on: Option<&'a [String]>,
    pub at: &'a BTreeMap<String, f64>,
}

/// A ride with its facts.
struct Outing<'a> {
    row: &'a RideRow,
    std_error: f64,
    facts: BTreeMap<String, f64>,
}

impl Dependence {
    pub fn of(question: &Question, rows: &[RideRow]) -> Self {
        let mut outings: Vec<Outing> = rows.iter().filter_map(Outing::of).collect();
        outings.sort_by_key(|outing| (outing.row.dated_at, outing.row.job_id));
        let known = known(&outings);
        let usual = |known: &&Known| known.rides as f64 >= USUAL * outings.len() as f64;
        let usual = || {
            known
                .iter()
                .filter(usual)
                .map(|known| known.name.clone())
                .collect()
        };
        let asked: Vec<String> = question.on.map_or_else(usual, <[String]>::to_vec);
        let all = outings.len();
        outings.retain(|outing| asked.iter().all(|name| outing.facts.contains_key(name)));
        let mut found = Self {
            axle: question.axle.to_owned(),
            name: question.name.to_owned(),
            unit: rows
                .first()
                .map_or_else(String::new, |row| row.unit.clone()),
            summary: String::new(),
            rides: outings.len(),
            bikes: 0,
            left_out: all - outings.len(),
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
        found.fit(&asked, &outings, question.at);
        found.summary = sentence::of(&found);
        found
    }

    fn fit(&mut self, asked: &[String], outings: &[Outing], at: &BTreeMap<String, f64>) {
        if outings.is_empty() {
            return;
        }
        let data = data(asked, outings);
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
            .map(|(step, size)| stepped(step, *size, outings))
            .collect();
        self.predict(&fit, &fitted, at);
        if self.bikes == 1 && !fitted.iter().any(|i| asked[*i] == DATE) {
            let left = outings.iter().zip(&fit.residuals);
            let deviation = |outing: &Outing| outing.std_error.hypot(fit.between_rides);
            let left: Vec<_> = left
                .map(|(o, r)| (o.row.dated_at, *r, deviation(o)))
                .collect();
            self.development = Development::of(&left);
        }
        self.points = points(outings, &data, &fit, fitted.len());
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

fn stepped(step: &regression::Step, size: Coefficient, outings: &[Outing]) -> Step {
    let first = outings[step.ride].row;
    Step {
        bike: first.bike.clone(),
        at: time::text(first.dated_at),
        size,
    }
}

/// The fitted rides with their first columns, which are the facts.
fn points(outings: &[Outing], data: &Data, fit: &Fit, facts: usize) -> Vec<Point> {
    let point = |(i, outing): (usize, &Outing)| Point {
        job: outing.row.job_id,
        bike: outing.row.bike.clone(),
        dated_at: time::text(outing.row.dated_at),
        facts: data.facts.row(i).iter().copied().take(facts).collect(),
        value: outing.row.value,
        std_error: outing.std_error,
        residual: fit.residuals[i],
    };
    let step = outings.len().div_ceil(POINTS).max(1);
    outings
        .iter()
        .enumerate()
        .step_by(step)
        .map(point)
        .collect()
}

impl<'a> Outing<'a> {
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

fn data(asked: &[String], outings: &[Outing]) -> Data {
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let bikes = outings.iter().map(|outing| {
        let next = numbers.len();
        *numbers.entry(&outing.row.bike).or_insert(next)
    });
    Data {
        bikes: bikes.collect(),
        values: DVector::from_iterator(outings.len(), outings.iter().map(|o| o.row.value)),
        errors: DVector::from_iterator(outings.len(), outings.iter().map(|o| o.std_error)),
        dates: outings.iter().map(|o| o.facts[DATE]).collect(),
        facts: DMatrix::from_fn(outings.len(), asked.len(), |i, j| {
            outings[i].facts[&asked[j]]
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

fn known(outings: &[Outing]) -> Vec<Known> {
    let mut known: BTreeMap<&str, Known> = BTreeMap::new();
    for (name, value) in outings.iter().flat_map(|outing| &outing.facts) {
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
