//! What people get wrong before a record comes here: a sign, a unit, an axle, a mass. Asked of every ride before anything is
//! made of its numbers. Each is reported only where the record shows the right reading beside the wrong one; a ride that is odd
//! for another reason is left to the diagnosis.

mod balance;
mod clock;
mod course;
mod gain;

use crate::bicycle::Bike;
use crate::report::Mistake;
use crate::ride::Ride;

/// All that is found on a ride.
pub fn mistakes(ride: &Ride, bike: &Bike) -> Vec<Mistake> {
    let mut found: Vec<Mistake> = clock::mistake(ride).into_iter().collect();
    found.extend(balance::mistake(bike));
    found.extend(gain::mistakes(ride));
    found.extend(course::mistake(ride, bike));
    found
}
