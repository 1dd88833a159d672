//! What others would do with the same rides: three small methods, reported in the same table.
//!
//! All three see only the ride and bike files, choose from the same library of regressors, validate on parts that they did not
//! fit, and name effects by id and axle. None of them can say `unnamed`.

pub mod best_of_k;
pub mod columns;
pub mod cross;
pub mod design;
pub mod gram;
pub mod regress;
pub mod signals;
pub mod stlsq;

use std::path::Path;

use rayon::prelude::*;

use crate::outcome::{Name, Outcome};
use crate::refit::known::{self, KnownError};
use crate::refit::replay::Replay;
use cross::Validated;
use design::Design;
use signals::{WIDTHS, couple, differentiated, simulated};

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
        ("differentiate, regress, cross-validated", column(0)),
        ("SINDy, cross-validated", column(1)),
        ("best of K, confirmed on the held-out part", column(2)),
    ])
}

fn ride(folder: &Path, name: &str) -> Result<[Outcome; 3], KnownError> {
    let (log, bike) = known::open(folder, name)?;
    let mut first = [(1e5, 300.0); 2];
    let widths = WIDTHS.map(|half| {
        let mut measured = differentiated(&log, &bike, half);
        first = measured.each_ref().map(design::plain);
        couple(&mut measured, first);
        measured.map(|s| Design::measured(&s))
    });
    let replay = Replay::new(log, bike, known::PLAIN_STEP_S);
    let model = simulated(&replay, first);
    Ok([
        outcome([0, 1].map(|axle| over_widths(&widths, axle, regress::choose))),
        outcome([0, 1].map(|axle| over_widths(&widths, axle, stlsq::choose))),
        model.map_or_else(
            || Outcome::failed("no plain fit".to_owned(), 0.0),
            |m| outcome(m.each_ref().map(best_of_k::choose)),
        ),
    ])
}

/// What a method names with the differentiator that validates best.
fn over_widths(
    widths: &[[Design; 2]],
    axle: usize,
    choose: impl Fn(&Design) -> Option<Validated>,
) -> Vec<Name> {
    let designs = widths.iter().map(|axles| &axles[axle]);
    let chosen = designs.filter_map(|design| Some((design, choose(design)?)));
    let best = chosen.min_by(|a, b| a.1.error.total_cmp(&b.1.error));
    best.map_or(Vec::new(), |(design, found)| design.names(&found.model))
}

/// Names of both axles together; an effect on both axles is named once.
fn outcome(axles: [Vec<Name>; 2]) -> Outcome {
    let mut names = axles.concat();
    names.sort();
    names.dedup();
    Outcome::named(names)
}
