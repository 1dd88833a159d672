//! The times of a file's rows, and those of one channel among them.

use std::fmt;

use crate::channels::table::Spec;

/// Times of the rows (s).
pub(super) enum Stamps {
    Listed { spec: Spec, times: Vec<f64> },
    Rate(f64),
}

impl Stamps {
    /// Leaves only the samples that are there in `values`. Their times, unless they are all there.
    pub fn own(&self, values: &mut Vec<f64>) -> Option<Vec<f64>> {
        if !values.iter().any(|v| v.is_nan()) {
            return None;
        }
        let own = (values.iter().enumerate())
            .filter(|(_, v)| !v.is_nan())
            .map(|(row, _)| self.time_s(row))
            .collect();
        values.retain(|v| !v.is_nan());
        Some(own)
    }

    pub fn time_s(&self, row: usize) -> f64 {
        match self {
            Self::Listed { times, .. } => times[row],
            Self::Rate(rate) => row as f64 / rate,
        }
    }

    pub fn duration_s(&self, rows: usize) -> f64 {
        let last = rows.saturating_sub(1);
        if rows > 0 {
            self.time_s(last) - self.time_s(0)
        } else {
            0.0
        }
    }

    /// The row of stamp `i` of `own`.
    pub fn row(&self, own: &Option<Vec<f64>>, i: usize) -> Option<usize> {
        match (self, own) {
            (Self::Listed { times, .. }, Some(own)) => times.iter().position(|t| *t == own[i]),
            (Self::Listed { .. }, None) => Some(i),
            (Self::Rate(_), _) => None,
        }
    }
}

/// What the rate follows from, in words.
impl fmt::Display for Stamps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listed { spec, .. } => {
                write!(f, "{}, read in {},", spec.header, spec.unit.name)
            }
            Self::Rate(_) => f.write_str("the option rate_hz"),
        }
    }
}

/// The stamps that a clock was fitted to, and those it has no place for.
pub(super) struct Known {
    /// `None`: all in the file.
    pub own: Option<Vec<f64>>,
    pub repeats: Vec<usize>,
}
