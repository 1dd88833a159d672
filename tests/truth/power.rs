//! Whether a ride shows what its report says that it would have shown.

pub mod outcome;
pub mod run;
