//! Where the centre of gravity lies between the wheels.

use veloid_engine::bicycle::BikeError;

use super::fields::WHEELBASE;

/// Wheelbases (m) of all bicycles and test rigs: twice what either of its parts may be.
const RANGE_M: [f64; 2] = [0.02, 10.0];

/// What is known of an axle: its distance from the centre of gravity (m), static load (N) and mass (kg).
#[derive(Clone, Copy, Default)]
pub struct Known {
    pub length_m: Option<f64>,
    pub load_n: Option<f64>,
    pub mass_kg: Option<f64>,
}

/// The distances of the centre of gravity from the front and the rear wheel (m) on this wheelbase: what one of them leaves to the
/// other, or where the loads, or else the masses, balance.
pub fn split(wheelbase: f64, front: Known, rear: Known) -> Result<[f64; 2], String> {
    let [low, high] = RANGE_M;
    if !(low..=high).contains(&wheelbase) {
        let key = WHEELBASE.to_owned();
        let value = wheelbase;
        return Err(BikeError::OutOfRange {
            key,
            value,
            low,
            high,
        }
        .to_string());
    }
    match (front.length_m, rear.length_m) {
        (Some(_), Some(_)) => Err(format!(
            "{WHEELBASE} is given together with l_front_m and l_rear_m, expected at most two of the three"
        )),
        (Some(length), None) => Ok([length, wheelbase - length]),
        (None, Some(length)) => Ok([wheelbase - length, length]),
        (None, None) => balanced(wheelbase, front, rear),
    }
}

fn balanced(wheelbase: f64, front: Known, rear: Known) -> Result<[f64; 2], String> {
    let loads = front.load_n.zip(rear.load_n);
    let (on_front, on_rear) = loads.or(front.mass_kg.zip(rear.mass_kg)).ok_or_else(|| {
        format!(
            "{WHEELBASE} needs both masses, both static loads or one of l_front_m and l_rear_m, \
             to locate the centre of gravity"
        )
    })?;
    let share = on_rear / (on_front + on_rear);
    Ok([wheelbase * share, wheelbase * (1.0 - share)])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn known(length_m: Option<f64>, load_n: Option<f64>, mass_kg: Option<f64>) -> Known {
        Known {
            length_m,
            load_n,
            mass_kg,
        }
    }

    /// The heavier wheel is the nearer one: m_F l_F = m_R l_R.
    #[test]
    fn the_centre_of_gravity_lies_where_the_wheels_balance() {
        let [front, rear] = split(
            1.1,
            known(None, None, Some(22.0)),
            known(None, None, Some(66.0)),
        )
        .unwrap();
        assert!((front - 0.825).abs() < 1e-12 && (rear - 0.275).abs() < 1e-12);
        let weighed = known(None, Some(300.0), Some(1.0));
        let [front, rear] = split(1.0, weighed, known(None, Some(100.0), Some(9.0))).unwrap();
        assert!((front - 0.25).abs() < 1e-12 && (rear - 0.75).abs() < 1e-12);
    }

    #[test]
    fn one_length_leaves_the_other() {
        let one = known(Some(0.8), None, None);
        let [front, rear] = split(1.1, one, Known::default()).unwrap();
        assert!(front == 0.8 && (rear - 0.3).abs() < 1e-12);
        let [front, rear] = split(1.1, Known::default(), one).unwrap();
        assert!((front - 0.3).abs() < 1e-12 && rear == 0.8);
        assert!(
            split(1.1, one, one)
                .unwrap_err()
                .contains("two of the three")
        );
        let half = known(None, Some(300.0), Some(22.0));
        let lacking = split(1.1, half, Known::default()).unwrap_err();
        assert!(lacking.contains("both masses"), "{lacking}");
    }
}
