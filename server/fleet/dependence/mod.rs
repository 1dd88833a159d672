//! What a parameter of one bicycle, or of all, depends on: pressures, temperature, date, load, any number that is known of the rides,
//! and facts in words such as rider and tyres.

mod categories;
mod find;
mod influence;
mod rides;
mod sentence;
#[cfg(test)]
mod tests;
mod variables;
mod view;

pub use find::Question;
pub use sentence::influence;
pub use variables::{DATE, label};
pub use view::{Categories, Category, Dependence, Influence};
