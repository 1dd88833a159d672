//! What the verdict means for whoever rode: where, how much, what it changes, what to ride next.

pub mod detectable;
pub mod evidence;
pub mod free_form;
pub mod hidden;
pub mod locate;
pub mod next_ride;
pub mod show;
pub mod simulation;
pub mod windows;
pub mod words;
