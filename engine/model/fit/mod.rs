//! Extended models: their motion, their fits, and what these say.

pub mod damped;
pub mod estimate;
pub mod fitter;
pub mod integrate;
pub mod model;
pub mod motion;
pub mod normal_equations;
pub mod physical;
pub mod polish;
pub mod refine;
pub mod sandwich;
pub mod shooting;
pub mod tangent;
pub mod together;
pub mod unit;

pub use damped::Effort;
pub use fitter::{Fitted, Fitter};
pub use integrate::rest;
pub use model::{COARSE, FINE, Model};
pub use motion::{Motion, motions};
pub use unit::{Point, Slot, Term, Unit};
