//! Which rides are kept in memory.

use veloid_engine::ride::{AxleRecord, Ride};

/// Most that a ride may take to be sent back from who checks an upload (bytes): half an hour of both axles at 100 Hz and more. A
/// larger one is read once more when its job begins.
pub const SMALL: usize = 16 << 20;
/// Most that the rides may take that are kept (bytes).
pub const ALL: usize = 16 * SMALL;

/// About the memory that a ride takes (bytes).
pub fn bytes(ride: &Ride) -> usize {
    let record = |record: &AxleRecord| {
        let measured = [&record.force, &record.acceleration];
        2 + measured.iter().filter(|values| values.is_some()).count()
    };
    let axles: usize = ride.axles.iter().map(|(_, axle)| record(axle)).sum();
    let others = [
        &ride.speed,
        &ride.cadence,
        &ride.roll,
        &ride.steer,
        &ride.yaw_rate,
        &ride.lateral_speed,
    ];
    let others = others.iter().filter(|values| values.is_some()).count();
    let sensors = ride.sensors.len() + 2 * ride.road_doubts.len();
    size_of::<f64>() * ride.samples * (axles + others + sensors)
}
