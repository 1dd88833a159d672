//! Drives a vehicle with what the loggers wrote: the only view of a ride that a refit may have.

use std::ops::Range;

use serde_json::Value;

use super::spline::Spline;
use crate::simulate::drive::{Drive, Travel, cumulative};
use crate::simulate::effect::{Effect, Kind};
use crate::simulate::integrate::{Motion, integrate};
use crate::simulate::road::{Road, STEP_M};
use crate::simulate::sensors::{Chain, Log};
use crate::simulate::vehicle::{Bike, State, Vehicle};

/// Half width of the window that smooths the logged speed, s.
const SMOOTH_S: f64 = 0.25;

#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    #[error("bike file lacks {0}")]
    Bike(&'static str),
    #[error("ride line {line}: {problem}")]
    Ride { line: usize, problem: String },
}

/// A logged ride ready to be simulated.
pub struct Replay {
    pub log: Log,
    pub bike: Bike,
    roads: Option<[Road; 2]>,
    plain: Drive,
    pub mean_speed_m_s: f64,
}

impl Replay {
    pub fn new(log: Log, bike: Bike, step_s: f64) -> Self {
        let end = log.t.last().copied().unwrap_or(0.0);
        let mut plain = Drive::empty(0.0, step_s, (end / step_s).ceil() as usize);
        let spline = |y: &Vec<f64>| Spline::new(&log.t, y);
        let mut roads = None;
        if !log.v.is_empty() {
            plain.travel = travel(&log, &plain);
            let tables = [0, 1].map(|axle| road(&spline(&log.u[axle]), &plain));
            plain.ride([&tables[0], &tables[1]], [0.0; 2], &[]);
            roads = Some(tables);
        } else if !log.u[0].is_empty() {
            for axle in 0..2 {
                let u = spline(&log.u[axle]);
                (plain.road[axle], plain.road_rate[axle]) =
                    (0..plain.len()).map(|i| u.at(plain.time(i))).unzip();
            }
        }
        for axle in 0..2 {
            if !log.force[axle].is_empty() {
                let force = spline(&log.force[axle]);
                plain.force[axle] = (0..plain.len())
                    .map(|i| force.at(plain.time(i)).0)
                    .collect();
            }
        }
        let mean_speed_m_s = log.v.iter().sum::<f64>() / log.v.len().max(1) as f64;
        Self {
            log,
            bike,
            roads,
            plain,
            mean_speed_m_s,
        }
    }

    /// The ground rests: the rest point is unknown.
    pub fn rests(&self) -> bool {
        self.plain.road[0].is_empty()
    }

    pub fn duration_s(&self) -> f64 {
        self.log.t.last().copied().unwrap_or(0.0)
    }

    pub fn simulate(
        &self,
        vehicle: &Vehicle,
        from: State,
        active: [bool; 2],
        until_s: f64,
    ) -> Motion {
        let changes = |e: &Effect| {
            matches!(
                e.kind,
                Kind::TyreEnveloping | Kind::WheelbaseDelay | Kind::WheelOutOfRound
            )
        };
        match &self.roads {
            Some(roads) if vehicle.effects.iter().any(changes) => {
                let mut drive = self.plain.clone();
                drive.ride([&roads[0], &roads[1]], [0.0; 2], &vehicle.effects);
                integrate(vehicle, &drive, from, active, until_s)
            }
            _ => integrate(vehicle, &self.plain, from, active, until_s),
        }
    }

    /// What a perfect logger would have written at the samples `range` of one axle.
    pub fn logged(
        &self,
        motion: &Motion,
        effects: &[Effect],
        axle: usize,
        range: &Range<usize>,
    ) -> Vec<f64> {
        let chain = Chain::new(axle, effects, self.log.t[0]);
        let limit = self.log.limit_m.map_or(f64::INFINITY, |limit| limit[axle]);
        self.log.t[range.clone()]
            .iter()
            .map(|&t| chain.reads(motion, t, t).clamp(-limit, limit))
            .collect()
    }
}

fn travel(log: &Log, drive: &Drive) -> Travel {
    let dt = log.t[1] - log.t[0];
    let (smooth, slope) = local_quadratic(&log.v, (SMOOTH_S / dt) as usize);
    let speed = Spline::new(&log.t, &smooth);
    let slope = Spline::new(&log.t, &slope.iter().map(|s| s / dt).collect::<Vec<_>>());
    let table =
        |s: &Spline| -> Vec<f64> { (0..drive.len()).map(|i| s.at(drive.time(i)).0).collect() };
    let (speed, acceleration) = (table(&speed), table(&slope));
    let crank = if log.cadence.is_empty() {
        Vec::new()
    } else {
        let rate: Vec<f64> = log
            .cadence
            .iter()
            .map(|rpm| rpm * std::f64::consts::TAU / 60.0)
            .collect();
        let rate = table(&Spline::new(&log.t, &rate));
        cumulative(&rate, &vec![0.0; rate.len()], drive.half_s, 0)
    };
    Travel {
        distance: cumulative(&speed, &acceleration, drive.half_s, 0),
        speed,
        acceleration,
        crank,
    }
}

/// Value and slope per sample of a local quadratic over 2 `half` + 1 samples, narrower at the ends.
fn local_quadratic(y: &[f64], half: usize) -> (Vec<f64>, Vec<f64>) {
    (0..y.len())
        .map(|i| {
            let h = half.min(i).min(y.len() - 1 - i) as i64;
            if h == 0 {
                let (a, b) = (i.max(1) - 1, (i + 1).min(y.len() - 1));
                return (y[i], (y[b] - y[a]) / (b - a).max(1) as f64);
            }
            let (mut s0, mut s2, mut s4, mut p0, mut p1, mut p2) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
            for j in -h..=h {
                let (x, v) = (j as f64, y[(i as i64 + j) as usize]);
                s0 += 1.0;
                s2 += x * x;
                s4 += x.powi(4);
                p0 += v;
                p1 += x * v;
                p2 += x * x * v;
            }
            ((p0 * s4 - p2 * s2) / (s0 * s4 - s2 * s2), p1 / s2)
        })
        .unzip()
}

/// The logged road of one wheel as a function of the distance ridden.
fn road(u: &Spline, drive: &Drive) -> Road {
    let distance = &drive.travel.distance;
    let count = (distance[distance.len() - 1] / STEP_M) as usize + 1;
    let (mut height, mut slope) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut i = 0;
    for node in 0..count {
        let x = node as f64 * STEP_M;
        while i + 2 < distance.len() && distance[i + 1] <= x {
            i += 1;
        }
        let s = (x - distance[i]) / (distance[i + 1] - distance[i]);
        let (value, rate) = u.at(drive.time(i) + s * drive.half_s);
        height.push(value);
        slope.push(rate / (drive.travel.speed[i] * (1.0 - s) + drive.travel.speed[i + 1] * s));
    }
    Road::from_nodes(0.0, height, slope)
}

/// The plain bicycle of a bike file; k and B are guesses.
pub fn bike(file: &Value) -> Result<Bike, ReplayError> {
    let get = |name: &'static str| file[name].as_f64().ok_or(ReplayError::Bike(name));
    Ok(Bike {
        mass_kg: [get("mass_front_kg")?, get("mass_rear_kg")?],
        arm_m: [get("l_front_m")?, get("l_rear_m")?],
        wheel_radius_m: [get("wheel_radius_front_m")?, get("wheel_radius_rear_m")?],
        stiffness_n_m: [1e5; 2],
        damping_n_s_m: [500.0; 2],
    })
}

/// Reads a ride that [`Log::to_csv`] wrote. An axle that it does not have rests on a flat road.
pub fn log(csv: &str) -> Result<Log, ReplayError> {
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns = vec![Vec::new(); names.len()];
    for (number, line) in lines.enumerate() {
        let fail = |problem: String| ReplayError::Ride {
            line: number + 2,
            problem,
        };
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != names.len() {
            return Err(fail(format!(
                "{} cells, {} expected",
                cells.len(),
                names.len()
            )));
        }
        for (column, cell) in columns.iter_mut().zip(cells) {
            column.push(
                cell.parse()
                    .map_err(|_| fail(format!("{cell}: not a number")))?,
            );
        }
    }
    let mut take = |name: &str| {
        names
            .iter()
            .position(|n| *n == name)
            .map_or(Vec::new(), |i| std::mem::take(&mut columns[i]))
    };
    let mut log = Log {
        t: take("t"),
        u: [take("u_f"), take("u_r")],
        z: [take("z_f"), take("z_r")],
        force: [take("force_f"), take("force_r")],
        a: [take("a_f"), take("a_r")],
        v: take("v"),
        cadence: take("cadence"),
        limit_m: None,
    };
    if log.t.len() < 2 || log.z.iter().all(Vec::is_empty) {
        return Err(ReplayError::Ride {
            line: 1,
            problem: "needs t and z_f or z_r".to_owned(),
        });
    }
    for axle in 0..2 {
        if log.z[axle].is_empty() {
            log.z[axle] = vec![0.0; log.t.len()];
            log.u[axle] = vec![0.0; log.u[1 - axle].len()];
        }
    }
    Ok(log)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axle_that_a_log_lacks_rests() {
        let read = |csv| log(csv).map(|log| (log.has(), log.u));
        let (has, u) = read("t,u_r,z_r\n0.0,1.0,2.0\n0.1,1.0,2.0\n").expect("read");
        assert_eq!(has, [false, true]);
        assert_eq!(u, [vec![0.0; 2], vec![1.0; 2]]);
        assert!(read("t,u_r\n0.0,1.0\n0.1,1.0\n").is_err());
    }
}
