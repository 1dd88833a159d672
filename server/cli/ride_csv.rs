//! A ride as the CSV that the reader understands.

use std::fmt::Write;

use veloid_engine::ride::Ride;

/// Header and one line per sample; every number with all its digits, small ones with an exponent.
pub fn text(ride: &Ride) -> String {
    let mut columns: Vec<(&str, &[f64])> = Vec::new();
    for (axle, names) in [
        (&ride.axles.front, ["u_f", "z_f", "force_f", "a_f"]),
        (&ride.axles.rear, ["u_r", "z_r", "force_r", "a_r"]),
    ] {
        let Some(record) = axle else { continue };
        if record.has_road() {
            columns.push((names[0], &record.road));
        }
        columns.push((names[1], &record.displacement));
        columns.extend(record.force.as_deref().map(|values| (names[2], values)));
        columns.extend(
            record
                .acceleration
                .as_deref()
                .map(|values| (names[3], values)),
        );
    }
    for (name, channel) in [
        ("v", &ride.speed),
        ("cadence", &ride.cadence),
        ("roll", &ride.roll),
        ("steer", &ride.steer),
        ("yaw_rate", &ride.yaw_rate),
        ("v_lat", &ride.lateral_speed),
    ] {
        columns.extend(channel.as_deref().map(|values| (name, values)));
    }
    let mut csv = "t".to_owned();
    for (name, _) in &columns {
        let _ = write!(csv, ",{name}");
    }
    csv.push('\n');
    for sample in 0..ride.samples {
        let _ = write!(csv, "{:?}", ride.time_s(sample));
        for (_, values) in &columns {
            let _ = write!(csv, ",{:?}", values[sample]);
        }
        csv.push('\n');
    }
    csv
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use veloid_engine::bicycle::Bike;
    use veloid_engine::ride::{ReadOptions, read};
    use veloid_engine::simulate::outing::Outing;

    #[test]
    fn what_is_written_is_read_back() {
        let ride = Outing {
            duration_s: 3.0,
            noise_displacement_m: 1e-4,
            ..Outing::default()
        }
        .ride();
        let text = super::text(&ride);
        let again = read(
            text.as_bytes(),
            "ride.csv",
            &Bike::default(),
            &ReadOptions::default(),
        )
        .unwrap();
        assert_eq!(again.axles, ride.axles);
        assert_eq!(again.speed, ride.speed);
    }
}
