//! Which facts cannot be distinguished from those before them.

use nalgebra::{DMatrix, DVector};

use super::Data;

/// Variance that a fact shares with others from which on it is not fitted beside them: a variance inflation of 10
/// (O'Brien 2007, doi:10.1007/s11135-006-9018-6).
const SHARED: f64 = 0.9;
/// Variance within bicycles from which on a fact is one of rides and not of bicycles only.
const WITHIN: f64 = 0.01;

/// How far a fact stands for others.
#[derive(Clone, Debug, PartialEq)]
pub struct Confounding {
    /// Share of its variance that those fitted before it explain, over all rides or within the bicycles, whichever is more.
    pub shared: f64,
    /// The fact that it goes with most closely, by its column, and their correlation.
    pub with: Option<(usize, f64)>,
    /// Share of its variance that is between bicycles.
    pub between_bikes: f64,
    pub refused: Option<Refusal>,
}

/// Why a fact is not fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It is the same on all rides.
    Constant,
    /// It goes with those before it.
    Shared,
    /// It differs between bicycles only, and these are too few.
    FewBikes,
}

impl Confounding {
    /// Of each fact, in their order.
    pub fn of(data: &Data) -> Vec<Self> {
        let several = data.bicycles() > 1;
        let overall: Vec<_> = data
            .facts
            .column_iter()
            .map(|c| centred(&c.into_owned()))
            .collect();
        let within: Vec<_> = (0..data.facts.ncols()).map(|i| within(data, i)).collect();
        let mut accepted: Vec<usize> = Vec::new();
        let mut of_bikes = 0;
        let mut found = Vec::new();
        for i in 0..data.facts.ncols() {
            let inside = accepted.iter().copied().filter(|j| varies_within(data, *j));
            let inside: Vec<usize> = inside.collect();
            let mut shared = explained(&overall, &accepted, i);
            let varies = varies_within(data, i);
            if several && varies {
                shared = shared.max(explained(&within, &inside, i));
            }
            let correlations = accepted
                .iter()
                .map(|j| (*j, correlation(&overall[*j], &overall[i])));
            let between = 1.0 - within[i].norm_squared() / overall[i].norm_squared();
            let refused = match () {
                () if overall[i].amax() <= 1e-12 * data.facts.column(i).amax() => {
                    Some(Refusal::Constant)
                }
                () if shared > SHARED => Some(Refusal::Shared),
                () if several && !varies && data.bicycles() < of_bikes + 3 => {
                    Some(Refusal::FewBikes)
                }
                () => None,
            };
            found.push(Self {
                shared,
                with: correlations.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())),
                between_bikes: if several && between.is_finite() {
                    between.clamp(0.0, 1.0)
                } else {
                    0.0
                },
                refused,
            });
            if refused.is_none() {
                accepted.push(i);
                of_bikes += usize::from(several && !varies);
            }
        }
        found
    }
}

/// Whether a fact differs between the rides of a bicycle.
pub fn varies_within(data: &Data, fact: usize) -> bool {
    let all = centred(&data.facts.column(fact).into_owned());
    within(data, fact).norm_squared() > WITHIN * all.norm_squared()
}

fn centred(column: &DVector<f64>) -> DVector<f64> {
    column.add_scalar(-column.mean())
}

/// A fact less its mean over each bicycle's rides.
fn within(data: &Data, fact: usize) -> DVector<f64> {
    let mut sums = vec![(0.0, 0.0); data.bicycles()];
    for (bike, x) in data.bikes.iter().zip(data.facts.column(fact).iter()) {
        sums[*bike].0 += x;
        sums[*bike].1 += 1.0;
    }
    let column = data.facts.column(fact);
    let off = data
        .bikes
        .iter()
        .zip(column.iter())
        .map(|(bike, x)| x - sums[*bike].0 / sums[*bike].1);
    DVector::from_iterator(data.rides(), off)
}

/// Share of a column's variance that others explain.
fn explained(columns: &[DVector<f64>], by: &[usize], of: usize) -> f64 {
    let total = columns[of].norm_squared();
    if by.is_empty() || total == 0.0 {
        return 0.0;
    }
    let by: Vec<DVector<f64>> = by.iter().map(|j| columns[*j].normalize()).collect();
    let by = DMatrix::from_columns(&by);
    let Some(gram) = by.tr_mul(&by).cholesky() else {
        return 1.0;
    };
    let left = &columns[of] - &by * gram.solve(&by.tr_mul(&columns[of]));
    (1.0 - left.norm_squared() / total).clamp(0.0, 1.0)
}

fn correlation(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let scale = a.norm() * b.norm();
    if scale > 0.0 { a.dot(b) / scale } else { 0.0 }
}
