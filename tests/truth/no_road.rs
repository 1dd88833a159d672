//! Rides of two accelerometers and a speed, on a road that nobody measured: whether effects are named and intervals hold.

pub mod class;
pub mod conceal;
pub mod conditions;
pub mod course;
pub mod demand;
pub mod logger;
pub mod mark;
pub mod plan;
pub mod ride;
pub mod run;
pub mod score;
pub mod table;
