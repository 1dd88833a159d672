//! The search for a set of effects that explains the ride.

pub mod attempt;
pub mod criteria;
pub mod extend;
mod flatness;
pub mod in_parts;
pub mod null;
pub mod offered;
pub mod parts;
pub mod refit;
pub mod rounds;
pub mod score_test;
pub mod sign_flips;
pub mod squares;
pub mod weak_form;

pub use criteria::Search;
pub use rounds::{Named, Round};
