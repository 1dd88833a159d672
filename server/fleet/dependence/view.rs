use std::collections::BTreeMap;

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::fleet::development::Development;
use crate::fleet::regression::{Coefficient, Prediction};

/// What a parameter depends on: a linear regression with each ride's error, a variance between rides beyond them and, over
/// several bicycles, a level of each.
#[derive(Debug, Serialize, ToSchema)]
pub struct Dependence {
    pub axle: String,
    pub name: String,
    pub unit: String,
    /// What was found, in words.
    pub summary: String,
    /// Rides and bicycles that were fitted.
    pub rides: usize,
    pub bikes: usize,
    /// Rides that were left out because one of the facts is not known of them.
    pub left_out: usize,
    /// The value where every fitted fact has its mean; null where nothing could be fitted.
    pub level: Option<Coefficient>,
    /// Standard deviation of rides beyond their own errors and the facts.
    pub between_rides: Option<f64>,
    /// Standard deviation of bicycles; null of one.
    pub between_bikes: Option<f64>,
    /// The facts that were asked for, in that order.
    pub facts: Vec<Influence>,
    /// Steps of single bicycles, as a new tyre makes one, that are fitted beside the facts; the clearest one first.
    pub steps: Vec<Step>,
    pub prediction: Option<Predicted>,
    /// What became of one bicycle's parameter beside its facts and steps; null where the date is one of the facts.
    pub development: Option<Development>,
    /// Every fact that the rides have, for the next question.
    pub known: Vec<Known>,
    /// The fitted rides, at most 1000 of them, evenly chosen in the order of their dates.
    pub points: Vec<Point>,
}

/// What a fact does.
#[derive(Debug, Serialize, ToSchema)]
pub struct Influence {
    pub name: String,
    /// Empty where it is not known.
    pub unit: String,
    pub mean: f64,
    pub least: f64,
    pub most: f64,
    /// Change of the parameter with one unit of the fact, the others held; null where it is not fitted.
    pub slope: Option<Coefficient>,
    /// Why it is not fitted.
    pub reason: Option<String>,
    /// Share of its variance that the facts before it explain; their influences grow less sure with it.
    pub shared: f64,
    /// The fact before it that it goes with most closely, and their correlation.
    pub goes_with: Option<String>,
    pub correlation: Option<f64>,
    /// Share of its variance that is between bicycles.
    pub between_bikes: f64,
    /// The fitted line, the other facts at their means.
    pub line: Vec<Place>,
}

/// A step of one bicycle.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = BikeStep)]
pub struct Step {
    pub bike: String,
    /// When the first ride after it was.
    #[schema(format = DateTime)]
    pub at: String,
    pub size: Coefficient,
}

/// A place of a line, with its 95 % interval.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = LinePlace)]
pub struct Place {
    pub x: f64,
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// What is expected where facts have values that were asked for, and the others their means; of one bicycle as it is after its steps.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = FactsPrediction)]
pub struct Predicted {
    pub at: BTreeMap<String, f64>,
    #[serde(flatten)]
    pub prediction: Prediction,
    /// In words.
    pub summary: String,
    /// Facts that no ride comes near.
    pub beyond: Vec<String>,
}

/// A fact that some rides have.
#[derive(Debug, Serialize, ToSchema)]
pub struct Known {
    pub name: String,
    pub unit: String,
    pub rides: usize,
    pub least: f64,
    pub most: f64,
}

/// A ride that was fitted.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = FittedRide)]
pub struct Point {
    pub job: Uuid,
    pub bike: String,
    #[schema(format = DateTime)]
    pub dated_at: String,
    /// The fitted facts, in their order.
    pub facts: Vec<f64>,
    pub value: f64,
    pub std_error: f64,
    /// What is above the fit, its bicycle's level taken out too.
    pub residual: f64,
}
