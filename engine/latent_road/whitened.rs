//! One bin of the likelihood: its part of the value, and the whitened changes of its covariance.

use std::f64::consts::TAU;

use nalgebra::{Complex, DVector};

use super::bins::{Bin, MOST_SENSORS};
use super::hermitian::{C, Factor, Hermitian, Numbers};
use super::parameters::{Layout, index};
use super::record::Sensor;
use super::response::{MOST_CHANGES, Response};

/// Shares of a Hann window's power that come from the frequency before, from its own, and from the one after: a window sees
/// the covariance smoothed so.
const HANN: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
/// Unknowns that one bin's covariance changes by, the road's density aside.
const MOST: usize = MOST_CHANGES + 2 * MOST_SENSORS + 2;

/// Everything that one bin adds.
pub struct Whitened<const M: usize> {
    /// ln det S + x^H S^-1 x, and its second part.
    pub value: f64,
    pub quadratic: f64,
    /// 1 - y y^H of the whitened spectra y: the gradient's other factor.
    pub excess: Numbers<M>,
    /// By ln of the road's density.
    pub road: Numbers<M>,
    list: [(usize, Numbers<M>); MOST],
    count: usize,
}

impl<const M: usize> Whitened<M> {
    /// Unknowns and the changes by them.
    pub fn changes(&self) -> &[(usize, Numbers<M>)] {
        &self.list[..self.count]
    }

    fn push(&mut self, at: usize, change: Numbers<M>) {
        if let Some(slot) = self.list.get_mut(self.count) {
            *slot = (at, change);
            self.count += 1;
        }
    }
}

/// `near` are the responses at the frequency before, at and after the bin's; `ln_density` the road's beside class C;
/// `changing` the unknowns that responses change by. Nothing where the covariance is none.
pub fn whitened<const M: usize>(
    (sensors, layout): (&[Sensor], &Layout),
    bin: &Bin,
    near: &[Response<M>],
    ln_density: f64,
    changing: &[usize],
    theta: &DVector<f64>,
) -> Option<Whitened<M>> {
    let size = bin.active.min(M);
    let density = ln_density.exp();
    let [apart, jitter] = layout.apart.map_or([0.0; 2], |[a, t]| {
        [theta[a].exp(), 0.5 * (bin.omega * theta[t].exp()).powi(2)]
    });
    let coherence = (-apart - jitter).exp();
    let across = |i: usize, j: usize| index(sensors[i].axle) != index(sensors[j].axle);
    let seen = |pick: &dyn Fn(&Response<M>) -> &Hermitian<M>| {
        let mut sum = Hermitian::ZERO;
        for (response, share) in near.iter().zip(HANN) {
            sum.add(pick(response), share * density);
        }
        for i in 0..M {
            for j in (0..i).filter(|j| across(i, *j)) {
                sum.0[i][j] *= coherence;
            }
        }
        sum
    };
    let signal = seen(&|r| &r.signal);
    let hz = bin.omega / TAU;
    let noise: [f64; M] = std::array::from_fn(|i| layout.noise[i].density(theta, hz));
    let mut covariance = signal;
    for i in 0..M {
        covariance.0[i][i] += noise[i];
    }
    let factor = Factor::new(&covariance, size)?;
    let y = factor.solve(&std::array::from_fn(|i| bin.x[i]));
    let quadratic = y.iter().map(|y| y.norm_sqr()).sum::<f64>();
    let mut out = Whitened {
        value: factor.ln_det + quadratic,
        quadratic,
        excess: excess(&y, size),
        road: factor.whiten(&signal),
        list: [(0, [[0.0; M]; M]); MOST],
        count: 0,
    };
    for (n, at) in changing.iter().enumerate() {
        out.push(*at, factor.whiten(&seen(&|r| &r.changes[n])));
    }
    for i in 0..size {
        let mut own = Hermitian::ZERO;
        own.0[i][i] = Complex::new(noise[i], 0.0);
        let own = factor.whiten(&own);
        let (low, upper) = layout.noise[i].between(hz);
        for (at, part) in [(low, 1.0 - upper), (low + 1, upper)] {
            if part > 0.0 {
                out.push(at, own.map(|row| row.map(|x| part * x)));
            }
        }
    }
    if let Some([a, t]) = layout.apart {
        let mut shared = signal;
        for i in 0..M {
            for j in (0..=i).filter(|j| !across(i, *j)) {
                shared.0[i][j] = C::new(0.0, 0.0);
            }
        }
        let shared = factor.whiten(&shared);
        out.push(a, shared.map(|row| row.map(|x| -apart * x)));
        out.push(t, shared.map(|row| row.map(|x| -2.0 * jitter * x)));
    }
    Some(out)
}

fn excess<const M: usize>(y: &[C; M], size: usize) -> Numbers<M> {
    let mut out = Hermitian::square(y).numbers();
    for (i, row) in out.iter_mut().enumerate() {
        for (j, x) in row.iter_mut().enumerate() {
            *x = if i == j && i < size { 1.0 } else { 0.0 } - *x;
        }
    }
    out
}
