//! What many rides of one bicycle, and many bicycles, say together.

mod beside;
mod dependence;
mod development;
mod effect;
mod event;
mod history;
mod outliers;
mod pool;
mod proposal;
mod regression;
pub mod words;

pub use dependence::{
    Categories, Category, DATE, Dependence, Influence, Question, influence, label,
};
pub use development::{Development, Kind};
pub use effect::{EffectOnBike, on_bikes};
pub use event::BikeEvent;
pub use history::{BikeHistory, Course, FOLLOWED, RIDES, histories, history};
pub use outliers::{FleetSpread, PooledBike, PooledParameter, against_the_fleet};
pub use proposal::{ProposedRide, proposals};
pub use regression::Coefficient;

/// Mean and variance weighted.
fn weighted(values: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64) {
    let total: f64 = values.clone().map(|(_, weight)| weight).sum();
    let mean = values.map(|(value, weight)| weight * value).sum::<f64>() / total;
    (mean, total)
}
