//! What a road of unit density makes of the sensors, and how that changes with the unknowns.

use std::f64::consts::TAU;

use nalgebra::{Complex, DVector};

use super::bins::{Group, MOST_SENSORS};
use super::hermitian::{C, Hermitian, ZERO};
use super::parameters::{CLASS_C, Layout, index};
use super::record::Sensor;
use super::transfer::response;

/// Unknowns by which responses change at most: two per axle, gain and delay of each sensor but the first, the drift of one
/// laser per axle, the speed.
pub const MOST_CHANGES: usize = 4 + 2 * (MOST_SENSORS - 1) + 2 + 1;

/// The sensors' covariance at one frequency over a road of class C, and its changes in the order of [`changing`].
#[derive(Clone, Copy)]
pub struct Response<const M: usize> {
    pub signal: Hermitian<M>,
    pub changes: [Hermitian<M>; MOST_CHANGES],
}

/// The unknowns that responses change by.
pub fn changing(layout: &Layout) -> Vec<usize> {
    let axles = layout.axles.iter().flatten().flat_map(|at| [*at, at + 1]);
    (axles.chain(layout.gain.iter().flatten().copied()))
        .chain(layout.delay.iter().flatten().copied())
        .chain(layout.drift.iter().flatten().copied())
        .chain(layout.speed)
        .collect()
}

/// The sensors' responses at one frequency, in their own times.
struct Sensed<const M: usize> {
    h: [C; M],
    /// By ln kappa, ln beta of the sensor's axle.
    by_axle: [[C; 2]; M],
    /// By a delay (s), and by the share that the speed is off.
    by_delay: [C; M],
    /// Time of the window since the record's middle (s), in the sensor's axle's time.
    since_middle_s: [f64; M],
    by_speed: [C; M],
}

/// The responses at all frequencies of a window, and at the one before and the one after them; beside the window the share
/// by which its speed reads too little beside the whole ride's.
pub fn responses<const M: usize>(
    sensors: &[Sensor],
    layout: &Layout,
    scale: &[f64],
    spacing: f64,
    window: (&Group, f64),
    theta: &DVector<f64>,
) -> Vec<Response<M>> {
    let (group, _) = window;
    let Some(first) = group.bins.first() else {
        return Vec::new();
    };
    (0..group.bins.len() + 2)
        .map(|k| {
            let omega = first.omega + (k as f64 - 1.0) * spacing;
            let sensed = sensed::<M>(sensors, layout, scale, window, omega, theta);
            let cycles_per_m = omega / TAU / group.speed;
            let density = CLASS_C / (cycles_per_m * cycles_per_m * group.speed);
            covariances(sensors, layout, &sensed, density)
        })
        .collect()
}

fn sensed<const M: usize>(
    sensors: &[Sensor],
    layout: &Layout,
    scale: &[f64],
    (group, off): (&Group, f64),
    omega: f64,
    theta: &DVector<f64>,
) -> Sensed<M> {
    let i = Complex::new(0.0, 1.0);
    let mut out = Sensed {
        h: [ZERO; M],
        by_axle: [[ZERO; 2]; M],
        by_delay: [ZERO; M],
        since_middle_s: [group.time_s; M],
        by_speed: [ZERO; M],
    };
    let speed = layout.speed.map_or(0.0, |v| theta[v]) + off;
    for (n, sensor) in sensors.iter().enumerate().take(M) {
        let axle = index(sensor.axle);
        let Some(at) = layout.axles[axle] else {
            continue;
        };
        let own = if axle == 1 {
            omega / group.stretch
        } else {
            omega
        };
        // The rear was aligned by a delay that is too long by this share where the speed reads too little.
        let late = if axle == 1 {
            omega * group.delay_s
        } else {
            0.0
        };
        let gain = layout.gain[n].map_or(0.0, |g| theta[g]).exp() / scale[n];
        let delay = |n: usize| layout.delay[n].map_or(0.0, |t| theta[t] * sensors[n].clock_s);
        if axle == 1 {
            out.since_middle_s[n] += group.delay_s;
        }
        let drift = layout.drift[n].map_or(0.0, |d| theta[d] * sensor.drift);
        let delay = delay(n) + sensor.beside.map_or(0.0, delay) + drift * out.since_middle_s[n];
        let turn = Complex::from_polar(gain, late * speed - own * delay);
        let found = response(sensor.kind, theta[at].exp(), theta[at + 1].exp(), own);
        out.h[n] = found.value * turn;
        out.by_axle[n] = [found.by_kappa * turn, found.by_beta * turn];
        out.by_delay[n] = -i * out.h[n] * own;
        out.by_speed[n] = i * out.h[n] * late;
    }
    out
}

fn covariances<const M: usize>(
    sensors: &[Sensor],
    layout: &Layout,
    sensed: &Sensed<M>,
    density: f64,
) -> Response<M> {
    let mut out = Response {
        signal: Hermitian::square(&sensed.h).scaled(density),
        changes: [Hermitian::ZERO; MOST_CHANGES],
    };
    let mut slots = out.changes.iter_mut();
    let mut push = |change: [C; M]| {
        if let Some(slot) = slots.next() {
            *slot = Hermitian::pair(&change, &sensed.h).scaled(density);
        }
    };
    for axle in 0..2 {
        if layout.axles[axle].is_some() {
            let on = |n: usize| index(sensors[n].axle) == axle;
            for q in 0..2 {
                let by = |n: usize| if on(n) { sensed.by_axle[n][q] } else { ZERO };
                push(std::array::from_fn(by));
            }
        }
    }
    let alone = |of: &[C; M], s: usize| std::array::from_fn(|n| if n == s { of[n] } else { ZERO });
    for s in (0..M).filter(|s| layout.gain[*s].is_some()) {
        push(alone(&sensed.h, s));
    }
    for s in (0..M).filter(|s| layout.delay[*s].is_some()) {
        let moved = |n: usize| n == s || sensors[n].beside == Some(s);
        let by = |n: usize| {
            if moved(n) {
                sensed.by_delay[n] * sensors[s].clock_s
            } else {
                ZERO
            }
        };
        push(std::array::from_fn(by));
    }
    for s in (0..M).filter(|s| layout.drift[*s].is_some()) {
        let by = sensed.by_delay[s] * sensed.since_middle_s[s] * sensors[s].drift;
        push(std::array::from_fn(|n| if n == s { by } else { ZERO }));
    }
    if layout.speed.is_some() {
        push(sensed.by_speed);
    }
    out
}
