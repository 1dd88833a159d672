//! The band in which the road moves the sensors: what is beyond is noise, or the road ends there.

use std::collections::BTreeMap;

use nalgebra::Complex;

use super::record::Sensor;
use super::windows::{Window, Windows};

/// Limits within which spectra are used: over time (Hz), and over distance (cycles/m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    pub low_hz: f64,
    pub high_hz: f64,
    pub highest_per_m: f64,
}

/// Lowest frequency (Hz) that is looked at: a rider pedals and moves below.
pub const LOWEST_HZ: f64 = 1.0;
/// Highest (Hz): four times a front axle's resonance; above, frame and spokes swing by themselves.
pub const HIGHEST_HZ: f64 = 40.0;
/// Least squared coherence of two sensors: each shows some 2.4 times more road than noise.
pub const COHERENT: f64 = 0.5;
/// Fall of a sensor's density over a quarter of an octave from which the road or the logger ends, unless it is a resonance that falls
/// so, at a damping ratio below 0.06.
pub const STEEPEST: f64 = 10.0;
/// Narrowest band (ratio of its ends): an octave.
pub const NARROWEST: f64 = 2.0;
/// Width (ratio of its ends) of a band that no wrong speed leaves: with speeds that were 1.5 to 5 s late, or a pace, the widest of five was 5.6; the
/// narrower of two clean ones that need it was 10.
const WIDE: f64 = 8.0;
/// Cells per octave of spatial frequency.
const CELLS: f64 = 8.0;
/// Spectral lines that are kept away from an edge: as far as a Hann window sees.
const GUARD: f64 = 2.0;

/// Fewest numbers from which two sensors' coherence is taken.
const LEAST: f64 = 4.0;

/// Densities of two sensors over one cell of spatial frequency, and what they have in common: by cells of the frequency over time, as the
/// axles turn the road's phase by that, and differently at another speed.
#[derive(Clone, Default)]
struct Cell {
    place: usize,
    all: Cross,
    crosses: BTreeMap<usize, Cross>,
}

/// Sums of two sensors' powers, and of the first times the other's conjugate.
#[derive(Clone, Copy, Default)]
pub struct Cross {
    pub sum: Complex<f64>,
    pub density: [f64; 2],
    count: f64,
}

impl Cross {
    pub fn add(&mut self, one: Complex<f64>, other: Complex<f64>) {
        self.sum += one * other.conj();
        self.density[0] += one.norm_sqr();
        self.density[1] += other.norm_sqr();
        self.count += 1.0;
    }

    /// Squared size of what both have in common, without what so few numbers have by chance.
    fn common(&self) -> f64 {
        let by_chance = self.density[0] * self.density[1] / self.count;
        let beyond = (self.sum.norm_sqr() - by_chance).max(0.0);
        beyond * self.count / (self.count - 1.0)
    }
}

impl Cell {
    fn coherence(&self) -> f64 {
        let counted = || self.crosses.values().filter(|c| c.count >= LEAST);
        let density = |sensor: usize| counted().map(|c| c.density[sensor]).sum::<f64>();
        let both = density(0) * density(1);
        if both > 0.0 {
            counted().map(|c| c.common().sqrt()).sum::<f64>().powi(2) / both
        } else {
            0.0
        }
    }

    fn mean(&self, sensor: usize) -> f64 {
        self.all.density[sensor] / self.all.count
    }
}

/// The widest band in which the first two sensors are coherent and no edge is passed.
///
/// # Errors
/// Why there is none.
pub fn band(windows: &Windows, sensors: &[Sensor]) -> Result<Band, String> {
    let reach = sensors.iter().take(2).map(|s| s.highest_hz);
    let reach = reach.fold(HIGHEST_HZ, f64::min);
    let speeds = || windows.list.iter().map(|w| w.speed);
    let (slowest, fastest) = (
        speeds().fold(f64::INFINITY, f64::min),
        speeds().fold(0.0, f64::max),
    );
    if sensors.len() < 2 || windows.list.is_empty() {
        return Err("there are fewer than two sensors to compare".to_owned());
    }
    let lowest = LOWEST_HZ / fastest;
    let cells = cells(windows, lowest, reach);
    let Some((first, after)) = run(&cells) else {
        return Err("the sensors are not coherent at any frequency".to_owned());
    };
    let edge = (first..after).find(|i| falls(&cells, *i));
    let end = edge.map_or(after, |i| i + 1);
    let at = |place: usize| lowest * (place as f64 / CELLS).exp2();
    let ends = end < cells.len();
    let highest_per_m = match ends {
        true => at(cells[end - 1].place + 1) - GUARD * windows.spacing_hz / slowest,
        false => reach / slowest,
    };
    let low_hz = (at(cells[first].place) * slowest).max(LOWEST_HZ);
    let top_hz = (highest_per_m * fastest).min(reach);
    if !(top_hz > NARROWEST * low_hz) {
        return Err(format!(
            "the road excites both sensors over less than an octave ({low_hz:.1} Hz to {top_hz:.1} Hz)"
        ));
    }
    Ok(Band {
        low_hz,
        high_hz: reach,
        highest_per_m,
    })
}

/// The widest run of coherent cells where it is wide, and else the one around the most coherent cell: cells of few numbers are coherent, or not, by
/// chance, and a wrong speed leaves a narrow run.
fn run(cells: &[Cell]) -> Option<(usize, usize)> {
    let coherence: Vec<f64> = cells.iter().map(Cell::coherence).collect();
    let mut after = 0;
    let runs = coherence.chunk_by(|a, b| (*a >= COHERENT) == (*b >= COHERENT));
    let runs = runs.map(|run| {
        after += run.len();
        (after - run.len(), after)
    });
    let runs: Vec<(usize, usize)> = runs
        .filter(|(first, _)| coherence[*first] >= COHERENT)
        .collect();
    let width = |run: &(usize, usize)| cells[run.1 - 1].place - cells[run.0].place;
    let widest = runs.iter().max_by_key(|run| width(run))?;
    if width(widest) as f64 >= WIDE.log2() * CELLS {
        return Some(*widest);
    }
    let best = (0..cells.len()).max_by(|a, b| coherence[*a].total_cmp(&coherence[*b]))?;
    runs.into_iter()
        .find(|(first, after)| (*first..*after).contains(&best))
}

/// The cells that hold any line, by rising spatial frequency.
fn cells(windows: &Windows, lowest: f64, reach: f64) -> Vec<Cell> {
    let mut cells: Vec<Cell> = Vec::new();
    let lines = |window: &Window| -> usize {
        ((reach / windows.spacing_hz) as usize).min(window.spectra.len().saturating_sub(1))
    };
    for window in &windows.list {
        for k in (LOWEST_HZ / windows.spacing_hz).ceil() as usize..=lines(window) {
            let (x, hz) = (&window.spectra[k], k as f64 * windows.spacing_hz);
            let place = ((hz / window.speed / lowest).log2() * CELLS).max(0.0) as usize;
            if place >= cells.len() {
                cells.resize(place + 1, Cell::default());
            }
            let cell = &mut cells[place];
            cell.all.add(x[0], x[1]);
            let place = (hz.log2() * CELLS) as usize;
            cell.crosses.entry(place).or_default().add(x[0], x[1]);
        }
    }
    for (place, cell) in cells.iter_mut().enumerate() {
        cell.place = place;
    }
    cells.retain(|c| c.all.count > 0.0);
    cells
}

/// Whether a sensor's density falls steeply after this cell, below what it was over the octave before: a resonance falls back to where it
/// rose from.
fn falls(cells: &[Cell], i: usize) -> bool {
    let near = cells[i + 1..]
        .iter()
        .take_while(|c| c.place <= cells[i].place + 2);
    let before = cells[..=i]
        .iter()
        .rev()
        .take_while(|c| c.place + CELLS as usize >= cells[i].place);
    (0..2).any(|sensor| {
        let least = |cells: &mut dyn Iterator<Item = &Cell>| {
            let means = cells.map(|c| c.mean(sensor));
            means.fold(f64::INFINITY, f64::min)
        };
        let (after, before) = (least(&mut near.clone()), least(&mut before.clone()));
        cells[i].mean(sensor) > STEEPEST * after && after < before
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::record::Lateness;
    use veloid_core::bicycle::Axle;
    use veloid_core::numerics::example::white;
    use veloid_ride::SensorKind;

    /// Two sensors at 5 m/s whose density and squared coherence are given by frequency (Hz).
    fn seen(of: impl Fn(f64) -> [f64; 2]) -> Result<Band, String> {
        let random = white(200 * 200 * 4, 3);
        let mut random = random.chunks_exact(2).map(|c| Complex::new(c[0], c[1]));
        let mut spectrum = |k: usize| {
            let [density, coherence] = of(0.25 * k as f64);
            let (x, other) = (random.next().unwrap(), random.next().unwrap());
            let y = x * coherence.sqrt() + other * (1.0 - coherence).sqrt();
            vec![x * density.sqrt(), y * density.sqrt()]
        };
        let list = (0..200).map(|_| Window {
            time_s: 0.0,
            speed: 5.0,
            delay_s: 0.2,
            stretch: 1.0,
            spectra: (0..200).map(&mut spectrum).collect(),
        });
        let windows = Windows {
            spacing_hz: 0.25,
            list: list.collect(),
        };
        let sensor = |axle| Sensor {
            axle,
            kind: SensorKind::Acceleration,
            values: Vec::new(),
            known: Lateness::default(),
            highest_hz: 40.0,
            clock_s: 0.0,
            beside: None,
            drift: 0.0,
        };
        band(&windows, &[sensor(Axle::Front), sensor(Axle::Rear)])
    }

    #[test]
    fn the_band_ends_where_the_sensors_part() {
        let beyond = |share: f64| seen(|hz| [1.0, if hz < 10.0 { 0.95 } else { share * COHERENT }]);
        let (whole, cut) = (beyond(1.15).unwrap(), beyond(0.85).unwrap());
        assert_eq!((whole.low_hz, whole.highest_per_m), (LOWEST_HZ, 8.0));
        let top = 5.0 * cut.highest_per_m;
        assert!(top < 10.5 && top > 8.0, "{top} Hz");
        let low = seen(|hz| [1.0, if hz < 5.0 { 0.1 } else { 0.95 }]).unwrap();
        assert!(low.low_hz > 4.3 && low.low_hz < 5.6, "{low:?}");
        assert!(seen(|_| [1.0, 0.0]).unwrap_err().contains("not coherent"));
    }

    #[test]
    fn the_widest_band_is_taken_not_the_most_coherent_cell() {
        let of = |hz: f64| {
            [
                1.0,
                if hz < 1.5 {
                    0.99
                } else if hz < 3.0 {
                    0.1
                } else {
                    0.9
                },
            ]
        };
        let band = seen(of).unwrap();
        assert!(band.low_hz > 2.5 && band.low_hz < 4.0, "{band:?}");
        assert_eq!(band.highest_per_m, 8.0);
    }

    #[test]
    fn the_band_ends_at_an_edge() {
        let fall = |share: f64| seen(|hz| [if hz < 10.0 { share * STEEPEST } else { 1.0 }, 0.95]);
        assert_eq!(fall(0.85).unwrap().highest_per_m, 8.0);
        let top = 5.0 * fall(1.15).unwrap().highest_per_m;
        assert!(top < 10.5 && top > 7.5, "{top} Hz");
        // A resonance is none, however weakly it is damped.
        for ratio in [0.1, 0.03, 0.01] {
            let resonance = |hz: f64| {
                let x = hz / 8.0;
                1.0 / ((1.0 - x * x).powi(2) + (2.0 * ratio * x).powi(2))
            };
            let band = seen(|hz| [hz * hz * resonance(hz), 0.95]).unwrap();
            assert_eq!(band.highest_per_m, 8.0, "{ratio}");
        }
    }

    #[test]
    fn less_than_an_octave_shows_nothing() {
        let upto = |hz: f64| seen(move |f| [1.0, if f < hz { 0.95 } else { 0.0 }]);
        assert!(upto(1.5).unwrap_err().contains("less than an octave"));
        assert!(upto(2.0 * NARROWEST * LOWEST_HZ).is_ok());
    }
}
