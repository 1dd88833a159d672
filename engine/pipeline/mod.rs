//! The order of the work: clocks are set right, the stages follow each other, several rides become a study.

mod beside;
mod compare;
mod gains;
#[cfg(test)]
mod hostile;
mod identify;
mod limits;
mod model;
mod observe;
mod result;
mod study;
mod synchronise;
mod validate;
mod what_next;
mod widening;

pub use compare::compare;
pub use identify::{assemble, conclude, diagnose, identify, observe, scores};
pub use model::{ModelError, read_model};
pub use result::result_of;
pub use study::{Ridden, study};
pub use synchronise::{from_arrays, read};
pub use validate::validate;
