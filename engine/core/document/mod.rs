//! Documents: what every one that is written passes, JSON that people write, and numbers and names as people read them.

mod finite_gate;
pub mod format_number;
pub mod json;
mod unseen;

pub use finite_gate::{NotFinite, checked};
pub use unseen::{seen, unseen};
