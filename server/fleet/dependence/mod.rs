//! What a parameter of one bicycle, or of all, depends on: pressures, temperature, date, load, and any number that is known of
//! the rides.

mod find;
mod sentence;
mod variables;
mod view;

pub use find::Question;
pub use variables::{DATE, label};
pub use view::{Dependence, Influence};
