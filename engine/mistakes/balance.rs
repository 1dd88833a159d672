//! Masses, lengths and static loads of a bicycle that contradict each other. On a rigid bicycle l_F m_F = l_R m_R (the centre of
//! gravity stands where both balance), and an axle's static load is its mass times g.

use veloid_core::bicycle::{Axle, Bike, GRAVITY};
use veloid_report::{Mistake, MistakeKind};

/// How near (ratio) two numbers must be to agree, and how near a known factor: what scales and tape measures show.
const AGREES: f64 = 1.2;
const NEAR: f64 = 1.04;
/// Pounds in a kilogram.
const POUNDS: f64 = 2.204_62;

/// What the numbers of a bicycle contradict each other in. Where the contradiction is none of the usual mistakes the verdict
/// stands: a bench need not balance as a bicycle does.
pub fn mistake(bike: &Bike) -> Option<Mistake> {
    let (said, why) = lever(bike).or_else(|| Axle::BOTH.into_iter().find_map(|a| load(bike, a)))?;
    Some(Mistake {
        kind: MistakeKind::Bicycle,
        sentence: format!(
            "{said}: {}. k and B scale with the mass. (On a bench that need not balance, omit the lengths.)",
            why.as_deref().unwrap_or("one of them is wrong")
        ),
        takes_the_verdict: why.is_some(),
    })
}

/// Whether other numbers of the bicycle agree with an axle's mass: its static load, or the balance of both axles.
pub fn confirms_mass(bike: &Bike, axle: Axle) -> bool {
    let is_load = static_load(bike, axle)
        .zip(bike.mass(axle))
        .is_some_and(|(load, mass)| is_near(load, mass * GRAVITY, AGREES));
    let lever = || {
        let front = bike.mass(Axle::Front)? * bike.l_front_m?;
        let rear = bike.mass(Axle::Rear)? * bike.l_rear_m?;
        Some(is_near(front, rear, AGREES))
    };
    is_load || lever() == Some(true)
}

fn static_load(bike: &Bike, axle: Axle) -> Option<f64> {
    match axle {
        Axle::Front => bike.static_load_front_n,
        Axle::Rear => bike.static_load_rear_n,
    }
}

fn is_near(ratio: f64, factor: f64, within: f64) -> bool {
    ratio / factor < within && factor / ratio < within
}

/// That masses and lengths do not balance, and the usual mistake that it looks like.
fn lever(bike: &Bike) -> Option<(String, Option<String>)> {
    let (m_f, m_r) = (bike.mass(Axle::Front)?, bike.mass(Axle::Rear)?);
    let (l_f, l_r) = (bike.l_front_m?, bike.l_rear_m?);
    let (front, rear) = (m_f * l_f, m_r * l_r);
    if is_near(front, rear, AGREES) {
        return None;
    }
    let (heavy, light) = match front > rear {
        true => ("mass_front_kg", "mass_rear_kg"),
        false => ("mass_rear_kg", "mass_front_kg"),
    };
    let by = (front / rear).max(rear / front);
    let why = if is_near(m_f * l_r, m_r * l_f, NEAR) {
        Some("l_front_m and l_rear_m, or the two masses, seem to be swapped".to_owned())
    } else if is_near(by, 2.0, NEAR) {
        Some(format!(
            "{heavy} seems to be twice, or {light} half, its true value"
        ))
    } else if is_near(by, POUNDS, NEAR) {
        Some(format!("{heavy} seems to be in pounds"))
    } else {
        None
    };
    let said = format!(
        "The bicycle's masses and lengths contradict each other (m_F l_F = {front:.1} kg m, m_R l_R = {rear:.1} kg m; both should \
         be about equal)"
    );
    Some((said, why))
}

/// That an axle's static load is not its mass times g.
fn load(bike: &Bike, axle: Axle) -> Option<(String, Option<String>)> {
    let reported = static_load(bike, axle)?;
    let weight = bike.mass(axle)? * GRAVITY;
    if is_near(reported, weight, AGREES) {
        return None;
    }
    let why = if is_near(reported * GRAVITY, weight, NEAR) {
        Some("the load seems to be in kilograms")
    } else if is_near(2.0 * reported, weight, NEAR) {
        Some("the mass seems to be doubled")
    } else if is_near(POUNDS * reported, weight, NEAR) {
        Some("the mass seems to be in pounds")
    } else {
        None
    };
    let said = format!(
        "The static load of the {axle} axle is {reported:.0} N, but its mass weighs {weight:.0} N"
    );
    Some((said, why.map(str::to_owned)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bike(masses: [f64; 2], lengths: [f64; 2], load: Option<f64>) -> Bike {
        Bike {
            mass_front_kg: Some(masses[0]),
            mass_rear_kg: Some(masses[1]),
            l_front_m: Some(lengths[0]),
            l_rear_m: Some(lengths[1]),
            static_load_front_n: load,
            ..Bike::default()
        }
    }

    #[test]
    fn the_usual_mistakes_of_scales_are_named() {
        let papers = [0.808, 0.293];
        for (masses, lengths, load, said) in [
            (
                [46.0, 63.0],
                papers,
                None,
                "mass_front_kg seems to be twice",
            ),
            ([23.0, 31.5], papers, None, "mass_rear_kg half"),
            (
                [23.0, 138.9],
                papers,
                None,
                "mass_rear_kg seems to be in pounds",
            ),
            ([23.0, 63.0], [0.293, 0.808], None, "seem to be swapped"),
            ([23.0, 63.0], papers, Some(23.0), "in kilograms"),
            ([46.0, 126.0], papers, Some(225.6), "doubled"),
            ([50.7, 138.9], papers, Some(225.6), "pounds"),
        ] {
            let found = mistake(&bike(masses, lengths, load)).unwrap_or_else(|| unreachable!());
            assert!(found.sentence.contains(said), "{}", found.sentence);
            assert!(found.takes_the_verdict);
        }
    }

    #[test]
    fn a_mass_is_confirmed_by_its_load_or_by_the_balance() {
        let papers = bike([23.0, 63.0], [0.808, 0.293], None);
        assert!(confirms_mass(&papers, Axle::Front));
        let odd = bike([46.0, 63.0], [0.808, 0.293], Some(225.6));
        assert!(!confirms_mass(&odd, Axle::Front));
        let weighed = bike([23.0, 40.0], [0.808, 0.293], Some(225.6 / 1.01));
        assert!(confirms_mass(&weighed, Axle::Front) && !confirms_mass(&weighed, Axle::Rear));
        assert!(!confirms_mass(&Bike::default(), Axle::Rear));
    }

    #[test]
    fn a_bench_may_be_odd_and_a_bicycle_is_left_alone() {
        let odd = mistake(&bike([40.0, 40.0], [0.5, 0.7], None));
        assert!(odd.is_some_and(|m| !m.takes_the_verdict));
        assert_eq!(
            mistake(&bike([23.0, 63.0], [0.808, 0.293], Some(225.6))),
            None
        );
        assert_eq!(mistake(&bike([23.0, 63.0], [0.808, 0.26], None)), None);
        assert_eq!(mistake(&Bike::default()), None);
    }
}
