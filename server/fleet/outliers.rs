//! Each bicycle against the fleet, by median and median absolute deviation, which a few broken bikes
//! cannot move.

use serde::Serialize;
use utoipa::ToSchema;
use veloid_courses::{NORMAL, median};

use super::development::Development;
use super::history::{BikeHistory, Course, FOLLOWED};
use super::pool::Pooled;
use super::words::became;

/// Robust deviations beyond which a bicycle is called an outlier (Iglewicz and Hoaglin, 1993).
const FAR: f64 = 3.5;
/// Fewest bikes that make a fleet.
const LEAST: usize = 5;

/// How one parameter scatters over the fleet.
#[derive(Debug, Serialize, ToSchema)]
pub struct FleetSpread {
    pub axle: String,
    pub name: String,
    pub unit: String,
    pub bikes: usize,
    pub median: f64,
    /// Robust standard deviation over the bikes.
    pub scatter: f64,
}

/// One bicycle's pooled parameters.
#[derive(Debug, Serialize, ToSchema)]
pub struct PooledBike {
    pub bike: String,
    pub parameters: Vec<PooledParameter>,
    /// When it was ridden last or, where that is not known, its last ride was uploaded.
    #[schema(format = DateTime)]
    pub last_ride_at: Option<String>,
    /// Effects that its latest 20 rides name.
    pub effects: Vec<String>,
}

#[derive(Debug, Serialize, ToSchema)]
pub struct PooledParameter {
    pub axle: String,
    pub name: String,
    pub unit: String,
    pub pooled: Pooled,
    /// Distance from the fleet's median in robust standard deviations, the bike's own error included.
    pub deviations: Option<f64>,
    pub outlier: bool,
    /// What became of it over the bike's latest 200 rides.
    pub development: Option<Development>,
    /// What became of it in words, as "fell by 4.1 ± 0.9 kN/m on 12 June"; null where nothing did.
    pub summary: Option<String>,
    /// Its values over these rides, oldest first.
    #[serde(skip)]
    pub values: Vec<f64>,
}

impl PooledParameter {
    /// The course of a bike beside the fleet's spread; sizes of effects are compared with no fleet.
    fn of(course: &Course, spread: Option<&FleetSpread>) -> Option<Self> {
        let pooled = course.pooled.clone()?;
        let deviations = spread.and_then(|spread| {
            let scatter = spread.scatter.hypot(pooled.std_error);
            let is_fleet = spread.bikes >= LEAST && scatter > 0.0;
            is_fleet.then(|| (pooled.value - spread.median) / scatter)
        });
        Some(Self {
            axle: course.axle.clone(),
            name: course.name.clone(),
            unit: course.unit.clone(),
            summary: (course.development.as_ref())
                .and_then(|development| became(development, &course.unit)),
            development: course.development.clone(),
            values: course.points.iter().map(|point| point.value).collect(),
            outlier: deviations.is_some_and(|d| d.abs() > FAR),
            deviations,
            pooled,
        })
    }
}

/// A course of a bike, and its rides pooled.
fn pooled<'a>(
    axle: &str,
    name: &str,
    history: &'a BikeHistory,
) -> Option<(&'a Course, &'a Pooled)> {
    let mut courses = history.courses.iter();
    let course = courses.find(|c| c.axle == axle && c.name == name)?;
    Some((course, course.pooled.as_ref()?))
}

/// The spread of every parameter, and every bike's place in it.
pub fn against_the_fleet(histories: &[BikeHistory]) -> (Vec<FleetSpread>, Vec<PooledBike>) {
    let spreads: Vec<FleetSpread> = FOLLOWED
        .into_iter()
        .filter_map(|(axle, name)| {
            let found: Vec<_> = histories
                .iter()
                .filter_map(|h| pooled(axle, name, h))
                .collect();
            let values: Vec<f64> = found.iter().map(|(_, p)| p.value).collect();
            let middle = median(values.clone());
            let distances = values.iter().map(|value| (value - middle).abs()).collect();
            Some(FleetSpread {
                axle: axle.to_owned(),
                name: name.to_owned(),
                unit: found.first()?.0.unit.clone(),
                bikes: values.len(),
                median: middle,
                scatter: NORMAL * median(distances),
            })
        })
        .collect();
    let place = |history: &BikeHistory| PooledBike {
        bike: history.bike.clone(),
        last_ride_at: history.last_ride_at(),
        effects: history.effects.clone(),
        parameters: (history.courses.iter())
            .filter_map(|course| {
                let mut all = spreads.iter();
                let spread = all.find(|s| s.axle == course.axle && s.name == course.name);
                PooledParameter::of(course, spread)
            })
            .collect(),
    };
    let bikes = histories.iter().map(place).collect();
    (spreads, bikes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bike(name: usize, k: f64) -> BikeHistory {
        BikeHistory {
            bike: format!("bike-{name}"),
            effects: Vec::new(),
            events: Vec::new(),
            courses: vec![Course {
                axle: "front".into(),
                name: "k_n_m".into(),
                unit: "N/m".into(),
                points: Vec::new(),
                pooled: Pooled::of(&[(k, 10.0)]),
                development: None,
            }],
        }
    }

    #[test]
    fn one_soft_tyre_stands_out_and_does_not_hide_itself() {
        let stiffness = [100e3, 101e3, 99e3, 100.5e3, 99.5e3, 60e3];
        let fleet: Vec<_> = stiffness
            .iter()
            .enumerate()
            .map(|(i, k)| bike(i, *k))
            .collect();
        let (spreads, bikes) = against_the_fleet(&fleet);
        assert!((spreads[0].median - 99.75e3).abs() < 1.0);
        let outliers: Vec<bool> = bikes.iter().map(|b| b.parameters[0].outlier).collect();
        assert_eq!(outliers, [false, false, false, false, false, true]);
    }

    #[test]
    fn few_bikes_are_no_fleet() {
        let (_, bikes) = against_the_fleet(&[bike(0, 1.0), bike(1, 9e9)]);
        assert!(bikes.iter().all(|b| b.parameters[0].deviations.is_none()));
    }
}
