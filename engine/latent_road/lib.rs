//! Stiffness and damping without a sensor for the road.
//!
//! The road is a random process over distance whose spectrum is estimated too (smooth in log-log, ISO 8608). Every sensor sees
//! it through its axle, m z'' + B z' + k z = B u' + k u, with noise of its own, the rear wheel one wheelbase later. In a
//! short window the spectra x of the sensors are then Gaussian with covariance S = h h^H S_u + N, and k, B, the road's spectrum,
//! the sensors' gains, delays and noise follow from Whittle's likelihood (1953), sum of ln det S + x^H S^-1 x. See
//! docs/latent-road.md.
//!
//! `gather` (`rough`) → `record` → `align` → `windows` → `band` → `bins` → `likelihood` (`transfer`, `response`, `whitened`) →
//! `search` (`fit`) → `intervals` → `found`, `clocks`.

mod align;
mod band;
mod bins;
mod clocks;
mod evidence;
mod fit;
mod found;
mod gather;
mod hermitian;
mod intervals;
mod likelihood;
#[cfg(test)]
mod measured;
mod parameters;
mod record;
mod response;
mod rough;
mod search;
#[cfg(test)]
mod tests;
mod transfer;
mod whitened;
mod windows;

pub use band::Band;
use bins::Bins;
pub use clocks::{Compared, compare};
pub use evidence::{Evidence, Reading};
use found::Ended;
pub use gather::beside;
use parameters::Layout;
use record::Record;
use veloid_core::bicycle::Bike;
use veloid_report::LatentRoad;
use veloid_ride::Ride;
use windows::Windows;

/// Knots of the road's spectrum per octave of spatial frequency.
const KNOTS_PER_OCTAVE: f64 = 1.0;
/// Fewest windows that say anything: what they scatter by is counted from them.
const LEAST_WINDOWS: usize = 4;

/// k and B of the axles from the ride's sensors, or why these do not determine them. Nothing for a ride whose road was recorded, or whose
/// sensors show no more than each other's clock.
pub fn latent_road(ride: &Ride, bike: &Bike) -> Option<LatentRoad> {
    if ride.sensors.is_empty() || ride.speed.is_none() && !ride.has_no_road() {
        return None;
    }
    let found = gather::gather(ride, bike).and_then(|record| identify(&record, bike));
    Some(found.unwrap_or_else(LatentRoad::without))
}

fn identify(record: &Record, bike: &Bike) -> Result<LatentRoad, String> {
    let windows = windows(record)?;
    let band = band::band(&windows, &record.sensors)?;
    solved(record, &windows, band, |ended| ended.report(bike))
}

/// The windows of a record.
///
/// # Errors
/// Why there are too few.
fn windows(record: &Record) -> Result<Windows, String> {
    let windows = Windows::of(record);
    if windows.list.len() < LEAST_WINDOWS {
        return Err(format!(
            "only {} stretches of {} s at a steady speed above {} m/s can be used, at least {LEAST_WINDOWS} are needed",
            windows.list.len(),
            windows::WINDOW_S,
            windows::SLOWEST
        ));
    }
    Ok(windows)
}

/// What `reported` makes of the most likely unknowns.
///
/// # Errors
/// Why there are none.
fn solved<T>(
    record: &Record,
    windows: &Windows,
    band: Band,
    reported: impl FnOnce(Ended) -> T,
) -> Result<T, String> {
    let bins = Bins::of(windows, &record.sensors, band);
    let span = bins.span().ok_or("the band contains no frequency")?;
    let layout = Layout::new(&record.sensors, span, KNOTS_PER_OCTAVE);
    let no_fit = "no start leads to a finite likelihood";
    let fit = search::search(&bins, &record.sensors, &layout).ok_or(no_fit)?;
    let spread = intervals::spread(&fit, &bins, &record.sensors, &layout)
        .ok_or("the likelihood has no well-defined maximum")?;
    Ok(reported(Ended {
        record,
        band,
        bins: &bins,
        layout: &layout,
        fit: &fit,
        spread: &spread,
    }))
}
