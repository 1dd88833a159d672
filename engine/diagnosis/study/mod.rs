//! Several rides of one bicycle as one: effects too weak for one ride are found in many, and k and B are common where the rides
//! bear that.

mod acting;
mod assemble;
mod ready;
mod rounds;
mod run;

pub use ready::Ready;
pub use run::study;
