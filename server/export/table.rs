//! The ride as models are fitted to it, as a CSV that the scripts read.

use std::fmt::Write;

use veloid_engine::diagnosis::as_diagnosed;
use veloid_engine::ride::Ride;

/// Time and channels in SI units with all their digits, the rate of the speed, and the number of the sample, by which scripts know the table.
pub fn table(ride: &Ride) -> String {
    let (ride, speed_rate) = as_diagnosed(ride);
    let mut columns = ride.channels();
    columns.extend(speed_rate.as_deref().map(|rate| ("speed_rate", rate)));
    let mut csv = "t".to_owned();
    for (name, _) in &columns {
        let _ = write!(csv, ",{name}");
    }
    csv.push_str(",veloid_sample\n");
    for i in 0..ride.samples {
        let _ = write!(csv, "{:?}", ride.time_s(i));
        for (_, values) in &columns {
            let _ = write!(csv, ",{:?}", values[i]);
        }
        let _ = writeln!(csv, ",{i}");
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_engine::simulate::simulated_ride::SimulatedRide;

    #[test]
    fn a_table_says_that_it_is_one() {
        let simulated = SimulatedRide {
            duration_s: 3.0,
            ..SimulatedRide::default()
        };
        let text = table(&simulated.ride());
        let header = text.lines().next().unwrap_or_default();
        assert_eq!(header, "t,u_f,z_f,u_r,z_r,v,speed_rate,veloid_sample");
        assert!(text.lines().nth(2).is_some_and(|line| line.ends_with(",1")));
    }
}
