//! Whether several rides of one bicycle, identified as one, give the right verdict and intervals that hold.

pub mod outcome;
pub mod run;
pub mod set;
pub mod table;
