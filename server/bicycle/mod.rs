//! The bicycle of an upload, however its sender gives it: chosen from the fleet, described in single fields, or as a
//! bike file.

mod fields;
mod given;
mod lengths;
mod read;

pub use fields::{GROUPS, Group};
pub use given::{Chosen, Given, Way};
pub use read::{Fault, of_fields};
