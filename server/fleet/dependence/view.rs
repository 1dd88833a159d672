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
    /// The numbers that were asked for, in that order.
    pub facts: Vec<Influence>,
    /// The facts in words that were asked for, in that order.
    pub categories: Vec<Categories>,
    /// Steps of single bicycles, as a new tyre makes one, that are fitted beside the facts; the clearest one first.
    pub steps: Vec<Step>,
    pub prediction: Option<Predicted>,
    /// What became of one bicycle's parameter beside its facts and steps; null where the date is one of the facts.
    pub development: Option<Development>,
    /// Every number that is known of rides, for the next question.
    pub known: Vec<Known>,
    /// Every fact in words that is known of rides.
    pub known_categories: Vec<KnownCategories>,
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
    /// Change of the parameter with one unit of the fact, the others held; of several bicycles that of those which agree. Null where
    /// it is not fitted, or where too many differ.
    pub slope: Option<Coefficient>,
    /// Bicycles whose slopes differ from that of the others, with their own; the clearest one first.
    pub own: Vec<OwnSlope>,
    /// Why there is no slope.
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

/// What a fact does on one bicycle that differs from the others.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct OwnSlope {
    pub bike: String,
    pub rides: usize,
    /// Mean of the fact over its rides.
    pub mean: f64,
    pub slope: Coefficient,
}

/// What a fact in words does.
#[derive(Debug, Serialize, ToSchema)]
pub struct Categories {
    pub fact: String,
    /// The most frequent category, with which the others are compared.
    pub reference: String,
    /// The most frequent one first.
    pub categories: Vec<Category>,
    /// Why the fact is not fitted.
    pub reason: Option<String>,
}

/// Rides of which a fact says the same.
#[derive(Debug, Serialize, ToSchema)]
pub struct Category {
    pub name: String,
    pub rides: usize,
    /// How far the parameter is above that of the reference, the other facts held; null of the reference and where it is not fitted.
    pub effect: Option<Coefficient>,
    /// Why it is not fitted.
    pub reason: Option<String>,
}

/// A fact in words that some rides have.
#[derive(Debug, Serialize, ToSchema)]
pub struct KnownCategories {
    pub name: String,
    pub rides: usize,
    pub categories: usize,
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
    /// The numbers that have a slope, in their order.
    pub facts: Vec<f64>,
    pub value: f64,
    pub std_error: f64,
    /// What is above the fit, its bicycle's level, steps and own slopes taken out too.
    pub residual: f64,
}
