//! Computing in child processes of this program, so that work which aborts, overflows its stack, takes all
//! memory or hears nothing ends one process that nobody else has work in. A child does one task at a time.

mod child;
mod frame;
mod pool;
mod process;
mod word;

pub use child::{Child, ChildError};
pub(super) use pool::Children;
pub(super) use process::Ended;
