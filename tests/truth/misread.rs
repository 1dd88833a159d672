//! Rides that are misread: recorded well, then written as people get them wrong, and what a binary makes of them.

pub mod mistake;
pub mod outcome;
pub mod record;
pub mod run;
