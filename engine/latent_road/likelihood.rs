//! Whittle's likelihood of the windows' spectra, its gradient and its expected curvature.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use super::bins::Bins;
use super::hermitian::dot;
use super::parameters::Layout;
use super::record::Sensor;
use super::response::{changing, responses};
use super::whitened::{Whitened, whitened};

/// Standard deviation of ln of one window's road density about the mean road's: roads are rougher here than there.
pub const PATCHES: f64 = 0.7;
/// Standard deviation of the share by which one window's speed is off beside the whole ride's (GPS, once a second).
pub const UNSTEADY: f64 = 0.02;

/// What is one window's own: ln of its road's density beside the mean road's, share by which its speed reads too little.
pub type Own = [f64; 2];

/// Negative log likelihood, with what is known beforehand, and its derivatives by the unknowns.
pub struct Evaluation {
    pub value: f64,
    pub gradient: DVector<f64>,
    pub curvature: DMatrix<f64>,
    pub windows: Vec<Part>,
    /// By frequency: sum of x^H S^-1 x, and what it should be.
    pub quadratic: Vec<[f64; 2]>,
}

/// One window's part.
#[derive(Clone)]
pub struct Part {
    /// Gradient by all unknowns, without what is known beforehand.
    pub score: DVector<f64>,
    /// Gradient and curvature by the window's own unknowns, and curvature across to the others.
    pub gradient: Vector2<f64>,
    pub curvature: Matrix2<f64>,
    pub across: [DVector<f64>; 2],
}

pub struct Likelihood<'a> {
    pub bins: &'a Bins,
    pub sensors: &'a [Sensor],
    pub layout: &'a Layout,
    /// Whether the road's density is unknown at each frequency of each window by itself, so that the curvature holds only what the
    /// comparison of the sensors shows.
    pub any_road: bool,
}

/// The curvature of one bin by unknowns other than the road, whose density there is eliminated.
fn add_compared<const M: usize>(
    speed: Option<usize>,
    found: &Whitened<M>,
    share: f64,
    curvature: &mut DMatrix<f64>,
    part: &mut Part,
) {
    let level = dot(&found.road, &found.road);
    for (i, (at, a)) in found.changes().iter().enumerate() {
        let by_level = dot(a, &found.road) / level;
        let projected = |b| share * (dot(a, b) - by_level * dot(b, &found.road));
        for (to, b) in &found.changes()[..=i] {
            curvature[(*at.max(to), *at.min(to))] += projected(b);
        }
        if speed == Some(*at) {
            part.curvature[(1, 1)] += projected(a);
            for (to, b) in found.changes() {
                part.across[1][*to] += projected(b);
            }
        }
    }
}

impl Evaluation {
    fn empty(unknowns: usize, windows: usize, lines: usize) -> Self {
        let zero = DVector::zeros(unknowns);
        let part = Part {
            score: zero.clone(),
            gradient: Vector2::zeros(),
            curvature: Matrix2::zeros(),
            across: [zero.clone(), zero.clone()],
        };
        Self {
            value: 0.0,
            gradient: zero,
            curvature: DMatrix::zeros(unknowns, unknowns),
            windows: vec![part; windows],
            quadratic: vec![[0.0; 2]; lines],
        }
    }
}

impl Likelihood<'_> {
    /// Nothing where a covariance is none.
    pub fn evaluate(&self, theta: &DVector<f64>, own: &[Own]) -> Option<Evaluation> {
        match self.sensors.len() {
            1 => self.of::<1>(theta, own),
            2 => self.of::<2>(theta, own),
            3 => self.of::<3>(theta, own),
            4 => self.of::<4>(theta, own),
            _ => None,
        }
    }

    fn of<const M: usize>(&self, theta: &DVector<f64>, own: &[Own]) -> Option<Evaluation> {
        let line = |omega: f64| (omega / self.bins.spacing).round() as usize;
        let lines = self.bins.all().map(|b| line(b.omega) + 1).max()?;
        let mut out = Evaluation::empty(theta.len(), self.bins.groups.len(), lines);
        let changing = changing(self.layout);
        let (bins, layout) = (self.bins, self.layout);
        for (w, (group, own)) in bins.groups.iter().zip(own).enumerate() {
            let near = responses::<M>(
                self.sensors,
                layout,
                &bins.scale,
                bins.spacing,
                (group, own[1]),
                theta,
            );
            for (k, bin) in group.bins.iter().enumerate() {
                let ln_density = layout.road(theta, bin.cycles_per_m) + own[0];
                let found = whitened(
                    (self.sensors, layout),
                    bin,
                    &near[k..k + 3],
                    ln_density,
                    &changing,
                    theta,
                )?;
                self.add(&found, w, bin.cycles_per_m, &mut out);
                let sum = &mut out.quadratic[line(bin.omega)];
                *sum = [sum[0] + found.quadratic, sum[1] + bin.active as f64];
            }
        }
        self.know(theta, own, &mut out);
        Some(out)
    }

    /// One bin of window `w`, counted as far as it is not another's repetition.
    fn add<const M: usize>(
        &self,
        found: &Whitened<M>,
        w: usize,
        cycles_per_m: f64,
        out: &mut Evaluation,
    ) {
        let share = self.bins.repeats.recip();
        let part = &mut out.windows[w];
        if self.any_road {
            add_compared(self.layout.speed, found, share, &mut out.curvature, part);
            return;
        }
        let (low, upper) = self.layout.between(cycles_per_m);
        let low = self.layout.knots + low;
        let knots = [(low, 1.0 - upper), (low + 1, upper)];
        out.value += share * found.value;
        let gradient = share * dot(&found.road, &found.excess);
        let road = share * dot(&found.road, &found.road);
        part.gradient[0] += gradient;
        part.curvature[(0, 0)] += road;
        for (i, (at, x)) in knots.iter().enumerate() {
            part.score[*at] += x * gradient;
            part.across[0][*at] += x * road;
            for (to, y) in &knots[..=i] {
                out.curvature[(*at, *to)] += x * y * road;
            }
        }
        for (i, (at, a)) in found.changes().iter().enumerate() {
            let own_gradient = share * dot(a, &found.excess);
            let with_road = share * dot(a, &found.road);
            part.score[*at] += own_gradient;
            part.across[0][*at] += with_road;
            // Knots stand after all other unknowns.
            for (knot, x) in knots {
                out.curvature[(knot, *at)] += x * with_road;
            }
            for (to, b) in &found.changes()[..=i] {
                out.curvature[(*at.max(to), *at.min(to))] += share * dot(a, b);
            }
            if self.layout.speed == Some(*at) {
                part.gradient[1] += own_gradient;
                part.curvature[(0, 1)] += with_road;
                part.curvature[(1, 0)] += with_road;
                part.curvature[(1, 1)] += share * dot(a, a);
                for (knot, x) in knots {
                    part.across[1][knot] += x * with_road;
                }
                for (to, b) in found.changes() {
                    part.across[1][*to] += share * dot(a, b);
                }
            }
        }
    }

    /// Adds what is known beforehand, sums up and makes the curvature whole.
    fn know(&self, theta: &DVector<f64>, own: &[Own], out: &mut Evaluation) {
        for part in &out.windows {
            out.gradient += &part.score;
        }
        for i in 0..theta.len() {
            for j in 0..i {
                out.curvature[(j, i)] = out.curvature[(i, j)];
            }
        }
        for (i, prior) in self.layout.priors.iter().enumerate() {
            let off = (theta[i] - prior.mean) / prior.deviation;
            out.value += 0.5 * off * off;
            out.gradient[i] += off / prior.deviation;
            out.curvature[(i, i)] += prior.deviation.powi(-2);
        }
        for (part, own) in out.windows.iter_mut().zip(own) {
            for (i, spread) in [PATCHES, UNSTEADY].into_iter().enumerate() {
                out.value += 0.5 * (own[i] / spread).powi(2);
                part.gradient[i] += own[i] * spread.powi(-2);
                part.curvature[(i, i)] += spread.powi(-2);
            }
        }
    }
}
