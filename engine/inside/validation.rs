//! The report's `validation` section.

use serde::Serialize;

use veloid_core::document::{NotFinite, checked};
use veloid_report::validation::Validation;

use crate::record::{Models, Record};
use crate::residual::residual_tests;
use crate::response::response;
use crate::restoring::restoring;

/// How an axle's models stand beside its record.
pub fn validation(record: &Record, models: &Models) -> Validation {
    let mut why = Vec::new();
    Validation {
        residual: kept("residual", residual_tests(record, models), &mut why),
        response: kept("response", response(record, models), &mut why),
        restoring: kept("restoring", restoring(record, models), &mut why),
        why,
    }
}

/// Nothing, for a reason.
pub fn without_validation(why: &str) -> Validation {
    Validation {
        why: vec![why.to_owned()],
        ..Validation::default()
    }
}

/// What was found, if all of it are numbers: a model that runs away has others.
fn kept<T: Serialize>(
    part: &'static str,
    found: Result<T, String>,
    why: &mut Vec<String>,
) -> Option<T> {
    let finite = |found| checked(part, found).map_err(|error: NotFinite| error.to_string());
    found
        .and_then(finite)
        .map_err(|reason| why.push(reason))
        .ok()
}
