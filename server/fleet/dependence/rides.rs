//! Rides with what is known of them, as the rows of a regression.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{DMatrix, DVector};

use super::variables::{self, DATE};
use crate::fleet::regression::Data;
use crate::store::dependence::RideRow;

/// A ride with its facts.
pub struct Ride<'a> {
    pub row: &'a RideRow,
    pub std_error: f64,
    pub numbers: BTreeMap<String, f64>,
    pub texts: BTreeMap<&'static str, String>,
}

impl<'a> Ride<'a> {
    pub fn of(row: &'a RideRow) -> Option<Self> {
        let std_error = row.std_error.filter(|e| e.powi(-2).is_normal())?;
        Some(Self {
            row,
            std_error,
            numbers: variables::numbers(row),
            texts: variables::texts(row),
        })
    }

    pub fn knows(&self, fact: &str) -> bool {
        self.numbers.contains_key(fact) || self.texts.contains_key(fact)
    }
}

/// A column of the regression: a number, or whether a fact in words is this one.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    pub fact: String,
    pub category: Option<String>,
}

impl Column {
    fn of(&self, ride: &Ride) -> f64 {
        match &self.category {
            None => ride.numbers.get(&self.fact).copied().unwrap_or(f64::NAN),
            Some(category) => {
                let is = ride.texts.get(self.fact.as_str()) == Some(category);
                f64::from(u8::from(is))
            }
        }
    }
}

/// Rides that know all of these facts, in the order of their dates.
pub fn data(columns: &[Column], rides: &[Ride]) -> Data {
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let bikes = rides.iter().map(|ride| {
        let next = numbers.len();
        *numbers.entry(&ride.row.bike).or_insert(next)
    });
    let each = |of: fn(&Ride) -> f64| DVector::from_iterator(rides.len(), rides.iter().map(of));
    Data {
        bikes: bikes.collect(),
        values: each(|ride| ride.row.value),
        errors: each(|ride| ride.std_error),
        dates: rides.iter().map(|ride| ride.numbers[DATE]).collect(),
        facts: DMatrix::from_fn(rides.len(), columns.len(), |i, j| columns[j].of(&rides[i])),
    }
}
