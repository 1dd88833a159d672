use std::collections::BTreeMap;

use super::rides::{Column, Ride, data};
use super::variables::{DATE, unit};
use super::view::{
    Categories, Category, Dependence, Influence, Known, OwnSlope, Point, Predicted, Step,
};
use super::{categories, influence, sentence};
use crate::fleet::development::Development;
use crate::fleet::regression::{Confounding, Data, Departure, Fit, with_departures};
use crate::store::dependence::RideRow;
use crate::time;

/// Rides that the points of an answer show at most.
const POINTS: usize = 1000;
/// Of so many rides a fact has to be known to be taken by itself, as a share.
const USUAL: f64 = 0.75;

/// What is asked: facts, or the numbers that most rides have, and where to predict.
pub struct Question<'a> {
    pub axle: &'a str,
    pub name: &'a str,
    pub on: Option<&'a [String]>,
    pub at: &'a BTreeMap<String, f64>,
}

impl Dependence {
    pub fn of(question: &Question, rows: &[RideRow]) -> Self {
        let mut rides: Vec<Ride> = rows.iter().filter_map(Ride::of).collect();
        rides.sort_by_key(|ride| (ride.row.dated_at, ride.row.job_id));
        let all = rides.len();
        let known = known(&rides);
        let usual = known
            .iter()
            .filter(|k| k.rides as f64 >= USUAL * all as f64);
        let usual = || usual.map(|known| known.name.clone()).collect();
        let asked: Vec<String> = question.on.map_or_else(usual, <[String]>::to_vec);
        let known_categories = categories::known(&rides);
        rides.retain(|ride| asked.iter().all(|fact| ride.knows(fact)));
        let in_words = asked
            .iter()
            .filter(|fact| known_categories.iter().any(|k| k.name == **fact));
        let categories: Vec<Categories> =
            in_words.map(|fact| Categories::of(fact, &rides)).collect();
        rides.retain(|ride| categories.iter().all(|fact| fact.takes(ride)));
        let mut found = Self {
            axle: question.axle.to_owned(),
            name: question.name.to_owned(),
            unit: rows
                .first()
                .map_or_else(String::new, |row| row.unit.clone()),
            summary: String::new(),
            rides: rides.len(),
            bikes: 0,
            left_out: all - rides.len(),
            level: None,
            between_rides: None,
            between_bikes: None,
            facts: Vec::new(),
            categories,
            steps: Vec::new(),
            prediction: None,
            development: None,
            known,
            known_categories,
            points: Vec::new(),
        };
        if !rides.is_empty() {
            found.fit(&asked, &rides, question.at);
        }
        found.summary = sentence::of(&found);
        found
    }

    fn fit(&mut self, asked: &[String], rides: &[Ride], at: &BTreeMap<String, f64>) {
        let columns = self.columns(asked);
        let whole = data(&columns, rides);
        self.bikes = whole.bicycles();
        let confounded = Confounding::of(&whole);
        self.describe(&columns, &whole, &confounded);
        let fitted: Vec<usize> = (0..columns.len())
            .filter(|i| confounded[*i].refused.is_none())
            .collect();
        let own = whole.facts.select_columns(&fitted);
        let is_number = |place: &usize| columns[fitted[*place]].category.is_none();
        let numbers: Vec<usize> = (0..fitted.len()).filter(is_number).collect();
        let (data, departures) = with_departures(
            Data {
                facts: own,
                ..whole
            },
            &numbers,
        );
        let Some(fit) = Fit::of(&data) else { return };
        let fitted: Vec<&Column> = fitted.iter().map(|i| &columns[*i]).collect();
        self.level = Some(fit.level);
        self.between_rides = Some(fit.between_rides);
        self.between_bikes = fit.between_bikes;
        self.take(&fitted, &fit, &departures, rides, &data.bikes);
        self.predict(&fit, &fitted, at);
        if self.bikes == 1 && !fitted.iter().any(|column| column.fact == DATE) {
            let left = rides.iter().zip(&fit.residuals);
            let left = left.map(|(ride, residual)| (ride.row.dated_at, *residual, ride.std_error));
            self.development = Development::of(&left.collect::<Vec<_>>(), &[]);
        }
        self.points = self.points(rides, &fit);
    }

    /// A column for each number, and one for each category but the most frequent of its fact.
    fn columns(&self, asked: &[String]) -> Vec<Column> {
        let columns = asked.iter().flat_map(|fact| {
            match self.categories.iter().find(|known| known.fact == *fact) {
                Some(categories) => categories.columns(),
                None => vec![Column {
                    fact: fact.clone(),
                    category: None,
                }],
            }
        });
        columns.collect()
    }

    fn describe(&mut self, columns: &[Column], data: &Data, confounded: &[Confounding]) {
        for (i, (column, confounding)) in columns.iter().zip(confounded).enumerate() {
            let with = confounding
                .with
                .map(|(other, _)| columns[other].fact.clone());
            let Some(category) = &column.category else {
                let values = data.facts.column(i).into_owned();
                self.facts
                    .push(Influence::new(&column.fact, &values, confounding, with));
                continue;
            };
            let refused = confounding
                .refused
                .map(|refusal| influence::reason(refusal, with.as_deref()));
            if let Some(category) = self.category(&column.fact, category) {
                category.reason = refused;
            }
        }
    }

    /// Takes over what was fitted: first the columns of facts, then those of departures.
    fn take(
        &mut self,
        fitted: &[&Column],
        fit: &Fit,
        departures: &[Departure],
        rides: &[Ride],
        bikes: &[usize],
    ) {
        let sizes = || departures.iter().zip(&fit.slopes[fitted.len()..]);
        let of_bike = |bike: usize| {
            rides
                .iter()
                .zip(bikes)
                .filter(move |(_, own)| **own == bike)
        };
        let name = |bike: usize| {
            of_bike(bike)
                .next()
                .map_or_else(String::new, |(ride, _)| ride.row.bike.clone())
        };
        let slope = |bike: usize, fact: &str, slope| {
            let values: Vec<f64> = of_bike(bike).map(|(ride, _)| ride.numbers[fact]).collect();
            OwnSlope {
                bike: name(bike),
                rides: values.len(),
                mean: values.iter().sum::<f64>() / values.len() as f64,
                slope,
            }
        };
        for (place, column) in fitted.iter().enumerate() {
            if let Some(category) = &column.category {
                if let Some(category) = self.category(&column.fact, category) {
                    category.effect = Some(fit.slopes[place]);
                }
                continue;
            }
            let differ = |departure: &Departure| match departure {
                Departure::Slope { bike, fact } if *fact == place => Some(*bike),
                _ => None,
            };
            let differing: Vec<usize> = departures.iter().filter_map(differ).collect();
            let own = sizes().filter_map(|(departure, size)| {
                Some(slope(differ(departure)?, &column.fact, *size))
            });
            let own: Vec<OwnSlope> = own.collect();
            let other = (0..self.bikes).find(|bike| !differing.contains(bike));
            let other = other.map(|bike| slope(bike, &column.fact, fit.slopes[place]));
            let count = self.bikes;
            if let Some(fact) = self.facts.iter_mut().find(|fact| fact.name == column.fact) {
                fact.take(fit, place, own, count, other);
            }
        }
        let steps = sizes().filter_map(|(departure, size)| match departure {
            Departure::Step { bike, ride } => Some(Step {
                bike: name(*bike),
                at: time::text(rides[*ride].row.dated_at),
                size: *size,
            }),
            Departure::Slope { .. } => None,
        });
        self.steps = steps.collect();
    }

    fn category(&mut self, fact: &str, name: &str) -> Option<&mut Category> {
        let mut facts = self.categories.iter_mut();
        facts.find(|known| known.fact == fact)?.category(name)
    }

    fn predict(&mut self, fit: &Fit, fitted: &[&Column], at: &BTreeMap<String, f64>) {
        let mut place = fit.means.clone();
        let mut asked: BTreeMap<String, f64> = BTreeMap::new();
        for (x, column) in place.iter_mut().zip(fitted) {
            if let (None, Some(value)) = (&column.category, at.get(&column.fact)) {
                *x = *value;
                asked.insert(column.fact.clone(), *value);
            }
        }
        if asked.is_empty() {
            return;
        }
        if self.bikes == 1 {
            // As the bicycle is now, after its steps.
            place[fitted.len()..].fill(1.0);
        }
        let prediction = fit.at(&place);
        let facts = self.facts.iter();
        let outside = facts.filter(|fact| {
            let value = asked.get(&fact.name);
            value.is_some_and(|value| !(fact.least..=fact.most).contains(value))
        });
        let beyond: Vec<String> = outside.map(|fact| fact.name.clone()).collect();
        let summary = sentence::predicted(self, &asked, &prediction, &beyond);
        self.prediction = Some(Predicted {
            at: asked,
            prediction,
            summary,
            beyond,
        });
    }

    fn points(&self, rides: &[Ride], fit: &Fit) -> Vec<Point> {
        let sloped: Vec<&String> = self
            .facts
            .iter()
            .filter(|fact| fact.slope.is_some())
            .map(|fact| &fact.name)
            .collect();
        let point = |(ride, residual): (&Ride, &f64)| Point {
            job: ride.row.job_id,
            bike: ride.row.bike.clone(),
            dated_at: time::text(ride.row.dated_at),
            facts: sloped.iter().map(|fact| ride.numbers[*fact]).collect(),
            value: ride.row.value,
            std_error: ride.std_error,
            residual: *residual,
        };
        let step = rides.len().div_ceil(POINTS).max(1);
        let rides = rides.iter().zip(&fit.residuals);
        rides.step_by(step).map(point).collect()
    }
}

fn known(rides: &[Ride]) -> Vec<Known> {
    let mut known: BTreeMap<&str, Known> = BTreeMap::new();
    for (name, value) in rides.iter().flat_map(|ride| &ride.numbers) {
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
