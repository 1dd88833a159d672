//! What becomes of a parameter over a bicycle's rides: its level, steps, and drifts that begin or end. Rides are looked at one after the
//! other, as they were ridden, and a change is reported once its evidence exceeds a threshold that holds however often one looks.

mod development;
mod evidence;
mod follow;
mod least_squares;
mod robust;
mod structure;
#[cfg(test)]
mod tests;

pub use development::{Development, Drift, Estimate, Step};
pub use follow::{Followed, THRESHOLD, follow};
pub use least_squares::median;
pub use robust::NORMAL;
pub use structure::{Change, Kind, Structure};

/// What one ride says of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ride {
    /// When it was ridden (days).
    pub day: f64,
    pub value: f64,
    /// Its own standard error, above zero.
    pub std_error: f64,
}

/// Rides, oldest first, and what else is known of each: one column for each fact, such as the temperature, that is not to pass for a
/// change.
#[derive(Clone, Copy, Debug)]
pub struct Rides<'a> {
    pub rides: &'a [Ride],
    pub facts: &'a [Vec<f64>],
}

impl Rides<'_> {
    /// Facts in which so many first rides differ.
    fn telling(&self, rides: usize) -> Vec<Vec<f64>> {
        let differ = |fact: &&Vec<f64>| fact[..rides].iter().any(|x| *x != fact[0]);
        self.facts.iter().filter(differ).cloned().collect()
    }
}
