use std::time::{Duration, Instant};

use serde::Serialize;

/// One measured quantity.
#[derive(Serialize)]
pub struct Figure {
    pub name: String,
    pub unit: &'static str,
    pub median: f64,
    pub best: f64,
    pub worst: f64,
    pub runs: usize,
}

impl Figure {
    /// Wall time, in milliseconds.
    pub fn time(name: impl Into<String>, times: &[Duration]) -> Self {
        let mut ms: Vec<f64> = times.iter().map(|t| t.as_secs_f64() * 1e3).collect();
        ms.sort_by(f64::total_cmp);
        Self::sorted(name, "ms", &ms)
    }

    /// `amount` of `unit` over each time.
    pub fn rate(
        name: impl Into<String>,
        unit: &'static str,
        amount: f64,
        times: &[Duration],
    ) -> Self {
        let mut rates: Vec<f64> = times.iter().map(|t| amount / t.as_secs_f64()).collect();
        rates.sort_by(|a, b| b.total_cmp(a));
        Self::sorted(name, unit, &rates)
    }

    fn sorted(name: impl Into<String>, unit: &'static str, from_best: &[f64]) -> Self {
        let at = |i: usize| from_best.get(i).copied().unwrap_or(f64::NAN);
        Self {
            name: name.into(),
            unit,
            median: at(from_best.len() / 2),
            best: at(0),
            worst: at(from_best.len().saturating_sub(1)),
            runs: from_best.len(),
        }
    }
}

/// Times `runs` repetitions after one that warms up.
pub fn timed<T, E>(
    runs: usize,
    mut work: impl FnMut() -> Result<T, E>,
) -> Result<Vec<Duration>, E> {
    work()?;
    (0..runs)
        .map(|_| {
            let begin = Instant::now();
            let result = work()?;
            let time = begin.elapsed();
            drop(result);
            Ok(time)
        })
        .collect()
}
