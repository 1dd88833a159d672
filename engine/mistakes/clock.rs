//! Times in another unit than was said.

use crate::document::format_number::significant;
use crate::report::{Mistake, MistakeKind};
use crate::ride::Ride;

/// Slowest rate (Hz) at which an axle's motion is recorded, and the fastest of any logger.
const RATES_HZ: [f64; 2] = [2.0, 20e3];
/// Milliseconds and microseconds in a second.
const UNITS: [(f64, &str); 2] = [(1e3, "ms"), (1e6, "us")];

/// That a ride goes so slowly that its times must be in a smaller unit than seconds.
pub fn mistake(ride: &Ride) -> Option<Mistake> {
    let rate = 1.0 / ride.step_s;
    let [slowest, fastest] = RATES_HZ;
    if rate >= slowest {
        return None;
    }
    let as_it_would_be = |(by, _): &&(f64, &str)| (slowest..fastest).contains(&(by * rate));
    let (by, unit) = UNITS.iter().find(as_it_would_be)?;
    Some(Mistake {
        kind: MistakeKind::WrongUnit,
        sentence: format!(
            "By its times this ride has {} samples a second; its times seem to be in {unit}, which would be {}. Head the column \
             \"t [{unit}]\".",
            significant(rate, 3),
            significant(by * rate, 4)
        ),
        takes_the_verdict: true,
    })
}
