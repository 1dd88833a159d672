//! A ride as the CSV that the reader understands.

use std::fmt::Write;

use veloid_engine::ride::Ride;
use veloid_engine::simulate::laser::Logged;

/// Header and one line per sample, the ride's own and those of `others` by their time stamps, with blanks where a channel has none;
/// every number with all its digits, small ones with an exponent.
pub fn text(ride: &Ride, others: &[Logged]) -> String {
    let columns = ride.channels();
    let names = columns.iter().map(|(name, _)| *name);
    let mut csv = "t".to_owned();
    for name in names.chain(others.iter().map(|o| o.channel)) {
        let _ = write!(csv, ",{name}");
    }
    csv.push('\n');
    let mut next = vec![0; others.len()];
    let mut own = 0;
    loop {
        let ahead = others.iter().zip(&next).map(|(o, n)| o.stamps_s.get(*n));
        let times = ahead.map(|t| t.copied().unwrap_or(f64::INFINITY));
        let own_time = if own < ride.samples {
            ride.time_s(own)
        } else {
            f64::INFINITY
        };
        let time = times.fold(own_time, f64::min);
        if time.is_infinite() {
            return csv;
        }
        let _ = write!(csv, "{time:?}");
        for (_, values) in &columns {
            match own_time == time {
                true => {
                    let _ = write!(csv, ",{:?}", values[own]);
                }
                false => csv.push(','),
            }
        }
        own += usize::from(own_time == time);
        for (other, next) in others.iter().zip(&mut next) {
            match other.stamps_s.get(*next) == Some(&time) {
                true => {
                    let _ = write!(csv, ",{:?}", other.values[*next]);
                    *next += 1;
                }
                false => csv.push(','),
            }
        }
        csv.push('\n');
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::Logged;
    use veloid_engine::bicycle::Bike;
    use veloid_engine::ride::{ReadOptions, read};
    use veloid_engine::simulate::simulated_ride::SimulatedRide;

    #[test]
    fn what_is_written_is_read_back() {
        let ride = SimulatedRide {
            duration_s: 3.0,
            noise_displacement_m: 1e-4,
            ..SimulatedRide::default()
        }
        .ride();
        let text = super::text(&ride, &[]);
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

    #[test]
    fn others_stand_between_with_blanks() {
        let ride = SimulatedRide {
            duration_s: 1.0,
            rate_hz: 10.0,
            ..SimulatedRide::default()
        }
        .ride();
        let laser = Logged {
            channel: "d_r",
            stamps_s: vec![-0.05, 0.0, 2.0],
            values: vec![1.0, 2.0, 3.0],
        };
        let text = super::text(&ride, &[laser]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with(",v,d_r"), "{}", lines[0]);
        assert_eq!(lines.len(), 1 + 11 + 2);
        assert_eq!(lines[1], "-0.05,,,,,,1.0");
        assert!(lines[2].starts_with("0.0,") && lines[2].ends_with(",2.0"));
        assert!(lines[3].ends_with(','));
        assert_eq!(lines[13], "2.0,,,,,,3.0");
    }
}
