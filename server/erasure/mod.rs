//! Deletion. What is deleted is hidden at once and can be brought back for a time; then it is erased, with all
//! that belongs to it.

mod job_rows;
mod mark;
mod policy;
mod prune;
mod rows;
mod scrub;

pub use mark::{delete, restore_bike, restore_ride};
pub use policy::{DAY_MS, Policy};
pub use prune::{EraseError, Erased, Prune};
