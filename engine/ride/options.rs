//! What the user may say about a ride file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::error::Problem;
use super::rates::{RATES, RATES_HZ};

/// How to read a ride file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// Channel name to column: a header text or a number counted from 1.
    pub map: BTreeMap<String, String>,
    /// Sampling rate of a file without a time column (Hz).
    pub rate_hz: Option<f64>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Vec<usize>>, min_items = 2, max_items = 2))]
    pub rows: Option<(usize, usize)>,
    /// +1: d is the deflection u - z; -1: d is a sensor's distance to the road, -(u - z).
    pub deflection_sign: f64,
    /// Band (Hz) that z and u are kept in where z is made from acceleration; by default from
    /// 0.5 Hz to 0.45 of the slowest sensor's rate.
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2))]
    pub band_hz: Option<(f64, f64)>,
    #[serde(skip)]
    pub limits: Limits,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            map: BTreeMap::new(),
            rate_hz: None,
            rows: None,
            deflection_sign: 1.0,
            band_hz: None,
            limits: Limits::default(),
        }
    }
}

impl ReadOptions {
    pub(super) fn validate(&self) -> Result<(), Problem> {
        let bad = |name, value: String, expected| {
            Err(Problem::BadOption {
                name,
                value,
                expected,
            })
        };
        if let Some(rate) = self.rate_hz
            && !RATES_HZ.contains(&rate)
        {
            return bad("rate_hz", format!("{rate:?} Hz"), RATES);
        }
        if self.deflection_sign.abs() != 1.0 {
            let value = format!("{:?}", self.deflection_sign);
            return bad("deflection_sign", value, "1 or -1");
        }
        if let Some((low, high)) = self.band_hz
            && !(low >= 0.01 && low < high && high <= 1e6)
        {
            return bad(
                "band_hz",
                format!("{low:?} to {high:?}"),
                "0.01 Hz <= low < high",
            );
        }
        if let Some((from, to)) = self.rows
            && from >= to
        {
            return bad("rows", format!("{from}:{to}"), "FROM before TO");
        }
        Ok(())
    }
}

/// Sizes beyond which a file is refused. Set by the program, never by the file or its sender.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    pub bytes: u64,
    pub rows: usize,
    pub columns: usize,
    pub line_bytes: usize,
    /// Fewest samples on the common clock.
    pub least_samples: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            bytes: 2 << 30,
            rows: 20_000_000,
            columns: 512,
            line_bytes: 64 << 10,
            least_samples: 50,
        }
    }
}
