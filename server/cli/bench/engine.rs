//! The engine's steps, each alone.

use rayon::prelude::*;
use veloid_engine::bicycle::Bike;
use veloid_engine::least_squares::{Deflection, Record, least_squares};
use veloid_engine::observer::differentiate_all;
use veloid_engine::report::Trial;
use veloid_engine::ride::{ReadOptions, Ride, parse_only, read};
use veloid_engine::simulate::linear::Input;
use veloid_engine::simulate::simulated_ride::SimulatedRide;
use veloid_engine::swarm::{self, Swarm};
use veloid_engine::{EngineError, Settings, Silent};
use veloid_engine::{conclude, diagnose, observe};

use super::figure::{Figure, timed};
use crate::cli::{CliError, ride_csv};

/// The paper's bicycle with 0.05 mm of noise.
pub fn ride(duration_s: f64, seed: u64) -> Ride {
    SimulatedRide {
        duration_s,
        noise_displacement_m: 5e-5,
        seed,
        ..SimulatedRide::default()
    }
    .ride()
}

pub fn bike() -> Bike {
    Bike {
        bike: "bench".to_owned(),
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        ..Bike::default()
    }
}

pub fn figures(runs: usize) -> Result<Vec<Figure>, CliError> {
    let (minute, five, hour) = (ride(60.0, 1), ride(300.0, 1), ride(3600.0, 1));
    let mut figures = reading(&hour, runs)?;
    figures.extend(regression(&hour, runs)?);
    for (name, ride) in [("60 s", &minute), ("300 s", &five)] {
        let times = timed(runs, || swarm::benchmark(ride))?;
        let name = format!("swarm as the peers', gradient objective, {name}");
        figures.push(Figure::time(name, &times));
    }
    let quick = Settings {
        diagnosis: false,
        ..Settings::default()
    };
    for (name, ride) in [("60 s", &minute), ("1 h", &hour)] {
        let observed = observe(ride, &bike(), &quick)?;
        let ready = || Swarm::new(ride, &bike(), &quick, &observed);
        let prepared = timed(runs, ready)?;
        figures.push(Figure::time(
            format!("a swarm made ready, {name}"),
            &prepared,
        ));
        let swarm = ready()?;
        let times = timed(runs, || trials(&swarm, &quick))?;
        let name = format!("swarm, 10 trials, consistent objective, {name}");
        figures.push(Figure::time(name, &times));
    }
    figures.extend(whole(&minute, &quick, runs)?);
    Ok(figures)
}

fn reading(hour: &Ride, runs: usize) -> Result<Vec<Figure>, CliError> {
    let (file, options) = (
        ride_csv::text(hour, &[]).into_bytes(),
        ReadOptions::default(),
    );
    let megabytes = file.len() as f64 / 1e6;
    let parsed = timed(runs, || parse_only(&file, &options).map(drop))?;
    let all = timed(runs, || read(&file, "bench.csv", &bike(), &options))?;
    Ok(vec![
        Figure::rate("parsing, CSV of 1 h", "MB/s", megabytes, &parsed),
        Figure::rate("reading with all checks, 1 h", "MB/s", megabytes, &all),
    ])
}

/// Observer and least squares on the front axle of an hour.
fn regression(hour: &Ride, runs: usize) -> Result<Vec<Figure>, CliError> {
    let Some(front) = &hour.axles.front else {
        return Ok(Vec::new());
    };
    let millions = hour.samples as f64 / 1e6;
    let step = hour.step_s;
    let signals: Vec<(&[f64], f64)> = (hour.axles.iter())
        .flat_map(|(_, record)| [(&record.displacement[..], 2000.0), (&record.road, 2000.0)])
        .collect();
    let watch = || Ok::<_, EngineError>(differentiate_all(&signals, step));
    let observer = timed(runs, watch)?;
    let followed = watch()?;
    let [z, u, ..] = &followed[..] else {
        return Ok(Vec::new());
    };
    let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    let deflection = Deflection {
        value: minus(&front.road, &z.position),
        rate: minus(&u.velocity, &z.velocity),
        force: None,
    };
    let record = Record {
        step_s: step,
        input: Input::new(&front.road, None, step),
        displacement: &front.displacement,
        valid: &front.valid,
        mass: Some(23.0),
        rest_point: false,
    };
    let squares = timed(runs, || {
        Ok::<_, EngineError>(least_squares(&record, &deflection, &z.acceleration, 100))
    })?;
    let observe = timed(runs, || observe(hour, &bike(), &Settings::default()))?;
    let unit = "M samples/s";
    Ok(vec![
        Figure::rate(
            "observer, z and u of both axles",
            unit,
            4.0 * millions,
            &observer,
        ),
        Figure::rate("least squares with its path", unit, millions, &squares),
        Figure::rate("stage observe, both axles", unit, 2.0 * millions, &observe),
    ])
}

/// Rides from files to reports on all cores, without a server: what a server can at most do.
pub fn alone(files: &[Vec<u8>], settings: &Settings) -> Result<(), CliError> {
    files.par_iter().try_for_each(|file| {
        let ride = read(file, "bench.csv", &bike(), &ReadOptions::default())?;
        let report = veloid_engine::identify(&ride, &bike(), settings, &Silent)?;
        serde_json::to_vec(&report)?;
        Ok(())
    })
}

fn trials(swarm: &Swarm, settings: &Settings) -> Result<Vec<Trial>, EngineError> {
    (0..settings.trials)
        .into_par_iter()
        .map(|index| swarm.trial(index, &Silent))
        .collect()
}

/// What follows the swarm, and everything in a row.
fn whole(minute: &Ride, settings: &Settings, runs: usize) -> Result<Vec<Figure>, CliError> {
    let observed = observe(minute, &bike(), settings)?;
    let swarm = Swarm::new(minute, &bike(), settings, &observed)?;
    let trials = trials(&swarm, settings)?;
    let fit = || conclude(minute, &bike(), settings, &observed, trials.clone());
    let concluded = timed(runs, fit)?;
    let conclusion = fit()?;
    let diagnosed = timed(runs.min(3), || {
        diagnose(minute, &bike(), settings, &conclusion, &Silent)
    })?;
    let identified = timed(runs, || {
        veloid_engine::identify(minute, &bike(), settings, &Silent)
    })?;
    Ok(vec![
        Figure::time(
            "stage conclude (output error, comparison), 60 s",
            &concluded,
        ),
        Figure::time("identification without diagnosis, 60 s", &identified),
        Figure::time("diagnosis, 60 s", &diagnosed),
    ])
}
