//! The bicycle of an upload, however its sender tells it: chosen from the fleet, described in single fields, or as a
//! bike file.

mod fields;
mod lengths;
mod read;
mod told;

pub use fields::{GROUPS, Group};
pub use read::{Fault, of_fields};
pub use told::{Chosen, Told, Way};
