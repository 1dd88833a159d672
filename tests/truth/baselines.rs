//! What others would do with the same rides: three small methods, reported in the same table.
//!
//! All three see only the ride and bike files, choose from the same library of regressors and name effects by id and axle.
//! None of them can say `unnamed`.

pub mod best_of_k;
pub mod columns;
pub mod gram;
pub mod regress_bic;
pub mod signals;
pub mod stlsq;

use std::path::Path;

use rayon::prelude::*;

use crate::prove::outcome::{Name, Outcome};
use crate::refit::known::{self, KnownError};
use crate::refit::replay::Replay;
use signals::{Signals, couple, differentiated, simulated};

/// Each method's outcomes, in the order of `names`.
pub fn all(
    folder: &Path,
    names: &[String],
) -> Result<Vec<(&'static str, Vec<Outcome>)>, KnownError> {
    let rides: Vec<[Outcome; 3]> = names
        .par_iter()
        .map(|name| ride(folder, name))
        .collect::<Result<_, _>>()?;
    let column = |i: usize| rides.iter().map(|r| r[i].clone()).collect();
    Ok(vec![
        ("differentiate, regress, BIC", column(0)),
        ("SINDy (STLSQ)", column(1)),
        ("best of K, LR at 5 %", column(2)),
    ])
}

fn ride(folder: &Path, name: &str) -> Result<[Outcome; 3], KnownError> {
    let (log, bike) = known::open(folder, name)?;
    let mut measured = differentiated(&log, &bike);
    let replay = Replay::new(log, bike, known::PLAIN_STEP_S);
    let first = measured.each_ref().map(regress_bic::plain);
    couple(&mut measured, first);
    let model = simulated(&replay, first);
    Ok([
        outcome(&measured, regress_bic::choose),
        outcome(&measured, stlsq::choose),
        model.map_or_else(
            || Outcome::failed("no plain fit".to_owned(), 0.0),
            |m| outcome(&m, best_of_k::choose),
        ),
    ])
}

/// Names of both axles together; an effect on both axles is named once.
fn outcome(axles: &[Signals; 2], choose: impl Fn(&Signals) -> Vec<Name>) -> Outcome {
    let mut names: Vec<Name> = axles.iter().flat_map(choose).collect();
    names.sort();
    names.dedup();
    Outcome::named(names)
}
