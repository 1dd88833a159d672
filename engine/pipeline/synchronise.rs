//! From the files of a ride to a ride whose sensors are on one clock.

use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_latent_road::{Compared, compare};
use veloid_methods::simulate::sensor_noise::noise;
use veloid_mistakes::{agrees, contradicts, lasers_are_turned};
use veloid_ride::{
    self, Arrays, ClockOffset, Column, Content, ReadError, ReadOptions, Ride, RideFile, RoadDoubt,
    SensorClock, SensorKind,
};

/// Reads the files of a ride ([`veloid_ride::read_on_clocks`]) and brings every laser, with all else that its file holds, to the clock of
/// the accelerometer on its axle, as far as the ride shows how they go beside each other.
///
/// # Errors
/// Name the file, the line and the column, and what was expected there.
///
/// ```
/// use veloid_engine::ride::RideFile;
/// use veloid_engine::{Bike, read};
///
/// let mut log = "t,u_f [mm],z_f [mm]\n".to_owned();
/// for i in 0..500 {
///     let t = f64::from(i) / 100.0;
///     let road = 3.0 * (9.0 * t).sin() + (31.0 * t).cos();
///     let axle = 3.1 * (9.0 * t - 0.02).sin() + 1.2 * (31.0 * t - 0.1).cos();
///     log += &format!("{t},{road},{axle}\n");
/// }
/// let file = RideFile::new("ride.csv", log.as_bytes());
/// let ride = read(&[file], &Bike::default(), &Default::default())?;
/// assert_eq!((ride.samples, ride.summary.rate_hz.round()), (500, 100.0));
/// // Millimetres in the file, metres in the ride.
/// let [front, rear] = [ride.axles.front, ride.axles.rear];
/// assert!(front.is_some_and(|front| (front.road[0] - 1e-3).abs() < 1e-9) && rear.is_none());
///
/// let broken = RideFile::new("ride.csv", b"t,u_f,z_f\n0,0.001,here\n");
/// let error = read(&[broken], &Bike::default(), &Default::default()).unwrap_err();
/// assert_eq!((error.file(), error.kind()), ("ride.csv", "not-a-number"));
/// # Ok::<(), veloid_engine::ride::ReadError>(())
/// ```
pub fn read(files: &[RideFile<'_>], bike: &Bike, options: &ReadOptions) -> Result<Ride, ReadError> {
    let (ride, turned) = deflection_turned(files, bike, options)?;
    let mut ride = match turned {
        Some(turned) => on_one_clock(ride, files, bike, &turned)?,
        None => return on_one_clock(ride, files, bike, options),
    };
    ride.summary.warnings.push(
        "by its sign the deflection d is a sensor's distance to the road, -(u - z): it was inverted (set deflection_sign to -1 to say so)"
            .to_owned(),
    );
    Ok(ride)
}

/// The ride with the deflection's sign as it was declared; or as it must be, with the options of that.
fn deflection_turned(
    files: &[RideFile<'_>],
    bike: &Bike,
    options: &ReadOptions,
) -> Result<(Ride, Option<ReadOptions>), ReadError> {
    let declared = veloid_ride::read_on_clocks(files, bike, options, &[])?;
    let deflections =
        Axle::BOTH.map(|axle| veloid_ride::channel_name(SensorKind::Deflection, axle));
    let has_one = |c: &Column| deflections.contains(&c.channel.as_str());
    if !declared.summary.columns.iter().any(has_one) {
        return Ok((declared, None));
    }
    let turned = ReadOptions {
        deflection_sign: -options.deflection_sign,
        ..options.clone()
    };
    // Without accelerometers only the other sign shows whether the axle follows its road then.
    let by_road = declared.sensors.is_empty();
    let is_doubted = match by_road {
        true => contradicts(&declared),
        false => lasers_are_turned(&declared),
    };
    if !is_doubted {
        return Ok((declared, None));
    }
    let other = veloid_ride::read_on_clocks(files, bike, &turned, &[])?;
    match by_road && !agrees(&other) {
        true => Ok((declared, None)),
        false => Ok((other, Some(turned))),
    }
}

/// Brings every laser to the clock of the accelerometer on its axle.
fn on_one_clock(
    ride: Ride,
    files: &[RideFile<'_>],
    bike: &Bike,
    options: &ReadOptions,
) -> Result<Ride, ReadError> {
    let by = |clocks: &[SensorClock]| veloid_ride::read_on_clocks(files, bike, options, clocks);
    let mut lasers = compare(&ride, bike);
    one_for_each_file(&mut lasers);
    let mut clocks: Vec<SensorClock> = lasers.iter().map(|laser| laser.clock.clone()).collect();
    clocks.extend(veloid_ride::unknown_clocks(&ride.summary, &clocks));
    if clocks.is_empty() {
        return Ok(ride);
    }
    let mut ride = by(&clocks)?;
    let mut doubts = Vec::new();
    for (i, clock) in clocks.iter().enumerate() {
        if clocks[..i].iter().any(|before| is_shared(before, clock)) {
            continue;
        }
        let further = clock.found.iter();
        for later in further.flat_map(|found| further_off(found, clock.applied)) {
            let mut moved = clocks.clone();
            for other in moved
                .iter_mut()
                .filter(|other| **other == *clock || is_shared(other, clock))
            {
                other.found = Some(later);
                other.applied = true;
            }
            // Where this cannot be read, the ride is too short by less than a sample.
            if let Ok(other) = by(&moved) {
                doubts.push(RoadDoubt {
                    change: change(&ride, &other),
                    is_noise: false,
                });
            }
        }
    }
    doubts.extend(noisier(&ride, &lasers));
    ride.road_doubts = doubts;
    Ok(ride)
}

/// Reads a ride from arrays of equal length, under names as a file's header has them: `t` (s), `u_f`, `u_r`, `z_f`, `z_r` (m)
/// and whatever else `docs/ride-format.md` lists, in another unit where the name says so (`z_f [mm]`). NaN is a missing
/// value. What a file with the same numbers would be warned of, this is warned of too.
///
/// # Errors
/// Name the column, and the sample counted from 1.
///
/// ```
/// use veloid_engine::{Bike, from_arrays};
///
/// let t: Vec<f64> = (0..500).map(|i| f64::from(i) / 100.0).collect();
/// let road: Vec<f64> = t.iter().map(|t| 3e-3 * (9.0 * t).sin() + 1e-3 * (31.0 * t).cos()).collect();
/// let axle: Vec<f64> = t.iter().map(|t| 3.1e-3 * (9.0 * t - 0.02).sin() + 1.2e-3 * (31.0 * t - 0.1).cos()).collect();
/// let columns = [("t", &t[..]), ("u_f", &road), ("z_f", &axle)];
/// let ride = from_arrays(&columns, &Bike::default(), &Default::default())?;
/// assert_eq!((ride.samples, ride.summary.rate_hz.round()), (500, 100.0));
///
/// let no_time = from_arrays(&columns[1..], &Bike::default(), &Default::default());
/// assert_eq!(no_time.unwrap_err().kind(), "time-missing");
/// # Ok::<(), veloid_engine::ride::ReadError>(())
/// ```
pub fn from_arrays(
    columns: &[(&str, &[f64])],
    bike: &Bike,
    options: &ReadOptions,
) -> Result<Ride, ReadError> {
    let arrays = Arrays {
        columns,
        epoch_s: None,
    };
    let content = Content::Arrays(arrays);
    read(
        &[RideFile {
            name: "arrays",
            content,
        }],
        bike,
        options,
    )
}

/// Whether two sensors stand in one file, and so on one clock.
fn is_shared(a: &SensorClock, b: &SensorClock) -> bool {
    a.file.is_some() && a.file == b.file
}

/// What two lasers in one file say of its clock is put together, each counting as it is sure.
fn one_for_each_file(lasers: &mut [Compared]) {
    let [front, rear] = lasers else { return };
    let (front, rear) = (&mut front.clock, &mut rear.clock);
    if !is_shared(front, rear) {
        return;
    }
    let found = match (front.found, rear.found) {
        (Some(a), Some(b)) => Some(a.together(&b)),
        (one, other) => one.or(other),
    };
    let applied = front.applied || rear.applied;
    for clock in [front, rear] {
        clock.reason = clock.reason.take().filter(|_| found.is_none());
        clock.found = found;
        clock.applied = applied;
    }
}

/// A clock as it may as well go: its offset, and its drift, one standard error further off. What was found and left in is off by
/// as much again.
fn further_off(found: &ClockOffset, applied: bool) -> [ClockOffset; 2] {
    let (kept, left) = match applied {
        true => (*found, ClockOffset::default()),
        false => (
            ClockOffset {
                middle_offset_s: 0.0,
                drift_ppm: 0.0,
                ..*found
            },
            *found,
        ),
    };
    let offset = found.middle_offset_std_s.hypot(left.middle_offset_s);
    let drift = found.drift_std_ppm.hypot(left.drift_ppm);
    [
        ClockOffset {
            middle_offset_s: kept.middle_offset_s + offset,
            ..kept
        },
        ClockOffset {
            drift_ppm: kept.drift_ppm + drift,
            ..kept
        },
    ]
}

/// By how much the road of `other` is higher, where both rides have it.
fn change(ride: &Ride, other: &Ride) -> PerAxle<Vec<f64>> {
    let later = ((ride.start_s - other.start_s) / ride.step_s).round() as isize;
    ride.axles.map(|axle, record| {
        let moved = other.axles.get(axle).map(|r| r.road.as_slice());
        let at = |i: usize| moved?.get((i as isize + later) as usize);
        let change = |(i, u): (usize, &f64)| at(i).map_or(0.0, |moved| moved - u);
        record.road.iter().enumerate().map(change).collect()
    })
}

/// Whichever numbers: the noise that is laid over a road to see what noise does.
const SEED: u64 = 0x6c_6173_6572;

/// As much noise again as the laser holds that the road was made from: the axle's own, or else the front one.
fn noisier(ride: &Ride, lasers: &[Compared]) -> Option<RoadDoubt> {
    lasers.first()?;
    let mut change = PerAxle::default();
    for (n, axle) in Axle::BOTH.into_iter().enumerate() {
        let own = lasers.iter().find(|laser| laser.axle == axle);
        let Some(laser) = own
            .or(lasers.first())
            .filter(|_| ride.axles.get(axle).is_some())
        else {
            continue;
        };
        let seed = SEED + n as u64;
        change.set(
            axle,
            noise(&laser.noise, ride.samples, 1.0 / ride.step_s, seed)?,
        );
    }
    Some(RoadDoubt {
        change,
        is_noise: true,
    })
}
