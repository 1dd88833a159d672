//! What the clock and the noise of a laser do to k and B, where the road was made from it.

use crate::uncertainty::road_variant::moved;
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_report::{Estimate, Parameters};
use veloid_ride::Ride;

/// Errors of k and B that come from the road alone: output error again on the road as it may as well have been. Nothing where the
/// road is in no doubt.
pub fn laser_error(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    found: &PerAxle<Estimate>,
) -> PerAxle<Parameters> {
    let mut out = PerAxle::default();
    for doubt in &ride.road_doubts {
        let moved = moved(ride, bike, settings, found, doubt);
        for (axle, e) in found.iter() {
            // Where nothing is found any more, all of it hangs on the laser.
            let by = moved.as_ref().ok().and_then(|m| m.get(axle));
            let [k, b] = by.map_or([e.k_n_m, e.b_n_s_m], |by| [by.k_n_m, by.b_n_s_m]);
            let before: Parameters = out.get(axle).cloned().unwrap_or_default();
            let sum = Parameters {
                k_n_m: k.hypot(before.k_n_m),
                b_n_s_m: b.hypot(before.b_n_s_m),
            };
            out.set(axle, sum);
        }
    }
    out
}
