//! Clean rides as three kinds of bench record them.

use serde_json::Value;

use crate::chance::Chance;
use crate::suite::case::{Case, Class, Noise, Setting};
use crate::suite::circumstance::Circumstance;
use crate::suite::ride::{Plain, plain};

/// What a bench records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Road and displacement of both axles.
    Road,
    /// An accelerometer on each axle.
    Accelerometers,
    /// The same and a laser to the road on one axle.
    Laser,
}

impl Kind {
    pub const ALL: [Kind; 3] = [Kind::Road, Kind::Accelerometers, Kind::Laser];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Road => "with a road",
            Kind::Accelerometers => "accelerometers only",
            Kind::Laser => "with a laser",
        }
    }
}

/// A table as a logger writes it; blank cells are `None`.
#[derive(Clone, Debug)]
pub struct Recorded {
    pub columns: Vec<(String, Vec<Option<f64>>)>,
    pub bike: Value,
    pub stiffness_n_m: [f64; 2],
    pub damping_n_s_m: [f64; 2],
}

/// Standard deviation of an accelerometer's noise (m/s^2) and of a laser's (m).
const ACCELEROMETER: [f64; 2] = [0.02, 0.1];
const LASER_M: [f64; 2] = [5e-5, 2e-4];

/// Clean ride `number` of a seed.
pub fn recorded(kind: Kind, seed: u64, number: u64) -> Recorded {
    let chance = &mut Chance::new(seed, (1 << 40) + number);
    let case = Case {
        class: Class::Clean,
        effects: Vec::new(),
        strange: None,
        size: 1,
        setting: Setting::Road,
        noise: Noise::ALL[number as usize % Noise::ALL.len()],
        circumstance: (kind != Kind::Road).then_some(Circumstance::Rough),
        duration_s: 60.0,
        rate_hz: 100.0,
    };
    let ride = plain(&case, seed, (1 << 41) + number);
    let all = |values: &[f64]| values.iter().map(|x| Some(*x)).collect::<Vec<_>>();
    let mut columns = vec![("t".to_owned(), all(&ride.log.t))];
    let mut add = |name: &str, values: Vec<Option<f64>>| columns.push((name.to_owned(), values));
    let named = |what: &str, axle: usize| format!("{what}_{}", ["f", "r"][axle]);
    if kind == Kind::Road {
        for axle in 0..2 {
            add(&named("u", axle), all(&ride.log.u[axle]));
            add(&named("z", axle), all(&ride.log.z[axle]));
        }
    } else {
        let noise = chance.log_uniform(ACCELEROMETER[0], ACCELEROMETER[1]);
        for axle in 0..2 {
            add(
                &named("a", axle),
                all(&accelerations(&ride, axle, noise, chance)),
            );
        }
    }
    if kind == Kind::Laser {
        let axle = chance.index(2);
        let every = chance.pick(&[1, 2, 4]);
        let noise = chance.log_uniform(LASER_M[0], LASER_M[1]);
        add(
            &named("d", axle),
            deflections(&ride, axle, every, noise, chance),
        );
    }
    add("v", all(&ride.log.v));
    Recorded {
        columns,
        bike: ride.bike_file,
        stiffness_n_m: ride.bike.stiffness_n_m,
        damping_n_s_m: ride.bike.damping_n_s_m,
    }
}

fn accelerations(ride: &Plain, axle: usize, noise: f64, chance: &mut Chance) -> Vec<f64> {
    let reads = |t: &f64| ride.motion.acceleration(axle, *t) + noise * chance.normal();
    ride.log.t.iter().map(reads).collect()
}

/// u - z in every n-th row.
fn deflections(
    ride: &Plain,
    axle: usize,
    every: usize,
    noise: f64,
    chance: &mut Chance,
) -> Vec<Option<f64>> {
    let rows = ride.log.t.iter().enumerate();
    rows.map(|(i, t)| {
        let d = ride.road(axle, *t) - ride.motion.position(axle, *t) + noise * chance.normal();
        (i % every == 0).then_some(d)
    })
    .collect()
}

impl Recorded {
    pub fn column(&mut self, name: &str) -> Option<&mut Vec<Option<f64>>> {
        let found = self.columns.iter_mut().find(|(n, _)| n == name);
        found.map(|(_, values)| values)
    }

    pub fn scale(&mut self, name: &str, by: f64) {
        for x in self.column(name).into_iter().flatten().flatten() {
            *x *= by;
        }
    }

    /// Writes either column under the other one's name.
    pub fn swap(&mut self, a: &str, b: &str) {
        for (name, _) in &mut self.columns {
            if name == a {
                b.clone_into(name);
            } else if name == b {
                a.clone_into(name);
            }
        }
    }

    /// Name of the laser's column.
    pub fn laser(&self) -> Option<String> {
        let mut names = self.columns.iter().map(|(name, _)| name);
        names.find(|name| name.starts_with("d_")).cloned()
    }

    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(n, _)| n.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.columns[0].1.len() {
            let cells = self.columns.iter().map(|(_, values)| values[row]);
            let cells: Vec<String> = cells
                .map(|cell| cell.map_or(String::new(), |x| format!("{x:.9}")))
                .collect();
            text += &(cells.join(",") + "\n");
        }
        text
    }
}
