use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use serde::Serialize;
use veloid_engine::bicycle::{Axle, Bike};
use veloid_engine::report::diagnosis::Place;
use veloid_engine::simulate::laser::Laser;
use veloid_engine::simulate::road::{Bump, Roughness};
use veloid_engine::simulate::simulated_ride::{
    Excitation, FULL_BAND, SimulatedRide, SpeedChange, Spring,
};
use veloid_engine::{EngineError, Imposed, SettingProblem, sensed, simulate};

use super::{CliError, ride_csv, split};

/// Writes a simulated ride and its true parameters.
///
/// By default the paper's bicycle rides for a minute on a road of ISO 8608 class B. The ride is written as a logger would
/// record it; `veloid identify RIDE.csv --bike BIKE.json` reads it. The same arguments give the same bytes.
#[derive(Args)]
pub struct Simulate {
    /// Where to write the ride (CSV); `-` is stdout.
    ride: PathBuf,
    /// Where to write the bike file.
    #[arg(long, value_name = "JSON")]
    bike: Option<PathBuf>,
    /// Where to write the truth: stiffness, damping and all other parameters of the ride.
    #[arg(long, value_name = "JSON")]
    truth: Option<PathBuf>,
    /// Length of the ride (s).
    #[arg(long, default_value_t = 60.0)]
    duration: f64,
    /// Sampling rate (Hz).
    #[arg(long, default_value_t = 100.0)]
    rate: f64,
    /// Riding speed (m/s).
    #[arg(long, default_value_t = 5.0)]
    speed: f64,
    /// A speed that oscillates around its mean: relative amplitude and period (s), such as `0.4:20`.
    #[arg(
        long,
        value_name = "SHARE:PERIOD",
        value_parser = swing,
        conflicts_with_all = ["shaker", "release"]
    )]
    speed_change: Option<SpeedChange>,
    /// Steady cadence (revolutions per minute); without it there is no cadence channel.
    #[arg(long, value_name = "RPM")]
    cadence: Option<f64>,
    /// Roughness of the road: a class of ISO 8608, or `flat` for bumps only.
    #[arg(long, value_enum, ignore_case = true, default_value = "B")]
    road: Road,
    /// A rounded bump: start, length and height (m; negative for a hole); may be given more than once.
    #[arg(long, value_name = "AT:LENGTH:HEIGHT", allow_hyphen_values = true)]
    bump: Vec<Triple>,
    /// A shaker instead of a road: a sine force on each axle mass (N), with linearly rising frequency (Hz).
    #[arg(long, value_name = "FORCE:FROM:TO", conflicts_with_all = ["bump", "release"])]
    shaker: Option<Triple>,
    /// A free decay from this displacement (m) instead of a road.
    #[arg(
        long,
        value_name = "M",
        conflicts_with = "bump",
        allow_hyphen_values = true
    )]
    release: Option<f64>,
    /// Mass on the front and rear wheel (kg).
    #[arg(long, value_name = "FRONT:REAR", default_value = "23:63")]
    mass: Pair,
    /// Vertical stiffness (N/m); one number applies to both axles.
    #[arg(long, value_name = "FRONT:REAR", default_value = "110000")]
    stiffness: Pair,
    /// Vertical damping (N s/m); one number applies to both axles.
    #[arg(long, value_name = "FRONT:REAR", default_value = "1150")]
    damping: Pair,
    /// Distance from the centre of gravity to the wheels (m).
    #[arg(long, value_name = "FRONT:REAR", default_value = "0.808:0.293")]
    lengths: Pair,
    /// Radius of the wheels (m), for the bike file; one number applies to both.
    #[arg(long, value_name = "FRONT:REAR")]
    wheel_radius: Option<Pair>,
    /// An effect outside the plain model, named as in the diagnosis, such as `coulomb_friction:front:friction=20`; the axle is
    /// front, rear or both. Up to three times.
    #[arg(long, value_name = "ID:AXLE:NAME=VALUE,..")]
    effect: Vec<Effect>,
    /// Record only one axle.
    #[arg(long, value_enum)]
    only: Option<OneAxle>,
    /// Highest frequency of the road where the ride is fastest (Hz), at most 0.45 of the rate, which is the default for accelerometers
    /// without a laser. Otherwise the default is a fifth of the rate, and at most 4 cycles a metre; beyond half of its own rate a laser takes the road for a slower one.
    #[arg(long, value_name = "HZ", conflicts_with_all = ["shaker", "release"])]
    road_to: Option<f64>,
    /// By how much the rear wheel runs to the side of the front one's track (m), on a road that is rough alike in all directions
    /// (isotropic): the finer the road, the less of it both wheels share.
    #[arg(long, value_name = "M", default_value_t = 0.0, conflicts_with_all = ["shaker", "release"])]
    track_offset: f64,
    /// Standard deviation of the white noise on the displacement (m).
    #[arg(long, default_value_t = 0.0)]
    noise: f64,
    /// Standard deviation of the white noise on the road (m).
    #[arg(long, default_value_t = 0.0)]
    road_noise: f64,
    /// Write accelerometers on the axles instead of road and displacement, with white noise of this standard deviation (m/s^2):
    /// a ride without a road sensor.
    #[arg(
        long,
        value_name = "M_S2",
        conflicts_with_all = ["shaker", "release", "noise", "road_noise"]
    )]
    accelerometers: Option<f64>,
    /// A laser next to the accelerometer on an axle, on its own logger: axle, white noise (m, standard deviation), delay of its
    /// clock at the start (ms) and drift (parts per million fast), such as `rear:2e-4:20:50`; once for each axle.
    #[arg(
        long,
        value_name = "AXLE:NOISE[:OFFSET_MS[:DRIFT_PPM]]",
        requires = "accelerometers"
    )]
    laser: Vec<LaserClock>,
    /// Sampling rate of the lasers by their own clocks (Hz); their rows are between the others, with blanks.
    #[arg(long, value_name = "HZ", default_value_t = 30.0, requires = "laser")]
    laser_rate: f64,
    /// Instead of RIDE write one file per logger next to it (ride-accelerometers.csv, ride-laser-rear.csv, ride-speed.csv),
    /// with time stamps that begin when the logger was started: earlier by the delay of its clock. Their names go to stdout.
    #[arg(long, requires = "accelerometers")]
    split: bool,
    /// Seed of the road and of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum Road {
    Flat,
    A,
    B,
    C,
    D,
    E,
    F,
    G,
    H,
}

impl Road {
    fn roughness(self) -> Option<Roughness> {
        Some(match self {
            Road::Flat => return None,
            Road::A => Roughness::A,
            Road::B => Roughness::B,
            Road::C => Roughness::C,
            Road::D => Roughness::D,
            Road::E => Roughness::E,
            Road::F => Roughness::F,
            Road::G => Roughness::G,
            Road::H => Roughness::H,
        })
    }
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum OneAxle {
    Front,
    Rear,
}

impl Simulate {
    pub fn run(self) -> Result<(), CliError> {
        let (simulated_ride, bike) = (self.simulated_ride(), self.bicycle());
        let effects: Vec<Imposed> = self.effect.iter().map(|e| e.0.clone()).collect();
        let ride = match self.accelerometers {
            Some(noise) => sensed(&simulated_ride, &bike, &effects, noise)?,
            None => simulate(&simulated_ride, &bike, &effects)?,
        };
        let lasers = self.lasers()?;
        let logged = lasers.iter().map(|laser| laser.logged(&simulated_ride));
        let logged = logged.collect::<Result<Vec<_>, _>>()?;
        bike.validate().map_err(EngineError::from)?;
        if self.split {
            for (name, text) in split::files(&ride, &lasers, &logged) {
                let path = split::beside(&self.ride, &name);
                write(&path, &text)?;
                writeln!(io::stdout(), "{}", path.display())?;
            }
        } else if self.ride.as_os_str() == "-" {
            io::stdout().write_all(ride_csv::text(&ride, &logged).as_bytes())?;
        } else {
            write(&self.ride, &ride_csv::text(&ride, &logged))?;
        }
        if let Some(path) = &self.bike {
            write(path, &(serde_json::to_string_pretty(&bike)? + "\n"))?;
        }
        if let Some(path) = &self.truth {
            let truth = Truth {
                simulated_ride,
                effects,
                lasers,
            };
            write(path, &(serde_json::to_string_pretty(&truth)? + "\n"))?;
        }
        Ok(())
    }

    fn simulated_ride(&self) -> SimulatedRide {
        let spring = |axle: Axle| {
            let left_out = match axle {
                Axle::Front => OneAxle::Rear,
                Axle::Rear => OneAxle::Front,
            };
            (self.only != Some(left_out)).then(|| Spring {
                mass_kg: self.mass.of(axle),
                k_n_m: self.stiffness.of(axle),
                b_n_s_m: self.damping.of(axle),
            })
        };
        let excitation = match (self.shaker, self.release) {
            (Some(Triple([amplitude_n, from_hz, to_hz])), _) => Excitation::Shaker {
                amplitude_n,
                from_hz,
                to_hz,
            },
            (None, Some(displacement_m)) => Excitation::Release { displacement_m },
            (None, None) => Excitation::Road {
                roughness: self.road.roughness(),
                bumps: self.bump.iter().map(Triple::bump).collect(),
            },
        };
        SimulatedRide {
            duration_s: self.duration,
            rate_hz: self.rate,
            speed_m_s: self.speed,
            speed_change: self.speed_change,
            cadence_rpm: self.cadence,
            wheelbase_m: self.lengths.0.iter().sum(),
            front: spring(Axle::Front),
            rear: spring(Axle::Rear),
            excitation,
            road_to_hz: self.road_to.or(self.whole_band()),
            track_offset_m: self.track_offset,
            noise_displacement_m: self.noise,
            noise_road_m: self.road_noise,
            seed: self.seed,
        }
    }

    /// Accelerometers measure as far as their rate goes.
    fn whole_band(&self) -> Option<f64> {
        let is_road = self.shaker.is_none() && self.release.is_none();
        (is_road && self.accelerometers.is_some() && self.laser.is_empty())
            .then_some(FULL_BAND * self.rate)
    }

    fn lasers(&self) -> Result<Vec<Laser>, EngineError> {
        let at = |LaserClock { axle, numbers }: &LaserClock| Laser {
            axle: *axle,
            noise_m: numbers[0],
            offset_s: 1e-3 * numbers[1],
            drift_ppm: numbers[2],
            rate_hz: self.laser_rate,
        };
        let lasers: Vec<Laser> = self.laser.iter().map(at).collect();
        for (i, laser) in lasers.iter().enumerate() {
            if lasers[..i].iter().any(|other| other.axle == laser.axle) {
                return Err(EngineError::Setting {
                    name: "laser",
                    problem: SettingProblem::TwoLasers { axle: laser.axle },
                });
            }
        }
        Ok(lasers)
    }

    fn bicycle(&self) -> Bike {
        Bike {
            bike: "simulated".to_owned(),
            mass_front_kg: Some(self.mass.of(Axle::Front)),
            mass_rear_kg: Some(self.mass.of(Axle::Rear)),
            l_front_m: Some(self.lengths.of(Axle::Front)),
            l_rear_m: Some(self.lengths.of(Axle::Rear)),
            wheel_radius_front_m: self.wheel_radius.map(|r| r.of(Axle::Front)),
            wheel_radius_rear_m: self.wheel_radius.map(|r| r.of(Axle::Rear)),
            ..Bike::default()
        }
    }
}

/// What a ride was made of.
#[derive(Serialize)]
struct Truth {
    #[serde(flatten)]
    simulated_ride: SimulatedRide,
    effects: Vec<Imposed>,
    lasers: Vec<Laser>,
}

fn write(path: &Path, text: &str) -> Result<(), CliError> {
    std::fs::write(path, text).map_err(|source| CliError::File {
        path: path.to_owned(),
        source,
    })
}

/// A number for each axle, as `FRONT:REAR` or as one for both.
#[derive(Clone, Copy)]
struct Pair([f64; 2]);

impl Pair {
    fn of(self, axle: Axle) -> f64 {
        match axle {
            Axle::Front => self.0[0],
            Axle::Rear => self.0[1],
        }
    }
}

impl FromStr for Pair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers(text)?[..] {
            [both] => Ok(Pair([both; 2])),
            [front, rear] => Ok(Pair([front, rear])),
            _ => Err("expected FRONT:REAR".to_owned()),
        }
    }
}

/// Three numbers with colons between them.
#[derive(Clone, Copy)]
struct Triple([f64; 3]);

impl Triple {
    fn bump(&self) -> Bump {
        let [at_m, length_m, height_m] = self.0;
        Bump {
            at_m,
            length_m,
            height_m,
        }
    }
}

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = numbers(text)?;
        numbers
            .try_into()
            .map(Triple)
            .map_err(|_| "expected three numbers separated by colons".to_owned())
    }
}

/// An effect as `ID:AXLE:NAME=VALUE,..`.
#[derive(Clone)]
struct Effect(Imposed);

impl FromStr for Effect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [id, axle, parameters] = text.splitn(3, ':').collect::<Vec<_>>()[..] else {
            return Err("expected ID:AXLE:NAME=VALUE,..".to_owned());
        };
        let axle = match axle {
            "front" => Place::Front,
            "rear" => Place::Rear,
            "both" => Place::Both,
            _ => return Err(format!("'{axle}' is not front, rear or both")),
        };
        let mut given = BTreeMap::new();
        for parameter in parameters.split(',') {
            let Some((name, value)) = parameter.split_once('=') else {
                return Err(format!("'{parameter}' is not NAME=VALUE"));
            };
            // As reports have the side of a stop.
            let value = match value.trim() {
                "compression" => 1.0,
                "rebound" => -1.0,
                "both" => 0.0,
                value => number(value)?,
            };
            if given.insert(name.trim().to_owned(), value).is_some() {
                return Err(format!("{name} is given twice"));
            }
        }
        Ok(Effect(Imposed {
            id: id.to_owned(),
            axle,
            parameters: given,
        }))
    }
}

/// A laser as `AXLE:NOISE[:OFFSET_MS[:DRIFT_PPM]]`.
#[derive(Clone)]
struct LaserClock {
    axle: Axle,
    /// Noise (m), offset (ms), drift (ppm).
    numbers: [f64; 3],
}

impl FromStr for LaserClock {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected AXLE:NOISE[:OFFSET_MS[:DRIFT_PPM]]".to_owned();
        let (axle, rest) = text.split_once(':').ok_or_else(expected)?;
        let axle = match axle {
            "front" => Axle::Front,
            "rear" => Axle::Rear,
            _ => return Err(format!("'{axle}' is not front or rear")),
        };
        let given = numbers(rest)?;
        if given.len() > 3 {
            return Err(expected());
        }
        let mut numbers = [0.0; 3];
        numbers[..given.len()].copy_from_slice(&given);
        Ok(Self { axle, numbers })
    }
}

fn swing(text: &str) -> Result<SpeedChange, String> {
    match numbers(text)?[..] {
        [share, period_s] => Ok(SpeedChange { share, period_s }),
        _ => Err("expected SHARE:PERIOD".to_owned()),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(':').map(number).collect()
}

fn number(text: &str) -> Result<f64, String> {
    let text = text.trim();
    text.parse()
        .map_err(|_| format!("'{text}' is not a number"))
}
