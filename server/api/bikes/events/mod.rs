//! What was done to a bicycle: a service, a new tyre.

pub mod create;
pub mod delete;
pub mod list;
