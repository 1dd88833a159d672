//! Signs and units of a displacement beside the road of its axle. With a displacement that reads g times what it should,
//! eq. (1) becomes z'' = -k/m z - B/m z' + g (k/m u + B/m u'): a regression on z, z', u, u' in the weak form shows g as the ratio
//! of two coefficients, and needs no start.

use veloid_core::bicycle::Axle;
use veloid_core::numerics::modulating::{Windows, regress};
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::{AxleRecord, Ride};

/// Halves of the windows (s), from a fast to a slow axle's time.
const HALVES_S: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Fewest samples in half a window, and fewest windows on either part.
const LEAST: usize = 4;
const FEWEST: usize = 30;
/// Share of the windows that is fitted; the rest judges.
const FITTED: f64 = 0.6;
/// Part of the squares of the acceleration that the right reading explains where nothing was fitted, at least, and that a
/// wrong one may explain at most. No reading is suspected on any of 90 rides with and without concealed effects (`veloid-truth make`,
/// every sixth of seeds 103 and 104).
pub const RIGHT: f64 = 0.9;
const WRONG: f64 = 0.5;
/// How much less an exchange of road and displacement may explain than any gain, which has two coefficients more.
const EQUAL: f64 = 0.05;
/// How near (ratio) the gain must come to that of a known mistake.
const NEAR: f64 = 1.15;
/// Gains of known mistakes, and the unit in which the displacement seems to be where it is said to be in metres.
const UNITS: [(f64, &str); 4] = [(1000.0, "mm"), (100.0, "cm"), (39.37, "inch"), (1e6, "um")];

/// How well readings of one axle explain its acceleration.
struct Reading {
    /// Part of the squares that the plain axle explains as the channels stand, and with a gain of its own.
    stands: f64,
    free: f64,
    gain: f64,
}

/// Mistakes in the displacements of a ride with a measured road.
pub fn mistakes(ride: &Ride) -> Vec<Mistake> {
    if !ride.sensors.is_empty() {
        return Vec::new();
    }
    if let Some(mistake) = swapped(ride) {
        return vec![mistake];
    }
    let axles = ride.axles.iter();
    let of_axle = |(axle, record): (Axle, &AxleRecord)| {
        let by_width = |of: &dyn Fn(usize) -> Option<Reading>| {
            let readings = widths(ride).into_iter().filter_map(of);
            readings.max_by(|a, b| a.free.total_cmp(&b.free))
        };
        let declared = by_width(&|half| reading(record, &record.road, half))?;
        let exchanged = by_width(&|half| exchanged(record, half));
        let follows = exchanged.filter(|other| other.stands > RIGHT && declared.stands < WRONG);
        if follows.is_some_and(|other| other.stands > declared.free - EQUAL) {
            return Some(exchange(axle));
        }
        mistake(axle, &declared)
    };
    axles.filter_map(of_axle).collect()
}

/// Whether every axle follows its road as the channels stand.
pub fn agrees(ride: &Ride) -> bool {
    least_explained(ride).is_some_and(|explained| explained > RIGHT)
}

/// Whether an axle does not follow its road as the channels stand.
pub fn contradicts(ride: &Ride) -> bool {
    least_explained(ride).is_some_and(|explained| explained < WRONG)
}

/// Part of the axles' accelerations that the plain axle explains with the channels as they stand, the least of all axles; nothing where
/// no axle has a road.
fn least_explained(ride: &Ride) -> Option<f64> {
    let explained = |record: &AxleRecord| {
        let readings = widths(ride).into_iter();
        let readings = readings.filter_map(|half| reading(record, &record.road, half));
        readings.map(|r| r.stands).max_by(f64::total_cmp)
    };
    let axles = ride
        .axles
        .iter()
        .filter_map(|(_, record)| explained(record));
    axles.min_by(f64::total_cmp)
}

/// That road and displacement of an axle stand in each other's place.
fn exchange(axle: Axle) -> Mistake {
    let [z, u] = names(axle);
    Mistake {
        kind: MistakeKind::SwappedRoad,
        sentence: format!(
            "The road follows the {axle} axle, not the axle the road: {u} and {z} are swapped. Swap them."
        ),
        takes_the_verdict: true,
    }
}

/// Channels of an axle's displacement and road.
fn names(axle: Axle) -> [&'static str; 2] {
    match axle {
        Axle::Front => ["z_f", "u_f"],
        Axle::Rear => ["z_r", "u_r"],
    }
}

fn mistake(axle: Axle, reading: &Reading) -> Option<Mistake> {
    if reading.free < RIGHT || reading.stands > WRONG {
        return None;
    }
    let [z, u] = names(axle);
    let size = reading.gain.abs();
    let is_near = |gain: f64| size / gain < NEAR && gain / size < NEAR;
    let turned = match reading.gain < 0.0 {
        true => {
            format!("{z} and {u} have opposite signs: invert the one that is positive downwards.")
        }
        false => String::new(),
    };
    if is_near(1.0) {
        return (reading.gain < 0.0).then_some(Mistake {
            kind: MistakeKind::TurnedChannel,
            sentence: turned,
            takes_the_verdict: true,
        });
    }
    let large = |(gain, unit): &(f64, &str)| match (is_near(*gain), is_near(1.0 / gain)) {
        (true, _) => Some((z, u, *gain, unit.to_string())),
        (_, true) => Some((u, z, *gain, unit.to_string())),
        _ => None,
    };
    let (channel, other, gain, unit) = UNITS.iter().find_map(large)?;
    let sentence = format!(
        "{channel} is about {gain} times too large relative to {other}: its unit seems to be {unit}. Name the column \
         \"{channel} [{unit}]\". {turned}"
    );
    Some(Mistake {
        kind: MistakeKind::WrongUnit,
        sentence: sentence.trim_end().to_owned(),
        takes_the_verdict: true,
    })
}

/// Front and rear displacement in each other's place, where each axle follows the other's road and not its own.
fn swapped(ride: &Ride) -> Option<Mistake> {
    let (front, rear) = (ride.axles.front.as_ref()?, ride.axles.rear.as_ref()?);
    // Long waves of a road are alike under both wheels: own and other road are seen through the same window.
    let follows_other = |record: &AxleRecord, other: &AxleRecord| {
        widths(ride).into_iter().any(|half| {
            let stands = |road| reading(record, road, half).map_or(1.0, |r| r.stands);
            let crossed = reading(record, &other.road, half).map_or(0.0, |r| r.stands);
            crossed > RIGHT && stands(&record.road) < WRONG
        })
    };
    let is_swapped = follows_other(front, rear) && follows_other(rear, front);
    is_swapped.then(|| Mistake {
        kind: MistakeKind::SwappedDisplacements,
        sentence: "Each axle follows the other one's road: z_f and z_r, or u_f and u_r, are swapped. Swap one pair."
            .to_owned(),
        takes_the_verdict: true,
    })
}

/// Halves of the windows (samples), no longer than leaves enough of them, whatever the clock says.
fn widths(ride: &Ride) -> Vec<usize> {
    let most = (ride.samples / (2 * FEWEST)).max(LEAST);
    let samples = |half: f64| ((half / ride.step_s) as usize).clamp(LEAST, most);
    let mut halves = HALVES_S.map(samples).to_vec();
    halves.dedup();
    halves
}

/// Reads an axle beside a road through windows of one width; nothing without a road that moves or with too few windows.
fn reading(record: &AxleRecord, road: &[f64], half: usize) -> Option<Reading> {
    if !record.has_road() || record.prescribed || record.force.is_some() {
        return None;
    }
    reads(rows(&record.displacement, road, &record.valid, half))
}

/// The same with road and displacement in each other's place.
fn exchanged(record: &AxleRecord, half: usize) -> Option<Reading> {
    if !record.has_road() || record.prescribed || record.force.is_some() {
        return None;
    }
    reads(rows(
        &record.road,
        &record.displacement,
        &record.valid,
        half,
    ))
}

/// Part of an axle's acceleration that the plain axle explains if its displacement is so many samples late.
pub fn explained_when_late(ride: &Ride, record: &AxleRecord, late: isize) -> Option<f64> {
    if !record.has_road() || record.prescribed || record.force.is_some() {
        return None;
    }
    let from = [late.max(0), (-late).max(0)].map(isize::unsigned_abs);
    let [z, u] = [&record.displacement, &record.road];
    let (z, u) = (z.get(from[0]..)?, u.get(from[1]..)?);
    let [z_valid, u_valid] = from.map(|from| &record.valid[from..]);
    let valid: Vec<bool> = (z_valid.iter().zip(u_valid))
        .map(|(z, u)| *z && *u)
        .collect();
    let readings = (widths(ride).into_iter()).filter_map(|half| reads(rows(z, u, &valid, half)));
    readings.map(|r| r.stands).max_by(f64::total_cmp)
}

/// What the windows of an axle say.
fn reads(rows: Vec<[f64; 8]>) -> Option<Reading> {
    let fitted = (FITTED * rows.len() as f64) as usize;
    if fitted < FEWEST || rows.len() - fitted < FEWEST {
        return None;
    }
    let all: f64 = rows[fitted..].iter().map(|r| r[ACCELERATION].powi(2)).sum();
    let free = regress(&rows, fitted, &[0, 1, 2, 3, 6])?;
    let stands = regress(&rows, fitted, &[4, 5, 6])?;
    // No spring pushes away from rest.
    let explained = |stiffness: f64, left: f64| match stiffness > 0.0 {
        true => 1.0 - left / all,
        false => 0.0,
    };
    Some(Reading {
        stands: explained(stands.by[4], stands.left),
        free: explained(-free.by[0], free.left),
        gain: -free.by[2] / free.by[0],
    })
}

/// Place of the acceleration among the numbers of a window.
const ACCELERATION: usize = 7;

/// What each window sees of z, z', u, u', u - z, u' - z', a constant and z''.
fn rows(z: &[f64], u: &[f64], valid: &[bool], half: usize) -> Vec<[f64; 8]> {
    let windows = Windows::new(half);
    let row = |first: usize| {
        let ([z, v, a], [u, du, _]) = (windows.see(z, first), windows.see(u, first));
        [z, v, u, du, u - z, du - v, windows.one(), a]
    };
    windows.places(valid).into_iter().map(row).collect()
}
